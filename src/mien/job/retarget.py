"""The main job: a performance and a character in, the character animated out."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from mien.capture import fill_gaps
from mien.core import Clip, Correspondence, Examples, InputError, Markers, Note, Report, Rig
from mien.core.arrays import Floats
from mien.geometry.bones import Bones
from mien.io.correctives import read_correctives
from mien.io.documents import read_examples
from mien.io.formats import read_rig
from mien.job.bones import Driven, driven, with_joints
from mien.job.choose import chosen
from mien.job.labelled import check_parameters, read_target, source_of, with_bones
from mien.job.layers import actor_extremes, rest_of
from mien.job.pairs import DEFAULT_COUNT, OWN, find_pairs, rig_landmarks
from mien.job.performance import Performance, check_same_mesh, load_performance
from mien.retargeting import METHODS, make_method, parameters
from mien.retargeting.copying import held
from mien.retargeting.layers import Layers

Progress = Callable[[str], None]
Stage = Callable[[str], AbstractContextManager[None]]


@dataclass(frozen=True)
class Request:
    """What is asked for, in file names.

    Attributes:
        performance, character: the two sides.
        method: a key of `METHODS`, or `auto`.
        actor: the rig that weights play on.
        training: the range-of-motion take; the performance itself if None.
        neutral: frame number or file of the actor's neutral; found if None.
        pairs, landmarks: what corresponds.
        count: pairs to make from landmarks.
        examples: labelled frames of the training take.
        animations: existing animation of the character, for methods that learn from poses that nobody acted.
        extremes: for layers, which frame of the training take shows which extreme.
        rigid: markers that ride on the skull.
        head: whether head motion goes to the character.
        settings: the method's parameters.
        correctives: which of the character's shapes follow from others.
        targets: whether the character's `shapes` or its `bones` are driven; what it has if None.
        poses: named poses of its bones.
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
    extremes: Path | None = None
    animations: tuple[Path, ...] = ()
    correctives: Path | None = None
    targets: str | None = None
    poses: Path | None = None


@dataclass(frozen=True, eq=False)
class Result:
    """What came out.

    Attributes:
        clip: the character's animation.
        report: the account of it.
        character: the rig it plays on; None if it is parameters alone.
        performance: the actor's side.
        pairs: the correspondence used, if any.
        markers: the performance at the paired points, if it has points.
        retargeter: the fitted method.
    """

    clip: Clip
    report: Report
    character: Rig | None
    performance: Performance
    pairs: Correspondence | None
    markers: Markers | None
    retargeter: Any


@dataclass(frozen=True, eq=False)
class Fitted:
    """A method fitted to an actor and a character, and what mapping another take needs besides.

    Attributes:
        retargeter: the fitted method.
        character: the rig it is for; None if it is parameters alone.
        pairs: the correspondence, or None for methods without points.
        notes: what pairing had to say.
        bones: what the parameters do to the character's joints, if its bones are driven.
    """

    retargeter: Any
    character: Rig | None
    pairs: Correspondence | None
    notes: tuple[Note, ...] = ()
    bones: Bones | None = None


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


def learn(request: Request, stage: Stage) -> tuple[Fitted, Performance]:
    """Fit the method of a request to the training take, or to the performance if there is none."""
    settled, why = chosen(request)
    fitted, performance = _learn(settled, stage)
    return replace(fitted, notes=(*why, *fitted.notes)), performance


def _learn(request: Request, stage: Stage) -> tuple[Fitted, Performance]:
    _check_correctives(request)
    if learns_from_labels(request.method):
        _check_no_targets(request)
        return _labelled(request, stage)
    if request.animations:
        raise InputError(f"the method {request.method!r} does not learn from existing animation; use --method latent.")
    with stage("read"):
        character = _with_correctives(read_rig(request.character), request.correctives)
        moved = driven(character, request.targets, request.poses)
        performance = load_performance(request.performance, request.actor)
        training = performance if request.training is None else load_performance(request.training, request.actor)
        examples = read_examples(request.examples) if request.examples else None
    _check_training(performance, training)
    if request.method == "copy" or (performance.clip is not None and performance.actor is None):
        return _moving(_copier(request, performance, moved.shown), moved), performance
    if request.method == Layers.name:
        own = actor_extremes(training, moved.shown, request.extremes, request.landmarks, request.count)
        if own is not None:
            return _moving(_layered(request, stage, own, training, moved.shown), moved), performance
    with stage("pair"):
        pairs, notes = find_pairs(
            training,
            character,
            pairs=request.pairs,
            landmarks=request.landmarks,
            count=request.count,
            neutral=request.neutral,
        )
        take = training.points(pairs)
        take.index(request.rigid)
        moved = moved.paired(pairs)
    with stage("fit"):
        settings, remarks = _settings(request)
        known = parameters(METHODS[request.method]()) if request.method in METHODS else {}
        retargeter = make_method(request.method, moved.settings(settings, known)).fit(
            _with_landmarks(moved.shown, request),
            take,
            pairs,
            neutral=training.neutral(pairs, request.neutral),
            rigid=request.rigid,
            head_moves=training.head_moves,
            examples=examples,
        )
    fitted = Fitted(moved.solved(retargeter, pairs), character, pairs, (*notes, *remarks))
    return _moving(fitted, moved), performance


