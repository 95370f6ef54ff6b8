"""How a character moves differently from the actor: stronger, slower to follow, in its own time.

The future work of Kholgade, Matthews, Sheikh (2011, §7): a squirrel is quick, a globe is slow,
and a head may turn about other axes.  Everything acts on the curves of the layers, so it
keeps them shares.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.spatial.transform import Rotation

from mien.core import Clip, InputError, Note
from mien.core.arrays import Floats
from mien.retargeting.layers.model import LayeredFace
from mien.solve.simplex import project_simplex


@dataclass(frozen=True, eq=False)
class Dynamics:
    """How a character performs.

    Attributes:
        gain: per layer, how much of what is not rest is shown; 1 leaves it, 0 is always at rest. In a layer
            without an extreme at rest the mean of the take stands for it.
        lag: seconds by which expressions trail (a first-order follower).
        speed: how much faster than the actor; 2 takes half the time.
        head_gain: how much of the head's turning and moving is shown.
        head_map: `(3, 3)` rotation from the actor's axes of turning to the character's.

    Raises:
        InputError: a value that is negative or not finite, no speed, or a map that is no rotation.
    """

    gain: Mapping[str, float] = field(default_factory=dict)
    lag: float = 0.0
    speed: float = 1.0
    head_gain: float = 1.0
    head_map: Floats = field(default_factory=lambda: np.eye(3))

    def __post_init__(self) -> None:
        for name, value in {**self.gain, "lag": self.lag, "speed": self.speed, "head_gain": self.head_gain}.items():
            if not (np.isfinite(value) and value >= 0):
                raise InputError(f"{name} must be a number of at least 0, but is {value}.")
        if self.speed == 0:
            raise InputError("speed must be above 0; at 0 nothing would ever happen.")
        turn = np.asarray(self.head_map, np.float64)
        if turn.shape != (3, 3) or not np.allclose(turn @ turn.T, np.eye(3), atol=1e-6) or np.linalg.det(turn) < 0:
            raise InputError("head_map must be a rotation, a 3 x 3 matrix with R Rᵀ = 1 and determinant 1.")
        object.__setattr__(self, "head_map", turn)

    def apply(self, face: LayeredFace, clip: Clip) -> Clip:
        """Return the curves as this character performs them.

        Args:
            face: the character in layers; an extreme without offset is its rest, which gains act against.
            clip: curves of its layers, see `layer_clip`.

        Raises:
            InputError: a gain is for no layer.
        """
        values = np.array(clip.values)
        for name, gain in self.gain.items():
            layer, rest = face.layers[face.layer(name)], _rest(face, name)
            columns = [clip.names.index(f"{name}.{extreme}") for extreme in layer.extremes]
            if rest is None:
                values[:, columns] = _spread(values[:, columns], gain)
            else:
                values[:, columns] = _gained(values[:, columns], rest, gain)
        values = _followed(values, self.lag * clip.fps)
        head = None if clip.head is None else self._head(clip.head)
        if self.speed != 1:
            values, head = _warped(values, head, self.speed)
        return replace(clip, values=values, head=head, eyes=None, joints=None)

    def notes(self, face: LayeredFace) -> tuple[Note, ...]:
        """Say which gains act against the mean of a layer, for want of an extreme at rest.

        Raises:
            InputError: a gain is for no layer.
        """
        bare = [name for name in self.gain if _rest(face, name) is None]
        text = "has no extreme at rest, so the gain acts against the mean of its extremes over the take."
        return tuple(Note("gain-about-mean", f"the layer {name!r} {text}", name) for name in bare)

    def _head(self, head: Floats) -> Floats:
        """Turn about mapped axes and by a share of the angle."""
        vectors = Rotation.from_matrix(head[:, :3, :3]).as_rotvec() @ self.head_map.T
        moved = np.tile(np.eye(4), (len(head), 1, 1))
        moved[:, :3, :3] = Rotation.from_rotvec(self.head_gain * vectors).as_matrix()
        moved[:, :3, 3] = self.head_gain * head[:, :3, 3] @ self.head_map.T
        return moved


def _rest(face: LayeredFace, name: str) -> int | None:
    """Return which extreme of a layer is the face at rest."""
    still = np.flatnonzero(~face.layers[face.layer(name)].offsets.any(axis=(1, 2)))
    return int(still[0]) if len(still) else None


def _spread(shares: Floats, gain: float) -> Floats:
    """Scale what differs from the mean over the take; where a share would fall below 0, the closest shares are taken."""
    seen = ~np.isnan(shares).any(axis=1)
    out = np.array(shares)
    if seen.any():
        total = np.maximum(shares[seen].sum(axis=1, keepdims=True), 1e-300)
        own = shares[seen] / total
        mean = own.mean(axis=0)
        out[seen] = project_simplex(mean + gain * (own - mean))
    return out


def _gained(shares: Floats, rest: int, gain: float) -> Floats:
    """Scale what is not rest; where it would exceed the whole, the whole is all there is."""
    shown = np.array(shares)
    shown[:, rest] = 0.0
    total = shown.sum(axis=1, keepdims=True)
    shown *= np.minimum(gain, 1 / np.maximum(total, 1e-300))
    shown[:, rest] = 1 - shown.sum(axis=1)
    return shown


def _followed(values: Floats, frames: float) -> Floats:
    """Follow with a time constant in frames; a mean of shares is shares."""
    if frames == 0:
        return values
    keep = np.exp(-1 / frames)
    out = np.array(values)
    for f in range(1, len(out)):
        out[f] = np.where(np.isnan(values[f]), out[f - 1], keep * out[f - 1] + (1 - keep) * values[f])
    return out


def _warped(values: Floats, head: Floats | None, speed: float) -> tuple[Floats, Floats | None]:
    """Play faster or slower: frames in between are means of their neighbours."""
    count = max(int(round((len(values) - 1) / speed)) + 1, 1)
    at = np.minimum(np.arange(count) * speed, len(values) - 1)
    low = np.minimum(at.astype(np.int64), max(len(values) - 2, 0))
    high, part = np.minimum(low + 1, len(values) - 1), (at - low)[:, None]
    mixed = (1 - part) * values[low] + part * values[high]
    if head is None:
        return mixed, None
    a, b = Rotation.from_matrix(head[low, :3, :3]), Rotation.from_matrix(head[high, :3, :3])
    turned = np.tile(np.eye(4), (count, 1, 1))
    turned[:, :3, :3] = (a * Rotation.from_rotvec(part * (a.inv() * b).as_rotvec())).as_matrix()
    turned[:, :3, 3] = (1 - part) * head[low, :3, 3] + part * head[high, :3, 3]
    return mixed, turned
