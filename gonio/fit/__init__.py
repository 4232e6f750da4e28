"""Fitting a model's parameters to measured reflection, or to another model.

    from gonio import fit, measured
    found = fit.fit(gonio.model("disney"), measured.load("paint.binary"))
    found.model, found.misfit, found.undetermined

Bounded least squares (`scipy.optimize.least_squares`) from several starts; all columns of the Jacobian
come from one kernel of Dr.Jit, in double precision. The metric decides the answer: all three are reported.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np

from gonio.fields import ModelError
from gonio.fit.metrics import METRICS
from gonio.fit.problem import Column, Floats, Problem, columns, from_measurement
from gonio.measured import Measurement, OfModel, measurement
from gonio.measured.formats.csv import directions
from gonio.model import Model

__all__ = ["METRICS", "Column", "Fit", "Problem", "fit"]

# Directions that a fit draws from a measurement unless it is told otherwise: more change the third digit.
POINTS = 10_000

# Steps of one descent; most need 10 to 30.
STEPS = 80

# A number whose change by its whole range moves the values by less than this part of all that the data
# determine says nothing about them.
UNDETERMINED = 1e-4

# Descents begin strictly inside the bounds, by this part of a range.
INSIDE = 1e-3

# Relative changes of the sum and of the numbers at which a descent ends.
TOLERANCE = 1e-9

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
    undetermined: tuple[str, ...]
    """Free numbers that the data say nothing about, by name."""
    at_bounds: tuple[str, ...]
    """Free numbers that ended at an end of their range."""
    starts: tuple[float, ...]
    """What each start came to, best first: equal ones are reassuring."""
    directions: int
    evaluations: int
    seconds: float


def fit(
    model: Model,
    data: Measurement | Model,
    *,
    metric: str = "log",
    fixed: Iterable[str] = (),
    starts: int = 4,
    points: int | None = POINTS,
    seed: int = 0,
    progress: Progress | None = None,
) -> Fit:
    """Find the parameters of a model that come nearest to data.

    Args:
        model: its values are the first start, and stay where they are fixed. Options stay as they are.
        data: measured reflection, or another model.
        metric: one of METRICS: log, cbrt, cosine.
        fixed: paths of parameters that keep the model's values, such as "base.roughness".
        starts: descents; the others begin anywhere in the ranges.
        points: directions that are drawn from the data; None for all.
        seed: of the draw and of the starts. The same seed gives the same result.
        progress: called with the starts that are done, and all of them.

    Raises:
        ModelError: an unknown metric or parameter, or nothing to fit.
        BackendError: there is no compiled backend.
    """
    from scipy.optimize import least_squares

    if metric not in METRICS:
        raise ModelError(f"no metric {metric!r}; there are {', '.join(METRICS)}.")
    if starts < 1 or (points is not None and points < 1):
        raise ModelError(f"a fit needs a start and a direction, got {starts} and {points}.")
    if isinstance(data, Measurement) and data.transmission:
        raise ModelError(f"{data.title}: {data.part} is no reflection; models have no other.")
    begin = time.perf_counter()
    free = columns(model, fixed)
    measured = data if isinstance(data, Measurement) else _measure(data)
    problem = from_measurement(model, free, measured, points, seed)
    chosen = METRICS[metric]
    low, high = problem.bounds
    width = np.where(np.isfinite(high - low), high - low, 1.0)
    random = np.random.default_rng(seed + 1)
    found = []
    for number in range(starts):
        x = problem.start() if number == 0 else problem.random(random)
        x = np.clip(x, low + INSIDE * width, high - INSIDE * width)
        result = least_squares(
            lambda x: problem.residuals(x, chosen),
            x,
            lambda x: problem.jacobian(x, chosen),
            (low, high),
            x_scale=width,
            max_nfev=STEPS,
            ftol=TOLERANCE,
            xtol=TOLERANCE,
            gtol=1e-12,
        )
        found.append((float(result.cost), number, result.x))
        if progress is not None:
            progress(number + 1, starts)
    found.sort(key=lambda entry: entry[:2])
    x = found[0][2]
    return Fit(
        model=problem.made(x),
        metric=metric,
        misfit={name: _rms(problem.residuals(x, m)) for name, m in METRICS.items()},
        relative=_rms(problem.residuals(x, chosen)) / max(_rms(_data(problem, metric)), 1e-300),
        undetermined=_undetermined(problem, x, metric, width),
        at_bounds=tuple(
            column.name
            for column, value, a, b, w in zip(free, x, low, high, width, strict=True)
            if min(value - a, b - value) < 1e-6 * w
        ),
        starts=tuple(float(np.sqrt(2 * cost / problem.values.size)) for cost, _, _ in found),
        directions=len(problem.wi),
        evaluations=problem.evaluations,
        seconds=time.perf_counter() - begin,
    )


def _measure(model: Model) -> Measurement:
    """A model at directions all over the hemisphere, crowded around the mirror direction."""
    what = OfModel(model)
    wi, wo = directions(what.isotropic)
    return measurement(
        "model",
        what.title,
        wi,
        wo,
        what.evaluate(wi, wo),
        channels=what.channels,
        isotropic=what.isotropic,
    )


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _data(problem: Problem, metric: str) -> Floats:
    scaled = METRICS[metric].value(problem.values * problem.cosines)
    return np.asarray(scaled * problem.roots)


def _undetermined(problem: Problem, x: Floats, metric: str, width: Floats) -> tuple[str, ...]:
    """Numbers in directions of the Jacobian's null space: alone without effect, or only together."""
    jacobian = problem.jacobian(x, METRICS[metric]) * width
    _, sizes, directions_ = np.linalg.svd(jacobian, full_matrices=False)
    nothing = directions_[sizes <= UNDETERMINED * max(sizes[0], 1e-300)]
    share = (nothing**2).sum(0)
    return tuple(c.name for c, s in zip(problem.free, share, strict=True) if s > 0.1)
