"""Rigs with correctives: weights in, markers, weights out, and animation that plays anywhere."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mien.core import Blendshapes, FileError, InputError, Rig
from mien.core.correctives import correctives_of
from mien.io.correctives import read_correctives
from mien.retargeting import make_method
from mien.retargeting.saved import packed, unpacked
from tests.retargeting.actors import CENTRES, SHAPES, at_rest, capture, face, pairs_of, points_on, weights

RULES = {
    "jawOpen_smile_L": {"jawOpen": 1.0, "smile_L": 1.0},
    "smiles": {"smile_L": 1.0, "smile_R": 1.0},
    "jawOpen50": {"jawOpen": 0.5},
}
EXACT = {"bounds": (0.0, 1.5), "sparsity": 1e-7, "damping": 0.0, "smooth": 0.0}


def corrected() -> Rig:
    """The small face, with two combinations and an in-between."""
    rig = face()
    near = np.linalg.norm(rig.neutral.vertices[None, :, :2] - CENTRES[[1, 0, 0], None] * [[[0.7, 0.9]]], axis=2)
    pushes = np.array([[0.002, -0.004, 0.003], [0.0, 0.003, 0.002], [0, 0.001, 0.004]])
    names = (*SHAPES, *RULES)
    deltas = np.concatenate([rig.blendshapes.deltas, np.exp(-((near / 0.02) ** 2))[..., None] * pushes[:, None]])
    return replace(rig, blendshapes=Blendshapes(names, deltas), correctives=correctives_of(RULES, names))


def acted(rig: Rig) -> np.ndarray:
    assert rig.correctives is not None
    return rig.correctives.complete(np.pad(weights(), ((0, 0), (0, len(RULES)))))


@pytest.mark.parametrize("method", ["rbf", "range-of-motion", "example-based"])
def test_weights_come_back_and_the_clip_holds_those_of_the_correctives(method: str) -> None:
    rig = corrected()
    values, points = acted(rig), points_on(rig)
    take = capture(rig, values, points)
    known = {"neutral": at_rest(rig, points), "head_moves": False}
    clip, report = make_method(method, EXACT).fit(rig, take, pairs_of(points), **known).retarget(take)
    assert clip.names == rig.blendshapes.names
    assert np.abs(clip.values - values).max() < (2e-3 if method == "rbf" else 0.15)
    np.testing.assert_array_equal(rig.correctives.complete(clip.values), clip.values)  # type: ignore[union-attr]
    np.testing.assert_allclose(replace(rig, correctives=None).pose(clip.values), rig.pose(clip.values), atol=1e-15)
    assert report.gain == pytest.approx(1, abs=2e-3)


def test_a_solve_of_whole_clips_refuses_them_in_words() -> None:
    rig = corrected()
    take = capture(rig, acted(rig), points_on(rig))
    with pytest.raises(InputError, match=r"has correctives.*use the method 'range-of-motion'"):
        make_method("spacetime").fit(rig, take, pairs_of(points_on(rig)), head_moves=False)


def test_a_model_keeps_its_correctives_and_a_damaged_one_is_refused() -> None:
    rig = corrected()
    take = capture(rig, acted(rig), points_on(rig))
    fitted = make_method("rbf").fit(rig, take, pairs_of(points_on(rig)), head_moves=False)
    header, arrays = packed(fitted)
    again = unpacked(json.loads(json.dumps(header)), arrays)
    np.testing.assert_array_equal(again.retarget(take)[0].values, fitted.retarget(take)[0].values)
    with pytest.raises(InputError, match="garbles"):
        unpacked(header, {**arrays, "corrective_shapes": np.array([6, 7, 99])})


def test_pairs_that_exclude_each_other_are_refused_beside_correctives() -> None:
    rig = corrected()
    take = capture(rig, acted(rig), points_on(rig))
    with pytest.raises(InputError, match="exclusive pairs"):
        make_method("rbf", {"exclusive": (("smile_L", "smile_R"),)}).fit(rig, take, pairs_of(points_on(rig)))


def test_rules_are_read_from_their_file(tmp_path: Path) -> None:
    path, names = tmp_path / "rules.json", (*SHAPES, *RULES)
    path.write_text(json.dumps({"format": "mien-correctives", "version": 1, "correctives": RULES}))
    read, made = read_correctives(path, names), correctives_of(RULES, names)
    for name in ("shapes", "drivers", "at"):
        np.testing.assert_array_equal(getattr(read, name), getattr(made, name))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("{", "not valid JSON"),
        ('{"correctives": {}}', "names no correctives"),
        ('{"correctives": []}', "names no correctives"),
        ('{"correctives": {"smiles": ["smile_L"]}}', "needs its drivers"),
        ('{"correctives": {"smiles": {"smile_L": "1"}}}', "needs its drivers"),
        ('{"correctives": {"smiles": {"smile_L": true}}}', "needs its drivers"),
        ('{"correctives": {"smiles": {"smile_L": 1, "smil_R": 1}}}', "Did you mean 'smile_R'"),
        ('{"correctives": {"smiles": {"smile_L": NaN}}}', "above 0"),
        ('{"format": "mien-pairs", "correctives": {}}', "mien-pairs"),
    ],
)
def test_a_bad_file_of_rules_is_refused_with_its_name(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "rules.json"
    path.write_text(text)
    with pytest.raises(FileError, match=said) as error:
        read_correctives(path, (*SHAPES, *RULES))
    assert str(path) in str(error.value)
