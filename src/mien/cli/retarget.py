"""`mien retarget`: the main job."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

Output = Annotated[
    list[Path], typer.Option("-o", "--output", help="Where to write: .glb, .gltf, .csv or .npz; repeat for several.")
]
Set = Annotated[
    list[str] | None,
    typer.Option("--set", help="A parameter of the method, KEY=VALUE; `mien methods NAME` lists them."),
]


def retarget(
    performance: Annotated[
        Path, typer.Argument(help="What the actor did: .c3d .trc markers, .glb animated face, .csv weights.")
    ],
    character: Annotated[
        Path, typer.Argument(help="The rig: .glb, .gltf, or a folder of .obj (neutral + one per shape).")
    ],
    output: Output,
    method: Annotated[str, typer.Option(help="See `mien methods`.")] = "range-of-motion",
    actor: Annotated[Path | None, typer.Option(help="The actor's rig, when the performance is weights.")] = None,
    training: Annotated[
        Path | None, typer.Option(help="The actor's range-of-motion take; the performance itself if not given.")
    ] = None,
    neutral: Annotated[
        str | None, typer.Option(help="The actor's neutral: a frame number or a file; found if not given.")
    ] = None,
    pairs: Annotated[Path | None, typer.Option(help="Which point is which (.pairs.json).")] = None,
    landmarks: Annotated[
        tuple[Path, Path] | None,
        typer.Option(help="Landmarks of actor and character; pairs are made from them.", metavar="SOURCE TARGET"),
    ] = None,
    count: Annotated[int, typer.Option(min=4, help="How many pairs to make from landmarks.")] = 99,
    examples: Annotated[Path | None, typer.Option(help="Frames that show named shapes (.csv, .json).")] = None,
    rigid: Annotated[
        list[str] | None, typer.Option(help="A marker that rides on the skull; repeat for several.")
    ] = None,
    bounds: Annotated[
        tuple[float, float] | None, typer.Option(help="Lowest and highest weight.", metavar="LO HI")
    ] = None,
    smooth: Annotated[
        float | None, typer.Option(help="Resistance to change between frames; a held pose is held.")
    ] = None,
    prior: Annotated[list[str] | None, typer.Option(help="NAME=WEIGHT: geometric (bending) or sparsity.")] = None,
    exclusive: Annotated[list[str] | None, typer.Option(help="A,B: shapes never active together; repeat.")] = None,
    symmetric: Annotated[
        list[str] | None, typer.Option(help="A,B: shapes drawn towards equal weights; repeat.")
    ] = None,
    set_: Set = None,
    head: Annotated[bool, typer.Option(help="Carry the head's motion to the character.")] = True,
    csv_format: Annotated[str, typer.Option(help="weights, or livelink for the Live Link Face layout.")] = "weights",
    report: Annotated[
        Path | None, typer.Option(help="An account of the result: .html to look at, .json to read by script.")
    ] = None,
    json: Annotated[bool, typer.Option("--json", help="Print the report as JSON.")] = False,
    quiet: Annotated[bool, typer.Option("-q", "--quiet", help="Print nothing but errors.")] = False,
) -> None:
    """Put a PERFORMANCE onto a CHARACTER.

    Examples:
      mien retarget take.c3d hero.glb --landmarks take.json hero.json -o hero_take.glb

      mien retarget actor.glb hero.glb --pairs a.pairs.json -o out.glb -o out.csv --report out.html

      mien retarget phone.csv hero.glb --actor me.glb -o out.glb --bounds 0 1
    """
    from mien.cli.parse import assignments, pair_names, prior_weights
    from mien.cli.say import print_json, stages
    from mien.job.outputs import check_outputs, inputs_of, with_losses, write_outputs
    from mien.job.retarget import Request, run

    settings = assignments(set_ or [])
    settings |= prior_weights(prior or [])
    given = {
        "bounds": bounds,
        "smooth": smooth,
        "exclusive": pair_names(exclusive or [], "--exclusive") or None,
        "symmetric": pair_names(symmetric or [], "--symmetric") or None,
    }
    settings |= {key: value for key, value in given.items() if value is not None}
    request = Request(
        performance,
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
        head,
        settings,
    )
    check_outputs(output, inputs_of(request), report=report, csv_format=csv_format)
    with stages(quiet) as stage:
        result = with_losses(run(request, stage), output, csv_format)
        stage("write")
        write_outputs(result, output, csv_format, report)
    if json:
        print_json(result.report.as_json())
    elif not quiet:
        _summary(result, [*output, *([report] if report else [])])


def _summary(result: object, written: list[Path]) -> None:
    from mien.cli.say import console, print_notes
    from mien.job.retarget import Result

    assert isinstance(result, Result)
    account = result.report.as_json()
    out = console()
    out.print(
        f"{len(result.clip)} frames at {result.clip.fps:g} fps, {len(result.clip.names)} shapes, method {account['method']}"
    )
    if account["fit"]["rms_mm"] is not None:
        gain = f", gain {account['gain']:.2f}" if account["gain"] is not None else ""
        out.print(f"fit {account['fit']['rms_mm']:.2f} mm (worst frame {account['fit']['max_mm']:.2f}){gain}")
    if account.get("neutral_frame") is not None:
        out.print(f"the actor's neutral is frame {account['neutral_frame']}")
    print_notes(result.report.notes)
    for path in written:
        out.print(f"wrote {path}")
