"""Models with tables in the place of F and D, for proofs of exports that look them up.

Their eval, and their shade, are the tree of the export run on NumPy arrays, with the table's own
interpolation; everything else is the model's.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from gonio.export.coded import Tables
from gonio.export.entry import Export
from gonio.export.evaluate import Known, Machine
from gonio.export.lit import read_shade
from gonio.export.prove.rows import rows_for
from gonio.export.read import Reader
from gonio.export.tabled import with_tables
from gonio.export.targets import SHADER_LIBRARY
from gonio.export.tree import Function, Struct, Type
from gonio.lights import stand_ins
from gonio.lights.catalogue import chosen
from gonio.model import Model

Array = npt.NDArray[Any]


@dataclass(frozen=True)
class TabledModel:
    """A model whose eval looks tables up."""

    model: Model
    tables: Tables
    function: Function
    """eval, with lookups."""
    lit: Function | None = None
    """shade, with lookups."""
    sky: dict[str, Callable[..., Known]] | None = None
    """What the lights look up."""

    def __getattr__(self, name: str) -> Any:
        """What the model has."""
        return getattr(self.model, name)

    def replace(self, **changes: Any) -> TabledModel:
        """With other parameters; the tables stay."""
        return replace(self, model=self.model.replace(**changes))

    def eval(self, wi: Array, wo: Array) -> Array:
        """As the export computes it."""
        return self._run(self.function, [wi, wo], wi.dtype.type)

    def shade(self, dtype: Any, **given: Array) -> Array:
        """As the export computes it, under the stand-ins' light."""
        assert self.lit is not None
        return self._run(
            self.lit, [_as(kind, given[n]) for n, kind in self.lit.parameters[1:]], dtype
        )

    def _run(self, function: Function, given: Sequence[Known], dtype: Any) -> Array:
        external = {**self.tables.external(), **(self.sky or {})}
        machine = Machine(external, dtype)
        with np.errstate(all="ignore"):
            made = machine.call(function, [_values(self.model, dtype), *given])
        count = max(len(v) for v in given if not isinstance(v, dict))
        return np.asarray(np.broadcast_to(made, (count, made.shape[-1])))


def _as(kind: Type, value: Array) -> Known:
    """An argument of shade; a struct of colours by its members."""
    if not isinstance(kind, Struct):
        return value
    return {member.name: value[:, i] for i, member in enumerate(kind.members)}


def _values(model: Model, dtype: Any) -> dict[str, Known]:
    """The parameters as arrays, inner models as dicts."""
    found: dict[str, Known] = {}
    for name in model.fields:
        value = getattr(model, name)
        if isinstance(value, Model):
            found[name] = _values(value, dtype)
        elif not isinstance(value, str):
            array = np.asarray(value, dtype)
            found[name] = array[None] if array.ndim == 0 or isinstance(value, tuple) else array
    return found


def tabled(model: Model, export: Export) -> TabledModel:
    """The model as its export with tables has it."""
    assert export.tables is not None
    reader = Reader("x", SHADER_LIBRARY, ["x"])
    root = reader.model(model, "x", title="x")
    function = reader.method(root, "eval")
    wanted, lights, lit, sky = [function], [], None, None
    if "shade" in export.entry.functions:
        shade = read_shade(reader, root, chosen(model, export.entry.lights))
        lit, lights = shade.function, shade.lights
        wanted.append(lit)
        sky = {"environment": _stand_in(reader, "environment", ["vec3", "float"])}
        sky["split_sum"] = _stand_in(reader, "split_sum", ["float", "float"])
    with_tables(reader, [root], wanted, export.tables.request, lights)
    return TabledModel(model, export.tables, function, lit, sky)


def _stand_in(reader: Reader, name: str, kinds: list[Any]) -> Callable[..., Known]:
    made = reader.function_for(getattr(stand_ins, name), kinds)
    return lambda *given: Machine().call(made, given)


def price(model: Model, export: Export, count: int) -> str:
    """What the tables change of the material as it is: relative differences of eval in some rows."""
    rows = rows_for(model, (), count)
    wi, wo = rows[:, :3].astype(np.float64), rows[:, 3:6].astype(np.float64)
    exact = np.asarray(model.eval(wi, wo)).reshape(len(rows), -1)
    found = tabled(model, export).eval(wi, wo)
    seen = exact.max(1) > 0
    off = (np.abs(found - exact).max(1) / np.maximum(exact.max(1), 1e-300))[seen]
    if not len(off):
        return "tables change nothing here"
    middle, most = np.quantile(off, [0.5, 0.99])
    return f"tables change the exact value by {middle:.1e} in the median row, {most:.1e} in all but 1 %"
