"""Pictures of light: radiance from all directions, read from the user's file and made sound."""

from __future__ import annotations

import functools
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gonio.images import LUMINANCE, ImageError, Pixels, read_image
from gonio.messages import notice

Floats = NDArray[np.float64]

IMAGE_FORMATS = (".exr", ".hdr")
HALF_MAX = 65504.0  # largest half float: what an overflowed sun pixel (infinite) was at least

# What pictures of other shapes usually are, by width over height.
_SHAPES = {
    1.0: "a mirror ball, an angular map or an octahedron",
    3 / 4: "a vertical cross",
    4 / 3: "a horizontal cross",
    6.0: "a strip of six cube faces",
    1 / 6: "a strip of six cube faces",
}
ASPECT_TOLERANCE = 0.05


def read_light(file: Path) -> Pixels:
    """Radiance in longitude and latitude, (height, width, 3), finite and not negative.

    Values that are not light are replaced and said: NaN by the mean of the good values around it,
    negative ones by 0, infinite ones by the largest finite value, or 65504 where that is larger.
    Good values stay as they are, in the same pixel too, however bright.

    Raises:
        ValueError: one line on why the file cannot be a picture of light.
    """
    known = file.stat()
    return _read(file, known.st_mtime_ns, known.st_size)


@functools.lru_cache(maxsize=2)  # the exposure and the scene ask for the same
def _read(file: Path, _time: int, _size: int) -> Pixels:
    try:
        image = read_image(file)
    except ImageError as error:
        raise ValueError(f"cannot read environment {file}: {error}") from None
    pixels = image.linear_rgb()
    height, width = pixels.shape[:2]
    # Rows from pole to pole, both included, make pictures one row higher than half their width.
    if abs(width / height - 2) > ASPECT_TOLERANCE * 2 and abs(width - 2 * (height - 1)) > 1:
        nearest = min(_SHAPES, key=lambda shape: abs(shape - width / height))
        close = abs(nearest - width / height) < ASPECT_TOLERANCE * nearest
        looks = f" (it may be {_SHAPES[nearest]})" if close else ""
        raise ValueError(
            f"environment {file} has {width} x {height} pixels{looks}; needed is a picture in longitude "
            "and latitude, twice as wide as high"
        )
    pixels = repaired(pixels, f"environment {file}")
    if min(height, width) < 2:
        raise ValueError(f"environment {file} has {width} x {height} pixels; 4 x 2 are the least")
    if not pixels.max() >= np.finfo(np.float32).tiny:  # below it, renderers' sums vanish
        raise ValueError(f"environment {file} has no light in it")
    pixels.setflags(write=False)  # it is shared
    return pixels


def repaired(pixels: Pixels, name: str) -> Pixels:
    """The picture with its bad values replaced, as `read_light` says; `name` begins the notice."""
    infinite = np.isposinf(pixels)
    unknown = np.isnan(pixels) | np.isneginf(pixels)
    negative = np.isfinite(pixels) & (pixels < 0)
    bad = infinite | unknown | negative
    if not bad.any():
        return pixels
    good = np.where(bad, 0, pixels)
    largest = max(float(good.max()), HALF_MAX)
    result = np.where(infinite, np.float32(largest), good)
    if unknown.any():
        result = _filled(result, unknown)
    kinds = ((unknown, "not a number", "the mean around it"), (negative, "negative", "0"))
    parts = [
        f"{int(m.any(axis=2).sum())} {what} (now {now})"
        for m, what, now in (*kinds, (infinite, "infinite", f"{largest:g}"))
        if m.any()
    ]
    notice(f"{name} has bad pixels: {', '.join(parts)}.")
    return np.asarray(result, np.float32)


PATCH_RADIUS = (
    32  # pixels; further from all that is known, nothing says more than the picture's mean
)


