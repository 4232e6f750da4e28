"""The frame of a tilted normal, for a surface whose normal alone is perturbed."""

from gonio.lang import Float, Vec3, dot, maximum, minimum, normalize, vec3


def flake_normal(slope_x: Float, slope_y: Float, distance: Float) -> Vec3:
    """normalize(N_flake + max(distance, 1) N) with N_flake = normalize(slope_x, slope_y, 1).

    Elek, "Layered materials in real-time rendering", CESCG 2010, section 4.1: flakes that cannot be told
    apart any more even out.
    """
    flake = normalize(vec3(slope_x, slope_y, 1))
    return normalize(vec3(flake.x, flake.y, flake.z + maximum(distance, 1)))


def _half_turn(w: Vec3, n: Vec3) -> Vec3:
    """w turned by 180 degrees about the bisector of n and the z axis, which swaps these two."""
    h = vec3(n.x, n.y, n.z + 1)
    return dot(w, h) / h.z * h - w


def to_tilted(w: Vec3, n: Vec3) -> Vec3:
    """w in the frame of n, turned there the shortest way; n.z > 0."""
    t = _half_turn(w, n)
    return vec3(-t.x, -t.y, t.z)


def from_tilted(w: Vec3, n: Vec3) -> Vec3:
    """The inverse of `to_tilted`."""
    return _half_turn(vec3(-w.x, -w.y, w.z), n)


def seen(cos_tilted: Float, mu: Float) -> Float:
    """How much of a tilted facet a direction sees, at most as much as of the flat surface."""
    return minimum(maximum(cos_tilted, 0) / mu, 1)
