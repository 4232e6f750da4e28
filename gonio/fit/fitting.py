"""A fit from beginning to end, and all that is known about it."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from gonio.fields import ModelError
from gonio.fit.columns import columns
from gonio.fit.descent import Found, NotLinearError, polish, search
from gonio.fit.intervals import certainty
from gonio.fit.metrics import METRICS, Metric
from gonio.fit.misfit import Map, Noise, Region, noise, regions, residual_map
from gonio.fit.problem import Floats, Problem, from_measurement
from gonio.fit.structure import Structure, structure
from gonio.fit.targets import measure
from gonio.measured import Measurement
from gonio.model import Model
from gonio.reference import Stack

# Directions that a fit draws from a measurement unless it is told otherwise: more change the third digit.
POINTS = 10_000

# Part of a range that counts as its end.
END = 1e-6

Progress = Callable[[int, int], None]


@dataclass(frozen=True)
class Fit:
    """A fitted model, and how well it fits."""

    model: Model
    metric: str
    misfit: dict[str, float]
    """Root mean square difference in each metric; the fit made the one of `metric` small."""
    relative: float
    """Root mean square difference over that of the data, in the fit's metric."""
    noise: Noise | None
    """How much of the misfit is noise; None for data without any, or too few."""
    values: dict[str, float]
    """The free numbers, by name: "roughness", "rho.r", "alpha_x=alpha_y"."""
    linear: tuple[str, ...]
    """Those in which the value is linear, which were solved inside."""
    intervals: dict[str, tuple[float, float]]
    """Of the free numbers that the data say anything about: 95 % of a bootstrap over blocks."""
    undetermined: tuple[str, ...]
    """Free numbers that are not determined by this data, by name; those without any effect stay."""
    spare: tuple[str, ...]
    """Free numbers that stay, because others can do whatever they do: a weight beside a colour."""
    at_bounds: tuple[str, ...]
    """Free numbers that ended at an end of their range."""
    by_metric: dict[str, dict[str, float]]
    """The free numbers as each metric has them: where they differ, the model does not fit."""
    regions: tuple[Region, ...]
    """Where the model fails, the largest share of the misfit first."""
    map: Map
    """Residuals over theta_h and theta_d."""
    starts: tuple[float, ...]
    """What each start came to, best first: equal ones are reassuring."""
    blocks: int
    """Of directions, that the bootstrap draws."""
    directions: int
    evaluations: int
    seconds: float


def fit(
    model: Model,
    data: Measurement | Model | Stack,
    *,
    metric: str = "log",
    fixed: Iterable[str] = (),
    tied: Iterable[Sequence[str]] = (),
    starts: int = 4,
    points: int | None = POINTS,
    first: int = 0,
    seed: int = 0,
    progress: Progress | None = None,
) -> Fit:
    """Find the parameters of a model that come nearest to data.

    A pure function of its arguments: the same ones give the same result to the last bit, in any process.

    Args:
        model: its values are the first start, and stay where they are fixed. Options stay as they are.
        data: measured reflection, another model, or a stack of layers, whose ground truth is taken.
        metric: one of METRICS: log, cbrt, cosine.
        fixed: parameters that keep the model's values, such as "base.roughness", or channels, "rho.r".
        tied: groups of parameters that are one number, such as ("alpha_x", "alpha_y").
        starts: descents; the others begin at the best of places all over the ranges.
        points: directions that are drawn from the data; None for all.
        first: number of the first start, where others are made elsewhere; start 0 is the model itself.
        seed: of the draw, of the starts and of the bootstrap.
        progress: called with the starts that are done, and all of them.

    Raises:
        ModelError: an unknown metric or parameter, or nothing to fit.
        BackendError: there is no compiled backend.
    """
    if metric not in METRICS:
        raise ModelError(f"no metric {metric!r}; there are {', '.join(METRICS)}.")
    if starts < 1 or (points is not None and points < 1):
        raise ModelError(f"a fit needs a start and a direction, got {starts} and {points}.")
    begin = time.perf_counter()
    free = columns(model, fixed, tied)
    measured = measure(data, seed)
    problem = from_measurement(model, free, measured, points, seed)
    tried = structure(problem, seed)
    idle, spare = (tuple(free[j].name for j in which) for which in (tried.idle, tried.spare))
    if len(idle) == len(free):
        raise ModelError(
            f"{model.name}: {', '.join(idle)} have no effect on it; nothing is left free."
        )
    if idle or spare:
        free = tuple(c for c in free if c.name not in (*idle, *spare))
        problem = replace(problem, free=free)
        tried = structure(problem, seed)
    found, known = _search(problem, METRICS[metric], tried, starts, seed, progress, first)
    x = _tidy(problem, found[0].x)
    made = problem.made(x)
    misfit = {name: _rms(problem.residuals(x, m)) for name, m in METRICS.items()}
    light = METRICS[metric].value(problem.values * problem.cosines)
    size = _rms(light * np.sqrt(problem.weights)[:, None])
    relative = misfit[metric] / max(size, 1e-300)
    sure = certainty(problem, METRICS[metric], known, x, measured.isotropic, seed)
    clean = isinstance(data, Model)
    told = None if clean else noise(measured, problem, METRICS[metric], x, misfit[metric], seed)
    low, high = problem.bounds
    return Fit(
        model=made,
        metric=metric,
        misfit=misfit,
        relative=relative,
        noise=told,
        values=_values(problem, x),
        linear=tuple(free[j].name for j in known.columns(True)),
        intervals=sure.intervals,
        undetermined=(*idle, *sure.undetermined),
        spare=spare,
        at_bounds=tuple(
            column.name
            for column, value, a, b in zip(free, x, low, high, strict=True)
            if value in (a, b)
        ),
        by_metric={
            name: _values(
                problem, x if name == metric else _tidy(problem, _again(problem, m, known, x))
            )
            for name, m in METRICS.items()
        },
        regions=regions(problem, METRICS[metric], x, relative, told),
        map=residual_map(problem, METRICS[metric], x),
        starts=tuple(float(np.sqrt(2 * f.cost / problem.values.size)) for f in found),
        blocks=sure.blocks,
        directions=len(problem.wi),
        evaluations=problem.evaluations,
        seconds=time.perf_counter() - begin,
    )


def _search(
    problem: Problem,
    metric: Metric,
    known: Structure,
    starts: int,
    seed: int,
    progress: Progress | None,
    first: int,
) -> tuple[list[Found], Structure]:
    try:
        return search(problem, metric, known, starts, seed, progress, first), known
    except NotLinearError:  # a kink that the trials missed
        known = known.without_linear()
        return search(problem, metric, known, starts, seed, progress, first), known


def _again(problem: Problem, metric: Metric, known: Structure, x: Floats) -> Floats:
    """Where another metric has its best near a fit, at as many directions as a descent sees."""
    few = problem.part(slice(None, None, -(-len(problem.wi) // POINTS)))
    try:
        return polish(few, metric, known, x).x
    except NotLinearError:
        return polish(few, metric, known.without_linear(), x).x


def _tidy(problem: Problem, x: Floats) -> Floats:
    """Numbers at an end of their range, which a descent comes to from inside, are that end."""
    low, high = problem.bounds
    x = np.where(x - low < END * problem.width, low, x)
    return np.where(high - x < END * problem.width, high, x)


def _values(problem: Problem, x: Floats) -> dict[str, float]:
    return {column.name: float(value) for column, value in zip(problem.free, x, strict=True)}


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2)))
