"""Which lights there are, what they take, and which of their forms fits a model."""

from __future__ import annotations

import functools
import importlib
import inspect
import pkgutil
import types
import typing
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import gonio.lights
from gonio.fields import ModelError
from gonio.lights.lookups import Lookups
from gonio.messages import did_you_mean
from gonio.model import Model, models

# Lights from pictures, in the order in which they are tried where none is named.
PICTURES = ("image", "coat", "layered")

# Arguments that every light takes before its own: the model, the point's frame, and the local wo.
COMMON = 3


@dataclass(frozen=True)
class Form:
    """One function of a light, for the models that have what it asks for."""

    light: str
    function: types.FunctionType
    needs: tuple[str, ...]
    """Methods or parameters of a model."""

    @property
    def arguments(self) -> dict[str, Any]:
        """The light's own arguments, by name, with their types."""
        hints = typing.get_type_hints(self.function, include_extras=True)
        names = list(inspect.signature(self.function).parameters)[COMMON:]
        return {n: hints[n] for n in names if hints[n] not in (Lookups, str)}

    @property
    def choices(self) -> dict[str, tuple[str, ...]]:
        """What can be chosen when a light is exported, with the values; the first is the default."""
        hints = typing.get_type_hints(self.function)
        return {
            name: (parameter.default, *_others(self.function, name, parameter.default))
            for name, parameter in inspect.signature(self.function).parameters.items()
            if hints.get(name) is str
        }

    @property
    def looks_up(self) -> bool:
        """Whether it asks its host for pictures or tables."""
        return Lookups in typing.get_type_hints(self.function).values()

    def missing(self, model: Model) -> list[str]:
        """What the light needs and a model lacks."""
        return [name for name in self.needs if not _has(model, name)]


def _others(function: types.FunctionType, name: str, default: str) -> tuple[str, ...]:
    values: tuple[str, ...] = function.__globals__["CHOICES"][name]
    return tuple(value for value in values if value != default)


def _has(model: Model, name: str) -> bool:
    outer, _, rest = name.partition(".")
    if rest:
        inner = getattr(model, outer, None)
        return isinstance(inner, Model) and _has(inner, rest)
    if name in model.fields:
        return True
    own = inspect.getattr_static(model.written, name, None)
    return own is not None and own is not vars(Model).get(name)


@functools.cache
def lights() -> Mapping[str, tuple[Form, ...]]:
    """All lights by name, each with its forms; the first that fits a model is taken."""
    found = {}
    for module in pkgutil.iter_modules(gonio.lights.__path__):
        forms = getattr(importlib.import_module(f"gonio.lights.{module.name}"), "FORMS", ())
        if forms:
            found[module.name] = tuple(Form(module.name, *form) for form in forms)
    return types.MappingProxyType(found)


def form_for(model: Model, light: str) -> Form:
    """The form of a light that fits a model.

    Raises:
        ModelError: an unknown light, or one that needs what the model lacks.
    """
    known = lights()
    if light not in known:
        did = did_you_mean(light, known)
        raise ModelError(f"no light {light!r}; {did}there are {', '.join(known)}.")
    for form in known[light]:
        if not form.missing(model):
            return form
    others = [name for name in known if any(not f.missing(model) for f in known[name])]
    needed = " or ".join(" and ".join(form.needs) for form in known[light])
    fitting = [name for name, cls in models().items() if _fits(cls, known[light])]
    instead = f"{model.name} can have {', '.join(others)}"
    raise ModelError(
        f"{model.name} cannot have the light {light!r}, which needs a model with {needed}"
        f" ({', '.join(fitting)}); {instead}."
    )


def _fits(cls: type[Model], forms: tuple[Form, ...]) -> bool:
    return any(not form.missing(cls()) for form in forms)


@dataclass(frozen=True)
class Chosen:
    """A light in the form that fits the model, with what was chosen of it."""

    form: Form
    choices: Mapping[str, str]


def chosen(model: Model, lights: Sequence[str]) -> list[Chosen]:
    """The lights that are named, such as "directional" or "harmonics:dc=cheap".

    Raises:
        ModelError: a light or a choice that is not there, or a light that the model cannot have.
    """
    found: list[Chosen] = []
    for text in lights:
        name, _, rest = text.partition(":")
        form = form_for(model, name)
        if any(form.light == other.form.light for other in found):
            raise ModelError(f"the light {name!r} is named twice; name it once.")
        choices = {key: values[0] for key, values in form.choices.items()}
        for pair in filter(None, rest.split(",")):
            key, _, value = pair.partition("=")
            if value not in form.choices.get(key, ()):
                known = ", ".join(f"{k}={'|'.join(v)}" for k, v in form.choices.items())
                raise ModelError(f"{name} has no {pair!r}; it has {known or 'no choices'}.")
            choices[key] = value
        found.append(Chosen(form, choices))
    if not found:
        raise ModelError("no light; name one, such as directional.")
    return found


def usual(model: Model) -> list[str]:
    """The lights of a model for which none is named: one from a direction, and from a picture if it can."""
    known = lights()
    fitting = [n for n in PICTURES if n in known and any(not f.missing(model) for f in known[n])]
    return ["directional", *fitting[:1]]


def listed(texts: Sequence[str]) -> list[str]:
    """Lights from texts like "directional,harmonics:dc=cheap,linear=halved"."""
    found: list[str] = []
    for part in (p.strip() for text in texts for p in text.split(",")):
        if "=" in part and ":" not in part and found:
            found[-1] += f",{part}"
        elif part:
            found.append(part)
    return found
