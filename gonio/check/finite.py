"""Values: finite, not negative, the same in float32 as in float64, at hard directions and everywhere."""

from __future__ import annotations

import time

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from gonio.check.adversarial import hard_numbers, hard_pairs, places
from gonio.check.reciprocity import dimensions, pairs
from gonio.check.report import FAIL, PASS, Effort, Finding, Report, judge
from gonio.check.search import maximise
from gonio.check.subject import (
    Array,
    ModelSubject,
    Subject,
    columns_of,
    directions,
    draw,
    evaluate,
    known_size,
    number_type,
    stored,
    vectors,
)
from gonio.lang import MU_MIN

# Far tails of a lobe are compared with this: D has few digits left below 1e-38, and the other factors,
# 1 / (4 mu_i mu_o) for one, may be as large as 1e13.
FAR_TAIL = 1e-20

# Tails of a sharp lobe are powers and exponentials of 1 / alpha, which magnify its last bit, and total
# reflection sets in suddenly: so many roundings of the parameters and of the directions' length are
# allowed, each by what it changes in float64.
ROUNDINGS = 8

# What float32 is allowed to be off by, where a model documents nothing else.
FLOAT32 = 1e-5

# The densities of clipped lobes (samplers that do not reach everything) have a rim where they end; float32
# is compared there with a tenth of a typical density.
RIM = 0.1

# Values that pass through zero are compared with this instead, in 1/sr.
ZERO_CROSSING = 0.03

# The reported density is that of `pdf`, but for the roundings of wi in between.
SAME_DENSITY = 1e-6


def check(subject: Subject, effort: Effort) -> Report:
    """Values at hard directions, parameters and random numbers; the lowest one; float32 and float64."""
    start = time.perf_counter()
    findings = [_finite(subject), _lowest(subject, effort)]
    if isinstance(subject, ModelSubject):
        findings.append(_precision(subject, effort))
    return Report("finite", subject.name, tuple(findings), time.perf_counter() - start)


def _finite(subject: Subject) -> Finding:
    """Count what is NaN or infinite; the first such case is shown."""
    wi, wo = (w.astype(np.float64) for w in hard_pairs())
    n = len(wi)
    where = places(n, len(subject.columns), 4)
    index = np.arange(n, dtype=np.uint32)
    u = hard_numbers(n, 3).astype(np.float64)
    bad: list[tuple[str, NDArray[np.intp]]] = []
    with np.errstate(invalid="ignore", over="ignore"):
        for single_precision in (True,) if subject.float32 else (True, False):
            precision = "float32" if single_precision else "float64"
            f, pdf = evaluate(
                subject,
                where,
                index,
                wi,
                wo,
                single_precision=single_precision,
                rounded=True,
            )
            w, density = draw(subject, where, index, wo, u, single_precision=single_precision)
            ok = {
                "eval": np.isfinite(f).all(axis=1),
                "pdf": np.isfinite(pdf) & (pdf >= 0),
                "sample": np.isfinite(w).all(axis=1)
                & (np.abs(np.linalg.norm(w.astype(np.float64), axis=1) - 1) < 1e-5)
                & np.isfinite(density)
                & (density >= 0),
            }
            if isinstance(subject, ModelSubject) and subject.closed_form:
                E = closed_albedo(subject, where, wo, single_precision)
                ok["albedo"] = np.isfinite(E).all(axis=1)
            bad += [(f"{name} in {precision}", np.flatnonzero(~good)) for name, good in ok.items()]
    count = sum(len(rows) for _, rows in bad)
    if not count:
        text = f"eval, pdf, sample{', albedo' if 'albedo' in ok else ''} finite at {n} hard cases"
        return Finding("not finite", 0.0, PASS, text, subject.tag())
    name, rows = next((name, rows) for name, rows in bad if len(rows))
    row = rows[0]
    names = ", ".join(dict.fromkeys(n for n, r in bad if len(r)))
    case = (where[row], wi[row], wo[row])
    text = f"of {n} hard cases: {names}; first {name} with u = {u[row].tolist()}"
    return Finding(
        "not finite", float(count), FAIL, text, subject.tag(), subject.replay(*case), case
    )


def closed_albedo(
    subject: ModelSubject, where: Array, wo: Array, single_precision: bool = False
) -> NDArray[np.float64]:
    """The model's own albedo (n, 3) at n points."""
    Float = number_type(single_precision)
    UInt = dr.uint32_array_t(Float)
    model = subject.at(where, dr.arange(UInt, len(where)), Float, single_precision)
    E = dr.replace_shape_t(Float, (3, -1))(model.albedo(vectors(Float, wo)))
    E = E + dr.zeros(Float, len(where))
    return columns_of(E, Float).astype(np.float64)


def _lowest(subject: Subject, effort: Effort) -> Finding:
    """The most negative value, by search, times pi."""

    def depth(points: Array) -> Array:
        where, wi, wo = pairs(subject, points)
        f, _ = evaluate(subject, where, np.arange(len(where), dtype=np.uint32), wi, wo)
        return np.asarray(-np.pi * f.min(axis=1))

    points, values = maximise(
        depth,
        dimensions(subject),
        population=effort.population,
        rounds=effort.rounds,
        seed=12,
    )
    where, wi, wo = pairs(subject, points[:1])
    lowest = float(values[0]) if values[0] > 0 else 0.0
    # Roundings of a lobe that ends in zero
    verdict, text = judge(subject, "negative", lowest, limit=1e-12)
    case = (where[0], wi[0], wo[0])
    return Finding(
        "below zero, times pi",
        lowest,
        verdict,
        text,
        subject.tag(),
        subject.replay(*case),
        case,
    )


