"""What functions of the tree compute, on NumPy arrays; also where only some of their inputs are known.

    machine = Machine()
    machine.call(function, [parameters, wi, wo])     # {"alpha": (N,), ...}, (N, 3), (N, 3)

Numbers are arrays of the shape (N,) or (1,), vectors (N, 2) or (N, 3), structs dicts of these. UNKNOWN is a
value that is not given, and all that depends on it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from gonio.export.tree import (
    Access,
    Assign,
    Builtin,
    Call,
    Constant,
    Construction,
    Expr,
    Function,
    Negation,
    Number,
    Operation,
    Repeat,
    Return,
    ReturnIf,
    SetMember,
    Splat,
    Statement,
    Struct,
    Type,
    Variable,
)
from gonio.table import Table

Array = NDArray[Any]

AXES = "xyz"


class _Unknown:
    """What is not given."""

    def __repr__(self) -> str:
        return "UNKNOWN"


UNKNOWN: Final = _Unknown()

Known = Any
"""An array, a dict of such values, or UNKNOWN."""


class Machine:
    """Runs functions of the tree."""

    def __init__(
        self,
        external: Mapping[str, Callable[..., Known]] | None = None,
        dtype: type[np.floating[Any]] = np.float64,
    ) -> None:
        """Begin with what stands for functions of the host, by their names in Python, and a precision."""
        self.external = external or {}
        self.dtype = dtype

    def call(self, function: Function, arguments: Sequence[Known]) -> Known:
        """The result of a function."""
        if function.table is not None:
            return self._entry(function.table, arguments[0])
        if function.external:
            if function.plain not in self.external or any(a is UNKNOWN for a in arguments):
                return UNKNOWN
            return np.asarray(self.external[function.plain](*arguments), self.dtype)
        names = [name for name, _ in function.parameters]
        return self.run(function, dict(zip(names, arguments, strict=True)))

    def _entry(self, table: Table, index: Known) -> Known:
        """An entry of a table of the model's own."""
        if index is UNKNOWN:
            return UNKNOWN
        values = table.values.reshape(-1, 3) if table.colours else table.values
        return np.asarray(values[np.asarray(index + 0.5, int)], self.dtype)

    def run(self, function: Function, values: dict[str, Known]) -> Known:
        """The result of a function's body; `values` are its arguments, and are changed."""
        early: list[tuple[Known, Known]] = []
        result: Known = UNKNOWN
        for statement in function.body:
            if isinstance(statement, ReturnIf):
                at = self.value(statement.condition, values)
                early.append((at, self.value(statement.value, values)))
            elif isinstance(statement, Return):
                result = self.value(statement.value, values)
            else:
                self.statement(statement, values)
        for at, value in reversed(early):
            result = _chosen(at, value, result)
        return result

    def statement(self, statement: Statement, values: dict[str, Known]) -> None:
        """Run one statement that returns nothing."""
        if isinstance(statement, Assign):
            values[statement.name] = self.value(statement.value, values)
        elif isinstance(statement, SetMember):
            value = self.value(statement.value, values)
            owner = values[statement.variable]
            if isinstance(owner, dict):
                values[statement.variable] = owner | {statement.member: value}
        elif isinstance(statement, Repeat):
            for step in range(statement.count):
                values[statement.variable] = np.full(1, step, self.dtype)
                for inner in statement.body:
                    self.statement(inner, values)

    # --- expressions ---------------------------------------------------------------------------------

    def value(self, expr: Expr, values: Mapping[str, Known]) -> Known:
        """What an expression is."""
        if isinstance(expr, (Number, Constant)):
            return np.full(1, expr.value, self.dtype)
        if isinstance(expr, Variable):
            return values[expr.name]
        if isinstance(expr, Access):
            return _part(self.value(expr.value, values), expr.name, expr.value.type)
        if isinstance(expr, Construction):
            return self._made(expr, values)
        if isinstance(expr, Call):
            return self.call(expr.function, [self.value(a, values) for a in expr.arguments])
        if isinstance(expr, Negation):
            inner = self.value(expr.value, values)
            if inner is UNKNOWN:
                return UNKNOWN
            return ~inner if inner.dtype == bool else -inner
        if isinstance(expr, Splat):
            inner = self.value(expr.value, values)
            return inner if inner is UNKNOWN else np.repeat(inner[:, None], _width(expr.type), 1)
        if isinstance(expr, Operation):
            a, b = self._alike(expr.left, expr.right, values=values)
            return UNKNOWN if a is UNKNOWN or b is UNKNOWN else OPERATIONS[expr.operator](a, b)
        return self._builtin(expr, values)

    def _made(self, expr: Construction, values: Mapping[str, Known]) -> Known:
        parts = [self.value(a, values) for a in expr.arguments]
        if isinstance(expr.type, Struct):
            names = [member.name for member in expr.type.members]
            return dict(zip(names, parts, strict=True))
        if any(part is UNKNOWN for part in parts):
            return UNKNOWN
        return np.stack(np.broadcast_arrays(*parts), -1)

    def _alike(self, *parts: Expr, values: Mapping[str, Known]) -> list[Known]:
        """Values, numbers beside vectors repeated for their components."""
        vectors = any(p.type in ("vec2", "vec3", "bool3") for p in parts)
        found = [self.value(p, values) for p in parts]
        return [
            v[:, None] if vectors and p.type in ("float", "bool") and v is not UNKNOWN else v
            for p, v in zip(parts, found, strict=True)
        ]

    def _builtin(self, expr: Builtin, values: Mapping[str, Known]) -> Known:
        given = self._alike(*expr.arguments, values=values)
        if expr.name == "select":
            return _chosen(*given)
        if any(v is UNKNOWN for v in given):
            return UNKNOWN
        with np.errstate(all="ignore"):
            return np.asarray(BUILTINS[expr.name](*given), self.dtype)


