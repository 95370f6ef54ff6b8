"""From a glTF animation to a clip: weights by shape name, and where the joints go."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from mien.core import Clip, FileError, InputError, Note, Skeleton
from mien.core.arrays import Floats
from mien.core.clip import checked_fps
from mien.core.errors import unknown
from mien.io.gltf.container import Document, open_document
from mien.io.gltf.fields import Fields
from mien.io.gltf.meshes import numbered, shape_names
from mien.io.gltf.rig import Character, character
from mien.io.gltf.scene import Scene, rest_parts
from mien.io.gltf.skinning import STILL
from mien.io.gltf.tracks import JITTER, Track, frame_rate, read_track, rounding
from mien.io.gltf.transforms import composed

KINDS = {"translation": ("VEC3", 3), "rotation": ("VEC4", 4), "scale": ("VEC3", 3)}

MOST_VALUES = 1 << 27
"""The most numbers a sampled clip may hold (1 GiB): a damaged key time can ask for years of frames."""

AGREE = 1e-4
"""Meshes whose weights for the same shape differ by no more than this say the same."""


@dataclass
class Tracks:
    """The curves of one animation.

    Attributes:
        weights: per node the curve of its mesh's weights.
        motion: per node the curves of `translation`, `rotation`, `scale`.
        notes: what was left out.
    """

    weights: dict[int, Track] = field(default_factory=dict)
    motion: dict[int, dict[str, Track]] = field(default_factory=dict)
    notes: list[Note] = field(default_factory=list)

    @property
    def all(self) -> list[Track]:
        """Every curve."""
        return [*self.weights.values(), *(track for parts in self.motion.values() for track in parts.values())]


def read_clip(path: Path, animation: str | int | None = None, fps: float | None = None) -> Clip:
    """Read one animation of a .glb or .gltf file, sampled at even times.

    Args:
        path: the file.
        animation: its name or number; the first if None.
        fps: the wanted frame rate; that of the keys if None.

    Returns:
        A clip whose channels are the shapes of `read_rig`, in the same order, and whose
        joints are those of its skeleton, if it has one.

    Raises:
        FileError: the file is damaged, holds no such animation, or none that moves the character.
        InputError: `fps` is not a positive number.
        MissingPackage: it is compressed with Draco, and DracoPy is not installed.
    """
    document = open_document(path)
    found = character(document)
    with np.errstate(all="ignore"):  # what overflows is found by the clip's check for finite numbers
        tracks = _tracks(document, _chosen(document, animation), found.scene)
        if not tracks.all:
            raise FileError(f"{path}: the animation moves no shape and no node of the character; choose another one.")
        rate = frame_rate(tracks.all) if fps is None else checked_fps(fps)
        times = _times(path, tracks, rate, len(found.rig.blendshapes) + 16 * len(found.joint_nodes))
        notes = [*found.rig.notes, *tracks.notes]
        values = _weights(document, found, tracks, times, rate, notes)
        joints = None if found.rig.skeleton is None else _joints(found, tracks, times, rate)
        try:
            return Clip(
                found.rig.blendshapes.names, values, rate, joints=joints, start=float(times[0]), notes=tuple(notes)
            )
        except InputError as error:
            raise FileError(f"{path}: {error}") from None


def _chosen(document: Document, wanted: str | int | None) -> Fields:
    animations = document.top.each("animations")
    if not animations:
        raise FileError(f"{document.path} holds no animation; export the character with its animation.")
    if wanted is None:
        return animations[0]
    if isinstance(wanted, int):
        if not 0 <= wanted < len(animations):
            raise FileError(f"{document.path} holds the animations 0 … {len(animations) - 1}, but not {wanted}.")
        return animations[wanted]
    names = [animation.text("name") for animation in animations]
    if wanted not in names:
        raise FileError(f"{document.path}: {unknown('animation', wanted, names)}")
    return animations[names.index(wanted)]


def _tracks(document: Document, animation: Fields, scene: Scene) -> Tracks:
    """Return the curves that reach the nodes of the default scene."""
    tracks = Tracks()
    samplers = animation.each("samplers")
    for channel in animation.each("channels"):
        target, index = channel.inner("target"), channel.integer("sampler")
        path = target.text("path")
        if index >= len(samplers):
            raise channel.error(f"refers to sampler {index}, which does not exist")
        if path == "pointer":
            tracks.notes.append(Note("animation-pointer", "KHR_animation_pointer is not read", channel.where))
        if "node" not in target or path not in {*KINDS, "weights"}:
            continue
        node = target.integer("node")
        if node >= len(scene.nodes):
            raise channel.error(f"animates nodes[{node}], which does not exist")
        if path == "weights":
            count = len(_names(document, scene.nodes[node]))
            if count and node in scene.shown:
                tracks.weights.setdefault(node, read_track(document, samplers[index], "SCALAR", count))
        else:
            tracks.motion.setdefault(node, {})[path] = read_track(document, samplers[index], *KINDS[path])
    return tracks


def _names(document: Document, node: Fields) -> list[str]:
    return shape_names(document.at("meshes", node.integer("mesh"), node))[0] if "mesh" in node else []


def _times(path: Path, tracks: Tracks, fps: float, width: int) -> Floats:
    width += sum(track.values.shape[1] for track in tracks.all)
    first = min(float(track.times[0]) for track in tracks.all)
    last = max(float(track.times[-1]) for track in tracks.all)
    frames = (last - first + rounding(np.array([last]))) * fps + 1 + JITTER
    if not frames * width < MOST_VALUES:
        raise FileError(f"{path}: an animation of {last - first:g} s is too long to sample {fps:g} times a second.")
    return first + np.arange(int(frames)) / fps


def _weights(
    document: Document, found: Character, tracks: Tracks, times: Floats, fps: float, notes: list[Note]
) -> Floats:
    """Return `(F, K)` weights: of several meshes with the same shape, the first one's."""
    place = {name: k for k, name in enumerate(found.rig.blendshapes.names)}
    values = np.zeros((len(times), len(place)))
    settled: set[str] = set()
    for node, name, curve in _curves(document, found.scene, tracks, times, fps):
        if name not in place:
            continue
        if name not in settled:
            settled.add(name)
            values[:, place[name]] = curve
        elif node in tracks.weights and np.abs(values[:, place[name]] - curve).max() > AGREE:
            where = found.scene.name(node)
            notes.append(Note("weights-disagree", f"{name!r} plays differently there; the first mesh is taken", where))
    return values


