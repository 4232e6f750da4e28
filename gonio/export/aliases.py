"""Which names may have one value in Python, where a shader has copies."""

from __future__ import annotations

from gonio.export.tree import (
    Access,
    Builtin,
    Call,
    Constant,
    Construction,
    Expr,
    Negation,
    Number,
    Operation,
    Return,
    Splat,
    Struct,
    Variable,
)


def aliases(expr: Expr) -> set[str]:
    """Names of variables whose value may be this one itself, not a copy."""
    if isinstance(expr, Variable):
        return {expr.name}
    if isinstance(expr, (Access, Splat)):
        return aliases(expr.value)
    if isinstance(expr, Construction) and isinstance(expr.type, Struct):
        return {name for a in expr.arguments for name in aliases(a)}
    if isinstance(expr, Builtin) and expr.name == "select":
        return {name for a in expr.arguments[1:] for name in aliases(a)}
    if isinstance(expr, Call) and not _is_new(expr):
        return {name for a in expr.arguments for name in aliases(a)}
    return set()


def _is_new(expr: Expr) -> bool:
    """Whether the value was computed, and is not a name's or a part of it."""
    if isinstance(expr, Call) and expr.function.external:
        return True
    if isinstance(expr, Call):
        last = expr.function.body[-1] if expr.function.body else None
        return isinstance(last, Return) and _is_new(last.value)
    if isinstance(expr, Construction):
        return not isinstance(expr.type, Struct)
    if isinstance(expr, Builtin):
        return expr.name != "select"
    return isinstance(expr, (Operation, Negation, Number, Constant))


def same(a: Expr, b: Expr) -> bool:
    """Whether two expressions are the same name, or the same member of it."""
    if isinstance(a, Variable) and isinstance(b, Variable):
        return a.name == b.name
    if isinstance(a, Access) and isinstance(b, Access):
        return a.name == b.name and same(a.value, b.value)
    return False
