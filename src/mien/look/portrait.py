"""A rig sitting for its picture: what does not change between frames, worked out once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from mien.core import Clip, InputError, Rig
from mien.core.arrays import Floats
from mien.look.camera import Camera, View, face_points, frame_face
from mien.look.parts import Surface, surface_of
from mien.look.raster import Dots, Edges, Picture, render, vertex_normals


@dataclass(frozen=True, eq=False)
class Portrait:
    """A rig, how its surface looks, and the camera in front of it.

    Attributes:
        rig: who is pictured.
        surface: the triangles drawn and their colours.
        camera: where it is seen from.
        size: width and height of the pictures [pixels].
    """

    rig: Rig
    surface: Surface
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
        paint: Mapping[str, tuple[float, float, float]] | None = None,
    ) -> Portrait:
        """Make ready to picture a rig, the face filling the picture unless a camera is given.

        Args:
            rig: who is pictured.
            view: from where.
            size: width and height [pixels].
            camera: instead of the one that frames the face.
            paint: linear red, green and blue of vertex groups, for a rig that has colours of its own.
        """
        return cls(rig, surface_of(rig, paint), camera or frame_face(rig, view, aspect=size[0] / size[1]), size)

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
        return render(
            vertices,
            self.surface.triangles,
            self.camera,
            size=self.size,
            colours=self.surface.colours if colours is None else colours,
            normals=vertex_normals(vertices, self.surface.triangles, self.surface.same),
            gaze=self.surface.gaze if colours is None else None,
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


def frame_clip(rig: Rig, clip: Clip, view: View = "front", *, aspect: float = 1.0) -> Camera:
    """Place a camera that keeps the face in the picture wherever the clip's head motion takes it."""
    if clip.head is None or not len(clip):
        return frame_face(rig, view, aspect=aspect)
    points = face_points(rig)
    low, high = points.min(axis=0), points.max(axis=0)
    corners = np.array([[(low, high)[bit >> axis & 1][axis] for axis in range(3)] for bit in range(8)])
    moved = np.einsum("fab,cb->fca", clip.head[:, :3, :3], corners) + clip.head[:, None, :3, 3]
    return frame_face(moved.reshape(-1, 3), view, aspect=aspect, margin=0.02)
