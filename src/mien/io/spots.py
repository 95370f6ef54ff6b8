"""Places on a mesh in a file's own words, and back."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from mien.core import FileError, InputError, Mesh, SurfacePoints
from mien.core.arrays import Ints
from mien.core.errors import unknown
from mien.geometry.surface import closest_points
from mien.io.values import numbers, short, whole

Spot = Mapping[str, Any]
"""A place in a file's own words: a vertex, a triangle with barycentric weights, a position or a marker."""


def as_spot(value: Any, mesh_name: str | None = None) -> Spot:
    """Return a place as files say it: a number alone is a vertex, of the mesh that is named."""
    place = {"vertex": value} if isinstance(value, int) else value
    return {**place, "mesh": mesh_name} if mesh_name and isinstance(place, dict) else place


def on_mesh(spot: Spot, mesh: Mesh, where: str) -> SurfacePoints:
    """Find a place on a mesh.

    Raises:
        FileError: it names what the mesh does not have, or a marker; `where` begins the message.
    """
    if not isinstance(spot, Mapping):
        raise FileError(
            f"{where} must be a vertex number or a triangle with barycentric weights, but is {short(spot)}."
        )
    if "vertex" in spot:
        members = _part(mesh, spot.get("mesh"), where)
        vertex = whole(spot["vertex"], len(members), f"{where}: vertex")
        return SurfacePoints.at_vertices(members[[vertex]])
    if "triangle" in spot:
        members = _part(mesh, spot.get("mesh"), where)
        triangles = mesh.triangles[np.isin(mesh.triangles, members).all(axis=1)]
        row = whole(spot["triangle"], len(triangles), f"{where}: triangle")
        weights = numbers(spot.get("barycentric", [1 / 3] * 3), 3, f"{where}: barycentric weights")
        if (weights < 0).any():
            raise FileError(f"{where}: barycentric weights must not be negative, but are {weights.tolist()}.")
        try:
            return SurfacePoints(triangles[[row]], weights[None])
        except InputError as error:
            raise FileError(f"{where}: {error}") from None
    if "position" in spot:
        position = numbers(spot["position"], 3, f"{where}: position")
        return closest_points(mesh.vertices, mesh.triangles, position[None])[0]
    raise FileError(
        f"{where} names a marker, but is to be found on a mesh: give a vertex, a triangle or a position, "
        "or exchange the two landmark files if they are in the wrong order."
    )


def _part(mesh: Mesh, name: Any, where: str) -> Ints:
    if name is None:
        return np.arange(len(mesh.vertices))
    if not isinstance(name, str) or name not in mesh.groups:
        raise FileError(f"{where}: {unknown('mesh', str(name), mesh.groups)}")
    return mesh.groups[name]


def say(point: SurfacePoints, mesh: Mesh) -> Any:
    """Return one surface point as files say it: a vertex, or a triangle with barycentric weights.

    Raises:
        InputError: it lies in no triangle of the mesh.
    """
    weights, corners = point.weights[0], point.corners[0]
    if weights.max() == 1:
        return int(corners[np.argmax(weights)])
    a, b, c = mesh.triangles.T
    inside = (a != b) & (b != c) & (c != a)
    for corner in corners[weights > 0]:
        inside &= (mesh.triangles == corner).any(axis=1)
    row = np.flatnonzero(inside)
    if not len(row) or (weights < 0).any():
        raise InputError(
            f"a point lies on the vertices {corners.tolist()} with the weights {weights.tolist()}, which is inside no "
            "triangle of the mesh; it cannot be written."
        )
    own = [float(weights[corners == corner].sum()) for corner in mesh.triangles[row[0]]]
    return {"triangle": int(row[0]), "barycentric": own}
