"""Names of shapes: one shape under every spelling, split and merged sides."""

from __future__ import annotations

import json
import re
import struct
from pathlib import Path

import numpy as np
import pytest

from mien.core import InputError
from mien.vocabularies import ARKIT, ARKIT_NAMES, arkit_name, match, shape_key
from mien.vocabularies.calibration import EXPRESSIONS, list_weights
from mien.vocabularies.regions import regions_of

SPELLINGS = [
    "eyeBlinkLeft",
    "EyeBlinkLeft",
    "eyeBlink_L",
    "eyeBlink_l",
    "eyeBlinkL",
    "eye_blink_left",
    "EyeBlink.L",
    "L_eyeBlink",
    "left_eye_blink",
    "blendShape1.eyeBlinkLeft",
    "head:blendShape1.eyeBlink_L",
    "Eye Blink Left",
]


def target_names(path: Path) -> list[str]:
    """Read the morph target names of a GLB without the project's own reader."""
    content = path.read_bytes()
    (length,) = struct.unpack_from("<I", content, 12)
    names = json.loads(content[20 : 20 + length])["meshes"][0]["extras"]["targetNames"]
    return [str(name) for name in names]


def test_there_are_52_distinct_arkit_names() -> None:
    assert len(ARKIT_NAMES) == len(set(ARKIT_NAMES)) == 52
    assert len({shape_key(name) for name in ARKIT_NAMES}) == 52


def test_every_left_shape_has_a_right_one() -> None:
    assert {stem for stem, side in ARKIT if side == "Left"} == {stem for stem, side in ARKIT if side == "Right"}


@pytest.mark.parametrize("spelling", SPELLINGS)
def test_every_spelling_is_the_same_shape(spelling: str) -> None:
    assert shape_key(spelling) == ("eyeblink", "L")
    assert arkit_name(spelling) == "eyeBlinkLeft"


@pytest.mark.parametrize("name", ["jawLeft", "JawLeft", "jaw_left", "mouthRight", "tongueLeft"])
def test_moving_to_a_side_is_not_being_on_it(name: str) -> None:
    assert shape_key(name).side == ""


@pytest.mark.parametrize("name", ["", "_", "L", "left", "...", "口あけ", "L_", "a" * 10000])
def test_any_text_has_a_key(name: str) -> None:
    assert isinstance(shape_key(name).stem, str)


def test_a_list_maps_to_itself_by_the_identity() -> None:
    found = match(ARKIT_NAMES, ARKIT_NAMES)
    np.testing.assert_array_equal(found.matrix, np.eye(52))
    assert not found.unmatched_source
    assert not found.unmatched_target


def test_a_merged_target_takes_the_mean_of_both_sides() -> None:
    found = match(["browInnerUp_R", "browInnerUp_L"], ["browInnerUp"])
    np.testing.assert_array_equal(found.matrix, [[0.5, 0.5]])


def test_a_split_target_takes_the_whole_weight_on_each_side() -> None:
    found = match(["cheekPuff"], ["cheekPuff_L", "cheekPuff_R"])
    np.testing.assert_array_equal(found.matrix, [[1], [1]])


def test_an_exact_name_wins_over_another_spelling() -> None:
    found = match(["eyeBlink_L", "eyeBlinkLeft"], ["eyeBlinkLeft"])
    np.testing.assert_array_equal(found.matrix, [[0, 1]])
    assert found.unmatched_source == ("eyeBlink_L",)


def test_nothing_in_common_gives_zeros_and_both_lists() -> None:
    found = match(["a"], ["b", "c"])
    assert found.unmatched_source == ("a",)
    assert found.unmatched_target == ("b", "c")
    assert not found.matrix.any()


def test_applying_equals_the_matrix_product_and_keeps_gaps_apart(rng: np.random.Generator) -> None:
    found = match(["browInnerUp_L", "browInnerUp_R", "jawOpen"], ["browInnerUp", "JawOpen"])
    values = rng.random((4, 3))
    np.testing.assert_allclose(found.apply(values), values @ found.matrix.T)
    values[2, 2] = np.nan
    assert np.isnan(found.apply(values)).tolist() == [[False, False], [False, False], [False, True], [False, False]]


def test_applying_to_other_columns_is_refused() -> None:
    with pytest.raises(InputError, match="2 source shapes"):
        match(["a", "b"], ["a"]).apply(np.zeros((3, 5)))


@pytest.mark.real
def test_ict_drives_all_of_arkit_but_the_tongue(data: Path) -> None:
    ict = target_names(data / "rigs" / "ict_head.glb")
    found = match(ict, ARKIT_NAMES)
    assert found.unmatched_target == ("tongueOut",)
    assert set(found.unmatched_source) == {"PupilDilate_L", "PupilDilate_R", "cheekRaiser_L", "cheekRaiser_R"}
    np.testing.assert_allclose(found.matrix.sum(axis=1), [name != "tongueOut" for name in ARKIT_NAMES])


@pytest.mark.real
def test_arkit_drives_both_halves_of_ict(data: Path) -> None:
    ict = target_names(data / "rigs" / "ict_head.glb")
    found = match(ARKIT_NAMES, ict)
    for name in ("browInnerUp_L", "browInnerUp_R", "cheekPuff_L", "cheekPuff_R"):
        driver = int(np.flatnonzero(found.matrix[ict.index(name)])[0])
        assert ARKIT_NAMES[driver] == name[:-2]
    assert found.unmatched_source == ("tongueOut",)


@pytest.mark.real
def test_makehuman_has_exactly_the_52_and_its_visemes(data: Path) -> None:
    names = target_names(data / "rigs" / "makehuman_adult.glb")
    found = match(names, ARKIT_NAMES)
    assert not found.unmatched_target
    assert all(name.startswith("viseme_") for name in found.unmatched_source)


@pytest.mark.real
def test_the_caricature_is_driven_by_what_it_stands_for(data: Path) -> None:
    truth = json.loads((data / "rigs" / "toon.semantics.json").read_text())
    ict = target_names(data / "rigs" / "ict_face.glb")
    found = match(ict, list(truth))
    for row, drivers in zip(found.matrix, truth.values(), strict=True):
        assert {ict[i] for i in np.flatnonzero(row)} == set(drivers)


def test_names_say_which_region_a_shape_belongs_to() -> None:
    names = ["browDownLeft", "EyeBlink_L", "blink_R", "noseSneerLeft", "cheekSquint_L", "jawOpen", "Eyebrow_Up", "A25"]
    regions = ["brows", "eyes", "eyes", "cheeks", "cheeks", "mouth", "brows", "mouth"]
    assert list(regions_of(names)) == regions


def test_the_calibration_list_is_the_one_that_is_documented() -> None:
    page = (Path(__file__).resolve().parents[1] / "docs" / "calibration-take.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (\d[\d, –]*) \|", page, re.MULTILINE)
    numbers = [int(number) for row in rows for number in re.split(", |–", row)]
    ranges = [list(map(int, row.split("–"))) for row in rows if "–" in row]
    counted = sorted({*numbers, *(n for first, last in ranges for n in range(first, last + 1))})
    assert counted == list(range(1, len(EXPRESSIONS) + 1))
    assert list_weights().shape == (len(EXPRESSIONS), len(ARKIT_NAMES))
    assert (list_weights().max(axis=1) > 0.5).all()
    assert len(np.unique(list_weights(), axis=0)) == len(EXPRESSIONS)
