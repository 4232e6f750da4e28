"""Triangle meshes, and those that are turned on a lathe."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Triangles:
    """A triangle mesh in arrays; counter-clockwise seen from outside.

    positions: (V, 3). faces: (F, 3) indices into them. normals: (V, 3) unit, or None when the file
    has none. uvs: (V, 2) as Mitsuba wants them (v = 0 is a picture's top row), or None.
    """

    positions: Floats
    faces: Ints
    normals: Floats | None = None
    uvs: Floats | None = None

    def moved(self, offset: tuple[float, float, float]) -> Triangles:
        """The same mesh, shifted by offset."""
        return replace(self, positions=self.positions + np.asarray(offset))

    def volume(self) -> float:
        """Signed volume; positive when a closed mesh has its outside outside."""
        a, b, c = (self.positions[self.faces[:, k]] for k in range(3))
        return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)

    def face_areas(self) -> Floats:
        """(F,) areas."""
        a, b, c = (self.positions[self.faces[:, k]] for k in range(3))
        return np.asarray(np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2)

    def to_mitsuba(self, name: str, bsdf: Any) -> Any:
        """A `mitsuba.Mesh` of the current variant. bsdf: a dict or a loaded BSDF."""
        import mitsuba as mi

        properties = mi.Properties()
        properties["bsdf"] = mi.load_dict(bsdf) if isinstance(bsdf, dict) else bsdf
        mesh = mi.Mesh(
            name,
            vertex_count=len(self.positions),
            face_count=len(self.faces),
            props=properties,
            has_vertex_normals=self.normals is not None,
            has_vertex_texcoords=self.uvs is not None,
        )
        buffers = mi.traverse(mesh)
        buffers["vertex_positions"] = np.ravel(self.positions).astype(np.float32)
        buffers["faces"] = np.ravel(self.faces).astype(np.uint32)
        if self.normals is not None:
            buffers["vertex_normals"] = np.ravel(self.normals).astype(np.float32)
        if self.uvs is not None:
            buffers["vertex_texcoords"] = np.ravel(self.uvs).astype(np.float32)
        buffers.update()
        return mesh


def grid_faces(rows: int, columns: int, first_is_point: bool, last_is_point: bool) -> Ints:
    """Triangles of a (rows, columns) grid of vertices, row-major; a row that is a single point
    gives one triangle per cell, not two, so that none is degenerate."""
    corner = np.arange(rows * columns).reshape(rows, columns)
    a, b = corner[:-1, :-1], corner[:-1, 1:]
    c, d = corner[1:, :-1], corner[1:, 1:]
    lower = np.stack([a, c, d], axis=-1)[: rows - 1 - last_is_point]
    upper = np.stack([a, d, b], axis=-1)[int(first_is_point) :]
    return np.concatenate([lower.reshape(-1, 3), upper.reshape(-1, 3)])


def lathe(profile: Floats, profile_normals: Floats, segments: int) -> Triangles:
    """A profile turned about the y axis.

    profile: (K, 2) of (radius, height), from the top down the outside. profile_normals: (K, 2),
    unit, pointing out of the solid. A radius of 0 at either end closes the surface there.
    uvs: u once around, from the back (-z) eastwards; v along the profile by arc length.
    """
    turn = np.linspace(0, 2 * np.pi, segments + 1)
    east, south = -np.sin(turn), -np.cos(turn)  # u = 0 at the back, where no camera sees the seam
    east[-1], south[-1] = east[0], south[0]  # exactly closed

    def revolve(curve: Floats) -> Floats:
        r, y = curve[:, :1], curve[:, 1:]
        return np.stack([r * east, np.broadcast_to(y, (len(r), segments + 1)), r * south], axis=-1)

    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(profile, axis=0), axis=1))])
    u, v = np.meshgrid(turn / (2 * np.pi), length / length[-1])
    return Triangles(
        positions=revolve(profile).reshape(-1, 3),
        faces=grid_faces(
            len(profile), segments + 1, bool(profile[0, 0] == 0), bool(profile[-1, 0] == 0)
        ),
        normals=revolve(profile_normals).reshape(-1, 3),
        uvs=np.stack([u, v], axis=-1).reshape(-1, 2),
    )


def rounded(corners: list[tuple[float, float, float]], steps: int = 8) -> tuple[Floats, Floats]:
    """Points and outward normals along a polygon (x, y, rounding radius), going clockwise around
    the solid; straight pieces get two points each, so that their normals stay flat."""
    points, normals = [], []
    xy = np.array([c[:2] for c in corners])
    direction = np.diff(xy, axis=0)
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    outward = np.stack([-direction[:, 1], direction[:, 0]], axis=-1)
    points.append(xy[0])
    normals.append(outward[0])
    for k in range(1, len(corners) - 1):
        turn = np.arccos(np.clip(direction[k - 1] @ direction[k], -1, 1))
        back = corners[k][2] * np.tan(turn / 2)
        left_turn = np.cross(np.append(direction[k - 1], 0), np.append(direction[k], 0))[2] > 0
        side = 1.0 if left_turn else -1.0
        start = xy[k] - back * direction[k - 1]
        centre = start + side * corners[k][2] * outward[k - 1]
        for t in np.linspace(0, 1, steps + 1):
            w = np.sin((1 - t) * turn) * outward[k - 1] + np.sin(t * turn) * outward[k]
            n = w / np.linalg.norm(w)
            points.append(centre - side * corners[k][2] * n)
            normals.append(n)
    points.append(xy[-1])
    normals.append(outward[-1])
    return np.array(points), np.array(normals)


def joined(parts: list[Triangles]) -> Triangles:
    """Several meshes as one; where only some have normals or uvs, the others' are zeros."""
    starts = np.cumsum([0, *(len(p.positions) for p in parts[:-1])])

    def together(arrays: list[Floats | None], width: int) -> Floats | None:
        if all(a is None for a in arrays):
            return None
        sizes = [len(p.positions) for p in parts]
        filled = [
            np.zeros((n, width)) if a is None else a for a, n in zip(arrays, sizes, strict=True)
        ]
        return np.concatenate(filled)

    return Triangles(
        np.concatenate([p.positions for p in parts]),
        np.concatenate([p.faces + s for p, s in zip(parts, starts, strict=True)]),
        together([p.normals for p in parts], 3),
        together([p.uvs for p in parts], 2),
    )
