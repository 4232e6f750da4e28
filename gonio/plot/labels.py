"""What the models of a plot are called: by what tells them apart."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any

from gonio.fields import Parameter, is_array
from gonio.materials import Material
from gonio.materials.notation import model_text
from gonio.model import Model


def _number(value: Any) -> str:
    if isinstance(value, Model):
        return model_text(value)
    if isinstance(value, tuple):
        distinct = value[:1] if len(set(value)) == 1 else value
        return "/".join(f"{v:.4g}" for v in distinct)
    return value if isinstance(value, str) else f"{value:.4g}"


Shown = Sequence[Model] | Sequence[Model | Material]
"""What a plot takes: models, and materials, which are called by their names."""

# Of texts that are longer, values that are the defaults are left out.
LONG = 90
DEFAULTS = "parameters at their defaults"

Value = tuple[Model, str]
"""A field of a model, by its name."""


def named(shown: Shown) -> tuple[list[Model], list[str], str]:
    """The models, a label for each, and a line with what they have in common.

    Between the two, every number that is not a default is told, and where there is room the defaults too.
    A material's label is its name, with what was changed.
    """
    found = [shown] if isinstance(shown, (Model, Material)) else list(shown)
    if not found:
        raise ValueError("a plot needs at least one model.")
    models = [one.plain()[0] if isinstance(one, Material) else one for one in found]
    for m in models:
        for name in m.fields:
            if is_array(getattr(m, name)):
                raise ValueError(
                    f"{m.name}.{name} is an array; a plot needs numbers: make one model per value."
                )
    plain = [one for one in found if isinstance(one, Model)]
    common = _common(plain) if len(plain) == len(found) else []
    labels = [
        _material_label(one) if isinstance(one, Material) else _label(one, plain, common)
        for one in found
    ]
    if isinstance(found[0], Material):
        return models, labels, found[0].description if len(found) == 1 else ""
    told = [(found[0], name) for name in common if _telling(found[0], name)]
    kept = _without_defaults(told)
    others = kept or any(label != m.name for label, m in zip(labels, models, strict=True))
    rest = [f"{'other' if others else 'all'} {DEFAULTS}"] if len(kept) < len(told) else []
    return models, labels, ", ".join([*map(_value_text, kept), *rest])


def _common(models: Sequence[Model]) -> list[str]:
    """The fields in which all models agree."""
    first = models[0]
    return [
        name
        for name in first.fields
        if all(
            name in m.fields and parameter_text(m, name) == parameter_text(first, name)
            for m in models
        )
    ]


def _telling(model: Model, name: str) -> bool:
    """Parameters always tell something; options and inner models when they are not the default."""
    return isinstance(model.fields[name], Parameter) or not _is_default((model, name))


def _is_default(value: Value) -> bool:
    model, name = value
    return bool(model.fields[name].is_default(getattr(model, name)))


def _material_label(material: Material) -> str:
    changed = [f"{name} = {_number(value)}" for name, value in material.changed.items()]
    return ", ".join([material.name, *changed])


def _label(model: Model, models: Sequence[Model], common: Sequence[str]) -> str:
    """A model's name, and what the others do not share."""
    others = [other for other in models if other.written is model.written]
    differing = {
        name
        for name in model.fields
        if any(parameter_text(other, name) != parameter_text(model, name) for other in others)
    }
    telling = [
        (model, name)
        for name in model.fields
        if name not in common and (name in differing or _telling(model, name))
    ]
    kept = _without_defaults(telling, differing)
    return ", ".join([model.name, *map(_value_text, kept)])


def _without_defaults(values: Sequence[Value], keep: Collection[str] = ()) -> Sequence[Value]:
    """The values, or those that are not the defaults where all would be too long a text."""
    if len(", ".join(map(_value_text, values))) <= LONG:
        return values
    return [value for value in values if value[1] in keep or not _is_default(value)]


def _value_text(value: Value) -> str:
    model, name = value
    return f"{name} = {parameter_text(model, name)}"


def parameter_text(model: Model, name: str) -> str:
    """A parameter's value as text."""
    return _number(getattr(model, name))
