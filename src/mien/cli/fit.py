"""`mien fit`: learn once, use often."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mien.cli import options


def fit(
    training: options.PerformanceFile,
    character: Annotated[Path, typer.Argument(help="The rig: .glb, .gltf, a folder of .obj; or a .csv of parameters.")],
    output: Annotated[Path, typer.Option("-o", "--output", help="Where to write the model (.mien).")],
    method: options.Method = "range-of-motion",
    actor: options.Actor = None,
    neutral: options.Neutral = None,
    pairs: options.Pairs = None,
    landmarks: options.Landmarks = None,
    count: options.Count = 99,
    examples: options.Examples = None,
    animation: options.Animation = None,
    extremes: options.Extremes = None,
    correctives: options.Correctives = None,
    targets: options.Targets = None,
    poses: options.Poses = None,
    rigid: options.Rigid = None,
    prior: options.Prior = None,
    contact: options.Contact = None,
    set_: options.Set = None,
    json: options.Json = False,
    quiet: options.Quiet = False,
) -> None:
    """Fit a method to an actor's range-of-motion take and a CHARACTER, for many takes to come.

    Examples:
      mien fit rom.c3d hero.glb --landmarks rom.json hero.json -o hero.mien

      mien retarget take.c3d hero.mien -o take.glb

      mien fit take.c3d hero.glb --method latent --examples labels.csv --animation walk.glb -o hero.mien
    """
    from mien.cli.parse import settings_of
    from mien.cli.say import console, print_json, print_notes, stages
    from mien.job.model import SUFFIX, save_model
    from mien.job.outputs import check_place, inputs_of
    from mien.job.request import Request
    from mien.job.retarget import fit

    request = Request(
        training,
        character,
        method,
        actor,
        training,
        neutral,
        pairs,
        landmarks,
        count,
        examples,
        tuple(rigid or ()),
        settings=settings_of(set_, prior, contact=contact),
        extremes=extremes,
        animations=tuple(animation or ()),
        correctives=correctives,
        targets=targets,
        poses=poses,
    )
    check_place(output, inputs_of(request), [SUFFIX], "a fitted model")
    with stages(quiet) as stage:
        fitted = fit(request, stage)
        save_model(output, fitted)
    notes = (*fitted.notes, *fitted.retargeter.notes)
    if json:
        print_json({"model": str(output), "method": method, "warnings": [vars(note) for note in notes]})
    elif not quiet:
        console().print(f"method {method}, {len(fitted.retargeter.names)} parameters\nwrote {output}")
        print_notes(notes)