def _precision(subject: ModelSubject, effort: Effort) -> Finding:
    """The largest relative error of float32 against float64, on the same float32 inputs."""
    # The squares of smaller cosines are below the smallest float32
    hard_i, hard_o = hard_pairs(MU_MIN)
    rng = np.random.default_rng(1)
    count = effort.pairs
    random = [
        directions(rng.random(count), 2 * np.pi * rng.random(count)).astype(np.float32)
        for _ in range(2)
    ]
    wi, wo = np.concatenate([hard_i, random[0]]), np.concatenate([hard_o, random[1]])
    where = places(len(wi), len(subject.columns), 5)
    index = np.arange(len(wi), dtype=np.uint32)
    wi64, wo64 = wi.astype(np.float64), wo.astype(np.float64)
    with np.errstate(invalid="ignore", over="ignore"):
        low = _values(subject, where, index, wi64, wo64, single_precision=True)
        high = _values(subject, where, index, wi64, wo64, single_precision=False)
        error = np.abs(low - high)
        # A float32 ends at 1e-38
        scale = np.where(np.abs(high) > 0, np.maximum(np.abs(high), FAR_TAIL), 1)
        if known_size(subject, "negative") is not None:
            scale[:, :3] = np.maximum(scale[:, :3], ZERO_CROSSING)
        if known_size(subject, "unreached") is not None:
            scale[:, 3] = np.maximum(scale[:, 3], RIM)
        # What is not finite has been reported
        error = np.where(np.isfinite(error), error, 0)
        rows = np.flatnonzero((error > 0.5 * FLOAT32 * scale).any(axis=1))
        if len(rows):
            effect = _rounding_effect(subject, where[rows], wi64[rows], wo64[rows], high[rows])
            error[rows] = np.maximum(error[rows] - ROUNDINGS * effect, 0)
        error = error / scale
    row, column = np.unravel_index(error.argmax(), error.shape)
    measured = float(error[row, column])
    verdict, text = judge(subject, "float32", measured, limit=FLOAT32, searched=False)
    name = ("eval", "eval", "eval", "pdf", "albedo", "albedo", "albedo")[column]
    case = (where[row], wi64[row], wo64[row])
    return Finding(
        "float32 error",
        measured,
        verdict,
        f"{text}; {name}",
        subject.tag(),
        subject.replay(*case),
        case,
    )


def _values(
    subject: ModelSubject,
    where: Array,
    index: NDArray[np.uint32],
    wi: Array,
    wo: Array,
    *,
    single_precision: bool,
    scaled: dict[int, float] | None = None,
) -> NDArray[np.float64]:
    """BRDF, density and closed-form albedo, one column each."""
    f, pdf = evaluate(
        subject, where, index, wi, wo, single_precision=single_precision, rounded=True
    )
    columns = [f.astype(np.float64), pdf.astype(np.float64)[:, None]]
    if subject.closed_form:
        Float = number_type(single_precision)
        UInt = dr.uint32_array_t(Float)
        model = subject.at(where, stored(UInt, index), Float, True)
        E = dr.replace_shape_t(Float, (3, -1))(model.albedo(vectors(Float, wo)))
        columns.append(columns_of(E + dr.zeros(Float, len(wo)), Float).astype(np.float64))
    return np.concatenate(columns, axis=1)


def _rounding_effect(
    subject: ModelSubject, where: Array, wi: Array, wo: Array, value: Array
) -> Array:
    """Change of the values in float64 by half a float32 epsilon in each parameter, in |wi| and in |wo|."""
    n, parameters = len(where), len(subject.columns)
    shorter = 1 - 2.0**-24
    total = np.zeros_like(value)
    index = np.arange(n, dtype=np.uint32)
    changed = _values(subject, where, index, wi * shorter, wo * shorter, single_precision=False)
    total += np.abs(changed - value)
    for column in range(parameters):
        moved = _Moved(subject, column)
        changed = _values(moved, where, index, wi, wo, single_precision=False)
        total += np.abs(changed - value)
    return total


class _Moved(ModelSubject):
    """A model with one number moved by half a float32 epsilon, away from an end of its range."""

    def __init__(self, subject: ModelSubject, column: int) -> None:
        super().__init__(subject.model, subject.fixed, subject.label)
        self.moved = self.columns[column]

    def values(self, places: Array, rounded: bool = False) -> dict[str, Array]:
        """As those of the model, but one."""
        found = super().values(places, rounded)
        path, channel, declared = self.moved.path, self.moved.channel, self.moved.declared
        value = found[path] if declared.width == 1 else found[path][:, channel]
        up = value * (1 + 2.0**-24)
        inside = (up >= declared.lowest) & (up <= declared.highest)
        new = np.where(inside, up, value * (1 - 2.0**-24))
        if declared.width == 1:
            found[path] = new
        else:
            found[path] = found[path].copy()
            found[path][:, channel] = new
        return found
