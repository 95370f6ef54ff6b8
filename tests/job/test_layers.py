from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mien.core import Clip, FileError, InputError, Rig
from mien.io.archive import read_archive, write_archive
from mien.io.formats import read_clip, read_rig
from mien.io.weights import write_clip
from mien.job.compose import Composed, compose, write_layers
from mien.job.model import load_model, replay, save_model
from mien.job.request import Request
from mien.job.retarget import fit, run
from mien.retargeting.layers import composed, rig_face
from mien.retargeting.layers.dynamics import Dynamics
from tests.io.hostile import survives
from tests.job.layered_files import EXTREMES, MASKS, NAMES, speech, write_extremes, write_layered_files

ROUNDING = 1e-5
"""What six decimals of a curve can do to a weight."""


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_layered_files(tmp_path_factory.mktemp("layers"))


def asked(files: Path, **more: Any) -> Request:
    return Request(files / "actor.glb", files / "hero.glb", method="layers", **more)


def captured(files: Path, **more: Any) -> Request:
    given = {"training": files / "rom.trc", "extremes": files / "extremes.csv", **more}
    return Request(files / "take.trc", files / "hero.glb", method="layers", **given)


def curves(files: Path, request: Request, name: str) -> Path:
    write_layers(files / name, run(request))
    return files / name


def edited(files: Path, source: Path, edit: Callable[[dict[str, np.ndarray]], None]) -> Path:
    clip = read_clip(source)
    columns = {name: np.array(values) for name, values in zip(clip.names, clip.values.T, strict=True)}
    edit(columns)
    path = files / "edited.csv"
    write_clip(path, Clip(tuple(columns), np.array(list(columns.values())).T, clip.fps))
    return path


@pytest.fixture(scope="module")
def played(files: Path) -> Path:
    """The curves of the actor's performance."""
    return curves(files, asked(files), "played.csv")


def exact(made: Composed) -> tuple[Rig, Clip]:
    assert made.split is not None
    return made.split


@pytest.mark.parametrize("masks", [(), MASKS])
def test_curves_compose_to_the_animation_they_came_from(files: Path, masks: tuple[str, ...]) -> None:
    request = asked(files, settings={"masks": masks})
    made = compose(files / "hero.glb", curves(files, request, "whole.csv"), masks=masks)
    assert np.abs(made.clip.values - run(request).clip.values).max() < ROUNDING
    assert made.notes == ()


def test_the_head_moves_as_in_the_performance(files: Path) -> None:
    result = run(captured(files))
    assert result.clip.head is not None
    made = compose(files / "hero.glb", curves(files, captured(files), "head.csv"))
    assert np.ptp(result.clip.head, axis=0).max() > 1e-4
    assert np.abs(made.clip.head - result.clip.head).max() < ROUNDING
    assert np.array_equal(exact(made)[1].head, made.clip.head)
    still = compose(files / "hero.glb", files / "head.csv", dynamics=Dynamics(head_gain=0.0))
    assert np.abs(still.clip.head - np.eye(4)).max() < 1e-12


def test_an_edited_layer_changes_nothing_else(files: Path, played: Path) -> None:
    def shout(columns: dict[str, np.ndarray]) -> None:
        columns["speech.viseme_aa"][:], columns["speech.viseme_PP"][:] = 1, 0

    before = exact(compose(files / "hero.glb", played))[1]
    after = exact(compose(files / "hero.glb", edited(files, played, shout)))[1]
    assert before.names == after.names
    changed = np.abs(before.values - after.values).max(axis=0) > ROUNDING
    spoken = np.array([name.startswith("speech.") for name in before.names])
    assert changed.any()
    assert not (changed & ~spoken).any()
    closed = [name.startswith("speech.viseme_PP@") for name in after.names]
    assert not after.values[:, closed].any()


