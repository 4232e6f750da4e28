"""The user's own mesh: read from its file, smoothed, and set on the stage."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from gonio.render.triangles import Floats, Triangles, joined

# The mesh of a user is scaled until its bounding sphere has this radius: a shape of any
# proportions, seen from any side, then stays in the frame that the shader ball fills.
MESH_RADIUS = 1.12

MESH_FORMATS = (".obj", ".ply", ".glb")


def load_mesh(path: str | Path) -> Triangles:
    """Reads .obj, .ply (Mitsuba's loaders) or .glb (trimesh, with the scene's transforms applied).

    A file without normals gets none here; see `with_normals`. Needs a Mitsuba variant to be set.
    FileNotFoundError when there is no such file; ValueError with one line when it is not a mesh
    that can be drawn: unknown format, cut short, no triangles, an index or number out of bounds.
    """
    file = existing(path, "mesh", MESH_FORMATS)
    try:
        mesh = _read_trimesh(file) if file.suffix.lower() == ".glb" else _read_native(file)
    except MemoryError:
        raise ValueError(
            f"mesh {file} asks for more memory than there is; is it damaged?"
        ) from None
    except Exception as error:
        # The loaders raise many types (struct.error, KeyError, RuntimeError...) for damaged files.
        raise ValueError(
            f"cannot read mesh {file}; is it damaged or cut short? The reader says: {reason(error)}"
        ) from error
    if len(mesh.faces) == 0 or len(mesh.positions) == 0:
        raise ValueError(f"mesh {file} has no triangles; is it cut short, or only points or lines?")
    if mesh.faces.min() < 0 or mesh.faces.max() >= len(mesh.positions):
        raise ValueError(
            f"mesh {file} has a triangle with a vertex that is not there; export again"
        )
    used = mesh.positions[mesh.faces.ravel()]
    if not np.isfinite(used).all():
        raise ValueError(
            f"mesh {file} has a vertex that is NaN or infinite; repair and export again"
        )
    if not np.ptp(used, axis=0).max() > 0:
        raise ValueError(f"mesh {file} has no extent: all its vertices are one point")
    # A NaN texture coordinate would turn into NaN pixels; 0 only looks wrong.
    return (
        mesh if mesh.uvs is None else replace(mesh, uvs=np.nan_to_num(mesh.uvs, posinf=0, neginf=0))
    )


def reason(error: Exception) -> str:
    """The part of a loader's message that tells something, on one line."""
    text = " ".join(str(error).split()) or type(error).__name__
    for mark in ("Error while loading", "failed to instantiate", "bitmap"):
        _, found, tail = text.rpartition(mark)
        if found and ": " in tail:
            text = tail.partition(": ")[2]
            break
    return text.rstrip("!. ")


def existing(path: str | Path, what: str, formats: tuple[str, ...]) -> Path:
    """path, when it is a readable, non-empty file of one of the formats; raises else."""
    file = Path(path)
    if file.suffix.lower() not in formats:
        raise ValueError(f"cannot use {what} {file}: its name must end in {', '.join(formats)}")
    if not file.exists():
        raise FileNotFoundError(f"no {what} file {file}; the path is taken from {Path.cwd()}")
    if not file.is_file():
        raise ValueError(f"{what} {file} is not a file")
    try:
        with file.open("rb") as stream:
            if not stream.read(1):
                raise ValueError(f"{what} {file} is an empty file")
    except OSError as error:
        raise ValueError(f"cannot open {what} {file}: {error.strerror}") from error
    return file


def _read_native(file: Path) -> Triangles:
    import mitsuba as mi

    # Without normals in the file Mitsuba would average some, with indices that it does not check in
    # a .ply: a damaged file would read foreign memory. So it is told not to; see with_normals.
    kind = file.suffix.lower()[1:]
    description = {
        "type": kind,
        "filename": str(file),
        "face_normals": not (_obj_has_normals if kind == "obj" else _ply_has_normals)(file),
    }
    try:
        return _arrays(mi.load_dict(description))
    except RuntimeError as error:
        polygons = kind == "ply" and "triangle" in str(error)  # quads, as Blender writes them
        # An index that counts back from the last vertex, which Mitsuba takes for a huge one.
        relative = kind == "obj" and "reference to invalid vertex 42949" in str(error)
        if polygons or relative:
            return _read_trimesh(file)
        raise


def _obj_has_normals(file: Path) -> bool:
    """Whether every face of an .obj has normals (f 1//1 or 1/1/1); where only some have, Mitsuba
    leaves the others' memory as it found it."""
    found = False
    with file.open("rb") as lines:
        for line in lines:
            if line.startswith(b"vn "):
                found = True
            elif line.startswith(b"f ") and line.count(b"/") < 2 * (len(line.split()) - 1):
                return False
    return found


def _ply_has_normals(file: Path) -> bool:
    with file.open("rb") as stream:
        header = stream.read(65536).partition(b"end_header")[0]
    return any(line.split()[2:] == [b"nx"] for line in header.splitlines())


