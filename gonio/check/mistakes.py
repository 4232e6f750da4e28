"""Mistakes inside a model file: found before anything is measured, with file, line and what to write.

Each method is called once with Dr.Jit arrays, without the base class around it, so that what it returns and
where it stops can be told.
"""

from __future__ import annotations

import ast
import inspect
import linecache
import re
import textwrap
import traceback
from collections.abc import Iterator
from typing import Any

import drjit as dr
import numpy as np

from gonio import lang
from gonio.arrays.kernel import opaque
from gonio.check.special import inner_models
from gonio.fields import ModelError, Parameter
from gonio.messages import nearest
from gonio.model import Model, as_written

# Methods, what they are given, and what they return: the width and how it is called.
METHODS = {
    "eval": (("wi", "wo"), 3, "a Color"),
    "pdf": (("wi", "wo"), 1, "a Float"),
    "sample": (("wo", "u"), 0, "Sample(wi, pdf)"),
    "albedo": (("wo",), 3, "a Color"),
}

# Names by which Python's own mathematics is called in a line of code.
FOREIGN = re.compile(r"\b(np|numpy|math|torch|jnp|cmath)\.(\w+)")

# What the same is called in gonio.lang, where it has another name.
SPELLED = {
    "arccos": "safe_acos",
    "acos": "safe_acos",
    "arcsin": "safe_asin",
    "asin": "safe_asin",
    "where": "select",
    "clip": "clamp",
    "pow": "power",
    "abs": "absolute",
    "fabs": "absolute",
    "min": "minimum",
    "max": "maximum",
    "linalg": "length",
    "pi": "PI",
    "array": "vec3",
    "if": "select",
}


def find(model: Model, Float: Any) -> None:
    """Raise a ModelError about the first mistake in a model or in one inside it.

    Args:
        model: what is looked at.
        Float: the number type of the kernel.

    Raises:
        ModelError: with the file, the line, and what to write.
    """
    for one in [model, *inner_models(model)]:
        _undeclared(one.written)
        _called(one, Float)


def _undeclared(cls: type[Model]) -> None:
    """Annotations that look like parameters, but are not declared with param()."""
    for owner in cls.__mro__:
        if not (isinstance(owner, type) and issubclass(owner, Model)) or owner is Model:
            continue
        for name, kind in inspect.get_annotations(owner, eval_str=False).items():
            word = kind if isinstance(kind, str) else _word(kind)
            if word in {"Float", "Color", "Vec2", "Vec3"} and name not in cls.fields:
                where = _line_of(owner, rf"^\s*{name}\s*:")
                value = vars(owner).get(name, 0.5)
                raise ModelError(
                    f"{where}: {name} is no parameter without param(); write {name}: {word} = "
                    f'param({value!r}, 0, 1, "what it means"), or leave the annotation away for a constant.'
                )


def _word(kind: Any) -> str:
    known = {"Float": lang.Float, "Color": lang.Color, "Vec2": lang.Vec2, "Vec3": lang.Vec3}
    return next((name for name, value in known.items() if kind is value), "")


def _called(model: Model, Float: Any) -> None:
    Vec2, Vec3 = dr.replace_shape_t(Float, (2, -1)), dr.replace_shape_t(Float, (3, -1))

    def convert(path: str, declared: Parameter, value: Any) -> Any:
        return opaque(Float, declared.width, value)

    bound = model.bind(Float, convert)
    given = {
        "wi": Vec3(Float(0.6, 0), Float(0, 0), Float(0.8, 1)),
        "wo": Vec3(Float(0, -0.8), Float(0.6, 0), Float(0.8, 0.6)),
        "u": Vec2(Float(0.3, 0.6), Float(0.7, 0.2)),
    }
    for name, (arguments, width, wanted) in METHODS.items():
        if not model.writes(name):
            continue
        method = as_written(getattr(model.written, name))
        try:
            result = method(bound, *(given[a] for a in arguments))
        except ModelError:
            raise
        except Exception as error:
            raise ModelError(_stopped(model.written, method, error)) from error
        if complaint := _unfit(name, result, width, wanted):
            where = _return_of(method)
            raise ModelError(f"{where}: {model.name}.{name} {complaint}")


def _unfit(name: str, result: Any, width: int, wanted: str) -> str:
    """What is wrong with a result; nothing if it is what the method has to return."""
    if result is None:
        return f"returns None; every path through it has to end in 'return', with {wanted}."
    if name == "sample":
        if not isinstance(result, tuple) or len(result) != 2:
            return f"returns {_kind(result)} alone; write return {wanted}, with the density of wi."
        found = [_unfit("wi", result[0], 3, "a Vec3"), _unfit("pdf", result[1], 1, "a Float")]
        return next((f"has a part that {text}" for text in found if text), "")
    if isinstance(result, (np.ndarray, np.generic)):
        return "returns a NumPy array; write it with the functions of gonio.lang, not with NumPy's."
    if not (dr.is_array_v(result) or isinstance(result, (int, float))):
        return f"returns {_kind(result)}; write return with {wanted}."
    components = dr.size_v(result) if dr.depth_v(result) == 2 else 1
    if width == 1 and components != 1:
        return f"returns {_kind(result)}; a density is one number, {wanted}."
    if width == 3 and components == 2:
        return f"returns {_kind(result)}; write return with {wanted}."
    return ""


