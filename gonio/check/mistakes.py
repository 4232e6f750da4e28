"""Mistakes inside a model file: found before anything is measured, with file, line and what to write.

Each method is called once with Dr.Jit arrays, without the base class around it, so that what it returns and
where it stops can be told.
"""

from __future__ import annotations

import ast
import inspect
import math
import re
import textwrap
from collections.abc import Iterator
from typing import Any

import drjit as dr
import numpy as np

from gonio import lang
from gonio.check.special import inner_models
from gonio.fields import ModelError, Parameter
from gonio.materials.advice import LANGUAGE, Stop, advice, own_files, place, stop
from gonio.materials.model_file import path_of
from gonio.model import Model, as_written

# Methods, what they are given, and what they return: the width and how it is called.
METHODS = {
    "eval": (("wi", "wo"), 3, "a Color"),
    "pdf": (("wi", "wo"), 1, "a Float"),
    "sample": (("wo", "u"), 0, "Sample(wi, pdf)"),
    "albedo": (("wo",), 3, "a Color"),
    "mean_albedo": ((), 3, "a Color"),
}


def find(model: Model, Float: Any) -> list[str]:
    """Raise a ModelError about the first mistake in a model or in one inside it.

    Returns what may be meant as it is, but looks like a mistake.

    Args:
        model: what is looked at.
        Float: the number type of the kernel.

    Raises:
        ModelError: with the file, the line, and what to write.
    """
    found = []
    for one in [model, *inner_models(model)]:
        _undeclared(one.written)
        found += _called(one, Float)
    return found


def notes(model: Model, Float: Any) -> list[str]:
    """What works in Python, but is outside the language or looks like a mistake: file, line and words.

    Files of gonio itself are not looked at.
    """
    if path_of(model.written) is None:
        return []
    from gonio.export.outside import outside  # takes a tenth of a second

    read = (f"{place(*e.place)}: {e.reason}" for e in outside(model) if e.place)
    return [*find(model, Float), *read]


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


def _called(model: Model, Float: Any) -> list[str]:
    Vec2, Vec3 = dr.replace_shape_t(Float, (2, -1)), dr.replace_shape_t(Float, (3, -1))
    held: dict[str, Any] = {}

    def convert(path: str, declared: Parameter, value: Any) -> Any:
        held[f"self.{path}"] = found = _two(Float, declared, value)
        return found

    bound = model.bind(Float, convert)
    given = {
        "wi": Vec3(Float(0.6, 0), Float(0, 0), Float(0.8, 1)),
        "wo": Vec3(Float(0, -0.8), Float(0.6, 0), Float(0.8, 0.6)),
        "u": Vec2(Float(0.3, 0.6), Float(0.7, 0.2)),
    }
    held |= given
    remarks = []
    before = {name: value.numpy().copy() for name, value in held.items()}
    for name, (arguments, width, wanted) in METHODS.items():
        if not model.writes(name):
            continue
        method = as_written(getattr(model.written, name))
        try:
            result = method(bound, *(given[a] for a in arguments))
        except Exception as error:
            if (found := stopped(model, error)) is None:
                reason = (
                    error if isinstance(error, ModelError) else f"{type(error).__name__}: {error}"
                )
                found = ModelError(f"{_start_of(method)}: {reason}")
            raise found from error
        if complaint := _unfit(name, result, width, wanted):
            where = _return_of(method)
            raise ModelError(f"{where}: {model.name}.{name} {complaint}")
        for path, value in held.items():
            if not np.array_equal(value.numpy(), before[path], equal_nan=True):
                raise ModelError(
                    f"{_changes_of(model, method)}: {name} changes {path} itself, which later steps compute"
                    " with; write x = x + y in place of x += y."
                )
        coloured = any(declared.width == 3 for _, declared, _ in model.parameters())
        if width == 3 and coloured and _kind(result) not in ("a Vec3", "a Color"):
            remarks.append(
                f"{_return_of(method)}: {name} returns one number for all three channels; if that is not "
                "meant, multiply it by a Color."
            )
    return remarks


def _two(Float: Any, declared: Parameter, value: Any) -> Any:
    """A parameter's values for two rays, of which no decision holds for both."""
    end = declared.high if math.isfinite(declared.high) else declared.low + 1
    channels = value if isinstance(value, tuple) else (value,) * declared.width
    pairs = [Float(v, (v + (end if v != end else declared.low)) / 2) for v in channels]
    return pairs[0] if declared.width == 1 else dr.replace_shape_t(Float, (3, -1))(*pairs)