def _curves(
    document: Document, scene: Scene, tracks: Tracks, times: Floats, fps: float
) -> Iterator[tuple[int, str, Floats]]:
    """Yield every shape of every mesh node with its weight over time, the animated nodes first."""
    for node in sorted(scene.mesh_nodes, key=lambda node: node not in tracks.weights):
        names = _names(document, scene.nodes[node])
        if node in tracks.weights:
            curves = tracks.weights[node].at(times, fps)
        else:
            still = _default_weights(document, scene.nodes[node], len(names))
            curves = np.broadcast_to(still, (len(times), len(names)))
        for name, curve in zip(names, curves.T, strict=True):
            yield node, name, curve


def _default_weights(document: Document, node: Fields, count: int) -> Floats:
    mesh = document.at("meshes", node.integer("mesh"), node)
    stored = node.numbers("weights") or mesh.numbers("weights") or []
    return np.array((stored + [0.0] * count)[:count])


def _joints(found: Character, tracks: Tracks, times: Floats, fps: float) -> Floats:
    """Return the world matrices `(F, J, 4, 4)` of the skeleton's joints."""
    local = {node: _local(found.scene.nodes[node], parts, times, fps) for node, parts in tracks.motion.items()}
    world = found.scene.moved(local, set(found.joint_nodes) - {STILL})
    joints = np.empty((len(times), len(found.joint_nodes), 4, 4))
    for j, node in enumerate(found.joint_nodes):
        joints[:, j] = np.eye(4) if node == STILL else world[node]
    return joints


def _local(node: Fields, parts: dict[str, Track], times: Floats, fps: float) -> Floats:
    rest = dict(zip(KINDS, rest_parts(node), strict=True))
    moved = {path: parts[path].at(times, fps) if path in parts else rest[path] for path in KINDS}
    return np.broadcast_to(composed(moved["translation"], moved["rotation"], moved["scale"]), (len(times), 4, 4))


def read_poses(path: Path) -> tuple[Skeleton, dict[str, Floats]]:
    """Read each animation that moves joints as one pose: how it ends.

    Returns:
        The file's skeleton, and `(J, 4, 4)` world matrices of its joints by the animation's name.

    Raises:
        FileError: the file is damaged, or holds no joints or no animation that moves one.
    """
    document = open_document(path)
    found = character(document)
    if found.rig.skeleton is None:
        raise FileError(f"{path} has no joints, so it holds no poses of any; export the skeleton with its animations.")
    poses: dict[str, Floats] = {}
    for animation in document.top.each("animations"):
        tracks = _tracks(document, animation, found.scene)
        if tracks.motion:
            end = np.array([max(float(track.times[-1]) for track in tracks.all)])
            poses[numbered([*poses, animation.text("name") or "pose"])[-1]] = _joints(found, tracks, end, 1.0)[0]
    if not poses:
        raise FileError(f"{path} holds no animation that moves a joint; export one animation for each pose.")
    return found.rig.skeleton, poses
