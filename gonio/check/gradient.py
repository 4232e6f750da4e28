"""Derivatives: finite at hard places in float32, and in float64 equal to central differences."""

from __future__ import annotations

import time
from typing import Any

import drjit as dr
import numpy as np

from gonio import backend
from gonio.arrays.kernel import opaque
from gonio.check.adversarial import hard_numbers, hard_pairs, places
from gonio.check.report import FAIL, PASS, Effort, Finding, Report
from gonio.check.subject import (
    Array,
    ModelSubject,
    Subject,
    columns_of,
    directions,
    number_type,
    stored,
    vectors,
)
from gonio.fields import Parameter
from gonio.lang import MU_MIN

# Steps of the differences, relative to the parameter or to its range.
STEP = 1e-6

# Central differences of float64 have about this error; where two steps differ by more than it, the place
# is a kink or too sharp, and that difference is allowed as well.
DIFFERENCES = 1e-4
UNSURE = 4.0

# Places at which derivatives are compared.
PLACES = 3000

# So many may lie too near to a kink, or in a lobe too sharp, for differences to tell.
TOLD = 0.5


def check(subject: Subject, effort: Effort) -> Report:
    """Derivatives with respect to every parameter, both directions and the random numbers."""
    start = time.perf_counter()
    findings = []
    if isinstance(subject, ModelSubject) and (effort.derivatives or not subject.tag()):
        findings = [_finite(subject)]
        if subject.columns:
            findings.append(_differences(subject))
    return Report("gradient", subject.name, tuple(findings), time.perf_counter() - start)


def bound(subject: ModelSubject, values: dict[str, Any], Float: Any) -> Any:
    """The model with Dr.Jit values for its free parameters."""

    def convert(path: str, declared: Parameter, value: Any) -> Any:
        return values[path] if path in values else opaque(Float, declared.width, value)

    return subject.model.bind(Float, convert)


def leaves(subject: ModelSubject, where: Array, Float: Any, rounded: bool) -> dict[str, Any]:
    """Values of the free parameters as Dr.Jit arrays."""
    return {
        path: vectors(Float, v) if v.ndim == 2 else stored(Float, v)
        for path, v in subject.values(where, rounded).items()
    }


def _finite(subject: ModelSubject) -> Finding:
    Float = backend.array_module().Float
    wi, wo = hard_pairs(MU_MIN)
    where = places(len(wi), len(subject.columns), 6)
    u = hard_numbers(len(wi), 8)
    wrong: list[str] = []
    row: int | None = None
    for method, names in {"eval": "wi wo", "pdf": "wi wo", "sample": "wo u"}.items():
        given = {"wi": wi, "wo": wo, "u": u}
        values = leaves(subject, where, Float, True)
        args = [vectors(Float, given[name].astype(np.float64)) for name in names.split()]
        dr.enable_grad(values, args)
        result = getattr(bound(subject, values, Float), method)(*args)
        total = dr.sum(result.pdf if method == "sample" else result, axis=None)
        if not dr.grad_enabled(total):
            continue  # constant, such as Lambert's density with respect to nothing
        # Not everything depends on a parameter: a cosine sampler, say, on none.
        dr.backward(total, flags=dr.ADFlag.Default | dr.ADFlag.AllowNoGrad)
        for name, value in [*values.items(), *zip(names.split(), args, strict=True)]:
            gradient = np.atleast_2d(np.array(dr.grad(value)))
            bad = ~np.isfinite(gradient).all(axis=0)
            if bad.any():
                wrong.append(f"d {method} / d {name}")
                row = int(np.flatnonzero(bad)[0]) if row is None and len(bad) == len(wi) else row
    if not wrong:
        text = f"derivatives of eval, pdf and sample finite at {len(wi)} hard cases"
        return Finding("not finite", 0.0, PASS, text, subject.tag())
    case = None if row is None else (where[row], wi[row].astype(float), wo[row].astype(float))
    return Finding(
        "not finite",
        float(len(wrong)),
        FAIL,
        f"NaN or infinite: {', '.join(wrong)}",
        subject.tag(),
        None if case is None else subject.replay(*case),
        case,
    )


