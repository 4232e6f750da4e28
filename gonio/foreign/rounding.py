"""How far roundings of float32 move values of foreign code: by shaking directions and parameters."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from gonio.foreign.expressions import Array
from gonio.foreign.function import Foreign

# float32 keeps 24 bits; directions are shaken by so many of its roundings, so many times.
ULP = 2.0**-24
SHAKEN, TIMES = 2.0, 4

# So many times what shaking changes is allowed: sums in shaders have dozens of roundings.
ROUNDINGS = 8.0

# Rounding may look small at one place by luck, and a search finds such places. An error is there all around
# as well: the best so many places are looked at again, at so many neighbours each, shaken more often; the
# lower quartile of their departures counts.
BEST, NEIGHBOURS, NEAR, OFTEN = 8, 24, 1e-4, 12


@dataclass(frozen=True)
class Rounded:
    """Values, and how far roundings of the directions move them."""

    values: Array
    rounding: Array


def rounded(
    foreign: Foreign, wi: Array, wo: Array, values: Any, seed: int = 5, times: int = TIMES
) -> Rounded:
    """Values (n, 3), and the largest change that roundings of what it is given make."""
    rng = np.random.default_rng(seed)
    middle = foreign.brdf(wi, wo, values)
    spread = np.zeros_like(middle)
    for _ in range(times):
        a, b = (
            w + SHAKEN * ULP * np.maximum(np.abs(w), ULP) * rng.uniform(-1, 1, w.shape)
            for w in (wi, wo)
        )
        # An index of 1 leaves a Fresnel term that is nothing but roundings
        shaken = {
            name: x * (1 + SHAKEN * ULP * rng.uniform(-1, 1, np.shape(x)))
            for name, x in (values or {}).items()
        }
        with np.errstate(invalid="ignore"):
            spread = np.fmax(spread, np.abs(foreign.brdf(a, b, shaken or values) - middle))
    return Rounded(middle, spread)
