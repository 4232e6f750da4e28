"""The object that a host passes in languages that have no global buffers and textures: C++, CUDA, Metal.

What looks something up there is a method of an object of any type, the last argument of all functions that
need it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

from gonio.export.printer import Printer
from gonio.export.tidy import rewrite
from gonio.export.tree import Call, Expr, Function, Struct, Variable, walk

# Languages where the host passes an object, and how functions take it.
OBJECTS: Mapping[str, Struct] = MappingProxyType(
    {
        "cpp": Struct("const Host&", ()),
        "cuda": Struct("const Host&", ()),
        "msl": Struct("thread const Host&", ()),
    }
)


def asking(functions: Sequence[Function], lookups: Sequence[Function]) -> list[Function]:
    """Those of some functions, callees before callers, that are lookups or lead to one."""
    found = {id(f) for f in lookups}
    for function in functions:
        if any(isinstance(e, Call) and id(e.function) in found for e in walk(function.body)):
            found.add(id(function))
    return [f for f in functions if id(f) in found]


def with_host(functions: Sequence[Function], host: Struct, lookups: Sequence[Function]) -> None:
    """Hand the host's object down to what looks things up; some lookups become its methods."""
    found = asking(functions, lookups)
    numbers = {id(f) for f in found}
    variable = Variable("host", host)

    def passed(expr: Expr) -> Expr:
        if isinstance(expr, Call) and id(expr.function) in numbers and not expr.function.external:
            return replace(expr, arguments=(*expr.arguments, variable))
        return expr

    for function in found:
        if function.external:
            function.name = f"host.{function.plain}"
        else:
            function.parameters = (*function.parameters, ("host", host))
            rewrite(function, passed)


class HostPrinter(Printer):
    """Writes functions that take the host's object as templates."""

    def function(self, function: Function) -> list[str]:
        """A function with its description."""
        lines = super().function(function)
        if not any(
            name == "host" and isinstance(kind, Struct) for name, kind in function.parameters
        ):
            return lines
        start = next(i for i, line in enumerate(lines) if not line.startswith("//"))
        return [*lines[:start], "template <class Host>", *lines[start:]]
