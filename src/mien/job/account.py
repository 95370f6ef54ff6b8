"""The account of a retargeting, for a person to look at or a script to read."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from mien.core import FileError, Rig
from mien.core.arrays import Floats
from mien.io.files import written_whole
from mien.job.likeness import actor_pictures, reading_of
from mien.job.outputs import REPORTS
from mien.job.request import Result
from mien.look import plots
from mien.look.page import Figure, Notes, Section, Table, page
from mien.look.portrait import Portrait
from mien.look.sheet import Labelled, Row, png, sheet, telling_frames
from mien.retargeting.shape_retargeter import ShapeRetargeter

SHOWN_FRAMES = 8
SHOWN_SHAPES = 8


def write_report(path: Path, result: Result) -> None:
    """Write the report as `.json` or as a page `.html`.

    Raises:
        FileError: another suffix, or the file cannot be written.
    """
    suffix = path.suffix.lower()
    if suffix == ".json":
        content = json.dumps(result.report.as_json(), indent=1, ensure_ascii=False)
    elif suffix in REPORTS:
        content = page(f"{result.performance.path.name} → {_name(result)}", sections(result))
    else:
        raise FileError(f"cannot write {path}: a report is written to {', '.join(REPORTS)}.")
    with written_whole(path) as temporary:
        temporary.write_text(content, encoding="utf-8")


def sections(result: Result) -> list[Section]:
    """Return what the page shows, from the overview to the details."""
    found: list[Section] = [_overview(result), Notes(result.report.notes, "What was repaired, left out or doubtful")]
    if result.character is not None:
        found.append(side_by_side(result, result.character))
    if isinstance(result.retargeter, ShapeRetargeter):
        found += _curves(result)
        found += _alignment(result.retargeter, result)
    else:
        found.append(
            Figure(plots.as_svg(plots.weight_curves(result.clip)), "The most active shapes.", "Weights over time")
        )
    return found


def _name(result: Result) -> str:
    return result.character.name if result.character is not None else "parameters"


def side_by_side(result: Result, rig: Rig) -> Figure:
    """Picture actor and character at the take's most telling frames."""
    frames = telling_frames(result.clip.values, SHOWN_FRAMES)
    sitter = Portrait.of(rig, size=(300, 300))
    values, joints = result.clip.channels(rig.blendshapes.names), result.clip.joints
    character = [sitter.picture(values[f], joints=None if joints is None else joints[f]) for f in frames]
    actor = actor_pictures(result.performance, result.markers, reading_of(result.retargeter), frames)
    labels = [f"frame {f} · {f / result.clip.fps:.2f} s" for f in frames]
    rows = []
    for begin in range(0, len(frames), 4):
        part = slice(begin, begin + 4)
        if actor:
            rows.append(Row("actor", tuple(Labelled(p) for p in actor[part])))
        cells = tuple(Labelled(p, text) for p, text in zip(character[part], labels[part], strict=True))
        rows.append(Row(rig.name if len(rig.name) < 18 else "character", cells))
    caption = (
        "Actor above, character below, at the most different frames of the take. Head motion is taken out of both."
    )
    return Figure(png(sheet(rows)), caption, "Side by side")


def _overview(result: Result) -> Table:
    account = result.report.as_json()
    rows: list[tuple[str, str]] = [
        ("performance", str(result.performance.path)),
        (
            "character",
            str(result.character.source if result.character is not None and result.character.source else _name(result)),
        ),
        ("method", result.report.method),
        ("frames", f"{len(result.clip)} at {result.clip.fps:g} per second"),
    ]
    if result.pairs is not None:
        rows.append(("pairs", str(len(result.pairs))))
    if account["fit"]["rms_mm"] is not None:
        rows.append(
            (
                "fit",
                f"{account['fit']['rms_mm']:.2f} mm root mean square, worst frame {account['fit']['max_mm']:.2f} mm",
            )
        )
    if account["gain"] is not None:
        rows.append(("gain", f"{account['gain']:.3f} (fitted movement over the actor's; 1 is right)"))
    if account.get("neutral_frame") is not None:
        rows.append(("neutral", f"frame {account['neutral_frame']}"))
    rows += [(f"time, {stage}", f"{seconds:.2f} s") for stage, seconds in account["timing_s"].items()]
    return Table(("what", "value"), rows, "Lengths are on a human-sized face.", "In short")


def _curves(result: Result) -> list[Section]:
    largest = result.report.figures.get("largest_weight", {})
    return [
        Figure(plots.as_svg(plots.weight_curves(result.clip)), "The most active shapes.", "Weights over time"),
        Figure(
            plots.as_svg(plots.fit_error(result.report.fit_mm, result.clip.fps)),
            "How far the fitted points are from the actor's, per frame.",
            "Fit",
        ),
        Figure(
            plots.as_svg(plots.bars(largest, "99th percentile of the weight", right=1.0)),
            "How far each shape goes in this take. A shape far below 1 was not asked to its full range, or acts too weakly.",
            "Range used",
        ),
    ]


def _alignment(retargeter: ShapeRetargeter, result: Result) -> list[Section]:
    found: list[Section] = []
    if retargeter.evidence:
        caption = (
            "The best correlation of each shape with a frame of the training take. Shapes near 0 were never shown."
        )
        found.append(
            Figure(plots.as_svg(plots.bars(retargeter.evidence, "best similarity in the take")), caption, "Evidence")
        )
    alignment = retargeter.alignment
    if alignment is None:
        return found
    order = np.argsort(-alignment.similarity.trust, kind="stable")
    names = [retargeter.names[k] for k in order]
    keys = alignment.keys
    fps = result.clip.fps
    found += [
        Figure(
            plots.as_svg(plots.similarity_matrix(alignment.similarity.enhanced[order], names, keys.frames, fps)),
            "Similarity of each shape to each frame of the training take, most trusted shapes first, key expressions marked "
            "(Ribera et al. 2017, figure 7).",
            "Similarity",
        ),
        Figure(
            plots.as_svg(plots.cumulative_correlation(keys.cumulative, keys.frames, fps)),
            f"Summed similarity; its {len(keys.frames)} peaks are the key expressions (figure 8).",
            "Key expressions",
        ),
        _personalised(retargeter, alignment.original, alignment.guess),
    ]
    return found


def _personalised(retargeter: ShapeRetargeter, original: Floats, guess: Floats) -> Figure:
    turn = retargeter.placement.rotation.T
    size = np.linalg.norm(original, axis=(1, 2))
    chosen = np.argsort(-size)[:SHOWN_SHAPES]
    neutral = retargeter.neutral / retargeter.centimetre @ turn / 100
    views = [shapes[chosen] @ turn / 100 for shapes in (original, guess, retargeter.shapes)]
    names = [retargeter.names[k] for k in chosen]
    figure = plots.sparse_blendshapes(neutral, names, views[0], views[1], views[2])
    return Figure(
        plots.as_svg(figure),
        "The character's shape, its warp onto the actor, and the actor's own shape found by the method (figure 17).",
        "The actor's own blendshapes",
    )
