"""Values: finite, not negative, the same in float32 as in float64, at hard directions and everywhere."""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from gonio.check import kernels
from gonio.check.adversarial import (
    EXTRA,
    Cases,
    hard_cases,
    hard_numbers,
    hard_pairs,
    hard_parameters,
    random_points,
    special_parts,
)
from gonio.check.kernels import draw, evaluate, evaluate_only
from gonio.check.no_number import said
from gonio.check.reciprocity import dimensions, pairs
from gonio.check.report import FAIL, PASS, Effort, Finding, Report, judge
from gonio.check.search import maximise
from gonio.check.subject import (
    Array,
    FreeNumber,
    Subject,
    columns_of,
    gathered,
    number_of,
    number_type,
    stored,
    vectors,
)
from gonio.lang import MU_MIN
from gonio.parts.distribution import ALPHA_MIN

# Far tails of a lobe are compared with this. Below 1e-38 a float32 has no digits left; divided by a cosine
# of 1e-18 afterwards that is an error of 1e-20, which is FLOAT32 of this.
FAR_TAIL = 1e-15

# Tails of a sharp lobe are powers and exponentials of 1 / alpha, which magnify its last bit, and total
# reflection sets in suddenly: so many roundings of the parameters are allowed, each by what it changes in
# float64. None of the directions: what depends on their length is a formula that has a better one.
ROUNDINGS = 8

# How a parameter is moved to see what roundings change: whether up, and by how many of them.
WAYS = ((True, 1), (False, 1), (True, ROUNDINGS), (False, ROUNDINGS))

# The narrowest distribution of facets, D, ends where its exponential leaves a float32. A value is D times
# G / (4 mu_i mu_o), and G at most the smaller cosine over the larger one, of V-grooves four times that: D
# over the square of the larger. A density is D m.z / (4 wo.m), and wo.m at least half the larger: D over
# twice the larger.
D_END = 2.0**-126 / (np.pi * ALPHA_MIN * ALPHA_MIN)

# What float32 is allowed to be off by, where a model documents nothing else.
FLOAT32 = 1e-5

# Sampled directions may be so much longer or shorter than one.
LENGTH = 1e-5

# Of errors below this searches do not ask what is excused, which takes most of their time; of so many of
# the worst it is asked at the end.
TOLD, FINALISTS = 0.05 * FLOAT32, 64

# The densities of clipped lobes (samplers that do not reach everything) have a rim where they end; float32
# is compared there with a tenth of a typical density.
RIM = 0.1

# Values that pass through zero are compared with this instead, in 1/sr.
ZERO_CROSSING = 0.03

# From so many hard cases on the whole list of hard pairs is affordable.
FULL = 1024

# Cosines of directions that are hardly above the horizon.
FLAT = 1e-5

# Mean albedos, and those composed of quadratures, are integrals of their own: fewer are tried.
MEANS = 64

NAMES = ("eval", "eval", "eval", "pdf", "albedo", "albedo", "albedo")
DENSITY = NAMES.index("pdf")


def check(subject: Subject, effort: Effort) -> Report:
    """Values at hard directions, parameters and random numbers; the lowest one; float32 and float64."""
    start = time.perf_counter()
    cases = all_cases(subject, effort)
    findings = [_finite(subject, cases, effort), _lowest(subject, cases, effort)]
    if subject.claiming and not subject.float32:
        findings += _precision(subject, effort)
    return Report("finite", subject.name, tuple(findings), time.perf_counter() - start)


# --- finite --------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Wrong:
    """A case in which a method is not finite, or something else that is never allowed."""

    what: str
    precision: str
    parameters: Array
    wi: Array
    wo: Array
    u: Array
    value: str


