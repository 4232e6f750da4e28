"""Proof of lit exports: rows for points in any frame, a host by formulas, and what Python computes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from gonio.export.buffer import Buffer
from gonio.export.coded import CodedTable
from gonio.export.entry import Entry, Export
from gonio.export.lookups import TABLES, object_name
from gonio.export.printer import Printer
from gonio.export.prove.harness import CODE, STAND_IN, input_columns, lit_columns, point_column
from gonio.export.prove.rows import rows_for, with_parameters
from gonio.export.prove.tabled import TabledModel
from gonio.export.prove.tools import Rows
from gonio.export.read import Reader
from gonio.export.table_text import reading
from gonio.export.targets import TARGETS, Target
from gonio.export.tree import Function
from gonio.lights import stand_ins
from gonio.lights.lookups import Lookups
from gonio.lights.shading import shade
from gonio.model import Model

# Share of the frames whose normal lies in an axis; the others are turned in every way.
AXES = 0.3

# Smallest cosine of light and view. A direction of the world is rounded by 6e-8 in every component, which a
# frame makes an error of the cosine.
GRAZING = 3e-3


def lit_rows(model: Model, entry: Entry, count: int, seed: int = 0) -> Rows:
    """Rows of inputs: the model's own, turned into frames of all directions, and what lights take."""
    rows = rows_for(model, entry.members, count, seed)
    rng = np.random.default_rng(seed + 1)
    z = rng.normal(size=(count, 3))
    z /= np.linalg.norm(z, axis=1, keepdims=True)
    z[rng.random(count) < AXES] = 0, 0, 1
    # Tangents are neither unit nor level
    tangent = rng.normal(size=(count, 3))
    x = tangent - np.sum(tangent * z, axis=1, keepdims=True) * z
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    frame = np.stack([x, np.cross(z, x), z], axis=1)
    light, view = (np.einsum("nij,ni->nj", frame, _off_horizon(rows[:, a : a + 3])) for a in (0, 3))
    columns: dict[str, Any] = {"normal": z * rng.uniform(0.5, 2, (count, 1)), "tangent": tangent}
    columns |= {"view": view, "light": light}
    made = [columns.get(n, rng.uniform(0.1, 2, (count, w))) for n, w in lit_columns(entry).items()]
    return np.concatenate([rows, *made], axis=1).astype(np.float32)


def _off_horizon(w: Rows) -> npt.NDArray[Any]:
    """Directions that a turned frame can still tell from the horizon: above it, or below."""
    z = np.where(w[:, 2] > 0, np.maximum(w[:, 2], GRAZING), np.minimum(w[:, 2], -GRAZING))
    lifted = np.concatenate([w[:, :2].astype(np.float64), z[:, None]], axis=1)
    return np.asarray(lifted / np.linalg.norm(lifted, axis=1, keepdims=True))


def shaded(
    model: Model, entry: Entry, lights: Sequence[str], rows: Rows, dtype: Any
) -> npt.NDArray[Any]:
    """What Python computes for the rows, in a precision."""
    given, column = {}, point_column(entry)
    for name, width in lit_columns(entry).items():
        values = rows[:, column : column + width].astype(dtype)
        given[name] = values if width == 3 else values.reshape(len(rows), -1, 3)
        if width == 1:
            given[name] = values[:, 0]
        column += width
    bound = with_parameters(model, entry.members, rows[:, : point_column(entry)], dtype)
    if isinstance(bound, TabledModel):
        return bound.shade(dtype, **given)
    return shade(bound, lights, **given, host=stand_ins.StandIn(), dtype=dtype)


def codes(export: Export) -> Rows:
    """The tables that the host has to look up, one after the other; none of other exports."""
    return np.concatenate([np.zeros(0, np.float32), *(t.codes.ravel() for t in _asked(export))])


def _asked(export: Export) -> list[CodedTable]:
    tables = export.tables.all if export.tables is not None else ()
    return [t for t in tables if any(n.endswith(f"_{t.kind}_table") for n in export.entry.lookups)]


def _readers(export: Export, target: Target, reader: Reader, start: int) -> list[str]:
    """Functions that look tables up in the buffer, from an entry on."""
    lines = []
    if target.name == "glsl":
        lines = [f"float {CODE}(int k);", ""]
    for table in _asked(export):
        function = reader.lookup(vars(Lookups)[f"{table.kind}_table"])
        printer = Printer(target, export.entry.prefix, [function])
        lines += [*reading(printer, function, table, f"{CODE}({start} + {{}})".format), ""]
        start += table.codes.size
    return lines


def with_stand_ins(export: Export, rows: int = 0) -> Export:
    """The export with its pictures defined: of light by formulas, of F and D from behind the rows.

    It was made without textures.
    """
    entry = export.entry
    if not entry.lookups and not entry.hosted:
        return export
    target = TARGETS[{"spirv": "glsl"}.get(export.language, export.language)]
    prefix = "stand_in" if entry.hosted else entry.prefix
    reader = Reader(prefix, target.library)
    functions: list[Function] = []
    tables = _readers(export, target, reader, rows * input_columns(entry))
    for name in entry.lookups:
        if name.endswith(TABLES):
            continue
        plain = name if entry.hosted else name.removeprefix(f"{entry.prefix}_")
        kinds = {"environment": ["vec3", "float"], "split_sum": ["float", "float"]}[plain]
        made = reader.function_for(getattr(stand_ins, plain), kinds)  # type: ignore[arg-type]
        made.name = f"{prefix}_{plain}"
        functions.append(made)
    printer = Printer(target, prefix, functions)
    lines = [*tables, *(line for f in functions for line in [*printer.function(f), ""])]
    if entry.hosted:
        lines += _object(printer, functions, export.buffer)
    text = "\n".join(lines) + "\n"
    if target.foot:
        text = f"namespace {entry.namespace} {{\n{text}}}\n"
    return replace(export, source=f"{export.source}\n{text}")


def _object(printer: Printer, functions: Sequence[Function], tables: Buffer | None) -> list[str]:
    """A struct whose methods are the functions, beside those of tables."""
    base = "" if tables is None else f" : {object_name(tables.prefix, 'Tables')}"
    lines = [f"struct {STAND_IN}{base} {{"]
    for function in functions:
        head = printer.function(function)
        signature = next(line for line in head if not line.startswith("//"))
        name = function.name.removeprefix("stand_in_")
        signature = signature.replace(function.name, name).replace(" {", " const {")
        arguments = ", ".join(n for n, _ in function.parameters)
        lines += [f"    {signature}", f"        return {function.name}({arguments});", "    }"]
    return [*lines, "};"]