def _unfit(name: str, result: Any, width: int, wanted: str) -> str:
    """What is wrong with a result; nothing if it is what the method has to return."""
    if result is None:
        return f"returns None; every path through it has to end in 'return', with {wanted}."
    if name == "sample":
        if not isinstance(result, tuple) or len(result) != 2:
            return f"returns {_kind(result)} alone; write return {wanted}, with the density of wi."
        wi, pdf = (
            _unfit(*part) for part in (("wi", result[0], 3, "a Vec3"), ("pdf", result[1], 1, ""))
        )
        if wi or pdf:
            kinds = " and ".join(_kind(part) for part in result)
            return f"returns {kinds}; write return {wanted}: a Vec3, and a Float."
        return ""
    if isinstance(result, (np.ndarray, np.generic)):
        return "returns a NumPy array; write it with the functions of gonio.lang, not with NumPy's."
    if isinstance(result, bool) or dr.is_mask_v(result):
        return f"returns a mask; write return select(mask, yes, no), with {wanted}."
    if isinstance(result, (tuple, list)) and width == 3 and len(result) == 3:
        return f"returns {_kind(result)}; write return vec3(x, y, z), {wanted}."
    if not (dr.is_array_v(result) or isinstance(result, (int, float))):
        return f"returns {_kind(result)}; write return with {wanted}."
    components = dr.size_v(result) if dr.depth_v(result) == 2 else 1
    if width == 1 and components != 1:
        return f"returns {_kind(result)}; a density is one number, {wanted}."
    if width == 3 and components == 2:
        return f"returns {_kind(result)}; write return with {wanted}."
    return ""


def _kind(value: Any) -> str:
    if dr.is_mask_v(value):
        return "a mask"
    if dr.is_array_v(value):
        return {1: "a Float", 2: "a Vec2", 3: "a Vec3"}.get(
            dr.size_v(value) if dr.depth_v(value) == 2 else 1, "an array"
        )
    if isinstance(value, tuple):
        return f"{len(value)} values"
    return f"a {type(value).__name__}"


# --- where a method stopped ----------------------------------------------------------------------


def stopped(model: Model, error: Exception) -> ModelError | None:
    """File, line and what to write, for an exception that went through a model's own file; else None."""
    for one in [model, *inner_models(model)]:
        at = stop(error, own_files(one.written))
        if at is not None:
            return ModelError(f"{at.where}: {_sentence(one, error, at)}")
    return None


def _sentence(model: Model, error: Exception, at: Stop) -> str:
    text = advice(error, at, model.written)
    if text and "super(" not in at.text:
        return text
    from gonio.export.outside import outside

    places = {e.place[1]: e.reason for e in outside(model) if e.place is not None}
    if at.line in places:
        return places[at.line]
    found = text or f"{type(error).__name__}: {' '.join(str(error).split())}"
    others = " ".join(f"See line {line} as well: {reason}" for line, reason in places.items())
    return f"{found.rstrip('.')}. {others or LANGUAGE}"


# --- lines ---------------------------------------------------------------------------------------


def _start_of(method: Any) -> str:
    return place(str(inspect.getsourcefile(method)), method.__code__.co_firstlineno)


def _return_of(method: Any) -> str:
    """The first return of a method; its head if there is none."""
    try:
        lines, first = inspect.getsourcelines(method)
        tree = ast.parse(textwrap.dedent("".join(lines)))
    except (OSError, SyntaxError):
        return _start_of(method)
    returns = sorted(n.lineno for n in _own(tree.body[0]) if isinstance(n, ast.Return))
    return place(str(inspect.getsourcefile(method)), first + (returns[0] - 1 if returns else 0))


def _changes_of(model: Model, method: Any) -> str:
    """Where a value that others hold is changed: as exports tell, else the first such step."""
    from gonio.export.outside import outside

    for error in outside(model):
        if error.place is not None and "=" in error.reason and "Python changes" in error.reason:
            return place(*error.place)
    lines, first = inspect.getsourcelines(method)
    tree = ast.parse(textwrap.dedent("".join(lines)))
    steps = [n.lineno for n in ast.walk(tree) if isinstance(n, ast.AugAssign)]
    return place(str(inspect.getsourcefile(method)), first + (min(steps) - 1 if steps else 0))


def _own(node: ast.AST) -> Iterator[ast.AST]:
    """The nodes of a function without those of functions inside it."""
    for child in ast.iter_child_nodes(node):
        yield child
        if not isinstance(child, (ast.FunctionDef, ast.Lambda)):
            yield from _own(child)


def _line_of(cls: type, pattern: str) -> str:
    lines, first = inspect.getsourcelines(cls)
    number = next((n for n, text in enumerate(lines) if re.search(pattern, text)), 0)
    return place(str(inspect.getsourcefile(cls)), first + number)
