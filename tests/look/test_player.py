"""The page that plays: what is packed into it, and what a browser makes of it."""

from __future__ import annotations

import html
import json
import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import ndimage

from mien.core import Blendshapes, Clip, Mesh, Rig
from mien.io.gltf import write_rig
from mien.job.picture import picture
from mien.look.player import player_page, scene_of
from mien.look.player.packing import packed, sparse_shapes, unpacked
from mien.look.portrait import Portrait, frame_clip
from mien.look.raster import render
from tests.conftest import grid_rig
from tests.io.gltf_samples import matrix, turn
from tests.io.rigged_samples import fitted, moved
from tests.look.solids import ball


def content(page: str) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """The scene of a page, decoded here."""
    told = re.search(r'id="scene">(.*?)</script>', page, re.S)
    block = re.search(r'id="arrays">(.*?)</script>', page, re.S)
    assert told is not None
    assert block is not None
    scene = json.loads(told[1])
    return scene, unpacked(scene["arrays"], block[1])


def posed(scene: dict[str, Any], arrays: dict[str, np.ndarray], weights: np.ndarray) -> np.ndarray:
    """The vertices that a page's shapes give, worked out another way than the page does."""
    points = arrays["positions"].reshape(-1, 3).astype(float)
    for k, weight in enumerate(weights):
        rows = slice(*arrays["first"][k : k + 2])
        points[arrays["moved"][rows]] += weight * arrays["step"][k] * arrays["steps"].reshape(-1, 3)[rows].astype(float)
    return points


def test_arrays_of_every_kind_come_back_and_start_where_browsers_can_read_them(rng: np.random.Generator) -> None:
    arrays = {
        "bytes": rng.integers(0, 255, 7).astype(np.uint8),
        "floats": rng.normal(size=(3, 2)).astype(np.float32),
        "steps": rng.integers(-9, 9, 5).astype(np.int16),
        "none": np.zeros(0, np.uint16),
        "counts": rng.integers(0, 1 << 30, 4).astype(np.uint32),
    }
    table, block = packed(arrays)
    back = unpacked(table, block)
    for name, array in arrays.items():
        assert np.array_equal(back[name], array.ravel())
        assert table[name][1] % 4 == 0


def test_sparse_shapes_keep_every_movement_to_a_part_in_thirty_thousand(rng: np.random.Generator) -> None:
    deltas = rng.normal(0, 0.01, (4, 50, 3)) * (rng.random((4, 50, 1)) < 0.3)
    deltas[2] = 0
    arrays = sparse_shapes(deltas)
    assert arrays["first"][2] == arrays["first"][3]
    assert len(arrays["moved"]) == deltas.any(axis=2).sum()
    for k in range(4):
        again = np.zeros((50, 3))
        rows = slice(*arrays["first"][k : k + 2])
        again[arrays["moved"][rows]] = arrays["steps"][rows] * arrays["step"][k].astype(float)
        assert np.abs(again - deltas[k]).max() <= np.abs(deltas[k]).max() / 60000 + 1e-12


def test_a_page_holds_the_whole_performance_and_asks_for_nothing_else(rng: np.random.Generator) -> None:
    rig = replace(grid_rig(9, ("a", "</script><b>", "c")), name='<"&>')
    values = rng.random((5, 3))
    values[2] = np.nan
    page = player_page(rig, Clip(rig.blendshapes.names, values, 24.0))
    scene, arrays = content(page)
    assert scene["shapes"] == list(rig.blendshapes.names)
    assert scene["fps"] == 24
    weights = arrays["weights"].reshape(5, 3)
    assert np.array_equal(weights[2], weights[1])
    assert np.abs(posed(scene, arrays, weights[4]) - rig.pose(values[4])).max() < 1e-6
    assert html.escape(rig.name) in page
    assert "<b>" not in page
    assert not re.search(r"""(src|href)\s*=|https?://|@import|url\(|import\s*\(|fetch\(""", page)


def test_joints_and_the_head_are_told_frame_by_frame() -> None:
    rig = fitted(grid_rig(8))
    values = np.random.default_rng(1).random((4, 3))
    head = np.tile(matrix((0.1, 0, 0), turn(1, 0.3)), (4, 1, 1))
    clip = Clip(rig.blendshapes.names, values, 24.0, head=head, joints=moved(rig))
    scene, arrays = scene_of(rig, clip)
    own = posed(scene, {name: array.ravel() for name, array in arrays.items()}, values[3])
    bones = np.einsum("nijk,ni->njk", arrays["bones"][3][arrays["joints"]], arrays["grips"])
    points = np.einsum("njk,nk->nj", bones[:, :, :3], own) + bones[:, :, 3]
    assert np.abs(points - rig.pose(values[3], clip.joints[3])).max() < 1e-5
    assert np.abs(arrays["head"][3] - head[3, :3]).max() < 1e-6


