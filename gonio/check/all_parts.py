"""The energy of all parts of a BSDF together, of which some are no function that an integral could take.

Mirrors, what passes through and what is refracted are known by samples alone: the mean of their weights is
the part of the light that goes on. Even sequences of three numbers, each shifted by other random ones, say
how exact a mean is.
"""

from __future__ import annotations

import time
from dataclasses import replace
from typing import Any

import drjit as dr
import numpy as np

from gonio.check import energy
from gonio.check.adversarial import special_parts
from gonio.check.energy import dimensions, starts, viewer
from gonio.check.no_number import said
from gonio.check.report import FAIL, NOTE, PASS, Effort, Finding, Report
from gonio.check.search import maximise
from gonio.check.subject import Array, Subject, number_type, repeated, stored, vectors

# Sets of samples of one mean, and how many each has: in the search, and for the best that it finds.
REPLICATES = 16
FEW, MANY = 16, 1 << 13

# Roberts' sequence for three numbers: powers of the root of x⁴ = x + 1.
_ROOT = 1.2207440846057596
R3 = (1 / _ROOT, 1 / _ROOT**2, 1 / _ROOT**3)

# How many of the best finds are looked at again, and what a mean may be above 1: so many times its error,
# as for mean weights, and the roundings of single precision.
CONFIRMED, SIGMAS, ROUNDING = 4, 7.0, 1e-4


def check(subject: Subject, effort: Effort) -> Report:
    """`gonio.check.energy`, and the energy of all parts together where some are no function."""
    start = time.perf_counter()
    report = energy.check(subject, effort)
    if not subject.left_out:
        return report
    function, *others = report.findings
    # Other parts come to it; what is too much already is so all the same
    if function.verdict == PASS:
        text = f"without {' and '.join(subject.left_out)}; {function.text}"
        function = replace(function, verdict=NOTE, text=text)
    findings = (function, largest(subject, effort), *others)
    return Report(report.check, report.model, findings, time.perf_counter() - start)


def largest(subject: Subject, effort: Effort) -> Finding:
    """The largest energy that all parts together carry on, over angles and parameters."""
    points, _ = maximise(
        lambda p: means(subject, *viewer(subject, p), FEW)[0],
        dimensions(subject),
        population=effort.albedos // 2,
        rounds=max(effort.rounds // 2, 3),
        seed=91,
        starts=starts(subject)[: effort.albedos // 4],
        special=special_parts(subject),
        bands=len(subject.parameters),
    )
    points = points[:CONFIRMED]
    total, error = means(subject, *viewer(subject, points), MANY)
    best = int(np.argmax(np.where(np.isnan(total), np.inf, total - SIGMAS * error)))
    measured, off = float(total[best]), float(SIGMAS * error[best])
    verdict = PASS if measured <= 1 + off + ROUNDING else FAIL
    parameters, wo = viewer(subject, points[best : best + 1])
    theta = np.degrees(np.arccos(wo[0, 2]))
    fault = said(("the mean weight of samples", measured))
    text = (
        f"with {' and '.join(subject.left_out)}, by their samples: {fault or 'at most 1 is allowed'}; at "
        f"{theta:.4g} degrees, ± {max(off, ROUNDING):.1g}"
    )
    case = (parameters[0], wo[0], wo[0])
    replay = subject.replay(*case)
    return Finding("all parts together", measured, verdict, text, subject.tag(), replay, case)


def means(subject: Subject, parameters: Array, wo: Array, count: int) -> tuple[Array, Array]:
    """The mean weight of the worst channel for rows of parameters and viewers, and its standard error."""
    Float = number_type()
    lanes = REPLICATES * count
    rows = repeated(len(wo), lanes)
    index = stored(dr.uint32_array_t(Float), rows)
    u = np.tile(_numbers(count), (len(wo), 1))
    bound: Any = subject.at(parameters, index, Float)
    choice, *pair = (stored(Float, c) for c in u.T)
    weight = bound.weight(
        vectors(Float, wo[rows]), choice, dr.replace_shape_t(Float, (2, -1))(*pair)
    )
    dr.eval(weight)
    values = np.stack([np.broadcast_to(c.numpy(), len(rows)) for c in weight], -1)
    sets = values.reshape(len(wo), REPLICATES, count, 3).mean(axis=2)
    mean, error = sets.mean(axis=1), sets.std(axis=1, ddof=1) / np.sqrt(REPLICATES)
    worst = np.argmax(np.where(np.isnan(mean), np.inf, mean), axis=1)
    row = np.arange(len(wo))
    return mean[row, worst], error[row, worst]


def _numbers(count: int) -> Array:
    """REPLICATES even sequences of three numbers, one after the other."""
    rng = np.random.default_rng(92)
    n = np.arange(1, count + 1)[:, None]
    shifts = rng.random((REPLICATES, 1, 3))
    return np.asarray(((shifts + n * np.array(R3)) % 1.0).reshape(-1, 3))
