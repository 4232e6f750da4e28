"""Mitsuba at work: passes of samples that add up to a picture."""

from __future__ import annotations

import itertools
import math
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gonio import backend
from gonio.messages import notice
from gonio.render import fireflies

Pixels = NDArray[np.float32]
Progress = Callable[[int, int], None]
"""Called with (samples done, samples in all) after every pass."""

# Samples of one pass: small enough to show progress and to answer an interrupt soon, large enough (4 M
# paths) to keep all cores busy. A picture of more pixels is made of bands.
PATHS_PER_PASS = 1 << 22

# Paths of a share, which is rendered in one place: ten seconds of a core for one picture to send.
PATHS_PER_SHARE = 1 << 23

# Linear sRGB of CIE XYZ, IEC 61966-2-1
XYZ_TO_RGB = np.array(
    [
        [3.2404542, -1.5371385, -0.4985314],
        [-0.9692660, 1.8760108, 0.0415560],
        [0.0556434, -0.2040259, 1.0572252],
    ]
)


# Samples of a pass whose spread says how noisy a picture is, and how many passes have to be there before
# their spread means anything.
NOISE_PASS, NOISE_PASSES = 16, 4

# A pixel's noise counts over its own brightness and a little more, as the eye has it: what is below this
# radiance looks black beside white.
NOISE_BLACK = 0.05


# Seconds between two looks whether a picture is there and whether Ctrl-C was pressed.
INTERRUPTIBLE = 0.05


class Noise:
    """How noisy the mean of equal passes is, from their spread."""

    def __init__(self, shape: tuple[int, ...]) -> None:
        """For pictures of a shape (height, width)."""
        self.passes = 0
        self.sum = np.zeros(shape, np.float64)
        self.squares = np.zeros(shape, np.float64)

    def add(self, pixels: Pixels) -> None:
        """Take another pass, shape (height, width, 3)."""
        luminance = pixels[..., :3].mean(axis=2)
        self.passes += 1
        self.sum += luminance
        self.squares += luminance * luminance

    def value(self) -> float:
        """Standard error of a pixel over its brightness, the mean of all pixels; inf at first."""
        if self.passes < NOISE_PASSES:
            return math.inf
        mean = self.sum / self.passes
        variance = np.maximum(self.squares / self.passes - mean * mean, 0) / (self.passes - 1)
        # Neighbours know the variance of a pixel better than its few passes do.
        spread = np.sqrt(_smoothed(variance)) / (np.abs(mean) + NOISE_BLACK)
        return float(spread.mean())


