"""What is asked for, what has been learned, and what came out: the nouns of the main job."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from mien.core import Clip, Correspondence, Markers, Note, Report, Rig
from mien.geometry.bones import Bones
from mien.job.pairs import DEFAULT_COUNT
from mien.job.performance import Performance

MODEL = ".mien"
"""Suffix of a file that holds a fitted method."""


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
