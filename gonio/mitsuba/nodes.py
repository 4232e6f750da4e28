"""Models, materials and stacks of layers as dicts for `mitsuba.load_dict`."""

from __future__ import annotations

import functools
from typing import Any

import mitsuba as mi

from gonio.fields import ModelError, is_array
from gonio.images import Pixels
from gonio.materials import Material
from gonio.materials.material import GROWTH_PARAMETER
from gonio.materials.texture_file import stored_values, texture_values
from gonio.materials.toml_file import FLAKE_SETTINGS
from gonio.mitsuba.properties import PLUGIN, PREFIX, SAMPLING
from gonio.mitsuba.register import is_registered, register
from gonio.mitsuba.textures import flake_map, flake_texture, growth_texture
from gonio.model import Model
from gonio.reference import Stack


def node(shown: Any, sampling: str = "own") -> dict[str, Any]:
    """A model, a material or a stack of layers as a dict for `mitsuba.load_dict`.

    A stack is one `gonio_layered_reference` in another.

    Args:
        shown: the model, material or stack.
        sampling: how paths are continued: by the model's "own" sampler, or "cosine" or "uniform", to
            see what that does to the noise.

    Raises:
        ModelError: a parameter is an array; pictures take numbers, colours and Mitsuba's textures.
        ValueError: another sampling than its own for a stack, whose walks are its sampler.
        TypeError: something else.
    """
    made = _dict_of(shown)
    if sampling != "own":
        if isinstance(shown, Stack):
            raise ValueError(f"a stack of layers has a sampler of its own only, not {sampling!r}.")
        inner = made["bsdf"] if made["type"] == "normalmap" else made
        inner[SAMPLING] = sampling
    return made


@functools.singledispatch
def _dict_of(shown: Any) -> dict[str, Any]:
    raise TypeError(f"a picture shows a model, a material or a stack of layers, not {shown!r}.")


@_dict_of.register
def _(model: Model) -> dict[str, Any]:
    if not is_registered(model.written):
        register(model.written)  # from a user's file, which gonio's registry does not hold
    made: dict[str, Any] = {"type": PREFIX + model.name}
    for name in model.fields:
        value = getattr(model, name)
        if is_array(value):
            raise ModelError(
                f"{model.name}: {name} is an array; a picture takes numbers, colours or textures."
            )
        if isinstance(value, tuple):
            value = {"type": "rgb", "value": list(value)}
        made[name] = _dict_of(value) if isinstance(value, Model) else value
    return made


@_dict_of.register
def _(material: Material) -> dict[str, Any]:
    made = _dict_of(material.model)
    widths = {path: declared.width for path, declared, _ in material.model.parameters()}
    for path, picture in material.textures.items():
        outer, _, name = path.rpartition(".")
        values = texture_values(picture, material.channels.get(path), widths[path])
        _at(made, outer)[name] = _bitmap(values, material.texture_scale)
    if material.flakes:
        settings = dict(material.flakes)
        tiles, fade = (
            settings.pop("tiles", FLAKE_SETTINGS["tiles"].default),
            settings.pop("fade", None),
        )
        _at(made, material.driven).update(flake_texture(flake_map(**settings), tiles, fade))
    if material.grows:
        _at(made, material.driven)[GROWTH_PARAMETER] = growth_texture()
    if material.normal_map is not None:
        normals = _bitmap(stored_values(material.normal_map), material.texture_scale)
        made = {"type": "normalmap", "normalmap": normals, "bsdf": made}
    return made


def _at(made: dict[str, Any], path: str) -> dict[str, Any]:
    """The dict of an inner model."""
    for name in filter(None, path.split(".")):
        made = made[name]
    return made


def _bitmap(values: Pixels, scale: tuple[float, float]) -> dict[str, Any]:
    repeated = mi.ScalarTransform4f().scale([*scale, 1])
    return {"type": "bitmap", "bitmap": mi.Bitmap(values), "raw": True, "to_uv": repeated}


@_dict_of.register
def _(stack: Stack) -> dict[str, Any]:
    made = _dict_of(stack.base)
    for layer in reversed(stack.layers):
        sigma = layer.sigma_a if isinstance(layer.sigma_a, tuple) else (layer.sigma_a,) * 3
        made = {
            "type": PLUGIN,
            "eta": float(layer.eta),
            "alpha": 0.0 if layer.smooth else float(layer.alpha),
            "sigma_a": {"type": "rgb", "value": list(sigma)},
            "thickness": float(layer.thickness),
            "distribution": layer.distribution,
            "base": made,
        }
    return made
