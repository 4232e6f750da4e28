"""Spectra to linear sRGB, by Mitsuba's tables: CIE 1931 2° observer, illuminant D65.

A spectrum that is the same everywhere has equal red, green and blue. Between the given wavelengths values
are interpolated, beyond them the last ones go on.
"""

from __future__ import annotations

import functools
import importlib
from typing import Any

import numpy as np

from gonio.measured.frames import Floats
from gonio.measured.measurement import Measurement

TOOL = "linear sRGB by Mitsuba's CIE 1931 2° observer and D65"

# XYZ, D65's white at Y = 1, to linear sRGB: IEC 61966-2-1.
XYZ_TO_RGB = np.array(
    [
        [3.2404542, -1.5371385, -0.4985314],
        [-0.969266, 1.8760108, 0.041556],
        [0.0556434, -0.2040259, 1.0572252],
    ]
)

# Steps of the integral, in nm; Mitsuba's tables have 5.
FIRST, LAST, STEP = 360, 830, 1


@functools.cache
def _observer() -> tuple[Floats, Floats]:
    """Wavelengths, and D65 times the three matching functions (3, n), for a white of Y = 1."""
    # The functions are the same in all variants; this one is looked at without choosing it
    mi = importlib.import_module("mitsuba.scalar_rgb")

    wavelengths = np.arange(FIRST, LAST + STEP, STEP, dtype=np.float64)
    xyz = np.array([np.ravel(mi.cie1931_xyz(float(w))) for w in wavelengths])
    light = np.array([float(mi.cie_d65(float(w))) for w in wavelengths])
    matching = xyz.T * light
    return wavelengths, matching / matching[1].sum()


def rgb_matrix(wavelengths: Any) -> Floats:
    """The matrix (3, n) that turns values at n growing wavelengths in nm into linear sRGB."""
    places, matching = _observer()
    given = np.asarray(wavelengths, np.float64)
    # Each value's share of the values in between, by interpolating unit vectors
    shares = np.stack([np.interp(places, given, unit) for unit in np.eye(len(given))], -1)
    matrix = XYZ_TO_RGB @ matching @ shares
    return np.asarray(matrix / matrix.sum(-1, keepdims=True))  # rounding of the white point


def to_rgb(measured: Measurement, values: Any) -> tuple[Floats, str]:
    """Values (n, channels) of a measurement as linear sRGB (n, 3), and how, in words."""
    values = np.asarray(values, np.float64)
    if measured.wavelengths is not None:
        if len(measured.wavelengths) == 1:
            return np.repeat(values, 3, -1), f"grey: one wavelength, {measured.channels[0]}"
        return values @ rgb_matrix(measured.wavelengths).T, TOOL
    if measured.channels == ("X", "Y", "Z"):
        return values @ XYZ_TO_RGB.T, "linear sRGB from XYZ by IEC 61966-2-1"
    if values.shape[-1] == 3:
        return values, "as in the file"
    return np.repeat(values.mean(-1, keepdims=True), 3, -1), (
        "grey" if values.shape[-1] == 1 else f"grey: the mean of {values.shape[-1]} channels"
    )
