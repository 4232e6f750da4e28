"""Reciprocity: f(wi, wo) = f(wo, wi) for all directions and parameters, by search."""

from __future__ import annotations

import time

import drjit as dr
import numpy as np

from gonio.check import hemisphere
from gonio.check.adversarial import special_parts
from gonio.check.kernels import evaluate_only
from gonio.check.no_number import said
from gonio.check.report import Effort, Finding, Report, judge
from gonio.check.search import maximise
from gonio.check.subject import (
    Array,
    Subject,
    cosine_at,
    directions,
    number_type,
    vectors,
)

# Differences count relative to the larger of the two values, or to this where both are smaller, in 1/sr.
FLOOR = 1e-4

# Two orders of the same ten operations in float64, through half vectors of lobes as sharp as 1e-4.
# Mitsuba's plug-ins compute in float32.
ROUNDING, ROUNDING_FLOAT32 = 1e-7, 2e-2

# The lowest cosine of the search; that of half vectors computed in float32 is higher.
MU_LOW, MU_LOW_FLOAT32 = 1e-4, 2e-2


def check(subject: Subject, effort: Effort) -> Report:
    """The largest relative difference between both orders of two directions."""
    start = time.perf_counter()
    points, values = maximise(
        lambda p: difference(subject, *pairs(subject, p)),
        dimensions(subject),
        population=effort.population,
        rounds=effort.rounds,
        seed=effort.beginning(11),
        special=special_parts(subject),
    )
    parameters, wi, wo = pairs(subject, points[:1])
    measured = float(values[0]) if not np.isinf(values[0]) else float("nan")
    limit = ROUNDING_FLOAT32 if subject.float32 else ROUNDING
    fault = said(*zip(("f(wi, wo)", "f(wo, wi)"), both(subject, parameters, wi, wo), strict=True))
    verdict, text = judge(subject, "reciprocity", measured, limit=limit, fault=fault)
    finding = Finding(
        "relative difference",
        measured,
        verdict,
        text,
        subject.tag(),
        subject.replay(parameters[0], wi[0], wo[0], compare="swapped"),
        (parameters[0], wi[0], wo[0]),
    )
    return Report("reciprocity", subject.name, (finding,), time.perf_counter() - start)


def dimensions(subject: Subject) -> int:
    """Coordinates of a pair of directions with parameters."""
    return len(subject.parameters) + 4


def pairs(subject: Subject, points: Array) -> tuple[Array, Array, Array]:
    """Parameters, wi and wo; wi is charted around the mirror direction, which shows every lobe."""
    count = len(subject.parameters)
    t = points[:, count:]
    low = MU_LOW_FLOAT32 if subject.float32 else MU_LOW
    wo = directions(np.maximum(cosine_at(t[:, 0]), low), 2 * np.pi * t[:, 1])
    Float = number_type()
    wi, _ = hemisphere.chart(vectors(Float, wo), Float(t[:, 2].copy()), Float(t[:, 3].copy()))
    dr.eval(wi)
    wi = np.stack([c.numpy() for c in wi], -1)
    level = directions(np.full(len(wi), low), np.arctan2(wi[:, 1], wi[:, 0]))
    wi = np.where(wi[:, 2:] < low, level, wi)
    return points[:, :count], wi / np.linalg.norm(wi, axis=1, keepdims=True), wo


def both(subject: Subject, parameters: Array, wi: Array, wo: Array) -> tuple[Array, Array]:
    """f(wi, wo) and f(wo, wi), (n, 3) each."""
    n = len(parameters)
    index = np.tile(np.arange(n, dtype=np.uint32), 2)
    f = evaluate_only(
        subject, parameters, index, np.concatenate([wi, wo]), np.concatenate([wo, wi])
    )
    return f[:n].astype(np.float64), f[n:].astype(np.float64)


def difference(subject: Subject, parameters: Array, wi: Array, wo: Array) -> Array:
    """|f(wi, wo) - f(wo, wi)| over the larger of the two, of the worst channel, (n,)."""
    a, b = both(subject, parameters, wi, wo)
    scale = np.maximum(np.maximum(np.abs(a), np.abs(b)), FLOOR)
    return np.asarray((np.abs(a - b) / scale).max(axis=1))
