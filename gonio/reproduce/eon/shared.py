"""Comparisons that several items make."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from gonio.arrays.elementwise import elementwise
from gonio.models import eon as eon_file
from gonio.reproduce.eon.formulas import HALF_PI, ROUNDING, A_fujii, E_fit, E_fon
from gonio.reproduce.measure import (
    Floats,
    largest_difference,
)
from gonio.reproduce.sheet import Sheet


def loss_difference(r: float, theta: Floats) -> Floats:
    """E_F less its fit, from the losses that gonio's EON computes with."""
    mu = np.cos(theta)
    loss = [elementwise(f, mu) for f in (eon_file.loss_exact, eon_file.loss_fitted)]
    return np.asarray(r * A_fujii(r) / math.pi * (loss[1] - loss[0]))


def fit_error(sheet: Sheet) -> None:
    """Eq. 14 against Eq. 13."""
    theta = np.linspace(0, HALF_PI - 1e-6, 2001)
    error = np.abs(loss_difference(1.0, theta) / E_fon(1.0, theta))
    sheet.claim("largest fractional error of the fitted albedo, r = 1", "<=", "0.001", error.max())
    apart = np.abs(loss_difference(1.0, theta) - (E_fon(1.0, theta) - E_fit(1.0, theta))).max()
    sheet.claim("difference from Eq. 13 less Eq. 14 as printed", "<=", 1e-10, apart, why="rounding")


def same(sheet: Sheet, what: str, ours: Any, theirs: Any, within: float = ROUNDING) -> None:
    """Two forms of one function, over random pairs of directions."""
    difference = largest_difference(ours, theirs)
    sheet.claim(f"{what}: largest difference over random pairs", "<=", within, difference)
