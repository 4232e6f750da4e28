"""Where single precision would change what Python computes with numbers of its own.

`big = 1e8; more = big + 1; more - big` is 1 in Python, whose numbers have 16 digits, and 0 in a shader.
Such names are followed as both compute them, through all steps of loops.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from gonio.export.tree import (
    Assign,
    Constant,
    Expr,
    Negation,
    Number,
    Operation,
    Repeat,
    Return,
    SetMember,
    Statement,
    Variable,
    children,
    inside,
)
from gonio.export.values import ARITHMETIC, COMPARISON, SAME

# How far the two may be apart, relative to numbers above 1: what the roundings of a long loop add up to,
# and far less than a difference of large numbers, or an overflow, makes of them.
APART = 1e-4

# Assignments and comparisons that are followed; loops beyond that take too long to run here.
EVALUATIONS_MAX = 20_000

Both = tuple[Any, Any]
"""A number as Python has it, and in single precision."""


def changed(statements: Sequence[Statement]) -> Expr | None:
    """The first value, or comparison, of Python's own numbers that single precision changes."""
    names = _of_numbers(statements)
    return _Run(names).block(_only(statements, names), {}) if names else None


def _all(statements: Sequence[Statement]) -> Iterator[Statement]:
    for statement in statements:
        yield statement
        if isinstance(statement, Repeat):
            yield from _all(statement.body)


def _of_numbers(statements: Sequence[Statement]) -> set[str]:
    """Names that are only ever given numbers, and what is computed from such names."""
    given: dict[str, list[Expr]] = {}
    names: set[str] = set()
    for statement in _all(statements):
        if isinstance(statement, Assign):
            given.setdefault(statement.name, []).append(statement.value)
        elif isinstance(statement, Repeat):
            names.add(statement.variable)
    names |= set(given)
    while True:
        left = {n for n in names if all(_is_of(e, names) for e in given.get(n, ()))}
        if left == names:
            return names
        names = left


def _is_of(expr: Expr, names: set[str]) -> bool:
    """Whether an expression is arithmetic of numbers and of these names."""
    if isinstance(expr, Variable):
        return expr.name in names
    if isinstance(expr, (Number, Constant)):
        return True
    arithmetic = isinstance(expr, Negation) and expr.type == "float"
    arithmetic |= isinstance(expr, Operation) and expr.operator in ARITHMETIC
    return arithmetic and all(_is_of(e, names) for e in children(expr))


def _largest(expr: Expr, names: set[str]) -> Iterator[Expr]:
    """What is computed or compared of such names alone, and is no part of more."""
    compared = isinstance(expr, Operation) and expr.operator in COMPARISON
    if compared and all(_is_of(e, names) for e in children(expr)):
        yield expr
    elif not _is_of(expr, names):
        for inner in children(expr):
            yield from _largest(inner, names)
    elif any(isinstance(e, Variable) for e in inside(expr)):
        yield expr


Step = tuple[Statement, tuple[Expr, ...], tuple[Any, ...]]
"""A statement, what it computes with numbers, and what a loop has inside."""


def _only(statements: Sequence[Statement], names: set[str]) -> tuple[Step, ...]:
    """The statements that compute with numbers alone, or compare them."""
    found: list[Step] = []
    for statement in statements:
        if isinstance(statement, Repeat):
            if inner := _only(statement.body, names):
                found.append((statement, (), inner))
        elif isinstance(statement, (Assign, Return, SetMember)):
            computed = tuple(_largest(statement.value, names))
            if computed or (isinstance(statement, Assign) and statement.name in names):
                found.append((statement, computed, ()))
    return tuple(found)


class _Run:
    """Runs statements on numbers, as Python and as a shader."""

    def __init__(self, names: set[str]) -> None:
        self.names = names
        self.left = EVALUATIONS_MAX

    def block(self, steps: Sequence[Step], values: dict[str, Both]) -> Expr | None:
        """The first expression that comes out differently."""
        for statement, computed, inner in steps:
            if self.left <= 0:
                return None
            if isinstance(statement, Repeat):
                for i in range(statement.count):
                    values[statement.variable] = (i, np.float32(i))
                    if (found := self.block(inner, values)) is not None:
                        return found
                continue
            self.left -= 1 + len(computed)
            for expr in computed:
                if _differs(expr, values):
                    return expr
            if isinstance(statement, Assign) and statement.name in self.names:
                values[statement.name] = _both(statement.value, values)
        return None


def _differs(expr: Expr, values: Mapping[str, Both]) -> bool:
    """Whether a value or a comparison is another one in single precision."""
    if not (isinstance(expr, Operation) and expr.operator in COMPARISON):
        return _apart(_both(expr, values))
    left, right = _both(expr.left, values), _both(expr.right, values)
    if _apart(left) or _apart(right):
        return True
    compare = COMPARISON[expr.operator]
    if compare(left[0], right[0]) != compare(left[1], right[1]):
        return True
    # Quotients are not exact on graphics processors
    near = abs(left[0] - right[0]) <= SAME * max(abs(left[0]), abs(right[0]))
    divided = any(isinstance(e, Operation) and e.operator == "/" for e in inside(expr))
    return near and (divided or _is_rounded(left) or _is_rounded(right))


def _is_rounded(value: Both) -> bool:
    return float(value[0]) != float(value[1])


def _apart(value: Both) -> bool:
    try:
        exact = float(value[0])
    except OverflowError:
        return True
    single = float(value[1])
    if not math.isfinite(exact) or not math.isfinite(single):
        return True
    return abs(exact - single) > APART * max(1.0, abs(exact))


def _both(expr: Expr, values: Mapping[str, Both]) -> Both:
    if isinstance(expr, (Number, Constant)):
        return expr.value, np.float32(expr.value)
    if isinstance(expr, Variable):
        return values[expr.name]
    if isinstance(expr, Negation):
        exact, single = _both(expr.value, values)
        return -exact, -single
    assert isinstance(expr, Operation)
    left, right = _both(expr.left, values), _both(expr.right, values)
    compute = ARITHMETIC[expr.operator]
    try:
        with np.errstate(all="ignore"):
            return compute(left[0], right[0]), compute(left[1], right[1])
    except ArithmeticError:  # of which Python itself complains
        return math.nan, np.float32(math.nan)
