"""The user's own mesh: read from its file, smoothed, and set on the stage."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from gonio.render import meshes
from gonio.render.triangles import Floats, Ints, Triangles

# The mesh of a user is scaled until its bounding sphere has this radius: a shape of any
# proportions, seen from any side, then stays in the frame that the shader ball fills.
MESH_RADIUS = 1.12

# Height of a mesh's lowest point: a floor of its own, or a mesh that is flat, would else share the ground's
# plane, and rays would hit now the one and now the other. Too little to be seen.
LIFT = 1e-3 * MESH_RADIUS

MESH_FORMATS = meshes.FORMATS

LARGEST = 1e100  # its square and its inverse are numbers, too
SLIVER = 1e-14  # of the squared extent: an area that nothing can be seen of


def load_mesh(path: str | Path) -> Triangles:
    """Reads .obj, .ply, .stl, .glb or .gltf (see `gonio.render.meshes`).

    A file without normals gets none here; see `with_normals`.
    FileNotFoundError when there is no such file; ValueError with one line when it is not a mesh
    that can be drawn: unknown format, cut short, no triangles, an index or number out of bounds.
    """
    file = existing(path, "mesh", MESH_FORMATS)
    try:
        with np.errstate(all="ignore"):  # numbers that are not finite are found below
            mesh = meshes.read(file)
    except MemoryError:
        raise ValueError(
            f"mesh {file} asks for more memory than there is; is it damaged?"
        ) from None
    except meshes.RefusedError as error:
        raise ValueError(f"cannot use mesh {file}: {error}") from None
    except Exception as error:
        # Damaged files raise many types (struct.error, KeyError, TypeError...) beside ValueError.
        raise ValueError(
            f"cannot read mesh {file}; is it damaged or cut short? The reader says: {reason(error)}"
        ) from error
    if len(mesh.faces) == 0 or len(mesh.positions) == 0:
        raise ValueError(f"mesh {file} has no triangles; is it cut short, or only points or lines?")
    used = mesh.positions[mesh.faces.ravel()]
    if not np.isfinite(used).all():
        raise ValueError(
            f"mesh {file} has a vertex that is NaN or infinite; repair and export again"
        )
    extent = float(np.ptp(used, axis=0).max())
    if not extent > 0:
        raise ValueError(f"mesh {file} has no extent: all its vertices are one point")
    if not 1 / LARGEST < extent < LARGEST:
        raise ValueError(f"mesh {file} is {extent:.3g} wide; give it a usual size")
    # Rounding leaves a little area to triangles whose corners are on a line.
    if not mesh.face_areas().max() > SLIVER * extent**2:
        raise ValueError(
            f"mesh {file} has no area: the corners of each of its triangles are on a line"
        )
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


# Computed normals are smooth across edges up to this angle between two triangles, which rounds what was
# modelled round (a tube of ten sides turns by 36 degrees) and keeps the edges of boxes and cut stones.
CREASE_COSINE = float(np.cos(np.radians(40.0)))
CROWD = 64  # more triangles around one point are a cap or a pole: smooth, or the pairs would be too many


def with_normals(mesh: Triangles) -> Triangles:
    """The mesh with unit normals at its vertices: its own, or computed ones where it has none.

    Computed normals are averages, by angle, over the triangles around a place. Where a mesh has none
    at all, triangles that meet at more than 40 degrees are kept apart, and vertices doubled for it.
    """
    own = mesh.normals
    if own is not None:
        length = np.linalg.norm(own, axis=1, keepdims=True)
        usable = np.isfinite(length) & (length > 0)
        own = np.where(usable, own, 0) / np.where(usable, length, 1)
        if usable.all():
            return replace(mesh, normals=own)
    # Corners at one place may be several vertices (uv seams, soups of triangles): average over places.
    _, place = np.unique(mesh.positions, axis=0, return_inverse=True)
    corner_place = place.reshape(-1)[mesh.faces].reshape(-1)
    face_normal, angle = _face_normals_and_angles(mesh)
    weighted = np.repeat(face_normal, 3, axis=0) * angle.reshape(-1, 1)
    smooth = _unit(_sums(corner_place, weighted, len(mesh.positions)))
    if own is not None:
        return replace(mesh, normals=np.where(usable, own, smooth[place.reshape(-1)]))
    normals = smooth[corner_place]
    apart = _creased(corner_place, np.repeat(face_normal, 3, axis=0), weighted, normals)
    corner_normals = normals.copy()
    corner_normals[apart.corners] = apart.normals
    return _split(mesh, corner_normals, apart.corners)


def _face_normals_and_angles(mesh: Triangles) -> tuple[Floats, Floats]:
    """Unit normals (F, 3), zero where there is no area, and the angles (F, 3) of the corners."""
    points = mesh.positions[mesh.faces]
    ahead = np.roll(points, -1, axis=1) - points
    size = np.linalg.norm(ahead, axis=-1, keepdims=True)
    ahead = ahead / np.where(size > 0, size, 1)
    back = -np.roll(ahead, 1, axis=1)
    normal = _unit(np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0]), 0.0)
    angle = np.arccos(np.clip(np.einsum("fck,fck->fc", ahead, back), -1, 1))
    return normal, angle


def _sums(index: Ints, vectors: Floats, count: int) -> Floats:
    return np.stack(
        [np.bincount(index, vectors[:, axis], minlength=count) for axis in range(3)], axis=-1
    )


def _unit(vectors: Floats, up: float = 1.0) -> Floats:
    """Unit vectors; (0, up, 0) for those without length."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    good = length > 1e-12 * max(float(length.max(initial=0.0)), 1e-300)
    return np.asarray(np.where(good, vectors / np.where(good, length, 1), [0.0, up, 0.0]))


