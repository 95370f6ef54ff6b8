"""What is written: refused before the work if it could not be, and written together or not at all."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path

from mien.core import Clip, FileError, Note
from mien.core.errors import unknown
from mien.io.files import written_whole
from mien.io.formats import FORMATS, write_clip
from mien.job.exact import MESHES, exactly, write_shown
from mien.job.pairs import OWN
from mien.job.request import Request, Result
from mien.vocabularies import ARKIT_NAMES, match

CSV_FORMATS = tuple(row.name for row in FORMATS if ".csv" in row.suffixes and row.write_clip)
REPORTS = (".html", ".htm", ".json")
ANIMATED = tuple(dict.fromkeys(suffix for row in FORMATS if row.write_clip for suffix in row.suffixes))


def check_outputs(
    outputs: Sequence[Path], inputs: Sequence[Path] = (), *, report: Path | None = None, csv_format: str = "weights"
) -> None:
    """Refuse outputs that could not be written, before any work is done.

    Args:
        outputs: where animation is to be written.
        inputs: what is read; none of it is ever written over.
        report: where the report is to be written.
        csv_format: the layout of `.csv` outputs.

    Raises:
        FileError: a folder is missing, a suffix is not one that is written, two outputs are
            the same file, or an output is an input.
    """
    if csv_format not in CSV_FORMATS:
        raise FileError(unknown("CSV format", csv_format, CSV_FORMATS))
    for path in outputs:
        check_place(path, inputs, ANIMATED, "animation")
    if report is not None:
        check_place(report, inputs, REPORTS, "a report")
    _check_apart([*outputs, *([report] if report else [])])


def check_place(path: Path, inputs: Sequence[Path], suffixes: Sequence[str], what: str) -> None:
    """Refuse one output that could not be written.

    Raises:
        FileError: as `check_outputs`.
    """
    if path.is_dir():
        raise FileError(f"cannot write {path}: it is a folder; name a file in it.")
    if path.suffix.lower() not in suffixes:
        raise FileError(f"cannot write {path}: {what} is written to {', '.join(suffixes)}.")
    if not path.parent.is_dir():
        raise FileError(f"cannot write {path}: the folder {path.parent} does not exist; create it first.")
    if any(path.resolve() == given.resolve() for given in inputs):
        raise FileError(f"cannot write {path}: it is one of the files that are read; give the output another name.")


def write_outputs(
    result: Result, outputs: Sequence[Path], csv_format: str = "weights", report: Path | None = None
) -> None:
    """Write the animation to each path in the format of its suffix, and the report; all of them or none.

    Raises:
        MienError: one of them cannot be written.
    """
    in_parts = [
        path for path in outputs if path.suffix.lower() == ".gltf"
    ]  # named by its .bin, so written in place, last
    whole = [path for path in outputs if path not in in_parts]
    shown = exactly(result)
    with _written_together([*whole, *([report] if report else [])]) as places:
        if report is not None:
            from mien.job.account import write_report  # pictures and diagrams take a while to load

            write_report(places[report], shown)
        for path in [*whole, *in_parts]:
            if shown is not result and path.suffix.lower() in MESHES and shown.character is not None:
                write_shown(places.get(path, path), shown.clip, shown.character)
                continue
            to = csv_format if path.suffix.lower() == ".csv" else None
            write_clip(places.get(path, path), result.clip, result.character, to=to)


def with_losses(result: Result, outputs: Sequence[Path], csv_format: str) -> Result:
    """Add to the report what the outputs' formats cannot hold."""
    notes = losses(result.clip, outputs, csv_format)
    return replace(result, report=replace(result.report, notes=(*result.report.notes, *notes)))


def losses(clip: Clip, outputs: Sequence[Path], csv_format: str) -> tuple[Note, ...]:
    """Say which channels a Live Link Face file has no column for."""
    if csv_format != "livelink":
        return ()
    left = match(clip.names, ARKIT_NAMES).unmatched_source
    where = [str(path) for path in outputs if path.suffix.lower() == ".csv"]
    if not left or not where:
        return ()
    text = f"{len(left)} channels have no column in a Live Link Face file and are left out: {', '.join(left[:12])}."
    return (Note("channels-left-out", text, where[0]),)


def inputs_of(request: Request) -> list[Path]:
    """Return the files a request reads."""
    landmarks = [path for path in request.landmarks or () if path != OWN]
    optional = (
        *(
            request.actor,
            request.training,
            request.pairs,
            request.examples,
            request.extremes,
            request.correctives,
            request.poses,
        ),
        *landmarks,
    )
    neutral = [Path(request.neutral)] if request.neutral is not None else []
    return [
        request.performance,
        request.character,
        *neutral,
        *request.animations,
        *(path for path in optional if path is not None),
    ]


def _check_apart(paths: Sequence[Path]) -> None:
    places = [path.resolve() for path in paths]
    for i, path in enumerate(paths):
        if places[i] in places[:i]:
            raise FileError(f"{path} is to be written twice; give each output a name of its own.")


@contextmanager
def _written_together(paths: Sequence[Path]) -> Iterator[dict[Path, Path]]:
    """Give a temporary place for each path, put in place when the block succeeds for all."""
    with ExitStack() as stack:
        yield {path: stack.enter_context(written_whole(path)) for path in paths}
