"""Measurements as tables over half and difference angles, and what a model samples and reflects by them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gonio.measured.frames import Floats, from_half_difference, half_difference, spherical
from gonio.measured.grid import Grid
from gonio.measured.measurement import Measurement
from gonio.measured.spectra import to_rgb

# Places along theta_h (by its root), theta_d and phi_d: MERL's.
ISOTROPIC = (90, 90, 180)

# Places along phi_h, theta_h, theta_d and phi_d.
ANISOTROPIC = (24, 48, 20, 30)

# Angles of the viewer that have a distribution of normals each, and normals' angles in it.
ROWS, BINS = 32, 90

# Azimuths of normals that a distribution is averaged over.
TURNS = 48

# Shares of the cosine-weighted samples that are tried; the lowest bounds the weights to pi f / 0.1.
SHARES = (0.1, 0.2, 0.35, 0.5, 0.65, 0.8, 0.95)

# Of the mean density: what a normal is drawn with at least, where the table says 0.
LEAST = 1e-3

# Places of the table of albedos along theta_o, and azimuths of the viewer for what is anisotropic.
ALBEDOS, AZIMUTHS = 91, 12


@dataclass(frozen=True)
class Tables:
    """What a measured model is made of; all with the last axis fastest."""

    values: NDArray[np.float32]
    """(theta_h, theta_d, phi_d, 3) or (phi_h, theta_h, theta_d, phi_d, 3), linear sRGB, not negative."""
    density: NDArray[np.float32]
    """(ROWS, BINS): of normals, in 1/sr."""
    cumulative: NDArray[np.float32]
    """(ROWS, BINS + 1): its integral."""
    bounds: NDArray[np.float32]
    """(BINS + 1,): 1 - cos(theta_m) at the bins' ends."""
    share: NDArray[np.float32]
    """(ROWS,): of cosine-weighted samples."""
    albedo: NDArray[np.float32]
    """(azimuths, ALBEDOS, 3): for theta_o in equal steps from 0 to 90 degrees."""
    mean_albedo: tuple[float, float, float]
    notes: tuple[str, ...]
    """What was changed, with its size."""


def tabulate(measured: Measurement, shape: tuple[int, ...] | None = None) -> Tables:
    """Put a measurement into tables.

    It is made reciprocal (by the mean of both orders), negative values become 0, and what was not measured
    takes the value of the nearest place that was.

    Args:
        measured: reflection.
        shape: places along theta_h, theta_d and phi_d, with those of phi_h before them for what is
            anisotropic; by default 90 x 90 x 180 and 24 x 48 x 20 x 30.

    Raises:
        ValueError: a shape that does not fit.
    """
    default = ISOTROPIC if measured.isotropic else ANISOTROPIC
    shape = default if shape is None else shape
    if len(shape) != len(default) or min(shape) < 2:
        raise ValueError(f"the shape {shape} is not one of {len(default)} places of at least 2.")
    values, known, notes = _fill(measured, shape)
    grid = Grid(
        values, np.ones(shape, bool), (False,) * 3 if len(shape) == 3 else (True,) + (False,) * 3
    )
    grid.periodic = (*grid.periodic[:-1], True)
    evaluate = evaluator(grid)
    density, cumulative, share = _normals(evaluate, measured.isotropic)
    albedo = _albedos(evaluate, measured.isotropic)
    theta = np.linspace(0, 0.5 * np.pi, ALBEDOS)
    weight = np.sin(2 * theta) * (theta[1] - theta[0])
    mean = (albedo.mean(0) * weight[:, None]).sum(0) / weight.sum()
    if not known.all():
        notes.append(
            f"{1 - known.mean():.1%} of the table is filled with the nearest measured value"
        )
    return Tables(
        values,
        density.astype(np.float32),
        cumulative.astype(np.float32),
        (2 * np.sin(0.5 * edges()) ** 2).astype(np.float32),
        share.astype(np.float32),
        albedo.astype(np.float32),
        (float(mean[0]), float(mean[1]), float(mean[2])),
        tuple(notes),
    )


