"""What plug-ins make of their properties: textures and constants."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import drjit as dr
import mitsuba as mi

from gonio.fields import ModelError, Parameter
from gonio.lang import vec3
from gonio.materials.notation import extinction_of, metal_parameters, named_index
from gonio.messages import did_you_mean
from gonio.mitsuba.upsampling import rgb_constant
from gonio.model import Model

PREFIX = "gonio_"

PLUGIN = "gonio_layered_reference"
"""Name of the BSDF that is the ground truth for layers."""


def plain(w: Any) -> Any:
    """Mitsuba's vector as one of gonio's."""
    return vec3(w.x, w.y, w.z)


def reject_unknown(name: str, known: Collection[str], properties: Any) -> None:
    """Raise a ModelError for the first property that the plug-in of a model does not have."""
    for given in properties.keys():  # noqa: SIM118 (not a dictionary)
        if given not in known:
            did = did_you_mean(given, known)
            raise ModelError(
                f"{PREFIX}{name} has no property {given!r}; {did}known are {', '.join(known)}."
            )


METAL = ("metal", "neutral")
"""Properties that stand for the index and extinction of a named metal."""


def metal_of(cls: type[Model], properties: Any) -> dict[str, Any]:
    """Index and extinction of the metal that `<string name="metal" value="Cu"/>` names; {} without one.

    Raises:
        ModelError: an unknown metal, a model without one, or an index given beside it.
    """
    if "metal" not in properties or "metal" in cls.fields:
        return {}
    neutral = bool(properties.get("neutral", False))
    found = metal_parameters(cls, properties["metal"], neutral)
    for name in found:
        if name in properties:
            raise ModelError(f"{PREFIX}{cls.name}: metal already says what {name} is; drop one.")
    return found


def transparent(cls: type[Model], properties: Any) -> dict[str, float]:
    """No extinction beside an index named by `<string name="eta" value="water"/>`, where none is given."""
    text = mi.Properties.Type.String
    words = (n for n in cls.fields if n in properties and properties.type(n) == text)
    beside = {extinction_of(name) for name in words}
    return {n: 0.0 for n in beside if isinstance(cls.fields.get(n), Parameter)}


SAMPLING = "sampling"
"""Property that says how a plug-in continues paths."""

SAMPLINGS = ("own", "cosine", "uniform")
"""Its values: the model's own sampler, or one that knows nothing of the model."""


def sampling_of(name: str, properties: Any) -> str:
    """How a plug-in continues paths; its model's own way where nothing is said.

    Raises:
        ModelError: something that is not one of SAMPLINGS.
    """
    found = str(properties.get(SAMPLING, SAMPLINGS[0]))
    if found not in SAMPLINGS:
        raise ModelError(
            f"{PREFIX}{name}: {SAMPLING} is {found!r}; allowed are {', '.join(SAMPLINGS)}."
        )
    return found


_slow: set[str] = set()


def say_slow() -> None:
    """Say once that a scalar variant runs these plug-ins in Python, ray by ray."""
    if mi.variant() not in _slow:
        _slow.add(mi.variant())
        mi.Log(
            mi.LogLevel.Warn,
            f"gonio's plug-ins are Python, which {mi.variant()} calls for every ray: pictures take "
            "hundreds of times as long as in an llvm or cuda variant, such as llvm_ad_rgb.",
        )


def parameter_texture(model: str, declared: Parameter, properties: Any, default: Any = None) -> Any:
    """The texture of a parameter: the one given, or a constant one made from numbers or the default."""
    name = declared.name
    value = properties.get(name, declared.default if default is None else default)
    if isinstance(value, mi.Texture):
        return value
    if name in properties and properties.type(name) == mi.Properties.Type.Spectrum:
        for v in value.values:
            declared.check(model, float(v))
        if declared.width == 3:
            return properties.get_unbounded_texture(name)
        if value.is_uniform():
            value = float(value.values[0])
    elif isinstance(value, str):  # <string name="eta" value="water"/>
        value = named_index(PREFIX + model, declared, value) or value
    elif dr.is_array_v(value) and len(value) == 3:  # <rgb>
        value = tuple(float(v) for v in value)
    if isinstance(value, bool) or not isinstance(value, (int, float, tuple)):
        allowed = "a number, an RGB colour, a spectrum" if declared.width == 3 else "a number"
        raise ModelError(
            f"{PREFIX}{model}: {name} is a {type(value).__name__}; "
            f"allowed are {allowed} and a texture."
        )
    if isinstance(value, tuple) and declared.width == 1:
        value = sum(value) / 3  # the mean stands for a colour where one number is needed
    value = declared.check(model, value)
    if declared.width == 3 and mi.is_spectral:
        return rgb_constant(value if isinstance(value, tuple) else (value,) * 3)
    constant = mi.Properties()
    constant["value"] = mi.ScalarColor3d(value) if isinstance(value, tuple) else value
    return constant.get_unbounded_texture("value")  # the range has been checked