def test_a_layer_can_be_taken_away(files: Path, played: Path) -> None:
    _, made = exact(compose(files / "hero.glb", played, dynamics=Dynamics({"blink": 0.0})))
    _, whole = exact(compose(files / "hero.glb", played))
    shut = [name.startswith("blink.") for name in made.names]
    assert whole.values[:, shut].max() > 0.5
    assert not made.values[:, shut].any()
    rest = [not s for s in shut]
    assert np.array_equal(made.values[:, rest], whole.values[:, rest])


def test_a_split_character_is_animated_exactly_as_its_layers_say(files: Path, played: Path) -> None:
    joined = compose(files / "hero.glb", played)
    rig, clip = exact(joined)
    face = rig_face(read_rig(files / "hero.glb"))
    wanted = composed(face, read_clip(played))
    split = rig.pose(clip.channels(rig.blendshapes.names))
    projected = joined.rig.pose(joined.clip.values)
    assert np.abs(split - wanted).max() < 1e-9
    assert compose(files / "hero.glb", played, split=False).split is None
    moving = joined.rig.blendshapes.deltas.any(axis=(0, 2))
    off = np.sqrt(((projected - wanted)[:, moving] ** 2).sum(axis=2).mean(axis=1))
    assert joined.loss_mm > 0
    assert off.mean() * 1000 == pytest.approx(joined.loss_mm, rel=0.5)


def test_picked_frames_of_a_capture_drive_the_character(files: Path) -> None:
    result = run(captured(files))
    assert np.abs(result.clip.channels(NAMES) - speech()).max() < 0.25
    assert np.corrcoef(result.clip.channels(NAMES).ravel(), speech().ravel())[0, 1] > 0.95
    assert result.report.as_json()["fit"]["rms_mm"] < 0.5


def test_curves_without_some_extremes_play_the_others(files: Path) -> None:
    few = write_extremes(files / "few.csv", [row for row in EXTREMES if row[1] != "surprise"])
    request = captured(files, extremes=few)
    made = compose(files / "hero.glb", curves(files, request, "few_curves.csv"))
    assert np.abs(made.clip.values - run(request).clip.values).max() < ROUNDING
    (note,) = made.notes
    assert "surprise" in note.message


def test_silence_of_the_actor_is_the_character_at_rest(files: Path) -> None:
    silent = write_extremes(files / "silent.csv", [*EXTREMES, ("speech", "viseme_sil", 0)])
    request = captured(files, extremes=silent)
    made = compose(files / "hero.glb", curves(files, request, "silent_curves.csv"))
    assert np.abs(made.clip.values - run(request).clip.values).max() < ROUNDING


@pytest.mark.parametrize("make", [asked, captured])
def test_a_saved_model_gives_what_the_fitted_one_gives(files: Path, make: Callable[[Path], Request]) -> None:
    request = make(files)
    save_model(files / "hero.mien", fit(request))
    later, at_once = replay(Request(request.performance, files / "hero.mien")), run(request)
    assert np.array_equal(later.clip.values, at_once.clip.values)
    assert later.report.evidence == at_once.report.evidence
    assert later.report.notes == at_once.report.notes
    write_layers(files / "later.csv", later)
    wanted = at_once.retargeter.layers(at_once.markers)
    assert np.array_equal(read_clip(files / "later.csv").channels(wanted.names), wanted.values.round(6))


def test_a_saved_model_steps_like_the_fitted_one(files: Path) -> None:
    fitted = fit(captured(files))
    save_model(files / "live.mien", fitted)
    loaded = load_model(files / "live.mien")
    assert loaded.pairs is None
    one, other = fitted.retargeter, loaded.retargeter
    state, twin = one.start(), other.start()
    for frame in run(captured(files)).markers.points[:5]:
        (state, values), (twin, others) = one.step(state, frame), other.step(twin, frame)
        assert np.array_equal(values, others)


def test_damaged_models_are_refused_in_words(files: Path, rng: np.random.Generator) -> None:
    save_model(files / "bad.mien", fit(captured(files)))
    survives(load_model, files / "bad.mien", rng)


def fields_of(header: dict[str, Any], *path: str) -> dict[str, Any]:
    found = header["fitted"]["fields"]
    for name in path:
        found = found[name]["fields"]
    return found