def _kind(value: Any) -> str:
    if dr.is_array_v(value):
        return {1: "a Float", 2: "a Vec2", 3: "a Vec3"}.get(
            dr.size_v(value) if dr.depth_v(value) == 2 else 1, "an array"
        )
    if isinstance(value, tuple):
        return f"{len(value)} values"
    return f"a {type(value).__name__}"


# --- where a method stopped ----------------------------------------------------------------------


def _stopped(cls: type[Model], method: Any, error: Exception) -> str:
    """File and line of the last step inside the user's own code, and what to write instead."""
    own = {inspect.getsourcefile(c) for c in cls.__mro__ if issubclass(c, Model) and c is not Model}
    frames = [f for f in traceback.extract_tb(error.__traceback__) if f.filename in own]
    frame = frames[-1] if frames else None
    if frame is None:
        return f"{_start_of(method)}: {type(error).__name__}: {error}"
    where = f"{frame.filename}, line {frame.lineno}"
    return f"{where}: {_advice(cls, error, frame.filename, frame.lineno or 0)}"


def _advice(cls: type[Model], error: Exception, filename: str, lineno: int) -> str:
    line = linecache.getline(filename, lineno).strip()
    reason = " ".join(str(error).split())
    if isinstance(error, (NameError, UnboundLocalError)):
        name = getattr(error, "name", "") or ""
        if hasattr(lang, name):
            return f"{name} is not known here; write 'from gonio.lang import {name}' at the top."
        if name in cls.fields:
            return f"{name} is not known here; a parameter is written self.{name}."
        near = nearest(name, (n for n in dir(lang) if not n.startswith("_")))
        hint = f"did you mean {near[0]!r} of gonio.lang?" if near else "define or import it."
        return f"{name} is not known here; {hint}"
    if isinstance(error, AttributeError):
        name = getattr(error, "name", "") or ""
        if isinstance(getattr(error, "obj", None), Model):
            near = nearest(name, cls.fields)
            hint = f"; did you mean self.{near[0]}?" if near else ""
            return (
                f"the model has no parameter {name!r}{hint} Declare it in the class: "
                f'{name}: Float = param(0.5, 0, 1, "what it means").'
            )
    if found := FOREIGN.search(line):
        name = SPELLED.get(found[2], found[2])
        known = hasattr(lang, name)
        write = f"{name} of gonio.lang" if known else "a function of gonio.lang (docs/language.md)"
        return f"{found[0]} does not work on the values of a model; write {write}."
    if _tests(line) and ("bool" in reason or "condition" in reason or "scalar" in reason):
        if builtin := re.search(r"\b(min|max)\(", line):
            return (
                f"{builtin[1]} cannot compare the values of a model; write {SPELLED[builtin[1]]} of "
                "gonio.lang."
            )
        return (
            "a value has no truth of its own: it stands for many at once. Write "
            "select(condition, yes, no) in place of if, and & | ~ in place of and, or, not."
        )
    return f"{type(error).__name__}: {reason}"


def _tests(line: str) -> bool:
    return re.search(r"\b(if|while|and|or|not|elif|assert|bool|max|min)\b", line) is not None


# --- lines ---------------------------------------------------------------------------------------


def _start_of(method: Any) -> str:
    return f"{inspect.getsourcefile(method)}, line {method.__code__.co_firstlineno}"


def _return_of(method: Any) -> str:
    """The first return of a method; its head if there is none."""
    try:
        lines, first = inspect.getsourcelines(method)
        tree = ast.parse(textwrap.dedent("".join(lines)))
    except (OSError, SyntaxError):
        return _start_of(method)
    returns = sorted(n.lineno for n in _own(tree.body[0]) if isinstance(n, ast.Return))
    return f"{inspect.getsourcefile(method)}, line {first + (returns[0] - 1 if returns else 0)}"


def _own(node: ast.AST) -> Iterator[ast.AST]:
    """The nodes of a function without those of functions inside it."""
    for child in ast.iter_child_nodes(node):
        yield child
        if not isinstance(child, (ast.FunctionDef, ast.Lambda)):
            yield from _own(child)


def _line_of(cls: type, pattern: str) -> str:
    lines, first = inspect.getsourcelines(cls)
    number = next((n for n, text in enumerate(lines) if re.search(pattern, text)), 0)
    return f"{inspect.getsourcefile(cls)}, line {first + number}"
