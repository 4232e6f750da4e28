"""How far the data determine the numbers: a bootstrap over blocks of directions.

What a model misses is no noise: it is alike at neighbouring directions, and standard errors from single
residuals are too small by orders of magnitude. So whole blocks of directions are drawn with replacement
(Künsch, "The jackknife and the bootstrap for general stationary observations", Annals of Statistics 17,
1989), and each draw takes one step of Gauss and Newton from the fit (Davidson, MacKinnon, "Bootstrap
testing in nonlinear models", International Economic Review 40, 1999), which needs sums over blocks only.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gonio.fit.descent import bounded_step
from gonio.fit.metrics import Metric
from gonio.fit.problem import Floats, Problem
from gonio.fit.structure import Structure
from gonio.measured.interpolation import coordinates

# Halvings into blocks, and the directions that a block has at least.
HALVINGS, LEAST = 6, 4

# Draws, and the part of them that an interval holds.
DRAWS, LEVEL = 800, 0.95

# A number whose change by its whole range moves the values by less than this part of all that the data
# determine says nothing about them.
UNDETERMINED = 1e-4

# An interval that covers more of a range than this does not determine the number either.
WIDE = 0.5


@dataclass(frozen=True)
class Certainty:
    """What the data say about the free numbers."""

    intervals: dict[str, tuple[float, float]]
    """By name, without those that have no effect."""
    undetermined: tuple[str, ...]
    """Names of those that have none, alone or together, or whose interval is most of their range."""
    blocks: int


def blocks(wi: Floats, wo: Floats, isotropic: bool) -> NDArray[np.intp]:
    """The block (n,) of each pair of directions: equally many in each, near each other."""
    places = coordinates(wi, wo, isotropic)
    places = places / np.maximum(np.ptp(places, axis=0), 1e-9)
    found = np.zeros(len(places), np.intp)
    halvings = min(HALVINGS, int(np.log2(max(len(places) / LEAST, 1))))
    for _ in range(halvings):
        upper = np.zeros(len(places), np.intp)
        for block in np.unique(found):
            inside = np.flatnonzero(found == block)
            widest = int(np.argmax(np.ptp(places[inside], axis=0)))
            order = inside[np.argsort(places[inside, widest], kind="stable")]
            upper[order[len(order) // 2 :]] = 1
        found = 2 * found + upper
    return found


def certainty(
    problem: Problem,
    metric: Metric,
    structure: Structure,
    x: Floats,
    isotropic: bool,
    seed: int = 0,
) -> Certainty:
    """Intervals of the free numbers at a fit."""
    names = [c.name for c in problem.free]
    low, high = problem.bounds
    width = problem.width
    where = blocks(problem.wi, problem.wo, isotropic)
    count = int(where.max()) + 1
    H, g = _sums(problem, metric, structure, x, where, count)
    scaled = H.sum(0) * np.outer(width, width)
    sizes, axes = np.linalg.eigh(scaled)
    nothing = axes[:, sizes <= UNDETERMINED**2 * max(sizes[-1], 1e-300)]
    share = (nothing**2).sum(1)
    lost = share > 0.1
    keep = np.flatnonzero(~lost)
    if not keep.size or count <= keep.size:
        return Certainty({}, tuple(n for n, s in zip(names, lost, strict=True) if s), count)
    random = np.random.default_rng(seed + 2)
    draws = random.multinomial(count, np.full(count, 1 / count), DRAWS).astype(np.float64)
    inside = np.ix_(keep, keep)
    all_H, all_g = np.tensordot(draws, H, 1), draws @ g
    steps = np.empty((DRAWS, len(keep)))
    for n in range(DRAWS):
        steps[n] = bounded_step(all_H[n][inside], all_g[n][keep], (low - x)[keep], (high - x)[keep])
    # As many blocks as there are less the numbers, as variances have it
    steps *= np.sqrt(count / (count - len(keep)))
    tails = (0.5 * (1 - LEVEL), 0.5 * (1 + LEVEL))
    ends = np.clip(x[keep] + np.quantile(steps, tails, axis=0), low[keep], high[keep])
    intervals = {
        names[j]: (float(min(a, x[j])), float(max(b, x[j])))
        for j, a, b in zip(keep, *ends, strict=True)
    }
    wide = {
        names[j]
        for j in keep
        if np.isfinite(high[j] - low[j])
        and intervals[names[j]][1] - intervals[names[j]][0] > WIDE * width[j]
    }
    undetermined = (n for n, s in zip(names, lost, strict=True) if s or n in wide)
    return Certainty(intervals, tuple(undetermined), count)


def _sums(
    problem: Problem,
    metric: Metric,
    structure: Structure,
    x: Floats,
    where: NDArray[np.intp],
    count: int,
) -> tuple[Floats, Floats]:
    """JᵀJ (blocks, numbers, numbers) and Jᵀr (blocks, numbers)."""
    numbers = len(x)
    place = [
        next(g for g, group in enumerate(structure.groups) if j in group) for j in range(numbers)
    ]
    H, g = np.zeros((count, numbers, numbers)), np.zeros((count, numbers))
    for part, f, slopes in problem.parts(x, structure.groups):
        cosines, root = problem.cosines[part], np.sqrt(problem.weights[part])[:, None]
        f = f * cosines
        r = (metric.value(f) - metric.value(problem.values[part] * cosines)) * root
        factor = metric.slope(f) * cosines * root
        J = (slopes * factor)[place] * structure.alone[:, None, :]
        order = np.argsort(where[part], kind="stable")
        sorted_ = where[part][order]
        J, r = J[:, order], r[order]
        ends = np.searchsorted(sorted_, np.arange(count + 1))
        for block in np.unique(sorted_):
            rows = slice(ends[block], ends[block + 1])
            flat = J[:, rows].reshape(numbers, -1)
            H[block] += flat @ flat.T
            g[block] += flat @ r[rows].ravel()
    return H, g


__all__ = ["LEVEL", "Certainty", "blocks", "certainty"]
