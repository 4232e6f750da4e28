"""Dr.Jit arrays, which pass straight through."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import drjit as dr
import numpy as np

from gonio.arrays.kernel import DIRECTION_NAMES, Kernel
from gonio.arrays.leaf import Leaf
from gonio.fields import framework


def call_drjit(kernel: Kernel, values: Sequence[Any]) -> Any:
    """Dr.Jit arrays pass straight through: nothing is evaluated, copied or checked here."""
    native = next(v for v in values if framework(v) == "drjit")
    Number = type(native)
    while dr.depth_v(Number) > 1:
        Number = dr.value_t(Number)
    Float = Number if dr.is_jit_v(Number) else float
    converted = [
        v if framework(v) == "drjit" else _from_numpy(v, leaf, Number)
        for v, leaf in zip(values, kernel.leaves, strict=True)
    ]
    converted = [
        dr.replace_shape_t(Float, (leaf.width, -1))(v)
        if leaf.width > 1 and Float is not float
        else v
        for v, leaf in zip(converted, kernel.leaves, strict=True)
    ]
    bound = kernel.bind(Float, converted)
    return getattr(bound, kernel.method)(*converted[: len(DIRECTION_NAMES[kernel.method])])


def _from_numpy(value: np.ndarray[Any, Any], leaf: Leaf, Number: Any) -> Any:
    if leaf.width == 1:
        return Number(value.reshape(-1))
    columns = np.moveaxis(value, -1, 0).reshape(leaf.width, -1)
    return dr.replace_shape_t(Number, (leaf.width, -1))(
        *(Number(np.ascontiguousarray(c)) for c in columns)
    )
