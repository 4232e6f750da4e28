"""The course's own formulas in NumPy: what gonio is compared with. They give f, the course gives f N.L."""

from __future__ import annotations

import math

import numpy as np

from gonio.reproduce.measure import Floats

# Signs of Eq. 27 to 29, which the conversion of the text lost, are those with which the fits are fits.


def tangential(wi: Floats, wo: Floats) -> Floats:
    """E.L - (N.E)(N.L)."""
    return np.asarray(np.sum(wi * wo, -1) - wi[..., 2] * wo[..., 2])


def schlick(f0: float, cos: Floats) -> Floats:
    """F_spec of Eq. 1."""
    return np.asarray(f0 + (1 - f0) * (1 - cos) ** 5)


def half(wi: Floats, wo: Floats) -> tuple[Floats, Floats]:
    """N.H and E.H."""
    h = wi + wo
    h = h / np.linalg.norm(h, axis=-1, keepdims=True)
    return h[..., 2], np.sum(h * wo, -1)


def highlight(n: float, wi: Floats, wo: Floats) -> Floats:
    """Eq. 1 without its Fresnel term."""
    cos_n, _ = half(wi, wo)
    return np.asarray((0.0397436 * n + 0.0856832) * cos_n**n / np.maximum(wi[..., 2], wo[..., 2]))


def blinn_phong(rho: float, f0: float, n: float, wi: Floats, wo: Floats) -> Floats:
    """Eq. 1, over pi in its diffuse part."""
    _, cos_h = half(wi, wo)
    return np.asarray(rho / math.pi * (1 - f0) + schlick(f0, cos_h) * highlight(n, wi, wo))


def fresnel(n1: float, n2: float, cos: Floats) -> Floats:
    """The exact reflectance from n1 to n2 of unpolarised light."""
    t = np.sqrt(np.maximum(1 - (n1 / n2) ** 2 * (1 - cos**2), 0))
    s = (n1 * cos - n2 * t) / (n1 * cos + n2 * t)
    p = (n2 * cos - n1 * t) / (n2 * cos + n1 * t)
    return np.asarray((s**2 + p**2) / 2)


def f0(n1: float, n2: float) -> float:
    """The same at the normal."""
    return ((n1 - n2) / (n1 + n2)) ** 2


def bottom_exact(n1: float, n2: float, cos: Floats) -> Floats:
    """Eq. 4, each factor at the angle that belongs to `cos` outside."""
    inside = np.sqrt(1 - (1 - cos**2) / n1**2)
    down, up = 1 - fresnel(1, n1, cos), 1 - fresnel(n1, 1, inside)
    return np.asarray(down * fresnel(n1, n2, inside) * up)


def bottom_constant(n1: float, n2: float) -> float:
    """F_bottom of Eq. 5."""
    return f0(n1, n2) * (1 - f0(1, n1))


def refracted(cos: Floats, n: float) -> Floats:
    """The cosine inside."""
    return np.sqrt(1 - (1 - cos**2) / n**2)


def A_eq23(n: float) -> float:
    """The first fraction of Eq. 23."""
    return 1 - 1 / (2 + 0.33 * n)


def f(n: float) -> float:
    """f(shi) of Eq. 27."""
    return 1 - 1 / (2 + 0.65 * n)


def g(n: float) -> float:
    """g(shi) of Eq. 27."""
    return 1 / (2.22222 + 0.1 * n)


def eq20(sigma: float, wi: Floats, wo: Floats) -> Floats:
    """Eq. 20 over pi and N.L, for a white surface."""
    v = sigma**2
    A, B = 1 - 0.5 * v / (v + 0.33), 0.45 * v / (v + 0.09)
    s = np.maximum(tangential(wi, wo), 0)
    cos_i = wi[..., 2]
    return np.asarray((cos_i * A + B * s * np.minimum(1, cos_i / wo[..., 2])) / cos_i / math.pi)


def eq23(n: float, wi: Floats, wo: Floats) -> Floats:
    """Eq. 23 over N.L."""
    s = np.maximum(tangential(wi, wo), 0)
    return _over_cosine(A_eq23(n), g(n) * s * np.minimum(1, wi[..., 2] / wo[..., 2]), wi)


def eq24(n: float, wi: Floats, wo: Floats) -> Floats:
    """Eq. 24 over N.L."""
    s = tangential(wi, wo)
    return _over_cosine(f(n), g(n) * s * np.minimum(1, wi[..., 2] / wo[..., 2]), wi)


def eq25(n: float, wi: Floats, wo: Floats) -> Floats:
    """Eq. 25 over N.L."""
    s = tangential(wi, wo)
    factor = np.where(s >= 0, np.minimum(1, wi[..., 2] / wo[..., 2]), wi[..., 2])
    return _over_cosine(f(n), g(n) * s * factor, wi)


def _over_cosine(A: float, rest: Floats, wi: Floats) -> Floats:
    return np.asarray((A + rest / wi[..., 2]) / math.pi)


def in_plane(n: float, x: float) -> float:
    """Eq. 26: the integral of Eq. 25, in radiance, over theta_i on the viewer's side, by Gauss's rule."""
    theta_o = math.acos(x)
    node, weight = np.polynomial.legendre.leggauss(64)
    total = 0.0
    for low, high in ((0.0, theta_o), (theta_o, math.pi / 2)):
        theta = low + (high - low) * (node + 1) / 2
        s = np.sin(theta) * math.sin(theta_o)
        t = np.maximum(np.cos(theta), x)
        radiance = np.cos(theta) * (f(n) + g(n) * s / t)
        total += float(np.sum(radiance * weight) * (high - low) / 2)
    return total


def dc_scale(n: float, x: Floats) -> Floats:
    """Eq. 27."""
    return np.asarray(f(n) + 0.5 * g(n) * (1 + 2 / math.pi * np.arccos(x) - x))


def dc_scale_cheap(n: float, x: Floats) -> Floats:
    """Eq. 28."""
    return np.asarray(f(n) + g(n) * (1 - x))


def linear_scale(n: float, x: Floats) -> Floats:
    """S of Eq. 29."""
    return np.asarray(f(n) + (f(n) - 1) * (1 - x))


def shininess(sigma: float) -> float:
    """Eq. 21, the other way round; sigma = 0 is an exponent that no highlight shows."""
    return 2 / sigma**2 if sigma > 0 else 1e12
