"""The main job: a performance and a character in, the character animated out."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from mien.capture import fill_gaps
from mien.core import Clip, InputError, Markers
from mien.core.arrays import Floats
from mien.job.bones import with_joints
from mien.job.labelled import with_bones
from mien.job.learn import learn
from mien.job.performance import Performance
from mien.job.request import Fitted, Request, Result
from mien.job.stages import Progress, Stage, stopwatch
from mien.retargeting.copying import held


def run(request: Request, progress: Progress = lambda stage: None) -> Result:
    """Do the main job: fit, and map the performance.

    Args:
        request: what is asked for.
        progress: called with the name of each stage as it begins.

    Raises:
        MienError: anything about the files or the values in them.
    """
    timing: dict[str, float] = {}
    stage = stopwatch(timing, progress)
    fitted, performance = learn(request, stage)
    return play(fitted, performance, stage, timing, head=request.head)


def fit(request: Request, progress: Progress = lambda stage: None) -> Fitted:
    """Fit only; the performance of the request is the training take if none is given.

    Raises:
        MienError: anything about the files or the values in them.
    """
    return learn(request, stopwatch({}, progress))[0]


def play(
    fitted: Fitted, performance: Performance, stage: Stage, timing: dict[str, float], *, head: bool = True
) -> Result:
    """Map a performance with a fitted method."""
    retargeter, character = fitted.retargeter, fitted.character
    with stage("solve"):
        frames = frames_of(fitted, performance)
        clip, report = retargeter.retarget(frames)
    clip = _with_head(clip, performance, retargeter, head)
    clip = with_bones(clip, character) if fitted.bones is None else with_joints(clip, fitted.bones)
    filled = frames if isinstance(frames, Markers) else None
    gaps = filled.notes if filled is not None else ()
    known = character.notes if character is not None else ()
    notes = tuple(dict.fromkeys((*known, *gaps, *fitted.notes, *report.notes)))
    return Result(
        clip, replace(report, notes=notes, timing_s=timing), character, performance, fitted.pairs, filled, retargeter
    )


def frames_of(fitted: Fitted, performance: Performance) -> Markers | Clip:
    """Return a performance as the fitted method reads it.

    Raises:
        InputError: it is of another kind than the training take.
    """
    wanted = getattr(fitted.retargeter, "markers", None)
    if wanted is None:
        if performance.clip is None:
            raise InputError(f"this method maps weights to weights, but {performance.path} holds markers.")
        return performance.clip
    if fitted.pairs is None and performance.markers is None:
        raise InputError(f"this method was fitted to markers, but {performance.path} holds none; give the same kind.")
    points = performance.markers if fitted.pairs is None else performance.points(fitted.pairs)
    assert points is not None
    return fill_gaps(points.only(wanted))


def _with_head(clip: Clip, performance: Performance, retargeter: Any, wanted: bool) -> Clip:
    """Keep the head's motion where it was found, take it from the weights' file, or leave it out."""
    recorded, placement = performance.clip, getattr(retargeter, "placement", None)
    head: Floats | None = clip.head
    if not wanted:
        head = None
    elif head is None and placement is not None and recorded is not None and recorded.head is not None:
        head = placement.conjugate(held(recorded.head.reshape(len(recorded), -1))[0].reshape(-1, 4, 4))
    eyes = recorded.eyes if recorded is not None else None
    return replace(clip, head=head, eyes=eyes, start=recorded.start if recorded is not None else 0.0)
