"""Makes an export read as if it was written for its language: without what options have left over.

Functions that only pass their arguments on are inlined; arguments that no function reads, members that
no function asks for, and what is computed for them, are left out.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from gonio.export.operators import simplified
from gonio.export.tree import (
    SELF,
    Access,
    Assign,
    Call,
    Constant,
    Construction,
    Expr,
    Function,
    Member,
    Number,
    Operation,
    Remark,
    Repeat,
    Return,
    ReturnIf,
    SetMember,
    Statement,
    Struct,
    Variable,
    inside,
    rebuilt,
    walk,
)


def tidy(
    functions: Sequence[Function], wanted: Sequence[Function], sample: Struct, methods: bool
) -> list[Function]:
    """The functions that are left, callees before callers; they and their structs are changed in place.

    Args:
        functions: callees before callers.
        wanted: those that users call, whose arguments stay as they are.
        sample: the struct of samples, which stays as it is.
        methods: whether the language calls methods on the model's struct.
    """
    for function in functions:
        rewrite(function, _inlined(wanted))
    left = _reachable(functions, wanted)
    for function in left:
        rewrite(function, _without_arguments)
        function.body = _without_unused(function.body)
        if function not in wanted and not function.external:
            _drop_arguments(function, methods)
    left = _reachable(left, wanted)
    _drop_members(left, sample)
    return _reachable(left, wanted)  # without what only dropped members asked for


def rewrite(function: Function, change: Callable[[Expr], Expr]) -> None:
    """Apply a change to every expression of a function, inner ones first."""

    def all_of(expr: Expr) -> Expr:
        return change(rebuilt(expr, all_of))

    def statement(found: Statement) -> Statement:
        if isinstance(found, Repeat):
            return replace(found, body=tuple(statement(s) for s in found.body))
        if isinstance(found, ReturnIf):
            return replace(found, condition=all_of(found.condition), value=all_of(found.value))
        if isinstance(found, (Assign, SetMember, Return)):
            return replace(found, value=all_of(found.value))
        return found

    function.body = tuple(statement(s) for s in function.body)


# --- functions that only pass on -------------------------------------------------------------------


def _is_name(expr: Expr) -> bool:
    if isinstance(expr, Access):
        return _is_name(expr.value)
    return isinstance(expr, (Variable, Constant, Number))


def _passed_on(function: Function) -> Expr | None:
    """What a function returns, if that is a name, a number, or a call or struct of its arguments alone."""
    if len(function.body) != 1 or not isinstance(function.body[0], Return):
        return None
    if function.body[0].comments or function.body[0].trailing:
        return None
    value = function.body[0].value
    if _is_name(value):
        return value
    if isinstance(value, Call) and all(_is_name(a) for a in value.arguments):
        return value
    if isinstance(value, Construction) and isinstance(value.type, Struct):
        return value if all(isinstance(a, Variable) for a in value.arguments) else None
    return None


def _whole(expr: Construction) -> Expr | None:
    """The struct of which all members, in their order, make one of the same kind again."""
    parts = expr.arguments
    if not isinstance(expr.type, Struct) or len(parts) != len(expr.type.members):
        return None
    whole: Expr | None = None
    for part, member in zip(parts, expr.type.members, strict=True):
        if not isinstance(part, Access) or part.name != member.name:
            return None
        if not isinstance(part.value, Variable) or part.value.type is not expr.type:
            return None
        if isinstance(whole, Variable) and whole.name != part.value.name:
            return None
        whole = part.value
    return whole


def _inlined(wanted: Sequence[Function]) -> Callable[[Expr], Expr]:
    def change(expr: Expr) -> Expr:
        if isinstance(expr, Operation) and expr.operator in "+-*/":
            return simplified(expr.operator, expr.left, expr.right, expr.type)
        if isinstance(expr, Construction):
            return _whole(expr) or expr
        if not isinstance(expr, Call) or expr.function in wanted:
            return expr
        value = _passed_on(expr.function)
        if value is None:
            return expr
        names = [name for name, _ in expr.function.parameters]
        given = dict(zip(names, expr.arguments, strict=True))
        uses = [e.name for e in inside(value) if isinstance(e, Variable)]
        if any(uses.count(n) > 1 and not _is_name(a) for n, a in given.items()):
            return expr
        return change(_substituted(value, given))

    return change


def _substituted(expr: Expr, given: Mapping[str, Expr]) -> Expr:
    if isinstance(expr, Variable):
        return given.get(expr.name, expr)
    return rebuilt(expr, lambda part: _substituted(part, given))


# --- what nothing reads ----------------------------------------------------------------------------


def _reachable(functions: Iterable[Function], wanted: Sequence[Function]) -> list[Function]:
    found: set[int] = set()
    todo = list(wanted)
    while todo:
        function = todo.pop()
        if id(function) not in found:
            found.add(id(function))
            todo += [e.function for e in walk(function.body) if isinstance(e, Call)]
    return [f for f in functions if id(f) in found]


def _drop_arguments(function: Function, methods: bool) -> None:
    """Arguments that the function does not read; calls follow by `_without_arguments`."""
    read = {e.name for e in walk(function.body) if isinstance(e, Variable)}
    kept = [
        name in read or (methods and name == SELF and function.owner is not None)
        for name, _ in function.parameters
    ]
    if not all(kept):
        function.kept = tuple(kept)
        function.parameters = tuple(
            p for p, keep in zip(function.parameters, kept, strict=True) if keep
        )


def _without_arguments(expr: Expr) -> Expr:
    if not isinstance(expr, Call) or not expr.function.kept:
        return expr
    kept = zip(expr.arguments, expr.function.kept, strict=True)
    return replace(expr, arguments=tuple(a for a, keep in kept if keep))


def _without_unused(statements: tuple[Statement, ...]) -> tuple[Statement, ...]:
    """Without variables that are not used any more."""
    while True:

        def kept(found: tuple[Statement, ...], used: set[str]) -> tuple[Statement, ...]:
            left = []
            for s in found:
                if isinstance(s, Repeat):
                    # What a loop declares is read in it or nowhere: the same name after it is another one
                    own = {a.name for a in s.body if isinstance(a, Assign) and a.declares}
                    s = replace(s, body=kept(s.body, (used - own) | _read(s.body)))
                    if not any(not isinstance(inner, Remark) for inner in s.body):
                        continue
                name = s.name if isinstance(s, Assign) else None
                name = s.variable if isinstance(s, SetMember) else name
                if name is None or name in used:
                    left.append(s)
            return tuple(left)

        after = kept(statements, _read(statements))
        if len(list(_all(after))) == len(list(_all(statements))):
            return after
        statements = after


def _read(statements: tuple[Statement, ...]) -> set[str]:
    """The names of the variables that are read in some statements."""
    return {e.name for e in walk(statements) if isinstance(e, Variable)}


def _all(statements: tuple[Statement, ...]) -> Iterable[Statement]:
    for s in statements:
        yield s
        if isinstance(s, Repeat):
            yield from _all(s.body)


def _drop_members(functions: Sequence[Function], sample: Struct) -> None:
    """Members of structs that no function reads."""
    read: dict[int, set[str]] = {}
    structs: dict[int, Struct] = {}

    def note(kind: Any) -> None:
        if isinstance(kind, Struct) and kind is not sample and id(kind) not in structs:
            structs[id(kind)] = kind
            for member in kind.members:
                note(member.type)

    for function in functions:
        for _, kind in function.parameters:
            note(kind)
        note(function.result)
        for expr in walk(function.body):
            note(expr.type)
            if isinstance(expr, Access) and isinstance(expr.value.type, Struct):
                read.setdefault(id(expr.value.type), set()).add(expr.name)
    kept: dict[int, tuple[bool, ...]] = {}
    for key, struct in structs.items():
        keep = tuple(m.name in read.get(key, set()) for m in struct.members)
        if not any(keep):  # shading languages have no empty structs
            keep = (True, *keep[1:])
        if not all(keep):
            kept[key] = keep
            struct.members = _chosen(struct.members, keep)

    def change(expr: Expr) -> Expr:
        if isinstance(expr, Construction) and id(expr.type) in kept:
            return replace(expr, arguments=_chosen(expr.arguments, kept[id(expr.type)]))
        return expr

    for function in functions:
        rewrite(function, change)
        function.body = tuple(
            s
            for s in function.body
            if not isinstance(s, SetMember) or _has(function.body, s, s.member)
        )
        function.body = _without_unused(function.body)


def _has(statements: tuple[Statement, ...], at: SetMember, member: str) -> bool:
    """Whether the struct of a variable still has a member."""
    for s in statements:
        if isinstance(s, Assign) and s.name == at.variable and isinstance(s.value.type, Struct):
            return any(m.name == member for m in s.value.type.members)
    return True


def _chosen(values: tuple[Any, ...], keep: tuple[bool, ...]) -> tuple[Any, ...]:
    return tuple(v for v, k in zip(values, keep, strict=True) if k)


def members(struct: Struct, prefix: str = "") -> Iterable[tuple[str, Member]]:
    """Path and declaration of all numbers and colours of a struct, those of inner models included."""
    for member in struct.members:
        if isinstance(member.type, Struct):
            yield from members(member.type, f"{prefix}{member.name}.")
        else:
            yield prefix + member.name, member
