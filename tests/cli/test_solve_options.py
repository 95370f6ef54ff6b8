"""What the command line says about the solve: priors, correctives, contact."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from mien.io.archive import read_archive
from mien.io.formats import read_clip
from mien.retargeting.prior import PRIORS
from tests.cli.running import mien
from tests.job.small_files import SmallFiles, write_small_files

RULES = {"format": "mien-correctives", "version": 1, "correctives": {"browUp": {"smile_L": 1, "smile_R": 1}}}


@pytest.fixture
def files(tmp_path: Path) -> SmallFiles:
    return write_small_files(tmp_path)


def job(files: SmallFiles, *more: object) -> list[object]:
    start = ["retarget", files["take.trc"], files["face.glb"], "--pairs", files["face.pairs.json"]]
    return [*start, "-o", files["o.npz"], *more]


@pytest.mark.parametrize("name", PRIORS)
def test_a_prior_without_a_weight_has_its_usual_one(files: SmallFiles, name: str) -> None:
    done = mien(*job(files, "--method", "rbf", "--prior", name, "--json"))
    assert done.code == 0
    used = json.loads(done.out)["settings"]
    assert (used["prior_kind"], used["prior"]) == (name, PRIORS[name].usual)


def test_a_fitted_model_keeps_the_prior_and_says_so(files: SmallFiles) -> None:
    model = files["m.mien"]
    start = ["fit", files["take.trc"], files["face.glb"], "--pairs", files["face.pairs.json"], "-o", model]
    assert mien(*start, "--prior", "pca=0.05", "--contact", 0.5, "--method", "rbf").code == 0
    header, _ = read_archive(model, "mien-model", 1)
    assert {key: header["settings"][key] for key in ("prior_kind", "prior", "contact")} == {
        "prior_kind": "pca",
        "prior": 0.05,
        "contact": 0.5,
    }


@pytest.mark.parametrize(
    "given", [["nope"], ["sparsity"], ["l2", "--prior", "pca"], ["=1"]], ids=lambda words: " ".join(words)
)
def test_a_prior_that_is_none_is_wrong_usage(files: SmallFiles, given: list[str]) -> None:
    done = mien(*job(files, "--prior", *given))
    assert (done.code, done.out) == (2, "")
    assert "--prior" in done.err


def test_correctives_are_solved_for_and_their_weights_are_in_the_animation(files: SmallFiles) -> None:
    rules = files["rules.json"]
    rules.write_text(json.dumps(RULES))
    assert mien(*job(files, "--correctives", rules, "--method", "rbf", "--set", "off=")).code == 0
    left, right, both = read_clip(files["o.npz"]).channels(("smile_L", "smile_R", "browUp")).T
    np.testing.assert_allclose(both, left * right, atol=1e-6)
    assert left.max() > 0.1


def test_correctives_that_cannot_be_used_are_refused(files: SmallFiles) -> None:
    rules = files["rules.json"]
    rules.write_text(json.dumps(RULES | {"correctives": {"frown": {"smile_L": 0.5}}}))
    unknown = mien(*job(files, "--correctives", rules))
    assert unknown.code == 1
    assert "rules.json" in unknown.err
    assert "frown" in unknown.err
    rules.write_text(json.dumps(RULES))
    elsewhere = mien(*job(files, "--correctives", rules, "--method", "layers"))
    assert elsewhere.code == 1
    assert "does not solve for weights" in " ".join(elsewhere.err.split())


def test_contact_without_landmarks_says_that_it_does_nothing(files: SmallFiles) -> None:
    done = mien(*job(files, "--method", "rbf", "--contact", 1, "--json"))
    assert done.code == 0
    assert "contact-unknown" in [warning["code"] for warning in json.loads(done.out)["warnings"]]