def all_cases(subject: Subject, effort: Effort) -> Cases:
    """The fixed list of hard pairs, and random hard cases."""
    # Every third of them where little is affordable
    step = 1 if effort.cases >= FULL else 3
    wi, wo = (w.astype(np.float64)[::step] for w in hard_pairs())
    n = len(wi)
    more = hard_cases(subject, random_points(subject, effort.cases, 9))
    return Cases(
        np.concatenate([hard_parameters(subject, n, 4), more.parameters]),
        np.concatenate([wi, more.wi]),
        np.concatenate([wo, more.wo]),
        np.concatenate([hard_numbers(n, 3).astype(np.float64), more.u]),
    )


def _finite(subject: Subject, cases: Cases, effort: Effort) -> Finding:
    """Count what is NaN or infinite; the first such case is shown."""
    found: list[Wrong] = []
    count = 0
    for single_precision in (True,) if subject.float32 else (True, False):
        wrong, number = not_finite(subject, cases, single_precision)
        found += wrong
        count += number
    if not found:
        # The largest value is searched for, in float32: it leads to where something overflows
        points, _ = maximise(
            lambda p: largest(subject, hard_cases(subject, p)),
            len(subject.parameters) + EXTRA,
            population=effort.cases,
            rounds=effort.rounds // 2,
            seed=14,
            special=special_parts(subject),
        )
        found, count = not_finite(subject, hard_cases(subject, points[:64]), True)
    if not count:
        albedo = ", albedo" if subject.albedos in ("closed form", "composed") else ""
        text = f"eval, pdf, sample{albedo} finite at {len(cases)} hard cases and in a search"
        return Finding("not finite", 0.0, PASS, text, subject.tag())
    first = found[0]
    names = ", ".join(dict.fromkeys(f"{w.what} in {w.precision}" for w in found))
    case = (first.parameters, first.wi, first.wo)
    sampled = first.what == "sample"
    replay = subject.replay(
        *case, double=first.precision == "float64", u=first.u if sampled else None
    )
    text = f"of {len(cases)} hard cases: {names}; first {first.what} = {first.value}"
    return Finding("not finite", float(count), FAIL, text, subject.tag(), replay, case)


