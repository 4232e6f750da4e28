"""Directions and random numbers: random ones, and those that break shading code."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating[Any]]

# Cosines at which published listings divide by zero, cancel or leave their range.
COSINES = (0.0, 1e-7, 1e-6, 1e-4, 1e-3, 0.017, 0.1, 0.5, 0.9, 0.99986, 0.9999, 0.999999, 1.0)
AZIMUTHS = (0.0, 1e-7, 1e-3, 0.5, 1.5707963, 1.5708, 2.0, 3.1414, 3.14159265)

# The smallest and the largest float32 random numbers, and some between.
RANDOM = (0.0, 2.0**-24, 1e-4, 0.25, 0.5, 0.75, 1 - 2.0**-24)


def polar(theta: Any, phi: Any = 0.0) -> Array:
    """Unit vectors, float64, shape (..., 3), from angles in radians."""
    theta, phi = np.broadcast_arrays(theta, phi)
    return np.stack(
        [np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1
    )


def from_cosine(mu: Any, phi: Any = 0.0) -> Array:
    """Unit vectors, float64, shape (..., 3), with exactly the given z."""
    mu, phi = np.broadcast_arrays(np.asarray(mu, np.float64), phi)
    s = np.sqrt((1 - mu) * (1 + mu))
    return np.stack([s * np.cos(phi), s * np.sin(phi), mu], axis=-1)


def random_directions(count: int, seed: int) -> Array:
    """Uniform over the upper hemisphere, float32, shape (count, 3)."""
    rng = np.random.default_rng(seed)
    return from_cosine(rng.random(count), 2 * np.pi * rng.random(count)).astype(np.float32)


def adversarial_pairs() -> tuple[Array, Array]:
    """Pairs (wi, wo), float32, of every combination of hard cosines and azimuths.

    Among them: both in the horizon, wi = wo, and wi the mirror direction of wo, exactly.
    """
    cases = itertools.product(COSINES, COSINES, AZIMUTHS)
    mu_i, mu_o, phi = np.array(list(cases)).T
    wi, wo = from_cosine(mu_i, phi).astype(np.float32), from_cosine(mu_o).astype(np.float32)
    turned = random_directions(2000, seed=7)
    grazing = from_cosine(10.0 ** np.linspace(-7, 0, 2000), np.linspace(0, 6, 2000))
    grazing = grazing.astype(np.float32)
    mirror = np.array([-1, -1, 1], np.float32)
    return (
        np.concatenate([wi, turned, turned * mirror, grazing, grazing * mirror]),
        np.concatenate([wo, turned, turned, grazing, grazing]),
    )