def _filled(pixels: Pixels, unknown: NDArray[np.bool_]) -> Pixels:
    """Unknown values by the mean of the known ones next to them, from the rim of a patch inwards."""
    known = ~unknown
    values = np.where(known, pixels, 0).astype(np.float64)
    mean = values.sum(axis=(0, 1)) / np.maximum(known.sum(axis=(0, 1)), 1)
    for _ in range(PATCH_RADIUS):
        if known.all():
            break
        total, count = _around(values), _around(known.astype(np.float64))
        reached = ~known & (count > 0.5)
        values = np.where(reached, total / np.maximum(count, 1), values)
        known = known | reached
    return np.where(known, values, mean).astype(np.float32)


def _around(values: Floats) -> Floats:
    """Sum over the 3 x 3 pixels around each; a picture in longitude has no left and right end."""
    rows, columns = values.shape[:2]
    wide = np.pad(np.pad(values, ((0, 0), (1, 1), (0, 0)), "wrap"), ((1, 1), (0, 0), (0, 0)))
    return np.asarray(sum(wide[i : i + rows, j : j + columns] for i in range(3) for j in range(3)))


# --- what a picture of light says about exposure and ground ----------------------------------------


def irradiance_on(pixels: Pixels, normals: Floats) -> Floats:
    """Irradiance (N, 3) on surfaces with these normals, (N, 3), in the picture's own directions: +y is
    up, the middle of the picture is at +z, its right half at -x."""
    rows, columns = pixels.shape[:2]
    # Cosine-weighted light varies slowly, so blocks of a large picture are taken together.
    step = max(1, rows // 64)
    used = pixels[: rows // step * step, : columns // step * step].astype(np.float64)
    coarse = used.reshape(rows // step, step, columns // step, step, 3).mean(axis=(1, 3))
    theta = np.pi * (np.arange(len(coarse)) + 0.5) / len(coarse)
    phi = 2 * np.pi * (np.arange(coarse.shape[1]) + 0.5) / coarse.shape[1]
    sine = np.sin(theta)[:, None]
    towards = np.stack(
        np.broadcast_arrays(sine * np.sin(phi), np.cos(theta)[:, None], -sine * np.cos(phi)),
        axis=-1,
    )
    solid = (sine * (np.pi / len(coarse)) * (2 * np.pi / coarse.shape[1]))[..., None]
    cosine = np.maximum(towards.reshape(-1, 3) @ normals.T, 0)
    return np.asarray(cosine.T @ (coarse * solid).reshape(-1, 3))


def exposure(pixels: Pixels) -> float:
    """Stops that bring a white matte surface, turned to where most light comes from, to WHITE."""
    index = np.arange(256)
    y = 1 - 2 * (index + 0.5) / 256
    phi = index * np.pi * (3 - np.sqrt(5))  # evenly spread, by the golden angle
    r = np.sqrt(1 - y * y)
    normals = np.stack([r * np.cos(phi), y, r * np.sin(phi)], axis=-1)
    luminance = irradiance_on(pixels, normals) @ LUMINANCE
    return float(np.log2(WHITE * np.pi / luminance.max()))


WHITE = 0.9  # as gonio's own lights have it: just below the largest value of a picture


def ground_colour(pixels: Pixels, azimuth: float) -> tuple[float, float, float]:
    """Albedo of matte ground that looks like the picture does below the horizon, behind the object.

    azimuth: degrees by which the picture's middle is turned away from behind the object.
    """
    rows, columns = pixels.shape[:2]
    up = irradiance_on(pixels, np.array([[0.0, 1.0, 0.0]]))[0]
    low, high = (int(rows * (90 + angle) / 180) for angle in GROUND_BAND)
    middle = columns / 2 + azimuth / 360 * columns
    width = columns * GROUND_WIDTH / 360
    across = np.arange(int(middle - width), int(middle + width) + 1) % columns
    seen = pixels[low : max(high, low + 1)][:, across].astype(np.float64).mean(axis=(0, 1))
    albedo = np.clip(np.pi * seen / np.maximum(up, 1e-12), *GROUND_ALBEDO)
    return float(albedo[0]), float(albedo[1]), float(albedo[2])


# Degrees below the horizon, and to either side, of the part that stands behind an object.
GROUND_BAND = (4.0, 24.0)
GROUND_WIDTH = 20.0
GROUND_ALBEDO = (0.03, 0.85)  # darker catches no shadow, brighter is no ground
