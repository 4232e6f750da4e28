"""Directions and random numbers that break shading code, in float32."""

from __future__ import annotations

import functools
import itertools

import numpy as np
from numpy.typing import NDArray

from gonio.check.subject import directions

# Cosines at which published listings divide by zero, cancel or leave their range; the smallest is a
# float32 without its full digits (a denormal).
COSINES = (0.0, 1e-42, 1e-30, 1e-7, 1e-6, 1e-4, 1e-3, 0.017, 0.1, 0.5, 0.9, 0.99986, 0.999999, 1.0)
AZIMUTHS = (0.0, 1e-7, 1e-3, 0.5, 1.5707963, 1.5708, 2.0, 3.1414, 3.14159265)

# The smallest and the largest float32 random numbers, and some between.
RANDOM = (0.0, 2.0**-24, 1e-4, 0.25, 0.5, 0.75, 1 - 2.0**-24)


@functools.cache
def hard_pairs(lowest: float = 0.0) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Pairs (wi, wo) of every combination of the cosines and azimuths above, and more.

    Among them: one or both in the horizon, wi = wo, and wi the mirror direction of wo, exactly. Cosines
    between 0 and `lowest` are left out.
    """
    cosines = [mu for mu in COSINES if mu == 0 or mu >= lowest]
    cases = itertools.product(cosines, cosines, AZIMUTHS)
    mu_i, mu_o, phi = np.array(list(cases)).T
    wi = directions(mu_i, phi).astype(np.float32)
    wo = directions(mu_o, 0 * phi).astype(np.float32)
    rng = np.random.default_rng(7)
    turned = directions(rng.random(2000), 2 * np.pi * rng.random(2000)).astype(np.float32)
    grazing = directions(10.0 ** np.linspace(-7, 0, 2000), np.linspace(0, 6, 2000))
    grazing = grazing.astype(np.float32)
    mirror = np.array([-1, -1, 1], np.float32)
    return (
        np.concatenate([wi, turned, turned * mirror, grazing, grazing * mirror]),
        np.concatenate([wo, turned, turned, grazing, grazing]),
    )


def hard_numbers(count: int, seed: int) -> NDArray[np.float32]:
    """Pairs of random numbers (count, 2) out of RANDOM."""
    return np.random.default_rng(seed).choice(np.array(RANDOM, np.float32), (count, 2))


def places(count: int, columns: int, seed: int) -> NDArray[np.float64]:
    """Random places of parameters (count, columns), one in ten of them at an end."""
    rng = np.random.default_rng(seed)
    t = rng.random((count, columns))
    t[rng.random(t.shape) < 0.05] = 0
    t[rng.random(t.shape) < 0.05] = 1
    return t
