"""The actor's own blendshapes refitted to the take, and their range calibrated: what the default does.

The printed alignment (eq. 4) averages frames that look like a shape, whatever their
strength, so its shapes come out weak and mixed (docs/accuracy.md).  Here the take is
explained instead: solve all frames for weights with the shapes so far, then let every
shape move a little towards what explains the frames better.  This settles directions;
strength comes from the paper's own notion of range: where the take covers the actor's
range of motion, the strongest movement of a shape is that shape at 1.  Frames that a person
has labelled say both, and more surely.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mien.core import Correctives
from mien.core.arrays import Flags, Floats
from mien.retargeting.energy import frame_solver
from mien.retargeting.settings import SolveSettings, in_range

SHOWN = 0.1
"""A shape whose strongest weight stays below this was not shown, and keeps its strength; so with labels."""
LARGEST = 1.5
"""Weights may go this far while the range is being found, and shapes grow by as much at most."""
FIRST, LAST = 0.9, 0.6
"""How far, in powers, shapes are brought to the range that weights show before and after they are refitted.

Weights of the shapes as they start are misled: a shape that its neighbours replace is taken for
a small one.  Afterwards the refit has taken up part of what the first calibration left.
"""
FRAMES = 2000
"""Longer takes are thinned to about this many frames."""
ROUNDS = 3
SMOOTH = 0.001
"""Of the weights that the shapes are found with: blinks are to show their full strength."""
NOISE_CM = 0.2
"""How far a point may be off, shapes and all, on a human face."""
DOUBT = 0.5
"""How far, as a share, labels are expected to change the strength that a shape has without them."""
INDEPENDENT = 0.01
"""The share of a labelled frame's points that counts: a wrong label, or a wrong shape, is wrong at all points alike."""
WEAKEST, STRONGEST = 0.2, 3.0
"""Labels change the strength of a shape by no more than these factors."""


@dataclass(frozen=True)
class Refit:
    """How far the take may change the shapes.

    Attributes:
        freedom: how far a shape may move at a point, as a share of its movement there.
        spread: the same where the shape does not move, as a share of its largest movement.
        full: the quantile of a shape's weights that counts as its full strength.
    """

    freedom: float = 0.1
    spread: float = 0.01
    full: float = 0.99

    def __post_init__(self) -> None:
        in_range(self, freedom=(0, 10), spread=(0, 1), full=(0.5, 1))


@dataclass(frozen=True, eq=False)
class Take:
    """What the shapes are found from.

    Attributes:
        names: `K` shape names.
        frames: `(F, M, 3)` displacements of the training take, without missing points [cm].
        confidence: `(M,)` how much each point counts.
        off: shapes that are never used, by name or pattern.
        labelled: `(E, M, 3)` frames that a person has labelled [cm].
        labels: `(E, K)` the weights there; NaN where not labelled.
        correctives: which shapes follow from others.
    """

    names: Sequence[str]
    frames: Floats
    confidence: Floats
    off: Sequence[str]
    labelled: Floats
    labels: Floats
    correctives: Correctives | None = None

    def weights(self, shapes: Floats, frames: Floats, highest: float) -> Floats:
        """Solve frames `(F, M, 3)` with shapes `(K, M, 3)` for weights `(F, K)` from 0 to `highest`."""
        count = len(shapes)
        settings = SolveSettings(smooth=SMOOTH, bounds=(0.0, highest), off=self.off)
        none = np.zeros((count, count))
        solver = frame_solver(shapes, self.names, none, self.confidence, settings, correctives=self.correctives)
        return solver.batch(frames)[0]

    def told(self, shapes: Floats) -> Floats:
        """Return weights `(E, K)` of the labelled frames: the labels, and solved with shapes `(K, M, 3)` where there is none."""
        if not len(self.labelled):
            return np.empty((0, len(shapes)))
        return np.where(np.isnan(self.labels), self.weights(shapes, self.labelled, 1.0), self.labels)

    @property
    def known(self) -> Flags:
        """`(K,)` shapes whose strength the labels say."""
        return np.asarray((np.nan_to_num(self.labels) >= SHOWN).any(axis=0))


def personalise(guess: Floats, take: Take, refit: Refit, *, full_range: bool) -> Floats:
    """Return the actor's own blendshapes.

    Args:
        guess: `(K, M, 3)` to start from [cm].
        take: what the actor did.
        refit: how far to go.
        full_range: whether the take shows each shape it shows at its full strength.

    Returns:
        `(K, M, 3)` [cm].
    """
    thin = thinned(take)
    shapes = begun(guess, thin, refit, full_range=full_range)
    for _ in range(ROUNDS):
        shapes = refitted(shapes, thin, refit)
    return calibrated(shapes, thin, refit.full, LAST, but=take.known) if full_range else shapes


