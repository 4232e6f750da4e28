"""What foreign code returns, by measurement: f, f cos(theta_i), pi f, or pi f cos(theta_i).

The cosine is told by reciprocity: of f and f cos(theta_i) at most one is the same with light and viewer
exchanged. A factor of pi is told by energy: with the brightest parameters the albedo is above 1, and not
above 1 without the factor. Code that gains energy beside that is told by most of its white settings.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import numpy as np

from gonio.foreign.expressions import Array
from gonio.foreign.function import Foreign, Returns, probe

# Relative differences of values with light and viewer exchanged: reciprocal ones are equal up to roundings,
# others are as different as cosines are.
RECIPROCAL = 0.02
PAIRS = 512

# Settings of the parameters, and directions of an albedo.
SETTINGS = 8
NODES = 24

# Albedos that are integrated so coarsely are right to this.
COARSE = 0.03

# A colour whose albedo is less is a tint of something else.
COLOURED = 0.5

# Albedos of bright settings that are taken for pi times those of f.
WHITE = (1.5, np.pi * (1 + COARSE))

# A name of pi with any prefix, but for those of multiples and of 1 / pi
_OTHERS = r"(?!(?:\w*_)?(?i:inv|one|over|rcp|reciprocal|two|four|half|quarter)_?(?:PI|pi|Pi))"
_PI = rf"(?:\b{_OTHERS}(?:\w+_|k)?(?:PI|pi|Pi)\b|\b3\.14\d*)"
_OVER_PI = (
    rf"(?i:/\s*{_PI}|/\s*\([^()]*{_PI}|(?:inv|one_?over|reciprocal|rcp)_?pi\b|_1_pi\b|pi_?inv\b"
    r"|\b0?\.318\d*)"
)
_TIMES_PI = rf"{_PI}f?\s*\*|\*\s*{_PI}"


def random_values(foreign: Foreign, count: int, rng: np.random.Generator) -> dict[str, Array]:
    """Values all over the ranges; colours are grey, and as often white."""
    found: dict[str, Array] = {}
    for name, p in foreign.parameters.items():
        t = rng.random(count)
        if p.width == 3:
            t = np.where(rng.random(count) < 0.5, 1, t)
            found[name] = np.repeat((p.low + (p.high - p.low) * t)[:, None], 3, axis=1)
        else:
            found[name] = p.low + (p.high - p.low) * t
    return found


def asymmetry(foreign: Foreign, cosine: int, fixed: Mapping[str, float] | None = None) -> float:
    """The median relative difference of both orders of two directions, with the cosine divided out."""
    wi, wo = probe(PAIRS, 3)
    values = random_values(foreign, PAIRS, np.random.default_rng(4))
    for name, value in (fixed or {}).items():
        values[name] = np.full(PAIRS, value)
    with np.errstate(all="ignore"):
        a = foreign.raw(wi, wo, values) / wi[:, 2:] ** cosine
        b = foreign.raw(wo, wi, values) / wo[:, 2:] ** cosine
        difference = np.abs(a - b) / np.maximum(np.abs(a), np.abs(b))
    difference = difference[np.isfinite(difference) & (np.maximum(np.abs(a), np.abs(b)) > 1e-4)]
    return float(np.median(difference)) if len(difference) else 0.0


def _asymmetries(foreign: Foreign) -> tuple[float, float]:
    """With the cosine and without; if neither is reciprocal, with a number at an end where one is."""
    both = asymmetry(foreign, 1), asymmetry(foreign, 0)
    if min(both) < RECIPROCAL:
        return both
    for name, p in foreign.parameters.items():
        if p.width == 1:
            held = {name: p.low}
            there = asymmetry(foreign, 1, held), asymmetry(foreign, 0, held)
            if min(there) < RECIPROCAL:
                return there
    return both


def names_exchanged(foreign: Foreign) -> bool:
    """Whether code is reciprocal without the viewer's cosine, which may be that of the light."""
    if foreign.returns.cosine or asymmetry(foreign, 0) < RECIPROCAL:
        return False
    wi, wo = probe(PAIRS, 3)
    values = random_values(foreign, PAIRS, np.random.default_rng(4))
    with np.errstate(all="ignore"):
        a = foreign.raw(wi, wo, values) / wo[:, 2:]
        b = foreign.raw(wo, wi, values) / wi[:, 2:]
        difference = np.abs(a - b) / np.maximum(np.abs(a), np.abs(b))
    seen = np.isfinite(difference) & (np.maximum(np.abs(a), np.abs(b)) > 1e-4)
    return bool(seen.any() and np.median(difference[seen]) < RECIPROCAL)