LIES: dict[str, Callable[[dict[str, Any], dict[str, Any]], None]] = {
    "another record": lambda h, a: h.update(fitted=fields_of(h)["actor"]),
    "an unknown class": lambda h, a: h["fitted"].update(record="Popen"),
    "markers left out": lambda h, a: fields_of(h, "actor").update(markers=["m0"]),
    "lips that are nowhere": lambda h, a: fields_of(h, "decomposer").update(
        lips={
            "record": "Lips",
            "fields": {"upper": 9999, "lower": 0, "closed": 0.0, "sigma": 1.0, "closure": 0.1, "bias": None},
        }
    ),
    "a layer that is text": lambda h, a: fields_of(h, "character").update(layers=["emotion", "speech"]),
    "a smoothness below 0": lambda h, a: fields_of(h, "decomposer").update(smooth=-1.0),
    "no field": lambda h, a: fields_of(h).pop("projection"),
    "points of another size": lambda h, a: a.update({"learnt.actor.rest": np.zeros((3, 3))}),
    "a projection of another size": lambda h, a: a.update({"learnt.projection.match": np.zeros((2, 2))}),
    "stability of another size": lambda h, a: a.update({"learnt.actor.stabiliser.stability": np.ones(2)}),
    "numbers that are none": lambda h, a: a.update({"learnt.actor.rest": a["learnt.actor.rest"] * np.nan}),
    "an array that is missing": lambda h, a: a.pop("learnt.projection.match"),
}


@pytest.mark.parametrize("lie", LIES)
def test_models_that_lie_are_refused(files: Path, lie: str) -> None:
    if not (files / "true.mien").exists():
        save_model(files / "true.mien", fit(captured(files)))
    header, arrays = read_archive(files / "true.mien", "mien-model", 1)
    LIES[lie](header, arrays)
    write_archive(files / "lie.mien", header, arrays)
    with pytest.raises(FileError, match=r"lie\.mien"):
        load_model(files / "lie.mien")


def test_curves_that_cannot_be_played_are_refused_in_words(files: Path, played: Path) -> None:
    lacking = edited(files, played, lambda columns: columns.pop("weight.mouth.speech"))
    with pytest.raises(InputError, match=r"weight\.mouth\.speech"):
        compose(files / "hero.glb", lacking)
    (files / "other.csv").write_text("frame,time,jawOpen\n0,0,1\n")
    with pytest.raises(InputError, match="play no layer of hero"):
        compose(files / "hero.glb", files / "other.csv")
    with pytest.raises(InputError, match="Known"):
        compose(files / "hero.glb", played, masks=("eyes",))
    with pytest.raises(InputError, match="unknown layer"):
        compose(files / "hero.glb", played, dynamics=Dynamics({"dance": 0.0}))


def test_extremes_that_are_not_in_the_take_are_refused_in_words(files: Path) -> None:
    for rows, said in (
        ([*EXTREMES, ("emotion", "fear", 99)], "frame 99"),
        ([*EXTREMES, ("emotion", "fear", 1)], "same"),
        ([("dance", "jump", 1), ("dance", "bow", 2)], "no layer"),
        (EXTREMES[:1], "at least two"),
    ):
        with pytest.raises(InputError, match=said):
            run(captured(files, extremes=write_extremes(files / "wrong.csv", rows)))


def test_only_layers_have_curves(files: Path, tmp_path: Path) -> None:
    result = run(Request(files / "actor.glb", files / "hero.glb", method="copy"))
    with pytest.raises(InputError, match="--method layers"):
        write_layers(tmp_path / "no.csv", result)


def test_vertex_groups_of_the_file_can_be_masks(files: Path) -> None:
    rig = read_rig(files / "hero.glb")
    assert set(MASKS) < set(rig.neutral.groups)
    bare = replace(rig.neutral, groups={name: rig.neutral.groups[name] for name in MASKS})
    assert sum(len(ids) for ids in bare.groups.values()) == len(rig.neutral.vertices)
