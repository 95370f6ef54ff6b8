"""`mien label --list`: the command says what it recognised, and what it cannot use."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.accuracy.calibration_take import played
from mien.io.examples import read_examples
from tests.cli.running import mien
from tests.retargeting.listed_takes import SMALL_FACE, listed_face, without, write_face, write_take


@pytest.fixture
def words(tmp_path: Path) -> tuple[object, ...]:
    """The command on a take in which the kiss is left out."""
    write_take(tmp_path / "rom.trc", listed_face(), without(played(), 6), SMALL_FACE)
    hero = write_face(tmp_path / "hero.glb", listed_face())
    return ("label", tmp_path / "rom.trc", hero, "-o", tmp_path / "labels", "--list")


def test_the_command_says_what_it_recognised(words: tuple[object, ...], tmp_path: Path) -> None:
    done = mien(*words)
    assert done.code == 0
    said = " ".join(done.out.split())
    table = read_examples(tmp_path / "labels" / "labels.csv")
    assert len(table.frames) == 28
    assert f"28 frames recognised: {table.frames[0]} jawOpen, {table.frames[1]} jawLeft" in said
    assert "1 of 29 expressions of the list were not recognised and have no label: mouthPucker" in done.err
    again = json.loads(mien(*words, "--json").out)
    assert (again["frames"], again["captions"]) == ([], [])
    assert len(read_examples(tmp_path / "labels" / "labels.csv").frames) == 28


def test_a_take_of_something_else_is_refused_in_words(words: tuple[object, ...], tmp_path: Path) -> None:
    backwards = replace(played(), values=played().values[::-1])
    write_take(tmp_path / "rom.trc", listed_face(), backwards, SMALL_FACE)
    done = mien(*words)
    assert done.code == 1
    assert "does not look like a take of the list" in " ".join(done.err.split())
    assert not (tmp_path / "labels").exists()


def test_pairs_are_for_the_list_alone(words: tuple[object, ...]) -> None:
    done = mien(*words[:-1], "--landmarks", "-", "-")
    assert done.code == 1
    assert "are for --list" in " ".join(done.err.split())
