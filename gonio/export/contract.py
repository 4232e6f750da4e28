"""The methods that every model has: their types, and the function behind each that is exported."""

from __future__ import annotations

import inspect
import types
from typing import Any, cast

from gonio.export import library
from gonio.export.source import source
from gonio.export.tree import ExportError, Struct, Type
from gonio.model import Model

# `eval` without the test for the horizon.
UNTESTED = "eval_above"

# The types of a model's own methods, which its users call.
SIGNATURES: dict[str, tuple[tuple[tuple[str, Type], ...], Type | None]] = {
    "eval": ((("wi", "vec3"), ("wo", "vec3")), "vec3"),
    UNTESTED: ((("wi", "vec3"), ("wo", "vec3")), "vec3"),
    "sample": ((("wo", "vec3"), ("u", "vec2")), None),
    "pdf": ((("wi", "vec3"), ("wo", "vec3")), "float"),
    "albedo": ((("wo", "vec3"),), "vec3"),
    "mean_albedo": ((), "vec3"),
}

# Methods of `gonio.model.Model` that are exported as they stand there, where a model has none of its own.
OF_ALL = ("sample_leaving", "pdf_leaving")

# What a shader may ask of `gonio.model.Model` itself.
OF_EVERY_MODEL = {*SIGNATURES, *OF_ALL, "at_least_as_rough", "name"}
NO_MEANING = "{!r} has no meaning in a shader; use parameters and options."


class MissingMethodError(ExportError):
    """A method that is not there, or that Python integrates."""


def written(name: str, found: Any) -> types.FunctionType | None:
    """The function that a model's author wrote, without the contract around its own methods."""
    if isinstance(found, property):
        found = found.fget
    if name in SIGNATURES and isinstance(found, types.FunctionType):
        found = getattr(found, "__wrapped__", found)
    return found if isinstance(found, types.FunctionType) else None


def method_of(owner: Struct, name: str) -> types.FunctionType:
    """The function that a model's author wrote for a method, or the one that stands for Model's own.

    Raises:
        ExportError: there is none that could be exported.
    """
    model = owner.model
    assert model is not None
    found = inspect.getattr_static(model.written, name)
    function = written(name, found)
    if function is None:
        raise MissingMethodError(f"{model.written.__name__}.{name} is no plain method.")
    if name not in OF_ALL and function is written(name, vars(Model).get(name)):
        if name == "albedo":
            return cast(types.FunctionType, library.sampled_albedo)
        if name == "mean_albedo":
            raise MissingMethodError(
                f"{model.name} has no closed form of its mean albedo, which shading code cannot integrate; "
                "choose another base, or an option that does not need it."
            )
        raise MissingMethodError(
            f"{model.name} has no {name}; write the method, or leave it out: --only eval, for example."
        )
    if hasattr(function, "__wrapped__"):
        inner = cast(types.FunctionType, inspect.unwrap(function))
        file = source(inner.__code__.co_filename)
        raise file.complaint(
            file.function(inner),
            f"{name} is wrapped by a decorator, which would be left out; write what the decorator does "
            "into the method.",
        )
    return function
