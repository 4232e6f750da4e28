"""The text's own formulas as it prints them, in NumPy: what gonio is compared with."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

import gonio
from gonio.model import Model
from gonio.reproduce.measure import (
    Floats,
)

CLAY = (0.75, 0.41, 0.28)
HALF_PI = math.pi / 2

# Double precision, with a division by cosines down to 0.02: what two forms of one formula differ by.
ROUNDING = 1e-12


def tangential(wi: Floats, wo: Floats) -> Floats:
    return np.asarray(np.sum(wi * wo, -1) - wi[..., 2] * wo[..., 2])


def qon_coefficients(sigma: float, offset: float = 0.33) -> tuple[float, float]:
    v = sigma**2
    return 1 - 0.5 * v / (v + offset), 0.45 * v / (v + 0.09)


def qon_angles(sigma: float, wi: Floats, wo: Floats) -> Floats:
    """Eq. 1 and 2."""
    A, B = qon_coefficients(sigma)
    theta = np.arccos(wi[..., 2]), np.arccos(wo[..., 2])
    phi = (np.arctan2(w[..., 1], w[..., 0]) for w in (wi, wo))
    g = np.maximum(np.cos(np.subtract(*phi)), 0)
    g = g * np.sin(np.maximum(*theta)) * np.tan(np.minimum(*theta))
    return np.asarray((A + B * g) / math.pi)


def qon_vectors(sigma: float, wi: Floats, wo: Floats, offset: float = 0.33) -> Floats:
    """Eq. 3 and 4."""
    A, B = qon_coefficients(sigma, offset)
    s = tangential(wi, wo)
    return np.asarray(
        (A + B * np.where(s > 0, s / np.maximum(wi[..., 2], wo[..., 2]), 0)) / math.pi
    )


def A_fujii(r: float) -> float:
    return 1 / (1 + (0.5 - 2 / (3 * math.pi)) * r)


def f_fon(r: float, wi: Floats, wo: Floats) -> Floats:
    """Eq. 10 and 11."""
    s = tangential(wi, wo)
    t = np.where(s > 0, np.maximum(wi[..., 2], wo[..., 2]), 1)
    return np.asarray(A_fujii(r) * (1 + r * s / t) / math.pi)


def G_qualitative(theta: Floats) -> Floats:
    """Eq. 8."""
    s = np.sin(theta)
    return np.asarray(s * (theta - s * np.cos(theta)) + 2 / 3 * np.tan(theta) * (1 - s**3))


def E_fon(r: float, theta: Floats) -> Floats:
    """Eq. 12 and 13."""
    G = G_qualitative(theta) - 2 / 3 * np.sin(theta)
    return np.asarray(A_fujii(r) * (1 + r / math.pi * G))


def E_fit(r: float, theta: Floats) -> Floats:
    """Eq. 12 and 14."""
    k = 1 - np.cos(theta)
    G = 0.0571085289 * k + 0.491881867 * k**2 - 0.332181442 * k**3 + 0.0714429953 * k**4
    return np.asarray(A_fujii(r) * (1 + r * G))


def mean_E_fon(r: float) -> float:
    """Eq. 15."""
    return A_fujii(r) * (1 + (2 / 3 - 28 / (15 * math.pi)) * r)


def f_eon(rho: float, r: float, wi: Floats, wo: Floats) -> Floats:
    """Eq. 16 and 19."""
    mean = mean_E_fon(r)
    lost = [1 - E_fon(r, np.arccos(w[..., 2])) for w in (wi, wo)]
    rho_ms = rho**2 * mean / (1 - rho * (1 - mean))
    return np.asarray(rho * f_fon(r, wi, wo) + rho_ms / math.pi * lost[0] * lost[1] / (1 - mean))


def coefficients(mu: float, r: float) -> Floats:
    """Listing 2, as the authors' published source has it."""
    a = 1 + r * (0.303392 + (-0.518982 + 0.111709 * mu) * mu + (-0.276266 + 0.335918 * mu) * r)
    b = r * (-1.16407 + 1.15859 * mu + (0.150815 - 0.150105 * mu) * r) / (mu**3 - 1.43545)
    c = 1 + (0.20013 + (-0.506373 + 0.261777 * mu) * mu) * r
    d = r * (0.540852 + (-1.01625 + 0.475392 * mu) * mu) / (-1.0743 + mu * (0.0725628 + mu))
    return np.array([a, b, c, d])


def matrix(mu: float, r: float) -> Floats:
    """Eq. 25."""
    a, b, c, d = coefficients(mu, r)
    return np.array([[a, 0, b], [0, c, 0], [d, 0, 1]])


def cltc_pdf(mu: float, r: float, wi: Floats) -> Floats:
    """Eq. 21 to 28, with the inverse matrix taken by NumPy; wo has azimuth 0."""
    M = matrix(mu, r)
    h = wi @ np.linalg.inv(M).T
    length = np.linalg.norm(h, axis=-1)
    D = np.maximum(h[..., 2] / length, 0) / math.pi / np.linalg.det(M) / length**3
    return np.asarray(2 * D / (1 + 1 / np.sqrt(1 + M[2, 0] ** 2)))


def uniform_share(mu: float, r: float) -> float:
    """P_u of Listing 4."""
    return float(r**0.1 * (0.162925 + mu * (-0.372058 + (0.538233 - 0.290822 * mu) * mu)))


def white_eon(**given: Any) -> Model:
    return gonio.EON(rho=1, **given)


def degrees(*angles: float) -> list[tuple[float, float]]:
    return [(a, math.radians(a)) for a in angles]
