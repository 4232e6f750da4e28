"""The pictures' stage: a shader ball built by code, its lights, and the user's own mesh or sky.

Everything here returns what `mitsuba.load_dict` takes. Axes: +y is up, the camera looks along -z
from the front, the ground is y = 0, lengths are in radii of the shader ball (it has radius 1).
Radiance is scaled so that a white diffuse surface facing the key light comes out just below 1.
"""

from __future__ import annotations

import difflib
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

BALL_CENTRE = 1.2  # height above the ground: radius 1 plus what the pedestal's lip lifts it
SHELL_INSIDE = 0.9  # inner radius of the shell, the outer one being 1
CORE_RADIUS = 0.7  # the sphere inside: leaves a gap of twice the wall, wide enough to be lit
BEVEL = 0.022  # radius of the rounding on the shell's edges: a highlight three pixels wide at 1024

# The mesh of a user is scaled until its bounding sphere has this radius: a shape of any
# proportions, seen from any side, then stays in the frame that the shader ball fills.
MESH_RADIUS = 1.12

MAX_PIXELS = 16384  # per side; more is a slip of the keyboard and would take all memory

TESTED = ("shell", "core", "mesh")  # the shapes that wear the material under test

MESH_FORMATS = (".obj", ".ply", ".glb")
IMAGE_FORMATS = (".exr", ".hdr")
HALF_MAX = 65504.0  # largest half float: what an overflowed sun pixel (inf) stood for


# ---------------------------------------------------------------------------------------- meshes


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


def _grid_faces(rows: int, columns: int, first_is_point: bool, last_is_point: bool) -> Ints:
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
        faces=_grid_faces(
            len(profile), segments + 1, bool(profile[0, 0] == 0), bool(profile[-1, 0] == 0)
        ),
        normals=revolve(profile_normals).reshape(-1, 3),
        uvs=np.stack([u, v], axis=-1).reshape(-1, 2),
    )


def sphere(radius: float, rows: int = 128) -> Triangles:
    """A sphere about the origin by the lathe, 2 * rows segments around."""
    theta = np.linspace(0, np.pi, rows + 1)
    arc = np.stack([np.sin(theta), np.cos(theta)], axis=-1)
    arc[0], arc[-1] = (0, 1), (0, -1)  # sin(pi) is not 0 in floating point
    return lathe(radius * arc, arc, 2 * rows)


def pedestal(segments: int = 256) -> Triangles:
    """The turned ring that carries the ball: foot at y = 0, lip against a ball of radius 1 whose
    centre is at BALL_CENTRE."""
    # Corners of the profile with the radius of their rounding; the lip leans against the ball.
    corners = [
        (0.0, 0.2, 0.0),
        (0.42, 0.2, 0.03),
        (0.475, 0.33, 0.02),
        (0.56, 0.33, 0.022),
        (0.59, 0.14, 0.1),
        (0.72, 0.11, 0.03),
        (0.72, 0.0, 0.012),
        (0.0, 0.0, 0.0),
    ]
    return lathe(*_rounded(corners), segments)


def _rounded(corners: list[tuple[float, float, float]], steps: int = 8) -> tuple[Floats, Floats]:
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


# The cut looks to the camera's left and a little up, towards the key light.
CUT_AZIMUTH, CUT_ELEVATION = -34.0, 16.0
CUT_HALF_WIDTH, CUT_HALF_HEIGHT = 43.0, 50.0  # degrees, as seen from the centre


def _direction(azimuth: float, elevation: float) -> Floats:
    """Unit vector; azimuth 0 towards the camera (+z), positive to its right, in degrees."""
    a, e = np.radians(azimuth), np.radians(elevation)
    return np.array([np.cos(e) * np.sin(a), np.sin(e), np.cos(e) * np.cos(a)])


