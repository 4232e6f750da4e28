"""Monotonicity: parameters of which the model says that the mean albedo never grows with them.

Steps along the parameter are integrated at two rows of the other parameters, and many more are looked at
with an estimate of the mean, in a search over all parameters; its best finds are integrated as well.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass

import numpy as np

from gonio.check.adversarial import hard_parameters, special_parts
from gonio.check.energy import ROUGHLY, SHALLOW, SINGLE, estimate, precise, spread_out
from gonio.check.hemisphere import LEVELS
from gonio.check.no_number import said
from gonio.check.report import FAIL, PASS, Effort, Finding, Report
from gonio.check.search import maximise
from gonio.check.subject import R2, Array, Subject, directions

# Steps over the parameter's range, each at a random value, rows of the other parameters at which they are
# integrated, nodes of the mean over wo, and azimuths of an anisotropic model.
STEPS, ROWS, NODES, TURNS = 11, 2, 3, 4

# The steps that grow most, or fall least, are cut into so many, so many times.
NEARER, LOOKS, WORST = 4, 2, 2

# Steps of the search, as powers of ten; below the last it is the growth that counts, above it the slope.
SMALLEST, LARGEST, SLOPE = -3.0, -0.5, 0.03

# Rounds of the search, and one in so many of its points of which the growth is integrated.
ROUNDS, CONFIRMED = 5, 8

# So many special values are among the steps that are integrated; all of them are in the search.
SPECIAL = 6

# Means may grow by the error of the integrals.
TRUSTED = 5e-5


def check(subject: Subject, effort: Effort) -> Report:
    """The largest growth of the mean albedo between two neighbouring values."""
    start = time.perf_counter()
    free = {f.path for f in subject.parameters}
    findings = [_growth(subject, path, effort) for path in subject.claims.falls if path in free]
    return Report("monotonicity", subject.name, tuple(findings), time.perf_counter() - start)


def means(
    subject: Subject, parameters: Array, tolerance: float = ROUGHLY, levels: int = SHALLOW
) -> Array:
    """Mean albedos (rows, 3) over wo, of albedos that `precise` integrates."""
    mu, w = _nodes()
    turns = 1 if subject.isotropic else TURNS
    azimuth = 2 * np.pi * np.repeat(np.arange(turns) + 0.137, NODES) / turns
    wo = np.tile(directions(np.tile(mu, turns), azimuth), (len(parameters), 1))
    each = NODES * turns
    E = precise(subject, np.repeat(parameters, each, axis=0), wo, tolerance, levels)
    weight = np.tile(w, turns) / turns
    return np.asarray((E.reshape(len(parameters), each, 3) * weight[:, None]).sum(axis=1))


def _nodes() -> tuple[Array, Array]:
    """Cosines of wo, and weights, of (1/π) ∫ E μ dω = ∫ E dμ²."""
    x, w = np.polynomial.legendre.leggauss(NODES)
    return np.sqrt((x + 1) / 2), w / 2


def _estimated(subject: Subject, parameters: Array) -> Array:
    """The same to a percent; the error of neighbours is about the same."""
    mu, w = _nodes()
    wo = np.tile(directions(mu, 2 * np.pi * R2[0] * np.arange(NODES)), (len(parameters), 1))
    E = estimate(subject, np.repeat(parameters, NODES, axis=0), wo)
    return np.asarray((E.reshape(len(parameters), NODES, 3) * w[:, None]).sum(axis=1))


def _growth(subject: Subject, path: str, effort: Effort) -> Finding:
    rng = np.random.default_rng(61)
    number = next(n for n, f in enumerate(subject.parameters) if f.path == path)
    rows = hard_parameters(subject, ROWS, 62)
    rows[0] = subject.default()
    special = special_parts(subject)[number]
    few = rng.choice(special, min(len(special), SPECIAL), replace=False)
    steps = np.unique(np.concatenate([(np.arange(STEPS) + rng.random(STEPS)) / STEPS, few]))
    chains = [(row, steps) for row in rows] + _likely(subject, number, effort)
    best = _largest(subject, number, chains, ROUGHLY, SHALLOW)
    if not best[0].growth <= TRUSTED:  # what fails is looked at with care
        chains = [(step.row, np.array([step.low, step.high])) for step in best]
        best = _largest(subject, number, chains, SINGLE, LEVELS)
    worst = max(best[0].growth, 0.0)
    verdict = PASS if worst <= TRUSTED else FAIL
    up = np.array([0.0, 0.0, 1.0])
    where = best[0].row.copy()
    where[number] = best[0].high
    case = (where, up, up)
    ends = np.tile(best[0].row, (2, 1))
    ends[:, number] = best[0].low, best[0].high
    text = "the mean albedo may not grow, whatever the other parameters are"
    if not math.isfinite(worst):
        text = said(("the mean of eval's integrals", means(subject, ends, SINGLE, LEVELS))) or text
    return Finding(
        f"growth with {path}",
        worst,
        verdict,
        text,
        subject.tag(),
        subject.recheck("monotonicity", case, free={path}),
        case,
    )


def _at(points: Array, number: int, part: Array) -> Array:
    """Rows of parameters of points of the search, with this number at these parts of its range."""
    rows = points[:, :-1].copy()
    rows[:, number] = np.clip(part, 0, 1)
    return rows


def _step(points: Array) -> Array:
    """The steps of points of the search."""
    return np.asarray(10 ** (SMALLEST + (LARGEST - SMALLEST) * points[:, -1]))


def _likely(subject: Subject, number: int, effort: Effort) -> list[tuple[Array, Array]]:
    """Settings of all parameters at which an estimate of the mean grows, with two steps there."""

    def steepest(points: Array) -> Array:
        at, step = points[:, number], _step(points)
        rows = [_at(points, number, at + side * step) for side in (-1.0, 0.0, 1.0)]
        mean = _estimated(subject, np.concatenate(rows)).reshape(3, len(points), 3)
        growth = np.diff(mean, axis=0).max(axis=(0, 2))
        return np.asarray(growth / (step + SLOPE))

    rng = np.random.default_rng(63)
    count = effort.screened
    points, _ = maximise(
        steepest,
        len(subject.parameters) + 1,
        population=count,
        rounds=ROUNDS,
        seed=64,
        starts=np.column_stack([hard_parameters(subject, count // 2, 65), rng.random(count // 2)]),
        special=special_parts(subject),
        steps=(0.1, 1e-3),
        bands=number,
    )
    best = spread_out(points, max(count // CONFIRMED, 2))
    return [
        (row, np.unique(np.clip(row[number] + step * np.array([-1, 0, 1]), 0, 1)))
        for row, step in zip(_at(best, number, best[:, number]), _step(best), strict=True)
    ]


@dataclass(frozen=True)
class Step:
    """A step along a parameter from one part of its range to another, and how much the mean grows."""

    growth: float
    row: Array
    """Of all parameters."""
    low: float
    high: float


def _largest(
    subject: Subject,
    number: int,
    chains: list[tuple[Array, Array]],
    tolerance: float,
    levels: int,
) -> list[Step]:
    """Steps by which the mean grows most, or falls least, the worst first.

    chains: rows of parameters, and the parts of the range where the mean is to be compared.
    """

    def along(chains: list[tuple[Array, Array]]) -> list[tuple[Array, Array, Array]]:
        parameters = [np.tile(row, (len(t), 1)) for row, t in chains]
        for one, (_, t) in zip(parameters, chains, strict=True):
            one[:, number] = t
        mean = means(subject, np.concatenate(parameters), tolerance, levels)
        ends = np.cumsum([len(t) for _, t in chains])[:-1]
        return [(*chain, m) for chain, m in zip(chains, np.split(mean, ends), strict=True)]

    best: list[Step] = []
    for look in range(LOOKS + 1):
        for row, t, mean in along(chains):
            growth = np.diff(mean, axis=0).max(axis=1)
            growth = np.where(np.isnan(growth), np.inf, growth)
            most = np.argsort(-growth)[:WORST]
            best += [Step(float(growth[k]), row, float(t[k]), float(t[k + 1])) for k in most]
        best.sort(key=lambda step: -step.growth)
        if look < LOOKS:
            chains = [(s.row, np.linspace(s.low, s.high, NEARER + 1)) for s in best[:WORST]]
    return best[: 2 * WORST]
