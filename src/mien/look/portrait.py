"""A rig sitting for its picture: what does not change between frames, worked out once."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from mien.core import Clip, InputError, Rig
from mien.core.arrays import Floats, Ints, floats
from mien.look.camera import Camera, View, face_vertices, frame_all, frame_face
from mien.look.creases import Creases
from mien.look.parts import Surface, surface_of
from mien.look.raster import Dots, Edges, Picture, render, vertex_normals

AT_ONCE = 32
"""Frames posed together while looking how far a face reaches."""


@dataclass(frozen=True, eq=False)
class Portrait:
    """A rig, how its surface looks, and the camera in front of it.

    Attributes:
        rig: who is pictured.
        surface: the triangles drawn and their colours.
        creases: the surface's triangles, its vertices doubled where teeth have edges.
        camera: where it is seen from.
        size: width and height of the pictures [pixels].
    """

    rig: Rig
    surface: Surface
    creases: Creases
    camera: Camera
    size: tuple[int, int]

    @classmethod
    def of(
        cls,
        rig: Rig,
        view: View = "front",
        *,
        size: tuple[int, int] = (512, 512),
        camera: Camera | None = None,
    ) -> Portrait:
        """Make ready to picture a rig, the face filling the picture unless a camera is given.

        Args:
            rig: who is pictured.
            view: from where.
            size: width and height [pixels].
            camera: instead of the one that frames the face.
        """
        surface = surface_of(rig)
        creases = Creases.of(rig.neutral.vertices, surface.triangles, surface.same, surface.teeth)
        return cls(rig, surface, creases, camera or frame_face(rig, view, aspect=size[0] / size[1]), size)

    def picture(
        self,
        weights: Floats | None = None,
        *,
        head: Floats | None = None,
        joints: Floats | None = None,
        colours: Floats | None = None,
        dots: Sequence[Dots] = (),
        edges: Edges = "fine",
    ) -> Picture:
        """Picture one pose.

        Args:
            weights: `(K,)` of the rig's blendshapes; neutral if None.
            head: `(4, 4)` rigid motion of the head [m].
            joints: `(J, 4, 4)` world matrices of the rig's joints.
            colours: `(N, 3)` sRGB per vertex instead of the surface's own, for heat maps.
            dots: markers to draw.
            edges: how they are drawn, see `render`.

        Raises:
            InputError: the weights do not fit the rig or are not finite.
        """
        k = len(self.rig.blendshapes)
        w = np.zeros(k) if weights is None else np.asarray(weights, dtype=np.float64)
        if w.shape != (k,) or not np.isfinite(w).all():
            raise InputError(
                f"a picture of {self.rig.name!r} needs {k} finite weights, but got an array of shape {w.shape}."
            )
        vertices = self.rig.pose(w, joints)
        if head is not None:
            vertices = vertices @ head[:3, :3].T + head[:3, 3]
        own = self.surface.colours if colours is None else floats(colours, vertices.shape, "vertex colours")
        split = self.creases.split
        vertices = split(vertices)
        return render(
            vertices,
            self.creases.triangles,
            self.camera,
            size=self.size,
            colours=split(own),
            normals=vertex_normals(vertices, self.creases.triangles, self.creases.same),
            gaze=split(self.surface.gaze) if colours is None else None,
            openings=self.surface.openings,
            dots=dots,
            edges=edges,
        )


def portrait(
    rig: Rig, weights: Floats | None = None, view: View = "front", *, size: tuple[int, int] = (512, 512)
) -> Picture:
    """Picture one pose of a rig; for many, make one `Portrait` and keep it.

    Raises:
        InputError: the weights do not fit the rig.
    """
    return Portrait.of(rig, view, size=size).picture(weights)


def weights_for(rig: Rig, clip: Clip) -> Floats:
    """Return the clip's `(F, K)` weights in the order of the rig's shapes; NaN rows were not tracked.

    Raises:
        InputError: not one channel of the clip is a shape of the rig.
    """
    shapes = rig.blendshapes.names
    if clip.names and not set(clip.names) & set(shapes):
        raise InputError(
            f"none of the clip's {len(clip.names)} channels ({', '.join(clip.names[:4])}, …) is a shape of "
            f"{rig.name!r} ({', '.join(shapes[:4])}, …); retarget the clip to this character first."
        )
    return clip.channels(shapes)


def frame_clip(
    rig: Rig, clip: Clip, view: View = "front", *, aspect: float = 1.0, frames: Sequence[int] | Ints | None = None
) -> Camera:
    """Place a camera that keeps the face in the picture in every frame shown, wherever the clip takes it.

    Args:
        rig: who plays it.
        clip: the animation, in the rig's shapes.
        view: from where.
        aspect: width over height of the picture.
        frames: those shown; all if None. Where one was not tracked, nothing is known to keep.

    Raises:
        InputError: not one channel of the clip is a shape of the rig.
    """
    weights = weights_for(rig, clip)
    shown = np.arange(len(clip)) if frames is None else np.asarray(frames, dtype=np.int64)
    shown = shown[np.isfinite(weights[shown]).all(axis=1)]
    return frame_all(_poses(rig, clip, weights, shown), view, aspect=aspect)


def _poses(rig: Rig, clip: Clip, weights: Floats, frames: Ints) -> Iterator[Floats]:
    """Yield where the face is at rest and in these frames, a few at a time."""
    face = rig.only(face_vertices(rig))
    yield face.neutral.vertices
    for start in range(0, len(frames), AT_ONCE):
        some = frames[start : start + AT_ONCE]
        points = face.pose(weights[some], None if clip.joints is None else clip.joints[some])
        if clip.head is not None:
            head = clip.head[some]
            points = points @ head[:, :3, :3].transpose(0, 2, 1) + head[:, None, :3, 3]
        yield points
