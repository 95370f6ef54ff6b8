"""Learning: a request's files read, paired, and a method fitted to them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

from mien.core import Correspondence, Examples, InputError, Markers, Note, Rig
from mien.io.correctives import read_correctives
from mien.io.examples import read_examples
from mien.io.formats import read_rig
from mien.job.bones import Driven, driven
from mien.job.checks import check_correctives, check_no_targets, check_training, known_parameters
from mien.job.choose import Reader, chosen
from mien.job.labelled import check_parameters, read_target, source_of
from mien.job.layers import actor_extremes, rest_of
from mien.job.pairs import OWN, find_pairs, rig_landmarks
from mien.job.performance import Performance, load_performance
from mien.job.request import Fitted, Request
from mien.job.stages import Stage
from mien.retargeting import METHODS, make_method
from mien.retargeting.layers import Layers


def learn(request: Request, stage: Stage) -> tuple[Fitted, Performance]:
    """Fit the method of a request to the training take, or to the performance if there is none."""
    read = cache(read_rig)  # choosing a method may have to look at the character before it is read
    settled, why = chosen(request, read)
    learned = _from_labels(settled, stage) if learns_from_labels(settled.method) else _from_range(settled, stage, read)
    fitted, performance = learned
    return replace(fitted, notes=(*why, *fitted.notes)), performance


def _from_range(request: Request, stage: Stage, read: Reader) -> tuple[Fitted, Performance]:
    """Fit a method to how an actor moves, or map weights by name."""
    check_correctives(request)
    if request.animations:
        raise InputError(f"the method {request.method!r} does not learn from existing animation; use --method latent.")
    with stage("read"):
        character = _with_correctives(read(request.character), request.correctives)
        moved = driven(character, request.targets, request.poses)
        performance = load_performance(request.performance, request.actor)
        training = performance if request.training is None else load_performance(request.training, request.actor)
        examples = read_examples(request.examples) if request.examples else None
    check_training(performance, training)
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
        known = known_parameters(request.method) or {}
        settings, remarks = _settings(request, known)
        rest = training.neutral(pairs, request.neutral)
        if rest is None and examples is None:
            rest = training.rest_at(pairs)  # pairing has found it, and need not be repeated
        retargeter = make_method(request.method, moved.settings(settings, known)).fit(
            _with_landmarks(moved.shown, request),
            take,
            pairs,
            neutral=rest,
            rigid=request.rigid,
            head_moves=training.head_moves,
            examples=examples,
        )
    fitted = Fitted(moved.solved(retargeter, pairs), character, pairs, (*notes, *remarks))
    return _moving(fitted, moved), performance


def _moving(fitted: Fitted, moved: Driven) -> Fitted:
    """Return a method fitted to shapes that stand for bones as one for the character that has the bones."""
    return replace(fitted, character=moved.rig, bones=moved.bones)


def _from_labels(request: Request, stage: Stage) -> tuple[Fitted, Performance]:
    """Fit a method that learns from labelled frames."""
    check_correctives(request)
    check_no_targets(request)
    with stage("read"):
        target = read_target(request.character, request.examples, request.animations)
        performance = load_performance(request.performance, request.actor)
        training = performance if request.training is None else load_performance(request.training, request.actor)
        examples = read_examples(request.examples) if request.examples else None
    check_training(performance, training)
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


def _settings(request: Request, known: Mapping[str, Any]) -> tuple[dict[str, Any], tuple[Note, ...]]:
    """Take only a take that was given as training at its word that it shows the actor's full range."""
    if request.training is not None or "full_range" not in known or "full_range" in request.settings:
        return request.settings, ()
    text = (
        "no training take was given (--training), so strength is as performed. Give a take in which the actor goes to "
        "the full range, or say that this one does with --set full_range=true, and full becomes full on the character."
    )
    return {**request.settings, "full_range": False}, (Note("range-as-performed", text),)


def _with_landmarks(character: Rig, request: Request) -> Rig:
    """Give a character the landmarks that are given or beside its file: contact and the second opinion ask for them."""
    given = request.landmarks[1] if request.landmarks is not None and request.landmarks[1] != OWN else None
    return replace(character, landmarks=rig_landmarks(character, given))


def _with_correctives(character: Rig, path: Path | None) -> Rig:
    if path is None:
        return character
    return replace(character, correctives=read_correctives(path, character.blendshapes.names))


def learns_from_labels(method: str) -> bool:
    """Return whether a method learns from labelled frames."""
    return getattr(METHODS.get(method), "by_example", False)
