"""`mien methods`: what there is to choose from."""

from __future__ import annotations

from typing import Annotated

import typer


def methods(
    name: Annotated[str | None, typer.Argument(help="A method, to see its parameters.")] = None,
    json: Annotated[bool, typer.Option("--json", help="Print as JSON.")] = False,
) -> None:
    """List the retargeting methods, or the parameters of one.

    Examples:
      mien methods

      mien methods range-of-motion
    """
    from rich.table import Table

    from mien.cli.say import console, print_json
    from mien.retargeting import METHODS, make_method, parameters

    if name is not None:
        values = parameters(make_method(name))
        if json:
            print_json({"method": name, "parameters": values})
            return
        table = Table("parameter", "default", title=name, title_justify="left")
        for key, value in values.items():
            table.add_row(key, str(value))
        console().print(table)
        return
    if json:
        print_json([{"name": m.name, "about": m.about, "needs": m.needs} for m in METHODS.values()])
        return
    table = Table("method", "what it does", "what it needs")
    for method in METHODS.values():
        table.add_row(method.name, method.about, method.needs)
    console().print(table)
