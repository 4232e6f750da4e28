"""Several materials of one model as one, whose parameter `row` chooses the material in the tables of F.

    metals = together({"gold": gold, "copper": copper})
    tables = Request(("fresnel",), materials=(("gold", gold), ("copper", copper)))
    export({"metals": metals}, "glsl", only=["eval"], tables=tables)

A slot is a place in the code that looks F up. The table has a row of each material for the first slot, then
those for the next: a lookup adds a number to the row, and rows never have others between them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import new_class
from typing import Any

import numpy as np

from gonio.export.coded import FRESNEL, Request
from gonio.export.evaluate import UNKNOWN, Known
from gonio.export.read import same_code
from gonio.export.tree import (
    SELF,
    Access,
    Assign,
    Call,
    ExportError,
    Function,
    Number,
    ReturnIf,
    Variable,
    inside,
)
from gonio.lang import Float
from gonio.model import Model, param

ROW = "row"
"""The parameter."""


def together(materials: Mapping[str, Model]) -> Model:
    """The first material's model with a parameter for the row; its other parameters are the first's.

    Raises:
        ExportError: fewer than two materials, or such whose code is not the same.
    """
    if len(materials) < 2:
        raise ExportError("a row is chosen among several materials; name two or more.")
    (first, model), *others = materials.items()
    for name, other in others:
        if same_code(other) != same_code(model):
            raise ExportError(
                f"{first} and {name} are not the same model with the same options, which materials of one "
                "function have to be; export them without --by-row."
            )
    if ROW in model.fields:
        raise ExportError(f"{model.name} has a parameter {ROW} of its own; give that another name.")
    said = ", ".join(f"{i} {name}" for i, name in enumerate(materials))
    written = model.written
    own = {
        "__module__": written.__module__,
        "__doc__": written.description,
        "__annotations__": {ROW: Float},
        ROW: param(0, 0, len(materials) - 1, f"the material, by its row in the table of F: {said}"),
    }
    made: Any = new_class(
        written.__name__, (written,), {"register": False}, lambda space: space.update(own)
    )
    made.name = written.name
    return at_row(made(), model, 0)


def check(request: Request, functions: Sequence[str]) -> None:
    """Refuse what no row could choose.

    Raises:
        ExportError: a table of F is not asked for, or functions that do not look it up are.
    """
    if FRESNEL not in request.kinds:
        raise ExportError("a row is chosen in a table of F; give --table fresnel as well.")
    if others := [name for name in functions if name not in ("eval", "shade")]:
        raise ExportError(
            f"{' and '.join(others)} would compute F of one index, whatever the row; with --by-row leave "
            "out --only, or give --only eval."
        )


def at_row(model: Model, material: Model, row: int) -> Model:
    """A model with a row as one of its materials."""
    return model.replace(**{name: getattr(material, name) for name in material.fields}, row=row)


def of_all(parameters: Sequence[dict[str, Known]]) -> dict[str, Known]:
    """The parameters of all materials behind each other; not known where that of one is not."""
    found: dict[str, Known] = {ROW: UNKNOWN}
    for name, first in parameters[0].items():
        values = [one[name] for one in parameters]
        if isinstance(first, dict):
            found[name] = of_all(values)
        elif any(value is UNKNOWN for value in values):
            found[name] = UNKNOWN
        else:
            found[name] = np.concatenate(values)
    return found


def of_one(index: Sequence[Known], number: int) -> tuple[Known, ...]:
    """What is known of one of the materials."""
    return tuple(v[number : number + 1] if len(v) > 1 else v for v in index)


def begin(function: Function, variable: Variable, nearest: Function, materials: int) -> None:
    """Let a function of the model read the row, behind the tests for the horizon."""
    assert function.owner is not None
    given = Access(Variable(SELF, function.owner), ROW, "float")
    value = Call(nearest, (given, Number(materials - 1)), "float")
    at = 0
    while isinstance(test := function.body[at], ReturnIf) and not any(
        isinstance(e, Variable) and e.name == variable.name
        for part in (test.condition, test.value)
        for e in inside(part)
    ):
        at += 1
    assigned = Assign(variable.name, value)
    function.body = (*function.body[:at], assigned, *function.body[at:])
