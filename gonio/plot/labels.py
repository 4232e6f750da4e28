"""What the models of a plot are called: by what tells them apart."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from gonio.fields import Parameter, is_array
from gonio.materials.notation import model_text
from gonio.model import Model


def _number(value: Any) -> str:
    if isinstance(value, Model):
        return model_text(value)
    if isinstance(value, tuple):
        distinct = value[:1] if len(set(value)) == 1 else value
        return "/".join(f"{v:.4g}" for v in distinct)
    if isinstance(value, Model):
        return model_text(value)
    return value if isinstance(value, str) else f"{value:.4g}"


def named(models: Sequence[Model]) -> tuple[list[Model], list[str], str]:
    """The models, a label for each, and a line with what they have in common.

    Between the two, every number of every model is told.
    """
    models = [models] if isinstance(models, Model) else list(models)
    if not models:
        raise ValueError("a plot needs at least one model.")
    for m in models:
        for name in m.fields:
            if is_array(getattr(m, name)):
                raise ValueError(
                    f"{m.name}.{name} is an array; a plot needs numbers: make one model per value."
                )
    first = models[0]
    common = {
        name: declared
        for name, declared in first.fields.items()
        if all(
            name in m.fields and parameter_text(m, name) == parameter_text(first, name)
            for m in models
        )
    }
    labels = []
    for m in models:
        telling = []
        for name, declared in m.fields.items():
            differs = any(
                parameter_text(o, name) != parameter_text(m, name)
                for o in models
                if o.written is m.written
            )
            default = declared.is_default(getattr(m, name))
            if name not in common and (isinstance(declared, Parameter) or differs or not default):
                telling.append(f"{name} = {parameter_text(m, name)}")
        labels.append(", ".join([m.name, *telling]))
    told = (
        f"{name} = {parameter_text(first, name)}"
        for name, declared in common.items()
        if isinstance(declared, Parameter) or not declared.is_default(getattr(first, name))
    )
    return models, labels, ", ".join(told)


def parameter_text(model: Model, name: str) -> str:
    """A parameter's value as text."""
    return _number(getattr(model, name))
