"""MERL's `.binary`: isotropic, over half and difference angles.

Source: Matusik, Pfister, Brand, McMillan, "A Data-Driven Reflectance Model", SIGGRAPH 2003, and the
reader that comes with the data. Three int32 (90, 90, 180), then a plane of float64 for red, green and
blue each, with the index phi_d + 180 (theta_d + 90 theta_h). Steps of theta_d and phi_d are a degree;
theta_h's index is 90 sqrt(theta_h / 90°). The reader cuts an angle down to the next index, so a number
stands for the middle of its step: so do gonio's reader and writer have it, and values between are
interpolated.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from gonio.files import replacing
from gonio.measured.frames import Floats, from_half_difference, half_difference
from gonio.measured.grid import Grid
from gonio.measured.measurement import Mask, Measurement, Reflectance, measurement
from gonio.measured.source import Source

NAME, SUFFIX = "MERL", ".binary"

SCALES = (1 / 1500, 1.15 / 1500, 1.66 / 1500)

# Beyond this the authors have continued their measurements.
EXTRAPOLATED = np.radians(80)

# Of the file; the other one is MERL's with phi_d all around.
SHAPES = ((90, 90, 180), (90, 90, 360))

# No table has longer axes.
LONGEST = 4096

BELOW = -1.0
"""What the format has for directions below the horizon."""


def _shape(source: Source) -> tuple[int, ...] | None:
    if source.size < 12:
        return None
    shape = tuple(int(n) for n in np.frombuffer(source.head[:12], "<i4"))
    return shape if all(1 <= n <= LONGEST for n in shape) else None


def sniff(source: Source) -> bool:
    """By its three numbers, and by the size that follows from them."""
    shape = _shape(source)
    return shape is not None and (shape in SHAPES or source.size == 12 + 24 * int(np.prod(shape)))


def read(source: Source) -> list[Measurement]:
    """The reflection; negative numbers are holes."""
    shape = _shape(source)
    assert shape is not None
    planes = source.binary(12, "<f8", (3, *shape))
    if source.size != 12 + 24 * int(np.prod(shape)):
        raise source.error(
            f"has {source.size} bytes; a table of {' x '.join(map(str, shape))} has "
            f"{12 + 24 * int(np.prod(shape))}."
        )
    n_h, n_d, n_p = shape
    count = n_h * n_d * n_p
    full_circle = n_p == 360
    values = np.empty((count, 3), np.float32)
    hole = np.zeros(count, bool)
    for c, scale in enumerate(SCALES):
        plane = np.asarray(planes[c]).reshape(-1)
        hole |= ~(plane >= 0)
        with np.errstate(over="ignore", invalid="ignore"):
            values[:, c] = plane * scale
    theta_h, theta_d, phi_d = _axes(n_h, n_d, n_p)
    wi, wo = np.empty((count, 3), np.float32), np.empty((count, 3), np.float32)
    size = n_d * n_p
    for row in range(n_h):  # a row at a time keeps double precision small
        place = slice(row * size, (row + 1) * size)
        a, b = from_half_difference(theta_h[row], 0.0, np.repeat(theta_d, n_p), np.tile(phi_d, n_d))
        wi[place], wo[place] = a, b
    grid = Grid(values.reshape(*shape, 3), ~hole.reshape(shape), (False, False, True))
    found = measurement(
        NAME,
        source.title,
        wi,
        wo,
        values,
        hole=hole,
        channels=("r", "g", "b"),
        extrapolated=np.tile(np.repeat(theta_d > EXTRAPOLATED, n_p), n_h),
        units="1/sr, stored as float64 over 1/1500, 1.15/1500 and 1.66/1500",
        notes=(
            "negative values mean not measured or below the horizon: holes",
            "values beyond theta_d = 80° are the authors' extrapolation",
            "numbers stand for the middle of their steps of angle",
        ),
        grid={"theta_h": n_h, "theta_d": n_d, "phi_d": n_p},
        interpolator=Between(grid, full_circle),
    )
    return [found]


def _axes(n_h: int, n_d: int, n_p: int) -> tuple[Floats, Floats, Floats]:
    """Middles of the steps, in radians."""
    theta_h = 0.5 * np.pi * ((np.arange(n_h) + 0.5) / n_h) ** 2
    theta_d = 0.5 * np.pi * (np.arange(n_d) + 0.5) / n_d
    turn = 2 * np.pi if n_p == 360 else np.pi
    return theta_h, theta_d, turn * (np.arange(n_p) + 0.5) / n_p


class Between:
    """Values between the numbers of a table over theta_h (by its root), theta_d and phi_d."""

    def __init__(self, grid: Grid, full_circle: bool) -> None:
        """`full_circle`: phi_d goes to 2 pi, not to pi, behind which the values repeat."""
        self.grid, self.turn = grid, 2 * np.pi if full_circle else np.pi
        self.reciprocal = not full_circle

    def __call__(self, wi: Floats, wo: Floats) -> tuple[Floats, Mask]:
        """Values and whether they were measured."""
        theta_h, _, theta_d, phi_d = half_difference(wi, wo)
        n_h, n_d, n_p = self.grid.valid.shape
        return self.grid(
            n_h * np.sqrt(np.clip(theta_h / (0.5 * np.pi), 0, 1)) - 0.5,
            n_d * theta_d / (0.5 * np.pi) - 0.5,
            n_p * (phi_d % self.turn) / self.turn - 0.5,
        )


def write(path: str | Path, reflectance: Reflectance, **options: Any) -> list[str]:
    """Write a table of 90 x 90 x 180. Returns what was lost: anisotropy is averaged over eight
    azimuths."""
    shape = SHAPES[0]
    axes = _axes(*shape)
    turns = [0.0] if reflectance.isotropic else [0.25 * np.pi * (k + 0.5) for k in range(8)]
    planes = np.empty((3, *shape))
    for row, theta_h in enumerate(axes[0]):
        theta_d, phi_d = np.repeat(axes[1], shape[2]), np.tile(axes[2], shape[1])
        total = np.zeros((len(theta_d), 3))
        for phi_h in turns:
            wi, wo = from_half_difference(theta_h, phi_h, theta_d, phi_d)
            total += reflectance.evaluate(wi, wo)[:, :3]
        total /= len(turns)
        total[(wi[:, 2] <= 0) | (wo[:, 2] <= 0)] = BELOW
        planes[:, row] = (total / np.where(total == BELOW, 1, SCALES)).T.reshape(3, *shape[1:])
    with replacing(path) as temporary, temporary.open("wb") as file:
        np.array(shape, "<i4").tofile(file)
        planes.astype("<f8").tofile(file)
    return [] if reflectance.isotropic else ["anisotropy: an average over eight azimuths"]
