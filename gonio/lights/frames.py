"""Frames of shaded points: from the world into the local frame of models, and back.

Directions and normals are in world space, or in any other that all of them share. The frame's x axis is the
direction of growing u, as normal maps and stretched highlights need it.
"""

from typing import NamedTuple

from gonio.lang import Float, Vec3, absolute, dot, normalize, select, vec3
from gonio.parts.tilt import flake_normal

# A tangent that leaves the normal by less than this sine, 0.06 degrees, has no direction, nor has one of
# length 0: another is taken.
TANGENT_MIN = 1e-3
COS2_MAX = 1 - TANGENT_MIN * TANGENT_MIN


class Frame(NamedTuple):
    """Axes of a point on the surface, unit and at right angles, in the world."""

    tangent: Vec3
    """The local x axis: where u grows."""
    bitangent: Vec3
    """The local y axis."""
    normal: Vec3
    """The local z axis."""


def cross(a: Vec3, b: Vec3) -> Vec3:
    """Outer product."""
    return vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)


def surface_frame(normal: Vec3, tangent: Vec3) -> Frame:
    """The frame of a normal and a tangent as meshes have them.

    normal: need not be unit. tangent: need not be unit or at right angles; without one give (0, 0, 0), and
    a direction is taken that the model must not depend on.
    """
    n = normalize(normal)
    along = dot(tangent, n)
    known = along * along < COS2_MAX * dot(tangent, tangent)
    # At right angles to n without a product, and not short
    other = select(absolute(n.x) > 0.7, vec3(-n.z, 0, n.x), vec3(0, n.z, -n.y))
    x = normalize(select(known, tangent - along * n, other))
    return Frame(x, cross(n, x), n)


def to_local(frame: Frame, w: Vec3) -> Vec3:
    """A direction of the world in the local frame, where models are evaluated."""
    return vec3(dot(frame.tangent, w), dot(frame.bitangent, w), dot(frame.normal, w))


def to_world(frame: Frame, w: Vec3) -> Vec3:
    """A direction of the local frame in the world: the inverse of `to_local`."""
    return w.x * frame.tangent + w.y * frame.bitangent + w.z * frame.normal


def mapped_normal(normal: Vec3, tangent: Vec3, texel: Vec3, handedness: Float) -> Vec3:
    """The world's normal of a normal map's texel, unit.

    texel: what the map holds, 0 to 1 in each channel, linear. handedness: -1 where u and v of the mesh are
    mirrored (glTF's tangent.w), else 1.
    """
    frame = surface_frame(normal, tangent)
    m = vec3(2 * texel.x - 1, handedness * (2 * texel.y - 1), 2 * texel.z - 1)
    return normalize(to_world(frame, m))


def world_flake_normal(
    normal: Vec3, tangent: Vec3, slope_x: Float, slope_y: Float, distance: Float
) -> Vec3:
    """The world's normal of a flake that tilts by these slopes; from afar flakes even out.

    distance: of the viewer; up to 1 a flake counts as much as the surface, then less and less (Elek,
    "Layered materials in real-time rendering", CESCG 2010, section 4.1).
    """
    frame = surface_frame(normal, tangent)
    return to_world(frame, flake_normal(slope_x, slope_y, distance))
