"""Cosine-weighted, uniform and grazing sampling of the upper hemisphere."""

from gonio.lang import (
    INV_PI,
    INV_TWO_PI,
    TWO_PI,
    Float,
    Vec2,
    Vec3,
    cos,
    log,
    minimum,
    safe_sqrt,
    sin,
    vec3,
)
from gonio.parts.special import expm1


def sample_cosine(u: Vec2) -> Vec3:
    """A direction with density cos(theta) / pi."""
    r = safe_sqrt(u.x)
    phi = TWO_PI * u.y
    return vec3(r * cos(phi), r * sin(phi), safe_sqrt(1 - u.x))


def pdf_cosine(w: Vec3) -> Float:
    """Density of `sample_cosine` in 1/sr, for w above the horizon."""
    return w.z * INV_PI


def sample_uniform(u: Vec2) -> Vec3:
    """A direction with density 1 / (2 pi)."""
    # z = 1 - u instead of u: random numbers lie in [0, 1), so z never becomes 0.
    z = 1 - u.x
    r = safe_sqrt(u.x * (1 + z))
    phi = TWO_PI * u.y
    return vec3(r * cos(phi), r * sin(phi), z)


def pdf_uniform() -> Float:
    """Density of `sample_uniform` in 1/sr."""
    return INV_TWO_PI


def sample_grazing(width: Float, u: Vec2) -> Vec3:
    """A direction with a density like mu / (mu^2 + width^2): near the horizon for a small width."""
    # The inverse of log(1 + mu^2 / width^2) / log(1 + 1 / width^2)
    w2 = width * width
    z2 = minimum(w2 * expm1((1 - u.x) * log(1 + 1 / w2)), 1)
    r = safe_sqrt(1 - z2)
    phi = TWO_PI * u.y
    return vec3(r * cos(phi), r * sin(phi), safe_sqrt(z2))


def pdf_grazing(w: Vec3, width: Float) -> Float:
    """Density of `sample_grazing` in 1/sr, for w above the horizon."""
    w2 = width * width
    return INV_PI * w.z / ((w.z * w.z + w2) * log(1 + 1 / w2))
