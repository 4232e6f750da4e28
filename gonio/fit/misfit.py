"""What a fit misses: how much of it is noise, and where the rest is.

The noise is what repeated directions differ by (the pure error of a lack-of-fit test: Fisher 1922; Draper,
Smith, "Applied Regression Analysis", 1998, section 2.1), or else what residuals differ by from a plane
through those at neighbouring directions: what the model misses is alike there, noise is not.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gonio.fit.metrics import Metric
from gonio.fit.problem import Floats, Problem, unit, usable
from gonio.measured import Measurement
from gonio.measured.frames import half_difference
from gonio.measured.interpolation import coordinates
from gonio.measured.spectra import to_rgb

# Directions that noise is estimated at, and neighbours of each in three and four dimensions.
ANCHORS, NEIGHBOURS = 1500, {3: 10, 4: 14}

# Directions that neighbours are looked for among: parts of the whole where there are more.
POOL, CELLS = 200_000, 14

# Repeated directions less their places that tell the noise by themselves, and how exactly they repeat.
REPEATS, SAME = 30, 1e-5

# Bounds of the map's cells in degrees.
THETA_H = (0, 1, 2.5, 5, 10, 20, 30, 45, 60, 90)
THETA_D = (0, 10, 20, 30, 40, 50, 60, 70, 80, 90)

# Misfit below this part of the data is rounding of single precision: nothing fails then.
EXACT = 1e-4

# A region fails if its directions miss this many times as much as the mean, and this share of all.
FAILS, SHARE = 1.5, 0.1

# Of the misfit: what a model misses beyond the noise has places only above. Below, it is less than a
# tenth of the squares, and places are where the noise is large.
OWN = 0.3


@dataclass(frozen=True)
class Noise:
    """Root mean squares in the fit's metric."""

    size: float
    """Of the noise."""
    model: float
    """Of what the model misses beyond it."""
    by: str
    """How it was found: "repeats" or "neighbours"."""


@dataclass(frozen=True)
class Region:
    """Some directions, and what the model misses there."""

    name: str
    theta_h: tuple[float, float]
    """Bounds in degrees."""
    theta_d: tuple[float, float]
    directions: int
    share: float
    """Of the sum of squares."""
    times: float
    """Mean square over that of all directions."""
    ratio: float
    """Light of the model over that of the data."""

    def sentence(self) -> str:
        """In words."""
        if abs(self.ratio - 1) < 0.02 or not np.isfinite(self.ratio):
            what = "right on average, but not in shape"
        elif self.ratio > 2:
            what = f"{self.ratio:.3g} times too bright"
        else:
            what = f"{abs(self.ratio - 1):.0%} too {'bright' if self.ratio > 1 else 'dark'}"
        return (
            f"{self.name} (theta_h {self.theta_h[0]:g} to {self.theta_h[1]:g}°, theta_d "
            f"{self.theta_d[0]:g} to {self.theta_d[1]:g}°): {what}; {self.share:.0%} of the misfit"
        )


@dataclass(frozen=True)
class Map:
    """Residuals in cells of theta_h and theta_d; (theta_h, theta_d) each, NaN where there is no data."""

    rms: Floats
    """Root mean square in the fit's metric."""
    ratio: Floats
    """Light of the model over that of the data."""
    directions: NDArray[np.intp]


