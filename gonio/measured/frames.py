"""Angles and directions: spherical ones, half and difference vectors, and the frame around a mirror.

Half and difference: Rusinkiewicz, "A New Change of Variables for Efficient BRDF Representation", 1998. h
is the half vector; d is wi in a frame whose pole is h: turned by -phi_h about the normal, then by
-theta_h about y.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def spherical(theta: Any, phi: Any) -> Floats:
    """Unit vectors (..., 3) from the angle to the normal and the azimuth, in radians."""
    theta, phi = np.broadcast_arrays(np.asarray(theta, np.float64), np.asarray(phi, np.float64))
    s = np.sin(theta)
    return np.stack([s * np.cos(phi), s * np.sin(phi), np.cos(theta)], -1)


def angles(w: Any) -> tuple[Floats, Floats]:
    """Angle to the normal in [0, pi] and azimuth in (-pi, pi] of vectors (..., 3)."""
    w = np.asarray(w, np.float64)
    return np.arctan2(np.hypot(w[..., 0], w[..., 1]), w[..., 2]), np.arctan2(w[..., 1], w[..., 0])


def half_difference(wi: Any, wo: Any) -> tuple[Floats, Floats, Floats, Floats]:
    """theta_h, phi_h, theta_d, phi_d of directions (..., 3); angles to poles in [0, pi/2] above the
    surface.

    phi_d is in (-pi, pi]. Where a pole leaves an azimuth open it is 0.
    """
    wi, wo = np.asarray(wi, np.float64), np.asarray(wo, np.float64)
    h = wi + wo
    theta_h, phi_h = angles(h)
    c, s = np.cos(phi_h), np.sin(phi_h)
    x, y, z = wi[..., 0], wi[..., 1], wi[..., 2]
    x, y = c * x + s * y, c * y - s * x
    c, s = np.cos(theta_h), np.sin(theta_h)
    x, z = c * x - s * z, s * x + c * z
    return theta_h, phi_h, np.arctan2(np.hypot(x, y), z), np.arctan2(y, x)


def from_half_difference(
    theta_h: Any, phi_h: Any, theta_d: Any, phi_d: Any
) -> tuple[Floats, Floats]:
    """wi and wo (..., 3) from the angles of `half_difference`."""
    d = spherical(theta_d, phi_d)
    c, s = np.cos(theta_h), np.sin(theta_h)
    x, y, z = c * d[..., 0] + s * d[..., 2], d[..., 1], c * d[..., 2] - s * d[..., 0]
    c, s = np.cos(phi_h), np.sin(phi_h)
    wi = np.stack(np.broadcast_arrays(c * x - s * y, s * x + c * y, z), -1)
    h = spherical(theta_h, phi_h)
    wo = 2 * np.sum(wi * h, -1, keepdims=True) * h - wi
    return wi, wo


def around_mirror(wi: Any, azimuth: Any, radial: Any) -> Floats:
    """Directions at an angle `radial` from the mirror direction of wi.

    Azimuth 0 points from the mirror direction to the normal's side of the plane of incidence, and
    grows counter-clockwise seen against the mirrored light.
    """
    wi = np.asarray(wi, np.float64)
    mirror = wi * np.array([-1.0, -1.0, 1.0])
    sine = np.hypot(mirror[..., 0], mirror[..., 1])
    far = sine > 1e-12
    ux = np.where(far, mirror[..., 0] / np.where(far, sine, 1), -1.0)
    uy = np.where(far, mirror[..., 1] / np.where(far, sine, 1), 0.0)
    toward = np.stack([-ux * mirror[..., 2], -uy * mirror[..., 2], sine], -1)
    across = np.cross(mirror, toward)
    r, a = np.asarray(radial)[..., None], np.asarray(azimuth)[..., None]
    return np.asarray(np.cos(r) * mirror + np.sin(r) * (np.cos(a) * toward + np.sin(a) * across))
