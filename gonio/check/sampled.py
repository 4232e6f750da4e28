"""Sampled directions in float32: where float64 puts them, for random numbers that are hardly different.

How far two directions may be apart depends on how sharp the lobe is, which the sampler itself tells: its
random numbers are moved by `STEP`, and the directions that float64 gives for those are as far away as that
part of all samples. An error is told in the same way: as the step of the random numbers, in parts of their
range, that would move the direction as far. What only a thousandth of the samples has is not looked at: a
half vector that nearly vanishes, or a lobe that is chosen by the last bit, concerns a millionth of them.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from gonio.check.adversarial import EXTRA, Cases, hard_cases, random_points, special_parts
from gonio.check.finite import ROUNDINGS, together
from gonio.check.kernels import draw_at
from gonio.check.report import Effort, Finding, judge
from gonio.check.search import maximise
from gonio.check.subject import Array, Subject, even

# The step of the random numbers.
STEP = 1e-3

# What float32 may be off by where a model documents nothing. Of the narrowest lobe, 1e-4 wide, a direction
# that is turned into the frame of a tilted facet and back is off by 2e-3, whatever the formula.
ALLOWED = 5e-3

# A rounding, and how many of them a direction may have: its own components', and those of half vectors and
# frames on the way.
EPSILON, OF_DIRECTIONS = 2.0**-24, 16

# Of so many samples around each of a search's cases the median counts, and of so many at the end.
AROUND, AT_LAST = 3, 9

# Errors below this part of the allowed ones are not told from nothing; of so many of the worst cases it is
# asked at the end what is excused.
TOLD, FINALISTS = 0.25, 64


def check(subject: Subject, effort: Effort) -> Finding:
    """The largest error of a sampled direction, by search."""
    points, _ = maximise(
        lambda p: typical(subject, hard_cases(subject, p), TOLD * ALLOWED, AROUND),
        len(subject.parameters) + EXTRA,
        population=effort.pairs // 2,
        rounds=max(effort.rounds // 4, 3),
        seed=47,
        starts=random_points(subject, effort.pairs // 4, 48),
        special=special_parts(subject),
    )
    cases = hard_cases(subject, points[:FINALISTS])
    found = typical(subject, cases, 0.0, AT_LAST)
    row = int(np.argmax(found))
    measured = float(found[row])
    verdict, text = judge(subject, "float32", measured, limit=ALLOWED, searched=False)
    text += "; as a step of the random numbers that moves the direction as far"
    case = (cases.parameters[row], cases.wi[row], cases.wo[row])
    replay = subject.replay(*case, double=False, u=cases.u[row], compare="double")
    return Finding("sampled in float32", measured, verdict, text, subject.tag(), replay, case)


def typical(subject: Subject, cases: Cases, told: float, count: int) -> Array:
    """The median error, (n,), of so many samples within STEP of each case's random numbers."""
    offsets = 2 * STEP * (even(count) - 0.5)
    near = np.clip(cases.u[:, None] + offsets, STEP, 1 - STEP).astype(np.float32)
    parameters, wi, wo = (
        np.repeat(part, count, axis=0) for part in (cases.parameters, cases.wi, cases.wo)
    )
    wide = Cases(parameters, wi, wo, near.reshape(-1, 2).astype(np.float64))
    return np.asarray(np.median(errors(subject, wide, told).reshape(-1, count), axis=1))