def not_finite(subject: Subject, cases: Cases, single_precision: bool) -> tuple[list[Wrong], int]:
    """The first case of each kind in which a method is not what it may be, and how many there are."""
    n = len(cases)
    index = np.arange(n, dtype=np.uint32)
    results: dict[str, tuple[Any, NDArray[Any]]] = {}
    with np.errstate(invalid="ignore", over="ignore"):
        f, pdf = evaluate(
            subject,
            cases.parameters,
            index,
            cases.wi,
            cases.wo,
            single_precision=single_precision,
            rounded=True,
        )
        w, density = draw(
            subject, cases.parameters, index, cases.wo, cases.u, single_precision=single_precision
        )
        length = np.linalg.norm(w.astype(np.float64), axis=1)
        results["eval"] = np.isfinite(f).all(axis=1), f
        results["pdf"] = np.isfinite(pdf) & (pdf >= 0), pdf
        results["sample"] = (
            (
                np.isfinite(w).all(axis=1)
                & (np.abs(length - 1) < LENGTH)
                & np.isfinite(density)
                & (density >= 0)
            ),
            np.concatenate([w, density[:, None]], axis=1),
        )
        step = max(n // MEANS, 1)
        if subject.albedos == "closed form":
            E = kernels.albedo(subject, cases.parameters, cases.wo, single_precision)
            results["albedo"] = np.isfinite(E).all(axis=1), E
        elif subject.albedos == "composed":
            E = kernels.albedo(
                subject, cases.parameters[::step], cases.wo[::step], single_precision
            )
            E = np.repeat(E, step, axis=0)[:n]
            results["albedo"] = np.isfinite(E).all(axis=1), E
        if subject.mean_closed:
            E = kernels.mean_albedo(subject, cases.parameters[::step], single_precision)
            E = np.repeat(E, step, axis=0)[:n]
            results["mean albedo"] = np.isfinite(E).all(axis=1), E
    precision = "float32" if single_precision else "float64"
    wrong = []
    for what, (good, value) in results.items():
        for row in np.flatnonzero(~good)[:1]:
            shown = ", ".join(f"{x:.6g}" for x in np.atleast_1d(value[row]))
            shown += _though_finite(what, value[row])
            wrong.append(
                Wrong(
                    what,
                    precision,
                    cases.parameters[row],
                    cases.wi[row],
                    cases.wo[row],
                    cases.u[row],
                    shown,
                )
            )
    return wrong, sum(int(np.count_nonzero(~good)) for good, _ in results.values())


def _though_finite(what: str, value: Array) -> str:
    """What is wrong with numbers that are finite: a density, or a direction with its own."""
    if what not in ("pdf", "sample") or not np.isfinite(value).all():
        return ""
    *direction, density = np.atleast_1d(value).astype(np.float64)
    if density < 0:
        return ", a density below 0"
    return f", wi of length {np.linalg.norm(direction):.6g}, where a direction has 1"


def largest(subject: Subject, cases: Cases) -> Array:
    """The largest value or density of each case in float32, as a power of ten; infinite if not finite."""
    index = np.arange(len(cases), dtype=np.uint32)
    with np.errstate(invalid="ignore", over="ignore"):
        f, pdf = evaluate(
            subject,
            cases.parameters,
            index,
            cases.wi,
            cases.wo,
            single_precision=True,
            rounded=True,
        )
        top = np.maximum(np.abs(f).max(axis=1), np.abs(pdf)).astype(np.float64)
    return np.where(np.isfinite(top), np.log10(np.maximum(top, 1e-45)), np.inf)


# --- not negative --------------------------------------------------------------------------------


def _lowest(subject: Subject, cases: Cases, effort: Effort) -> Finding:
    """The most negative value, by search, times pi; in float32 as well."""

    def depth(points: Array) -> Array:
        parameters, wi, wo = pairs(subject, points)
        f = evaluate_only(subject, parameters, np.arange(len(wi), dtype=np.uint32), wi, wo)
        return np.asarray(-np.pi * f.min(axis=1))

    points, values = maximise(
        depth,
        dimensions(subject),
        population=effort.population,
        rounds=effort.rounds,
        seed=effort.beginning(12),
        special=special_parts(subject),
    )
    parameters, wi, wo = pairs(subject, points[:1])
    case = (parameters[0], wi[0], wo[0])
    # 0 first: of two equal numbers `max` takes that one, and the other may be -0
    lowest = max(0.0, float(values[0])) if not np.isinf(values[0]) else float("nan")
    double = True
    if lowest == 0 and not subject.float32:
        f, _ = evaluate(
            subject,
            cases.parameters,
            np.arange(len(cases), dtype=np.uint32),
            cases.wi,
            cases.wo,
            single_precision=True,
            rounded=True,
        )
        below = -np.pi * f.min(axis=1)
        row = int(np.argmax(np.nan_to_num(below, nan=0.0)))  # NaN has been reported
        if below[row] > 0:
            lowest, double = float(below[row]), False
            case = (cases.parameters[row], cases.wi[row], cases.wo[row])
    f = evaluate_only(subject, case[0][None], np.zeros(1, np.uint32), case[1][None], case[2][None])
    # Roundings of a lobe that ends in zero
    verdict, text = judge(subject, "negative", lowest, limit=1e-12, fault=said(("eval", f)))
    return Finding(
        "below zero, times pi",
        lowest,
        verdict,
        text if double else f"{text}; in float32",
        subject.tag(),
        subject.replay(*case, double=double),
        case,
    )


# --- float32 -------------------------------------------------------------------------------------


def promises(subject: Subject) -> list[str]:
    """What a model says of float32: of everything, and of the density alone where it documents that."""
    apart = subject.size("float32_density") is not None
    return ["float32", "float32_density"] if apart else ["float32"]


def _precision(subject: Subject, effort: Effort) -> list[Finding]:
    """The largest relative errors of float32 against float64, on the same float32 inputs, by search."""
    return [_searched(subject, effort, promise) for promise in promises(subject)]


def _searched(subject: Subject, effort: Effort, promise: str) -> Finding:
    size = subject.size(promise)
    # Nothing below what is documented decides anything
    told = TOLD if promise == "float32" or size is None else 0.5 * size.size
    points, _ = maximise(
        lambda p: float32_error(subject, hard_cases(subject, p), told, promise).max(axis=1),
        len(subject.parameters) + EXTRA,
        population=effort.pairs,
        rounds=effort.rounds,
        seed=15,
        starts=random_points(subject, effort.pairs // 2, 5),
        special=special_parts(subject),
    )
    # What is excused has been looked at only where it decides something; for the number, everywhere
    cases = hard_cases(subject, points[:FINALISTS])
    return _worst(subject, effort, cases, promise, float32_error(subject, cases, 0.0, promise))


def _worst(subject: Subject, effort: Effort, cases: Cases, promise: str, errors: Array) -> Finding:
    row, column = np.unravel_index(int(errors.argmax()), errors.shape)
    measured = float(errors[row, column])
    verdict, text = judge(subject, promise, measured, limit=FLOAT32, searched=False)
    case = (cases.parameters[row], cases.wi[row], cases.wo[row])
    return Finding(
        "float32 error",
        measured,
        verdict,
        f"{text}; {NAMES[column]}"
        + (f", less than {TOLD:g} beyond roundings of the parameters" if measured < TOLD else "")
        + (_horizon(case[1], case[2]) if verdict == FAIL else ""),
        subject.tag(),
        subject.replay(*case, double=False, compare="double"),
        case,
    )


def _horizon(wi: Array, wo: Array) -> str:
    """What to do where a half vector is all that is left of two long ones."""
    if max(wi[2], wo[2]) > FLAT or wi[:2] @ wo[:2] > -0.5:
        return ""
    return (
        " at opposite directions in the horizon: if they are turned or scaled before they are added, turn "
        "their half vector instead, which keeps its digits (docs/checking.md)"
    )


def float32_error(
    subject: Subject, cases: Cases, told: float = TOLD, promise: str = "float32"
) -> Array:
    """Relative errors (n, 4 or 7) of BRDF, density and closed-form albedo in float32.

    What a few roundings of the parameters change is left out of errors above `told`: no formula could do
    better with such inputs. What is not finite counts as no error; another finding reports it. So does what
    belongs to another promise: density alone is "float32_density" where a model documents that, of which
    is left out what the density changes within a few float32 of the directions.
    """
    with np.errstate(invalid="ignore", over="ignore"):
        low = _values(subject, cases, single_precision=True)
        high = _values(subject, cases, single_precision=False)
        higher = stored(number_type(), np.maximum(cases.wi[:, 2], cases.wo[:, 2]))
        found = departures(subject, _columns(low), _columns(high), higher, promise)
        dr.eval(found)
        raw, scale = (columns_of(parts) for parts in zip(*found, strict=True))
        error = raw.copy()
        # Most of what roundings explain is explained by a lower bound of their effect as well
        for effect_of in (_rounding_effect_at_least, _rounding_effect):
            rows = np.flatnonzero((error > told * scale).any(axis=1))
            if len(rows):
                few = Cases(cases.parameters[rows], cases.wi[rows], cases.wo[rows], cases.u[rows])
                left = np.maximum(raw[rows] - ROUNDINGS * effect_of(subject, few, high[rows]), 0)
                error[rows] = left
        if promise != "float32":
            rows = np.flatnonzero((error > told * scale).any(axis=1))
            if len(rows):
                few = Cases(cases.parameters[rows], cases.wi[rows], cases.wo[rows], cases.u[rows])
                moved = ROUNDINGS * _effect_of_directions(subject, few, high[rows])
                error[rows] = np.maximum(error[rows] - moved, 0)
        relative = error / scale
    return np.where(np.isfinite(relative), relative, 0)


def _effect_of_directions(subject: Subject, cases: Cases, high: Array) -> Array:
    """What half a float32 epsilon of their length, along x and y of both directions, changes in float64."""
    n = len(cases)
    blocks = []
    for axis, sign, which in itertools.product((0, 1), (1, -1), (0, 1)):
        pair = [cases.wi.copy(), cases.wo.copy()]
        pair[which][:, axis] += sign * 2.0**-24
        blocks.append(pair)
    wi, wo = (np.concatenate([pair[which] for pair in blocks]) for which in (0, 1))
    times = (len(blocks), 1)
    moved = Cases(np.tile(cases.parameters, times), wi, wo, np.tile(cases.u, times))
    found = _values(subject, moved, single_precision=False).reshape(-1, 2, n, high.shape[1])
    # The larger change of both signs' for wi and for wo, and those of both axes together
    change = np.abs(found - high).reshape(2, 2, 2, n, high.shape[1])
    change = np.where(np.isfinite(change), change, 0)
    return np.asarray(change.max(axis=1).sum(axis=(0, 1)))


def departures(
    subject: Subject,
    low: Sequence[Any],
    high: Sequence[Any],
    higher: Any,
    promise: str = "float32",
) -> list[tuple[Any, Any]]:
    """How far float32 is off float64 in each column, and what that is compared with: Dr.Jit arrays.

    Args:
        subject: whose columns (`NAMES`) they are.
        low: what float32 gives, in double precision.
        high: what float64 gives.
        higher: the higher one of the two directions' cosines.
        promise: "float32", or "float32_density" for the density where a model documents that.
    """
    crossing = subject.size("negative") is not None
    clipped = subject.size("unreached") is not None
    apart = subject.size("float32_density") is not None
    higher = dr.maximum(higher, MU_MIN)
    found = []
    for column, (one, exact) in enumerate(zip(low, high, strict=True)):
        error, size = dr.abs(one - exact), dr.abs(exact)
        least = FAR_TAIL  # a float32 ends at 1e-38
        if NAMES[column] == "eval":
            least = ZERO_CROSSING if crossing else least
            error = dr.maximum(error - D_END / higher / higher, 0)
        elif column == DENSITY:
            least = RIM if clipped else least
            error = dr.maximum(error - 0.5 * D_END / higher, 0)
        scale = dr.select(size > 0, dr.maximum(size, least), 1)
        error = dr.select(dr.isfinite(error), error, 0)
        if apart and (column == DENSITY) == (promise == "float32"):
            error = dr.zeros(type(error), dr.width(error))
        found.append((error, scale))
    return found


def _columns(values: NDArray[np.float64]) -> list[Any]:
    return [stored(number_type(), column) for column in values.T]


def _values(
    subject: Subject,
    cases: Cases,
    *,
    single_precision: bool,
    disturb: Callable[[Subject, dict[str, Array]], dict[str, Array]] | None = None,
) -> NDArray[np.float64]:
    """BRDF, density and closed-form albedo, one column each; for parameters that float32 can hold.

    `disturb` gives other values of the parameters, or several blocks of them for the same directions.
    """
    Float = number_type(single_precision)
    values = subject.values(cases.parameters, rounded=True)
    wi, wo = cases.wi, cases.wo
    if disturb is not None and values:
        values = disturb(subject, values)
        blocks = len(next(iter(values.values()))) // len(wi)
        wi, wo = np.tile(wi, (blocks, 1)), np.tile(wo, (blocks, 1))
    n = len(wi)
    if n == 1:  # one row alone would be compiled for itself
        values = {path: np.repeat(v, 2, axis=0) for path, v in values.items()}
        wi, wo = np.repeat(wi, 2, axis=0), np.repeat(wo, 2, axis=0)
    rows = stored(dr.uint32_array_t(Float), np.arange(len(wi), dtype=np.uint32))
    model = subject.bound(gathered(values, rows, Float), Float)
    pair = vectors(Float, wi), vectors(Float, wo)
    dr.make_opaque(pair)
    found = columns(subject, model, *pair)
    dr.eval(found)
    return columns_of(found)[:n].astype(np.float64)


def columns(subject: Subject, model: Any, wi: Any, wo: Any) -> list[Any]:
    """BRDF, density and closed-form albedo of a bound model, one column each (`NAMES`): Dr.Jit arrays."""
    Float = type(wi.x)
    f, pdf = model.eval(wi, wo), Float(model.pdf(wi, wo))
    found = [*dr.replace_shape_t(Float, (3, -1))(f), pdf]
    if subject.albedos == "closed form":
        found += [*dr.replace_shape_t(Float, (3, -1))(model.albedo(wo))]
    zero = dr.zeros(Float, max(dr.width(wi), dr.width(wo)))
    return [value + zero for value in found]


def _beside(free: FreeNumber, value: Array, up: Any, roundings: int = 1) -> Array:
    """A number that is so many halves of a float32 epsilon larger or smaller, inside its range."""
    step = roundings * 2.0**-24
    changed = value * np.where(up, 1 + step, 1 - step)
    return np.clip(changed, free.declared.lowest, free.declared.highest)


def _one_by_one(subject: Subject, values: dict[str, Array]) -> dict[str, Array]:
    """Blocks of the same values, each with one of the numbers changed, for each of WAYS."""
    numbers, n = len(subject.parameters), len(next(iter(values.values())))
    blocks = len(WAYS) * numbers
    found = {path: np.tile(v, (blocks, 1) if v.ndim == 2 else blocks) for path, v in values.items()}
    for (way, (up, roundings)), (number, free) in itertools.product(
        enumerate(WAYS), enumerate(subject.parameters)
    ):
        block = way * numbers + number
        part = number_of(found, free)[block * n : (block + 1) * n]
        part[:] = _beside(free, part, up, roundings)
    return found


def together(subject: Subject, values: dict[str, Array]) -> dict[str, Array]:
    """Blocks of the same values: all numbers a bit larger, all smaller, and every second one so."""
    n = len(next(iter(values.values())))
    found = {path: np.tile(v, (4, 1) if v.ndim == 2 else 4) for path, v in values.items()}
    block = np.repeat(np.arange(4), n)
    for number, free in enumerate(subject.parameters):
        part = number_of(found, free)
        part[:] = _beside(free, part, np.choose(block, [1, 0, number % 2, 1 - number % 2]) == 1)
    return found


def _rounding_effect(subject: Subject, cases: Cases, value: Array) -> Array:
    """Change of the values in float64 by half a float32 epsilon in each parameter.

    Both ways are tried: where something ends in black, one of them may change nothing. So is the change by
    all the roundings that are allowed: where total reflection is that near, one of them may not reach it.
    """
    if not subject.parameters:
        return np.zeros_like(value)
    changed = _values(subject, cases, single_precision=False, disturb=_one_by_one)
    ways = np.abs(changed.reshape(len(WAYS), -1, *value.shape) - value)
    each = [way / roundings for way, (_, roundings) in zip(ways, WAYS, strict=True)]
    return np.asarray(np.max(each, axis=0).sum(axis=0))


def _rounding_effect_at_least(subject: Subject, cases: Cases, value: Array) -> Array:
    """The same by a few evaluations: what all parameters change together is not more."""
    changed = _values(subject, cases, single_precision=False, disturb=together)
    return np.asarray(np.abs(changed.reshape(-1, *value.shape) - value).max(axis=0))