def _width(kind: Type) -> int:
    return 2 if kind == "vec2" else 3


def _part(value: Known, name: str, kind: Type) -> Known:
    if value is UNKNOWN:
        return UNKNOWN
    return value[name] if isinstance(kind, Struct) else value[:, AXES.index(name)]


def _chosen(condition: Known, yes: Known, no: Known) -> Known:
    """`yes` where the condition holds; known as soon as that decides."""
    if isinstance(yes, dict) and isinstance(no, dict):
        return {name: _chosen(condition, yes[name], no[name]) for name in yes}
    if condition is UNKNOWN:
        return UNKNOWN
    if yes is UNKNOWN or no is UNKNOWN:
        certain = condition.all() or not condition.any()
        return (yes if condition.all() else no) if certain else UNKNOWN
    if condition.ndim < np.ndim(yes):
        condition = condition[:, None]
    return np.where(condition, yes, no)


def _power(x: Array, exponent: Array) -> Array:
    return np.asarray(np.power(x, exponent))


def _safe_sqrt(x: Array) -> Array:
    return np.asarray(np.sqrt(np.maximum(x, 0)))


def _twice_atan_over(v: Array) -> Array:
    zero = v == 0
    return np.where(zero, 2, 2 * np.arctan(v) / np.where(zero, 1, v))


OPERATIONS: Mapping[str, Callable[[Any, Any], Any]] = {
    "+": np.add,
    "-": np.subtract,
    "*": np.multiply,
    "/": lambda a, b: _quotient(a, b),
    "<": np.less,
    "<=": np.less_equal,
    ">": np.greater,
    ">=": np.greater_equal,
    "==": np.equal,
    "!=": np.not_equal,
    "&&": np.logical_and,
    "||": np.logical_or,
}


def _quotient(a: Array, b: Array) -> Array:
    with np.errstate(all="ignore"):
        return np.asarray(a / b)


BUILTINS: Mapping[str, Callable[..., Any]] = {
    "minimum": np.minimum,
    "maximum": np.maximum,
    "clamp": lambda x, low, high: np.minimum(np.maximum(x, low), high),
    "lerp": lambda a, b, t: a * (1 - t) + b * t,
    "absolute": np.abs,
    "fract": lambda x: x - np.floor(x),
    "sqrt": np.sqrt,
    "safe_sqrt": _safe_sqrt,
    "smooth_sqrt": np.sqrt,
    "safe_acos": lambda x: np.arccos(np.clip(x, -1, 1)),
    "safe_asin": lambda x: np.arcsin(np.clip(x, -1, 1)),
    "twice_atan_over": _twice_atan_over,
    "sin": np.sin,
    "cos": np.cos,
    "exp": np.exp,
    "log": np.log,
    "power": _power,
    "erf": np.vectorize(math.erf),
    "fma": lambda a, b, c: np.asarray(a, np.float64) * b + c,
    "dot": lambda a, b: np.sum(a * b, -1),
    "length": lambda v: np.sqrt(np.sum(v * v, -1)),
    "normalize": lambda v: v / np.sqrt(np.sum(v * v, -1, keepdims=True)),
}
