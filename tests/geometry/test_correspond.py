from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mien.core import Correspondence, Rig
from mien.io.documents import join
from mien.io.formats import read_rig
from mien.job.pairs import find_pairs, rig_landmarks
from mien.job.performance import Performance

HEADS = [
    ("makehuman_adult", "ict_face"),
    ("ict_face", "makehuman_adult"),
    ("makehuman_adult", "makehuman_child"),
    ("makehuman_adult", "toon"),
    ("ict_head", "aura"),
    ("toon", "makehuman_child"),
]
JAW = {"aura": "jawDrop"}
BLINK = {
    "makehuman_adult": "eyeBlinkLeft",
    "makehuman_child": "eyeBlinkLeft",
    "aura": "eyesClosed_L",
}


def paired(data: Path, source: str, target: str, count: int = 99) -> tuple[Rig, Rig, Correspondence]:
    actor, character = (read_rig(data / "rigs" / f"{name}.glb") for name in (source, target))
    pairs, _ = find_pairs(Performance(Path(source), actor=actor), character, count=count)
    return actor, character, pairs


def movement(rig: Rig, points: object, shape: str) -> np.ndarray:
    moved = np.linalg.norm(points.of(rig.blendshapes.deltas[rig.blendshapes.index(shape)]), axis=1)  # type: ignore[attr-defined]
    return moved / moved.max()


@pytest.mark.real
@pytest.mark.parametrize(("source", "target"), HEADS)
def test_no_pair_takes_one_lip_or_lid_for_the_other(data: Path, source: str, target: str) -> None:
    """A lower-lip point rides on the jaw and an upper-lid point on the blink; the wrong side would not."""
    actor, character, pairs = paired(data, source, target)
    assert len(pairs) >= 95
    for shapes in (JAW, BLINK):
        default = "jawOpen" if shapes is JAW else "eyeBlink_L"
        mine = movement(actor, pairs.source, shapes.get(source, default))
        theirs = movement(character, pairs.target, shapes.get(target, default))
        assert np.corrcoef(mine, theirs)[0, 1] > 0.9
        crossed = (np.maximum(mine, theirs) > 0.6) & (np.minimum(mine, theirs) < 0.1)
        assert not crossed.any(), [pairs.names[i] for i in np.flatnonzero(crossed)]


@pytest.mark.real
def test_pairs_from_landmarks_come_close_to_the_exact_ones(data: Path) -> None:
    """ICT and its caricature share vertices, so the right answer is known."""
    _, character, pairs = paired(data, "ict_face", "toon")
    vertices = character.neutral.vertices
    assert pairs.source is not None
    error = np.linalg.norm(pairs.target.of(vertices) - pairs.source.of(vertices), axis=1)
    assert np.median(error) < 0.003
    assert error.max() < 0.015


@pytest.mark.real
def test_landmarks_stay_exactly_on_landmarks(data: Path) -> None:
    _, character, pairs = paired(data, "makehuman_adult", "toon")
    marks = rig_landmarks(character, None)
    shared = [name for name in pairs.names if name in marks]
    placed = join([marks[name] for name in shared]).of(character.neutral.vertices)
    rows = np.array([pairs.names.index(name) for name in shared])
    assert len(shared) == 60
    assert np.array_equal(pairs.target.take(rows).of(character.neutral.vertices), placed)
