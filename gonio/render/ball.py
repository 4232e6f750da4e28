"""The shader ball: a shell with an opening, the core inside, and the pedestal below."""

from __future__ import annotations

import numpy as np

from gonio.render.triangles import Floats, Triangles, grid_faces, joined, lathe, rounded

BALL_CENTRE = 1.2  # height above the ground: radius 1 plus what the pedestal's lip lifts it
SHELL_INSIDE = 0.9  # inner radius of the shell, the outer one being 1
CORE_RADIUS = 0.7  # the sphere inside: leaves a gap of twice the wall, wide enough to be lit
BEVEL = 0.022  # radius of the rounding on the shell's edges: a highlight three pixels wide at 1024


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
    return lathe(*rounded(corners), segments)


# The cut looks to the camera's left and a little up, towards the key light.
CUT_AZIMUTH, CUT_ELEVATION = -34.0, 16.0
CUT_HALF_WIDTH, CUT_HALF_HEIGHT = 43.0, 50.0  # degrees, as seen from the centre


def direction(azimuth: float, elevation: float) -> Floats:
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
    axis = direction(CUT_AZIMUTH, CUT_ELEVATION)
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
        pole = -direction(CUT_AZIMUTH, CUT_ELEVATION)
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
            grid_faces(rows, columns + 1, True, False),
            np.concatenate([outside[:-1], wall_normals]).reshape(-1, 3),
            np.concatenate([_sphere_uv(outside[:-1]), wall_uv]).reshape(-1, 2),
        )
    )
    second = _without_seam(
        Triangles(
            SHELL_INSIDE * inside.reshape(-1, 3),
            grid_faces(inner_rows + 1, columns + 1, False, True),
            -inside.reshape(-1, 3),
            _sphere_uv(inside).reshape(-1, 2),
        )
    )
    return joined([first, second])
