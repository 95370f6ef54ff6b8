"""The main job: a performance and a character in, the character animated out."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from mien.core import Clip, Correspondence, InputError, Markers, Note, Report, Rig
from mien.core.arrays import Floats
from mien.io.documents import read_examples
from mien.io.formats import read_rig
from mien.job.pairs import DEFAULT_COUNT, find_pairs
from mien.job.performance import Performance, check_same_mesh, load_performance
from mien.retargeting import METHODS, make_method, parameters
from mien.retargeting.copying import held

Progress = Callable[[str], None]


@dataclass(frozen=True)
class Request:
    """What is asked for, in file names.

    Attributes:
        performance, character: the two sides.
        method: a key of `METHODS`.
        actor: the rig that weights play on.
        training: the range-of-motion take; the performance itself if None.
        neutral: frame number or file of the actor's neutral; found if None.
        pairs, landmarks: what corresponds.
        count: pairs to make from landmarks.
        examples: labelled frames of the training take.
        rigid: markers that ride on the skull.
        head: whether head motion goes to the character.
        settings: the method's parameters.
    """

    performance: Path
    character: Path
    method: str = "range-of-motion"
    actor: Path | None = None
    training: Path | None = None
    neutral: str | None = None
    pairs: Path | None = None
    landmarks: tuple[Path, Path] | None = None
    count: int = DEFAULT_COUNT
    examples: Path | None = None
    rigid: tuple[str, ...] = ()
    head: bool = True
    settings: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Result:
    """What came out.

    Attributes:
        clip: the character's animation.
        report: the account of it.
        character: the rig it plays on.
        performance: the actor's side.
        pairs: the correspondence used, if any.
        markers: the performance at the paired points, if it has points.
        retargeter: the fitted method.
    """

    clip: Clip
    report: Report
    character: Rig
    performance: Performance
    pairs: Correspondence | None
    markers: Markers | None
    retargeter: Any


def run(request: Request, progress: Progress = lambda stage: None) -> Result:
    """Do the main job.

    Args:
        request: what is asked for.
        progress: called with the name of each stage as it begins.

    Raises:
        MienError: anything about the files or the values in them.
    """
    timing: dict[str, float] = {}
    stage = _stopwatch(timing, progress)
    with stage("read"):
        character = read_rig(request.character)
        performance = load_performance(request.performance, request.actor)
        training = performance if request.training is None else load_performance(request.training, request.actor)
        examples = read_examples(request.examples) if request.examples else None
    _check_training(performance, training)
    if request.method == "copy" or (performance.clip is not None and performance.actor is None):
        return _copied(request, performance, character, timing)
    with stage("pair"):
        pairs, notes = find_pairs(
            training,
            character,
            pairs=request.pairs,
            landmarks=request.landmarks,
            count=request.count,
            neutral=request.neutral,
        )
        take, markers = training.points(pairs), performance.points(pairs)
        take.index(request.rigid)
    with stage("fit"):
        settings, remarks = _settings(request)
        retargeter: Any = make_method(request.method, settings).fit(
            character,
            take,
            pairs,
            neutral=training.neutral(pairs, request.neutral),
            rigid=request.rigid,
            head_moves=performance.head_moves,
            examples=examples,
        )
    with stage("solve"):
        from mien.capture import fill_gaps

        filled = fill_gaps(markers.only(retargeter.markers))
        clip, report = retargeter.retarget(filled)
    clip = _with_head(clip, performance, retargeter, request.head)
    report = replace(
        report, notes=_distinct((*character.notes, *filled.notes, *notes, *remarks, *report.notes)), timing_s=timing
    )
    return Result(clip, report, character, performance, pairs, filled, retargeter)


def _settings(request: Request) -> tuple[dict[str, Any], tuple[Note, ...]]:
    """Take only a take that was given as training at its word that it shows the actor's full range."""
    known = parameters(METHODS[request.method]()) if request.method in METHODS else {}
    if request.training is not None or "full_range" not in known or "full_range" in request.settings:
        return request.settings, ()
    text = (
        "no training take was given (--training), so strength is as performed. Give a take in which the actor goes to "
        "the full range, or say that this one does with --set full_range=true, and full becomes full on the character."
    )
    return {**request.settings, "full_range": False}, (Note("range-as-performed", text),)


def _check_training(performance: Performance, training: Performance) -> None:
    """Refuse a training take that says nothing about the performance.

    Raises:
        InputError: one is markers and the other a mesh, or they are different meshes.
    """
    if (performance.markers is None) != (training.markers is None):
        kinds = ("markers", "an animated face or weights")
        mine, other = kinds if performance.markers is not None else kinds[::-1]
        raise InputError(
            f"the performance {performance.path} is {mine}, but the training take {training.path} is {other}; "
            "both must have been captured the same way."
        )
    if training.actor is not None and performance.actor is not None:
        check_same_mesh(performance.actor, training.actor, training.path)


def _copied(request: Request, performance: Performance, character: Rig, timing: dict[str, float]) -> Result:
    if request.method not in ("copy", "range-of-motion"):
        raise InputError(
            f"the method {request.method!r} needs points in space, but {request.performance} holds weights; give --actor."
        )
    if performance.clip is None:
        raise InputError(
            f"the method 'copy' maps weights to weights, but {request.performance} holds markers; use range-of-motion."
        )
    copier = METHODS["copy"]().fit(character, performance.clip)
    clip, report = copier.retarget(performance.clip)
    notes = report.notes
    if request.method != "copy":
        text = (
            "no actor's rig was given (--actor), so weights were copied by name; intensities are the performance's own."
        )
        notes = (Note("copied-by-name", text, str(request.performance)), *notes)
    if not request.head:
        clip = replace(clip, head=None)
    report = replace(report, notes=_distinct((*character.notes, *notes)), timing_s=timing)
    return Result(clip, report, character, performance, None, None, copier)


def _with_head(clip: Clip, performance: Performance, retargeter: Any, wanted: bool) -> Clip:
    """Keep the head's motion where it was found, take it from the weights' file, or leave it out."""
    recorded = performance.clip
    head: Floats | None = clip.head
    if not wanted:
        head = None
    elif head is None and recorded is not None and recorded.head is not None:
        head = retargeter.placement.conjugate(held(recorded.head.reshape(len(recorded), -1))[0].reshape(-1, 4, 4))
    eyes = recorded.eyes if recorded is not None else None
    return replace(clip, head=head, eyes=eyes, start=recorded.start if recorded is not None else 0.0)


def _distinct(notes: Sequence[Note]) -> tuple[Note, ...]:
    return tuple(dict.fromkeys(notes))


def _stopwatch(timing: dict[str, float], progress: Progress) -> Callable[[str], Any]:
    @contextmanager
    def stage(name: str) -> Iterator[None]:
        progress(name)
        begin = time.perf_counter()
        yield
        timing[name] = round(time.perf_counter() - begin, 4)

    return stage
