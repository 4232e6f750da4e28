"""Where foreign code is judged: directions and parameters of the points of a search."""

from __future__ import annotations

from typing import Any

import numpy as np

from gonio.check.subject import Array
from gonio.foreign.subject import ForeignSubject

# A departure that is left after that counts from here on, relative to the larger value.
LIMIT = 1e-3

# Cosines of the search; below the second one faults are shown but do not count, because pixels hardly have
# such directions.
MU_LOW, MU_HARD = 1e-3, 1e-5


def places(subject: ForeignSubject, points: Array, low: float = MU_LOW) -> tuple[Array, Array, Any]:
    """wi, wo and values of points in [0, 1]^(numbers + 4)."""
    from gonio.check.reciprocity import pairs

    parameters, wi, wo = pairs(subject, points)
    return lifted(wi, low), lifted(wo, low), subject.values(parameters)


def lifted(w: Array, low: float) -> Array:
    """Directions whose cosines are at least `low`."""
    z = np.maximum(w[:, 2], low)
    flat = np.maximum(np.hypot(w[:, 0], w[:, 1]), 1e-300)
    scale = np.sqrt(np.maximum(1 - z * z, 0)) / flat
    return np.stack([w[:, 0] * scale, w[:, 1] * scale, z], -1)
