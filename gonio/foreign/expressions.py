"""Formulas that users write between code and directions, such as alpha=roughness*roughness or L=-wi.

Python's syntax with numbers, names, + - * / ** (or ^), components .x .y .z, (r, g, b) and a few functions.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gonio.foreign.source import ForeignError

Array = NDArray[np.float64]


def _dot(a: Any, b: Any) -> Any:
    return (a * b).sum(-1)


def _normalize(a: Any) -> Any:
    return a / np.maximum(np.linalg.norm(a, axis=-1, keepdims=True), 1e-300)


FUNCTIONS: dict[str, Callable[..., Any]] = {
    "sqrt": np.sqrt,
    "exp": np.exp,
    "log": np.log,
    "log2": np.log2,
    "sin": np.sin,
    "cos": np.cos,
    "tan": np.tan,
    "acos": np.arccos,
    "radians": np.radians,
    "degrees": np.degrees,
    "min": np.minimum,
    "max": np.maximum,
    "pow": np.power,
    "dot": _dot,
    "cross": np.cross,
    "normalize": _normalize,
}

CONSTANTS = {"pi": np.pi}

_OPERATIONS: dict[type, Callable[[Any, Any], Any]] = {
    ast.Add: np.add,
    ast.Sub: np.subtract,
    ast.Mult: np.multiply,
    ast.Div: np.divide,
    ast.Pow: np.power,
}


@dataclass(frozen=True)
class Expression:
    """A formula that has been read."""

    text: str
    tree: ast.expr
    names: frozenset[str]
    """What it needs."""

    def value(self, given: Mapping[str, Any]) -> Any:
        """Its value where names stand for (n,), (n, 3) or plain numbers."""
        return _value(self.tree, given)

    @property
    def alone(self) -> str:
        """The name, if it is nothing else."""
        return self.tree.id if isinstance(self.tree, ast.Name) else ""


def parse(text: str) -> Expression:
    """Read a formula.

    Raises:
        ForeignError: it has something else than the above.
    """
    try:
        tree = ast.parse(text.strip().replace("^", "**"), mode="eval").body
    except (SyntaxError, ValueError):
        raise ForeignError(
            f"{text!r} is no formula; write a name, a number or roughness**2."
        ) from None
    names: set[str] = set()
    _look(tree, text, names)
    return Expression(text.strip(), tree, frozenset(names - set(CONSTANTS)))


def _look(node: ast.expr, text: str, names: set[str]) -> None:
    if isinstance(node, ast.Constant) and isinstance(node.value, (int, float)):
        return
    if isinstance(node, ast.Name):
        names.add(node.id)
        return
    if isinstance(node, ast.BinOp) and type(node.op) in _OPERATIONS:
        _look(node.left, text, names)
        _look(node.right, text, names)
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.USub, ast.UAdd)):
        _look(node.operand, text, names)
    elif isinstance(node, ast.Tuple) and len(node.elts) in (2, 3, 4):
        for part in node.elts:
            _look(part, text, names)
    elif isinstance(node, ast.Attribute) and node.attr in "xyz":
        _look(node.value, text, names)
    elif (
        isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in FUNCTIONS
    ):
        for part in node.args:
            _look(part, text, names)
    else:
        known = ", ".join(FUNCTIONS)
        raise ForeignError(
            f"{text!r}: a formula has + - * / ** .x .y .z, numbers, names and {known}."
        )


def _value(node: ast.expr, given: Mapping[str, Any]) -> Any:
    if isinstance(node, ast.Constant):
        return float(node.value)  # type: ignore[arg-type]
    if isinstance(node, ast.Name):
        return given[node.id] if node.id in given else CONSTANTS[node.id]
    if isinstance(node, ast.BinOp):
        a, b = _even(_value(node.left, given), _value(node.right, given))
        return _OPERATIONS[type(node.op)](a, b)
    if isinstance(node, ast.UnaryOp):
        value = _value(node.operand, given)
        return -value if isinstance(node.op, ast.USub) else value
    if isinstance(node, ast.Tuple):
        return np.stack(np.broadcast_arrays(*(_value(part, given) for part in node.elts)), -1)
    if isinstance(node, ast.Attribute):
        return _value(node.value, given)[..., "xyz".index(node.attr)]
    assert isinstance(node, ast.Call)
    assert isinstance(node.func, ast.Name)
    values = [_value(part, given) for part in node.args]
    if node.func.id in ("min", "max", "pow") and len(values) == 2:
        values = list(_even(*values))
    return FUNCTIONS[node.func.id](*values)


def _even(a: Any, b: Any) -> tuple[Any, Any]:
    """A number for each row beside a vector for each row: give the number a last axis."""
    a, b = np.asarray(a), np.asarray(b)
    if a.ndim == 1 and b.ndim == 2:
        return a[:, None], b
    if a.ndim == 2 and b.ndim == 1 and b.shape[0] == a.shape[0]:
        return a, b[:, None]
    return a, b
