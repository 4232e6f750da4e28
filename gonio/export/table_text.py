"""Tables as arrays in a text, and the functions that interpolate them, in every language.

Languages with textures have this for hosts that would rather not bind one (`--lookups array`); C++, CUDA
and Metal, whose lookups are no global names, always.
"""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Mapping
from types import MappingProxyType

from gonio.export.coded import FRESNEL, CodedTable
from gonio.export.comments import comment
from gonio.export.printer import INDENT, WIDTH, Printer
from gonio.export.tree import ExportError, Function

# An array's declaration, before the function or (C++, CUDA) inside it.
_ARRAYS: Mapping[str, str] = MappingProxyType(
    {
        "glsl": "const int {name}[{count}] = int[{count}](\n{codes}\n);",
        "essl": "const int {name}[{count}] = int[{count}](\n{codes}\n);",
        "hlsl": "static const int {name}[{count}] = {{\n{codes}\n}};",
        "slang": "static const int {name}[{count}] = {{\n{codes}\n}};",
        "msl": "constant {type} {name}[{count}] = {{\n{codes}\n}};",
        "cpp": "static const {type} {name}[{count}] = {{\n{codes}\n}};",
        "cuda": "static const {type} {name}[{count}] = {{\n{codes}\n}};",
    }
)


def array(printer: Printer, function: Function, table: CodedTable) -> list[str]:
    """A table's array, and the function that looks it up."""
    language = printer.target.name
    name = f"{function.name}_codes"
    if language not in _ARRAYS:
        raise ExportError(
            f"{printer.target.title} has no arrays for tables; leave out --lookups array."
        )
    small = "unsigned char" if table.bits == 8 else "unsigned short"
    if language == "msl":
        small = "uchar" if table.bits == 8 else "ushort"
    codes = [str(c) for c in table.codes.ravel().tolist()]
    lines = textwrap.wrap(", ".join(codes), WIDTH - len(INDENT))
    declared = _ARRAYS[language].format(
        name=name, count=len(codes), codes="\n".join(INDENT + line for line in lines), type=small
    )
    inside = language in ("cpp", "cuda")
    text = reading(printer, function, table, lambda k: f"{name}[{k}]")
    where = next(i for i, line in enumerate(text) if not line.startswith("//")) + 1
    if inside:
        return [*text[:where], *(INDENT + line for line in declared.splitlines()), *text[where:]]
    return [*declared.splitlines(), "", *text]


def reading(
    printer: Printer, function: Function, table: CodedTable, entry: Callable[[str], str]
) -> list[str]:
    """The function that looks a table up, whose codes are read by an expression of their number."""
    body = (
        _fresnel(printer, table, entry)
        if table.kind == FRESNEL
        else _distribution(printer, table, entry)
    )
    parameters = ", ".join(
        printer.target.parameter.format(type=printer.type(kind), name=n)
        for n, kind in function.parameters
    )
    head = printer.target.function.format(
        result=printer.type(function.result), name=function.name, parameters=parameters
    )
    text = [*comment((*function.doc, "", *table.meaning())), head]
    return [*text, *(INDENT + line for line in body), "}"]


class _Words:
    """How a language declares and casts."""

    def __init__(self, printer: Printer) -> None:
        self.target = printer.target
        self.to_int = f"{self.target.whole}({{}})"
        self.to_float = self.target.to_float

    def number(self, value: float) -> str:
        return f"{float(value)!r}{self.target.suffix}"

    def float(self, name: str, value: str) -> str:
        return self.target.local.format(type=self.target.types["float"], name=name, value=value)

    def whole(self, name: str, value: str) -> str:
        return self.target.local.format(type=self.target.whole, name=name, value=value)

    def call(self, name: str, *arguments: str) -> str:
        return self.target.spellings[name].format(*arguments)

    def place(self, at: str, value: str, left: str, last: int) -> list[str]:
        """Where an axis is met: `at` as a number, `left` as the entry before it."""
        limited = self.call("minimum", at, self.number(max(last - 1, 0)))
        return [self.float(at, value), self.whole(left, self.to_int.format(limited))]

    def within(self, value: str, last: int) -> str:
        """A number from 0 to 1, as one up to the last entry."""
        inside = self.call("clamp", value, self.number(0), self.number(1))
        return f"{inside} * {self.number(last)}"


def _fresnel(printer: Printer, table: CodedTable, entry: Callable[[str], str]) -> list[str]:
    w = _Words(printer)
    cosines = table.codes.shape[1]
    lines = w.place("at", w.within("cos_theta", cosines - 1), "left", cosines - 1)
    lines.append(w.float("t", f"(at - {w.to_float.format('left')}) / {w.number(table.most)}"))
    lines.append(w.float("s", f"{w.number(1 / table.most)} - t"))
    row = w.to_int.format("row")
    lines.append(w.whole("k", f"3 * ({cosines} * {row} + left)"))
    parts = []
    for c in range(3):
        low, high = (entry(f"k{f' + {n}' if n else ''}") for n in (c, c + 3))
        parts.append(f"s * {w.to_float.format(low)} + t * {w.to_float.format(high)}")
    for axis, part in zip("xyz", parts, strict=True):
        lines.append(w.float(f"F_{axis}", part))
    made = printer.target.vector.format(type=printer.type("vec3"), arguments="F_x, F_y, F_z")
    return [*lines, f"return {made};"]


def _distribution(printer: Printer, table: CodedTable, entry: Callable[[str], str]) -> list[str]:
    w = _Words(printer)
    rows, places = table.codes.shape
    lines = w.place("across", w.within("u", places - 1), "left", places - 1)
    down = w.call("clamp", "row", w.number(0), w.number(rows - 1))
    lines += w.place("down", down, "top", rows - 1)
    lines.append(w.float("s", f"across - {w.to_float.format('left')}"))
    lines.append(w.float("t", f"down - {w.to_float.format('top')}"))
    lines.append(w.whole("k", f"{places} * top + left"))
    for value, at in (("upper", ""), ("lower", f" + {places}")):
        a = w.to_float.format(entry(f"k{at}"))
        b = w.to_float.format(entry(f"k{at} + 1"))
        lines.append(w.float(value, f"{a} + s * ({b} - {a})"))
    lines.append(f"return (upper + t * (lower - upper)) / {w.number(table.most)};")
    return lines
