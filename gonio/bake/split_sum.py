"""The split-sum table of a model with a highlight: what it reflects of light from everywhere.

    table = gonio.bake.split_sum.split_sum_table(gonio.model("ue4", light="image"))      # (64, 64, 2)
    gonio.bake.split_sum.look_up(table, mu, alpha)

Source: Karis, "Real shading in Unreal Engine 4", SIGGRAPH 2013 course "Physically based shading in theory
and practice"; of tri-Ace's Blinn-Phong it is the AmbientBRDF of Gotanda, "Practical implementation of
physically-based shading models at tri-Ace", SIGGRAPH 2010 course. With F = f0 (1 - w) + f90 w and Schlick's
weight w at the half vector, the albedo of the highlight is f0 A + f90 B: A and B are the table.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gonio.arrays.functions import applied
from gonio.fields import ModelError, Parameter
from gonio.lang import Float, Vec2, Vec3, maximum, safe_sqrt, vec2, vec3
from gonio.lights.catalogue import form_for
from gonio.model import Model
from gonio.parts.distribution import ALPHA_MIN, RoundGGX
from gonio.parts.fresnel import schlick_weight_half
from gonio.parts.lobes import pdf_ggx_lobe, sample_ggx_lobe

Floats = NDArray[np.float64]
Progress = Callable[[int, int], None]

SIZE = 64
"""Texels along either axis."""

# Samples of one texel, a lattice: twice as many change the table by less than 1e-3.
SAMPLES = 2048
GOLDEN = 0.6180339887498949


def split_sum_table(
    model: Model, size: int = SIZE, *, samples: int = SAMPLES, progress: Progress | None = None
) -> NDArray[np.float32]:
    """A and B for every cosine of the viewer and every width of the highlight.

    Args:
        model: whose highlight it is. Its widths are those of the table, its colours do not matter.
        size: texels along either axis, at least 2.
        samples: of each texel.
        progress: called with (rows done, rows in all).

    Returns:
        Shape (size, size, 2), float32: row j has alpha = ((j + 0.5) / size)^2, column i the cosine
        (i + 0.5) / size.

    Raises:
        ModelError: a model without a highlight.
        ValueError: a size out of its range.
    """
    if size < 2:
        raise ValueError(f"size={size} is out of range; allowed is at least 2.")
    middles = (np.arange(size) + 0.5) / size
    table = np.empty((size, size, 2), np.float32)
    for j, root in enumerate(middles):
        table[j] = split_sum(model, middles, np.full(size, root * root), samples=samples)
        if progress is not None:
            progress(j + 1, size)
    return table


def split_sum(model: Model, mu: ArrayLike, alpha: ArrayLike, *, samples: int = SAMPLES) -> Floats:
    """A and B at some cosines and widths, shape (..., 2), integrated.

    Raises:
        ModelError: a model without a highlight.
    """
    if form_for(model, "image").needs != ("image_lobes",):
        raise ModelError(f"{model.name} has no highlight, so it needs no table.")
    mu, alpha = np.broadcast_arrays(np.asarray(mu, np.float64), np.asarray(alpha, np.float64))
    shape = mu.shape
    index = np.arange(samples)
    u1, u2 = (index + 0.5) / samples, (index * GOLDEN) % 1
    values = [np.repeat(mu.ravel(), samples), np.repeat(alpha.ravel(), samples)]
    values += [np.tile(u, mu.size) for u in (u1, u2)]
    parts = applied(_weights, _sharpest(model), values, width=2)
    return np.asarray(parts.reshape(*shape, samples, 2).mean(axis=-2), np.float64)


def _weights(model: Any, mu: Float, alpha: Float, u1: Float, u2: Float) -> Vec2:
    """A sample's share of A and of B: the highlight's weight, split by Schlick's."""
    facets = RoundGGX(maximum(alpha, ALPHA_MIN))
    wo = vec3(safe_sqrt((1 - mu) * (1 + mu)), 0 * mu, mu)
    wi: Vec3 = sample_ggx_lobe(facets, wo, vec2(u1, u2))
    density = pdf_ggx_lobe(facets, wi, wo)
    weight = model.at_least_as_rough(alpha).highlight(wi, wo) * wi.z / maximum(density, 1e-30)
    share = schlick_weight_half(wi, wo)
    return vec2(weight * (1 - share), weight * share)


def _sharpest(model: Model) -> Model:
    """The model with the sharpest highlight it can have, which `at_least_as_rough` widens to any alpha."""
    sharp: dict[str, float] = {}
    for name, declared in model.fields.items():
        if isinstance(declared, Parameter) and declared.rougher is not None:
            widened = float(declared.rougher(declared.low, 0.5))
            sharp[name] = declared.high if widened == declared.low else declared.low
    return model.replace(**sharp)


def highlighted(model: Model) -> Model:
    """The model whose highlight a material's table belongs to: of a coat its base, else itself."""
    base = getattr(model, "base", None)
    return base if hasattr(model, "image_coat") and isinstance(base, Model) else model


def look_up(table: NDArray[Any], mu: ArrayLike, alpha: ArrayLike) -> Floats:
    """A and B as a graphics card looks them up: linear, clamped at the middles of the outer texels."""
    mu, alpha = np.broadcast_arrays(np.asarray(mu, np.float64), np.asarray(alpha, np.float64))
    size = len(table)
    x, y = (np.clip(v * size - 0.5, 0, size - 1) for v in (mu, np.sqrt(np.maximum(alpha, 0))))
    i, j = (np.minimum(v.astype(int), size - 2) for v in (x, y))
    s, t = (x - i)[..., None], (y - j)[..., None]
    left = (1 - t) * table[j, i] + t * table[j + 1, i]
    right = (1 - t) * table[j, i + 1] + t * table[j + 1, i + 1]
    return np.asarray((1 - s) * left + s * right, np.float64)


def split_sum_error(table: NDArray[Any], model: Model, count: int = 500) -> float:
    """By how much A or B, looked up, is off at most, at random cosines above 0.02 and widths."""
    rng = np.random.default_rng(0)
    mu, alpha = rng.uniform(0.02, 1, count), rng.uniform(0.02, 1, count) ** 2
    exact = split_sum(model, mu, alpha)
    return float(np.abs(look_up(table, mu, alpha) - exact).max())
