"""The documentation is executed, so that it stays true."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest
from typer.testing import CliRunner

from mien.cli.app import app
from mien.retargeting import METHODS
from tests.conftest import ROOT

PAGES = sorted([ROOT / "README.md", ROOT / "CONTRIBUTING.md", *ROOT.glob("docs/*.md")])
README = (ROOT / "README.md").read_text(encoding="utf-8")


def blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", README, flags=re.DOTALL | re.MULTILINE)


def mien(line: str) -> str:
    done = CliRunner().invoke(app, shlex.split(line)[1:])
    assert done.exit_code == 0, f"{line}\n{done.output}\n{done.exception}"
    return done.output


@pytest.fixture(scope="module")
def demo(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("readme")
    mien(f"mien demo --quiet --no-film --out {folder / 'demo'}")
    return folder


def test_the_commands_of_the_readme_run_in_order(demo: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(demo)
    lines = [line for block in blocks("sh") for line in block.splitlines() if line.startswith("mien ")]
    assert len(lines) >= 4
    for line in lines:
        mien(line)
    for name in ("out.glb", "out.csv", "out.html", "out.png", "pairs.json"):
        assert (demo / "demo" / name).stat().st_size > 1000


def test_the_python_of_the_readme_runs(demo: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(demo)
    if not (demo / "demo" / "pairs.json").exists():
        mien("mien pairs demo/capture.trc demo/character.glb -o demo/pairs.json -q")
    (code,) = blocks("python")
    exec(compile(code, "README.md", "exec"), {})
    assert (demo / "demo" / "python.glb").stat().st_size > 1000


def test_the_readme_lists_every_method() -> None:
    listed = re.findall(r"^\| `([a-z-]+)` \|", README, flags=re.MULTILINE)
    assert listed == list(METHODS)


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.name)
def test_links_lead_somewhere(page: Path) -> None:
    for link in re.findall(r"\]\(([^)#]+)\)", page.read_text(encoding="utf-8")):
        if "://" not in link:
            assert (page.parent / link).exists(), f"{page.name} links to {link}"


def test_make_targets_of_the_readme_exist() -> None:
    targets = set(re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), flags=re.MULTILINE))
    assert {
        line.split()[1] for block in blocks("sh") for line in block.splitlines() if line.startswith("make ")
    } <= targets
