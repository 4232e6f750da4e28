"""What those who read one function ask of whoever collects the functions of an export."""

from __future__ import annotations

import types
from collections.abc import Iterable
from typing import Protocol

from gonio.export.tree import Function, Struct, Type
from gonio.export.values import Static
from gonio.table import Table


class Collector(Protocol):
    """Where the functions and structs that an expression needs are collected, each once."""

    lacking: frozenset[str]
    """Functions of the vocabulary that are taken from the library."""
    sample: Struct
    """The struct of a sampled direction."""
    differentiable: bool
    """Whether the language takes derivatives of the text."""

    def origin(self, function: Function) -> types.FunctionType | None:
        """The Python function that an exported one was read from."""
        ...

    def function_for(
        self,
        function: types.FunctionType,
        arguments: Iterable[Type | Static],
        owner: Struct | None = None,
        method: str = "",
        guarded: bool = True,
    ) -> Function:
        """A Python function as it is for some types of arguments."""
        ...

    def is_open(
        self, function: types.FunctionType, arguments: Iterable[Type | Static], owner: Struct | None
    ) -> bool:
        """Whether the function is being read, so that to call it would be to call itself."""
        ...

    def record(self, cls: type, given: tuple[Type | Static, ...]) -> Struct:
        """The struct of a NamedTuple or dataclass with these types of members."""
        ...

    def results(self, function: str, names: tuple[str, ...], given: tuple[Type, ...]) -> Struct:
        """The struct for several results of a function."""
        ...

    def power(self, exponent: int, kind: Type) -> Function:
        """A function that multiplies a value with itself."""
        ...

    def lookup(self, function: types.FunctionType) -> Function:
        """What the host supplies under this declaration."""
        ...

    def table(self, table: Table, owner: Struct | None) -> Function:
        """What reads an entry of a table, which may be one of a model's class."""
        ...
