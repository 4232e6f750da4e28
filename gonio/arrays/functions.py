"""Functions written in the language of models, of a model and of arrays."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import drjit as dr
import numpy as np
from numpy.typing import ArrayLike, NDArray

from gonio import backend
from gonio.arrays.kernel import Evaluated, opaque
from gonio.fields import Parameter, is_array


def applied(
    function: Callable[..., Any],
    model: Evaluated,
    values: Sequence[ArrayLike],
    *,
    width: int = 3,
    dtype: type[np.generic] = np.float64,
) -> NDArray[Any]:
    """What a function gives for a model and for numbers or vectors, one row after the other.

    Args:
        function: of the bound model and of as many values as there are.
        model: whose parameters may be arrays of the rows' number.
        values: shape (rows,) or (1,) for numbers, (rows, 3) or (1, 3) for vectors.
        width: of the result.
        dtype: float32 or float64, in which it is computed.

    Returns:
        Shape (rows, width).
    """
    arrays = [np.ascontiguousarray(v, dtype) for v in values]
    given = {path: value for path, _, value in model.parameters() if is_array(value)}
    rows = max([len(a) for a in arrays] + [np.asarray(v).shape[0] for v in given.values()])
    module = backend.array_module()
    if module is dr.scalar:
        return _one_by_one(function, model, arrays, width, rows)
    Number = module.Float if dtype is np.float32 else module.Float64

    def convert(path: str, parameter: Parameter, value: Any) -> Any:
        if path not in given:
            return opaque(Number, parameter.width, value)
        return _value(Number, np.ascontiguousarray(value, dtype))

    bound = model.bind(Number, convert, keep=False)
    result = function(bound, *(_value(Number, a) for a in arrays))
    kind = Number if width == 1 else dr.replace_shape_t(Number, (width, -1))
    wide = kind(result) + dr.zeros(kind, rows)
    return np.asarray(wide.numpy()).reshape(width, rows).T


def _value(Number: Any, array: NDArray[Any]) -> Any:
    if array.ndim == 1:
        return Number(array)
    columns = (Number(np.ascontiguousarray(c)) for c in array.T)
    return dr.replace_shape_t(Number, (array.shape[1], -1))(*columns)


def _one_by_one(
    function: Callable[..., Any],
    model: Evaluated,
    arrays: Sequence[NDArray[Any]],
    width: int,
    rows: int,
) -> NDArray[Any]:
    """In plain Python: slow, but it needs no compiler."""
    types = {1: float, 2: dr.scalar.Array2f64, 3: dr.scalar.Array3f64}
    found = np.empty((rows, width))

    def at(array: Any, row: int) -> Any:
        value = np.asarray(array, np.float64)[min(row, len(array) - 1)]
        return types[value.size](value.tolist())

    for row in range(rows):

        def convert(path: str, parameter: Parameter, value: Any, row: int = row) -> Any:
            return at(value, row) if is_array(value) else opaque(float, parameter.width, value)

        bound = model.bind(float, convert, keep=False)
        found[row] = function(bound, *(at(a, row) for a in arrays))
    return found
