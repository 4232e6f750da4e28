"""Light that wanders below the surface of skin before it leaves, as a blur on the screen.

    gonio.render(gonio.materials.load_material("skin"), diffusion=0.01)     # 1 mm is 0.01 scene units

Only what a surface reflects diffusely is blurred, by how far the points seen in neighbouring pixels are
apart in space. So nothing crosses from one object to another, nor from a nose to the cheek behind it.

Sources: Gotanda, "Beyond a simple physically based Blinn-Phong model in real-time", SIGGRAPH 2012 course,
section 4: a small amount, almost invisible, over a rough layered model; d'Eon, Luebke, Enderton, "Efficient
rendering of human skin", EGSR 2007, for how far light of each colour gets.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]

# d'Eon, Luebke, Enderton: variances in square millimetres, and weights of red, green and blue.
SKIN = (
    (0.0064, (0.233, 0.455, 0.649)),
    (0.0484, (0.100, 0.336, 0.344)),
    (0.187, (0.118, 0.198, 0.0)),
    (0.567, (0.113, 0.007, 0.007)),
    (1.99, (0.358, 0.004, 0.0)),
    (7.41, (0.078, 0.0, 0.0)),
)

# Millimetres that are reckoned with; less than 0.5 % of the red light gets farther.
REACH = 6.5

# Pixels that this may be; the work grows with the square.
RADIUS_MAX = 40


def skin_profile(distance: ArrayLike) -> Floats:
    """Share of light that leaves at a distance in millimetres, per square millimetre; shape (..., 3)."""
    r2 = np.asarray(distance, np.float64)[..., None] ** 2
    total = np.zeros((*r2.shape[:-1], 3))
    for variance, weights in SKIN:
        total += np.array(weights) / (2 * np.pi * variance) * np.exp(-r2 / (2 * variance))
    return total


def diffuse_on_screen(
    light: ArrayLike,
    positions: ArrayLike,
    areas: ArrayLike,
    surface: ArrayLike,
    millimetre: float,
    progress: Callable[[int, int], None] | None = None,
) -> Floats:
    """Spread diffusely reflected light over the pixels that show points nearby on the same surface.

    Args:
        light: the diffuse part of a picture, shape (height, width, 3).
        positions: the points seen, shape (height, width, 3).
        areas: of surface that each pixel shows, up to a factor, shape (height, width).
        surface: number of the surface seen, 0 for none, shape (height, width).
        millimetre: in the unit of `positions`.
        progress: called after each row of neighbours with what is done and the whole.

    Raises:
        ValueError: as `reach_in_pixels`.
    """
    whole, number = np.array(light, np.float64), np.asarray(surface)
    radius = reach_in_pixels(positions, number, millimetre)
    if not number.any():
        return whole
    shown = tuple(slice(at.min(), at.max() + 1) for at in np.nonzero(number))
    P, number = np.asarray(positions, np.float64)[shown], number[shown]
    L, A = whole[shown], np.asarray(areas, np.float64)[shown]
    height, width = number.shape
    # The pixel itself stands for the places in it, half a pixel away on the mean.
    own = _spacing(P, number) / 2
    weights = skin_profile(np.broadcast_to(own / millimetre, number.shape)) * A[..., None]
    weights *= (own / millimetre < REACH) & (number > 0)[..., None]
    total = weights * L
    # Light goes both ways between two pixels: half of the neighbours are enough.
    for down in range(radius + 1):
        for right in range(-radius if down else 1, radius + 1):
            if down * down + right * right > radius * radius:
                continue
            here = _window(height, -down), _window(width, -right)
            there = _window(height, down), _window(width, right)
            apart = np.linalg.norm(P[here] - P[there], axis=-1)
            apart = np.maximum(apart, own) / millimetre
            near = np.nonzero(
                (number[here] == number[there]) & (number[here] > 0) & (apart < REACH)
            )
            share = skin_profile(apart[near])
            for to, by in ((here, there), (there, here)):
                weight = share * A[by][near][:, None]
                total[to][near] += weight * L[by][near]
                weights[to][near] += weight
        if progress is not None:
            progress(down + 1, radius + 1)
    whole[shown] = np.where(weights > 0, total / np.where(weights > 0, weights, 1), L)
    return whole


def reach_in_pixels(positions: ArrayLike, surface: ArrayLike, millimetre: float) -> int:
    """How many pixels light gets to each side.

    Args:
        positions: the points seen, shape (height, width, 3).
        surface: number of the surface seen, 0 for none, shape (height, width).
        millimetre: in the unit of `positions`.

    Raises:
        ValueError: a millimetre that is not above 0, or that reaches over more than RADIUS_MAX pixels.
    """
    if not millimetre > 0:
        raise ValueError(f"millimetre={millimetre} is out of range; allowed is above 0.")
    spacing = _spacing(np.asarray(positions, np.float64), np.asarray(surface))
    radius = int(np.ceil(REACH * millimetre / spacing)) if spacing > 0 else 0
    if radius > RADIUS_MAX:
        raise ValueError(
            f"light would spread over {radius} pixels, allowed are {RADIUS_MAX}; "
            "make the millimetre or the picture smaller."
        )
    return radius


def _window(size: int, shift: int) -> slice:
    """The part of an axis that has a neighbour `shift` places back."""
    return slice(min(max(shift, 0), size), max(size + min(shift, 0), 0))


def _spacing(P: Floats, number: NDArray[np.generic]) -> float:
    """How far apart neighbouring pixels' points are: the median over the surfaces."""
    together = (number[:, 1:] == number[:, :-1]) & (number[:, 1:] != 0)
    apart = np.linalg.norm(P[:, 1:] - P[:, :-1], axis=-1)[together]
    return float(np.median(apart)) if apart.size else 0.0
