"""Colours at wavelengths: three spectra that stand for red, green and blue.

A model's colours are three numbers, and it computes with each of them alone. In spectral variants it
computes with the same three, and its result is spread over the wavelengths by three spectra that lie
between 0 and 1, add up to 1, and look like the primaries of sRGB under daylight (D65). So reflectances,
indices, extinctions and absorptions alike give the colour that they give in RGB, grey stays grey, and no
energy is made. Where real spectra meet colours in one model, the colours themselves are spread so.

After Mallett and Yuksel, "Spectral primary decomposition for rendering with sRGB reflectance", EGSR 2019:
the smoothest such spectra, found here by least squares.
"""

from __future__ import annotations

import functools
from typing import Any

import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

STEP = 10.0  # nanometres: the spectra turn over 50
# Of a condition against the smoothness: it is met to a hundred-thousandth.
STRICT = 1e3


def wavelengths() -> Floats:
    """Where the three spectra have their values, in nanometres."""
    return np.asarray(np.arange(mi.MI_CIE_MIN, mi.MI_CIE_MAX + STEP / 2, STEP))


@functools.cache
def primaries() -> Floats:
    """Values of the three spectra, shape (3, wavelengths)."""
    from scipy.optimize import lsq_linear

    seen = _seen_by_node()
    count = seen.shape[1]
    one = np.eye(count)
    slope = np.diff(one, axis=0)
    alike = np.kron(np.eye(3), slope)  # smooth, each of the three
    added = STRICT * np.concatenate([one, one, one], axis=1)
    looks = STRICT * np.kron(np.eye(3), seen)
    system = np.concatenate([alike, added, looks])
    wanted = np.concatenate(
        [np.zeros(len(alike)), np.full(count, STRICT), STRICT * np.eye(3).reshape(-1)]
    )
    found = lsq_linear(system, wanted, bounds=(0, 1), tol=1e-12)
    values = np.clip(found.x.reshape(3, count), 0, 1)
    return np.asarray(values / values.sum(axis=0))


def _seen_by_node() -> Floats:
    """Linear sRGB of a spectrum that is 1 at one node and falls to 0 at the next, in D65; (3, nodes)."""
    fine = np.arange(mi.MI_CIE_MIN, mi.MI_CIE_MAX + 0.25, 0.5)
    place = (fine - mi.MI_CIE_MIN) / STEP
    tents = np.maximum(1 - np.abs(place - np.arange(len(wavelengths()))[:, None]), 0)
    observer = np.array([np.ravel(mi.cie1931_xyz(float(w))) for w in fine])
    daylight = np.array([float(np.ravel(mi.cie_d65(float(w)))[0]) for w in fine])
    weights = daylight[:, None] * observer
    weights = weights / weights[:, 1].sum()  # white has the luminance 1
    to_rgb = np.array(
        [np.ravel(mi.xyz_to_srgb(mi.ScalarColor3f(*np.eye(3)[k].tolist()))) for k in range(3)]
    )
    return np.asarray((tents @ weights @ to_rgb).T)


class Spread:
    """The three spectra as textures of Mitsuba's current variant, which has to be spectral."""

    def __init__(self) -> None:
        """Make the three textures."""
        limits = {"wavelength_min": mi.MI_CIE_MIN, "wavelength_max": wavelengths()[-1]}
        self.textures = [
            mi.load_dict({"type": "regular", "values": ", ".join(map(repr, v.tolist()))} | limits)
            for v in primaries()
        ]

    def __call__(self, colour: Any, si: Any, active: Any) -> Any:
        """A colour of three numbers at the wavelengths of si."""
        red, green, blue = (texture.eval(si, active) for texture in self.textures)
        return red * colour[0] + green * colour[1] + blue * colour[2]


_spreads: dict[str, Spread] = {}


def spread() -> Spread:
    """The three spectra for the current variant, made when they are first needed."""
    if mi.variant() not in _spreads:
        _spreads[mi.variant()] = Spread()
    return _spreads[mi.variant()]


def rgb_constant(colour: tuple[float, ...]) -> Any:
    """A texture that holds a colour as three numbers, of any size."""
    return mi.load_dict({"type": "rawconstant", "value": list(colour)})


def holds_rgb(texture: Any) -> bool:
    """Whether a texture of a spectral variant holds colours as three numbers, not as spectra."""
    kind = texture.class_name()
    if kind.startswith("RawConstant"):
        return True
    # A bitmap has them when it is raw.
    return kind.startswith("Bitmap") and "raw = 1" in str(texture)
