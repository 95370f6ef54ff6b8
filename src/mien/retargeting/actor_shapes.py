"""The actor's own blendshapes by name of how they are found, for methods that take them as given.

What a comparison needs: the same shapes under another solve, or the same solve on other shapes.
"""

from __future__ import annotations

from mien.core import Examples, InputError, Rig
from mien.core.arrays import Floats
from mien.core.errors import unknown
from mien.retargeting.initial import warped_shapes
from mien.retargeting.prepare import Prepared
from mien.retargeting.range_of_motion import RangeOfMotion
from mien.retargeting.settings import SolveSettings

SHAPES = ("range-of-motion", "alignment", "rbf")
"""The default of `range-of-motion`; its alignment as published; the character's shapes warped onto the actor."""


def check_shapes(kind: str) -> None:
    """Check how shapes are to be found.

    Raises:
        InputError: no such way.
    """
    if kind not in SHAPES:
        raise InputError(unknown("way to find the actor's shapes", kind, SHAPES))


def actor_shapes(
    kind: str,
    prepared: Prepared,
    character: Rig,
    solve: SolveSettings,
    *,
    full_range: bool = True,
    examples: Examples | None = None,
) -> Floats:
    """Return the actor's own blendshapes, `(K, M, 3)` [cm].

    Args:
        kind: one of `SHAPES`.
        prepared: the take beside the character.
        character: the rig, with its `K` shapes.
        solve: the per-frame solve; what it leaves at rest is not learned from.
        full_range: for `range-of-motion`, whether the take shows what it shows at full strength.
        examples: labelled frames, for `range-of-motion` and `alignment`.

    Raises:
        InputError: every frame misses a marker, or an example names an unknown shape or frame.
    """
    check_shapes(kind)
    if kind == "rbf":
        return warped_shapes(prepared.terms)
    found = "alignment" if kind == "alignment" else "refit"
    method = RangeOfMotion(shapes=found, full_range=full_range, solve=solve)
    return method.align(prepared, character, examples).personal
