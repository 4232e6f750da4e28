"""Quadrature over the hemisphere in NumPy, written apart from gonio's own."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np

from support.directions import Array, polar

NODES = 20


def hemisphere_rule(
    theta_o: float, nodes: int = NODES, *, horizon: bool = False
) -> tuple[Array, Array]:
    """Directions (n, 3) and weights (n,) of solid angle, split at theta_o and at quarter turns.

    horizon: crowd there as well, for integrands that change within the last degree.
    """
    x, w = np.polynomial.legendre.leggauss(nodes)
    # Steps that shrink by tens towards theta_o, where a grazing view makes integrands steep.
    steps = 10.0 ** -np.arange(1, 8)
    edges = np.concatenate([[0], theta_o - steps, [theta_o], theta_o + steps, [np.pi / 2]])
    if horizon:
        edges = np.concatenate([edges, np.pi / 2 - steps])
    edges = np.unique(np.clip(edges, 0, np.pi / 2))
    theta = np.concatenate([(b - a) / 2 * x + (a + b) / 2 for a, b in pairwise(edges)])
    theta_w = np.concatenate([(b - a) / 2 * w for a, b in pairwise(edges)])
    phi = np.concatenate([np.pi / 4 * (x + 1 + 2 * quarter) for quarter in range(4)])
    phi_w = np.tile(np.pi / 4 * w, 4)
    t, p = np.meshgrid(theta, phi, indexing="ij")
    weights = np.outer(theta_w * np.sin(theta), phi_w)
    return polar(t.ravel(), p.ravel()), weights.ravel()


def half_vector_rule(
    theta_o: float, widths: tuple[float, float] = (1, 1), nodes: int = 14, azimuths: int = 60
) -> tuple[Array, Array]:
    """The same for highlights of any sharpness: wo = (theta_o, 0) mirrored at half vectors.

    Slopes of the half vector are split at powers of ten, and end where wi meets the horizon. Azimuths are
    those of slopes over `widths`, split at quarter turns and crowding there from both sides.
    """
    x, w = np.polynomial.legendre.leggauss(azimuths)
    # x^3 (10 - 15 x + 6 x^2) crowds at both ends of [0, 1]
    x, w = (x + 1) / 2, w / 2
    bend, bend_w = x**3 * (10 - 15 * x + 6 * x**2), 30 * x**2 * (1 - x) ** 2 * w
    psi = np.concatenate([np.pi / 2 * (bend + quarter) for quarter in range(4)])
    psi_w = np.tile(np.pi / 2 * bend_w, 4)
    dx, dy = widths[0] * np.cos(psi), widths[1] * np.sin(psi)
    phi_w = psi_w * widths[0] * widths[1] / (dx**2 + dy**2)
    phi = np.arctan2(dy, dx)

    mu, toward = max(np.cos(theta_o), 1e-12), np.sin(theta_o) * np.cos(phi)
    root = np.sqrt(toward**2 + mu**2)
    last = np.where(toward > 0, (root + toward) / mu, mu / np.maximum(root - toward, 1e-300))
    # Decades below the last slope; the innermost one starts at 0 instead
    x, w = np.polynomial.legendre.leggauss(nodes)
    x, w = (x + 1) / 2, w / 2
    decades = int(np.ceil(np.log10(last.max() / 1e-7)))
    edges = 10.0 ** -np.arange(0.0, max(decades, 1) + 1)
    lows = np.append(edges[1:], 0)
    unit = np.concatenate([a + (b - a) * x for a, b in zip(lows, edges, strict=True)])
    unit_w = np.concatenate([(b - a) * w for a, b in zip(lows, edges, strict=True)])
    # Two stretches, which meet where wi is as high as wo: max(mu_i, mu_o) has a kink there
    level = np.maximum(toward, 0) / mu
    begin = np.repeat(np.stack([0 * level, level], -1), len(unit), axis=-1)
    extent = np.repeat(np.stack([level, last - level], -1), len(unit), axis=-1)
    t = begin + extent * np.tile(unit, 2)
    cos_m = 1 / np.sqrt(1 + t * t)
    m = np.stack([t * cos_m * np.cos(phi)[:, None], t * cos_m * np.sin(phi)[:, None], cos_m], -1)
    cos_h = (toward[:, None] * t + mu) * cos_m
    wi = 2 * cos_h[..., None] * m - polar(theta_o)
    weights = 4 * cos_h * t * cos_m**3 * extent * np.tile(unit_w, 2) * phi_w[:, None]
    return wi.reshape(-1, 3), weights.ravel()


def mirror_rule(theta_o: float, nodes: int = NODES) -> tuple[Array, Array]:
    """The same for lobes round about the mirror direction: circles around it, cut at the horizon."""
    low = np.pi / 2 - theta_o
    # Angles from the mirror direction are split at powers of ten past each place where something begins.
    steps = 10.0 ** -np.arange(0, 6)
    starts = [0.0, low, np.pi / 2]
    edges = np.concatenate([[s] for s in starts] + [s + steps for s in starts] + [[np.pi - low]])
    edges = np.unique(np.clip(edges, 0, np.pi - low))
    x, w = np.polynomial.legendre.leggauss(nodes)
    x, w = (x + 1) / 2, w / 2
    # Crowding at the lower end, where what is cut off grows like a root, and more so at the upper one,
    # where an edge may be as steep as cos^0.01
    x, w = 1 - (1 - x * x) ** 5, w * 10 * x * (1 - x * x) ** 4
    alpha = np.concatenate([a + (b - a) * x for a, b in pairwise(edges)])
    alpha_w = np.concatenate([(b - a) * w for a, b in pairwise(edges)])
    sine, mu = np.sin(theta_o), np.cos(theta_o)
    s, c = np.sin(alpha), np.cos(alpha)
    arc = np.arccos(np.clip(-c * mu / np.maximum(s * sine, 1e-300), -1, 1))
    y, v = np.polynomial.legendre.leggauss(2 * nodes)
    psi = arc[:, None] * y
    up, across = s[:, None] * np.cos(psi), s[:, None] * np.sin(psi)
    # The mirror direction is (-sine, 0, mu), and up from there (mu, 0, sine)
    out = c[:, None]
    wi = np.stack([mu * up - sine * out, across, sine * up + mu * out], -1)
    weights = alpha_w[:, None] * s[:, None] * arc[:, None] * v
    return wi.reshape(-1, 3), weights.ravel()


def rule_for(model: Any, theta_o: float, nodes: int = NODES) -> tuple[Array, Array]:
    """The rule that fits a model."""
    if model.numeric.rule == "angles":
        return hemisphere_rule(theta_o, nodes)
    if model.numeric.rule == "mirror":
        return mirror_rule(theta_o, nodes + 12)
    stretch = getattr(model, "anisotropy", getattr(model, "anisotropic", 0.0))
    # Half way between a stretched lobe and a round one, so that both stay resolved
    aspect = float(1 - 0.9 * stretch) ** 0.25
    return half_vector_rule(theta_o, (1 / aspect, aspect))


def albedo(
    evaluate: Callable[[Array, Array], Any],
    theta_o: float,
    rule: tuple[Array, Array] | None = None,
) -> Array:
    """∫ f cos(theta_i) for wo at (theta_o, phi = 0), float64, shape (3,)."""
    wi, weights = rule if rule is not None else hemisphere_rule(theta_o)
    f = np.asarray(evaluate(wi, polar(theta_o)))
    return np.asarray(np.sum(f * (weights * wi[:, 2])[:, None], axis=0))


def mean(directional: Callable[[Array], Any], nodes: int = 24, turns: int = 1) -> Array:
    """(1/pi) ∫ E(wo) cos(theta_o) of an albedo, float64, shape (3,); turns: azimuths per quarter."""
    x, w = np.polynomial.legendre.leggauss(nodes)
    # Half of the nodes crowd in the horizon, where masking by sharp facets sets in
    theta = np.concatenate([np.pi / 8 * (x + 1), np.pi / 2 - np.pi / 4 * ((x + 1) / 2) ** 3])
    w = np.concatenate([np.pi / 8 * w, np.pi / 4 * 3 / 2 * ((x + 1) / 2) ** 2 * w])
    phi = np.pi / 2 * (np.arange(turns) + 0.5) / turns if turns > 1 else np.zeros(1)
    theta, phi = (a.ravel() for a in np.meshgrid(theta, phi, indexing="ij"))
    w = np.repeat(w / turns, turns)
    E = np.asarray(directional(polar(theta, phi)))
    weights = w * 2 * np.sin(theta) * np.cos(theta)
    return np.asarray(np.sum(E * weights[:, None], axis=0))