@dataclass(frozen=True)
class _Apart:
    """Corners whose normals are not the average of their place, and what they are instead."""

    corners: Ints
    normals: Floats


def _creased(place: Ints, flat: Floats, weighted: Floats, smooth: Floats) -> _Apart:
    """Averages over only those triangles around a corner that meet its own within the crease angle."""
    has_area = np.abs(flat).max(axis=1) > 0
    # Within half the angle of the average all are within the angle of each other.
    half = np.sqrt((1 + CREASE_COSINE) / 2)
    leaning = has_area & (np.einsum("ck,ck->c", flat, smooth) < half)
    count = np.bincount(place)
    sharp = np.zeros(len(count), bool)
    sharp[place[leaning]] = True
    sharp &= count <= CROWD
    corners = np.flatnonzero(sharp[place])
    corners = corners[np.argsort(place[corners], kind="stable")]
    normals = np.zeros((len(corners), 3))
    sizes = count[place[corners]]
    for size in np.unique(sizes):
        rows = np.flatnonzero(sizes == size).reshape(-1, size)
        for chunk in np.array_split(rows, -(-rows.size * int(size) // (1 << 21))):
            here = corners[chunk]
            near = np.einsum("pik,pjk->pij", flat[here], flat[here]) >= CREASE_COSINE
            normals[chunk] = np.einsum("pij,pjk->pik", near, weighted[here])
    # A triangle without area has no side of its own.
    found = np.linalg.norm(normals, axis=1, keepdims=True) > 0
    return _Apart(corners, np.where(found, _unit(normals), smooth[corners]))


def _split(mesh: Triangles, corner_normals: Floats, apart: Ints) -> Triangles:
    """The mesh with normals; vertices are doubled whose corners have different ones."""
    faces = mesh.faces.reshape(-1).copy()
    normals = np.zeros_like(mesh.positions)
    normals[:, 1] = 1
    normals[faces] = corner_normals
    rounded = np.round(corner_normals[apart] * 1e6).astype(np.int64)
    key = np.concatenate([faces[apart, None], rounded], axis=1)
    _, first, new = np.unique(key, axis=0, return_index=True, return_inverse=True)
    doubled = faces[apart[first]]
    faces[apart] = len(mesh.positions) + new.reshape(-1)
    return Triangles(
        np.concatenate([mesh.positions, mesh.positions[doubled]]),
        faces.reshape(-1, 3),
        np.concatenate([normals, corner_normals[apart[first]]]),
        None if mesh.uvs is None else np.concatenate([mesh.uvs, mesh.uvs[doubled]]),
    )


UP_AXES = ("y", "z")


def on_stage(mesh: Triangles, up: str = "y", turn: float = 0.0) -> Triangles:
    """The mesh turned upright, scaled to the size of the shader ball and stood on the ground.

    up: the file's axis that points up, "y" or "z". turn: degrees about the vertical, counter-
    clockwise seen from above. Scaled so that its bounding sphere has radius MESH_RADIUS; lies LIFT above.
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
        positions=(positions - anchor) * scale + np.array([0, LIFT, 0]),
        normals=None if mesh.normals is None else mesh.normals @ rotation.T,
    )
