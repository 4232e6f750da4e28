"""Texture coordinates for meshes that have none: projected from the six sides, or from a sphere."""

from __future__ import annotations

import numpy as np

from gonio.render.triangles import Floats, Ints, Triangles

PROJECTIONS = ("box", "sphere")


def projected(mesh: Triangles, projection: str) -> Triangles:
    """The mesh with uvs in place of its own.

    projection: "box" lays the picture on each triangle from the side that it faces most, once over the
    mesh's longest side; "sphere" wraps it around once, with its top row upwards (+y) and its middle to
    the front (+z).

    Raises:
        ValueError: another projection.
    """
    if projection not in PROJECTIONS:
        raise ValueError(f"no uv projection {projection!r}; use one of {', '.join(PROJECTIONS)}")
    points = mesh.positions[mesh.faces]
    used = mesh.positions[np.unique(mesh.faces)]
    low, high = used.min(axis=0), used.max(axis=0)
    box = projection == "box"
    return _with_corner_uvs(
        mesh, _box(points, low, high) if box else _sphere(points, (low + high) / 2)
    )


def _box(points: Floats, low: Floats, high: Floats) -> Floats:
    normal = np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0])
    axis = np.argmax(np.abs(normal), axis=1)
    side = np.sign(np.take_along_axis(normal, axis[:, None], axis=1))
    place = (points - (low + high) / 2) / (high - low).max()
    x, y, z = np.moveaxis(place, -1, 0)
    # Seen from outside, u goes to the right and v down; from above, v goes towards the front.
    u = np.choose(axis[:, None], [-side * z, x, side * x])
    v = np.choose(axis[:, None], [-y, side * z, -y])
    return np.stack([u, v], axis=-1) + 0.5


def _sphere(points: Floats, centre: Floats) -> Floats:
    d = points - centre
    radius = np.linalg.norm(d, axis=-1)
    flat = np.hypot(d[..., 0], d[..., 2])
    u = np.arctan2(d[..., 0], d[..., 2]) / (2 * np.pi) + 0.5
    v = np.arccos(np.clip(d[..., 1] / np.where(radius > 0, radius, 1), -1, 1)) / np.pi
    # At a pole any longitude will do, and that of the triangle's other corners does not twist it.
    pole = flat < 1e-9 * radius.max()
    first = np.take_along_axis(u, np.argmin(pole, axis=1)[:, None], axis=1)
    u = np.where(pole, first, u)
    u = u - np.round(u - u[:, :1])  # across the seam the coordinate runs on
    others = (
        np.where(pole, 0, u).sum(axis=1, keepdims=True) / np.maximum((~pole).sum(1), 1)[:, None]
    )
    return np.stack([np.where(pole, others, u), v], axis=-1)


def _with_corner_uvs(mesh: Triangles, corner_uvs: Floats) -> Triangles:
    """The mesh with a vertex for each pair of an old vertex and a uv."""
    old: Ints = mesh.faces.reshape(-1)
    flat = corner_uvs.reshape(-1, 2)
    key = np.concatenate([old[:, None], np.round(flat * 1e7).astype(np.int64)], axis=1)
    _, first, new = np.unique(key, axis=0, return_index=True, return_inverse=True)
    kept = old[first]
    return Triangles(
        mesh.positions[kept],
        new.reshape(-1, 3),
        None if mesh.normals is None else mesh.normals[kept],
        flat[first],
    )