def _cut_edge(count: int) -> tuple[Floats, Floats]:
    """The cut's rim on the unit sphere: (count + 1, 3) points, closed, clockwise seen from outside
    (so with the shell on the left), and the unit tangents of the sphere there that point across
    the rim into the cut."""
    # A superellipse in the plane that touches the sphere at the cut's axis: great-circle sides,
    # and corners so round that the bevel has room.
    a, b = np.tan(np.radians([CUT_HALF_WIDTH, CUT_HALF_HEIGHT]))
    psi = np.linspace(0, -2 * np.pi, 8193)
    power = 5
    rho = (np.abs(np.cos(psi) / a) ** power + np.abs(np.sin(psi) / b) ** power) ** (-1 / power)
    axis = _direction(CUT_AZIMUTH, CUT_ELEVATION)
    right = np.cross([0.0, 1.0, 0.0], axis)
    right /= np.linalg.norm(right)
    up = np.cross(axis, right)
    rim = axis + rho[:, None] * (np.cos(psi)[:, None] * right + np.sin(psi)[:, None] * up)
    rim /= np.linalg.norm(rim, axis=1, keepdims=True)
    # Even steps of arc length: even quads on the bevel, in the corners too.
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(rim, axis=0), axis=1))])
    wanted = np.linspace(0, length[-1], count + 1)
    even = np.stack([np.interp(wanted, length, rim[:, k]) for k in range(3)], axis=-1)
    even /= np.linalg.norm(even, axis=1, keepdims=True)
    even[-1] = even[0]
    along = np.roll(even[:-1], -1, axis=0) - np.roll(even[:-1], 1, axis=0)
    into = np.cross(along, even[:-1])
    into /= np.linalg.norm(into, axis=1, keepdims=True)
    return even, np.concatenate([into, into[:1]])


def _sphere_uv(position: Floats) -> Floats:
    """Longitude from the back (-z) eastwards and latitude from the top, both in 0..1."""
    d = position / np.linalg.norm(position, axis=-1, keepdims=True)
    u = np.arctan2(-d[..., 0], -d[..., 2]) / (2 * np.pi) % 1
    return np.stack([u, np.arccos(np.clip(d[..., 1], -1, 1)) / np.pi], axis=-1)


def _without_seam(mesh: Triangles) -> Triangles:
    """Doubles the vertices where u jumps from 1 to 0, so that no triangle spans the jump."""
    assert mesh.normals is not None
    assert mesh.uvs is not None
    u = mesh.uvs[mesh.faces, 0]
    wraps = np.ptp(u, axis=1) > 0.5
    behind = (u < 0.5) & wraps[:, None]
    doubled, place = np.unique(mesh.faces[behind], return_inverse=True)
    faces = mesh.faces.copy()
    faces[behind] = len(mesh.positions) + place
    return Triangles(
        np.concatenate([mesh.positions, mesh.positions[doubled]]),
        faces,
        np.concatenate([mesh.normals, mesh.normals[doubled]]),
        np.concatenate([mesh.uvs, mesh.uvs[doubled] + [1.0, 0.0]]),
    )


