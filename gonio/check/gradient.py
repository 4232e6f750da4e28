"""Derivatives: finite at hard parameters, float32's like float64's, and these like central differences."""

from __future__ import annotations

import functools
import time
from collections.abc import Sequence
from typing import Any

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from gonio import backend
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
from gonio.check.kernels import evaluate, reflect
from gonio.check.no_number import said
from gonio.check.report import FAIL, PASS, UNSURE, Effort, Finding, Report
from gonio.check.search import maximise
from gonio.check.subject import (
    Array,
    FreeNumber,
    Subject,
    columns_of,
    directions,
    gathered,
    number_of,
    number_type,
    stored,
    vectors,
)
from gonio.horizon import MU_STEEP
from gonio.lang import MU_MIN

# Steps of the differences, relative to the parameter or to its range.
STEP = 1e-6

# Central differences of float64 have about this error; where two steps differ by more than it, the place
# is a kink or too sharp, and that difference is allowed as well.
DIFFERENCES = 1e-4
ALLOWED = 4.0

# Pairs of directions at which derivatives are compared.
PAIRS = 3000

# One number for three channels or coordinates, in which each can be told from the others.
MIXED = np.array([1.0, 0.7, 0.4])

# Every so many of the hard pairs do for two options together, each of which has been looked at by itself.
BRIEF = 8

# What derivatives in float32 may be off by, relative to them and to a thousandth of the value, at all but
# one in a hundred of the pairs: those are in sharp lobes, or both directions graze below 1e-5. Where
# derivative and value are below FAINT nobody sees them.
IN_FLOAT32, ALL_BUT, FAINT = 0.02, 0.99, 1e-5

# So many may lie too near to a kink, or in a lobe too sharp, for differences to tell; with fewer nothing is
# said.
TOLD = 0.5


def check(subject: Subject, effort: Effort) -> Report:
    """Derivatives with respect to every parameter, both directions and the random numbers."""
    start = time.perf_counter()
    findings = []
    if subject.differentiable and (effort.derivatives or not subject.tag()):
        findings = [_finite(subject, effort)]
        if subject.parameters and not effort.briefly:
            findings.append(_differences(subject))
        if not effort.briefly:
            findings.append(_in_float32(subject))
    return Report("gradient", subject.name, tuple(findings), time.perf_counter() - start)


def leaves(subject: Subject, parameters: Array, Float: Any, rounded: bool) -> dict[str, Any]:
    """Values of the free parameters as Dr.Jit arrays."""
    return {
        path: vectors(Float, v) if v.ndim == 2 else stored(Float, v)
        for path, v in subject.values(parameters, rounded).items()
    }


METHODS = {"eval": ("wi", "wo"), "pdf": ("wi", "wo"), "sample": ("wo", "u")}

# What has closed forms beside those, and takes part in fits: looked at where a search is not worth it.
CLOSED: dict[str, tuple[str, ...]] = {"albedo": ("wo",), "mean_albedo": ()}


def _inputs(method: str) -> tuple[str, ...]:
    return METHODS[method] if method in METHODS else CLOSED[method]


def closed(subject: Subject) -> list[str]:
    """The albedos of a model that are closed forms."""
    found = ["albedo"] if subject.albedos == "closed form" else []
    return [*found, "mean_albedo"] if subject.mean_closed else found


def gradients(
    subject: Subject,
    cases: Cases,
    method: str,
    single_precision: bool = True,
    rounded: bool = True,
) -> dict[str, NDArray[Any]]:
    """Derivatives of a method's sum (for `sample` that of density and direction), by name.

    With `rounded` for parameters that float32 can hold, also in double precision.
    """
    module = backend.array_module()
    Float = module.Float if single_precision else module.Float64
    given = {"wi": cases.wi, "wo": cases.wo, "u": cases.u}
    values = leaves(subject, cases.parameters, Float, rounded)
    names = _inputs(method)
    args = [vectors(Float, given[name]) for name in names]
    found = {}
    derivatives = derived(subject, values, args, method, Float)
    dr.eval(derivatives)  # together, in one kernel
    for name, derivative in derivatives.items():
        gradient = np.atleast_2d(np.array(derivative))
        found[name] = np.broadcast_to(gradient, (len(gradient), len(cases)))
    return found


