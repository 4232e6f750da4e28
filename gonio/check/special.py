"""Numbers in a model's source at which its formulas may change: thresholds, limits and defaults."""

from __future__ import annotations

import ast
import functools
import inspect
import math
import sys

from gonio.model import Child, Model

# More numbers than this are tables of fits, not thresholds; the first ones are enough.
MOST = 24


def inner_models(model: Model) -> list[Model]:
    """All models inside a model, at every depth."""
    found = []
    for name, declared in model.fields.items():
        if isinstance(declared, Child):
            inner = getattr(model, name)
            found += [inner, *inner_models(inner)]
    return found


def literals(model: Model) -> tuple[float, ...]:
    """The numbers that the model's own file and those of its inner models contain, smallest first."""
    found: set[float] = set()
    for cls in _classes(model):
        found |= set(_in_module(cls.__module__))
    return tuple(sorted(found))[: 4 * MOST]


def _classes(model: Model) -> list[type]:
    return [
        cls
        for one in [model, *inner_models(model)]
        for cls in one.written.__mro__
        if issubclass(cls, Model) and cls is not Model
    ]


@functools.cache
def _in_module(name: str) -> tuple[float, ...]:
    """Numbers that are compared with something, or given to a function that limits; then all others."""
    module = sys.modules.get(name)
    try:
        tree = ast.parse(inspect.getsource(module)) if module else None
    except (OSError, TypeError, SyntaxError):
        tree = None
    if tree is None:
        return ()
    compared, others = [], []
    for node in ast.walk(tree):
        if isinstance(node, ast.Compare):
            compared += [_value(n) for n in ast.walk(node)]
        elif isinstance(node, ast.Call) and _is_limit(node.func):
            compared += [_value(n) for arg in node.args for n in ast.walk(arg)]
        elif isinstance(node, ast.Constant):
            others.append(_value(node))
    found = dict.fromkeys(v for v in [*compared, *others] if v is not None and math.isfinite(v))
    return tuple(found)[:MOST]


def _is_limit(function: ast.expr) -> bool:
    return isinstance(function, ast.Name) and function.id in {"minimum", "maximum", "clamp"}


def _value(node: ast.AST) -> float | None:
    value = node.value if isinstance(node, ast.Constant) else None
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return float(value)
    return None
