"""Bad input: one clear paragraph that names the thing, exit code 1, and nothing written."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mien.core import Blendshapes, Clip, Mesh, Rig
from mien.io import gltf, npz
from tests.cli.running import contents, mien
from tests.job.small_files import FEW_SHAPES, LANDMARKS, SmallFiles, capture_of, marker_pairs, write_small_files
from tests.retargeting.actors import face, weights

Args = list[object]
Case = Callable[[SmallFiles], Args]
CASES: dict[str, tuple[Case, tuple[str, ...]]] = {}


def case(*words: str) -> Callable[[Case], Case]:
    """Add a case: what it does to the files and which arguments it runs with; the error must hold the words."""

    def add(make: Case) -> Case:
        CASES[make.__name__] = (make, words)
        return make

    return add


def job(f: SmallFiles, performance: str = "take.trc", character: str = "face.glb", *more: object) -> Args:
    pairs = () if "--landmarks" in more else ("--pairs", f["face.pairs.json"])
    return ["retarget", f[performance], f[character], *pairs, *more]


@pytest.fixture(scope="module")
def originals(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    folder = tmp_path_factory.mktemp("small")
    write_small_files(folder)
    return contents(folder)


# --- files ------------------------------------------------------------------------------


@case("nowhere.trc", "does not exist")
def missing_performance(f: SmallFiles) -> Args:
    return job(f, "nowhere.trc")


@case("nowhere.glb", "does not exist", "face.glb")
def missing_character(f: SmallFiles) -> Args:
    return job(f, character="nowhere.glb")


@case("nowhere.json", "does not exist")
def missing_pairs(f: SmallFiles) -> Args:
    return [*job(f)[:3], "--pairs", f["nowhere.json"]]


@case("face.glb", "truncated")
def character_cut_in_half(f: SmallFiles) -> Args:
    content = f["face.glb"].read_bytes()
    f["face.glb"].write_bytes(content[: len(content) // 2])
    return job(f)


@case("face.glb")
def character_of_ten_bytes(f: SmallFiles) -> Args:
    f["face.glb"].write_bytes(f["face.glb"].read_bytes()[:10])
    return job(f)


@case("face.glb", "web page")
def web_page_instead_of_a_character(f: SmallFiles) -> Args:
    f["face.glb"].write_text("<!DOCTYPE html><html><body>404</body></html>")
    return job(f)


@case("take.trc", "web page")
def web_page_instead_of_a_take(f: SmallFiles) -> Args:
    f["take.trc"].write_text("<html><body>404</body></html>")
    return job(f)


@case("take.trc", "empty")
def empty_take(f: SmallFiles) -> Args:
    f["take.trc"].write_bytes(b"")
    return job(f)


@case("take.xyz", "suffix")
def unknown_suffix(f: SmallFiles) -> Args:
    f["take.trc"].rename(f["take.xyz"])
    return job(f, "take.xyz")


@case("take.trc", "not a character")
def sides_exchanged(f: SmallFiles) -> Args:
    return job(f, "anim.glb", "take.trc")


@case("face.glb", "animation")
def performance_is_a_still_face(f: SmallFiles) -> Args:
    return ["retarget", f["face.glb"], f["face.glb"], "--pairs", f["mesh.pairs.json"]]


@case("face.pairs.json", "JSON")
def pairs_that_are_not_json(f: SmallFiles) -> Args:
    f["face.pairs.json"].write_text("{pairs: 1")
    return job(f)


@case("mesh.landmarks.json", "mien-pairs")
def landmarks_given_as_pairs(f: SmallFiles) -> Args:
    return [*job(f)[:3], "--pairs", f["mesh.landmarks.json"]]


# --- the character ----------------------------------------------------------------------


def rig_with(f: SmallFiles, names: tuple[str, ...], deltas: np.ndarray) -> Args:
    gltf.write_rig(f["face.glb"], replace(face(), blendshapes=Blendshapes(names, deltas)))
    return job(f)


@case("no blendshapes", "nothing to animate")
def character_without_blendshapes(f: SmallFiles) -> Args:
    return rig_with(f, (), np.zeros((0, 576, 3)))


@case("2 blendshapes", "empty")
def character_with_only_empty_shapes(f: SmallFiles) -> Args:
    return rig_with(f, ("a", "b"), np.zeros((2, 576, 3)))


@case("face.glb", "NaN or infinity")
def character_with_nan_vertices(f: SmallFiles) -> Args:
    content = f["face.glb"].read_bytes()
    vertices = face().neutral.vertices[:9].astype("<f4").tobytes()
    assert vertices in content
    f["face.glb"].write_bytes(content.replace(vertices, np.full(27, np.nan, "<f4").tobytes()))
    return job(f)


@case("empty")
def a_folder_of_equal_shapes(f: SmallFiles) -> Args:
    folder = f["cloud"]
    folder.mkdir()
    for name in ("neutral", "jawOpen"):
        (folder / f"{name}.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 1 1 1\n")
    return [
        "retarget",
        f["take.trc"],
        folder,
        "--pairs",
        f.pairs([{"source": f"m{i}", "target": i} for i in range(5)]),
    ]


# --- pairs ------------------------------------------------------------------------------


def with_pairs(f: SmallFiles, rows: list[dict[str, object]]) -> Args:
    f.pairs(rows)
    return job(f)


@case("face.pairs.json", "pair 3", "'M3'", "'m3'")
def unknown_marker(f: SmallFiles) -> Args:
    rows = marker_pairs()
    rows[3]["source"] = "M3"
    return with_pairs(f, rows)


@case("face.pairs.json", "pair 0", "576", "575")
def unknown_vertex(f: SmallFiles) -> Args:
    rows = marker_pairs()
    rows[0]["target"] = 576
    return with_pairs(f, rows)


@case("3", "at least 4")
def three_pairs(f: SmallFiles) -> Args:
    return with_pairs(f, marker_pairs()[:3])


@case("no pairs")
def no_pairs(f: SmallFiles) -> Args:
    return with_pairs(f, [])


@case("plane")
def pairs_in_a_line(f: SmallFiles) -> Args:
    return with_pairs(f, marker_pairs()[:7])


@case("'m5'", "more than once")
def a_marker_paired_twice(f: SmallFiles) -> Args:
    return with_pairs(f, [*marker_pairs(), marker_pairs()[5]])


@case("'m5'", "'m6'", "same point")
def two_markers_on_one_vertex(f: SmallFiles) -> Args:
    rows = marker_pairs()
    rows[6]["target"] = rows[5]["target"]
    return with_pairs(f, rows)


@case("mirror", "left")
def pairs_with_left_and_right_exchanged(f: SmallFiles) -> Args:
    rows = marker_pairs()
    across = [6 - i // 7 for i in range(49)]
    targets = [rows[7 * a + i % 7]["target"] for i, a in enumerate(across)]
    return with_pairs(f, [{**row, "target": t} for row, t in zip(rows, targets, strict=True)])


@case("radius", "same spot")
def scrambled_pairs(f: SmallFiles) -> Args:
    rows = marker_pairs()
    order = np.random.default_rng(4).permutation(49)
    return with_pairs(f, [{**row, "target": rows[i]["target"]} for row, i in zip(rows, order, strict=True)])


@case("scaled", "units")
def a_take_of_absurd_size(f: SmallFiles) -> Args:
    take = capture_of()
    f.take(replace(take, points=take.points * 1e5))
    return job(f)


@case("nothing says which point", "--pairs", "--landmarks")
def neither_pairs_nor_landmarks(f: SmallFiles) -> Args:
    return job(f)[:3]


@case("markers.landmarks.json", "wrong order", "marker")
def landmark_files_exchanged(f: SmallFiles) -> Args:
    return job(f, "take.trc", "face.glb", "--landmarks", f["mesh.landmarks.json"], f["markers.landmarks.json"])


@case("2 landmarks", "at least 4")
def landmarks_that_share_too_little(f: SmallFiles) -> Args:
    f.landmarks({name: {"vertex": v} for name, v in list(LANDMARKS.items())[:2]}, "mesh.landmarks.json")
    return job(f, "take.trc", "face.glb", "--landmarks", f["markers.landmarks.json"], f["mesh.landmarks.json"])


# --- the performance --------------------------------------------------------------------


@case("no movement", "120 frames")
def a_take_without_movement(f: SmallFiles) -> Args:
    f.take(capture_of(np.zeros((120, 6))))
    return job(f)


@case("no movement")
def a_take_of_one_frame(f: SmallFiles) -> Args:
    f.take(capture_of(weights(120)[:1]))
    return job(f)


@case("pairs are usable")
def a_take_that_is_all_gaps(f: SmallFiles) -> Args:
    take = capture_of()
    f.take(replace(take, points=np.full_like(take.points, np.nan)))
    return job(f)


@case("take.trc", "infinity")
def a_take_with_infinity(f: SmallFiles) -> Args:
    lines = f["take.trc"].read_text().splitlines()
    cells = lines[20].split("\t")
    lines[20] = "\t".join([*cells[:5], "inf", *cells[6:]])
    f["take.trc"].write_text("\n".join(lines) + "\n")
    return job(f)


@case("take.trc", "line 21", "'abc'")
def a_take_with_words_for_numbers(f: SmallFiles) -> Args:
    lines = f["take.trc"].read_text().splitlines()
    cells = lines[20].split("\t")
    lines[20] = "\t".join([*cells[:5], "abc", *cells[6:]])
    f["take.trc"].write_text("\n".join(lines) + "\n")
    return job(f)


@case("take.trc", "frame rate", "0")
def a_take_of_zero_frames_per_second(f: SmallFiles) -> Args:
    text = f["take.trc"].read_text()
    f["take.trc"].write_text(text.replace("60\t60\t120", "0\t0\t120", 1))
    return job(f)


@case("clip.npz", "frame rate", "0")
def weights_of_zero_frames_per_second(f: SmallFiles) -> Args:
    np.savez(f["clip.npz"], names=np.array(["jawOpen"]), values=np.zeros((3, 1)), fps=0.0)
    return ["retarget", f["clip.npz"], f["face.glb"]]


@case("weights.csv", "times", "rise")
def weights_whose_time_stands_still(f: SmallFiles) -> Args:
    f["weights.csv"].write_text("frame,time,jawOpen\n0,0,0\n1,0,1\n2,0,0\n")
    return ["retarget", f["weights.csv"], f["face.glb"]]


@case("weights.csv", "infinity", "jawOpen")
def weights_with_infinity(f: SmallFiles) -> Args:
    f["weights.csv"].write_text("frame,time,jawOpen\n0,0,0\n1,0.1,inf\n")
    return ["retarget", f["weights.csv"], f["face.glb"]]


@case("tracking was lost")
def weights_lost_throughout(f: SmallFiles) -> Args:
    f["weights.csv"].write_text("frame,time,jawOpen\n0,0,\n1,0.1,\n")
    return ["retarget", f["weights.csv"], f["face.glb"]]


@case("weights.csv", "no row")
def weights_with_a_header_only(f: SmallFiles) -> Args:
    f["weights.csv"].write_text("frame,time,jawOpen\n")
    return ["retarget", f["weights.csv"], f["face.glb"]]


@case("nose", "shape of face")
def weights_that_share_no_name(f: SmallFiles) -> Args:
    f["weights.csv"].write_text("frame,time,nose\n0,0,0\n1,0.1,1\n")
    return ["retarget", f["weights.csv"], f["face.glb"]]


@case("nose", "actor")
def weights_that_are_not_the_actors(f: SmallFiles) -> Args:
    f["weights.csv"].write_text("frame,time,nose\n0,0,0\n1,0.1,1\n")
    return ["retarget", f["weights.csv"], f["face.glb"], "--actor", f["face.glb"], "--pairs", f["mesh.pairs.json"]]


@case("--actor")
def a_method_of_points_for_weights(f: SmallFiles) -> Args:
    return ["retarget", f["weights.csv"], f["face.glb"], "--method", "rbf"]


@case("'copy'", "markers")
def copying_markers(f: SmallFiles) -> Args:
    return job(f, "take.trc", "face.glb", "--method", "copy")


def absurd(f: SmallFiles, size: float) -> Args:
    values = np.random.default_rng(2).normal(0, size, (50, 6))
    npz.write_clip(f["clip.npz"], Clip(face().blendshapes.names, values, 30.0))
    args: Args = ["retarget", f["clip.npz"], f["face.glb"], "--actor", f["face.glb"], "--pairs", f["mesh.pairs.json"]]
    return args


@case("clip.npz", "e+200", "frame")
def weights_beyond_all_measure(f: SmallFiles) -> Args:
    return absurd(f, 1e200)


@case("5000", "0 … 119")
def a_neutral_beyond_the_take(f: SmallFiles) -> Args:
    return job(f, "take.trc", "face.glb", "--neutral", 5000)


@case("frame -1")
def a_negative_neutral(f: SmallFiles) -> Args:
    return job(f, "take.trc", "face.glb", "--neutral", "-1")


@case("rest.trc", "does not exist")
def a_neutral_file_that_is_missing(f: SmallFiles) -> Args:
    return job(f, "take.trc", "face.glb", "--neutral", f["rest.trc"])


@case("4 vertices", "576", "same mesh")
def a_training_take_of_another_mesh(f: SmallFiles) -> Args:
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    other = Rig(Mesh(corners, [[0, 1, 2], [0, 2, 3]]), Blendshapes(("jawOpen",), np.ones((1, 4, 3))))
    gltf.write_rig(f["other.glb"], other, Clip(("jawOpen",), np.array([[0.0], [1.0]]), 30.0))
    return ["retarget", f["anim.glb"], f["face.glb"], "--pairs", f["mesh.pairs.json"], "--training", f["other.glb"]]


@case("take.trc", "anim.glb", "same way")
def a_training_take_of_another_kind(f: SmallFiles) -> Args:
    return job(f, "take.trc", "face.glb", "--training", f["anim.glb"])


# --- options ----------------------------------------------------------------------------


@case("'sparsty'", "'sparsity'")
def an_unknown_parameter(f: SmallFiles) -> Args:
    return job(f, "take.trc", "face.glb", "--set", "sparsty=1")


@case("smooth", "'much'")
def a_parameter_of_the_wrong_kind(f: SmallFiles) -> Args:
    return job(f, "take.trc", "face.glb", "--set", "smooth=much")


@case("sparsity", "at least 0")
def a_negative_parameter(f: SmallFiles) -> Args:
    return job(f, "take.trc", "face.glb", "--set", "sparsity=-1")


@case("steepness")
def a_parameter_that_is_nan(f: SmallFiles) -> Args:
    return job(f, "take.trc", "face.glb", "--set", "steepness=nan")


@case("bounds")
def bounds_as_a_word(f: SmallFiles) -> Args:
    return job(f, "take.trc", "face.glb", "--set", "bounds=0")


@case("shape_sparsity")
def a_table_as_a_word(f: SmallFiles) -> Args:
    return job(f, "take.trc", "face.glb", "--set", "shape_sparsity=jawOpen")


@case("bounds", "enclose 0")
def bounds_without_the_neutral(f: SmallFiles) -> Args:
    return job(f, "take.trc", "face.glb", "--bounds", 0.5, 1)


@case("bounds")
def bounds_that_are_nan(f: SmallFiles) -> Args:
    return job(f, "take.trc", "face.glb", "--bounds", "nan", "nan")


@case("'jawOpne'", "'jawOpen'")
def an_unknown_exclusive_shape(f: SmallFiles) -> Args:
    return job(f, "take.trc", "face.glb", "--exclusive", "jawOpne,browUp")


@case("method 'nope'", "range-of-motion")
def an_unknown_method(f: SmallFiles) -> Args:
    return job(f, "take.trc", "face.glb", "--method", "nope")


@case("marker 'zz'")
def an_unknown_rigid_marker(f: SmallFiles) -> Args:
    return job(f, "take.trc", "face.glb", *(word for name in ("zz", "m0", "m1", "m2") for word in ("--rigid", name)))


@case("rigid")
def too_few_rigid_markers(f: SmallFiles) -> Args:
    return job(f, "take.trc", "face.glb", "--rigid", "m0")


@case("face.examples.csv", "frame")
def examples_without_frames(f: SmallFiles) -> Args:
    f["face.examples.csv"].write_text("time,jawOpen\n0,1\n")
    return job(f, "take.trc", "face.glb", "--examples", f["face.examples.csv"])


@case("'jawOpne'", "'jawOpen'")
def examples_of_an_unknown_shape(f: SmallFiles) -> Args:
    f["face.examples.csv"].write_text("frame,jawOpne\n9,1\n")
    return job(f, "take.trc", "face.glb", "--examples", f["face.examples.csv"])


@case("frame 999")
def examples_beyond_the_take(f: SmallFiles) -> Args:
    f["face.examples.csv"].write_text("frame,jawOpen\n999,1\n")
    return job(f, "take.trc", "face.glb", "--examples", f["face.examples.csv"])


@pytest.fixture
def files(originals: dict[str, bytes], tmp_path: Path) -> SmallFiles:
    folder = tmp_path / "in"
    folder.mkdir()
    for name, content in originals.items():
        (folder / name).write_bytes(content)
    return SmallFiles(folder)


@pytest.mark.parametrize("name", CASES)
def test_bad_input_gives_one_paragraph_and_writes_nothing(name: str, files: SmallFiles, tmp_path: Path) -> None:
    make, words = CASES[name]
    args = make(files)
    out = tmp_path / "out"
    out.mkdir()
    (out / "o.csv").write_text("what stood here before")
    before = contents(tmp_path)
    settings = () if "--set" in args else ("--set", FEW_SHAPES)
    done = mien(*args, *settings, "-o", out / "o.glb", "-o", out / "o.csv", "--report", out / "r.json")
    assert done.code == 1, done
    assert done.out == ""
    said = done.err.strip()
    assert said.startswith("mien: ")
    assert "\n" not in said
    assert "Traceback" not in said
    assert [word for word in words if word not in said] == [], said
    assert contents(tmp_path) == before
