"""Films of a performance, as H.264 in MP4, which every player and browser shows."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path

import numpy as np

from mien.core import Clip, FileError, InputError, MissingPackage, Rig
from mien.core.arrays import Floats, Ints
from mien.core.clip import checked_fps
from mien.io.files import written_whole
from mien.look.camera import Camera, View
from mien.look.portrait import Portrait, frame_clip, weights_for
from mien.look.raster import Picture

Progress = Callable[[int, int], None]

FASTEST = 30.0
"""Frames per second a film has unless more are asked for."""


def write_movie(path: Path, frames: Iterable[Picture], fps: float) -> None:
    """Write pictures of one size as an MP4 film; an odd width or height loses its last column or row.

    Raises:
        FileError: it cannot be written, or the name does not end in .mp4.
        InputError: there is no frame, or the frames differ in size.
        MissingPackage: imageio-ffmpeg is not installed.
    """
    fps = checked_fps(fps)
    if path.suffix.lower() != ".mp4":
        raise FileError(f"cannot write {path}: films are written as .mp4; change the name.")
    with written_whole(path) as temporary:
        _encode(temporary, path, iter(frames), fps)


def render_clip(
    path: Path,
    rig: Rig,
    clip: Clip,
    *,
    view: View = "front",
    size: tuple[int, int] = (640, 640),
    fps: float | None = None,
    camera: Camera | None = None,
    progress: Progress | None = None,
) -> None:
    """Film a rig playing a clip, the camera still and the head moving.

    A frame that was not tracked holds the last pose and is shown in grey.

    Args:
        path: the .mp4 file.
        rig: who plays it.
        clip: the animation, in the rig's shapes.
        view: from where.
        size: width and height [pixels], even.
        fps: frames per second of the film; the clip's own, at most 30, if None.
        camera: where to film from instead of framing the face over the clip.
        progress: called with frames done and frames in all.

    Raises:
        FileError: the film cannot be written.
        InputError: the clip is empty or none of its channels is a shape of the rig.
        MissingPackage: imageio-ffmpeg is not installed.
    """
    if not len(clip):
        raise InputError("the clip has no frames to film.")
    weights = weights_for(rig, clip)
    rate = min(clip.fps, FASTEST) if fps is None else checked_fps(fps)
    frames = sampled(len(clip), clip.fps, rate)
    eye = camera or frame_clip(rig, clip, view, aspect=size[0] / size[1], frames=frames)
    sitter = Portrait.of(rig, view, size=size, camera=eye)
    write_movie(path, _pictures(sitter, clip, weights, frames, progress), rate)


def sampled(count: int, fps: float, wanted: float) -> Ints:
    """Return the frame shown at each moment when `count` frames at `fps` are played at `wanted` fps."""
    moments = np.arange(max(1, round(count * wanted / fps)))
    return np.minimum(np.round(moments * fps / wanted).astype(np.int64), count - 1)


def _pictures(
    sitter: Portrait, clip: Clip, weights: Floats, frames: Ints, progress: Progress | None
) -> Iterator[Picture]:
    tracked = np.asarray(np.isfinite(weights).all(axis=1))
    held = np.maximum.accumulate(np.where(tracked, np.arange(len(tracked)), -1))

    def picture(frame: int) -> Picture:
        pose = weights[held[frame]] if held[frame] >= 0 else None
        head = None if clip.head is None else clip.head[frame]
        joints = None if clip.joints is None else clip.joints[frame]
        made = sitter.picture(pose, head=head, joints=joints, edges="quick")
        return made if tracked[frame] else _grey(made)

    for done, made in enumerate(_made_ahead(picture, frames.tolist())):
        yield made
        if progress is not None:
            progress(done + 1, len(frames))


def _made_ahead(picture: Callable[[int], Picture], frames: Iterable[int]) -> Iterator[Picture]:
    """Yield the pictures in order, made on all cores, and only a few more than were asked for."""
    workers = os.cpu_count() or 1
    waiting: deque[Future[Picture]] = deque()
    with ThreadPoolExecutor(workers) as pool:
        try:
            for frame in frames:
                waiting.append(pool.submit(picture, frame))
                if len(waiting) > 2 * workers:
                    yield waiting.popleft().result()
            while waiting:
                yield waiting.popleft().result()
        finally:
            pool.shutdown(wait=False, cancel_futures=True)


def _grey(picture: Picture) -> Picture:
    level = (picture.astype(np.float64) @ [0.2126, 0.7152, 0.0722]).astype(np.uint8)
    return np.repeat(level[..., None], 3, axis=2)


def _encode(temporary: Path, path: Path, frames: Iterator[Picture], fps: float) -> None:
    try:
        import imageio_ffmpeg
    except ImportError:
        raise MissingPackage("a film", "imageio-ffmpeg", "look") from None
    first = next(frames, None)
    if first is None:
        raise InputError(f"there are no frames to write to {path}.")
    height, width = (n - n % 2 for n in first.shape[:2])
    if not (height and width):
        raise InputError(
            f"a film needs frames of at least 2 × 2 pixels; these are {first.shape[1]} × {first.shape[0]}."
        )
    film = imageio_ffmpeg.write_frames(
        str(temporary),
        (width, height),
        fps=fps,
        codec="libx264",
        pix_fmt_out="yuv420p",
        quality=None,
        macro_block_size=2,
        output_params=["-crf", "18", "-preset", "veryfast", "-movflags", "+faststart"],
    )
    film.send(None)
    try:
        for number, frame in enumerate(_with(first, frames)):
            if frame.shape != first.shape:
                raise InputError(
                    f"frame {number} of the film is {frame.shape}, the first {first.shape}; all must agree."
                )
            film.send(np.ascontiguousarray(frame[:height, :width]))
    except OSError as error:
        raise FileError(f"{path} could not be encoded: {str(error).strip().splitlines()[0]}") from None
    finally:
        film.close()
    if temporary.stat().st_size == 0:
        raise FileError(f"{path} could not be encoded: the encoder wrote nothing; is the disk full?")


def _with(first: Picture, rest: Iterator[Picture]) -> Iterator[Picture]:
    yield first
    yield from rest