def errors(subject: Subject, cases: Cases, told: float) -> Array:
    """How far float32's directions are off, (n,), as steps of the random numbers.

    What roundings of the random numbers, of wo and of the parameters change is left out of errors above
    `told`. Samples that are wasted in one precision count as no error.
    """
    wi, kept = _drawn(subject, cases, single_precision=True)
    exact, sound = _drawn(subject, cases)
    used = kept & sound
    off = np.where(used, np.linalg.norm(np.where(used[:, None], wi - exact, 0), axis=1), 0)
    off = np.maximum(off - OF_DIRECTIONS * EPSILON, 0)
    found = np.zeros(len(cases))
    rows = np.flatnonzero(off > 0)
    if not len(rows):
        return found
    few = _some(cases, rows)
    scale = _moved(subject, few, exact[rows], _steps(few, STEP))
    found[rows] = STEP * off[rows] / np.maximum(scale, EPSILON)
    rows = np.flatnonzero(found > told)
    if len(rows):
        few = _some(cases, rows)
        nearest = _nearest(subject, few, wi[rows])
        roundings = _moved(subject, few, exact[rows], _steps(few, ROUNDINGS * EPSILON))
        roundings += _moved(subject, few, exact[rows], _turns(few))
        roundings += ROUNDINGS * _by_parameters(subject, few, exact[rows])
        left = np.minimum(off[rows], nearest - OF_DIRECTIONS * EPSILON) - roundings
        found[rows] *= np.maximum(left, 0) / off[rows]
    return found


def _drawn(
    subject: Subject, cases: Cases, *, single_precision: bool = False
) -> tuple[Array, NDArray[np.bool_]]:
    """Directions in double precision, and which of them are samples at all."""
    values = subject.values(cases.parameters, rounded=True)
    wi, pdf = draw_at(subject, values, cases.wo, cases.u, single_precision=single_precision)
    return wi.astype(np.float64), (pdf > 0) & np.isfinite(wi).all(axis=1)


def _some(cases: Cases, rows: NDArray[np.intp]) -> Cases:
    return Cases(cases.parameters[rows], cases.wi[rows], cases.wo[rows], cases.u[rows])


def _steps(cases: Cases, step: float) -> Iterator[Cases]:
    """The same cases, with one of the random numbers a step larger or smaller."""
    for number in (0, 1):
        for sign in (-1, 1):
            u = cases.u.copy()
            u[:, number] = np.clip(u[:, number] + sign * step, 0, 1 - EPSILON)
            yield dataclasses.replace(cases, u=u)


def _turns(cases: Cases) -> Iterator[Cases]:
    """The same cases, with wo's x or y a rounding larger or smaller."""
    for axis in (0, 1):
        for sign in (-1, 1):
            wo = cases.wo.copy()
            wo[:, axis] += sign * EPSILON
            yield dataclasses.replace(cases, wo=wo)


def _moved(subject: Subject, cases: Cases, wi: Array, others: Iterator[Cases]) -> Array:
    """How far float64's directions of other cases are from these at most, (n,)."""
    far = np.zeros(len(cases))
    for other in others:
        moved, kept = _drawn(subject, other)
        distance = np.where(kept, np.linalg.norm(moved - wi, axis=1), 0)
        far = np.maximum(far, np.where(np.isfinite(distance), distance, 0))
    return far


def _nearest(subject: Subject, cases: Cases, wi: Array) -> Array:
    """How far these directions are from float64's with random numbers a few roundings away, (n,)."""
    near = np.full(len(cases), np.inf)
    for other in _steps(cases, ROUNDINGS * EPSILON):
        moved, kept = _drawn(subject, other)
        distance = np.linalg.norm(moved - wi, axis=1)
        near = np.fmin(near, np.where(kept, distance, np.inf))
    return near


def _by_parameters(subject: Subject, cases: Cases, wi: Array) -> Array:
    """How far half a float32 epsilon in the parameters moves float64's directions, (n,)."""
    if not subject.parameters:
        return np.zeros(len(cases))
    values = together(subject, subject.values(cases.parameters, rounded=True))
    blocks = len(next(iter(values.values()))) // len(cases)
    wo, u = np.tile(cases.wo, (blocks, 1)), np.tile(cases.u, (blocks, 1))
    moved, pdf = draw_at(subject, values, wo, u)
    distance = np.linalg.norm(moved - np.tile(wi, (blocks, 1)), axis=1)
    distance = np.where((pdf > 0) & np.isfinite(distance), distance, 0)
    return np.asarray(distance.reshape(blocks, -1).max(axis=0))