def _arrays(mesh: Any) -> Triangles:
    def take(buffer: Any, columns: int) -> Floats:
        return np.array(buffer, dtype=np.float64).reshape(-1, columns)

    return Triangles(
        take(mesh.vertex_positions_buffer(), 3),
        np.array(mesh.faces_buffer(), dtype=np.int64).reshape(-1, 3),
        take(mesh.vertex_normals_buffer(), 3) if mesh.has_vertex_normals() else None,
        take(mesh.vertex_texcoords_buffer(), 2) if mesh.has_vertex_texcoords() else None,
    )


def _read_trimesh(file: Path) -> Triangles:
    import trimesh

    scene = trimesh.load(file, force="scene", process=False)
    parts = []
    for node in scene.graph.nodes_geometry:
        transform, name = scene.graph[node]
        geometry = scene.geometry[name]
        if isinstance(geometry, trimesh.Trimesh) and len(geometry.faces):
            parts.append(_from_trimesh(geometry, np.asarray(transform, dtype=np.float64)))
    if not parts:
        return Triangles(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64))
    return joined(parts)


def _from_trimesh(geometry: Any, transform: Floats) -> Triangles:
    positions = np.asarray(geometry.vertices, dtype=np.float64)
    faces = np.asarray(geometry.faces, dtype=np.int64)
    linear = transform[:3, :3]
    if np.linalg.det(linear) < 0:
        faces = faces[:, ::-1]  # a mirrored node turns its triangles inside out
    normals = None
    # trimesh computes normals when asked; only those that came with the file are wanted here.
    if "vertex_normals" in geometry._cache.cache:
        normals = np.asarray(geometry.vertex_normals, dtype=np.float64) @ np.linalg.pinv(linear)
        length = np.linalg.norm(normals, axis=1, keepdims=True)
        normals = normals / np.where(length > 0, length, 1)
    uv = getattr(geometry.visual, "uv", None)
    uvs = None
    if uv is not None and len(uv) == len(positions):
        uvs = np.asarray(uv, dtype=np.float64) * [1, -1] + [0, 1]  # trimesh has v = 0 at the bottom
    return Triangles(positions @ linear.T + transform[:3, 3], faces, normals, uvs)


FLAT_COSINE = 0.87  # 30 degrees: see with_normals


def with_normals(mesh: Triangles) -> Triangles:
    """The mesh with unit normals: its own, or computed ones where it has none.

    Computed normals are averages over the triangles at a vertex, by area. For a mesh that has none
    at all they are dropped again (None: every triangle flat) when triangles lean from them by 30
    degrees or more on average: that is a cube or a cut stone, and smoothing would show a cushion.
    """
    own = mesh.normals
    if own is not None:
        length = np.linalg.norm(own, axis=1, keepdims=True)
        usable = np.isfinite(length) & (length > 0)
        own = np.where(usable, own, 0) / np.where(usable, length, 1)
        if usable.all():
            return replace(mesh, normals=own)
    a, b, c = (mesh.positions[mesh.faces[:, k]] for k in range(3))
    area_normal = np.cross(b - a, c - a)
    total = np.zeros_like(mesh.positions)
    # Corners at one place may be several vertices (uv seams, .stl-like soups): average over places.
    _, place = np.unique(mesh.positions, axis=0, return_inverse=True)
    place = place.reshape(-1)
    for axis in range(3):
        for corner in range(3):
            total[:, axis] += np.bincount(
                place[mesh.faces[:, corner]], area_normal[:, axis], minlength=len(total)
            )
    length = np.linalg.norm(total, axis=1, keepdims=True)
    normals = (total / np.where(length > 0, length, 1))[place]
    area = np.linalg.norm(area_normal, axis=1)
    lean = np.einsum("ij,ikj->ik", area_normal, normals[mesh.faces]).mean(axis=1)
    normals[length[place, 0] == 0] = (0.0, 1.0, 0.0)  # at a vertex without area: any unit vector
    if own is not None:
        return replace(mesh, normals=np.where(usable, own, normals))
    return mesh if lean.sum() < FLAT_COSINE * area.sum() else replace(mesh, normals=normals)


UP_AXES = ("y", "z")


def on_stage(mesh: Triangles, up: str = "y", turn: float = 0.0) -> Triangles:
    """The mesh turned upright, scaled to the size of the shader ball and stood on the ground.

    up: the file's axis that points up, "y" or "z". turn: degrees about the vertical, counter-
    clockwise seen from above. Scaled so that its bounding sphere has radius MESH_RADIUS.
    """
    if up not in UP_AXES:
        raise ValueError(f"no up axis {up!r}; use one of {', '.join(UP_AXES)}")
    if not np.isfinite(turn):
        raise ValueError(f"turn must be a finite number of degrees, not {turn}")
    angle = np.radians(turn)
    rotation = np.array(
        [[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]]
    )
    if up == "z":
        rotation = rotation @ np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])
    positions = mesh.positions @ rotation.T
    used = positions[np.unique(mesh.faces)]  # stray vertices do not count
    low, high = used.min(axis=0), used.max(axis=0)
    middle = low / 2 + high / 2
    scale = MESH_RADIUS / np.linalg.norm(used - middle, axis=1).max()
    anchor = np.array([middle[0], low[1], middle[2]])
    return replace(
        mesh,
        positions=(positions - anchor) * scale,
        normals=None if mesh.normals is None else mesh.normals @ rotation.T,
    )
