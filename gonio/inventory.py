"""What gonio has besides models: the functions they are made of, and the tools that name a source.

Nothing is listed by hand. Parts are the public functions of the modules in `gonio.parts`, and of those
modules of gonio itself whose docstring names a source.
"""

from __future__ import annotations

import ast
import importlib
import importlib.util
import inspect
import pkgutil
import textwrap
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import groupby
from types import ModuleType

import gonio
from gonio import parts as parts_package
from gonio.description import module_notes


@dataclass(frozen=True)
class Part:
    """A public function that is not a method of a model."""

    name: str
    """Such as "D_ggx"."""
    module: str
    """Where it is imported from, such as "gonio.parts.distribution"."""
    summary: str
    """The first sentence of its docstring."""
    group: str
    """What its module holds, in one line."""
    source: str
    """The publications that its module names; "" if it needs none."""


def parts() -> list[Part]:
    """All parts, by module, in the order in which they are written."""
    return [part for module in _modules() for part in _functions(module)]


def lines(found: Iterable[Part]) -> Iterator[str]:
    """Parts as text: modules with their functions below."""
    for number, (module, group) in enumerate(groupby(found, lambda part: part.module)):
        listed = list(group)
        if number:
            yield ""
        yield f"{module}: {listed[0].group}"
        width = max(len(part.name) for part in listed)
        for part in listed:
            yield f"  {part.name:<{width}}  {part.summary}"
        if listed[0].source:
            yield from textwrap.wrap(
                f"Source: {listed[0].source}", 100, initial_indent="  ", subsequent_indent="    "
            )


def _modules() -> Iterator[ModuleType]:
    for info in pkgutil.iter_modules(parts_package.__path__):
        yield importlib.import_module(f"{parts_package.__name__}.{info.name}")
    for info in pkgutil.iter_modules(gonio.__path__):
        # Asked of the file first: importing all of gonio would load Mitsuba and matplotlib.
        if not info.ispkg and _names_a_source(info.name):
            yield importlib.import_module(f"gonio.{info.name}")


def _names_a_source(name: str) -> bool:
    spec = importlib.util.find_spec(f"gonio.{name}")
    assert spec is not None
    assert spec.origin is not None
    with open(spec.origin, encoding="utf-8") as file:
        docstring = ast.get_docstring(ast.parse(file.read())) or ""
    return "source" in module_notes(docstring)


def _functions(module: ModuleType) -> Iterator[Part]:
    notes = module_notes(inspect.getdoc(module) or "")
    for name, value in vars(module).items():
        if inspect.isfunction(value) and value.__module__ == module.__name__ and name[0] != "_":
            summary = (inspect.getdoc(value) or "").partition("\n\n")[0].replace("\n", " ")
            yield Part(name, module.__name__, summary, notes["title"], notes.get("source", ""))