def noise(
    data: Measurement, problem: Problem, metric: Metric, x: Floats, rms: float, seed: int
) -> Noise | None:
    """How much of the misfit is noise; None where there are too few directions to tell."""
    place = usable(data)
    wi, wo = unit(data.wi[place]), unit(data.wo[place])
    where = coordinates(wi, wo, data.isotropic)
    # A value that repeats to the last bit was written twice, not measured twice
    exact = np.ascontiguousarray(data.values[place]).view(np.uint32)
    first = np.unique(_mixed(np.round(where / SAME)) + 3 * _mixed(exact), return_index=True)[1]
    place, wi, wo, where = place[first], wi[first], wo[first], where[first]
    group = _mixed(np.round(np.concatenate([wi, wo], -1) / SAME))
    different, group = np.unique(group, return_inverse=True)
    if len(group) - len(different) >= REPEATS:
        few = np.flatnonzero(np.bincount(group)[group] > 1)
        few = few[np.isin(group[few], np.unique(group[few])[:ANCHORS])]
        r = _residuals(data, place[few], wi[few], wo[few], problem, metric, x)
        size = _by_repeats(r, group[few])
        by = "repeats"
    else:
        random = np.random.default_rng(seed + 3)
        chosen, anchors = _pool(where, random)
        where = where[chosen]
        count = NEIGHBOURS[where.shape[1]]
        if len(where) < 4 * count:
            return None
        index, share = _planes(where, anchors, count)
        used, back = np.unique(index, return_inverse=True)
        some = chosen[used]
        r = _residuals(data, place[some], wi[some], wo[some], problem, metric, x)
        r = r[back.reshape(index.shape)]
        square = (r[:, 0] - np.einsum("nk,nkc->nc", share, r[:, 1:])) ** 2
        size = float(np.sqrt((square / (1 + (share**2).sum(-1))[:, None]).mean()))
        by = "neighbours"
    size = min(size, rms)
    return Noise(size, float(np.sqrt(rms**2 - size**2)), by)


def _mixed(numbers: NDArray[Any]) -> NDArray[np.int64]:
    """One number (n,) for each row (n, k): different ones differ, but for accidents."""
    whole = numbers.astype(np.int64)
    odd = np.random.default_rng(0).integers(1 << 62, size=whole.shape[1]) | 1
    return np.asarray(whole @ odd)


def _by_repeats(r: Floats, group: NDArray[np.intp]) -> float:
    """Standard deviation within groups."""
    index = np.unique(group, return_inverse=True)[1]
    counts = np.bincount(index)
    mean = np.stack([np.bincount(index, r[:, c]) for c in range(3)], -1) / counts[:, None]
    return float(np.sqrt(((r - mean[index]) ** 2).sum() / (3 * (counts - 1).sum())))


def _planes(
    where: Floats, anchors: NDArray[np.intp], count: int
) -> tuple[NDArray[np.intp], Floats]:
    """Each anchor and its neighbours (n, 1 + count), and the shares (n, count) of a plane through these."""
    from scipy.spatial import cKDTree

    tree = cKDTree(where, balanced_tree=False, compact_nodes=False)
    index = tree.query(where[anchors], count + 1)[1]
    own = index == anchors[:, None]
    own[~own.any(-1), -1] = True
    around = index[~own].reshape(len(anchors), count)
    offset = where[around] - where[anchors][:, None]
    offset = offset / np.maximum(np.abs(offset).max((1, 2), keepdims=True), 1e-12)
    design = np.concatenate([np.ones((*offset.shape[:2], 1)), offset], -1)
    share = np.linalg.pinv(design, rcond=1e-3)[:, 0]
    return np.concatenate([anchors[:, None], around], -1), share


def _residuals(
    data: Measurement,
    place: NDArray[np.intp],
    wi: Floats,
    wo: Floats,
    problem: Problem,
    metric: Metric,
    x: Floats,
) -> Floats:
    """In the metric, without weights, (n, 3)."""
    f = problem.at(wi, wo).evaluate(x) * wi[:, 2:]
    values = to_rgb(data, data.values[place])[0] * wi[:, 2:]
    return np.asarray(metric.value(f) - metric.value(values))