def derived(
    subject: Subject, values: dict[str, Any], args: list[Any], method: str, Float: Any
) -> dict[str, Any]:
    """Derivatives of a method's sum, by name, as Dr.Jit arrays that are not evaluated yet.

    Args:
        subject: whose method it is.
        values: of the parameters, by their paths: arrays that can be differentiated.
        args: directions and random numbers, in the order of METHODS or CLOSED.
        method: of METHODS or CLOSED.
        Float: the arrays' type of numbers.
    """
    dr.enable_grad(values, args)
    result = getattr(subject.bound(values, Float), method)(*args)
    value = result
    if method == "sample":
        # What is not finite in one of them is not finite in their sum
        wi, density = result
        value = density + sum(float(m) * w for w, m in zip(wi, MIXED, strict=True))
    # The sum over the cases is not taken: it would be computed at once, in a kernel of its own.
    total = value if dr.depth_v(value) == 1 else dr.sum(value, axis=0)
    if not dr.grad_enabled(total):
        return {}  # constant, such as Lambert's density with respect to nothing
    # Not everything depends on a parameter: a cosine sampler, say, on none.
    dr.backward(total, flags=dr.ADFlag.Default | dr.ADFlag.AllowNoGrad)
    inputs = {**values, **dict(zip(_inputs(method), args, strict=True))}
    return {name: dr.grad(value) for name, value in inputs.items()}


def _steepest(subject: Subject, cases: Cases, method: str) -> Array:
    """The largest derivative of each case as a power of ten; infinite if it is not finite."""
    top = np.zeros(len(cases))
    with np.errstate(invalid="ignore", over="ignore"):
        for gradient in gradients(subject, cases, method).values():
            size = np.abs(gradient.astype(np.float64)).max(axis=0)
            top = np.maximum(top, np.where(np.isfinite(size), size, np.inf))
        return np.asarray(np.log10(np.maximum(top, 1e-45)))


def _steepest_at(subject: Subject, method: str, points: Array) -> Array:
    return _steepest(subject, hard_cases(subject, points, MU_MIN), method)


