"""Printing: results on stdout, progress and remarks on stderr."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress, SpinnerColumn, TaskProgressColumn, TextColumn, TimeElapsedColumn
from rich.text import Text

from mien.core.errors import Note


def print_json(document: Any) -> None:
    """Print a document for scripts to read."""
    json.dump(document, sys.stdout, indent=1, ensure_ascii=False)
    sys.stdout.write("\n")


def console(*, error: bool = False) -> Console:
    """Return where to print: stdout for results, stderr for remarks.  Names from files are printed as they are."""
    return Console(stderr=error, highlight=False, soft_wrap=True, markup=False)


def print_notes(notes: tuple[Note, ...]) -> None:
    """Print what was repaired or left out, one line each."""
    out = console(error=True)
    for note in notes:
        out.print(Text.assemble(("  · ", "yellow"), note.message, (f" ({note.code})", "dim")))


@contextmanager
def stages(quiet: bool) -> Iterator[Callable[[str], None]]:
    """Show which stage is running, until the block ends."""
    if quiet or not sys.stderr.isatty():
        yield lambda name: None
        return
    with Progress(
        SpinnerColumn(),
        TextColumn("{task.description}"),
        TimeElapsedColumn(),
        console=console(error=True),
        transient=True,
    ) as bar:
        task = bar.add_task("starting", total=None)
        with _told_of_compiling(bar.console):
            yield lambda name: bar.update(task, description=f"{name} …")


@contextmanager
def _told_of_compiling(out: Console) -> Iterator[None]:
    """Say once if something is compiled while the block runs: it happens when it is first used, and takes a while."""
    from numba.core import event

    class Telling(event.Listener):
        told = False

        def on_start(self, _: Any) -> None:
            if not self.told:
                self.told = True
                out.print("first run: compiling, which takes about a minute and is kept for later runs")

        def on_end(self, _: Any) -> None:
            """Say nothing: a listener has to have this."""

    with event.install_listener("numba:compile", Telling()):
        yield


@contextmanager
def counted(quiet: bool, what: str) -> Iterator[Callable[[int, int], None]]:
    """Show a bar over a known number of steps."""
    if quiet or not sys.stderr.isatty():
        yield lambda done, total: None
        return
    with Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        TaskProgressColumn(),
        TimeElapsedColumn(),
        console=console(error=True),
    ) as bar:
        task = bar.add_task(what, total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)
