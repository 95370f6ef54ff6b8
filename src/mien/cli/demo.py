"""`mien demo`: the main job on the faces that come with mien."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def demo(
    out: Annotated[Path, typer.Option(help="Folder for the results; made if it does not exist.")] = Path("demo"),
    film: Annotated[bool, typer.Option(help="Also film the result (a few seconds more).")] = True,
    json: Annotated[bool, typer.Option("--json", help="Print the report as JSON.")] = False,
    quiet: Annotated[bool, typer.Option("-q", "--quiet", help="Print nothing but errors.")] = False,
) -> None:
    """Put the built-in actor's capture onto a cartoon, rig a goat, let a globe speak, and say where to look.

    Examples:
      mien demo

      mien demo --out /tmp/demo --no-film
    """
    from mien.cli.say import console, counted, print_json, print_notes, stages
    from mien.core import FileError
    from mien.job import demo as job
    from mien.job import rig
    from mien.job.outputs import write_outputs
    from mien.job.picture import picture
    from mien.job.retarget import run

    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FileError(f"cannot make the folder {out}: {error.strerror}.") from None
    with stages(quiet) as stage:
        stage("building the actor and the character")
        request = job.prepare(out)
        result = run(request, stage)
        stage("write")
        animated, weights, page, sheet = (
            out / name for name in ("animated.glb", "weights.csv", "report.html", "sheet.png")
        )
        write_outputs(result, [animated, weights], report=page)
        picture(animated, sheet)
        stage("rigging a goat")
        bare = job.prepare_goat(out)
        goat, goat_sheet = out / "goat_rigged.glb", out / "goat_rigged.png"
        rig.write(rig.run(bare), goat)
        picture(goat, goat_sheet)
        stage("a sentence on a globe and a radio")
        sentence = job.prepare_sentence(out)
        spoken = [one.character.with_stem(f"{one.character.stem}_speaks") for one in sentence]
        for one, path in zip(sentence, spoken, strict=True):
            write_outputs(run(one), [path])
        together = out / "sentence.png"
        job.picture_together([sentence[0].performance, *spoken], together)
    written = [page, sheet, animated, weights, goat_sheet, goat, together, *spoken]
    if film:
        with counted(quiet, "filming") as progress:
            picture(animated, out / "film.mp4", progress=progress)
        written.insert(2, out / "film.mp4")
    account = result.report.as_json()
    if json:
        print_json(account)
    if json or quiet:
        return
    show = console()
    show.print(f"{len(result.clip)} frames: fit {account['fit']['rms_mm']:.2f} mm, gain {account['gain']:.2f}")
    print_notes(result.report.notes)
    show.print("\nThe same with files of your own:")
    show.print(f"  mien rig builtin {bare.face} -o rigged.glb")
    show.print(f"  mien retarget {request.performance} {request.character} -o out.glb --report out.html\n")
    show.print("Look at:")
    for path in written:
        show.print(f"  {path}")