def _differences(subject: ModelSubject) -> Finding:
    rng = np.random.default_rng(9)
    where = 0.02 + 0.96 * rng.random((PLACES, len(subject.columns)))
    wi, wo = (
        directions(0.02 + 0.97 * rng.random(PLACES), 2 * np.pi * rng.random(PLACES))
        for _ in range(2)
    )
    Float = backend.array_module().Float64
    values = leaves(subject, where, Float, False)
    dr.enable_grad(values)
    f = bound(subject, values, Float).eval(vectors(Float, wi), vectors(Float, wo))
    f = dr.replace_shape_t(Float, (3, -1))(f)
    # One number for the three channels, in which each can be told from the others
    total = f.x + 0.7 * f.y + 0.4 * f.z + dr.zeros(Float, PLACES)
    level = np.abs(np.array(dr.detach(total)))
    dr.backward(dr.sum(total), flags=dr.ADFlag.Default | dr.ADFlag.AllowNoGrad)
    found = {
        path: np.atleast_2d(np.array(dr.grad(v) + dr.zeros(type(v), PLACES)))
        for path, v in values.items()
    }

    plain, fixed = subject.values(where), _Fixed(subject, wi, wo)
    worst, worst_row, worst_name, told = 0.0, 0, "", 1.0
    for column in subject.columns:
        value = plain[column.path]
        x = value if value.ndim == 1 else value[:, column.channel]
        span = min(column.declared.high - column.declared.low, 1.0)
        step = STEP * np.maximum(np.abs(x), 0.1 * span)
        near, far = (
            (_total(fixed, plain, column, k * step) - _total(fixed, plain, column, -k * step))
            / (2 * k * step)
            for k in (1.0, 2.0)
        )
        exact = found[column.path][column.channel]
        unsure = np.abs(near - far)
        # What a parameter changes over its own size is the scale: less is lost in the roundings
        scale = np.abs(near) + 1e-3 * level / np.maximum(np.abs(x), 0.1 * span) + 1e-9
        error = np.maximum(np.abs(exact - near) - UNSURE * unsure, 0) / scale
        error = np.where(np.isfinite(exact), error, np.inf)
        told = min(told, float(np.mean(unsure < DIFFERENCES * scale)))
        if error.max() > worst:
            worst, worst_row, worst_name = float(error.max()), int(error.argmax()), column.path
    case = (where[worst_row], wi[worst_row], wo[worst_row])
    if worst > DIFFERENCES:
        verdict, text = FAIL, f"d eval / d {worst_name} is not the central difference"
    elif told < TOLD:
        verdict, text = FAIL, f"only {100 * told:.0f} % of the places are smooth enough to tell"
    else:
        verdict, text = PASS, f"at most {DIFFERENCES:g} is allowed"
    return Finding(
        "off central differences",
        worst,
        verdict,
        text,
        subject.tag(),
        subject.replay(*case),
        case,
    )


class _Fixed:
    """A model and directions, for values at moved parameters."""

    def __init__(self, subject: ModelSubject, wi: Array, wo: Array) -> None:
        self.subject = subject
        self.Float = number_type()
        self.wi, self.wo = vectors(self.Float, wi), vectors(self.Float, wo)


def _total(fixed: _Fixed, plain: dict[str, Array], column: Any, step: Array) -> Array:
    Float = fixed.Float
    moved = dict(plain)
    value = plain[column.path].copy()
    if value.ndim == 1:
        value += step
    else:
        value[:, column.channel] += step
    moved[column.path] = value
    values = {
        path: vectors(Float, v) if v.ndim == 2 else stored(Float, v) for path, v in moved.items()
    }
    f = bound(fixed.subject, values, Float).eval(fixed.wi, fixed.wo)
    f = dr.replace_shape_t(Float, (3, -1))(f) + dr.zeros(Float, len(step))
    columns = columns_of(f, Float)
    return np.asarray(columns @ np.array([1.0, 0.7, 0.4]))
