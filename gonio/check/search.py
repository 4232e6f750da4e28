"""Finds worst cases: a search over the unit cube that remembers the best and looks nearer and nearer."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from gonio.check.subject import Array

# The best eighth of what was seen has offspring.
ELITE = 8

# A coordinate is cut into so many bands where each is to be looked at.
BANDS = 8


def maximise(
    objective: Callable[[Array], Array],
    dimensions: int,
    *,
    population: int,
    rounds: int,
    seed: int,
    starts: Array | None = None,
    special: Sequence[Array] = (),
    steps: tuple[float, float] = (0.25, 1e-6),
    bands: int | None = None,
) -> tuple[Array, Array]:
    """The highest values of a function of points in [0, 1]^dimensions, and where, best first.

    The first round is random, with many coordinates at the ends, where models break most often. In later
    ones each of the best gets offspring: some of its coordinates moved by steps that shrink from round to
    round, put to an end, or taken from another of the best.

    Args:
        objective: values (n,) for points (n, dimensions), in one batch.
        dimensions: of the cube.
        population: points in a round.
        rounds: how many.
        seed: of the random numbers.
        starts: points that the first round contains.
        special: for each of the first dimensions, values that are tried as they are and nearby.
        steps: the size of the first and of the last steps.
        bands: a coordinate: half of what is remembered are the best of each of its bands, so that a broad
            and nearly as high plain elsewhere does not drive out a narrow summit.
    """
    rng = np.random.default_rng(seed)
    points = _scattered(rng, population, dimensions)
    if starts is not None:
        points[: len(starts)] = starts[:population]
    if len(special):
        rest = slice(0 if starts is None else min(len(starts), population), None)
        points[rest] = specialised(rng, points[rest], special, 0.15)
    best_points, best_values = points[:0], np.zeros(0)
    for turn in range(rounds):
        values = np.asarray(objective(points), np.float64)
        # What is not a number is worse than every number.
        values = np.where(np.isnan(values), np.inf, values)
        best_points = np.concatenate([best_points, points])
        best_values = np.concatenate([best_values, values])
        order = _best(best_points, best_values, max(population // ELITE, 4), bands)
        best_points, best_values = best_points[order], best_values[order]
        if turn < rounds - 1:
            width = steps[0] * (steps[1] / steps[0]) ** (turn / max(rounds - 2, 1))
            points = _offspring(rng, best_points, population, width)
            if len(special):
                points[3::8] = specialised(rng, points[3::8], special, 0.3)
    return best_points, best_values


def _best(points: Array, values: Array, count: int, bands: int | None) -> NDArray[np.intp]:
    """Rows of the highest values, best first; with `bands` half of them, and the best of each band."""
    order = np.argsort(-values, kind="stable")
    if bands is None:
        return order[:count]
    band = np.minimum((BANDS * points[order, bands]).astype(np.intp), BANDS - 1)
    each = max(count // (2 * BANDS), 1)
    kept = np.zeros(len(order), bool)
    kept[: count // 2] = True
    for number in range(BANDS):
        kept[np.flatnonzero(band == number)[:each]] = True
    return order[kept]


def _scattered(rng: np.random.Generator, count: int, dimensions: int) -> Array:
    """Random points; in each of them a random part of the coordinates is at an end."""
    points = rng.random((count, dimensions))
    share = rng.random((count, 1)) * (np.arange(count)[:, None] % 2)
    at_end = rng.random(points.shape) < share
    return np.where(at_end, rng.integers(0, 2, points.shape), points)


def _offspring(rng: np.random.Generator, elite: Array, count: int, width: float) -> Array:
    n, dimensions = elite.shape
    # The best have more
    parents = (n * rng.random(count) ** 2).astype(np.intp)
    points = elite[parents]
    moved = rng.random(points.shape) < rng.choice([1.5 / max(dimensions, 1), 0.5, 1.0], (count, 1))
    steps = rng.standard_normal(points.shape)
    steps *= width * 10.0 ** -rng.integers(0, 3, (count, 1))
    np.add(points, steps, out=points, where=moved)
    # Every fourth: some coordinates from another of the best; every eighth: some to an end
    crossed, ended = points[1::4], points[2::8]
    other = elite[rng.integers(0, n, len(crossed))]
    np.copyto(crossed, other, where=rng.random(crossed.shape) < 0.5)
    few = rng.random(ended.shape) < 1.5 / max(dimensions, 1)
    np.copyto(ended, rng.integers(0, 2, ended.shape), where=few)
    return np.asarray(np.clip(points, 0, 1, out=points))


def specialised(
    rng: np.random.Generator, points: Array, special: Sequence[Array], share: float
) -> Array:
    """Points with a share of their coordinates at special values, or a tiny bit beside them."""
    count = min(points.shape[1], len(special))
    shape = (len(points), count)
    many = np.array([len(values) for values in special[:count]], np.intp)
    chosen = (rng.random(shape) < share) & (many > 0)
    beside = 10.0 ** rng.uniform(-14, -1.5, shape) * rng.choice([-1.0, 1.0], shape)
    place = (np.cumsum(many) - many) + (rng.random(shape) * many).astype(np.intp)
    value = np.concatenate([*special[:count], np.zeros(1)])[np.minimum(place, many.sum())]
    value = np.clip(value + np.where(rng.random(shape) < 0.5, beside, 0), 0, 1)
    found = points.copy()
    found[:, :count] = np.where(chosen, value, points[:, :count])
    return found
