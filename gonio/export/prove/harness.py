"""What all runners share: the columns of inputs and outputs, and the statements between them.

A row of inputs holds wi (3), wo (3), u (2) and then the parameters in the order of the struct's members. A
row of outputs holds what the export has of eval (3), sample (wi 3, pdf 1), pdf (1) and albedo (3), in this
order. All runners read and write such rows of float32.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy.typing as npt

from gonio.export.entry import Entry, Export
from gonio.export.lookups import ROWS
from gonio.export.prove.tools import ProofError, Rows


@dataclass(frozen=True)
class Results:
    """What came of running exports."""

    outputs: list[Rows | ProofError]
    """Per export its rows of outputs, or why it was refused."""
    device: str
    """What ran them, for people."""


Runner = Callable[[Sequence[Export], Sequence[Rows]], Results]

STAND_IN = "StandIn"
"""Type of the object that stands for a host's lookups of pictures, and has its tables."""

BUFFER = "tables"
"""What the function that runs all rows calls the numbers of tables."""

CODE = "gonio_code"
"""What reads an entry of a table from the buffer of rows, behind which it stands."""

GIVEN = 8
"""Columns before the parameters: wi, wo and u."""

WIDTHS = {"eval": 3, "sample": 4, "pdf": 1, "albedo": 3, "shade": 3}

POINT = {"normal": 3, "tangent": 3, "view": 3}
"""What shade takes first; a lit export's rows end with these and with what its lights take."""


def input_columns(entry: Entry) -> int:
    """How many numbers a row of inputs has."""
    return point_column(entry) + sum(lit_columns(entry).values())


def point_column(entry: Entry) -> int:
    """Where the columns of a lit export's point begin."""
    return GIVEN + sum(member.width for member in entry.members)


def lit_columns(entry: Entry) -> dict[str, int]:
    """Name and width of what shade takes besides the parameters."""
    if "shade" not in entry.functions:
        return {}
    return POINT | {given.name: given.width for given in entry.given}


def output_columns(entry: Entry) -> int:
    """How many numbers a row of outputs has."""
    return sum(WIDTHS[name] for name in entry.functions)


def split(entry: Entry, outputs: Rows) -> dict[str, npt.NDArray[Any]]:
    """The columns of each function."""
    found, start = {}, 0
    for name in WIDTHS:
        if name in entry.functions:
            found[name] = outputs[:, start : start + WIDTHS[name]]
            start += WIDTHS[name]
    return found


@dataclass(frozen=True)
class Dialect:
    """How a language spells the statements of a harness."""

    vec2: str
    """A vector of {0}, {1}."""
    vec3: str
    variable: str = "{type} {name} = {value};"
    declaration: str = "{type} {name};"
    vec2_type: str = "vec2"
    vec3_type: str = "vec3"
    read: str = "x[i + {column}]"
    write: str = "y[o + {0}] = {1};"
    call: str = "{prefix}_{function}(params, {arguments})"
    buffer: str = BUFFER
    """The numbers of tables as the host's object takes them."""
    scope: str = ""
    """What stands before the export's names, such as "gonio_eon::"."""


_ARGUMENTS = {"eval": "wi, wo", "sample": "wo, u", "pdf": "wi, wo", "albedo": "wo"}


def statements(entry: Entry, dialect: Dialect) -> list[str]:
    """Read one row of inputs, call every function, write one row of outputs."""
    d = dialect

    def read(start: int, width: int) -> str:
        numbers = [
            d.read.format(column=c, texel=c // 4, component="xyzw"[c % 4])
            for c in range(start, start + width)
        ]
        return numbers[0] if width == 1 else (d.vec2 if width == 2 else d.vec3).format(*numbers)

    places = {"wi": (0, 3), "wo": (3, 3), "u": (6, 2)}
    called = [f for f in entry.functions if f != "shade"]
    used = {name for f in called for name in _ARGUMENTS[f].split(", ")}
    lines = [
        d.variable.format(
            type=d.vec2_type if width == 2 else d.vec3_type, name=name, value=read(start, width)
        )
        for name, (start, width) in places.items()
        if name in used
    ]
    lines.append(d.declaration.format(type=d.scope + entry.struct, name="params"))
    column = GIVEN
    for member in entry.members:
        lines.append(f"params.{member.place} = {read(column, member.width)};")
        column += member.width
    lines += _point(entry, d, read)
    lines += _host(entry, d)
    column = 0
    for function in WIDTHS:
        if function not in entry.functions:
            continue
        arguments = _ARGUMENTS.get(function) or ", ".join(lit_columns(entry))
        if function in entry.hosted:
            arguments += ", host"
        call = d.call.format(prefix=d.scope + entry.prefix, function=function, arguments=arguments)
        kind = {
            "sample": d.scope + entry.sample_struct,
            "pdf": "float",
        }.get(function, d.vec3_type)
        result = f"out_{function}"
        lines.append(d.variable.format(type=kind, name=result, value=call))
        parts = {
            "sample": [f"{result}.wi.{c}" for c in "xyz"] + [f"{result}.pdf"],
            "pdf": [result],
        }.get(function, [f"{result}.{c}" for c in "xyz"])
        for part in parts:
            lines.append(d.write.format(column, part))
            column += 1
    return lines


def _point(entry: Entry, d: Dialect, read: Callable[[int, int], str]) -> list[str]:
    """Statements that read what shade takes."""
    structs = {given.name: given for given in entry.given if given.struct}
    lines, column = [], point_column(entry)
    for name, width in lit_columns(entry).items():
        if name in structs:
            lines.append(d.declaration.format(type=d.scope + structs[name].struct, name=name))
            for i, member in enumerate(structs[name].members):
                lines.append(f"{name}.{member} = {read(column + 3 * i, 3)};")
        else:
            kind = "float" if width == 1 else d.vec3_type
            value = read(column, width)
            lines.append(d.variable.format(type=kind, name=name, value=value))
        column += width
    return lines


def _host(entry: Entry, d: Dialect) -> list[str]:
    """The object with lookups, where functions take one."""
    if not any(f in entry.hosted for f in entry.functions):
        return []
    lines = [d.declaration.format(type=d.scope + STAND_IN, name="host")]
    if entry.reading:
        lines.append(f"host.{ROWS} = {d.buffer};")
    return lines


def reads_buffer(export: Export) -> bool:
    """Whether what is called reads tables."""
    return any(f in export.entry.reading for f in export.entry.functions)


def given_rows(export: Export, kind: str) -> str:
    """The last parameter of the function that runs all rows: tables, if it has some."""
    return f", {kind} {BUFFER}" if reads_buffer(export) else ""


def indented(lines: Sequence[str], spaces: int = 4) -> str:
    """The lines as text, moved to the right."""
    return "\n".join(" " * spaces + line for line in lines)
