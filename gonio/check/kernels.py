"""A model's methods in batches. They are few, and used by every check, so that each is compiled once.

What a kernel is made of decides whether it is compiled anew: everything that goes in is in memory, and has
at least two elements.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Mapping
from typing import Any

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from gonio.check.subject import Array, Subject, columns_of, gathered, number_type, stored, vectors


@contextlib.contextmanager
def one_thread() -> Iterator[None]:
    """One thread alone: those that wait for the next of many small kernels take more than they give."""
    before = dr.thread_count()
    dr.set_thread_count(1)
    try:
        yield
    finally:
        dr.set_thread_count(before)


def reflect(model: Any, wi: Any, wo: Any) -> tuple[Any, Any]:
    """BRDF (a Dr.Jit vector) and density at pairs of directions, evaluated."""
    Float = type(wi.x)
    dr.make_opaque(wi, wo)
    zero = dr.zeros(Float, max(dr.width(wi), dr.width(wo)))
    f = dr.replace_shape_t(Float, (3, -1))(model.eval(wi, wo)) + zero
    pdf = Float(model.pdf(wi, wo)) + zero
    dr.eval(f, pdf)
    return f, pdf


def reflect_only(model: Any, wi: Any, wo: Any) -> Any:
    """BRDF alone, for the millions of directions of an integral."""
    Float = type(wi.x)
    dr.make_opaque(wi, wo)
    zero = dr.zeros(Float, max(dr.width(wi), dr.width(wo)))
    f = dr.replace_shape_t(Float, (3, -1))(model.eval(wi, wo)) + zero
    dr.eval(f)
    return f


def sample(model: Any, wo: Any, u: Any) -> tuple[Any, Any]:
    """Sampled directions and the densities that the sampler reports, evaluated."""
    Float = type(wo.x)
    dr.make_opaque(wo, u)
    wi, pdf = model.sample(wo, u)
    zero = dr.zeros(Float, max(dr.width(wo), dr.width(u)))
    wi, pdf = dr.replace_shape_t(Float, (3, -1))(wi) + zero, Float(pdf) + zero
    dr.eval(wi, pdf)
    return wi, pdf


def evaluate(
    subject: Subject,
    parameters: Array,
    index: NDArray[np.uint32],
    wi: Array,
    wo: Array,
    *,
    single_precision: bool = False,
    rounded: bool = False,
) -> tuple[NDArray[Any], NDArray[Any]]:
    """BRDF (n, 3) and density (n,) for n pairs of directions at the rows that `index` names."""
    Float = number_type(single_precision)
    rows = stored(dr.uint32_array_t(Float), _two(index))
    model = subject.at(parameters, rows, Float, rounded)
    f, pdf = reflect(model, vectors(Float, _two(wi)), vectors(Float, _two(wo)))
    return columns_of(f)[: len(wi)], pdf.numpy()[: len(wi)]


def evaluate_only(
    subject: Subject, parameters: Array, index: NDArray[np.uint32], wi: Array, wo: Array
) -> NDArray[Any]:
    """BRDF (n, 3) alone, in float64, as `evaluate` has it."""
    Float = number_type()
    rows = stored(dr.uint32_array_t(Float), _two(index))
    model = subject.at(parameters, rows, Float)
    f = reflect_only(model, vectors(Float, _two(wi)), vectors(Float, _two(wo)))
    return columns_of(f)[: len(wi)]


def draw(
    subject: Subject,
    parameters: Array,
    index: NDArray[np.uint32],
    wo: Array,
    u: Array,
    *,
    single_precision: bool = False,
) -> tuple[NDArray[Any], NDArray[Any]]:
    """Sampled directions (n, 3) and the densities that the sampler reports (n,)."""
    Float = number_type(single_precision)
    rows = stored(dr.uint32_array_t(Float), _two(index))
    model = subject.at(parameters, rows, Float, single_precision)
    wi, pdf = sample(model, vectors(Float, _two(wo)), vectors(Float, _two(u)))
    return columns_of(wi)[: len(wo)], pdf.numpy()[: len(wo)]


def draw_at(
    subject: Subject,
    values: Mapping[str, Array],
    wo: Array,
    u: Array,
    *,
    single_precision: bool = False,
) -> tuple[NDArray[Any], NDArray[Any]]:
    """The same for values of the parameters by path, a row for each wo."""
    Float = number_type(single_precision)
    rows = stored(dr.uint32_array_t(Float), _two(np.arange(len(wo), dtype=np.uint32)))
    model = subject.bound(gathered(values, rows, Float), Float)
    wi, pdf = sample(model, vectors(Float, _two(wo)), vectors(Float, _two(u)))
    return columns_of(wi)[: len(wo)], pdf.numpy()[: len(wo)]


def albedo(
    subject: Subject, parameters: Array, wo: Array, single_precision: bool = False
) -> NDArray[np.float64]:
    """The model's own albedo (n, 3) at n rows of parameters."""
    Float = number_type(single_precision)
    rows = stored(dr.uint32_array_t(Float), _two(np.arange(len(wo), dtype=np.uint32)))
    model = subject.at(parameters, rows, Float, single_precision)
    return reflected(model, vectors(Float, _two(wo)))[: len(wo)]


def reflected(model: Any, wo: Any) -> NDArray[np.float64]:
    """The albedo (n, 3) of a model that is bound."""
    Float = type(wo.x)
    dr.make_opaque(wo)
    E = dr.replace_shape_t(Float, (3, -1))(model.albedo(wo)) + dr.zeros(Float, dr.width(wo))
    dr.eval(E)
    return columns_of(E).astype(np.float64)


def mean_albedo(
    subject: Subject, parameters: Array, single_precision: bool = False
) -> NDArray[np.float64]:
    """The model's own mean albedo (n, 3)."""
    Float = number_type(single_precision)
    n = len(parameters)
    rows = stored(dr.uint32_array_t(Float), _two(np.arange(n, dtype=np.uint32)))
    model = subject.at(parameters, rows, Float, single_precision)
    E = dr.replace_shape_t(Float, (3, -1))(model.mean_albedo()) + dr.zeros(Float, len(rows))
    dr.eval(E)
    return columns_of(E).astype(np.float64)[:n]


def _two(values: NDArray[Any]) -> NDArray[Any]:
    """Rows that are two at least: one alone would be compiled for itself."""
    return np.repeat(values, 2, axis=0) if len(values) == 1 else values
