"""What an expression can be to the exporter: a value in the shader, or something decided before."""

from __future__ import annotations

import math
import operator
import types
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from gonio.export.tree import (
    Constant,
    Expr,
    Negation,
    Number,
    Operation,
    Splat,
    Struct,
    Type,
    Variable,
)

# The smallest float32 with all its digits; graphics processors make smaller ones 0.
SMALLEST = float(np.finfo(np.float32).tiny)

# An expression of numbers is computed by the shader's compiler in single precision. Where that is further
# off than this, as with 2**24 + 1 - 2**24, the number is written as Python computes it.
SAME = 1e-6

ARITHMETIC: dict[str, Callable[[Any, Any], Any]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": operator.truediv,
}
COMPARISON: dict[str, Callable[[Any, Any], Any]] = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "==": operator.eq,
    "!=": operator.ne,
}
JOINED: dict[str, Callable[[Any, Any], Any]] = {"&&": operator.and_, "||": operator.or_}


@dataclass(frozen=True, eq=False)
class Static:
    """A value that is known when the shader is made: an option, a module, a function, a number.

    Two are the same if Python would do the same with them: not 2 and 2.0, nor 1 and True.
    """

    value: Any

    def __eq__(self, other: object) -> bool:
        """Whether it is the same value of the same type."""
        return isinstance(other, Static) and _exactly(self.value) == _exactly(other.value)

    def __hash__(self) -> int:
        """Equal values have equal hashes."""
        return hash(_exactly(self.value))


def _exactly(value: Any) -> Any:
    """What two values share if and only if they are of one type and equal, down to the sign of zero."""
    if type(value) is tuple:
        return (tuple, *map(_exactly, value))
    return (type(value), value.hex() if type(value) is float else value)


@dataclass(frozen=True)
class Method:
    """A method of a model or a NamedTuple that is not called yet."""

    model: Expr
    name: str
    function: types.FunctionType


@dataclass(frozen=True)
class Many:
    """Several values, as `return a, b` gives them."""

    values: tuple[Expr, ...]


Value = Expr | Static | Method | Many


class Changed(Variable):
    """A copy of a model's struct with other members: only as a whole statement."""

    model: Expr
    members: dict[str, Expr]

    def __init__(self, model: Expr, kind: Type, members: dict[str, Expr]) -> None:
        """Of a model's value, with some members changed."""
        super().__init__("rougher", kind)
        object.__setattr__(self, "model", model)
        object.__setattr__(self, "members", members)


def is_number(value: Any) -> bool:
    """Whether it is a number of Python, which has a place in a shader."""
    # Not what derives from them, such as bool, enumerations, and classes with operators of their own
    return type(value) in (int, float, np.float64)


def misfit(value: Any) -> str:
    """Why a number of Python is none in a shader; empty if it is one."""
    if isinstance(value, complex):
        return f"the result {value:.3g} is complex, which no shader computes with"
    try:
        size = abs(float(value))
    except OverflowError:
        size = math.inf
    if not size <= float(np.finfo(np.float32).max):
        what = "this number" if math.isinf(size) else f"{value!r}"
        return f"{what} does not fit into a float32; shaders compute in it"
    if 0 < size < SMALLEST:
        return f"{value!r} is 0 in a float32; shaders compute in it. Use at least {SMALLEST:.3g}"
    return ""


def exact(expr: Expr) -> Any:
    """The value of an expression made of numbers alone, as Python computes it; None of any other.

    Raises:
        ArithmeticError: Python cannot compute it.
    """
    if isinstance(expr, (Number, Constant)):
        return expr.value
    if isinstance(expr, Negation) and expr.type == "float":
        inner = exact(expr.value)
        return None if inner is None else -inner
    if isinstance(expr, Operation) and expr.operator in ARITHMETIC:
        left = exact(expr.left)
        right = None if left is None else exact(expr.right)
        return None if right is None else ARITHMETIC[expr.operator](left, right)
    return None


def truth(value: Value) -> Static | None:
    """What is known of a condition when the shader is made: an option's, or that of named numbers."""
    if isinstance(value, Static):
        return value
    if isinstance(value, Operation) and value.operator in COMPARISON:
        left, right = exact(value.left), exact(value.right)
        if left is not None and right is not None:
            return Static(COMPARISON[value.operator](left, right))
        return None
    if isinstance(value, Operation) and value.operator in JOINED:
        one, other = truth(value.left), truth(value.right)
        if one is None or other is None:
            return None
        return Static(JOINED[value.operator](one.value, other.value))
    if isinstance(value, (Number, Constant, Negation, Operation)):
        known = exact(value)
        return None if known is None else Static(known)
    return None


def single(expr: Expr) -> float:
    """The value of an expression made of numbers alone, as a shader's compiler computes it."""
    with np.errstate(all="ignore"):
        return float(_single(expr))


def _single(expr: Expr) -> Any:
    if isinstance(expr, (Number, Constant)):
        return np.float32(expr.value)
    if isinstance(expr, Negation):
        return -_single(expr.value)
    assert isinstance(expr, Operation)
    return ARITHMETIC[expr.operator](_single(expr.left), _single(expr.right))


def spoken(kind: Type) -> str:
    """A type in words."""
    if isinstance(kind, Struct):
        return kind.name
    return {"float": "number", "bool": "mask", "bool3": "mask of a colour"}.get(kind, kind)


def shown_kind(value: Any) -> str:
    """A value that no shader has, by its type."""
    return f"a {type(value).__name__}"


def shown(value: Any) -> str:
    """What only the exporter sees, in words."""
    if isinstance(value, types.ModuleType):
        return f"the module {value.__name__}"
    name = getattr(value, "__name__", None)
    return name if isinstance(name, str) else repr(value)


def factor(expr: Expr) -> float:
    """The size of the numbers that an expression multiplies what is not known by; 1 if there are none."""
    if isinstance(expr, (Number, Constant)):
        return abs(float(expr.value)) or 1.0
    if isinstance(expr, (Negation, Splat)):
        return factor(expr.value)
    if isinstance(expr, Operation) and expr.operator in "*/":
        left, right = factor(expr.left), factor(expr.right)
        return left * right if expr.operator == "*" else left / right
    return 1.0
