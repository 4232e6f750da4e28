"""F and D as tables, for shaders that look them up instead of computing them.

    fresnel = gonio.bake.tables.fresnel_table(**gonio.parts.metals.metal("Cu"))       # (128, 3)
    gonio.bake.tables.fresnel_error(fresnel, **gonio.parts.metals.metal("Cu")).largest

Source: Elek, "Layered materials in real-time rendering", CESCG 2010, section 3.1: F is a table of 128
entries for each material, D one of 512 x 512 for all. D's axis is u with theta = (pi / 2) u^8: with the
angle itself as the axis a sharp highlight falls between two entries.
Choices where the paper is silent: the axis of F is the cosine, which shaders have; widths of D are spaced
evenly in their logarithm, from ALPHA_LOW, where the peak of D still fits into the paper's 16 bit float.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gonio.arrays.elementwise import elementwise
from gonio.files import check_place, replacing
from gonio.images import write_linear
from gonio.lang import Float, vec3
from gonio.parts import distribution, fresnel

Table = NDArray[np.float32]
Floats = NDArray[np.float64]

FRESNEL_ENTRIES = 128
DISTRIBUTION_ENTRIES = 512

# 1 / (pi ALPHA_LOW^2) is 35,400; a 16 bit float ends at 65,504.
ALPHA_LOW = 0.003

# Largest number of a 16 bit float.
HALF_MAX = 65504.0

# theta = (pi / 2) u^EXPONENT
EXPONENT = 8

DISTRIBUTIONS: dict[str, Callable[..., Any]] = {
    "beckmann": lambda m, alpha: distribution.RoundBeckmann(alpha).D(m),
    "ggx": lambda m, alpha: distribution.RoundGGX(alpha).D(m),
    "blinn_phong": lambda m, alpha: distribution.BlinnPhong(alpha).D(m),
    "gaussian": lambda m, alpha: distribution.Gaussian(alpha).D(m),
}

# Where errors are measured: so many places between two entries.
BETWEEN = 8


@dataclass(frozen=True)
class TableError:
    """How far a table, interpolated, is from its function."""

    largest: float
    """Largest difference: of F itself; of D as a share of its peak at the same width."""
    at: float
    """The angle of incidence, or of the facet's normal, in degrees, where that is."""
    mean: float
    """Largest error of the integral over the hemisphere with the cosine, relative."""


# --- F ---------------------------------------------------------------------------------------------------


def fresnel_table(eta: ArrayLike, k: ArrayLike = 0.0, entries: int = FRESNEL_ENTRIES) -> Table:
    """F at evenly spaced cosines from 0 to 1, for a material.

    Args:
        eta: relative index; one number, or one for each channel.
        k: extinction; 0 for dielectrics.
        entries: how many cosines, at least 2.

    Returns:
        Shape (entries, channels), float32.

    Raises:
        ValueError: an argument out of its range.
    """
    if entries < 2:
        raise ValueError(f"entries={entries} is out of range; allowed is at least 2.")
    return np.asarray(_exact_fresnel(np.linspace(0, 1, entries), eta, k), np.float32)


def check_index(eta: ArrayLike, k: ArrayLike = 0.0) -> None:
    """Refuse light that comes from inside a dielectric, before any of its table is made.

    Where it begins to be reflected totally, F has an upright tangent at a cosine between two entries: with
    index 0.5 a row of 128 is off by 0.18, and 16 times as many entries leave a quarter of that.

    Raises:
        ValueError: an index below 1 without extinction.
    """
    eta, k = np.broadcast_arrays(np.asarray(eta, float), k)
    if (inside := (eta > 0) & (eta < 1) & (k == 0)).any():
        index = float(eta[inside].flat[0])
        raise ValueError(
            f"index {index:g} is below 1: light from inside a dielectric is totally reflected from an "
            "angle on, which a table cannot hold; give at least 1 (the same surface from outside has "
            f"{1 / index:.4g})."
        )


def look_up_fresnel(table: Table, cos_theta: ArrayLike) -> Floats:
    """F from a table, interpolated between two entries; shape (..., channels)."""
    return _interpolated(table, np.clip(cos_theta, 0, 1) * (len(table) - 1))


def fresnel_error(table: Table, eta: ArrayLike, k: ArrayLike = 0.0) -> TableError:
    """How far a table made by `fresnel_table` for this material is from the exact F."""
    cosines = np.linspace(0, 1, BETWEEN * (len(table) - 1) + 1)
    exact, found = _exact_fresnel(cosines, eta, k), look_up_fresnel(table, cosines)
    apart = np.abs(found - exact).max(axis=1)
    weight = 2 * cosines[:, None]
    means = (np.trapezoid(F * weight, cosines, axis=0) for F in (found, exact))
    lookup_mean, exact_mean = means
    worst = int(np.argmax(apart))
    return TableError(
        float(apart[worst]),
        float(np.degrees(np.arccos(cosines[worst]))),
        float(np.max(np.abs(lookup_mean / exact_mean - 1))),
    )


def _exact_fresnel(cosines: Floats, eta: ArrayLike, k: ArrayLike) -> Floats:
    eta, k = np.broadcast_arrays(np.atleast_1d(eta), np.atleast_1d(k))
    if eta.ndim != 1 or not (np.all(eta > 0) and np.all(k >= 0) and np.isfinite(eta + k).all()):
        raise ValueError(
            f"eta={eta.tolist()}, k={k.tolist()}: eta must be above 0 and k at least 0, "
            "one number each or one for each channel."
        )
    return elementwise(fresnel.F_conductor, cosines[:, None], eta, k)


# --- D ---------------------------------------------------------------------------------------------------


