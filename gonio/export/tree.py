"""The checked tree of what is exported: structs, functions, typed expressions. No Python is left in it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    from gonio.model import Model
    from gonio.table import Table

# Name of the struct of parameters where a function gets it.
SELF = "params"

# What users call of a model, under these names in every language.
METHODS = ("eval", "sample", "pdf", "albedo")

# The same with what lit exports have besides.
CALLED = (*METHODS, "shade")


class ExportError(ValueError):
    """Something that cannot be exported, with its place in the Python file and what to write instead."""

    place: tuple[str, int] | None = None
    """File and line, where there is one."""
    reason: str = ""
    """What is wrong there, and what to write."""


@dataclass(eq=False)
class Struct:
    """A type with members: a model's parameters, a sample, or the results of a function."""

    name: str
    members: tuple[Member, ...]
    doc: tuple[str, ...] = ()
    model: Model | None = None
    """The model whose parameters these are."""
    prefix: str = ""
    """Of the functions that belong to the model, such as "eon"."""
    fixed: tuple[tuple[str, Any], ...] = ()
    """Members that are known when the shader is made, and stand in no struct of it."""
    order: tuple[str, ...] = ()
    """All members as Python unpacks them; empty: as they stand here."""
    python: type | None = None
    """The NamedTuple or dataclass that it stands for."""


Type = Literal["float", "vec2", "vec3", "bool", "bool3"] | Struct


@dataclass(frozen=True)
class Member:
    """One member of a struct."""

    name: str
    type: Type
    doc: str = ""


# --- expressions -----------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Number:
    """A number as it stands in the source."""

    value: float
    type: Type = "float"


@dataclass(frozen=True, eq=False)
class Constant:
    """A named number of a Python module, with the comments that stand beside it there."""

    name: str
    value: float
    comments: tuple[str, ...] = ()
    place: tuple[str, int, int] = ("", 0, 0)
    """File, line and column of its definition, by which such numbers are ordered."""
    type: Type = "float"


@dataclass(frozen=True, eq=False)
class Variable:
    """A local variable or an argument."""

    name: str
    type: Type


@dataclass(frozen=True, eq=False)
class Access:
    """A member of a struct, or a component x, y, z of a vector."""

    value: Expr
    name: str
    type: Type


@dataclass(frozen=True, eq=False)
class Negation:
    """-a, or "not" of a mask."""

    value: Expr
    type: Type


@dataclass(frozen=True, eq=False)
class Operation:
    """a op b, per component; the operands may be a vector and a number."""

    operator: str
    left: Expr
    right: Expr
    type: Type


@dataclass(frozen=True, eq=False)
class Splat:
    """A number (or mask) repeated for each component."""

    value: Expr
    type: Type


@dataclass(frozen=True, eq=False)
class Builtin:
    """A function of the vocabulary that every language spells its own way."""

    name: str
    arguments: tuple[Expr, ...]
    type: Type


@dataclass(frozen=True, eq=False)
class Construction:
    """A vector from numbers, or a struct from its members."""

    arguments: tuple[Expr, ...]
    type: Type


@dataclass(frozen=True, eq=False)
class Call:
    """A call of an exported function."""

    function: Function
    arguments: tuple[Expr, ...]
    type: Type


Expr = (
    Number
    | Constant
    | Variable
    | Access
    | Negation
    | Operation
    | Splat
    | Builtin
    | Construction
    | Call
)


# --- statements ------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Statement:
    """What every statement has: the comments above it, the one behind it, an empty line before."""

    comments: tuple[str, ...] = field(default=(), kw_only=True)
    trailing: str = field(default="", kw_only=True)
    blank: bool = field(default=False, kw_only=True)


@dataclass(frozen=True, eq=False)
class Assign(Statement):
    """A variable declared, or given another value."""

    name: str
    value: Expr
    declares: bool = True


@dataclass(frozen=True, eq=False)
class SetMember(Statement):
    """A member of a struct variable given another value."""

    variable: str
    member: str
    value: Expr
    struct: Struct


@dataclass(frozen=True, eq=False)
class Return(Statement):
    """The result."""

    value: Expr


@dataclass(frozen=True, eq=False)
class ReturnIf(Statement):
    """An early result, for directions below the horizon."""

    condition: Expr
    value: Expr


@dataclass(frozen=True, eq=False)
class Repeat(Statement):
    """A loop over 0, 1, ... count - 1; the variable is a float."""

    variable: str
    count: int
    body: tuple[Statement, ...]
    named: Constant | None = None
    """The count as the file has it, if it is a number with a name."""


@dataclass(frozen=True, eq=False)
class Remark(Statement):
    """Comments at the end of a body."""


# --- functions -------------------------------------------------------------------------------------


@dataclass(eq=False)
class Function:
    """One exported function, for the types of its arguments."""

    name: str
    doc: tuple[str, ...]
    parameters: tuple[tuple[str, Type], ...]
    result: Type
    body: tuple[Statement, ...]
    owner: Struct | None = None
    """The model it is a method of; its first parameter is the model's struct."""
    method: str = ""
    """Its name as a method, such as "eval"."""
    plain: str = ""
    """Its name in Python; of a NamedTuple's method with the class, such as "GGX.D"."""
    exponents: frozenset[int] = frozenset()
    """Which arguments are exponents of `power`."""
    in_exponents: frozenset[int] = frozenset()
    """Which arguments exponents are computed of."""
    struct_exponents: tuple[Expr, ...] = ()
    """Exponents that are computed of structs among the arguments, and of nothing but arguments."""
    kept: tuple[bool, ...] = ()
    """Which arguments are left, once some were dropped because nothing reads them."""
    external: bool = False
    """Whether the host supplies it, so that it has no body here."""
    table: Table | None = None
    """Whose entries it reads, if it does."""


def walk(statements: tuple[Statement, ...]) -> Iterator[Expr]:
    """Every expression in some statements, outer ones first."""
    for statement in statements:
        if isinstance(statement, Repeat):
            if statement.named is not None:
                yield statement.named
            yield from walk(statement.body)
        for part in ("condition", "value"):
            expr = getattr(statement, part, None)
            if expr is not None:
                yield from inside(expr)


def children(expr: Expr) -> tuple[Expr, ...]:
    """The expressions that an expression is made of."""
    if isinstance(expr, (Access, Negation, Splat)):
        return (expr.value,)
    if isinstance(expr, Operation):
        return (expr.left, expr.right)
    if isinstance(expr, (Builtin, Construction, Call)):
        return expr.arguments
    return ()


def inside(expr: Expr) -> Iterator[Expr]:
    """An expression and all that it is made of."""
    yield expr
    for child in children(expr):
        yield from inside(child)


def rebuilt(expr: Expr, change: Callable[[Expr], Expr]) -> Expr:
    """The same expression with `change` applied to each of its parts."""
    if isinstance(expr, Access):
        return Access(change(expr.value), expr.name, expr.type)
    if isinstance(expr, Negation):
        return Negation(change(expr.value), expr.type)
    if isinstance(expr, Splat):
        return Splat(change(expr.value), expr.type)
    if isinstance(expr, Operation):
        return Operation(expr.operator, change(expr.left), change(expr.right), expr.type)
    if isinstance(expr, Builtin):
        return Builtin(expr.name, tuple(change(a) for a in expr.arguments), expr.type)
    if isinstance(expr, Construction):
        return Construction(tuple(change(a) for a in expr.arguments), expr.type)
    if isinstance(expr, Call):
        return Call(expr.function, tuple(change(a) for a in expr.arguments), expr.type)
    return expr
