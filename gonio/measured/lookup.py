"""Tables that a model looks up: numbers that belong to its class, read by `fetch` inside kernels."""

from __future__ import annotations

from typing import Any

import drjit as dr
import numpy as np
from numpy.typing import ArrayLike


class Table:
    """Numbers, or triples of them, one after the other; on a device as soon as a kernel asks for them."""

    def __init__(self, values: ArrayLike, width: int = 1) -> None:
        """Take numbers.

        Args:
            values: any shape; for width 3 the last axis has 3 components.
            width: 1 for numbers, 3 for colours.
        """
        self.values = np.ascontiguousarray(values, np.float32).reshape(-1)
        self.width = width
        self._stored: dict[Any, Any] = {}

    def on(self, Float: Any) -> Any:
        """The numbers as a Dr.Jit array of this type."""
        if Float not in self._stored:
            array = Float(self.values)
            dr.make_opaque(array)
            self._stored[Float] = array
        return self._stored[Float]


def fetch(table: Table, index: Any) -> Any:
    """The number (or colour) at a place of a table; `index` is a whole number that is not negative."""
    if not dr.is_array_v(index):
        at = int(index) * table.width
        if table.width == 1:
            return float(table.values[at])
        return dr.scalar.Array3f64(*(float(v) for v in table.values[at : at + 3]))
    Float = type(index)
    place = dr.uint32_array_t(Float)(index)
    if table.width == 1:
        return dr.gather(Float, table.on(Float), place)
    return dr.gather(dr.replace_shape_t(Float, (3, -1)), table.on(Float), place)