def _pool(where: Floats, random: np.random.Generator) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Directions to look for neighbours among, and which of these are looked at."""
    chosen = np.arange(len(where))
    if len(where) > POOL:
        cell = np.floor((where - where.min(0)) * CELLS).astype(np.int64)
        cells, index = np.unique(_mixed(cell), return_inverse=True)
        order = random.permutation(len(cells))
        filled = np.cumsum(np.bincount(index)[order])
        use = np.zeros(len(cells), bool)
        use[order[: max(1, int(np.searchsorted(filled, POOL)))]] = True
        chosen = np.flatnonzero(use[index])
    return chosen, np.sort(random.permutation(len(chosen))[:ANCHORS])


def residual_map(problem: Problem, metric: Metric, x: Floats) -> Map:
    """Where the model misses how much."""
    f, r = _both(problem, metric, x)
    theta_h, theta_d = _angles(problem)
    row = np.clip(np.searchsorted(THETA_H, theta_h, "right") - 1, 0, len(THETA_H) - 2)
    column = np.clip(np.searchsorted(THETA_D, theta_d, "right") - 1, 0, len(THETA_D) - 2)
    shape = (len(THETA_H) - 1, len(THETA_D) - 1)
    cell = np.ravel_multi_index((row, column), shape)

    def sums(values: Floats) -> Floats:
        return np.asarray(np.bincount(cell, values, int(np.prod(shape))), float).reshape(shape)

    count = np.bincount(cell, minlength=int(np.prod(shape))).reshape(shape)
    with np.errstate(invalid="ignore", divide="ignore"):
        rms = np.sqrt(sums((r**2).mean(-1)) / count)
        ratio = sums(f.sum(-1)) / sums((problem.values * problem.cosines).sum(-1))
    return Map(np.where(count > 0, rms, np.nan), np.where(count > 0, ratio, np.nan), count)


def regions(
    problem: Problem, metric: Metric, x: Floats, relative: float, noise: Noise | None
) -> tuple[Region, ...]:
    """Where the model fails, the largest share first.

    Empty where it fits, where what it misses is noise, or where it misses alike everywhere.
    """
    if relative < EXACT:
        return ()
    if noise is not None and noise.model < OWN * np.hypot(noise.model, noise.size):
        return ()
    f, r = _both(problem, metric, x)
    theta_h, theta_d = _angles(problem)
    square = (r**2).sum(-1)
    found = [
        region
        for region in _named(f, problem.values * problem.cosines, theta_h, theta_d, square)
        if region.times >= FAILS and region.share >= SHARE
    ]
    return tuple(sorted(found, key=lambda region: -region.share))


# Name, bounds of theta_h, and of theta_d, in degrees. Together they are all directions.
REGIONS = (
    ("the highlight's core", (0, 5), (0, 65)),
    ("the highlight's flank", (5, 25), (0, 65)),
    ("back towards the light", (25, 90), (0, 10)),
    ("away from the highlight", (25, 90), (10, 65)),
    ("grazing light at the mirror direction", (0, 10), (65, 90)),
    ("grazing light elsewhere", (10, 90), (65, 90)),
)


def _named(
    f: Floats, values: Floats, theta_h: Floats, theta_d: Floats, square: Floats
) -> Iterator[Region]:
    for name, h, d in REGIONS:
        inside = (theta_h >= h[0]) & (theta_h < h[1]) & (theta_d >= d[0]) & (theta_d < d[1])
        if not inside.any():
            continue
        light = float(values[inside].sum())
        yield Region(
            name,
            (float(h[0]), float(h[1])),
            (float(d[0]), float(d[1])),
            int(inside.sum()),
            float(square[inside].sum() / max(square.sum(), 1e-300)),
            float(square[inside].mean() / max(square.mean(), 1e-300)),
            float(f[inside].sum()) / light if light > 0 else float("inf"),
        )


def _both(problem: Problem, metric: Metric, x: Floats) -> tuple[Floats, Floats]:
    """f cos of the model (n, 3), and weighted residuals."""
    f = problem.evaluate(x) * problem.cosines
    r = metric.value(f) - metric.value(problem.values * problem.cosines)
    return f, np.asarray(r * np.sqrt(problem.weights)[:, None])


def _angles(problem: Problem) -> tuple[Floats, Floats]:
    theta_h, _, theta_d, _ = half_difference(problem.wi, problem.wo)
    return np.degrees(theta_h), np.degrees(theta_d)


__all__ = ["THETA_D", "THETA_H", "Map", "Noise", "Region", "noise", "regions", "residual_map"]
