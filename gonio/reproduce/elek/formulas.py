"""The paper's own formulas in NumPy: what gonio is compared with."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from gonio.reproduce.measure import Floats

Base = Callable[[Floats, Floats], Floats]


def half(wi: Floats, wo: Floats) -> tuple[Floats, Floats]:
    """N.H and V.H."""
    h = wi + wo
    h = h / np.linalg.norm(h, axis=-1, keepdims=True)
    return h[..., 2], np.sum(h * wo, -1)


def D(m: float, cos: Floats) -> Floats:
    """Beckmann's distribution as printed, which integrates to pi."""
    return np.asarray(np.exp(-(1 - cos**2) / (m * cos) ** 2) / (m**2 * cos**4))


def G(wi: Floats, wo: Floats) -> Floats:
    """Appendix B: V-cavities."""
    n, h = half(wi, wo)
    return np.asarray(np.minimum(1, 2 * n * np.minimum(wi[..., 2], wo[..., 2]) / h))


def lazanyi(cos: Floats, n: float, k: float = 0.0) -> Floats:
    """Appendix B's F."""
    return np.asarray(((n - 1) ** 2 + 4 * n * (1 - cos) ** 5 + k**2) / ((n + 1) ** 2 + k**2))


def conductor(cos: Floats, n: float, k: float = 0.0) -> Floats:
    """Fresnel's equations for unpolarised light, in complex numbers."""
    eps = (n + 1j * k) ** 2
    g = np.sqrt(eps - 1 + cos**2 + 0j)
    s = np.abs((cos - g) / (cos + g)) ** 2
    p = np.abs((eps * cos - g) / (eps * cos + g)) ** 2
    return np.asarray((s + p) / 2)


def torrance_sparrow(m: float, F: float | Floats, wi: Floats, wo: Floats) -> Floats:
    """Eq. 1 with 1 / 4 in place of 1 / pi, and D over pi: f."""
    n, _ = half(wi, wo)
    return np.asarray(F * D(m, n) / math.pi * G(wi, wo) / (4 * wi[..., 2] * wo[..., 2]))


def refracted(w: Floats, n: float) -> Floats:
    """Snell's law with the azimuth kept."""
    t = w / n
    t[..., 2] = np.sqrt(1 - t[..., 0] ** 2 - t[..., 1] ** 2)
    return t


def layered(
    n: float,
    m: float,
    sigma_d: float,
    base: Base,
    wi: Floats,
    wo: Floats,
    F: Callable[..., Floats] = lazanyi,
) -> Floats:
    """Eq. 2 to 4 with a rough coat."""
    _, cos_h = half(wi, wo)
    Fh = F(cos_h, n)
    inside = refracted(wi, n), refracted(wo, n)
    T12 = 1 - Fh
    a = np.exp(-sigma_d * (1 / inside[0][..., 2] + 1 / inside[1][..., 2]))
    g = G(wi, wo)
    t = (1 - g) + T12 * g
    return np.asarray(torrance_sparrow(m, Fh, wi, wo) + T12 * base(*inside) * a * t)


def smoothstep(low: float, high: float, x: float) -> float:
    """Cg's."""
    t = min(max((x - low) / (high - low), 0), 1)
    return t * t * (3 - 2 * t)