def _smoothed(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Means over 3 by 3 pixels."""
    padded = np.pad(values, 1, mode="edge")
    height, width = values.shape
    parts = [padded[y : y + height, x : x + width] for y in range(3) for x in range(3)]
    return np.asarray(np.mean(parts, axis=0))


def integrate(
    loaded: Any,
    spp: int,
    seed: int,
    progress: Progress | None,
    *,
    alpha: bool = False,
    noise: float | None = None,
    seconds: float | None = None,
    clamp: float | None = None,
) -> Pixels:
    """The mean of several passes, so that long work shows progress and can be interrupted.

    Args:
        loaded: the scene; its first sensor is rendered.
        spp: samples per pixel; with `noise` or `seconds` the most that are taken.
        seed: of the random numbers.
        progress: called after each pass.
        noise: stop when the picture's noise (see `Noise`) is at most this, such as 0.02; a notice says
            what it is where samples or time end before.
        seconds: begin no further pass after that time.
        alpha: keep the film's alpha as a fourth channel.
        clamp: cut samples of indirect light above this radiance, of a scene with the integrator `path`; a
            notice says how much light that took.

    Returns:
        Linear RGB, (height, width, 3), whatever the film's format is.

    Raises:
        ValueError: no samples, a goal that is not above 0, or a film whose channels are no colours.
    """
    if spp < 1:
        raise ValueError(f"spp={spp} is out of range; allowed is at least 1.")
    for name, goal in (("noise", noise), ("seconds", seconds)):
        if goal is not None and not 0 < goal < math.inf:
            raise ValueError(f"{name}={goal} is out of range; allowed is a finite number above 0.")
    width, height = (int(n) for n in loaded.sensors()[0].film().crop_size())
    integrator = loaded.integrator()
    if clamp is not None:
        integrator = fireflies.cut(integrator, clamp)
    judged = noise is not None or seconds is not None
    rounds = shares((width, height), spp, NOISE_PASS if judged else spp)
    found = Noise((height, width)) if judged else None
    start = time.monotonic()
    total: Any = None
    taken = done = 0
    missed = False
    for of_round in rounds:
        pixels: Any = None
        for share in of_round:

            def step(count: int, rows: int = share.rows) -> None:
                nonlocal done
                done += count * rows
                if progress is not None:
                    progress(min(done // height, spp), spp)

            part = render_share(
                loaded, share, seed, alpha=alpha, progress=step, integrator=integrator
            )
            if pixels is None:
                pixels = np.zeros((height, width, part.shape[2]), np.float32)
            pixels[share.top : share.top + share.rows] += part
        total = pixels if total is None else total + pixels
        wanted = of_round[-1].spp_before + of_round[-1].spp
        if found is not None:
            found.add(pixels / (wanted - taken))
        taken = wanted
        missed = noise is not None and found is not None and found.value() > noise
        if noise is not None and not missed:
            break
        if seconds is not None and time.monotonic() - start >= seconds:
            break
    if progress is not None and judged:
        progress(spp, spp)  # also where the goal was reached before
    if missed and noise is not None and found is not None:
        value = found.value()
        reached = f"is {100 * value:.2g} %" if math.isfinite(value) else "is not known"
        notice(
            f"the noise {reached} after {taken} sample{'s' * (taken > 1)} per pixel; the goal of "
            f"{100 * noise:.2g} % takes more samples or time."
        )
    if clamp is not None:
        notice(
            f"clamp: samples of indirect light brighter than {clamp:.3g} were cut, which took "
            f"{100 * fireflies.lost(integrator):.2g} % of the picture's light."
        )
    return np.asarray(total / np.float32(taken))


@dataclass(frozen=True)
class Share:
    """Some of the samples of some of a picture's rows: what one machine renders of it at a time."""

    top: int
    rows: int
    passes: tuple[tuple[int, int], ...]
    """Number, which decides the random numbers, and samples per pixel of each."""
    spp_before: int
    """Samples per pixel of the same rows in earlier shares."""

    @property
    def spp(self) -> int:
        """Samples per pixel."""
        return sum(count for _, count in self.passes)


def shares(size: tuple[int, int], spp: int, wanted: int | None = None) -> list[list[Share]]:
    """How a picture is cut, in rounds of `wanted` samples for all of it; all in one by default.

    It depends on nothing but the picture's size and samples, so that the sum of all shares, in this order,
    is the same whoever rendered them.
    """
    width, height = size
    bands = _bands(width, height)
    limit = max(1, PATHS_PER_PASS // max(width * max(rows for _, rows in bands), 1))
    wanted = wanted or spp
    rounds = []
    number = 0
    for n in range(max(1, -(-spp // wanted))):
        found: list[Share] = []
        for top, rows in bands:
            room, group, before = 0, [], n * wanted
            for count in _passes(wanted, limit):
                group.append((number, count))
                number += 1
                room += count * rows * width
                if room >= PATHS_PER_SHARE:
                    found.append(Share(top, rows, tuple(group), before))
                    before += found[-1].spp
                    room, group = 0, []
            if group:
                found.append(Share(top, rows, tuple(group), before))
        rounds.append(found)
    return rounds


def render_share(
    loaded: Any,
    share: Share,
    seed: int,
    *,
    alpha: bool = False,
    progress: Callable[[int], None] | None = None,
    integrator: Any = None,
) -> Pixels:
    """The sum of a share's samples, linear RGB (rows, width, 3), times its samples per pixel.

    Args:
        loaded: the scene.
        share: what to render of it.
        seed: of the random numbers.
        alpha: keep the film's alpha as a fourth channel.
        progress: called after each pass with its samples per pixel.
        integrator: the scene's own by default.
    """
    import mitsuba as mi

    sensor = loaded.sensors()[0]
    total: Any = None
    with _Cropped(sensor) as cropped:
        if share.rows < int(sensor.film().crop_size()[1]):
            cropped.show(share.top, share.rows)
        for number, count in share.passes:
            # Mitsuba derives a pass's random numbers from its seed; far-apart seeds never overlap.
            picture = mi.render(
                loaded, integrator=integrator, spp=count, seed=seed * 65536 + number
            )
            pixels = _numbers(picture) * np.float32(count)
            total = pixels if total is None else total + pixels
            if progress is not None:
                progress(count)
        return _colours(total, sensor.film(), alpha)


def _numbers(picture: Any) -> Pixels:
    """A picture's numbers when they are there.

    Mitsuba renders while they are waited for, and Python would raise KeyboardInterrupt only afterwards:
    another thread waits, so that this one can be interrupted. What is rendered then ends by itself.
    """
    found: list[Pixels | BaseException] = []

    def wait() -> None:
        try:
            found.append(np.array(picture, dtype=np.float32))
        except BaseException as error:  # raised below, where somebody sees it
            found.append(error)

    thread = threading.Thread(target=wait)
    thread.start()
    while thread.is_alive():
        thread.join(INTERRUPTIBLE)
    if isinstance(found[0], BaseException):
        raise found[0]
    return found[0]


def _bands(width: int, height: int) -> list[tuple[int, int]]:
    """First row and number of rows of the parts of a picture, each of at most PATHS_PER_PASS pixels."""
    count = min(height, -(-width * height // PATHS_PER_PASS))
    edges = [height * k // count for k in range(count + 1)]
    return [(top, bottom - top) for top, bottom in itertools.pairwise(edges)]


class _Cropped:
    """A sensor whose film shows some of its rows at a time, and all that it did at the end."""

    def __init__(self, sensor: Any) -> None:
        self.sensor = sensor

    def __enter__(self) -> _Cropped:
        film = self.sensor.film()
        self.offset, self.size = film.crop_offset(), film.crop_size()
        self.changed = False
        return self

    def show(self, top: int, rows: int) -> None:
        self._set([self.offset[0], self.offset[1] + top], [self.size[0], rows])
        self.changed = True

    def __exit__(self, *_: Any) -> None:
        if self.changed:
            self._set(self.offset, self.size)

    def _set(self, offset: Any, size: Any) -> None:
        import mitsuba as mi

        film = mi.traverse(self.sensor)
        film["film.crop_offset"], film["film.crop_size"] = (
            mi.ScalarPoint2u(offset),
            mi.ScalarPoint2u(size),
        )
        film.update()


def _colours(pixels: Pixels, film: Any, alpha: bool) -> Pixels:
    """Linear RGB of what a film holds."""
    import mitsuba as mi

    formats = mi.Bitmap.PixelFormat
    bitmap = film.bitmap()
    kind, names = bitmap.pixel_format(), [channel.name for channel in bitmap.struct_()]
    if kind in (formats.Y, formats.YA):
        colours = np.repeat(pixels[..., :1], 3, axis=2)
    elif kind in (formats.XYZ, formats.XYZA):
        colours = (pixels[..., :3] @ XYZ_TO_RGB.T).astype(np.float32)
    elif kind in (formats.RGB, formats.RGBA) or names[:3] == ["R", "G", "B"]:
        colours = pixels[..., :3]
    else:
        raise ValueError(
            f"the film holds the channels {', '.join(names)}, which are no colours; use an hdrfilm."
        )
    if alpha and kind in (formats.YA, formats.XYZA, formats.RGBA):
        colours = np.concatenate([colours, pixels[..., -1:]], axis=2)
    return np.ascontiguousarray(colours)


# A stratified sampler wants square numbers of samples, and rounds others up with a warning.
SQUARES = (64, 36, 16, 4, 1)


def _passes(spp: int, limit: int) -> Iterator[int]:
    """Square numbers of samples, at most `limit` each, that add up to `spp`."""
    while spp > 0:
        count = next(n for n in SQUARES if n <= min(spp, limit))
        yield count
        spp -= count


def ready_mitsuba() -> Any:
    """Mitsuba with a variant that fits the backend in force, unless the user chose one."""
    import mitsuba as mi

    if mi.variant() is None:
        mi.set_variant(backend.mitsuba_variant())
    import gonio.mitsuba

    gonio.mitsuba.register()
    return mi