def shell(columns: int = 384, outer_rows: int = 112, inner_rows: int = 56) -> Triangles:
    """The ball's outer shell about the origin, radii SHELL_INSIDE to 1, with its cut; closed.

    The wall of the cut is swept along the rim in the plane perpendicular to it, which makes the
    normals below exact: on a sphere neither the radius nor the across-direction turns out of that
    plane along the way. uvs are longitude and latitude; on the wall they run on across the edge.
    """
    rim, into = _cut_edge(columns)

    # Two quarter circles with the flat wall between: the distance from the centre, the arc length
    # behind the rim, and the normal's parts along the radius and along `into`.
    bend = np.linspace(0, np.pi / 2, 7)
    rise, fall = np.cos(bend), np.cos(bend[::-1])
    r = np.concatenate([1 - BEVEL * (1 - rise), SHELL_INSIDE + BEVEL * (1 - fall)])[:, None, None]
    n_r = np.concatenate([rise, -fall])[:, None, None]
    n_i = np.concatenate([np.sin(bend), np.sin(bend[::-1])])[:, None, None]
    back = BEVEL * (1 - n_i)
    angle = back / r
    radial = np.cos(angle) * rim - np.sin(angle) * into
    across = np.cos(angle) * into + np.sin(angle) * rim
    wall = r * radial
    wall_normals = n_r * radial + n_i * across

    def cap(edge: Floats, rows: int) -> Floats:
        """From an edge over the back of the sphere to the point opposite to the cut; unit."""
        pole = -_direction(CUT_AZIMUTH, CUT_ELEVATION)
        edge = edge / np.linalg.norm(edge, axis=-1, keepdims=True)
        reach = np.arccos(np.clip(edge @ pole, -1, 1))[:, None]
        t = np.linspace(1, 0, rows + 1)[:, None, None]
        arc = (np.sin(t * reach) * edge + np.sin((1 - t) * reach) * pole) / np.sin(reach)
        arc[-1] = pole
        return arc

    outside = cap(wall[0], outer_rows)[::-1]  # from the pole to the rim, on to the wall
    inside = cap(wall[-1], inner_rows)

    # Across the edge the texture goes on as if the wall were folded up into the sphere; the fold
    # is measured in angles, as longitude and latitude are.
    wall_uv = _sphere_uv(rim + (1 - r - back) * into)
    front = np.concatenate([outside[:-1], wall])
    rows = len(front)
    first = _without_seam(
        Triangles(
            front.reshape(-1, 3),
            _grid_faces(rows, columns + 1, True, False),
            np.concatenate([outside[:-1], wall_normals]).reshape(-1, 3),
            np.concatenate([_sphere_uv(outside[:-1]), wall_uv]).reshape(-1, 2),
        )
    )
    second = _without_seam(
        Triangles(
            SHELL_INSIDE * inside.reshape(-1, 3),
            _grid_faces(inner_rows + 1, columns + 1, False, True),
            -inside.reshape(-1, 3),
            _sphere_uv(inside).reshape(-1, 2),
        )
    )
    return _joined([first, second])


def _joined(parts: list[Triangles]) -> Triangles:
    """Several meshes as one; normals and uvs survive only when all parts have them."""
    starts = np.cumsum([0, *(len(p.positions) for p in parts[:-1])])

    def all_or_none(arrays: list[Floats | None]) -> Floats | None:
        present = [a for a in arrays if a is not None]
        return np.concatenate(present) if len(present) == len(arrays) else None

    return Triangles(
        np.concatenate([p.positions for p in parts]),
        np.concatenate([p.faces + s for p, s in zip(parts, starts, strict=True)]),
        all_or_none([p.normals for p in parts]),
        all_or_none([p.uvs for p in parts]),
    )


# ------------------------------------------------------------------------------- the user's mesh


