"""What a fit makes small: how far a model's values are from measured ones.

Each compares g(f cos(theta_i)), because that is what reaches the eye; g decides how much highlights count.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

# Of the cube root, whose slope has no bound at 0: the product below which it is a line.
SMALL = 1e-6


@dataclass(frozen=True)
class Metric:
    """A scale for reflected light, with its slope."""

    doc: str
    value: Callable[[Any], Any]
    slope: Callable[[Any], Any]


def _cbrt(x: Any) -> Any:
    return np.sign(x) * (np.cbrt(np.abs(x) + SMALL) - np.cbrt(SMALL))


METRICS: dict[str, Metric] = {
    "log": Metric(
        "ln(1 + f cos), Löw et al. 2012: highlights and the rest count alike",
        # A model may go below 0 by a rounding; far below -1 no model is
        lambda x: np.log1p(np.maximum(x, -0.5)),
        lambda x: 1 / (1 + np.maximum(x, -0.5)),
    ),
    "cbrt": Metric(
        "the cube root of f cos, Fores et al. 2012: as bright as it looks",
        _cbrt,
        lambda x: 1 / (3 * np.cbrt(np.abs(x) + SMALL) ** 2),
    ),
    "cosine": Metric(
        "f cos, Ngan et al. 2005: highlights alone",
        lambda x: x,
        lambda x: np.ones_like(x),
    ),
}
"""By name; the first is the default."""
