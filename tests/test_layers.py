"""Imports go down: the tree stays readable only if nothing reaches up or sideways."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

SOURCE = Path(__file__).resolve().parents[1] / "src" / "mien"

FLOORS = [
    {"core"},
    {"geometry", "solve", "vocabularies"},
    {"rigging"},
    {"capture", "library"},
    {"io"},
    {"retargeting"},
    {"look", "evaluate"},
    {"job"},
    {"cli"},
]
"""From the ground up; a package may import from floors below it and from itself."""
METHODS = {
    *("range_of_motion", "layers", "rbf", "direct", "copying", "latent", "transport", "regression"),
    *("example_based", "spacetime"),
}
"""Methods do not import each other: what two of them share stands beside them in `retargeting`."""


def imports(path: Path) -> list[tuple[int, str]]:
    found = []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("mien"):
            found.append((node.lineno, node.module))
        elif isinstance(node, ast.Import):
            found += [(node.lineno, name.name) for name in node.names if name.name.startswith("mien")]
    return found


def floor_of(package: str) -> int:
    return next(i for i, floor in enumerate(FLOORS) if package in floor)


def test_every_package_has_a_floor() -> None:
    packages = {p.name for p in SOURCE.iterdir() if p.is_dir() and not p.name.startswith("__")}
    assert packages == set().union(*FLOORS)


@pytest.mark.parametrize("path", sorted(SOURCE.glob("*/**/*.py")), ids=lambda p: str(p.relative_to(SOURCE)))
def test_imports_go_down(path: Path) -> None:
    mine = path.relative_to(SOURCE).parts[0]
    for line, module in imports(path):
        other = module.split(".")[1] if "." in module else None
        assert other is not None, f"{path}:{line} imports the package's top; name the module"
        if other != mine:
            assert floor_of(other) < floor_of(mine), f"{path}:{line}: {mine} must not import {other}"


def test_methods_do_not_import_each_other() -> None:
    for path in SOURCE.glob("retargeting/**/*.py"):
        mine = path.relative_to(SOURCE / "retargeting").parts[0].removesuffix(".py")
        for line, module in imports(path):
            parts = module.split(".")
            if mine in METHODS and parts[1] == "retargeting" and len(parts) > 2 and parts[2] in METHODS:
                assert parts[2] == mine, f"{path}:{line}: {mine} must not import {parts[2]}"


def test_only_io_opens_files_and_only_cli_prints() -> None:
    for path in SOURCE.glob("**/*.py"):
        package = path.relative_to(SOURCE).parts[0]
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call):
                name = ast.unparse(node.func)
                assert package == "cli" or name not in ("print", "sys.exit"), f"{path}:{node.lineno} prints"
                assert package == "io" or name != "open", f"{path}:{node.lineno} opens a file"
