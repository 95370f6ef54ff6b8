"""The benchmark's page: figures, plots, and every method beside the truth in pictures."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from mien.core import FileError, InputError, MissingPackage
from mien.evaluate.bench.document import Document
from mien.evaluate.bench.figures import ACCURACY, BY_KEY, FIGURES, Spread
from mien.evaluate.bench.run import Line, Scened
from mien.io.files import written_whole
from mien.look import compared, plots
from mien.look.page import Figure, Prose, Section, Table, page
from mien.look.portrait import Portrait
from mien.look.raster import Picture
from mien.look.sheet import Labelled, Row, png, sheet

SIZE = 150
"""Width and height of each picture [pixels]."""
TRUTH = "truth"
SMALL = 0.001
"""Less than this is not worth a digit."""
PLOTTED = ("vertex_mm", "gain", "lid_mm")
RIGHT = {"vertex_mm": 0.0, "gain": 1.0, "lid_mm": 0.0}
RIGHTNESS = tuple(BY_KEY[key] for key in ACCURACY)
REST = tuple(figure for figure in FIGURES if figure.key not in ACCURACY)


def real_data(given: Path | None, named: str | None) -> Path | None:
    """Return the folder of real rigs and recordings; None if there is none.

    Raises:
        FileError: the folder that was given lacks them.
    """
    folder = given or (Path(named) if named else None)
    if folder is None or (folder / "rigs").is_dir():
        return folder
    if given is None:
        return None
    raise FileError(f"{folder} holds no real data: it lacks the folder rigs; leave --data out to run without.")


def check_places(json: Path | None, html: Path | None) -> None:
    """Refuse what could not be written before an hour is spent.

    Raises:
        InputError: another suffix.
        FileError: the folder is missing.
        MissingPackage: the page's pictures need a package that is not installed.
    """
    for package, name in (("matplotlib", "matplotlib"), ("PIL", "pillow")):
        if html is not None and find_spec(package) is None:
            raise MissingPackage("the page of the benchmark", name, "look")
    for path, suffix, option in ((json, ".json", "--json"), (html, ".html", "--html")):
        if path is None:
            continue
        if path.suffix.lower() != suffix:
            raise InputError(f"{option} writes a {suffix} file, but {path} is none; change the name.")
        if not path.parent.is_dir():
            raise FileError(f"cannot write {path}: there is no folder {path.parent}; make it first.")


def write_page(path: Path, found: Document, played: Sequence[Scened]) -> None:
    """Write the page.

    Raises:
        FileError: it cannot be written.
        MissingPackage: matplotlib or Pillow is not installed.
    """
    content = page("mien bench", sections(found, played))
    with written_whole(path) as temporary:
        temporary.write_text(content, encoding="utf-8")


def sections(found: Document, played: Sequence[Scened]) -> list[Section]:
    """Return what the page shows: the plots first, then scene by scene figures and pictures."""
    shown: list[Section] = [_about(found), _legend()]
    for key in PLOTTED:
        rows = {s.scene.name: _spreads(s, key) for s in played}
        figure = compared.spreads(rows, f"{BY_KEY[key].title}: {BY_KEY[key].meaning}", RIGHT[key], columns=2)
        caption = "Mean over identities, with one standard deviation either way; the line is what would be right."
        shown.append(Figure(plots.as_svg(figure), caption, _HEADINGS[key]))
    costs = [(line.row.method, line.figures["frame_ms"].mean, line.figures["vertex_mm"].mean) for line in _done(played)]
    trade = compared.trade(costs, "time per frame [ms]", "vertex error [mm]")
    words = "Every method in every scene: to the left is faster, down is nearer to the truth."
    shown.append(Figure(plots.as_svg(trade), words, "What accuracy costs"))
    for scened in played:
        shown += [*_tables(scened), strips(scened)]
    return shown


_HEADINGS = {"vertex_mm": "How far the surface is off", "gain": "How strong", "lid_mm": "Do eyes close"}


def _about(found: Document) -> Prose:
    where = found["machine"]
    text = (
        f"{found['suite']}, {len(found['rows'])} rows in {found['seconds']:.0f} s. Commit {where['commit']}, {where['time']}, "
        f"{where['cpu']} with {where['threads']} threads, {where['system']}, Python {where['python']}."
    )
    return Prose(text)


def _legend() -> Table:
    rows = [(figure.title, figure.meaning) for figure in FIGURES]
    return Table(("figure", "what it is"), rows, heading="How to read it")


def _done(played: Sequence[Scened]) -> list[Line]:
    return [line for scened in played for line in scened.lines if not line.failed]


def _spreads(scened: Scened, key: str) -> dict[str, Spread]:
    return {line.row.method: line.figures[key] for line in scened.lines if not line.failed}


def _tables(scened: Scened) -> list[Section]:
    """Return how right each method was, and what it cost."""
    people = ", ".join(scened.scene.identities)
    right = (
        f"Mean ± standard deviation over {people}. "
        f"The truth itself has {scened.witness.crossings:.0f} crossings at the strongest frames."
    )
    done, failed = ([line for line in scened.lines if bool(line.failed) is wanted] for wanted in (False, True))
    columns = ("method", *(figure.title for figure in RIGHTNESS))
    rows = [(line.row.method, *(_written(line.figures[f.key]) for f in RIGHTNESS)) for line in done]
    cost = [(line.row.method, *(_written(line.figures[f.key]) for f in REST), line.given) for line in done]
    cost += [(line.row.method, *[None] * len(REST), line.failed) for line in failed]
    return [
        Table(columns, rows, right, scened.scene.name),
        Table(
            ("method", *(figure.title for figure in REST), "what it was given"), cost, "What it took, and what it did."
        ),
    ]


def _written(spread: Spread) -> str | None:
    """Return a mean with its standard deviation, in a cell that is not broken into lines."""
    if not np.isfinite(spread.mean):
        return None
    mean = f"{spread.mean:.3g}" if abs(spread.mean) >= SMALL else f"{spread.mean:.3f}"
    if spread.std < max(SMALL, SMALL * abs(spread.mean)):
        return mean
    deviation = f"{spread.std:.0f}" if spread.std >= 10 else f"{spread.std:.1g}".removeprefix("0")
    return f"{mean}\u00a0±{deviation}"


def strips(scened: Scened) -> Figure:
    """Show the character in the truth's strongest frames, and as each method poses it there."""
    caption = (
        f"{scened.scene.identities[0]} at the frames in which the truth moves most; the truth above, then each method."
    )
    return Figure(png(pictured(scened)), caption)


def pictured(scened: Scened) -> Picture:
    """Picture a row of the truth's strongest frames, and one for each method."""
    case, frames = scened.witness.case, scened.witness.frames
    sitter = Portrait.of(case.character, size=(SIZE, SIZE))
    labels = [f"{f / case.test.fps:.2f} s" for f in frames]
    poses = {TRUTH: np.asarray(case.truth_range.values)[frames], **scened.poses}
    rows = [
        Row(name, tuple(Labelled(sitter.picture(pose), label) for pose, label in zip(of, labels, strict=True)))
        for name, of in poses.items()
    ]
    return sheet(rows)
