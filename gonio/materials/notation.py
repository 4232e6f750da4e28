"""Models written as text, as on the command line: eon:roughness=1,rho=0.8/0.3/0.1."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Iterable
from typing import Any

from gonio.fields import ModelError, Parameter
from gonio.materials.model_file import model_class
from gonio.model import Child, Model, model


def parse_model(text: str, params: Iterable[str] = ()) -> Model:
    """Make a model from text, such as "eon:roughness=1,sampler=cosine,rho=0.8/0.3/0.1".

    Args:
        text: a model's name, or the path of a model file (my_model.py), then after a colon parameters and
            options with commas between them. An inner model is given by name, its parameters by their path:
            base=lambert,base.rho=0.5.
        params: further ones, each "name=value", colours as 0.8,0.3,0.1 or 0.8/0.3/0.1. Those in the
            text win.

    Raises:
        ModelError: an unknown model, name or value, or something that is not name=value.
    """
    name, colon, inline = text.partition(":")
    cls = model_class(name)
    if colon and not inline:
        raise ModelError(f"{text!r} ends in a colon; write {name}:name=value or {name}.")
    pieces = inline.split(",") if inline else []
    for before, piece in itertools.pairwise(pieces):
        if "=" in before and "=" not in piece:
            raise ModelError(
                f"{text!r}: {piece!r} is not name=value; in a model's text a colour has slashes, such "
                "as rho=0.8/0.3/0.1."
            )
    values = _parse_values(cls, params) | _parse_values(cls, pieces)
    return cls(**values)


def _parse_values(cls: type[Model], assignments: Iterable[str]) -> dict[str, Any]:
    values: dict[str, Any] = {}
    texts: dict[str, str] = {}
    for assignment in assignments:
        path, equals, value = (part.strip() for part in assignment.partition("="))
        if not equals or not path:
            names = ", ".join(cls.fields)
            raise ModelError(
                f"{cls.name}: {assignment!r} is not name=value; its names are {names}."
            )
        if path in texts:
            raise ModelError(f"{cls.name}: {path} is given twice.")
        texts[path] = value
    for path, value in texts.items():
        declared = _declaration(cls, path, texts)
        if isinstance(declared, Parameter):
            values[path] = _parse_number(cls.name, declared, value)
        else:  # an option, a model, or unknown, of which the model complains
            values[path] = value
    return values


def _declaration(cls: type[Model], path: str, texts: dict[str, str]) -> Any:
    """The declaration behind a path such as base.rho, given what the inner models are."""
    walked = ""
    while "." in path:
        name, _, path = path.partition(".")
        declared = cls.fields.get(name)
        if not isinstance(declared, Child):
            return None
        walked += name
        cls = type(model(texts.get(walked, declared.default)))
        walked += "."
    return cls.fields.get(path)


# Angles as people write them: pi, pi/4, 3pi/8, 0.5*pi.
MULTIPLE_OF_PI = re.compile(r"(?P<times>[\d.]+)?\s*\*?\s*(?:pi|π)\s*(?:/\s*(?P<over>[\d.]+))?")


def parse_angle(text: str) -> float:
    """A number, or a multiple of pi such as pi/4.

    Raises:
        ValueError: neither.
    """
    found = MULTIPLE_OF_PI.fullmatch(text.strip().lower())
    if found is None:
        return float(text)
    over = float(found["over"] or 1)
    if over == 0:
        raise ValueError(f"{text} divides by zero.")
    return float(found["times"] or 1) * math.pi / over


def _parse_number(model: str, declared: Parameter, text: str) -> float | tuple[float, ...]:
    try:
        if declared.width == 1 and MULTIPLE_OF_PI.fullmatch(text.strip().lower()):
            return parse_angle(text)
        numbers = tuple(float(part) for part in re.split(r"[,/]", text))
    except ValueError:
        wish = "a number" if declared.width == 1 else "one or three numbers, such as 0.8,0.3,0.1"
        raise ModelError(
            f"{model}: {declared.name}={text} is not {wish}; allowed is {declared.range_text()}."
        ) from None
    return numbers[0] if len(numbers) == 1 else numbers


def model_text(made: Model) -> str:
    """A model as `parse_model` reads it, such as "weidlich_wilkie:alpha=0.4,base.rho=0.5"."""
    settings = []
    for path, value in _settings(made, ""):
        if isinstance(value, tuple):
            value = "/".join(f"{v:.9g}" for v in value)
        settings.append(f"{path}={value}")
    return made.name + (":" if settings else "") + ",".join(settings)


def _settings(made: Model, prefix: str) -> list[tuple[str, Any]]:
    """Paths and values of all that differs from the defaults, inner models' names first."""
    found: list[tuple[str, Any]] = []
    for name, declared in made.fields.items():
        value = getattr(made, name)
        if isinstance(value, Model):
            if value.name != getattr(declared, "default", ""):
                found.append((prefix + name, value.name))
            found += _settings(value, f"{prefix}{name}.")
        elif not declared.is_default(value):
            found.append((prefix + name, value))
    return found
