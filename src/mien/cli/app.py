"""The command `mien`: its subcommands, and how errors leave it."""

from __future__ import annotations

import os
import sys

import typer

from mien.cli import (
    bench,
    compose,
    convert,
    demo,
    evaluate,
    fit,
    inspect,
    label,
    methods,
    pairs,
    pose,
    render,
    retarget,
    rig,
    suggest,
)
from mien.core.errors import MienError

app = typer.Typer(
    name="mien",
    help="Put an actor's facial performance onto any character.",
    no_args_is_help=True,
    rich_markup_mode="rich",
    add_completion=False,
    pretty_exceptions_enable=False,
)

for command in (
    retarget.retarget,
    fit.fit,
    rig.rig,
    compose.compose,
    pairs.pairs,
    inspect.inspect,
    convert.convert,
    evaluate.evaluate,
    render.render,
    pose.pose,
    suggest.suggest,
    label.label,
    methods.methods,
    demo.demo,
    bench.bench,
):
    app.command()(command)


@app.callback()
def options(debug: bool = typer.Option(False, "--debug", help="Show the traceback of an error.")) -> None:
    """Put an actor's facial performance onto any character."""
    if debug:
        os.environ["MIEN_DEBUG"] = "1"


def main() -> None:
    """Run the command line; a user's error is one paragraph and exit code 1."""
    try:
        app()
    except MienError as error:
        if os.environ.get("MIEN_DEBUG"):
            raise
        print(f"mien: {error}", file=sys.stderr)
        sys.exit(1)
    except KeyboardInterrupt:
        print("mien: stopped; nothing was written.", file=sys.stderr)
        sys.exit(130)
    except BrokenPipeError:
        sys.exit(0)