def load_mesh(path: str | Path) -> Triangles:
    """Reads .obj, .ply (Mitsuba's loaders) or .glb (trimesh, with the scene's transforms applied).

    A file without normals gets none here; see `with_normals`. Needs a Mitsuba variant to be set.
    FileNotFoundError when there is no such file; ValueError with one line when it is not a mesh
    that can be drawn: unknown format, cut short, no triangles, an index or number out of bounds.
    """
    file = _existing(path, "mesh", MESH_FORMATS)
    try:
        mesh = _read_trimesh(file) if file.suffix.lower() == ".glb" else _read_native(file)
    except MemoryError:
        raise ValueError(
            f"mesh {file} asks for more memory than there is; is it damaged?"
        ) from None
    except Exception as error:
        # The loaders raise many types (struct.error, KeyError, RuntimeError...) for damaged files.
        raise ValueError(
            f"cannot read mesh {file}; is it damaged or cut short? The reader says: "
            f"{_reason(error)}"
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


def _reason(error: Exception) -> str:
    """The part of a loader's message that tells something, on one line."""
    text = " ".join(str(error).split()) or type(error).__name__
    for mark in ("Error while loading", "failed to instantiate", "bitmap"):
        _, found, tail = text.rpartition(mark)
        if found and ": " in tail:
            text = tail.partition(": ")[2]
            break
    return text.rstrip("!. ")


def _existing(path: str | Path, what: str, formats: tuple[str, ...]) -> Path:
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
    return _joined(parts)


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


# ------------------------------------------------------------------------------ light and ground

Colour = tuple[float, float, float]
Nodes = dict[str, object]


def _rgb(value: Colour | float) -> Nodes:
    # Always {"type": "rgb"}: a bare number would be an equal-energy spectrum in spectral variants,
    # which is pink next to the white point of the picture.
    return {"type": "rgb", "value": list(value) if isinstance(value, tuple) else [value] * 3}


def _softbox(
    azimuth: float,
    elevation: float,
    distance: float,
    size: tuple[float, float],
    irradiance: float,
    colour: Colour = (1.0, 1.0, 1.0),
    shape: str = "rectangle",
    share: float = 1.0,
) -> Nodes:
    """A flat lamp (rectangle or disk) turned towards the ball.

    Angles in degrees as in `_direction`; size: full width and height; irradiance: what arrives at
    the ball's centre on a surface that faces the lamp (a white Lambertian then shows 1/pi of it).
    share: how often the lamp is chosen for a shadow ray, relative to the others.
    """
    import mitsuba as mi

    centre = np.array([0.0, BALL_CENTRE, 0.0])
    place = centre + distance * _direction(azimuth, elevation)
    area = size[0] * size[1] * (1.0 if shape == "rectangle" else np.pi / 4)
    radiance = irradiance * distance**2 / area
    to_world = mi.ScalarTransform4f().look_at(
        origin=place.tolist(), target=centre.tolist(), up=[0, 1, 0]
    ) @ mi.ScalarTransform4f().scale([size[0] / 2, size[1] / 2, 1])
    return {
        "type": shape,
        "to_world": to_world,
        "emitter": {
            "type": "area",
            "radiance": _rgb((radiance * colour[0], radiance * colour[1], radiance * colour[2])),
            "sampling_weight": share,
        },
    }


def _surround(radiance: float | Colour, share: float = 1.0) -> Nodes:
    # Beside lamps the share is 0: paths that leave the scene by the material's own sampling find
    # the surround with less noise, and the shadow rays are all left for the lamps.
    return {"type": "constant", "radiance": _rgb(radiance), "sampling_weight": share}


GROUND_GREY = 0.32


def _sweep() -> Triangles:
    """The paper backdrop of a studio: floor, curve and wall in one piece, smooth."""
    front, back, length, height, half_width = 14.0, -3.0, 13.0, 16.0, 24.0
    # The slope eases in and out along the curve; a plain quarter circle shows a line at both ends.
    t = np.linspace(0, 1, 97)
    slope = np.pi / 2 * t**2 * (3 - 2 * t)

    def along(speed: Floats) -> Floats:
        steps = (speed[1:] + speed[:-1]) / 2 * length / (len(t) - 1)
        return np.concatenate([[0.0], np.cumsum(steps)])

    rise, run = along(np.sin(slope)), along(np.cos(slope))
    y = np.concatenate([[0.0], rise, [height]])
    z = np.concatenate([[front], back - run, [back - run[-1]]])
    n_y = np.concatenate([[1.0], np.cos(slope), [0.0]])
    n_z = np.concatenate([[0.0], np.sin(slope), [1.0]])
    x = np.array([half_width, -half_width])

    def spread(first: Floats, second: Floats, third: Floats) -> Floats:
        columns = np.broadcast_arrays(first[None, :], second[:, None], third[:, None])
        return np.stack(columns, axis=-1).reshape(-1, 3)

    u, v = np.meshgrid([1.0, 0.0], np.linspace(1, 0, len(y)))
    return Triangles(
        spread(x, y, z),
        _grid_faces(len(y), 2, False, False),
        spread(np.zeros(2), n_y, n_z),
        np.stack([u, v], axis=-1).reshape(-1, 2),
    )


def _turntable(radius: float, segments: int = 256) -> Triangles:
    """A flat round slab with its top at y = 0."""
    corners = [(0.0, 0.0, 0.0), (radius, 0.0, 0.03), (radius, -0.1, 0.02), (0.0, -0.1, 0.0)]
    return lathe(*_rounded(corners), segments)


def _grey(value: float) -> Nodes:
    return {"type": "diffuse", "reflectance": _rgb(value)}


def _studio_ground() -> Nodes:
    return {"ground": _sweep().to_mitsuba("ground", _grey(GROUND_GREY))}


def _table_ground() -> Nodes:
    return {"ground": _turntable(2.6).to_mitsuba("ground", _grey(GROUND_GREY))}


KEY, WARM, COOL = (1.0, 0.975, 0.94), (1.0, 0.94, 0.86), (0.9, 0.95, 1.0)


def _studio() -> Nodes:
    """Big key from the upper left, weak fill from the right, a strip behind for the rim."""
    return {
        "key": _softbox(-54, 42, 6.0, (4.6, 4.6), 2.9, KEY, share=4),
        "fill": _softbox(72, 16, 7.0, (2.4, 6.0), 0.25, COOL),
        "rim": _softbox(128, 48, 7.0, (5.0, 2.0), 1.0, WARM, share=2),
        "surround": _surround(0.09, share=0),
        **_studio_ground(),
    }


def _sun() -> Nodes:
    """A hard, warm sun from the side over the studio's dim cool surround."""
    return {
        # 2 degrees across: four times the real sun, so that its shadows' edges are still seen
        "sun": _softbox(-62, 38, 16.0, (0.56, 0.56), 2.8, (1.0, 0.94, 0.85), "disk"),
        "surround": _surround((0.08, 0.1, 0.13), share=0),
        **_studio_ground(),
    }


def _front() -> Nodes:
    """One small lamp beside the camera: what flattens a rough diffuse ball into a disk."""
    return {
        "lamp": _softbox(6, 22, 9.0, (1.2, 1.2), 2.6, shape="disk"),
        "surround": _surround(0.02, share=0),
        **_studio_ground(),
    }


def _side() -> Nodes:
    """One small lamp at a right angle to the view: what shows the terminator."""
    return {
        "lamp": _softbox(90, 14, 9.0, (1.2, 1.2), 2.6, shape="disk"),
        "surround": _surround(0.02, share=0),
        **_studio_ground(),
    }


def _white() -> Nodes:
    """Radiance 1 from everywhere."""
    return {"surround": _surround(1.0), **_table_ground()}


def _sunsky() -> Nodes:
    """Mitsuba's sun and clear sky over wide grey ground."""
    import mitsuba as mi

    if "mono" in str(mi.variant()):
        raise ValueError("environment 'sunsky' needs colour; use an rgb or spectral variant")
    sun = _direction(-55, 38)
    return {
        "sky": {
            "type": "sunsky",
            "sun_direction": sun.tolist(),
            "turbidity": 3.5,
            "albedo": _rgb(GROUND_GREY),
            "sun_aperture": 2.0,
            "to_world": mi.ScalarTransform4f().rotate([1, 0, 0], -90),  # its zenith is +z
            "sky_scale": SKY_SCALE,
            "sun_scale": SKY_SCALE,
        },
        "ground": _turntable(120.0).to_mitsuba("ground", _grey(GROUND_GREY)),
    }


SKY_SCALE = 1.7  # brings white in the sun to about 0.9

ENVIRONMENTS: dict[str, Callable[[], Nodes]] = {
    "studio": _studio,
    "sun": _sun,
    "front": _front,
    "side": _side,
    "white": _white,
    "sunsky": _sunsky,
}


def environment_nodes(environment: str | Path, turn: float = 0.0) -> Nodes:
    """Lights and ground as scene nodes, by name (see ENVIRONMENTS) or from an .exr or .hdr file.

    turn: degrees about the vertical by which a picture is turned; its middle is behind the object.
    Infinite pixels count as the largest half float and negative ones as 0. ValueError for an
    unknown name or a file that is no picture, FileNotFoundError for one that does not exist.
    """
    name = str(environment)
    if isinstance(environment, str) and name in ENVIRONMENTS:
        return ENVIRONMENTS[name]()
    if Path(name).suffix == "" and not Path(name).is_file():
        near = difflib.get_close_matches(name, ENVIRONMENTS, n=1)
        guess = f"did you mean {near[0]!r}? Known" if near else "known"
        raise ValueError(
            f"no environment {name!r}; {guess}: {', '.join(ENVIRONMENTS)}, or a path to an "
            f"{' or '.join(IMAGE_FORMATS)} file"
        )
    return {"sky": _picture_light(Path(name), turn), **_table_ground()}


def _picture_light(path: Path, turn: float) -> Nodes:
    import mitsuba as mi

    file = _existing(path, "environment", IMAGE_FORMATS)
    try:
        bitmap = mi.Bitmap(str(file)).convert(
            mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, srgb_gamma=False
        )
        pixels = np.array(bitmap, dtype=np.float32)
    except Exception as error:
        raise ValueError(
            f"cannot read environment {file}; is it damaged? The reader says: {_reason(error)}"
        ) from error
    if np.isnan(pixels).any():
        raise ValueError(f"environment {file} has NaN pixels; repair it in an image editor")
    pixels = np.clip(pixels, 0, HALF_MAX)
    if min(pixels.shape[:2]) < 2 or not pixels.max() > 0:
        raise ValueError(f"environment {file} has no light in it")
    return {
        "type": "envmap",
        "bitmap": mi.Bitmap(pixels),
        # Mitsuba has the middle of the picture at +z, behind the camera.
        "to_world": mi.ScalarTransform4f().rotate([0, 1, 0], 180 + turn),
    }


# -------------------------------------------------------------------------------------- the scene

FURNACE_DEPTH = 256  # at 64 a white cavity still keeps a tenth of its light
FIELD_OF_VIEW = 20.0  # degrees, of the shorter side: a long lens, so that the ball stays round


def _sensor(size: tuple[int, int], spp: int, target: float) -> Nodes:
    """Looks down a little at (0, target, 0)."""
    import mitsuba as mi

    middle = np.array([0.0, target, 0.0])
    place = middle + 9.6 * _direction(0, 13)
    return {
        "type": "perspective",
        "fov": FIELD_OF_VIEW,
        "fov_axis": "smaller",
        "to_world": mi.ScalarTransform4f().look_at(
            origin=place.tolist(), target=middle.tolist(), up=[0, 1, 0]
        ),
        "film": {
            "type": "hdrfilm",
            "width": size[0],
            "height": size[1],
            "pixel_format": "luminance" if "mono" in str(mi.variant()) else "rgb",
            "component_format": "float32",
            "rfilter": {"type": "gaussian"},
        },
        "sampler": {"type": "multijitter", "sample_count": spp},
    }


def _check_size(size: tuple[int, int]) -> tuple[int, int]:
    try:
        width, height = (int(s) for s in size)
    except (TypeError, ValueError):
        raise ValueError(f"size must be (width, height) in pixels, not {size!r}") from None
    if not (1 <= width <= MAX_PIXELS and 1 <= height <= MAX_PIXELS):
        raise ValueError(f"size must be 1 to {MAX_PIXELS} pixels a side, not {width} x {height}")
    return width, height


def _for_both_sides(bsdf: Any) -> Any:
    """The BSDF, made two-sided unless it lets light through."""
    import mitsuba as mi

    transmits = mi.has_flag(bsdf.flags(), mi.BSDFFlags.Transmission)
    if transmits or mi.has_flag(bsdf.flags(), mi.BSDFFlags.Null):
        return bsdf
    back = any(
        mi.has_flag(bsdf.flags(k), mi.BSDFFlags.BackSide) for k in range(bsdf.component_count())
    )
    return bsdf if back else mi.load_dict({"type": "twosided", "material": bsdf})


def shader_ball(
    bsdf: dict[str, object],
    *,
    environment: str | Path = "studio",
    mesh: str | Path | None = None,
    size: tuple[int, int] = (512, 512),
    furnace: bool = False,
    spp: int = 64,
    max_depth: int = 12,
    up: str = "y",
    turn: float = 0.0,
    environment_turn: float = 0.0,
) -> Nodes:
    """A scene for `mitsuba.load_dict` that shows a material.

    bsdf: a Mitsuba material as a dict. It goes on the shader ball's shell and core, or on the mesh:
    an .obj, .ply or .glb file, scaled to the ball's size, `up` its vertical axis ("y" or "z"),
    turned by `turn` degrees; there it is made two-sided, since cloth and scans are open surfaces.
    environment: a name in ENVIRONMENTS or an .exr or .hdr file, turned by `environment_turn`
    degrees. size: (width, height) in pixels. spp: samples per pixel the scene asks for.
    furnace: only the object, in radiance 1 from everywhere; a material that loses no light cannot
    be seen against the background.

    Set a Mitsuba variant first; the dict holds loaded meshes and belongs to that variant.
    Raises ValueError or FileNotFoundError, one line, for anything that cannot be used.
    """
    import mitsuba as mi

    if mi.variant() is None:
        raise ValueError("no Mitsuba variant is set; call mitsuba.set_variant('llvm_ad_rgb') first")
    size = _check_size(size)
    if spp < 1 or max_depth < 1:
        raise ValueError(f"spp and max_depth must be at least 1, not {spp} and {max_depth}")
    material = mi.load_dict(bsdf)
    scene: Nodes = {"type": "scene"}
    if mesh is None:
        middle = (0.0, BALL_CENTRE, 0.0)
        scene["shell"] = shell().moved(middle).to_mitsuba("shell", material)
        scene["core"] = sphere(CORE_RADIUS).moved(middle).to_mitsuba("core", material)
        target = BALL_CENTRE if furnace else BALL_CENTRE - 0.06
        if not furnace:
            scene["pedestal"] = pedestal().to_mitsuba("pedestal", _grey(0.12))
    else:
        shape = with_normals(on_stage(load_mesh(mesh), up, turn))
        scene["mesh"] = shape.to_mitsuba("mesh", _for_both_sides(material))
        target = float(shape.positions[np.unique(shape.faces), 1].max()) / 2
    if furnace:
        # Russian roulette would only add noise: nothing is lost, so no path is worth cutting.
        integrator = {"type": "path", "max_depth": FURNACE_DEPTH, "rr_depth": FURNACE_DEPTH}
        # Shadow rays would add noise too. All go to a lamp that is off, and every path finds the
        # surround by the material's own sampling: exact when that samples without loss.
        scene["surround"] = _surround(1.0, share=0)
        scene["off"] = {"type": "point", "position": [0, 9, 0], "intensity": _rgb(0.0)}
    else:
        integrator = {"type": "path", "max_depth": max_depth, "rr_depth": 3}
        scene.update(environment_nodes(environment, environment_turn))
    scene["integrator"] = integrator
    scene["sensor"] = _sensor(size, spp, target)
    return scene
