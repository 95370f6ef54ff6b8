"""`--method auto`: which method suits what was given, and why.

The rules are those of docs/how-to-choose.md, asked in order; the first that holds decides.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from mien.core import Note, Rig
from mien.io.examples import read_examples
from mien.io.formats import format_of, read_rig
from mien.job.request import Request
from mien.vocabularies.expressions import BLINKS, EMOTIONS, VISEMES

Reader = Callable[[Path], Rig]

AUTO = "auto"
MOSTLY = 0.5
"""A character with more than this share of emotions, visemes and blinks among its shapes is made of extremes."""


def chosen(request: Request, read: Reader = read_rig) -> tuple[Request, tuple[Note, ...]]:
    """Settle the method of a request that leaves it open.

    Args:
        request: what is asked for; unless its method is `auto` it is returned as it is.
        read: reads the character, if it has to be looked at.

    Returns:
        The request with a method, and a note that says why this one.

    Raises:
        FileError: the character has to be looked at and cannot be read.
    """
    if request.method != AUTO:
        return request, ()
    name, why = next(((name, why) for holds, name, why in RULES if holds(request, read)), OTHERWISE)
    return replace(request, method=name), (Note("method-chosen", f"chose {name}: {why}.", name),)


def _picked_extremes(request: Request, _: Reader) -> bool:
    return request.extremes is not None


def _labelled_shapes(request: Request, read: Reader) -> bool:
    """Whether the labels are weights of blendshapes, and something says which point is which."""
    if request.examples is None or request.animations or (request.pairs is None and request.landmarks is None):
        return False
    if _only_names(request, read) or format_of(request.character).read_rig is None:
        return False
    return set(read_examples(request.examples).names) <= set(read(request.character).blendshapes.names)


def _labelled(request: Request, _: Reader) -> bool:
    return request.examples is not None or bool(request.animations)


def _only_names(request: Request, _: Reader) -> bool:
    kind = format_of(request.performance)
    return request.actor is None and kind.read_markers is None and kind.read_rig is None


def _made_of_extremes(request: Request, read: Reader) -> bool:
    if format_of(request.character).read_rig is None:
        return False
    names = read(request.character).blendshapes.names
    known = {*EMOTIONS, *VISEMES, *BLINKS}
    return sum(name in known for name in names) > MOSTLY * max(1, len(names))


RULES: tuple[tuple[Callable[[Request, Reader], bool], str, str], ...] = (
    (_picked_extremes, "layers", "frames were picked as extremes (--extremes)"),
    (
        _labelled_shapes,
        "range-of-motion",
        "frames are labelled with the character's blendshapes, and pairs or landmarks say which point is which",
    ),
    (_labelled, "latent", "labelled frames or existing animation of the character were given to learn from"),
    (
        _only_names,
        "copy",
        "the performance is weights and there is no --actor to play them on, so names are all there is",
    ),
    (_made_of_extremes, "layers", "the character's shapes are whole emotions, visemes and blinks"),
)
"""What decides, the method, and what the user is told."""
OTHERWISE = ("range-of-motion", "the character has shapes of its own and nobody labelled frames")
