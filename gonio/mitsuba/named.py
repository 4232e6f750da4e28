"""`gonio_material`: a ready material, a material file or a model in its notation, as one plug-in.

    <bsdf type="gonio_material"><string name="name" value="lacquered_walnut"/></bsdf>
    <bsdf type="gonio_material"><string name="name" value="gold:alpha=0.3"/></bsdf>
    <bsdf type="gonio_material"><string name="file" value="clay.toml"/></bsdf>

A file is looked for where Mitsuba looks for files, so beside the scene. Materials with pictures need
texture coordinates; those that grow need the attribute that `gonio.mitsuba.textures.add_growth` makes.
"""

from __future__ import annotations

from typing import Any

import mitsuba as mi

from gonio.fields import ModelError
from gonio.materials import load
from gonio.mitsuba.nodes import node

NAME = "gonio_material"

_known: set[str] = set()


def register() -> None:
    """Register the plug-in for Mitsuba's current variant, once."""
    if mi.variant() is not None and mi.variant() not in _known:
        mi.register_bsdf(NAME, _made)
        _known.add(mi.variant())


def _made(properties: Any) -> Any:
    given = [name for name in properties.keys()]  # noqa: C416, SIM118 (not a dictionary)
    if len(given) != 1 or given[0] not in ("name", "file"):
        raise ModelError(
            f"{NAME} takes either a name or a file, as a string; given: {', '.join(given) or 'neither'}."
        )
    text = properties[given[0]]
    if not isinstance(text, str):
        raise ModelError(f"{NAME}: {given[0]} is a {type(text).__name__}; it takes a string.")
    if given[0] == "file":
        name, colon, values = text.partition(":")
        text = str(mi.file_resolver().resolve(name)) + colon + values
    return mi.load_dict(node(load(text)))