def places(shape: tuple[int, ...]) -> tuple[Floats, Floats, Floats, Floats]:
    """phi_h, theta_h, theta_d and phi_d of the middles of a table's steps."""
    n_q, n_h, n_d, n_p = (1, *shape) if len(shape) == 3 else shape
    phi_h = 2 * np.pi * (np.arange(n_q) + (0.5 if n_q > 1 else 0)) / n_q
    theta_h = 0.5 * np.pi * ((np.arange(n_h) + 0.5) / n_h) ** 2
    return (
        phi_h,
        theta_h,
        0.5 * np.pi * (np.arange(n_d) + 0.5) / n_d,
        np.pi * (np.arange(n_p) + 0.5) / n_p,
    )


def _fill(
    measured: Measurement, shape: tuple[int, ...]
) -> tuple[NDArray[np.float32], NDArray[Any], list[str]]:
    phi_h, theta_h, theta_d, phi_d = places(shape)
    full = (len(phi_h), len(theta_h), len(theta_d), len(phi_d))
    size = math.prod(full[1:]) if len(phi_h) > 1 else math.prod(full[2:])
    count = math.prod(full) // size
    values = np.zeros((count, size, 3), np.float32)
    known, above = np.zeros((count, size), bool), np.zeros((count, size), bool)
    reciprocal = getattr(measured.interpolator, "reciprocal", False)
    negative = 0
    for row in range(count):  # a part at a time, which bounds the memory
        q, h, d, p = (
            axis[i]
            for axis, i in zip(
                (phi_h, theta_h, theta_d, phi_d),
                np.unravel_index(np.arange(row * size, (row + 1) * size), full),
                strict=True,
            )
        )
        wi, wo = from_half_difference(h, q, d, p)
        up = (wi[:, 2] > 1e-4) & (wo[:, 2] > 1e-4)
        above[row] = up
        if not up.any():
            continue
        forward, sure = measured.interpolate(wi[up], wo[up])
        back, sure_back = forward, sure
        if not reciprocal:
            back, sure_back = measured.interpolate(wo[up], wi[up])
        weight = np.where(sure | sure_back, sure, 1).astype(float)[:, None]
        other = np.where(sure | sure_back, sure_back, 1).astype(float)[:, None]
        mean = (weight * forward + other * back) / (weight + other)
        negative += int((mean < 0).any(-1).sum())
        values[row, up] = to_rgb(measured, mean)[0]
        known[row, up] = sure | sure_back
    notes = []
    if negative:
        notes.append(f"{negative / above.sum():.1%} of the table was negative: 0")
    np.maximum(values, 0, out=values)
    # Below the horizon and where nothing is known: the nearest place of the table
    nearest = _nearest(
        above.reshape(full) & known.reshape(full) if known.any() else above.reshape(full)
    )
    filled = values.reshape(*full, 3)[nearest]
    return filled.reshape(*shape, 3), known[above], notes


def _nearest(known: NDArray[Any]) -> tuple[NDArray[Any], ...]:
    """Indices of the nearest known place, with phi_d going round."""
    from scipy.ndimage import distance_transform_edt

    period = known.shape[-1]
    margin = min(period, 8)
    wrapped = np.concatenate([known[..., -margin:], known, known[..., :margin]], -1)
    index = distance_transform_edt(~wrapped, return_distances=False, return_indices=True)
    index = index[..., margin : margin + period]
    return (*index[:-1], (index[-1] - margin) % period)


def evaluator(grid: Grid) -> Callable[[Any, Any], Floats]:
    """Values (n, 3) of a table at directions (n, 3): the model, in NumPy."""
    n_h, n_d, n_p = grid.valid.shape[-3:]

    def evaluate(wi: Any, wo: Any) -> Floats:
        theta_h, phi_h, theta_d, phi_d = half_difference(wi, wo)
        at = [
            n_h * np.sqrt(np.clip(theta_h / (0.5 * np.pi), 0, 1)) - 0.5,
            n_d * theta_d / (0.5 * np.pi) - 0.5,
            n_p * (phi_d % np.pi) / np.pi - 0.5,
        ]
        if grid.valid.ndim == 4:
            n_q = grid.valid.shape[0]
            at.insert(0, n_q * (phi_h % (2 * np.pi)) / (2 * np.pi) - 0.5)
        return grid(*at)[0]

    return evaluate


def edges() -> Floats:
    """Bounds of the normals' angles, in radians: as MERL has theta_h."""
    return np.asarray(0.5 * np.pi * (np.arange(BINS + 1) / BINS) ** 2)


