"""`mien retarget`: the main job."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from mien.cli import options

if TYPE_CHECKING:
    from mien.job.request import Request, Result

Output = Annotated[
    list[Path], typer.Option("-o", "--output", help="Where to write: .glb, .gltf, .csv or .npz; repeat for several.")
]


def retarget(
    performance: options.PerformanceFile,
    character: Annotated[
        Path,
        typer.Argument(
            help="The rig: .glb, .gltf, a folder of .obj; a model that `mien fit` made (.mien); or a .csv of parameters."
        ),
    ],
    output: Output,
    method: options.Method = "range-of-motion",
    actor: options.Actor = None,
    training: Annotated[
        Path | None, typer.Option(help="The actor's range-of-motion take; full becomes full on the character.")
    ] = None,
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
    bounds: Annotated[
        tuple[float, float] | None, typer.Option(help="Lowest and highest weight.", metavar="LO HI")
    ] = None,
    smooth: Annotated[
        float | None, typer.Option(help="Resistance to change between frames; a held pose is held.")
    ] = None,
    prior: options.Prior = None,
    contact: options.Contact = None,
    exclusive: Annotated[list[str] | None, typer.Option(help="A,B: shapes never active together; repeat.")] = None,
    symmetric: Annotated[
        list[str] | None, typer.Option(help="A,B: shapes drawn towards equal weights; repeat.")
    ] = None,
    set_: options.Set = None,
    head: Annotated[bool, typer.Option(help="Carry the head's motion to the character.")] = True,
    csv_format: Annotated[str, typer.Option(help="weights, or livelink for the Live Link Face layout.")] = "weights",
    report: Annotated[
        Path | None, typer.Option(help="An account of the result: .html to look at, .json to read by script.")
    ] = None,
    layers: Annotated[
        Path | None,
        typer.Option(help="With --method layers: the curves of the layers (.csv), to edit and `mien compose`."),
    ] = None,
    onto: Annotated[
        Path | None, typer.Option("--character", help="With a model: where its character is now, if it has moved.")
    ] = None,
    json: options.Json = False,
    quiet: options.Quiet = False,
) -> None:
    """Put a PERFORMANCE onto a CHARACTER.

    Examples:
      mien retarget take.c3d hero.glb --landmarks take.json hero.json -o hero_take.glb

      mien retarget actor.glb hero.glb --pairs a.pairs.json -o out.glb -o out.csv --report out.html

      mien retarget phone.csv hero.glb --actor me.glb -o out.glb --bounds 0 1

      mien retarget take.c3d globe.glb --method layers --training rom.c3d --extremes rom.csv -o out.glb

      mien retarget take.c3d hero.glb --method latent --examples labels.csv -o out.glb

      mien fit rom.c3d hero.glb -o hero.mien && mien retarget take.c3d hero.mien -o out.glb
    """
    from mien.cli.parse import settings_of
    from mien.cli.say import print_json
    from mien.job.request import Request

    settings = settings_of(
        set_, prior, exclusive=exclusive, symmetric=symmetric, bounds=bounds, smooth=smooth, contact=contact
    )
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
        extremes,
        tuple(animation or ()),
        correctives,
        targets,
        poses,
    )
    result = _carried_out(request, onto, Written(tuple(output), csv_format, report, layers), quiet)
    if json:
        print_json(result.report.as_json())
    elif not quiet:
        _summary(result, [*output, *(path for path in (report, layers) if path is not None)])


@dataclass(frozen=True)
class Written:
    """What is to be written.

    Attributes:
        outputs: the animation.
        csv_format: the layout of those that are `.csv`.
        report: the account of it.
        layers: the curves of the layers.
    """

    outputs: tuple[Path, ...]
    csv_format: str
    report: Path | None
    layers: Path | None


def _carried_out(request: Request, onto: Path | None, written: Written, quiet: bool) -> Result:
    """Refuse what could not be written, do the job, write."""
    from mien.cli.say import stages
    from mien.job.outputs import check_outputs, check_place, inputs_of, with_losses, write_outputs

    given = [*inputs_of(request), *([onto] if onto else [])]
    check_outputs(written.outputs, given, report=written.report, csv_format=written.csv_format)
    if written.layers is not None:
        check_place(written.layers, [*given, *written.outputs], (".csv",), "the curves of layers")
    with stages(quiet) as stage:
        result = with_losses(_mapped(request, onto, stage), written.outputs, written.csv_format)
        stage("write")
        write_outputs(result, written.outputs, written.csv_format, written.report)
        if written.layers is not None:
            from mien.job.compose import write_layers

            write_layers(written.layers, result)
    return result


def _mapped(request: Request, onto: Path | None, stage: Callable[[str], None]) -> Result:
    """Map the performance, with a method that is fitted first unless the character is a fitted model."""
    from mien.job.request import MODEL

    if request.character.suffix.lower() == MODEL:
        from mien.job.model import replay  # what fits one method need not load all that can be saved

        return replay(request, onto, stage)
    from mien.job import retarget

    return retarget.run(request, stage)


def _summary(result: Result, written: list[Path]) -> None:
    from mien.cli.say import console, print_notes

    account = result.report.as_json()
    out = console()
    out.print(
        f"{len(result.clip)} frames at {result.clip.fps:g} fps, {len(result.clip.names)} parameters, method {account['method']}"
    )
    if account["fit"]["rms_mm"] is not None:
        gain = f", gain {account['gain']:.2f}" if account["gain"] is not None else ""
        out.print(f"fit {account['fit']['rms_mm']:.2f} mm (worst frame {account['fit']['max_mm']:.2f}){gain}")
    if account.get("neutral_frame") is not None:
        out.print(f"the actor's neutral is frame {account['neutral_frame']}")
    print_notes(result.report.notes)
    for path in written:
        out.print(f"wrote {path}")
