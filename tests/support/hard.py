"""Directions, random numbers and parameters at which shading code leaves a float32, in batches."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gonio.fields import Parameter

Array = NDArray[np.float32]

# Values at which formulas change or cancel, inside the range of many parameters.
SPECIAL = (0.0, 1.0, 0.5, 0.25, 1.5, 1 + 1e-6, 1 - 1e-6, 1e-3)


def directions(rng: np.random.Generator, count: int) -> NDArray[np.float64]:
    """Unit vectors: anywhere, cosines down to 1e-18, sines down to 1e-20, and the normal itself."""
    kind, x = rng.integers(0, 4, count), rng.random(count)
    z = np.where(kind == 0, x, 10.0 ** (-18 * x))
    sine = np.where(kind == 2, 10.0 ** (-20 * x), 10.0 ** (-4 * x))
    sine = np.where(kind < 2, np.sqrt(1 - z * z), sine)
    z = np.where(kind < 2, z, np.sqrt(1 - sine * sine))
    phi = np.where(
        rng.random(count) < 0.2,
        np.pi / 4 * rng.integers(0, 8, count),
        2 * np.pi * rng.random(count),
    )
    w = np.stack([sine * np.cos(phi), sine * np.sin(phi), z], -1)
    w[rng.random(count) < 0.02] = (0, 0, 1)
    return w


def pairs(rng: np.random.Generator, count: int) -> tuple[Array, Array]:
    """wi and wo: unrelated, equal, mirrored, and mirrored but for 1e-9 to 1 of them."""
    wo, other, kind = directions(rng, count), directions(rng, count), rng.integers(0, 5, count)
    mirrored = wo * (-1, -1, 1)
    near = mirrored + 10.0 ** (-9 * rng.random((count, 1))) * rng.normal(size=(count, 3))
    lifted = mirrored * (1, 1, 0) + (0, 0, 1) * np.minimum(mirrored * 10 ** rng.normal(), 1)
    wi = np.choose(kind[:, None], [other, wo, mirrored, near, lifted])
    z = np.clip(np.abs(wi[:, 2]), 1e-40, 1)
    level = np.hypot(wi[:, 0], wi[:, 1])
    scale = np.sqrt(1 - z * z) / np.maximum(level, 1e-300)
    flat = np.where(level[:, None] > 0, wi[:, :2] * scale[:, None], 0)
    z = np.where(level > 0, z, 1)
    return np.concatenate([flat, z[:, None]], 1).astype(np.float32), wo.astype(np.float32)


def parameter(rng: np.random.Generator, declared: Parameter, count: int) -> Array:
    """Values (count, width): the ends of the range, near them, the default, special ones, and any."""
    low, high = declared.low, min(declared.high, 1e3)
    default = np.broadcast_to(declared.default, declared.width)
    columns = []
    for channel in range(declared.width):
        kind, x = rng.integers(0, 8, count), rng.random(count)
        small = low + (high - low) * 10.0 ** (-9 * x)
        spread = low + (high - low) * x
        special = np.clip(rng.choice(SPECIAL, count), low, high)
        ends = [np.full(count, low), np.full(count, high), np.full(count, default[channel])]
        columns.append(np.choose(kind, [*ends, small, high + low - small, special, spread, spread]))
    grey = rng.random(count) < 0.3
    columns = [np.where(grey, columns[0], c) for c in columns]
    return np.clip(np.stack(columns, -1).astype(np.float32), declared.lowest, declared.highest)


def numbers(rng: np.random.Generator, count: int) -> Array:
    """Pairs of random numbers in [0, 1): both ends, near them, and any."""
    kind, x = rng.integers(0, 5, (count, 2)), rng.random((count, 2))
    last = np.full((count, 2), 1 - 2.0**-24)
    u = np.choose(kind, [0 * x, last, 10.0 ** (-8 * x), 1 - 10.0 ** (-8 * x), x])
    return np.minimum(u, last).astype(np.float32)


def values(rng: np.random.Generator, model: Any, count: int) -> dict[str, Array]:
    """Values of every parameter, those of inner models included, by path."""
    return {path: parameter(rng, declared, count) for path, declared, _ in model.parameters()}
