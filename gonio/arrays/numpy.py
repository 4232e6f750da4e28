"""NumPy arrays in and out."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import drjit as dr
import numpy as np

from gonio import backend
from gonio.arrays.kernel import DIRECTION_NAMES, Kernel, precision, repack
from gonio.arrays.leaf import UNIT_TOLERANCE, complaint
from gonio.lang import Sample


def call_numpy(kernel: Kernel, values: Sequence[Any]) -> Any:
    """Evaluate a kernel on NumPy arrays."""
    dtype = precision(values)
    arrays = [np.ascontiguousarray(v, dtype) for v in values]
    shapes = [v.shape for v in values]  # ascontiguousarray makes 0-d arrays 1-d
    return repack(kernel, run(kernel, arrays, shapes, dtype))


def run(
    kernel: Kernel,
    arrays: Sequence[np.ndarray[Any, Any]],
    shapes: Sequence[tuple[int, ...]],
    dtype: type[np.generic],
) -> list[np.ndarray[Any, Any]]:
    """The results on contiguous arrays, for the frameworks that hand theirs over through NumPy."""
    module = backend.array_module()
    if module is dr.scalar:
        return _run_scalar(kernel, arrays, shapes, dtype)
    Float = module.Float if dtype is np.float32 else module.Float64
    if math.prod(kernel.batch_shape(shapes)) == 0:
        return empty(kernel, shapes, dtype)
    flats = [Float(a.reshape(-1)) for a in arrays]
    results, result_shapes, flag = kernel.evaluate(flats, shapes, Float)
    dr.eval(results, flag)
    kernel.complain(flag, lambda place: arrays[place].reshape(shapes[place]))
    # NumPy keeps the results' memory alive; nobody else refers to it.
    return [r.numpy().reshape(s) for r, s in zip(results, result_shapes, strict=True)]


def empty(
    kernel: Kernel, shapes: Sequence[tuple[int, ...]], dtype: type[np.generic]
) -> list[np.ndarray[Any, Any]]:
    """Results full of zeros."""
    batch = kernel.batch_shape(shapes)
    widths = {"pdf": (1,), "sample": (3, 1)}.get(kernel.method, (3,))
    return [np.zeros((*batch, w) if w > 1 else batch, dtype) for w in widths]


def _run_scalar(
    kernel: Kernel,
    arrays: Sequence[np.ndarray[Any, Any]],
    shapes: Sequence[tuple[int, ...]],
    dtype: type[np.generic],
) -> list[np.ndarray[Any, Any]]:
    """One element after the other in plain Python: slow, but it needs no compiler."""
    batch = kernel.batch_shape(shapes)
    spread = []
    for leaf, array, shape in zip(kernel.leaves, arrays, shapes, strict=True):
        array = array.reshape(shape)
        if backend.validating():
            value = array if leaf.width == 1 else np.moveaxis(array, -1, 0)
            if leaf.kind == "direction":
                with np.errstate(invalid="ignore", over="ignore"):
                    good = np.abs((value.astype(np.float64) ** 2).sum(0) - 1) <= UNIT_TOLERANCE
            else:
                low, high = (0, 1) if leaf.kind == "random" else (leaf.low, leaf.high)
                good = (value >= low) & (value <= high)
            if not good.all():
                raise ValueError(complaint(leaf, array))
        spread.append(np.broadcast_to(array, (*batch, leaf.width) if leaf.width > 1 else batch))
    outputs = empty(kernel, shapes, dtype)
    types = {1: float, 2: dr.scalar.Array2f64, 3: dr.scalar.Array3f64}
    count = len(DIRECTION_NAMES[kernel.method])
    for index in np.ndindex(batch):
        values = [
            types[leaf.width](a[index].tolist())
            for leaf, a in zip(kernel.leaves, spread, strict=True)
        ]
        bound = kernel.bind(float, values)
        result = getattr(bound, kernel.method)(*values[:count])
        for output, part in zip(
            outputs, result if isinstance(result, Sample) else (result,), strict=True
        ):
            output[index] = part
    return outputs
