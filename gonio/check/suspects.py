"""Where a sampler is tested: the defaults, and settings that seem wrong when few samples are looked at."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from gonio.check import hemisphere
from gonio.check.adversarial import hard_parameters
from gonio.check.energy import dimensions, viewer
from gonio.check.hemisphere import PDF, UNREACHED
from gonio.check.kernels import evaluate
from gonio.check.product_rules import albedos
from gonio.check.report import Effort
from gonio.check.subject import Array, Subject, repeated

# Points of a screening that are merely random.
EVEN = 24

# The tolerance of the integrals; an error of 1e-5 is a tenth of the standard error of a test's counts.
INTEGRALS = 2e-5

# The tolerance of albedos that mean weights are compared with in a screening.
LOOSELY = 1e-3

# A density whose integral is off by this in a screening, beyond the error of the rule, is suspicious, and
# so are cells that hold so many times more or fewer of the samples than they should.
SUSPICIOUS, CROWDED = 2e-3, 0.5

# Samples of a screening, and the error of a mean of so many evenly spread ones (of a function like a step).
SCREEN_SAMPLES = hemisphere.FEWER_PROBES
QUASI = 4e-3


def screened_points(subject: Subject, count: int, seed: int) -> Array:
    """Rows of parameters over the whole range, coloured ones as well, with random viewers."""
    rng = np.random.default_rng(seed)
    extra = dimensions(subject) - len(subject.parameters)
    return np.concatenate(
        [hard_parameters(subject, count, seed + 1), rng.random((count, extra))], axis=1
    )


def _at_ends(subject: Subject, most: int, seed: int) -> Array:
    """Points with each number in turn, and each channel of a colour, exactly at each of its ends.

    The others are random: a lobe that is chosen by one number alone is never drawn there. Of more than
    `most` points those are random as well.
    """
    rng = np.random.default_rng(seed)
    count = len(subject.parameters)
    points = rng.random((2 * count, dimensions(subject)))
    number = np.arange(count)
    points[2 * number, number], points[2 * number + 1, number] = 0.0, 1.0
    return rng.permutation(points)[:most]


# Angles of wo at which default parameters are tested, as coordinates of a search.
ANGLES = ((0.4, 0.15), (0.2, 0.6))


@dataclass(frozen=True)
class Screened:
    """Points with few samples each: how suspicious they are (above 1), and what they never sample."""

    points: Array
    integral: Array
    """Of the density."""
    weight: Array
    """Its mean."""
    shape: Array
    unreached: Array
    """Albedo in directions that are never drawn."""
    different: Array
    """Largest relative difference between the reported density and that of `pdf`."""
    which: Array
    """The sample that has it."""
    below: Array
    """Samples below the horizon with a density."""


def screened(subject: Subject, effort: Effort) -> Screened:
    """Hard rows of parameters, some that are merely random, and those with one number at an end."""
    rng = np.random.default_rng(43)
    points = [
        screened_points(subject, effort.screened, 41),
        rng.random((EVEN, dimensions(subject))),
        _at_ends(subject, effort.screened, 46),
    ]
    return screen(subject, np.concatenate(points))


def suspects(subject: Subject, found: Screened, effort: Effort) -> Array:
    """The default parameters, those rows at which something seems to be wrong, and some in pure colours.

    What seems wrong is of as many kinds as there are: the integral of the density, the mean weight, and the
    shape, which a few samples tell from its like only where it is off by half.
    """
    count = effort.tests
    default = np.array([np.append(subject.default(), angles) for angles in ANGLES])
    kinds = [found.integral, found.weight, found.shape]
    chosen: list[int] = []
    order = [np.argsort(-kind) for kind in kinds]
    for rank in range(len(found.points)):
        for kind in order:
            if len(chosen) < max(count - 1, 1) and kind[rank] not in chosen:
                chosen.append(int(kind[rank]))
    # With a single test the default is only looked at if nothing else is suspicious
    alarming = max(float(kind[chosen[0]]) for kind in kinds) > 1
    if count == 1 and not alarming:
        return default[:1]
    pure = _pure(subject)[: count - 1]
    return np.concatenate([default[: count - len(chosen)], found.points[chosen], pure])


def _pure(subject: Subject) -> Array:
    """Default parameters with every colour in one channel alone, each in the next one; two such points.

    Lobes that are chosen by one mean of the channels and weighed by another are grey all the same.
    """
    point = np.append(subject.default(), ANGLES[0])
    coloured = dict.fromkeys(f.path for f in subject.parameters if f.declared.width == 3)
    channel = {path: number for number, path in enumerate(coloured)}
    points = np.tile(point, (2 if coloured else 0, 1))
    for row, (number, free) in itertools.product(range(len(points)), enumerate(subject.parameters)):
        if free.path in channel:
            points[row, number] = float((channel[free.path] + row + 2) % 3 == free.channel)
    return points


def screen(subject: Subject, points: Array) -> Screened:
    """What few samples and one look at each cell say of points."""
    parameters, wo = viewer(subject, points)
    samples = hemisphere.drawn(subject, parameters, wo, SCREEN_SAMPLES)
    cut = hemisphere.partition(subject, parameters, wo, hemisphere.FEWER, SCREEN_SAMPLES, samples)
    found = hemisphere.integrate(subject, parameters, wo, cut, INTEGRALS, 1)
    n = len(points)
    few = _few(subject, parameters, wo, *samples)
    kept, mean, scatter = few.kept, few.mean, few.scatter
    total = found.total
    # The rule's own error, of which this is four times an estimate
    error = 4 * found.error
    integral = np.abs(total[:, PDF] - kept) - error - np.where(kept < 1, QUASI, 0)
    # One look at each cell tells an albedo to a few percent only
    known = albedos(subject, parameters, wo, LOOSELY)
    albedo = known.total.mean(axis=1) - total[:, UNREACHED]
    noise = QUASI * 10 * scatter + SUSPICIOUS * np.maximum(albedo, 1e-3)
    weight = (np.abs(mean - albedo) - known.error) / noise
    cells = 2**hemisphere.FEWER
    # A quarter of the probes is spread evenly, whatever the sampler does
    drawn = np.bincount(cut.cell, minlength=n * cells).reshape(n, cells) / (0.75 * SCREEN_SAMPLES)
    shape = np.abs(drawn - found.cells[:, :, PDF]).max(axis=1) * cells - error * cells
    scores = [
        integral / SUSPICIOUS,
        weight,
        shape / CROWDED,
        total[:, UNREACHED],
        few.different,
        few.which,
        few.below,
    ]
    return Screened(points, *(np.where(np.isnan(score), np.inf, score) for score in scores))


@dataclass(frozen=True)
class Few:
    """What a few samples of each point have shown, (points,) each."""

    kept: Array
    """Part of them that is kept."""
    mean: Array
    """Of the weights, and their standard deviation."""
    scatter: Array
    different: Array
    """Largest relative difference between the reported density and that of `pdf`, and whose it is."""
    which: Array
    below: Array
    """Samples below the horizon with a density."""


def _few(subject: Subject, parameters: Array, wo: Array, wi: Array, reported: Array) -> Few:
    index = repeated(len(parameters), len(wi) // len(parameters))
    f, pdf = evaluate(subject, parameters, index, wi, wo[index])
    good = (reported > 0) & (wi[:, 2] > 0)
    with np.errstate(invalid="ignore", over="ignore"):
        weight = np.where(good, f.mean(axis=1) * wi[:, 2] / np.where(good, reported, 1), 0)
        different = np.where(good, np.abs(pdf - reported) / np.where(good, reported, 1), 0)
    low = (reported > 0) & (wi[:, 2] <= 0)
    weight, kept, different, below = (
        value.reshape(len(parameters), -1) for value in (weight, good, different, low)
    )
    return Few(
        kept.mean(axis=1),
        weight.mean(axis=1),
        weight.std(axis=1),
        different.max(axis=1),
        different.argmax(axis=1),
        below.sum(axis=1),
    )
