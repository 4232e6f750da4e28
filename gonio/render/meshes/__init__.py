"""Mesh files, read by format into one kind of triangles.

trimesh reads STL. It is not asked for the others, where it was measured to lose what pictures need: it
cuts concave polygons into fans, drops uvs of OBJ faces beside faces without, of glTF parts without a
material, sparse accessors and normalised integers, and fails on indented OBJ lines and on PLY's corner
uvs. No other reader under a permissive licence keeps polygons, uvs of corners and double precision.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from gonio.render.meshes.gltf import RefusedError, read_gltf
from gonio.render.meshes.obj import read_obj
from gonio.render.meshes.ply import read_ply
from gonio.render.triangles import Triangles

__all__ = ["FORMATS", "RefusedError", "read"]

FORMATS = (".obj", ".ply", ".stl", ".glb", ".gltf")


def read(file: Path) -> Triangles:
    """The triangles of a mesh file, in double precision and in the file's own coordinates.

    Whatever the format, uvs have v = 0 at the picture's top row, a missing uv among others is (0, 0),
    and a missing normal among others is a zero vector.

    Raises:
        ValueError: what is wrong with the file.
    """
    suffix = file.suffix.lower()
    if suffix == ".obj":
        return read_obj(file.read_bytes()).triangulated()
    if suffix == ".ply":
        return read_ply(file.read_bytes()).triangulated()
    if suffix == ".stl":
        return _read_stl(file)
    return read_gltf(file)


def _read_stl(file: Path) -> Triangles:
    import trimesh

    loaded: Any = trimesh.load(file, file_type="stl", force="scene", process=False)
    meshes = [m for m in loaded.geometry.values() if isinstance(m, trimesh.Trimesh)]
    positions = [np.asarray(m.triangles, np.float64).reshape(-1, 3) for m in meshes]
    corners = np.concatenate(positions) if positions else np.zeros((0, 3))
    places, faces = np.unique(corners, axis=0, return_inverse=True)
    return Triangles(places, faces.reshape(-1, 3))