def _moving(fitted: Fitted, moved: Driven) -> Fitted:
    """Return a method fitted to shapes that stand for bones as one for the character that has the bones."""
    return replace(fitted, character=moved.rig, bones=moved.bones)


def _check_correctives(request: Request) -> None:
    """Refuse correctives for a method that does not solve for weights.

    Raises:
        InputError: the method has no solve that they could be part of.
    """
    known = parameters(METHODS[request.method]()) if request.method in METHODS else {"prior_kind": None}
    if request.correctives is not None and "prior_kind" not in known:
        raise InputError(
            f"the method {request.method!r} does not solve for weights frame by frame, so it cannot take correctives; "
            "use range-of-motion, rbf or direct, or leave --correctives out."
        )


def _with_landmarks(character: Rig, request: Request) -> Rig:
    """Give a character the landmarks beside its file, if contact is asked for, which needs them."""
    if "contact" not in request.settings:
        return character
    given = request.landmarks[1] if request.landmarks is not None and request.landmarks[1] != OWN else None
    return replace(character, landmarks=rig_landmarks(character, given))


def _check_no_targets(request: Request) -> None:
    """Refuse targets where the labels say what is driven.

    Raises:
        InputError: there are some.
    """
    if request.targets is not None or request.poses is not None:
        raise InputError(
            f"the method {request.method!r} drives what its labels name, bones as joint.rx and so on; leave --targets and "
            "--poses out."
        )


def _with_correctives(character: Rig, path: Path | None) -> Rig:
    if path is None:
        return character
    return replace(character, correctives=read_correctives(path, character.blendshapes.names))


def learns_from_labels(method: str) -> bool:
    """Return whether a method learns from labelled frames."""
    return getattr(METHODS.get(method), "by_example", False)


def _labelled(request: Request, stage: Stage) -> tuple[Fitted, Performance]:
    """Fit a method that learns from labelled frames."""
    with stage("read"):
        target = read_target(request.character, request.examples, request.animations)
        performance = load_performance(request.performance, request.actor)
        training = performance if request.training is None else load_performance(request.training, request.actor)
        examples = read_examples(request.examples) if request.examples else None
    _check_training(performance, training)
    check_parameters(examples, target.rig)
    with stage("pair"):
        source = source_of(
            training,
            target.rig,
            pairs=request.pairs,
            landmarks=request.landmarks,
            count=request.count,
            neutral=request.neutral,
        )
    with stage("fit"):
        own = {"animations": target.animations} if target.animations else {}
        retargeter = make_method(request.method, {**request.settings, **own}).fit(
            target.rig,  # type: ignore[arg-type]  # these methods do without a mesh
            source.take,
            source.pairs,
            neutral=source.neutral,
            rigid=request.rigid,
            head_moves=training.head_moves,
            examples=examples,
        )
    return Fitted(retargeter, target.rig, source.points), performance


def _layered(
    request: Request,
    stage: Stage,
    own: tuple[Markers, Examples, Correspondence | None],
    training: Performance,
    character: Rig,
) -> Fitted:
    """Fit the layers method to an actor with extremes of its own, which no pair ties to the character."""
    take, extremes, points = own
    with stage("fit"):
        retargeter = make_method(request.method, request.settings).fit(
            character,
            take,
            neutral=rest_of(training, points, request.neutral),
            rigid=request.rigid,
            head_moves=training.head_moves,
            examples=extremes,
        )
    return Fitted(retargeter, character, points)


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
    notes = _distinct((*known, *gaps, *fitted.notes, *report.notes))
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


def _copier(request: Request, performance: Performance, character: Rig) -> Fitted:
    if request.method not in ("copy", "range-of-motion"):
        raise InputError(
            f"the method {request.method!r} needs points in space, but {request.performance} holds weights; give --actor."
        )
    if performance.clip is None:
        raise InputError(
            f"the method 'copy' maps weights to weights, but {request.performance} holds markers; use range-of-motion."
        )
    notes: tuple[Note, ...] = ()
    if request.method != "copy":
        text = (
            "no actor's rig was given (--actor), so weights were copied by name; intensities are the performance's own."
        )
        notes = (Note("copied-by-name", text, str(request.performance)),)
    return Fitted(METHODS["copy"]().fit(character, performance.clip), character, None, notes)


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


def _distinct(notes: Sequence[Note]) -> tuple[Note, ...]:
    return tuple(dict.fromkeys(notes))


def stopwatch(timing: dict[str, float], progress: Progress) -> Stage:
    """Return what times a stage and says that it begins."""

    @contextmanager
    def stage(name: str) -> Iterator[None]:
        progress(name)
        begin = time.perf_counter()
        yield
        timing[name] = round(time.perf_counter() - begin, 4)

    return stage
