"""Tables that a model looks up: numbers that belong to its class or module, read by `fetch`.

A kernel gathers them from an array, a shader reads them from a buffer that its host binds
(`gonio.export.buffer`). What lies between two entries is written in the language of models.
"""

from __future__ import annotations

from typing import Any

import drjit as dr
import numpy as np
from numpy.typing import ArrayLike

from gonio.lang import Color, Float

# Places are numbers of single precision. Shaders add a half and cut: up to here that sum is exact.
COUNT_MAX = 1 << 23


class Table:
    """Numbers, or colours, one after the other; on a device as soon as a kernel asks for them."""

    def __init__(
        self, name: str, values: ArrayLike, *, colours: bool = False, doc: str = ""
    ) -> None:
        """Take numbers.

        Args:
            name: what shaders call its lookup, after the model's prefix: lower-case words joined by `_`.
            values: any shape, row after row; of colours the last axis has 3 components.
            colours: whether an entry is a colour.
            doc: what the numbers are, and over what; shaders and manifests say it.

        Raises:
            ValueError: colours without three components, or more entries than a number can count.
        """
        array = np.ascontiguousarray(values, np.float32)
        if colours and array.shape[-1:] != (3,):
            raise ValueError(f"the table {name} has the shape {array.shape}; colours end in 3.")
        self.name, self.doc, self.colours = name, doc, colours
        self.shape = array.shape[:-1] if colours else array.shape
        self.values = array.reshape(-1)
        if self.count > COUNT_MAX:
            raise ValueError(f"the table {name} has {self.count} entries; {COUNT_MAX} is the most.")
        self._stored: dict[Any, Any] = {}

    @property
    def count(self) -> int:
        """How many entries there are."""
        return self.values.size // (3 if self.colours else 1)

    def misplaced(self, index: float) -> str:
        """What is said of a place that no entry has."""
        return (
            f"the table {self.name} has no place {index:g}; its places are whole numbers from 0 to "
            f"{self.count - 1}."
        )

    def on(self, Float: Any) -> Any:
        """The numbers as a Dr.Jit array of this type."""
        if Float not in self._stored:
            array = Float(self.values)
            dr.make_opaque(array)
            self._stored[Float] = array
        return self._stored[Float]


def fetch(table: Table, index: Float) -> Float | Color:
    """The number (or colour) at a place of a table; `index` is a whole number that is not negative."""
    if not dr.is_array_v(index):
        at = int(index)
        if at != index or not 0 <= at < table.count:
            raise IndexError(table.misplaced(index))
        if not table.colours:
            return float(table.values[at])
        return dr.scalar.Array3f64(*(float(v) for v in table.values[3 * at : 3 * at + 3]))
    kind = type(index)
    place = dr.uint32_array_t(kind)(index)
    if not table.colours:
        return dr.gather(kind, table.on(kind), place)
    return dr.gather(dr.replace_shape_t(kind, (3, -1)), table.on(kind), place)
