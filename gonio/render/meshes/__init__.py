"""Mesh files, read by format into one kind of triangles.

trimesh was measured to lose what pictures need: it cuts concave polygons into fans, drops uvs of OBJ faces
beside faces without, of glTF parts without a material, sparse accessors and normalised integers, and fails
on indented OBJ lines, on PLY's corner uvs, and on STL solids with other names than it expects.
tinyobjloader fails on continued lines and reads OBJ alone.
"""

from __future__ import annotations

from pathlib import Path

from gonio.render.meshes.gltf import RefusedError, read_gltf
from gonio.render.meshes.obj import read_obj
from gonio.render.meshes.ply import read_ply
from gonio.render.meshes.stl import read_stl
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
        return read_stl(file.read_bytes())
    return read_gltf(file)
