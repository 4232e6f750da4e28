"""Quadrature over the hemisphere in NumPy, written apart from gonio's own."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np

from support.directions import Array, polar

NODES = 20


def hemisphere_rule(theta_o: float, nodes: int = NODES) -> tuple[Array, Array]:
    """Directions (n, 3) and weights (n,) of solid angle, split at theta_o and at quarter turns."""
    x, w = np.polynomial.legendre.leggauss(nodes)
    # Steps that shrink by tens towards theta_o, where a grazing view makes integrands steep.
    steps = 10.0 ** -np.arange(1, 8)
    edges = np.concatenate([[0], theta_o - steps, [theta_o], theta_o + steps, [np.pi / 2]])
    edges = np.unique(np.clip(edges, 0, np.pi / 2))
    theta = np.concatenate([(b - a) / 2 * x + (a + b) / 2 for a, b in pairwise(edges)])
    theta_w = np.concatenate([(b - a) / 2 * w for a, b in pairwise(edges)])
    phi = np.concatenate([np.pi / 4 * (x + 1 + 2 * quarter) for quarter in range(4)])
    phi_w = np.tile(np.pi / 4 * w, 4)
    t, p = np.meshgrid(theta, phi, indexing="ij")
    weights = np.outer(theta_w * np.sin(theta), phi_w)
    return polar(t.ravel(), p.ravel()), weights.ravel()


def albedo(evaluate: Callable[[Array, Array], Any], theta_o: float) -> Array:
    """∫ f cos(theta_i) for wo at (theta_o, phi = 0), float64, shape (3,)."""
    wi, weights = hemisphere_rule(theta_o)
    f = np.asarray(evaluate(wi, polar(theta_o)))
    return np.asarray(np.sum(f * (weights * wi[:, 2])[:, None], axis=0))


def mean(directional: Callable[[Array], Any], nodes: int = 48) -> Array:
    """(1/pi) ∫ E(wo) cos(theta_o) of an isotropic albedo, float64, shape (3,)."""
    x, w = np.polynomial.legendre.leggauss(nodes)
    theta = np.pi / 4 * (x + 1)
    E = np.asarray(directional(polar(theta)))
    weights = np.pi / 4 * w * 2 * np.sin(theta) * np.cos(theta)
    return np.asarray(np.sum(E * weights[:, None], axis=0))
