"""A rig from elsewhere: MakeHuman's bones and pose units on other heads.

    python -m benchmarks.paper_figures.rig_transfer.elsewhere

The skeleton's base mesh comes without landmarks, and its head is that of the adult, which has them:
each landmark is put on the point of the base mesh nearest to where it is on the adult.  Pose units turn
bones in their own frames; the carried bones are turned by the same angles.  The table says how far each
pose takes the skin on the base mesh and on the other heads, in millimetres on a human-sized face.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from benchmarks.paper_figures.rig_transfer.command import run
from benchmarks.paper_figures.rig_transfer.drawing import camera, sitter
from benchmarks.paper_figures.rig_transfer.faces import Settings
from benchmarks.report import Row, publish
from mien.core import Rig, Skeleton
from mien.core.arrays import Floats
from mien.core.units import human_centimetre
from mien.geometry.surface import closest_points
from mien.io.makehuman import read_pose_units, read_rig
from mien.look.sheet import Labelled, save_png, sheet
from mien.look.sheet import Row as Pictures
from mien.rigging.transfer import transfer_rig

POSES = (
    "JawDrop",
    "LeftUpperLidClosed",
    "RightUpperLidClosed",
    "MouthLeftPullUp",
    "MouthRightPullSide",
    "lowerLipDown",
)
FACES = ("MakeHuman child", "ICT", "actor", "cartoon")


def elsewhere(settings: Settings) -> None:
    """Write the sheet and the table."""
    if settings.data is None or not (settings.data / "bones").is_dir():
        print("elsewhere: MakeHuman's bones are not there; skipped.")
        return
    rig = bone_rig(settings)
    assert rig.skeleton is not None
    units = read_pose_units(settings.data / "bones" / "face-poseunits.json", rig.skeleton)
    names = [next(unit for unit in units if unit.lower() == pose.lower()) for pose in POSES]
    poses = {name: turns(rig.skeleton, units[name]) for name in names}
    rows, pictures = _shown(rig, rig, poses, settings, "MakeHuman's own")
    sheets = [pictures]
    for name in FACES if not settings.quick else FACES[:1]:
        face = settings.bare(name)
        moved = transfer_rig(rig, face).rig
        more, pictures = _shown(moved, face, poses, settings, name)
        rows += more
        sheets.append(pictures)
    save_png(settings.out / "elsewhere.png", sheet(sheets, "MakeHuman's bones and pose units on other heads"))
    joints = len(rig.skeleton.names)
    about = f"{len(poses)} of {len(units)} pose units of a rig with {joints} bones, on other heads"
    publish("rig_transfer_elsewhere", about, rows, ["numpy"], settings.results)


def bone_rig(settings: Settings) -> Rig:
    """Return the bone rig of MakeHuman's head, with the adult's landmarks."""
    assert settings.data is not None
    rig, adult = read_rig(settings.data / "bones", below="neck02"), settings.bare("MakeHuman adult")
    mesh = rig.neutral
    body = mesh.triangles[np.isin(mesh.triangles, mesh.groups["body"]).all(axis=1)]
    marks = {
        name: closest_points(mesh.vertices, body, point.of(adult.neutral.vertices))[0]
        for name, point in adult.landmarks.items()
    }
    return replace(rig, landmarks=marks)


def turns(skeleton: Skeleton, pose: Floats) -> Floats:
    """Return by what each joint is moved in its own frame `(J, 4, 4)`, from world matrices of a pose."""
    return np.asarray(np.linalg.inv(_local(skeleton, skeleton.rest)) @ _local(skeleton, pose))


def turned(skeleton: Skeleton, moves: Floats) -> Floats:
    """Return the world matrices `(J, 4, 4)` of a skeleton whose joints are moved in their own frames."""
    local = _local(skeleton, skeleton.rest) @ moves
    world = np.zeros_like(local)
    for joint, parent in enumerate(skeleton.parents):  # parents come first in MakeHuman's rigs
        world[joint] = local[joint] if parent < 0 else world[parent] @ local[joint]
    return world


def _local(skeleton: Skeleton, world: Floats) -> Floats:
    above = np.where((skeleton.parents >= 0)[:, None, None], world[skeleton.parents], np.eye(4))
    return np.asarray(np.linalg.inv(above) @ world)


def _shown(
    rig: Rig, framed: Rig, poses: dict[str, Floats], settings: Settings, title: str
) -> tuple[list[Row], Pictures]:
    """Picture and measure a rig in every pose."""
    assert rig.skeleton is not None
    places = np.concatenate([point.of(framed.neutral.vertices) for point in framed.landmarks.values()])
    millimetre = 0.1 * human_centimetre(places)
    seen = sitter(rig, size=settings.tile, at=camera(framed))
    cells, row = [Labelled(seen.picture(), "at rest")], Row(head=title)
    for name, moves in poses.items():
        joints = turned(rig.skeleton, moves)
        cells.append(Labelled(seen.picture(joints=joints), name))
        moved = np.linalg.norm(rig.pose(np.zeros(len(rig.blendshapes)), joints) - rig.neutral.vertices, axis=1)
        row[name] = float(moved.max() / millimetre)
    return [row], Pictures(title, tuple(cells))


if __name__ == "__main__":
    run(__doc__, elsewhere)
