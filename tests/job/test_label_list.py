"""Labels of the calibration list, from files to files."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.accuracy.calibration_take import played
from mien.core import InputError
from mien.evaluate.collection import actor, take
from mien.io.examples import read_examples, write_examples
from mien.job import label, label_list
from mien.job.label import Choice, write
from mien.job.label_list import NAMES, choose_listed, labels_of
from mien.job.request import Request
from mien.job.retarget import run
from mien.vocabularies import ARKIT_NAMES
from mien.vocabularies.calibration import list_weights
from tests.job.small_files import SmallFiles
from tests.retargeting.listed_takes import SMALL_FACE, holds, listed_face, without, write_face, write_take


@pytest.fixture
def listed(files: SmallFiles) -> SmallFiles:
    """A capture of the list and its character, with landmarks beside."""
    write_face(files["hero.glb"], listed_face())
    write_take(files["rom.trc"], listed_face(), conditions=SMALL_FACE)
    return files


@pytest.fixture(autouse=True)
def small_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    for module in (label, label_list):
        monkeypatch.setattr(module, "SIZE", 48)


def chosen(files: SmallFiles, take: str = "rom.trc") -> Choice:
    return choose_listed(files[take], files["hero.glb"], files["labels"])


def entries(choice: Choice) -> list[int]:
    return [NAMES.index(caption) for caption in choice.captions]


def test_the_list_labels_itself(listed: SmallFiles) -> None:
    found = chosen(listed)
    assert entries(found) == list(range(29))
    assert ((holds()[:, 0] <= found.frames) & (found.frames <= holds()[:, 1])).all()
    assert set(found.table.names) == set(ARKIT_NAMES)
    order = [found.table.names.index(name) for name in ARKIT_NAMES]
    assert found.table.values[:, order] == pytest.approx(list_weights())
    written = write(found, listed["labels"])
    assert {path.name for path in written} >= {"labels.csv", "frames.png", f"frame_{found.frames[3]:05d}.png"}
    again = read_examples(listed["labels"] / "labels.csv")
    assert again.frames.tolist() == found.frames.tolist()


def test_such_labels_make_the_weights_better(listed: SmallFiles) -> None:
    write(chosen(listed), listed["labels"])
    plain = Request(listed["rom.trc"], listed["hero.glb"])
    right = played().values
    errors = [
        np.abs(run(request).clip.channels(ARKIT_NAMES) - right)[holds().mean(axis=1).astype(int)].mean()
        for request in (plain, replace(plain, examples=listed["labels"] / "labels.csv"))
    ]
    assert errors[1] < 0.85 * errors[0]


def test_rows_that_a_person_has_corrected_stay(listed: SmallFiles) -> None:
    first = chosen(listed)
    write(first, listed["labels"])
    kept = replace(first.table, frames=first.table.frames[3:5] + 2, values=0.5 * first.table.values[3:5])
    write_examples(listed["labels"] / "labels.csv", kept)
    second = chosen(listed)
    assert entries(second) == [e for e in range(29) if e not in (3, 4)]
    assert second.table.values[:2] == pytest.approx(kept.values)


def test_what_is_not_found_is_named(listed: SmallFiles) -> None:
    write_take(listed["rom.trc"], listed_face(), without(played(), 7), SMALL_FACE)
    found = chosen(listed)
    assert "mouthFunnel" not in found.captions
    assert ["mouthFunnel" in note.message for note in found.notes if note.code == "expressions-not-found"] == [True]


def test_shapes_that_the_list_does_not_know_are_blank() -> None:
    labels = labels_of(("Jaw_Open", "viseme_aa", "mouthSmile", "TongueOut"))
    assert labels[0].tolist() == pytest.approx([1, np.nan, 0, 0], nan_ok=True)
    assert labels[NAMES.index("mouthSmile"), 2] == 1
    assert labels[NAMES.index("mouthSmileLeft"), 2] == 0.5


def test_an_animated_face_may_have_done_the_list(listed: SmallFiles) -> None:
    rig = listed_face()
    write_face(listed["rom.glb"], rig, played())
    assert entries(chosen(listed, "rom.glb")) == list(range(29))


def test_other_takes_are_refused_in_words(listed: SmallFiles) -> None:
    backwards = replace(played(), values=played().values[::-1])
    write_take(listed["rom.trc"], listed_face(), backwards, SMALL_FACE)
    with pytest.raises(InputError, match=r"not look like a take of the list.* at \d+\.\d s.*order.*by hand"):
        chosen(listed)
    with pytest.raises(InputError, match="--actor"):
        chosen(listed, "weights.csv")
    with pytest.raises(InputError, match="give its rig"):
        choose_listed(listed["rom.trc"], listed["m.mien"], listed["labels"])


def test_a_character_with_names_of_its_own_is_refused_in_words(listed: SmallFiles) -> None:
    write_face(listed["hero.glb"], listed_face(tuple(f"slider_{i}" for i in range(52))))
    with pytest.raises(InputError, match=r"only 0 of the 29.*other names than Apple's.*by hand"):
        chosen(listed)


@pytest.mark.real
def test_another_person_does_the_list_for_another_topology(data: Path, tmp_path: Path) -> None:
    person, character = actor(data, "p1"), data / "rigs" / "makehuman_adult.glb"
    write_take(tmp_path / "rom.trc", person)
    found = choose_listed(tmp_path / "rom.trc", character, tmp_path / "labels")
    assert len(found.frames) >= 27
    first, last = holds()[entries(found)].T
    assert ((first <= found.frames) & (found.frames <= last)).all()
    visemes = [i for i, name in enumerate(found.table.names) if name.startswith("viseme")]
    assert np.isnan(found.table.values[:, visemes]).all()


@pytest.mark.real
def test_a_medley_is_not_the_list(data: Path, tmp_path: Path) -> None:
    write_take(tmp_path / "rom.trc", actor(data, "p1"), take(data, "alex_rom_3"))
    with pytest.raises(InputError, match="does not look like a take of the list"):
        choose_listed(tmp_path / "rom.trc", data / "rigs" / "makehuman_adult.glb", tmp_path / "labels")
