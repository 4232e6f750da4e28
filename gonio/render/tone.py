"""From linear light to what a screen shows: curves that bend highlights, and sRGB.

Sources: "filmic" is the fit of Narkowicz, "ACES filmic tone mapping curve", 2015; "agx" is Sobotka's AgX
as Wrensch fitted it with a polynomial, "Minimal AgX implementation", 2023.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Pixels = NDArray[np.float32]


def _linear(rgb: Pixels) -> Pixels:
    return np.clip(rgb, 0, 1)


# Scales the light so that middle grey, 0.18, stays where it is; the root of curve(s * 0.18) = 0.18.
FILMIC_SCALE = 0.7232


def _filmic(rgb: Pixels) -> Pixels:
    x = np.minimum(np.maximum(rgb, 0) * np.float32(FILMIC_SCALE), np.float32(1e6))
    return np.clip(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0, 1)


# Linear sRGB to AgX's primaries, which lie further out, so that bright saturated light turns white.
AGX_INSET = np.array(
    [
        [0.842479062253094, 0.0784335999999992, 0.0792237451477643],
        [0.0423282422610123, 0.878468636469772, 0.0791661274605434],
        [0.0423756549057051, 0.0784336, 0.879142973793104],
    ]
)
# Stops between which AgX's curve runs, and the polynomial of degree six that stands for it.
AGX_STOPS = (-12.47393, 4.026069)
AGX_CURVE = (15.5, -40.14, 31.96, -6.868, 0.4298, 0.1191, -0.00232)


def _agx(rgb: Pixels) -> Pixels:
    inset = np.maximum(rgb, 0) @ AGX_INSET.T
    low, high = AGX_STOPS
    place = np.clip((np.log2(np.maximum(inset, 2.0**low)) - low) / (high - low), 0, 1)
    shown = np.clip(np.polyval(AGX_CURVE, place) @ np.linalg.inv(AGX_INSET).T, 0, 1)
    return np.asarray(shown**2.2, np.float32)  # the curve gives codes of a 2.2 screen


TONES: dict[str, Callable[[Pixels], Pixels]] = {"linear": _linear, "filmic": _filmic, "agx": _agx}


def to_srgb(pixels: Pixels, exposure: float = 0.0, tone: str = "linear") -> NDArray[np.uint8]:
    """8-bit sRGB of linear pixels.

    Args:
        pixels: linear RGB, shape (height, width, 3), or with alpha by which they are multiplied, (..., 4).
        exposure: in stops, before the curve.
        tone: "linear" (clipped at 1), "filmic" or "agx".

    Raises:
        ValueError: another curve, or an exposure that is not finite.
    """
    if tone not in TONES:
        raise ValueError(f"no tone curve {tone!r}; known are {', '.join(TONES)}.")
    if not np.isfinite(exposure):
        raise ValueError(f"exposure={exposure} is not a finite number of stops.")
    alpha = pixels[..., 3:]
    light = np.asarray(pixels[..., :3], np.float32)
    if alpha.size:
        light = np.asarray(light / np.maximum(alpha, np.float32(1e-6)), np.float32)
    with np.errstate(over="ignore"):
        exposed = light * np.float32(np.exp2(np.clip(exposure, -126, 126)))
    shown = np.clip(TONES[tone](np.asarray(exposed, np.float32)), 0, 1)
    # IEC 61966-2-1
    codes = np.where(shown <= 0.0031308, 12.92 * shown, 1.055 * shown ** (1 / 2.4) - 0.055)
    return np.round(255 * np.concatenate([codes, np.clip(alpha, 0, 1)], axis=-1)).astype(np.uint8)
