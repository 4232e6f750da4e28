"""A material: a model, and what drives some of its parameters from point to point."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from gonio import notebook
from gonio.fields import ModelError
from gonio.model import HEADS, Model

FLAKE_PARAMETERS = ("flake_x", "flake_y")
GROWTH_PARAMETER = "growth"


class MaterialError(ValueError):
    """A material that cannot be used; the message names file, line and remedy."""


@dataclass(frozen=True)
class Material:
    """A model with its parameters, and pictures or maps for some of them."""

    name: str
    model: Model
    description: str = ""
    textures: dict[str, Path] = field(default_factory=dict)
    """Pictures by the path of their parameter; the model has the default there."""
    channels: dict[str, str] = field(default_factory=dict)
    """Which channel of its picture drives a parameter, by its path: "r", "g", "b", "a", "luminance"."""
    flakes: dict[str, Any] = field(default_factory=dict)
    """How to make the map of flakes; empty for none."""
    grows: bool = False
    """Whether growth comes from the mesh, as a vertex attribute."""
    driven: str = ""
    """Path, with a dot behind, of the inner model that flakes and growth drive; "" for the model itself."""
    normal_map: Path | None = None
    """A picture of tangent-space normals, 0.5 + 0.5 n, x along u and y along v."""
    texture_scale: tuple[float, float] = (1.0, 1.0)
    """How often pictures repeat along the texture coordinates u and v."""
    changed: dict[str, Any] = field(default_factory=dict)
    """What was changed since the material was read, for its label."""

    def _repr_html_(self) -> str:
        """A table of the parameters and of the pictures that drive them, for notebooks."""
        maps = dict.fromkeys(self.driven_by_maps(), "a map")
        driven = maps | {path: picture.name for path, picture in self.textures.items()}
        rows = ((path, driven.get(path, value), *rest) for path, value, *rest in self.model.rows())
        title = f"{self.name}: {self.model.written.__name__}"
        return notebook.table(title, self.description, HEADS, rows)

    def driven_by_maps(self) -> list[str]:
        """Paths of the parameters that flakes and growth drive."""
        names = (*(FLAKE_PARAMETERS if self.flakes else ()), *([GROWTH_PARAMETER] * self.grows))
        return [self.driven + name for name in names]

    def replace(self, **changed: Any) -> Material:
        """A copy with some parameters or options changed; a number takes the place of a picture or map.

        Raises:
            ModelError: an unknown name, or a value out of its range.
        """
        inner = tuple(f"{path}." for path in changed if isinstance(changed[path], (str, Model)))
        textures = {
            path: picture
            for path, picture in self.textures.items()
            if path not in changed and not path.startswith(inner)
        }
        maps = self.driven_by_maps()
        given = any(path in changed or path.startswith(inner) for path in maps)
        return dataclasses.replace(
            self,
            model=self.model.replace(**changed),
            textures=textures,
            channels={path: c for path, c in self.channels.items() if path in textures},
            flakes={} if given else self.flakes,
            grows=self.grows and not given,
            changed=self.changed | changed,
        )

    def plain(self) -> tuple[Model, list[str]]:
        """The model alone, for what has no surface, and what has to be said about it.

        Raises:
            ModelError: a picture drives a parameter, which has no one value then.
        """
        if self.normal_map is not None:
            raise ModelError(
                f"{self.name} has a normal map, {self.normal_map.name}, and here is no surface; write a "
                "material file without it."
            )
        if self.textures:
            path, picture = next(iter(self.textures.items()))
            raise ModelError(
                f"{self.name}: {path} comes from {picture.name}, and here it needs one value: write "
                f"{self.name}:{path}=VALUE."
            )
        values = {path: value for path, _, value in self.model.parameters()}
        source = "the mesh" if self.grows else "a map of flakes"
        notes = [
            f"{self.name}: {path} comes from {source}; here it is {values[path]:g}. "
            f"{self.name}:{path}=VALUE changes that."
            for path in self.driven_by_maps()
        ]
        return self.model, notes


def inside(outer: Model, children: Mapping[str, Material], name: str) -> Model | Material:
    """A model with materials inside, as one material if pictures or maps drive anything in them.

    Raises:
        ModelError: maps in two of them.
    """
    textures = {
        f"{path}.{inner}": picture
        for path, child in children.items()
        for inner, picture in child.textures.items()
    }
    channels = {
        f"{path}.{inner}": channel
        for path, child in children.items()
        for inner, channel in child.channels.items()
    }
    mapped = [path for path, child in children.items() if child.flakes or child.grows]
    if len(mapped) > 1:
        raise ModelError(f"{name}: flakes or growth in {' and in '.join(mapped)}; one is allowed.")
    if not (textures or mapped):
        return outer
    if not mapped:
        return Material(name, outer, "", textures, channels)
    child = children[mapped[0]]
    return Material(
        name,
        outer,
        "",
        textures,
        channels,
        child.flakes,
        child.grows,
        f"{mapped[0]}.{child.driven}",
    )
