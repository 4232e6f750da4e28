"""The chart of directions by half vectors, in which a mirror's lobe of any width takes up a fair share.

A direction wi is given by m = normalize(wi + wo), and m by its azimuth and by a level: the slope
tan(theta_m) = SLOPE_SCALE sinh(level), which grows evenly at first and then by factors. wi meets the
horizon at `last_slope`.
"""

from __future__ import annotations

from typing import Any

import drjit as dr

from gonio.lang import Float, Vec3, sqrt, vec3

# A third of the sharpest alpha, which anisotropy divides by up to 3.2.
SLOPE_SCALE = 3e-5


def level_of(slope: Float) -> Float:
    """The level of a slope: the inverse of `slope_at`."""
    return dr.asinh(slope / SLOPE_SCALE)


def slope_at(level: Float) -> tuple[Float, Float]:
    """The slope of a level, and its derivative."""
    grown = dr.exp(level)
    inv = 1 / grown
    return 0.5 * SLOPE_SCALE * (grown - inv), 0.5 * SLOPE_SCALE * (grown + inv)


def last_slope(toward: Float, mu: Float) -> Float:
    """The slope at which wi meets the horizon.

    toward: what wo has along the azimuth of m, sin(theta_o) cos(phi). mu: wo's cosine.
    """
    root = sqrt(toward * toward + mu * mu) + dr.abs(toward)
    # Of the two forms the one without cancellation
    return dr.select(toward > 0, root / mu, mu / root)


def mirrored(wo: Vec3, x: Float, y: Float, toward: Float, slope: Float) -> tuple[Vec3, Any]:
    """wo mirrored at a half vector, and the solid angle of wi per slope and azimuth.

    x, y: the azimuth of m, of length 1. toward: wo.x x + wo.y y. slope: of m.
    """
    cos_m = dr.rsqrt(1 + slope * slope)
    sin_m = slope * cos_m
    cos_h = (toward * slope + wo.z) * cos_m
    wi = 2 * cos_h * vec3(sin_m * x, sin_m * y, cos_m) - wo
    # dωi = 4 (wo · m) dm, and dm = t cos³θm dt dφ
    return wi, 4 * cos_h * sin_m * cos_m * cos_m
