"""The frame of a tilted normal, for a surface whose normal alone is perturbed."""

from gonio.lang import Float, Vec3, maximum, minimum, normalize, vec3
from gonio.parts.frame import tangential_dot


def flake_normal(slope_x: Float, slope_y: Float, distance: Float) -> Vec3:
    """normalize(N_flake + max(distance, 1) N) with N_flake = normalize(slope_x, slope_y, 1).

    Elek, "Layered materials in real-time rendering", CESCG 2010, section 4.1: flakes that cannot be told
    apart any more even out.
    """
    flake = normalize(vec3(slope_x, slope_y, 1))
    return normalize(vec3(flake.x, flake.y, flake.z + maximum(distance, 1)))


def flake_normal_added(slope_x: Float, slope_y: Float, distance: Float) -> Vec3:
    """The same as Elek's code has it, which adds both to the normal N of before: one N more."""
    return flake_normal(slope_x, slope_y, maximum(distance, 1) + 1)


def to_tilted(w: Vec3, n: Vec3) -> Vec3:
    """w in the frame of n, turned there the shortest way; n.z > 0."""
    # Its sign decides whether the surface is seen at all: the last digits count.
    z = tangential_dot(w, n) + w.z * n.z
    along = (z + w.z) / (n.z + 1)
    return vec3(w.x - along * n.x, w.y - along * n.y, z)


def from_tilted(w: Vec3, n: Vec3) -> Vec3:
    """The inverse of `to_tilted`."""
    return to_tilted(w, vec3(-n.x, -n.y, n.z))


def seen(cos_tilted: Float, mu: Float) -> Float:
    """How much of a tilted facet a direction sees, at most as much as of the flat surface."""
    return minimum(maximum(cos_tilted, 0) / mu, 1)