def _normals(evaluate: Any, isotropic: bool) -> tuple[Floats, Floats, Floats]:
    """Distributions of normals, each in proportion to what is reflected by them, and shares."""
    bounds = edges()
    solid = 2 * np.pi * (np.cos(bounds[:-1]) - np.cos(bounds[1:]))
    middle = np.sqrt(bounds[1:] * bounds[:-1])
    middle[0] = 0.5 * bounds[1]
    phi = 2 * np.pi * (np.arange(TURNS) + 0.5) / TURNS
    m = spherical(middle[:, None], phi)
    density, share = np.empty((ROWS, BINS)), np.empty(ROWS)
    turns = [0.0] if isotropic else [2 * np.pi * k / 8 for k in range(8)]
    for row in range(ROWS):
        theta = 0.5 * np.pi * (row + 0.5) / ROWS
        light, around = np.zeros((len(turns), BINS, TURNS)), np.zeros((BINS, TURNS))
        cosine = np.zeros((len(turns), BINS, TURNS))
        for number, turn in enumerate(turns):
            wo = spherical(theta, turn)
            cos_h = m @ wo
            wi = 2 * cos_h[..., None] * m - wo
            up = (wi[..., 2] > 1e-6) & (cos_h > 1e-6)
            f = np.zeros((BINS, TURNS))
            f[up] = evaluate(wi[up], np.broadcast_to(wo, wi[up].shape)).mean(-1)
            light[number] = f * np.maximum(wi[..., 2], 0)
            cosine[number] = np.where(up, wi[..., 2], 0)
            around = np.maximum(cos_h, 0)
        wanted = (4 * around * light.mean(0)).mean(-1)
        wanted += LEAST * (wanted @ solid) / (2 * np.pi) + 1e-12
        density[row] = wanted / (wanted @ solid)
        # The share with the smallest second moment of light over density
        area = 4 * around * solid[:, None] / TURNS
        lobe = density[row][:, None] / np.maximum(4 * around, 1e-9)
        moments = [
            np.sum(light**2 / np.maximum(s * cosine / np.pi + (1 - s) * lobe, 1e-12) * area)
            for s in SHARES
        ]
        share[row] = SHARES[int(np.argmin(moments))]
    cumulative = np.concatenate([np.zeros((ROWS, 1)), np.cumsum(density * solid, -1)], -1)
    return density, cumulative / cumulative[:, -1:], share


def _albedos(evaluate: Any, isotropic: bool) -> Floats:
    """Directional albedos (azimuths, ALBEDOS, 3), integrated over half vectors in the table's steps."""
    n, turns, every = (2 * BINS, 48, 1) if isotropic else (BINS, 36, 3)
    bounds = 0.5 * np.pi * (np.arange(n + 1) / n) ** 2
    solid = np.repeat((np.cos(bounds[:-1]) - np.cos(bounds[1:])) * 2 * np.pi / turns, turns)
    theta = 0.5 * np.pi * ((np.arange(n) + 0.5) / n) ** 2
    m = spherical(theta[:, None], 2 * np.pi * (np.arange(turns) + 0.5) / turns).reshape(-1, 3)
    azimuths = 1 if isotropic else AZIMUTHS
    thetas = np.linspace(0, 0.5 * np.pi, ALBEDOS)
    given = thetas[::every]  # those between are interpolated for what is anisotropic
    albedo = np.empty((azimuths, len(given), 3))
    for turn in range(azimuths):
        for row, theta_o in enumerate(given):
            # In the horizon there is a limit: what grazes it by a quarter of a degree
            wo = spherical(min(theta_o, 0.5 * np.pi - 0.005), 2 * np.pi * turn / azimuths)
            cos_h = m @ wo
            wi = 2 * cos_h[:, None] * m - wo
            up = (wi[:, 2] > 1e-6) & (cos_h > 1e-6)
            f = evaluate(wi[up], np.broadcast_to(wo, wi[up].shape))
            weight = (4 * cos_h * solid)[up] * wi[up, 2]
            albedo[turn, row] = (f * weight[:, None]).sum(0)
    return np.array(
        [
            np.stack([np.interp(thetas, given, around[:, c]) for c in range(3)], -1)
            for around in albedo
        ]
    )


__all__ = ["ALBEDOS", "ANISOTROPIC", "AZIMUTHS", "BINS", "ISOTROPIC", "ROWS", "Tables", "tabulate"]
