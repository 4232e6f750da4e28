"""How good a measurement is: what it covers, its noise, and whether it can be reflection at all."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gonio.measured.frames import Floats, angles, half_difference, spherical
from gonio.measured.interpolation import NEIGHBOURS, Scattered, local_plane, projections
from gonio.measured.measurement import Measurement

# Points that noise and reciprocity are estimated from; more change the second digit only.
SOME = 4000

# Nodes of the albedos' integrals: angles and azimuths of the half vector. Midpoints of MERL's own steps.
NODES = (90, 72)

# Angles of the viewer that albedos are integrated for, in degrees.
ALBEDO_ANGLES = (0, 10, 20, 30, 40, 50, 60, 70, 75, 80, 85)

# Azimuths of the viewer that anisotropic samples are looked at from.
AZIMUTHS = 8

# Places of a hemisphere that coverage is counted in, for angles of the viewer up to the second number.
COVERAGE, GRAZING = 2000, np.radians(85)


@dataclass(frozen=True)
class Spread:
    """A relative departure: in the middle of all places, and at nineteen of twenty at most."""

    median: float
    high: float
    count: int
    """Places that it was found at; 0 if there was none to look at."""

    @staticmethod
    def of(values: Floats) -> Spread:
        """Of departures (n,)."""
        if len(values) == 0:
            return Spread(float("nan"), float("nan"), 0)
        return Spread(float(np.median(values)), float(np.percentile(values, 95)), len(values))


@dataclass(frozen=True)
class Albedo:
    """A directional albedo, integrated over a measurement: the largest channel."""

    theta: float
    """Angle of the viewer in degrees."""
    phi: float
    """Its azimuth in degrees."""
    measured: float
    """What the measured directions add up to."""
    all: float
    """With what is interpolated or continued beyond them."""


@dataclass(frozen=True)
class Quality:
    """Numbers about a measurement. Extrapolated values count only where that is said."""

    places: int
    """Numbers per channel in the file."""
    used: int
    """Of these, with a value and above the horizon."""
    holes: int
    """Above the horizon, without a value."""
    extrapolated: int
    theta_i: tuple[float, float]
    """Smallest and largest angle of the light, in degrees."""
    theta_o: tuple[float, float]
    incidences: int
    """Different directions of the light, as the file has them."""
    from_mirror: float
    """Smallest angle between a half vector and the normal, in degrees."""
    covered: float
    """Share of all pairs of directions up to 85° that a measured value is near to."""
    lowest: float
    largest: float
    brightest: tuple[float, float, float]
    """Of the largest value: theta_i, theta_o and the azimuth between them, in degrees."""
    negative: int
    """Measured values below 0."""
    negative_extrapolated: int
    noise: Spread
    """Departure of values from those around them, which interpolation adds to."""
    reciprocity: Spread
    """|f(wi, wo) - f(wo, wi)| over their mean, where both were measured."""
    symmetry: Spread
    """The same for the mirror image at the plane of incidence; of anisotropic samples, for turns."""
    albedos: tuple[Albedo, ...]

    @property
    def brightest_albedo(self) -> Albedo | None:
        """The largest albedo of what was measured."""
        return max(self.albedos, key=lambda a: a.measured, default=None)


def quality(measured: Measurement) -> Quality:
    """Look at a measurement from all sides; a few seconds for a large one."""
    use = measured.valid
    beyond = np.zeros(len(use), bool) if measured.extrapolated is None else measured.extrapolated
    real = use & ~beyond
    real = real if real.any() else use
    wi, wo = measured.wi[real].astype(np.float64), measured.wo[real].astype(np.float64)
    values = measured.values[real].astype(np.float64)
    above = measured.wi[:, 2] > 1e-6
    above &= (measured.wo[:, 2] < -1e-6) if measured.transmission else (measured.wo[:, 2] > 1e-6)
    theta_i, theta_o = np.degrees(angles(wi)[0]), np.degrees(angles(wo)[0])
    if measured.transmission:
        theta_o = 180 - theta_o
    peak = int(np.argmax(values.max(-1)))
    apart = np.degrees(angles(wo[peak])[1] - angles(wi[peak])[1]) % 360
    few = np.random.default_rng(11).permutation(len(wi))[:SOME]
    through = measured.transmission
    return Quality(
        places=len(use),
        used=int(use.sum()),
        holes=int((above & ~use).sum()),
        extrapolated=int((use & beyond).sum()),
        theta_i=(float(theta_i.min()), float(theta_i.max())),
        theta_o=(float(theta_o.min()), float(theta_o.max())),
        incidences=len(np.unique(np.round(wi, 4), axis=0)),
        from_mirror=float("nan")
        if through
        else float(np.degrees(half_difference(wi, wo)[0].min())),
        covered=float("nan") if through else _covered(measured),
        lowest=float(values.min()),
        largest=float(values.max()),
        brightest=(float(theta_i[peak]), float(theta_o[peak]), float(min(apart, 360 - apart))),
        negative=int((values < 0).any(-1).sum()),
        negative_extrapolated=int((measured.values[use & beyond] < 0).any(-1).sum()),
        noise=_noise(wi, wo, values, measured.isotropic, few),
        reciprocity=Spread.of(np.zeros(0)) if through else _swapped(measured, wi[few], wo[few]),
        symmetry=Spread.of(np.zeros(0)) if through else _turned(measured, wi[few], wo[few]),
        albedos=() if through else tuple(_albedos(measured)),
    )


def _covered(measured: Measurement) -> float:
    random = np.random.default_rng(5)
    mu = random.uniform(np.cos(GRAZING), 1, (2, COVERAGE))
    phi = random.uniform(0, 2 * np.pi, (2, COVERAGE))
    wi, wo = (spherical(np.arccos(m), p) for m, p in zip(mu, phi, strict=True))
    return float(measured.interpolate(wi, wo)[1].mean())


def _noise(wi: Floats, wo: Floats, values: Floats, isotropic: bool, few: NDArray[Any]) -> Spread:
    """Each value against the plane through those around it; what is curved counts as noise."""
    from scipy.spatial import cKDTree

    if len(wi) < 4 * NEIGHBOURS:
        return Spread.of(np.zeros(0))
    # Not what interpolation uses: swapped directions are no neighbours, their differences are not noise
    places = projections(wi, wo, isotropic)
    grey = values.mean(-1)
    distance, index = cKDTree(places).query(places[few], NEIGHBOURS)
    # Without the value itself, which need not come first: mirror images have the same place
    own = index == few[:, None]
    own[~own.any(-1), -1] = True
    around = index[~own].reshape(len(few), -1)
    distance = distance[~own].reshape(len(few), -1)
    expected = local_plane(places[around] - places[few][:, None], distance, grey[around, None])
    expected = expected[:, 0]
    scale = np.maximum(np.abs(grey[index]).mean(-1), 1e-12)
    return Spread.of(np.abs(grey[few] - expected) / scale)


def _interpolated(measured: Measurement) -> bool:
    """Whether values at other directions are made of loose points."""
    return measured.interpolator is None or isinstance(measured.interpolator, Scattered)


def _swapped(measured: Measurement, wi: Floats, wo: Floats) -> Spread:
    # The interpolation of loose points makes them reciprocal; only points near swapped ones would tell
    if _interpolated(measured):
        return Spread.of(np.zeros(0))
    a, known_a = measured.interpolate(wi, wo)
    b, known_b = measured.interpolate(wo, wi)
    return _difference(a, b, known_a & known_b)


def _turned(measured: Measurement, wi: Floats, wo: Floats) -> Spread:
    if measured.isotropic:
        mirror = np.array([1.0, -1.0, 1.0])
        if _interpolated(measured) or "phi" in measured.grid:  # the format has one side only
            return Spread.of(np.zeros(0))
        a, known_a = measured.interpolate(wi, wo)
        b, known_b = measured.interpolate(wi * mirror, wo * mirror)
        return _difference(a, b, known_a & known_b)
    c, s = np.cos(1.0), np.sin(1.0)
    about = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    a, known_a = measured.interpolate(wi, wo)
    b, known_b = measured.interpolate(wi @ about, wo @ about)
    return _difference(a, b, known_a & known_b)


def _difference(a: Floats, b: Floats, known: NDArray[Any]) -> Spread:
    a, b = a[known].mean(-1), b[known].mean(-1)
    return Spread.of(np.abs(a - b) / np.maximum(0.5 * (np.abs(a) + np.abs(b)), 1e-9))


def _albedos(measured: Measurement) -> list[Albedo]:
    wi_of, weight = _half_vectors()
    found = []
    turns = [0.0] if measured.isotropic else list(2 * np.pi * np.arange(AZIMUTHS) / AZIMUTHS)
    for theta in ALBEDO_ANGLES:
        for phi in turns:
            wo = spherical(np.radians(theta), phi)
            wi = 2 * (wi_of @ wo)[:, None] * wi_of - wo
            up = wi[:, 2] > 1e-6
            values, known = measured.interpolate(wi[up], np.broadcast_to(wo, wi[up].shape))
            # dwi = 4 (wo . m) dm
            solid = (4 * (wi_of @ wo) * weight)[up] * wi[up, 2]
            total = (values * solid[:, None]).sum(0)
            certain = (values * (solid * known)[:, None]).sum(0)
            found.append(
                Albedo(
                    float(theta), float(np.degrees(phi)), float(certain.max()), float(total.max())
                )
            )
    return found


def _half_vectors() -> tuple[Floats, Floats]:
    """Half vectors (n, 3), crowded at the normal, and the solid angle of each."""
    n, turns = NODES
    u = (np.arange(n) + 0.5) / n
    theta = 0.5 * np.pi * u**2
    edges = 0.5 * np.pi * (np.arange(n + 1) / n) ** 2
    solid = (np.cos(edges[:-1]) - np.cos(edges[1:])) * 2 * np.pi / turns
    phi = 2 * np.pi * (np.arange(turns) + 0.5) / turns
    return spherical(theta[:, None], phi).reshape(-1, 3), np.repeat(solid, turns)
