"""`mien bench`: every method on the same work."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from mien.evaluate.bench.figures import Spread
    from mien.evaluate.bench.gate import Verdict
    from mien.evaluate.bench.run import Scened

WIDTH = 180
"""Columns that a table with standard deviations needs, and that files and pipes get; a narrower terminal sees the means."""


def bench(
    full: Annotated[bool, typer.Option("--full", help="Every case, and not the quick suite alone.")] = False,
    methods: Annotated[str, typer.Option(help="Only these methods, as in rbf,direct,latent.")] = "",
    cases: Annotated[str, typer.Option(help="Only cases whose names hold all these words, as in 'acting goat'.")] = "",
    data: Annotated[
        Path | None, typer.Option(help="Folder of the real rigs and recordings (default: MIEN_DATA, if set).")
    ] = None,
    embedded: Annotated[bool, typer.Option("--embedded", help="Leave the real data out where it is present.")] = False,
    json: Annotated[Path | None, typer.Option("--json", help="Where to write the figures (.json).")] = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="Run only the cases that --json, written case by case, does not hold yet.")
    ] = False,
    html: Annotated[Path | None, typer.Option("--html", help="Where to write a page with plots and pictures.")] = None,
    gate: Annotated[Path | None, typer.Option(help="A baseline (.json): fail if anything got worse since.")] = None,
    quiet: Annotated[bool, typer.Option("-q", "--quiet", help="No progress, and no tables.")] = False,
) -> None:
    """Measure every method on the same performances and characters, in one table.

    Examples:
      mien bench

      mien bench --methods rbf,range-of-motion --cases acting --html bench.html

      mien bench --gate benchmarks/results/bench_quick.json

      mien bench --full --json full.json --resume
    """
    import time

    from mien.cli.say import counted
    from mien.core import InputError
    from mien.evaluate.bench.document import begun, extended, lacking, read, write
    from mien.evaluate.bench.gate import gate as compare
    from mien.evaluate.bench.run import run
    from mien.evaluate.bench.table import entrants, scenes
    from mien.job.bench import check_places, real_data, write_page

    check_places(json, html)
    baseline = None if gate is None else read(gate)
    folder = None if embedded else real_data(data, os.environ.get("MIEN_DATA"))
    suite = scenes(full=full, real=folder is not None, words=cases.split())
    field = entrants([name.strip() for name in methods.split(",") if name.strip()])
    name = f"{'full' if full else 'quick'} suite, {'embedded and real' if folder else 'embedded'} data"
    if resume and json is None:
        raise InputError("--resume goes on with the file that --json names; give --json, too.")
    found = begun(name, read(json) if resume and json is not None and json.is_file() else None)
    suite = lacking(found, suite, field)
    out, played = wide_console(), []
    with counted(quiet, "bench") as step:
        start = time.perf_counter()
        for scened in run(suite, field, folder, lambda done, total, what: step(done, total)):
            found, start = extended(found, scened, time.perf_counter() - start), time.perf_counter()
            if json is not None:
                write(json, found)
            if html is not None:  # a scene is large
                played.append(scened)
            if not quiet:
                out.print(table_of(scened, spread=out.width >= WIDTH), soft_wrap=False)
                out.file.flush()  # a log shows each scene when it is done
    if json is not None:
        out.print(f"wrote {json}")
    if html is not None:
        write_page(html, found, played)
        out.print(f"wrote {html}")
    if not quiet:
        out.print(f"{name}, {len(suite)} scenes × {len(field)} methods; {found['seconds']:.0f} s in all")
    if baseline is not None:
        verdict = compare(found, baseline, whole=not (methods or cases))
        print_verdict(verdict, gate)
        if verdict.regressions:
            raise typer.Exit(1)


def wide_console() -> Console:
    """Return where to print; a file or a pipe has no width of its own."""
    from mien.cli.say import console

    out = console()
    if not out.is_terminal:
        out.width = WIDTH
    return out


def table_of(scened: Scened, spread: bool = True) -> Table:
    """Return the table of a scene: means over its identities, and their standard deviations if there is room."""
    from rich import box
    from rich.table import Table

    from mien.evaluate.bench.figures import FIGURES

    scene = scened.scene
    title = (
        f"{scene.name} · {len(scene.identities)} identities · the truth has {scened.witness.crossings:.0f} crossings"
    )
    table = Table(title=title, title_justify="left", title_style="bold", box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0))
    table.add_column("method", no_wrap=True, min_width=max(len(line.row.method) for line in scened.lines))
    for figure in FIGURES:
        table.add_column(figure.title, justify="right", no_wrap=True, min_width=max(4, len(figure.title)))
    table.add_column("given", no_wrap=spread)
    for line in scened.lines:
        if line.failed:
            table.add_row(line.row.method, *["–"] * len(FIGURES), line.failed, style="dim")
        else:
            table.add_row(line.row.method, *(_cell(line.figures[f.key], spread) for f in FIGURES), line.given)
    return table


def print_verdict(verdict: Verdict, baseline: Path | None) -> None:
    """Say what got worse, or that nothing did."""
    from rich import box
    from rich.table import Table

    out = wide_console()
    compared = f"{verdict.figures} figures of {verdict.rows} rows compared with {baseline}"
    if not verdict.timed:
        compared += " (no times: the reference method was not run)"
    if not verdict.regressions:
        out.print(f"{compared}: nothing got worse.")
        return
    table = Table(title=f"{compared}: worse", title_justify="left", title_style="bold red", box=box.SIMPLE_HEAD)
    for column in ("method", "case", "figure", "was", "is", "allowed"):
        table.add_column(column, justify="right" if column in ("was", "is", "allowed") else "left")
    for bad in verdict.regressions:
        table.add_row(bad.method, bad.where, bad.figure, *_plain((bad.was, bad.now, bad.allowed)))
    out.print(table, soft_wrap=False)


def _plain(values: Sequence[float | None]) -> list[str]:
    return ["–" if value is None else f"{value:.4g}" for value in values]


def _cell(figure: Spread, spread: bool) -> str:
    """Return a mean with its standard deviation; without it where there is a single identity."""
    if figure.mean != figure.mean:
        return "–"
    text, deviation = _short(figure.mean), f"{figure.std:.{0 if figure.std >= 1 else 2}f}"
    return f"{text} ±{deviation.removeprefix('0')}" if spread and float(deviation) > 0 else text


def _short(value: float) -> str:
    """Return a number in at most four characters, as tables have room for."""
    return f"{value:.0f}" if abs(value) >= 9.95 else f"{value:.2f}"
