"""Frames of shaded points: from the world into the local frame of models, and back.

Directions and normals are in world space, or in any other that all of them share. The frame's x axis is the
direction of growing u, as normal maps and stretched highlights need it. A model that does not depend on its
tangents gets the frame of the normal alone, which takes fewer operations.
"""

from typing import NamedTuple

from gonio.lang import Float, Vec3, absolute, dot, normalize, select, sqrt, vec3
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

    def to_local(self, w: Vec3) -> Vec3:
        """A direction of the world in the local frame, where models are evaluated."""
        return vec3(dot(self.tangent, w), dot(self.bitangent, w), dot(self.normal, w))

    def to_world(self, w: Vec3) -> Vec3:
        """A direction of the local frame in the world: the inverse of `to_local`."""
        return w.x * self.tangent + w.y * self.bitangent + w.z * self.normal


class NormalFrame(NamedTuple):
    """The local frame of a normal alone, whose x and y axes are any: the normal is turned to +z.

    With n below z = 0 the world is first turned by half a turn about x, so that no quotient is large.
    """

    normal: Vec3
    """The local z axis, unit."""
    side: Float
    """1, or -1 where the normal is below z = 0."""
    inv: Float
    """1 / (1 + |n.z|)."""

    def to_local(self, w: Vec3) -> Vec3:
        """A direction of the world in the local frame, where models are evaluated."""
        # Two mirrors: one turns n to -z, the other is z = 0; n + z is the normal of the first.
        n = self.normal
        mu = dot(n, w)
        k = (mu + self.side * w.z) * self.inv
        return vec3(w.x - k * n.x, self.side * (w.y - k * n.y), mu)

    def to_world(self, w: Vec3) -> Vec3:
        """A direction of the local frame in the world: the inverse of `to_local`."""
        n = self.normal
        y = self.side * w.y
        slope = n.x * w.x + n.y * y
        k = slope * self.inv - w.z
        return vec3(w.x - k * n.x, y - k * n.y, n.z * w.z - self.side * slope)


AnyFrame = Frame | NormalFrame
"""What lights get."""


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


def normal_frame(normal: Vec3) -> NormalFrame:
    """The frame of a normal, for models that do not depend on tangents. normal: need not be unit."""
    n = normalize(normal)
    return NormalFrame(n, select(n.z < 0, -1.0, 1.0), 1 / (1 + absolute(n.z)))


def mapped_normal(normal: Vec3, tangent: Vec3, texel: Vec3, handedness: Float) -> Vec3:
    """The world's normal of a normal map's texel, unit.

    texel: what the map holds, 0 to 1 in each channel, linear. handedness: -1 where u and v of the mesh are
    mirrored (glTF's tangent.w), else 1. Without a tangent the map has no direction: the normal stays.
    """
    n = normalize(normal)
    along = dot(tangent, n)
    across = tangent - along * n
    size2 = dot(across, across)
    known = size2 > TANGENT_MIN * TANGENT_MIN * (along * along)
    scale = select(known, 1 / sqrt(select(known, size2, 1)), 0)
    x, y = scale * (2 * texel.x - 1), scale * handedness * (2 * texel.y - 1)
    return normalize(x * across + y * cross(n, across) + (2 * texel.z - 1) * n)


def world_flake_normal(
    normal: Vec3, tangent: Vec3, slope_x: Float, slope_y: Float, distance: Float
) -> Vec3:
    """The world's normal of a flake that tilts by these slopes; from afar flakes even out.

    distance: of the viewer; up to 1 a flake counts as much as the surface, then less and less (Elek,
    "Layered materials in real-time rendering", CESCG 2010, section 4.1).
    """
    frame = surface_frame(normal, tangent)
    return frame.to_world(flake_normal(slope_x, slope_y, distance))
