"""Numbers that expressions come to, through calls of helpers and names that are given once."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from gonio.export.evaluate import UNKNOWN, Known, Machine
from gonio.export.tree import Access, Construction, Expr, Struct, Variable, inside, rebuilt

# Names that stand for others, one after the other; expressions double with some of them.
EXPANSIONS_MAX = 8


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


def put(expr: Expr, values: Mapping[str, Expr]) -> Expr:
    """An expression with others in the place of names, and of members of structs that these make."""
    if isinstance(expr, Variable):
        return values.get(expr.name, expr)
    found = rebuilt(expr, lambda inner: put(inner, values))
    if isinstance(found, Access) and isinstance(found.value, Construction):
        kind = found.value.type
        if isinstance(kind, Struct):
            return found.value.arguments[[m.name for m in kind.members].index(found.name)]
    return found


def expanded(expr: Expr, made: Mapping[str, Expr]) -> Expr:
    """An expression with what names were given in their places, down to those that have no value here."""
    found = put(expr, made)
    for _ in range(EXPANSIONS_MAX):
        names = {e.name for e in inside(found) if isinstance(e, Variable)}
        if not names & set(made):
            break
        found = put(found, made)
    return found
