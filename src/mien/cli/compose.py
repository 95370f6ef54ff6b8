"""`mien compose`: a character played by edited curves of emotion, speech and blink."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mien.cli import options


def compose(
    character: Annotated[
        Path, typer.Argument(help="A rig whose blendshapes are emotions, visemes and blinks, by name.")
    ],
    curves: Annotated[
        Path, typer.Argument(help="The curves that `mien retarget --layers` wrote, edited or not (.csv).")
    ],
    output: Annotated[
        list[Path],
        typer.Option("-o", "--output", help="Where to write: .glb, .gltf, .csv or .npz; repeat for several."),
    ],
    mask: Annotated[
        list[str] | None, typer.Option(help="A vertex group that is a region of the character; repeat, in order.")
    ] = None,
    split: Annotated[
        bool,
        typer.Option(
            help="Give an animated file a shape per extreme and region beside its own, which plays the curves exactly; "
            "weights (.csv, .npz) are always of its own shapes."
        ),
    ] = True,
    gain: Annotated[
        list[str] | None, typer.Option(help="LAYER=VALUE: how much of a layer the character shows; repeat.")
    ] = None,
    speed: Annotated[float, typer.Option(help="How much faster than the actor the character acts.")] = 1.0,
    lag: Annotated[float, typer.Option(help="How long the character takes to follow [s].")] = 0.0,
    head_gain: Annotated[float, typer.Option(help="How much of the head's turning and moving is shown.")] = 1.0,
    json: options.Json = False,
    quiet: options.Quiet = False,
) -> None:
    """Play a CHARACTER by the CURVES of a performance's layers.

    Examples:
      mien retarget take.c3d hero.glb --method layers --training rom.c3d --extremes rom.csv -o hero_take.glb --layers take.csv

      mien compose globe.glb take.csv --mask body --mask mouths --mask eyes -o globe_take.glb
    """
    from mien.cli.parse import numbers
    from mien.cli.say import console, print_json, print_notes, stages
    from mien.job import compose as job
    from mien.job.outputs import check_outputs
    from mien.retargeting.layers.dynamics import Dynamics

    check_outputs(output, [character, curves])
    with stages(quiet) as stage:
        stage("compose")
        own = Dynamics(numbers(gain or [], "--gain"), lag, speed, head_gain)
        dynamics = own if gain or (speed, lag, head_gain) != (1.0, 0.0, 1.0) else None
        made = job.compose(character, curves, masks=mask or (), split=split, dynamics=dynamics)
        stage("write")
        job.write(made, output)
    if json:
        split_shapes = 0 if made.split is None else len(made.split[1].names)
        account = {
            "frames": len(made.clip),
            "shapes": len(made.clip.names),
            "loss_mm": round(made.loss_mm, 4),
            "split_shapes": split_shapes,
        }
        print_json({**account, "warnings": [vars(note) for note in made.notes]})
    elif not quiet:
        out = console()
        exact = "" if made.split is None else f"; meshes exact, by {len(made.split[1].names)} shapes split by region"
        out.print(
            f"{len(made.clip)} frames, {len(made.clip.names)} shapes, projected to within {made.loss_mm:.2f} mm{exact}"
        )
        print_notes(made.notes)
        for path in output:
            out.print(f"wrote {path}")