def distribution_table(
    name: str = "beckmann", size: int = DISTRIBUTION_ENTRIES, exponent: float = EXPONENT
) -> Table:
    """D for every width and angle.

    Args:
        name: "beckmann", "ggx", "blinn_phong" or "gaussian". Blinn-Phong of a width above 0.99 ends in
            the horizon too steeply for any table.
        size: how many widths and how many angles, at least 2.
        exponent: theta = (pi / 2) u^exponent along the second axis; 1 is the paper's counterexample.

    Returns:
        Shape (size, size), float32: row v has the width ALPHA_LOW^(1 - v), with u and v from 0 to 1.

    Raises:
        ValueError: an unknown distribution, or a size out of its range.
    """
    if name not in DISTRIBUTIONS:
        raise ValueError(f"no distribution {name!r}; known are {', '.join(DISTRIBUTIONS)}.")
    if size < 2:
        raise ValueError(f"size={size} is out of range; allowed is at least 2.")
    axis = np.linspace(0, 1, size)
    theta = np.pi / 2 * axis**exponent
    return np.asarray(_exact_distribution(name, theta, _width(axis)[:, None]), np.float32)


def look_up_distribution(
    table: Table, theta: ArrayLike, alpha: ArrayLike, exponent: float = EXPONENT
) -> Floats:
    """D from a table, interpolated between four entries.

    Args:
        table: as `distribution_table` makes it.
        theta: angle between the facet's normal and the surface's, radians.
        alpha: width; below ALPHA_LOW it is ALPHA_LOW.
        exponent: with which the table was made.
    """
    theta, alpha = np.broadcast_arrays(np.asarray(theta, np.float64), np.asarray(alpha, np.float64))
    last = len(table) - 1
    u = np.clip(theta / (np.pi / 2), 0, 1) ** (1 / exponent) * last
    v = np.clip(1 - np.log(np.maximum(alpha, ALPHA_LOW)) / np.log(ALPHA_LOW), 0, 1) * last
    column, row = (np.minimum(x.astype(int), last - 1) for x in (u, v))
    s, t = u - column, v - row
    above = (1 - s) * table[row, column] + s * table[row, column + 1]
    below = (1 - s) * table[row + 1, column] + s * table[row + 1, column + 1]
    return np.asarray((1 - t) * above + t * below, np.float64)


def distribution_error(
    table: Table, name: str = "beckmann", exponent: float = EXPONENT, alpha: float | None = None
) -> TableError:
    """How far a table made by `distribution_table` is from the exact D, for all widths or for one."""
    last = len(table) - 1
    # Half way between two widths, where interpolation is worst
    widths = _width((np.arange(last) + 0.5) / last) if alpha is None else np.array([alpha])
    u = np.linspace(0, 1, BETWEEN * last + 1)
    theta = np.pi / 2 * u**EXPONENT
    largest, at, mean = 0.0, 0.0, 0.0
    weight = 2 * np.pi * np.sin(theta) * np.cos(theta)
    for width in widths:
        exact = _exact_distribution(name, theta, width)
        found = look_up_distribution(table, theta, width, exponent)
        apart = np.abs(found - exact) / exact.max()
        worst = int(np.argmax(apart))
        if apart[worst] > largest:
            largest, at = float(apart[worst]), float(np.degrees(theta[worst]))
        covered = np.trapezoid(found * weight, theta) / np.trapezoid(exact * weight, theta)
        mean = max(mean, abs(float(covered) - 1))
    return TableError(largest, at, mean)


def _width(v: Floats) -> Floats:
    return np.asarray(ALPHA_LOW ** (1 - v))


def _exact_distribution(name: str, theta: ArrayLike, alpha: ArrayLike) -> Floats:
    evaluate = DISTRIBUTIONS[name]

    def at(sine: Float, cosine: Float, width: Float) -> Float:
        return evaluate(vec3(sine, 0 * sine, cosine), width)

    return elementwise(at, np.sin(theta), np.cos(theta), alpha)


def _interpolated(table: Table, place: ArrayLike) -> Floats:
    at = np.asarray(place, np.float64)
    low = np.minimum(at.astype(int), len(table) - 2)
    t = (at - low)[..., None]
    return np.asarray((1 - t) * table[low] + t * table[low + 1], np.float64)


# --- files -----------------------------------------------------------------------------------------------


def in_halves(table: Table) -> Table:
    """The table as a texture of 16 bit floats holds it."""
    return np.minimum(table, HALF_MAX).astype(np.float16).astype(np.float32)


def write_table(path: str | Path, table: Table, bits: int = 32) -> None:
    """Write a table as .npy, or as an .exr picture with the first axis downwards.

    A table of F becomes a picture one pixel high, with the cosine to the right. bits: 32, or 16 for half
    floats.

    Raises:
        ValueError: another suffix.
        FileNotFoundError: the folder does not exist.
    """
    path = check_table(path)
    stored = table if bits == 32 else in_halves(table)
    with replacing(path) as temporary:
        if path.suffix == ".npy":
            np.save(temporary, stored if bits == 32 else stored.astype(np.float16))
            return

        write_linear(temporary, _picture(stored), half=bits == 16)


def check_table(path: str | Path) -> Path:
    """The path, or a ValueError or OSError unless `write_table` can write a file of this name."""
    path = Path(path)
    if path.suffix not in {".npy", ".exr"}:
        raise ValueError(f"cannot write {path.name!r}; the suffix must be .npy or .exr.")
    return check_place(path)


def _picture(table: Table) -> Table:
    """A table as (rows, columns, channels); an .exr file has one channel or three."""
    if table.ndim == 3:
        return np.concatenate([table, np.zeros_like(table[..., :1])], axis=-1)
    if table.shape[1] in {1, 3} and table.shape[1] != table.shape[0]:
        return table[None]
    return table[..., None]