def around_the_mirror(wo: Array) -> tuple[Array, Array]:
    """Directions (n, 3) of light for a viewer (3,), and weights of an integral over the hemisphere.

    Half vectors are spread evenly over angles that grow with a cube: the mirror's lobe is resolved
    whatever its width.
    """
    x, w = np.polynomial.legendre.leggauss(NODES)
    phi = 2 * np.pi * (np.arange(NODES) + 0.5) / NODES
    theta_h = 0.5 * np.pi * ((x + 1) / 2) ** 3
    jacobian = 0.5 * np.pi * 3 * ((x + 1) / 2) ** 2 * w / 2
    t, p = (a.ravel() for a in np.meshgrid(theta_h, phi, indexing="ij"))
    weight = np.repeat(jacobian, NODES) * np.sin(t) * 2 * np.pi / NODES
    h = np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)], -1)
    cos_d = h @ wo
    wi = 2 * cos_d[:, None] * h - wo
    weight = weight * 4 * cos_d
    good = (cos_d > 0) & (wi[:, 2] > 1e-4)
    return wi[good], weight[good]


def albedos(foreign: Foreign, values: dict[str, Any], cosine: int) -> Array:
    """Roughly the directional albedos at a middling angle, one for each setting, (settings,)."""
    count = len(next(iter(values.values()))) if values else 1
    view = np.array([np.sin(0.6), 0.0, np.cos(0.6)])
    wi, weight = around_the_mirror(view)
    weight = weight * wi[:, 2] ** (1 - cosine)
    wo = np.broadcast_to(view, wi.shape)
    found = np.empty(count)
    for k in range(count):
        f = foreign.raw(wi, wo, {n: v[k] for n, v in values.items()}).max(axis=1)
        found[k] = np.nansum(np.where(np.isfinite(f), f, 0) * weight)
    return found


def _typical(foreign: Foreign, values: dict[str, Any], cosine: int) -> float:
    """The median albedo of white; of code with several colours, which may be a sum, the darkest one's."""
    colours = [name for name, p in foreign.parameters.items() if p.width == 3]
    found = []
    for white in ([name] for name in colours) if len(colours) > 1 else [colours]:
        given = {
            name: np.full_like(v, foreign.parameters[name].high if name in white else 0)
            if name in colours
            else v
            for name, v in values.items()
        }
        found.append(float(np.median(albedos(foreign, given, cosine))))
    seen = [albedo for albedo in found if albedo > COLOURED]
    return min(seen, default=max(found))


def measure(foreign: Foreign) -> Returns:
    """What a function returns."""
    with_cosine, without = _asymmetries(foreign)
    cosine = int(with_cosine < RECIPROCAL < without or with_cosine < 0.1 * without)
    values = random_values(foreign, SETTINGS, np.random.default_rng(5))
    bright = float(albedos(foreign, values, cosine).max())
    if bright > WHITE[1]:
        bright = _typical(foreign, values, cosine)
    # Code that divides by pi itself, and gains energy, is wrong rather than pi f
    divides = any(re.search(_OVER_PI, f.body) for f in foreign.source.called(foreign.function))
    # What stands below, as in a^2 / (PI * t * t), is no factor of pi
    left = re.sub(_OVER_PI, "", foreign.function.body)
    times = re.search(_TIMES_PI, left) is not None
    plain = divides and not times
    factor = np.pi if WHITE[0] < bright <= WHITE[1] and not plain else 1.0
    return Returns(float(factor), cosine)
