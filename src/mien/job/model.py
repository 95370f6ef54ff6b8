"""Fitted methods as `.mien` files: learn once, use often."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from mien.core import Correspondence, FileError, InputError, Rig, SurfacePoints
from mien.io.archive import read_archive, write_archive
from mien.io.formats import read_rig
from mien.job.bones import Driven, packed_bones, unpacked_bones
from mien.job.labelled import bones_of
from mien.job.performance import load_performance
from mien.job.request import MODEL, Fitted, Request, Result
from mien.job.retarget import play
from mien.job.stages import Progress, stopwatch
from mien.retargeting.saved import packed, unpacked

FORMAT, VERSION = "mien-model", 1
SUFFIX = MODEL


def save_model(path: Path, fitted: Fitted) -> None:
    """Write a fitted method; the character itself is not in the file, only where it is.

    Raises:
        FileError: another suffix, or the file cannot be written.
    """
    if path.suffix.lower() != SUFFIX:
        raise FileError(f"cannot write {path}: a fitted model is written to {SUFFIX}.")
    header, arrays = packed(fitted.retargeter)
    source = fitted.character.source if fitted.character is not None else None
    header |= {"format": FORMAT, "version": VERSION, "character": str(source.resolve()) if source else None}
    header["parameters_alone"] = fitted.character is None
    if fitted.bones is not None:
        own, more = packed_bones(fitted.bones)
        header, arrays = header | own, arrays | more
    pairs = fitted.pairs
    if pairs is not None:
        header["pairs"] = pairs.names
        arrays |= {"target_corners": pairs.target.corners, "target_weights": pairs.target.weights}
        if pairs.source is not None:
            arrays |= {"source_corners": pairs.source.corners, "source_weights": pairs.source.weights}
    write_archive(path, header, arrays)


def load_model(path: Path, character: Path | None = None) -> Fitted:
    """Read a fitted method and the character it is for.

    Args:
        path: a `.mien` file.
        character: where the character is, if no longer where it was.

    Raises:
        FileError: the file is damaged, or the character is not there.
        InputError: the character has other shapes than the one the method was fitted to.
    """
    header, arrays = read_archive(path, FORMAT, VERSION)
    alone = header.get("parameters_alone") is True and character is None
    place = character or (Path(header["character"]) if isinstance(header.get("character"), str) else None)
    if not alone and (place is None or not place.exists()):
        raise FileError(f"the character that {path} was fitted to is not at {place}; say where it is with --character.")
    rig = None if alone or place is None else read_rig(place)
    try:
        retargeter = unpacked(header, arrays)
        pairs = _pairs(header, arrays)
        bones = unpacked_bones(header, arrays, rig)
    except (InputError, KeyError, TypeError) as error:
        raise FileError(f"{path}: {error}") from None
    if bones is not None and rig is not None:
        retargeter = Driven(rig, bones).solved(retargeter, pairs)
    elif rig is not None:
        _check_shapes(retargeter.names, rig, path)
    return Fitted(retargeter, rig, pairs, bones=bones)


def replay(request: Request, character: Path | None = None, progress: Progress = lambda stage: None) -> Result:
    """Map the performance of a request whose character is a fitted model.

    Raises:
        InputError: the request also says how to fit, which a fitted model no longer does.
        FileError: a file is missing or damaged.
    """
    plain = Request(request.performance, request.character, actor=request.actor, head=request.head)
    if request != plain:
        raise InputError(
            f"{request.character} is fitted already: the method, its parameters, pairs, landmarks, training and neutral are "
            "settled in it. Leave these options out, or fit again with `mien fit`."
        )
    timing: dict[str, float] = {}
    stage = stopwatch(timing, progress)
    with stage("read"):
        fitted = load_model(request.character, character)
        performance = load_performance(request.performance, request.actor)
    return play(fitted, performance, stage, timing, head=request.head)


def _pairs(header: dict[str, Any], arrays: dict[str, Any]) -> Correspondence | None:
    if "pairs" not in header:
        return None
    source = None
    if "source_corners" in arrays:
        source = SurfacePoints(arrays["source_corners"], arrays["source_weights"])
    target = SurfacePoints(arrays["target_corners"], arrays["target_weights"])
    return Correspondence(tuple(header["pairs"]), target, source)


def _check_shapes(names: tuple[str, ...], rig: Rig, path: Path) -> None:
    known = {*rig.blendshapes.names, *bones_of(rig)}
    missing = [name for name in names if name not in known]
    if missing:
        raise InputError(
            f"{path} drives {len(names)} shapes, but {rig.name} lacks {len(missing)} of them ({', '.join(missing[:5])}); "
            "it was fitted to another character. Fit it again, or name the right one with --character."
        )
