from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np
import pytest

from mien.core import FileError, InputError
from mien.io.archive import read_archive, write_archive
from mien.io.formats import read_rig
from mien.job import demo
from mien.job.model import load_model, replay, save_model
from mien.job.request import Request
from mien.job.retarget import fit, run
from tests.io.hostile import survives


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[Request, Path]:
    """The built-in faces as files, and the model fitted to them."""
    folder = tmp_path_factory.mktemp("model")
    request = demo.prepare(folder)
    save_model(folder / "hero.mien", fit(request))
    return request, folder / "hero.mien"


def test_a_saved_model_gives_what_the_fitted_one_gives(made: tuple[Request, Path]) -> None:
    request, model = made
    at_once = run(request)
    later = replay(Request(request.performance, model))
    assert np.array_equal(at_once.clip.values, later.clip.values)
    assert np.array_equal(at_once.clip.head, later.clip.head)
    assert later.report.evidence == at_once.report.evidence


def test_a_saved_model_steps_like_the_fitted_one(made: tuple[Request, Path]) -> None:
    request, model = made
    one, other = fit(request).retargeter, load_model(model).retargeter
    frame = one.neutral + 1e-3
    assert np.array_equal(one.step(one.start(), frame)[1], other.step(other.start(), frame)[1])


def test_a_model_of_copied_names_can_be_saved(made: tuple[Request, Path], tmp_path: Path) -> None:
    request, _ = made
    rows = "frame,time,Jaw_Open,Grin_L\n0,0,0.2,0\n1,0.1,0.4,1\n"
    (tmp_path / "weights.csv").write_text(rows)
    weights = Request(tmp_path / "weights.csv", request.character, method="copy")
    save_model(tmp_path / "copy.mien", fit(weights))
    again = replay(Request(weights.performance, tmp_path / "copy.mien"))
    assert np.array_equal(again.clip.values, run(weights).clip.values)


def test_a_model_of_another_character_is_refused(made: tuple[Request, Path], tmp_path: Path) -> None:
    request, model = made
    from mien.io.gltf import write_rig
    from mien.library import actor

    write_rig(tmp_path / "other.glb", actor())
    with pytest.raises(InputError, match="another character"):
        load_model(model, tmp_path / "other.glb")
    with pytest.raises(FileError, match="--character"):
        load_model(model, tmp_path / "gone.glb")
    assert load_model(model, request.character).character.name == read_rig(request.character).name


def test_a_fitted_model_takes_no_further_parameters(made: tuple[Request, Path]) -> None:
    request, model = made
    with pytest.raises(InputError, match="mien fit"):
        replay(Request(request.performance, model, settings={"smooth": 1}))


def test_damaged_models_are_refused_in_words(
    made: tuple[Request, Path], tmp_path: Path, rng: np.random.Generator
) -> None:
    path = tmp_path / "bad.mien"
    path.write_bytes(made[1].read_bytes())
    survives(load_model, path, rng)


def test_headers_that_lie_are_refused(made: tuple[Request, Path], tmp_path: Path) -> None:
    _, model = made
    header, arrays = read_archive(model, "mien-model", 1)
    path = tmp_path / "lie.mien"
    changes = (
        {"version": 2},
        {"format": "other"},
        {"kind": "wizard"},
        {"names": header["names"][:-1]},
        {"settings": 3},
        {"evidence": None},
    )
    for change in changes:
        write_archive(path, {**header, **change}, arrays)
        with pytest.raises(FileError, match=r"lie\.mien"):
            load_model(path)
    write_archive(path, header, {**arrays, "shapes": arrays["shapes"].astype(np.float32)})
    with pytest.raises(FileError, match="shapes"):
        load_model(path)


def test_nothing_in_a_model_is_unpickled(tmp_path: Path) -> None:
    path = tmp_path / "evil.mien"
    np.save(tmp_path / "x.npy", np.array([{"a": 1}], dtype=object), allow_pickle=True)
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("header.json", '{"format": "mien-model", "version": 1, "kind": "copy"}')
        archive.write(tmp_path / "x.npy", "matrix.npy")
    with pytest.raises(FileError):
        load_model(path)
