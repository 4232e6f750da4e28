"""Polygons as mesh files hold them, and how they become triangles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gonio.render.triangles import Floats, Ints, Triangles

MISSING = -1  # the index of a corner that has no texture coordinate or no normal


@dataclass(frozen=True)
class Polygons:
    """Polygons by their corners, each of which has its own position, uv and normal, as in OBJ.

    positions: (V, 3). sizes: (F,) corners of each polygon, which follow each other in the (C,)
    arrays `corners` (indices of positions), `corner_uvs` and `corner_normals` (indices of uvs and
    normals, MISSING where there is none; None where no corner has one). uvs: (T, 2), v = 0 at a
    picture's bottom row. normals: (N, 3), of any length.
    """

    positions: Floats
    sizes: Ints
    corners: Ints
    uvs: Floats | None = None
    corner_uvs: Ints | None = None
    normals: Floats | None = None
    corner_normals: Ints | None = None

    def triangulated(self) -> Triangles:
        """The same surface in triangles; vertices are doubled where uvs or normals are.

        A missing uv is (0, 0); a missing normal is a zero vector.

        Raises:
            ValueError: a corner has an index that is not there.
        """
        for index, values, what in (
            (self.corners, self.positions, "vertex"),
            (self.corner_uvs, self.uvs, "texture coordinate"),
            (self.corner_normals, self.normals, "normal"),
        ):
            if index is None or values is None or not len(index):
                continue
            least = 0 if what == "vertex" else MISSING
            if index.min() < least or index.max() >= len(values):
                wrong = index[(index < least) | (index >= len(values))][0]
                raise ValueError(
                    f"a polygon has the {what} {wrong}, a {what} that is not there "
                    f"(there are {len(values)}, counted from 0)"
                )
        triangles = corner_triangles(self.positions, self.sizes, self.corners)
        return self._welded(triangles)

    def _welded(self, triangles: Ints) -> Triangles:
        """One vertex for every combination of position, uv and normal among the corners."""
        key = self.corners.astype(np.int64)
        for values, index in ((self.uvs, self.corner_uvs), (self.normals, self.corner_normals)):
            if values is not None and index is not None:
                # Numbered anew after each step, so that the product of counts fits into 64 bits.
                combined = key * (len(values) + 1) + index + 1
                key = np.unique(combined, return_inverse=True)[1].reshape(-1)
        _, first, vertex = np.unique(key, return_index=True, return_inverse=True)
        downwards = None if self.uvs is None else self.uvs * [1, -1] + [0, 1]
        return Triangles(
            self.positions[self.corners[first]],
            vertex.reshape(-1)[triangles],
            _gathered(self.normals, self.corner_normals, first),
            _gathered(downwards, self.corner_uvs, first),
        )


def _gathered(values: Floats | None, index: Ints | None, corners: Ints) -> Floats | None:
    """The values of some corners, zeros for those that have none."""
    if values is None or index is None:
        return None
    with_zeros = np.concatenate([np.zeros((1, values.shape[1])), values])
    return np.asarray(with_zeros[index[corners] + 1])


def corner_triangles(positions: Floats, sizes: Ints, corners: Ints) -> Ints:
    """Triangles (T, 3) of polygons, as places in `corners`, turned as the polygons are.

    Triangles stay, convex polygons become fans, and others are cut by ear clipping in the plane of
    their mean normal. Polygons with less than three corners have no area and are left out.
    """
    starts = np.concatenate([[0], np.cumsum(sizes)[:-1]]).astype(np.int64)
    parts: list[Ints] = []
    places: list[Ints] = []  # where a triangle's polygon stands, to keep the file's order
    for size in np.unique(sizes[sizes >= 3]):
        chosen = np.flatnonzero(sizes == size)
        rows = starts[chosen][:, None] + np.arange(size)
        steps = np.arange(1, size - 1)
        fans = np.stack(
            [
                np.broadcast_to(rows[:, :1], (len(rows), size - 2)),
                rows[:, steps],
                rows[:, steps + 1],
            ],
            axis=-1,
        )
        if size > 3:
            points = positions[corners[rows]]
            for k in np.flatnonzero(~_fan_is_right(points)):
                fans[k] = _ears(points[k], rows[k], fans[k])
        parts.append(fans.reshape(-1, 3))
        places.append(np.repeat(chosen, size - 2))
    if not parts:
        return np.zeros((0, 3), np.int64)
    order = np.argsort(np.concatenate(places), kind="stable")
    return np.asarray(np.concatenate(parts)[order])


def _fan_is_right(points: Floats) -> NDArray[np.bool_]:
    """For polygons (P, K, 3): whether every triangle of the fan looks where the polygon does."""
    from_first = points[:, 1:] - points[:, :1]
    crosses = np.cross(from_first[:, :-1], from_first[:, 1:])
    # Their sum is twice the polygon's vector area: Newell's normal, also of bent polygons.
    whole = crosses.sum(axis=1)
    along = np.einsum("ptk,pk->pt", crosses, whole)
    # Rounding leaves triangles without area a little on either side.
    return np.asarray((along >= -1e-12 * np.einsum("pk,pk->p", whole, whole)[:, None]).all(axis=1))


def _ears(points: Floats, row: Ints, fan: Ints) -> Ints:
    """Triangles of one polygon that is not convex; its fan if it has no area or crosses itself."""
    import mapbox_earcut

    from_first = points - points[0]
    normal = np.cross(from_first[1:-1], from_first[2:]).sum(axis=0)
    size = float(np.linalg.norm(normal))
    if not (np.isfinite(points).all() and size > 0):
        return fan
    normal = normal / size
    axis = np.eye(3)[np.argmin(np.abs(normal))]
    across = np.cross(axis, normal)
    across /= np.linalg.norm(across)
    flat = np.stack([from_first @ across, from_first @ np.cross(normal, across)], axis=-1)
    ends = np.array([len(flat)], np.uint32)
    ears: Any = mapbox_earcut.triangulate_float64(np.ascontiguousarray(flat), ends)
    found = np.asarray(ears, np.int64).reshape(-1, 3)
    a, b, c = (flat[found[:, k]] for k in range(3))
    twice = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    found[twice < 0] = found[twice < 0][:, ::-1]
    # Corners on a straight line may leave fewer triangles than a fan has; repeated corners fill up.
    missing = len(fan) - len(found)
    if missing < 0 or not len(found):
        return fan
    rest = np.repeat(found[:1, :1], missing, axis=0).repeat(3, axis=1)
    return np.asarray(row[np.concatenate([found, rest])])
