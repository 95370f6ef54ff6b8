"""The knobs of the per-frame solve, shared by every method that fits points."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from fnmatch import fnmatchcase
from typing import Any

import numpy as np

from mien.core import InputError
from mien.core.errors import unknown
from mien.retargeting.prior import PRIORS


@dataclass(frozen=True)
class SolveSettings:
    """The knobs of the per-frame solve.

    The defaults are those that measure best (docs/accuracy.md); `PAPER` holds the published ones.

    Attributes:
        prior: µ, how strongly unlikely faces are avoided.
        prior_kind: what makes a face unlikely, a key of `PRIORS`: bending of the surface as published, or another.
        sparsity: ν, how strongly small weights are pulled to exactly zero; weakens expressions.
        damping: ρ, the share of a shape's movement that may be wrong; keeps shapes from
            working against each other.
        smooth: resistance to change, at 30 frames a second and alike at any other rate; a held
            pose is held at any value.
        ahead: whether the smoothness of a whole take ties a frame to the next as well as to the one
            before. Live, nobody knows the next; with `ahead` off, a take gives what its frames give one by one.
        bounds: lowest and highest weight, or None for no bounds (the paper's choice).
        off: shapes kept at rest, by name or pattern. Visemes are mixtures of the other shapes:
            left in, they take over the jaw's curve. Shapes that match are used all the same if
            the character has no others.
        unseen: whether a shape costs more the more it moves the face where no marker is.
        contact: how far the gap of the character's lids and lips is brought to the actor's where
            these close: 0 not at all, 1 all the way.
        shape_sparsity: per-shape factors on ν, by name.
        exclusive: pairs of shapes that are never active together.
        symmetric: pairs of shapes drawn towards equal weights.
        symmetry: how strongly.
    """

    prior: float = 0.0
    prior_kind: str = "geometric"
    sparsity: float = 0.0002
    damping: float = 0.003
    smooth: float = 0.002
    ahead: bool = True
    bounds: tuple[float, float] | None = (0.0, 1.0)
    off: Sequence[str] = ("viseme_*",)
    unseen: bool = True
    contact: float = 0.0
    shape_sparsity: Mapping[str, float] = field(default_factory=dict)
    exclusive: Sequence[tuple[str, str]] = ()
    symmetric: Sequence[tuple[str, str]] = ()
    symmetry: float = 0.1

    def __post_init__(self) -> None:
        for name in ("prior", "sparsity", "damping", "smooth", "contact", "symmetry"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value >= 0):
                raise InputError(f"{name} must be a number of at least 0, but is {value}.")
        if self.contact > 1:
            raise InputError(f"contact must be a number from 0 (none) to 1 (all the way), but is {self.contact}.")
        if self.prior_kind not in PRIORS:
            raise InputError(unknown("prior", self.prior_kind, PRIORS))
        if self.bounds is not None and not self.bounds[0] <= 0 <= self.bounds[1]:
            raise InputError(
                f"the bounds must enclose 0 (the neutral), but are {self.bounds[0]:g} … {self.bounds[1]:g}."
            )

    def as_dict(self) -> dict[str, Any]:
        """Return the settings by name, ready for JSON."""
        return asdict(self)

    def kept_at_rest(self, names: Sequence[str]) -> tuple[str, ...]:
        """Return those of the names that `off` leaves out; none if it would leave out all."""
        off = tuple(name for name in names if any(fnmatchcase(name, pattern) for pattern in self.off))
        return off if len(off) < len(names) else ()


PAPER: Mapping[str, Any] = {
    "prior": 0.3,
    "sparsity": 0.6,
    "damping": 0.0,
    "smooth": 0.0,
    "bounds": None,
    "off": (),
    "unseen": False,
}
"""µ and ν as published (Ribera et al. 2017, §5): no bounds, no damping, no smoothing, every shape."""


def in_range(owner: Any, **limits: tuple[float, float]) -> None:
    """Check parameters of a method against their limits, ends included.

    Raises:
        InputError: one lies outside.
    """
    for name, (low, high) in limits.items():
        value = getattr(owner, name)
        if not low <= value <= high:
            wanted = f"at least {low:g}" if np.isinf(high) else f"between {low:g} and {high:g}"
            raise InputError(f"{name} must be {wanted}, but is {value}.")
