"""The cases of a long search: made, tried and looked through in one kernel.

Each row of parameters is tried with `LANES` pairs of directions and random numbers, which are made where
they are used; what is written to memory is three numbers for each case. Suspicious ones are made again, for
`gonio.check.finite` and `gonio.check.gradient` to judge.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from gonio import backend
from gonio.check.adversarial import EXTRA, Cases, placed
from gonio.check.finite import LENGTH, columns, departures, promises
from gonio.check.gradient import METHODS, derived
from gonio.check.subject import Array, Subject, columns_of, compute, gathered, stored

# Pairs of directions for each row of parameters.
LANES = 64

# Near a case, this share of its coordinates is moved, by steps between these powers of ten.
MOVED, STEPS = 0.4, (-8.0, -1.0)


@dataclass(frozen=True)
class Rows:
    """Parameters to try, and where their directions and random numbers lie."""

    parameters: Array
    """Rows in [0, 1], (rows, numbers)."""
    near: Array
    """Coordinates of directions and random numbers to look near, (rows, EXTRA); NaN for anywhere."""
    seed: int


@dataclass(frozen=True)
class Screened:
    """What a screen knows of each case."""

    errors: dict[str, Array]
    """The largest relative error of float32, with nothing excused, by the promise it belongs to."""
    steep: NDArray[np.float32]
    """The largest derivative; infinite if one of them is not finite."""
    wrong: NDArray[np.bool_]
    """Whether a value is not finite, or negative, or a sampled direction not of unit length."""


def screen(subject: Subject, rows: Rows, count: int) -> Screened:
    """Try `count` cases: `LANES` pairs of directions for one row after the other."""
    module = compute()
    lane = dr.arange(module.UInt, count)
    wi, wo, u = placed(_coordinates(rows, lane))
    values = subject.values(rows.parameters, rounded=True)
    single = gathered(values, lane // LANES, module.Float)
    double = gathered(values, lane // LANES, module.Float64)
    given = {"wi": _single(wi), "wo": _single(wo), "u": _single(u)}

    steep = dr.zeros(module.Float, count)
    if subject.differentiable:
        for gradient in _gradients(subject, single, given):
            size = dr.select(dr.isfinite(gradient), dr.abs(gradient), dr.inf)
            steep = dr.maximum(steep, size)

    model = subject.bound(single, module.Float)
    low = columns(subject, model, given["wi"], given["wo"])
    sampled, density = model.sample(given["wo"], given["u"])
    good = (density >= 0) & dr.isfinite(density) & (low[len(sampled)] >= 0)
    good &= dr.abs(dr.norm(dr.replace_shape_t(module.Float64, (3, -1))(sampled)) - 1) < LENGTH
    for value in low:
        good &= dr.isfinite(value)
    if subject.size("negative") is None:
        for value in low[: len(sampled)]:
            good &= value >= 0

    high = columns(subject, subject.bound(double, module.Float64), wi, wo)
    low = [module.Float64(value) for value in low]
    errors = {promise: dr.zeros(module.Float64, count) for promise in promises(subject)}
    for promise in errors:
        for departure, scale in departures(subject, low, high, dr.maximum(wi.z, wo.z), promise):
            errors[promise] = dr.maximum(errors[promise], departure / scale)
    dr.eval(errors, steep, good)
    found = {promise: error.numpy() for promise, error in errors.items()}
    return Screened(found, steep.numpy(), ~good.numpy())


def _gradients(subject: Subject, values: dict[str, Any], given: dict[str, Any]) -> Iterator[Any]:
    """Derivatives of each method by each number, as `gonio.check.gradient` takes them."""
    module = backend.array_module()
    for method, names in METHODS.items():
        leaves = {path: _differentiable(module, value) for path, value in values.items()}
        args = [_differentiable(module, given[name]) for name in names]
        for gradient in derived(subject, leaves, args, method, module.Float).values():
            plain = dr.detach(gradient, preserve_type=False)
            yield from [plain] if dr.depth_v(plain) == 1 else plain


def cases(subject: Subject, rows: Rows, chosen: NDArray[np.intp]) -> Cases:
    """The cases of these numbers, for the checks."""
    wi, wo, u = placed(_coordinates(rows, stored(compute().UInt, chosen)))
    dr.eval(wi, wo, u)
    return Cases(rows.parameters[chosen // LANES], columns_of(wi), columns_of(wo), columns_of(u))


def places(rows: Rows, chosen: NDArray[np.intp]) -> Array:
    """The coordinates of the cases of these numbers, (cases, EXTRA)."""
    t = _coordinates(rows, stored(compute().UInt, chosen))
    dr.eval(t)
    return columns_of(t)


def _coordinates(rows: Rows, lane: Any) -> list[Any]:
    """The coordinates of directions and random numbers of the cases that `lane` names."""
    module = compute()
    generator = module.Philox4x32(dr.opaque(module.UInt64, rows.seed), lane)
    random = [x for _ in range(EXTRA // 2 + 1) for x in generator.next_float64x2()]
    table = stored(module.Float64, np.resize(rows.near, (max(len(rows.near), 2), EXTRA)).ravel())
    step = dr.power(10.0, dr.lerp(*STEPS, random[EXTRA]))
    found = []
    for number, x in enumerate(random[:EXTRA]):
        near = dr.gather(module.Float64, table, lane // LANES * EXTRA + number)
        # One random number says whether it moves, and how far
        moved = near + dr.select(x < MOVED, step * (2 / MOVED * x - 1), 0)
        found.append(dr.select(dr.isfinite(near), dr.clip(moved, 0, 1), x))
    return found


def _single(value: Any) -> Any:
    return dr.replace_shape_t(compute().Float, (len(value), -1))(value)


def _differentiable(module: Any, value: Any) -> Any:
    if dr.depth_v(value) == 1:
        return module.Float(value)
    return dr.replace_shape_t(module.Float, (len(value), -1))(value)
