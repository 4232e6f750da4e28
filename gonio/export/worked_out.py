"""Numbers that expressions come to, through calls of helpers and names that are given once."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from gonio.export.evaluate import UNKNOWN, Known, Machine
from gonio.export.tree import Access, Construction, Expr, Struct


class _Values(Mapping[str, Known]):
    """What names come to, each worked out when it is asked for; what has no expression is not known."""

    def __init__(self, made: Mapping[str, Expr]) -> None:
        self.made = made
        self.found: dict[str, Known] = {}

    def __getitem__(self, name: str) -> Known:
        if name not in self.found:
            expr = self.made.get(name)
            self.found[name] = UNKNOWN if expr is None else Machine().value(expr, self)
        return self.found[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.made)

    def __len__(self) -> int:
        return len(self.made)


def number(expr: Expr, made: Mapping[str, Expr]) -> float | None:
    """The number that an expression comes to; None if it depends on what only the shader knows.

    Args:
        expr: what to work out.
        made: what names were given.
    """
    if expr.type != "float":
        return None
    value = Machine().value(expr, _Values(made))
    return None if value is UNKNOWN else float(value[0])


def member(expr: Expr, name: str) -> Expr:
    """A member of a struct: what it was made of, if it is made here."""
    kind = expr.type
    assert isinstance(kind, Struct)
    names = [m.name for m in kind.members]
    if isinstance(expr, Construction):
        return expr.arguments[names.index(name)]
    return Access(expr, name, kind.members[names.index(name)].type)