def _finite(subject: Subject, effort: Effort) -> Finding:
    # Below the horizon there are no values, and so no derivatives
    step = BRIEF if effort.briefly else 1
    wi, wo = (w.astype(np.float64)[::step] for w in hard_pairs(MU_MIN))
    more = hard_cases(subject, random_points(subject, effort.cases, 6), MU_MIN)
    cases = Cases(
        np.concatenate([hard_parameters(subject, len(wi), 6), more.parameters]),
        np.concatenate([wi, more.wi]),
        np.concatenate([wo, more.wo]),
        np.concatenate([hard_numbers(len(wi), 8).astype(np.float64), more.u]),
    )
    wrong: list[tuple[str, NDArray[Any]]] = []
    worst: tuple[Cases, int, str] | None = None
    for method in [*METHODS, *([] if effort.briefly else closed(subject))]:
        tried = cases
        searched = method in METHODS and not effort.briefly
        if searched and np.isfinite(_steepest(subject, cases, method)).all():
            # The steepest place is searched for; it leads to where something overflows
            points, _ = maximise(
                functools.partial(_steepest_at, subject, method),
                len(subject.parameters) + EXTRA,
                population=effort.cases,
                rounds=max(effort.rounds // 3, 4),
                seed=16,
                special=special_parts(subject),
            )
            tried = hard_cases(subject, points[:256], MU_MIN)
        for name, gradient in gradients(subject, tried, method).items():
            bad = np.flatnonzero(~np.isfinite(gradient).all(axis=0))
            if len(bad):
                wrong.append((f"d {method} / d {name}", gradient[:, bad[0]]))
                worst = (tried, int(bad[0]), method) if worst is None else worst
    if worst is None:
        albedo = "" if effort.briefly or not closed(subject) else ", albedo"
        text = (
            f"derivatives of eval, pdf, sampled directions and densities{albedo} finite at "
            f"{len(cases)} hard cases{'' if effort.briefly else ' and in a search'}"
        )
        return Finding("not finite", 0.0, PASS, text, subject.tag())
    tried, row, method = worst
    case = (tried.parameters[row], tried.wi[row], tried.wo[row])
    u = tried.u[row] if method == "sample" else None
    return Finding(
        "not finite",
        float(len(wrong)),
        FAIL,
        said(*wrong),
        subject.tag(),
        subject.replay(*case, double=False, u=u, derivatives=True),
        case,
    )


def _differences(subject: Subject) -> Finding:
    rng = np.random.default_rng(9)
    where = 0.02 + 0.96 * rng.random((PAIRS, len(subject.parameters)))
    wi, wo = (directions(_cosines(rng), 2 * np.pi * rng.random(PAIRS)) for _ in range(2))
    Float = backend.array_module().Float64
    values = leaves(subject, where, Float, False)
    dr.enable_grad(values)
    f = subject.bound(values, Float).eval(vectors(Float, wi), vectors(Float, wo))
    f = dr.replace_shape_t(Float, (3, -1))(f)
    total = sum((c * float(m) for c, m in zip(f, MIXED, strict=True)), dr.zeros(Float, PAIRS))
    dr.backward(dr.sum(total), flags=dr.ADFlag.Default | dr.ADFlag.AllowNoGrad)
    derivatives = {path: dr.grad(v) + dr.zeros(type(v), PAIRS) for path, v in values.items()}
    dr.eval(derivatives, total)
    level = np.abs(np.array(dr.detach(total)))
    found = {path: np.atleast_2d(np.array(d)) for path, d in derivatives.items()}

    plain = subject.values(where)
    worst, worst_row, worst_name, told, fault = 0.0, 0, "", 1.0, ""
    differences = central_differences(subject, plain, wi, wo, MIXED)
    for free, (near, far) in zip(subject.parameters, differences, strict=True):
        x, span = number_of(plain, free), _span(free)
        exact = found[free.path][free.channel]
        unsure = np.abs(near - far)
        # What a parameter changes over its own size is the scale: less is lost in the roundings
        scale = np.abs(near) + 1e-3 * level / np.maximum(np.abs(x), 0.1 * span) + 1e-9
        error = np.maximum(np.abs(exact - near) - ALLOWED * unsure, 0) / scale
        error = np.where(np.isfinite(exact) & np.isfinite(error), error, np.inf)
        told = min(told, float(np.mean(unsure < DIFFERENCES * scale)))
        if not error.max() <= worst:
            worst, worst_row, worst_name = float(error.max()), int(error.argmax()), free.path
            named = (f"d eval / d {free.path}", exact[worst_row]), ("eval", level[worst_row])
            fault = said(*named, ("its central difference", near[worst_row]))
    case = (where[worst_row], wi[worst_row], wo[worst_row])
    if not worst <= DIFFERENCES:
        verdict = FAIL
        text = fault or f"d eval / d {worst_name} is not the central difference"
    elif told < TOLD:
        verdict = UNSURE
        text = f"only {100 * told:.0f} % of the pairs are smooth enough for differences to tell"
    else:
        verdict, text = PASS, f"at most {DIFFERENCES:g} is allowed"
    return Finding(
        "off central differences",
        worst,
        verdict,
        text,
        subject.tag(),
        subject.replay(*case, derivatives=True),
        case,
    )


def _in_float32(subject: Subject) -> Finding:
    """Derivatives in float32 beside those in float64, by every parameter and both directions."""
    rng = np.random.default_rng(9)
    where = 0.02 + 0.96 * rng.random((PAIRS, len(subject.parameters)))
    wi, wo = (
        directions(_cosines(rng), 2 * np.pi * rng.random(PAIRS)).astype(np.float32).astype(float)
        for _ in range(2)
    )
    cases = Cases(where, wi, wo, np.zeros((PAIRS, 2)))
    index = np.arange(PAIRS, dtype=np.uint32)
    f, pdf = evaluate(subject, where, index, wi, wo, rounded=True)
    levels = {"eval": np.abs(f.sum(axis=1)), "pdf": np.abs(pdf)}
    worst, worst_row, worst_name, fault = 0.0, 0, "eval / d wi", ""
    for method, level in levels.items():
        low = gradients(subject, cases, method)
        for name, exact in gradients(subject, cases, method, single_precision=False).items():
            size = np.abs(exact).max(axis=0) + 1e-3 * level + FAINT
            error = np.abs(low[name].astype(np.float64) - exact).max(axis=0) / size
            error = np.where(np.isfinite(error), error, np.inf)
            off = float(np.quantile(error, ALL_BUT, method="lower"))
            if not off <= worst:
                worst, worst_row = off, int(error.argmax())
                worst_name = f"{method} / d {name}"
                ends = ("float32", low[name]), ("float64", exact)
                named = [(f"d {worst_name} in {p}", g[:, worst_row]) for p, g in ends]
                fault = said(*named, (method, level[worst_row]))
    case = (where[worst_row], wi[worst_row], wo[worst_row])
    verdict = PASS if worst <= IN_FLOAT32 else FAIL
    text = f"at most {IN_FLOAT32:g} is allowed at all but 1 % of the pairs; d {worst_name}"
    text = fault if fault and verdict == FAIL else text
    replay = subject.replay(*case, double=False, derivatives=True)
    return Finding("off in float32", worst, verdict, text, subject.tag(), replay, case)


def _cosines(rng: np.random.Generator) -> Array:
    """From grazing to the normal; a third of them by powers of ten down to where derivatives end."""
    high = 0.02 + 0.97 * rng.random(PAIRS)
    grazing = 10 ** rng.uniform(np.log10(1.1 * MU_STEEP), np.log10(0.02), PAIRS)
    return np.where(rng.random(PAIRS) < 1 / 3, grazing, high)


# Places of the differences, in steps.
SHIFTS = (1.0, -1.0, 2.0, -2.0)


def _span(free: FreeNumber) -> float:
    return min(free.declared.high - free.declared.low, 1.0)


def central_differences(
    subject: Subject, plain: dict[str, Array], wi: Array, wo: Array, weights: Array
) -> list[tuple[Array, Array]]:
    """Of a weighted sum of eval's channels, by each number: (rows,) with a step, and with twice that."""
    steps = [
        STEP * np.maximum(np.abs(number_of(plain, free)), 0.1 * _span(free))
        for free in subject.parameters
    ]
    moved = _moved(subject, plain, steps, wi, wo, weights)
    one, other = (
        [
            (shifted[SHIFTS.index(k)] - shifted[SHIFTS.index(-k)]) / (2 * k * step)
            for step, shifted in zip(steps, moved, strict=True)
        ]
        for k in (1.0, 2.0)
    )
    return list(zip(one, other, strict=True))


def _moved(
    subject: Subject,
    plain: dict[str, Array],
    steps: Sequence[Array],
    wi: Array,
    wo: Array,
    weights: Array,
) -> Array:
    """Values at the places of the differences for each number, (numbers, shifts, rows), in one batch."""
    Float = number_type()
    n, blocks = len(wi), len(steps) * len(SHIFTS)
    values = {path: np.tile(v, (blocks, 1) if v.ndim == 2 else blocks) for path, v in plain.items()}
    for number, (free, step) in enumerate(zip(subject.parameters, steps, strict=True)):
        rows = slice(number * len(SHIFTS) * n, (number + 1) * len(SHIFTS) * n)
        number_of(values, free)[rows] += np.outer(SHIFTS, step).ravel()
    index = stored(dr.uint32_array_t(Float), np.arange(n * blocks, dtype=np.uint32))
    model = subject.bound(gathered(values, index, Float), Float)
    both = (vectors(Float, np.tile(w, (blocks, 1))) for w in (wi, wo))
    f, _ = reflect(model, *both)
    return np.asarray(columns_of(f) @ weights).reshape(len(steps), len(SHIFTS), n)