def begun(guess: Floats, take: Take, refit: Refit, *, full_range: bool) -> Floats:
    """Return shapes `(K, M, 3)` as strong as the take, if it shows the actor's range, and the labels have them [cm]."""
    return strengthened(calibrated(guess, take, refit.full, FIRST) if full_range else guess, take)


def unexplained(shapes: Floats, take: Take) -> float:
    """Return the root mean square, over frames and points, of what shapes leave of a take's movement [cm]."""
    weights = take.weights(shapes, take.frames, 1.0)
    return float(np.sqrt(((take.frames - np.tensordot(weights, shapes, axes=1)) ** 2).sum(axis=2).mean()))


def thinned(take: Take, frames: int = FRAMES) -> Take:
    """Leave out frames of a long take, evenly."""
    return replace(take, frames=take.frames[:: max(1, len(take.frames) // frames)])


def calibrated(shapes: Floats, take: Take, full: float, share: float = 1.0, but: Flags | None = None) -> Floats:
    """Scale each shape so that its strongest weight in the take is 1.

    Args:
        shapes: `(K, M, 3)` [cm].
        take: what the actor did.
        full: the quantile that counts as strongest.
        share: how much of the way to go, in powers: 1 is all.
        but: `(K,)` shapes that keep their strength.
    """
    strongest = np.quantile(take.weights(shapes, take.frames, LARGEST), full, axis=0)
    shown = strongest > SHOWN if but is None else (strongest > SHOWN) & ~but
    scale = np.where(shown, np.clip(strongest, SHOWN, LARGEST), 1.0) ** share
    return _scaled(shapes, scale, take.correctives)


def strengthened(shapes: Floats, take: Take) -> Floats:
    """Scale each labelled shape to what the labelled frames say of its strength.

    The scales `s` are those that explain the frames `A` best with the weights `W` they are
    labelled with, near 1 where labels say little: `min c |A - W s P|² / noise² + |s - 1|² / doubt²`,
    `c` being the share of points that counts.

    Args:
        shapes: `(K, M, 3)` `P` [cm].
        take: what the actor did, `A` and `W`.
    """
    weights = take.told(shapes)
    given = (np.nan_to_num(take.labels) > 0).any(axis=0)
    if not given.any():
        return shapes
    left = take.labelled - np.tensordot(weights[:, ~given], shapes[~given], axes=1)
    weights, labelled = weights[:, given], shapes[given]
    alike = np.tensordot(labelled, labelled, axes=((1, 2), (1, 2)))
    evidence = INDEPENDENT / NOISE_CM**2
    system = evidence * (weights.T @ weights) * alike + np.eye(len(labelled)) / DOUBT**2
    load = evidence * np.einsum("ek,kmd,emd->k", weights, labelled, left, optimize=True) + 1 / DOUBT**2
    scale = np.ones(len(shapes))
    scale[given] = np.clip(np.linalg.solve(system, load), WEAKEST, STRONGEST)
    return _scaled(shapes, scale, take.correctives)


def refitted(shapes: Floats, take: Take, refit: Refit) -> Floats:
    """Let every shape move towards what explains the frames better.

    With the weights `W` of the frames held fixed, each point `m` has its own small
    ridge problem, `min |A_m - W P_m|² / noise² + Σ_k |P_km - P⁰_km|² / (freedom · reach_km)²`.
    Labelled frames count as much as all others together, with the weights they are labelled with.

    Args:
        shapes: `(K, M, 3)` `P⁰` [cm].
        take: what the actor did: `A`.
        refit: the scales of the problem.
    """
    count, points, _ = shapes.shape
    frames = np.concatenate([take.frames, take.labelled])
    weights = np.concatenate([take.weights(shapes, take.frames, 1.0), take.told(shapes)])
    say = np.ones(len(frames))
    say[len(take.frames) :] = len(take.frames) / max(1, len(take.labelled))
    size = np.linalg.norm(shapes, axis=2)
    reach = refit.freedom * (size + refit.spread * size.max(axis=1, keepdims=True)) + 1e-4
    hold = 1 / reach**2
    counted = weights.T * say / NOISE_CM**2
    load = (counted @ frames.reshape(len(frames), -1)).reshape(count, points, 3)
    systems = counted @ weights + hold.T[:, :, None] * np.eye(count)
    targets = (load + hold[:, :, None] * shapes).transpose(1, 0, 2)
    return np.asarray(np.linalg.solve(systems, targets).transpose(1, 0, 2))


def _scaled(shapes: Floats, scale: Floats, correctives: Correctives | None) -> Floats:
    if correctives is not None:
        scale = _driven(scale, correctives)
    return np.asarray(shapes * scale[:, None, None])


def _driven(scale: Floats, correctives: Correctives) -> Floats:
    """Let a combination grow as its drivers do, whose product it goes with; an in-between stays as it is."""
    result = scale.copy()
    drivers = np.append(scale, 1.0)[correctives.drivers]
    result[correctives.shapes] = np.where(correctives.at < 1, 1.0, drivers).prod(axis=1)
    return result