def test_a_face_of_ten_thousand_vertices_and_fifty_shapes_fits_ten_megabytes(rng: np.random.Generator) -> None:
    points, triangles = ball(100)
    deltas = rng.normal(0, 0.01, (50, len(points), 3))
    rig = Rig(Mesh(points, triangles), Blendshapes(tuple(f"s{k}" for k in range(50)), deltas))
    page = player_page(rig, Clip(rig.blendshapes.names, rng.random((300, 50)), 30.0))
    assert len(page) < 10e6


def test_a_page_is_written_for_a_still_face_too(tmp_path: Path) -> None:
    write_rig(tmp_path / "a.glb", grid_rig())
    picture(tmp_path / "a.glb", tmp_path / "a.html")
    scene, arrays = content((tmp_path / "a.html").read_text(encoding="utf-8"))
    assert scene["fps"] == 0
    assert "weights" not in arrays


PROBE = """<script>
show(FRAME); bend(now); draw();
const pixels = new Uint8Array(4 * stage.width * stage.height);
gl.readPixels(0, 0, stage.width, stage.height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
document.body.textContent = JSON.stringify({ size: [stage.width, stage.height], fault: gl.getError(),
  points: Array.from(points.subarray(0, 3 * count)), pixels: Array.from(pixels) });
</script></body>"""


@pytest.fixture(scope="module")
def browser() -> Any:
    """Open a page in a browser without a window, and return what it shows and where its vertices are."""
    chromium = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if chromium is None:
        pytest.skip("no Chromium here to open the page with")

    def opened(path: Path, page: str, frame: int) -> dict[str, Any]:
        path.write_text(page.replace("</body>", PROBE.replace("FRAME", str(frame))), encoding="utf-8")
        software = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--window-size=460,320"]
        command = [chromium, "--headless=new", *software, f"--user-data-dir={path.parent}", "--dump-dom", path.as_uri()]
        done = subprocess.run(command, capture_output=True, text=True, timeout=60)
        said = re.search(r"<body>(.*?)</body>", done.stdout, re.S)
        assert said is not None, done.stderr[-2000:]
        found: dict[str, Any] = json.loads(html.unescape(said[1]))
        return found

    return opened


def bust() -> tuple[Rig, Clip]:
    """A ball that two shapes, joints and the head move, half of it in a colour of its own."""
    points, triangles = ball(40, 0.1)
    rig = fitted(Rig(Mesh(points, triangles), Blendshapes((), np.zeros((0, len(points), 3)))))
    groups = {"all": np.arange(len(points)), "half": np.flatnonzero(points[:, 0] > 0)}
    colours = {"all": (0.7, 0.3, 0.1), "half": (0.05, 0.2, 0.6)}
    rig = replace(rig, neutral=replace(rig.neutral, groups=groups), colours=colours)
    head = np.tile(matrix((0.01, 0, 0), turn(1, 0.4)), (4, 1, 1))
    values = np.random.default_rng(3).random((4, 3))
    return rig, Clip(rig.blendshapes.names, values, 24.0, head=head, joints=moved(rig))


def test_a_browser_bends_the_face_as_mien_does_and_shows_it_in_the_same_light(tmp_path: Path, browser: Any) -> None:
    rig, clip = bust()
    shown = browser(tmp_path / "a.html", player_page(rig, clip), 2)
    assert shown["fault"] == 0
    assert clip.joints is not None
    assert np.abs(np.reshape(shown["points"], (-1, 3)) - rig.pose(clip.values[2], clip.joints[2])).max() < 1e-5
    width, height = shown["size"]
    seen = np.reshape(shown["pixels"], (height, width, 4))[::-1]
    camera = frame_clip(rig, clip)
    assert clip.head is not None
    side = min(width, height)
    wanted = Portrait.of(rig, size=(side, side), camera=camera).picture(
        clip.values[2], head=clip.head[2], joints=clip.joints[2]
    )
    left, top = (width - side) // 2, (height - side) // 2
    square = seen[top : top + side, left : left + side]
    inside = square[..., 3] == 255
    backdrop = render(np.zeros((1, 3)), np.empty((0, 3), np.int64), camera, size=(side, side))
    assert 0.1 < inside.mean() < 0.9
    covered = (wanted != backdrop).any(axis=2)
    assert not (ndimage.binary_erosion(covered) & (square[..., 3] == 0)).any()
    assert not (ndimage.binary_erosion(inside) & ~covered).any()
    assert np.abs(square[inside][:, :3].astype(int) - wanted[inside]).mean() < 12
