"""Running the table: scene after scene, identity after identity, method after method."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mien.core.arrays import Floats
from mien.evaluate.bench.cell import Cell, Witness, measure
from mien.evaluate.bench.figures import ACCURACY, BY_KEY, FIGURES, Spread, spread_of
from mien.evaluate.bench.table import Entrant, Row, Scene

REFERENCE = "rbf"
"""Times are told relative to this method's in the same case, so that machines can be compared."""

Progress = Callable[[int, int, str], None]


@dataclass(frozen=True, eq=False)
class Line:
    """A method in a scene, over the identities.

    Attributes:
        row: which.
        given: what it got besides take and pairs, in words.
        figures: spread by key; those against a truth are of the range truth.
        absolute: the same against the absolute truth.
        time_ratio: processor time per frame over the reference's in the same case, the median; NaN without it.
        failed: why it has no figures; empty if it has.
    """

    row: Row
    given: str
    figures: Mapping[str, Spread]
    absolute: Mapping[str, Spread]
    time_ratio: float
    failed: str


@dataclass(frozen=True, eq=False)
class Scened:
    """A scene, played by every method.

    Attributes:
        scene: which.
        lines: one per method.
        witness: its first identity, for pictures.
        poses: `(P, K)` of that identity at the witness's frames, by method.
    """

    scene: Scene
    lines: tuple[Line, ...]
    witness: Witness
    poses: Mapping[str, Floats]


def run(
    suite: Sequence[Scene],
    methods: Sequence[Entrant],
    folder: Path | None = None,
    progress: Progress = lambda done, total, what: None,
) -> Iterator[Scened]:
    """Run methods on scenes, giving each scene as it is done.

    Args:
        suite: the scenes.
        methods: the entrants.
        folder: the real data; needed by scenes of it.
        progress: called with the number of cells done, their total, and what comes next.

    Raises:
        FileError: a file of the real data is missing or damaged.
    """
    total = len(methods) * sum(len(scene.recipes) for scene in suite)
    done = 0
    for scene in suite:
        cells: list[Cell] = []
        first: Witness | None = None
        for identity, case in scene.cases(folder):
            progress(done, total, f"{scene.name}: {identity}")
            witness = Witness.of(case)
            first = first or witness
            for entrant in methods:
                progress(done, total, f"{scene.name}: {identity}, {entrant.name}")
                cells.append(measure(witness, entrant, identity))
                done += 1
        assert first is not None
        yield Scened(
            scene, tuple(_line(scene, entrant.name, cells) for entrant in methods), first, _poses(cells, scene)
        )
    progress(total, total, "done")


def _line(scene: Scene, method: str, cells: Sequence[Cell]) -> Line:
    mine = [cell for cell in cells if cell.method == method]
    failed = next((cell.failed for cell in mine if cell.failed), "")
    figures = {f.key: spread_of(f, [cell.figures.get(f.key) for cell in mine]) for f in FIGURES}
    absolute = {key: spread_of(BY_KEY[key], [cell.absolute.get(key) for cell in mine]) for key in ACCURACY}
    reference = {cell.identity: cell.busy_ms for cell in cells if cell.method == REFERENCE and not cell.failed}
    ratios = [
        cell.busy_ms / reference[cell.identity] for cell in mine if cell.identity in reference and not cell.failed
    ]
    given = next((cell.given for cell in mine if cell.given), "")
    ratio = float(np.median(ratios)) if ratios else float("nan")
    return Line(scene.row(method), given, {} if failed else figures, {} if failed else absolute, ratio, failed)


def _poses(cells: Sequence[Cell], scene: Scene) -> dict[str, Floats]:
    """Return the poses of the scene's first identity, by method."""
    first = scene.identities[0]
    return {cell.method: cell.poses for cell in cells if cell.identity == first and cell.poses is not None}
