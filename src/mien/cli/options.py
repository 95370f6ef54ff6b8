"""Options that several commands share, said once."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

PerformanceFile = Annotated[
    Path, typer.Argument(help="What the actor did: .c3d .trc markers, .glb animated face, .csv weights.")
]
Method = Annotated[str, typer.Option(help="See `mien methods`; auto chooses by what is given, and says why.")]
Actor = Annotated[Path | None, typer.Option(help="The actor's rig, when the performance is weights.")]
Neutral = Annotated[str | None, typer.Option(help="The actor's neutral: a frame number or a file; found if not given.")]
Pairs = Annotated[Path | None, typer.Option(help="Which point is which (.pairs.json).")]
Landmarks = Annotated[
    tuple[Path, Path] | None,
    typer.Option(
        help="Landmarks of actor and character, - for a side's own; pairs are made from them.", metavar="SOURCE TARGET"
    ),
]
Count = Annotated[int, typer.Option(min=4, help="How many pairs to make from landmarks.")]
Examples = Annotated[
    Path | None,
    typer.Option(help="Labelled frames of the training take: frame, and a column per parameter (.csv, .json)."),
]
Animation = Annotated[
    list[Path] | None,
    typer.Option(help="For latent: existing animation of the character, to learn its poses from; repeat for several."),
]
Extremes = Annotated[
    Path | None,
    typer.Option(help="For layers: which frame of the training take shows which extreme (.csv: layer,extreme,frame)."),
]
Targets = Annotated[
    str | None,
    typer.Option(help="What is driven: shapes or bones. Bones only if it has no shapes, unless said.", metavar="WHAT"),
]
Poses = Annotated[
    Path | None,
    typer.Option(help="Named poses of the character's bones: a .glb with an animation each, or a .json with its .bvh."),
]
Rigid = Annotated[list[str] | None, typer.Option(help="A marker that rides on the skull; repeat for several.")]
Correctives = Annotated[
    Path | None,
    typer.Option(help="Which shapes follow from others: combinations and in-betweens (.json); they are solved for."),
]
Prior = Annotated[
    list[str] | None,
    typer.Option(
        help="NAME or NAME=WEIGHT: what makes a face likely (geometric, l2, elastic-net, pca, none), or sparsity=WEIGHT."
    ),
]
Contact = Annotated[
    float | None,
    typer.Option(help="How far lids and lips close where the actor's do, 0 to 1 (all the way). Needs iBUG landmarks."),
]
Set = Annotated[
    list[str] | None,
    typer.Option("--set", help="A parameter of the method, KEY=VALUE; `mien methods NAME` lists them."),
]
Json = Annotated[bool, typer.Option("--json", help="Print the result as JSON.")]
Quiet = Annotated[bool, typer.Option("-q", "--quiet", help="Print nothing but errors.")]
