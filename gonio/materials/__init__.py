"""Materials as small TOML files: the name of a model and its parameters.

    model = "weidlich_wilkie"
    description = "Walnut under a clear lacquer."
    alpha = 0.05
    thickness = "orm.png:g"         # a picture relative to this file drives the parameter

    [base]                          # an inner model
    model = "eon"
    rho = [0.25, 0.12, 0.06]

A picture for a number is grey, or its channel is named: "orm.png:g" (r, g, b, a, luminance), and taken as
it is stored; for a colour it is sRGB, or linear in .exr and .hdr.

Options take their names as strings. `metal = "Au"` stands for eta and k (or metal_eta and metal_k), and
`neutral = true` beside it keeps grey metals grey (see `gonio.parts.metals.metal`). A table
[flakes] (size, density, flake_size, spread, seed, tiles, fade) makes the map of a paint's flakes, and
`growth = "mesh"` lets patina grow in the cavities of whatever mesh it is put on; see
`gonio.mitsuba.textures`.
Materials that come with gonio are in the folder `materials` and are loaded by their names.
"""

from __future__ import annotations

import difflib
import re
import tomllib
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from gonio.fields import ModelError, Parameter
from gonio.images import ImageError
from gonio.materials.notation import parse_model
from gonio.materials.texture_file import split_channel, texture_values
from gonio.model import Child, Model, models

# What a [flakes] table may hold.
FLAKE_SETTINGS = ("size", "density", "flake_size", "spread", "seed", "tiles", "fade")

LIBRARY = Path(__file__).parent


class MaterialError(ValueError):
    """A material file that cannot be used; the message names file, line and remedy."""


@dataclass(frozen=True)
class Material:
    """A model with its parameters, and textures for some of them."""

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


def library() -> dict[str, Path]:
    """The files of the materials that come with gonio, by name, sorted."""
    return {path.stem: path for path in sorted(LIBRARY.glob("*.toml"))}


def load_series(name: str) -> list[Material]:
    """The steps NAME_1, NAME_2, ... among gonio's materials, in order.

    Raises:
        MaterialError: there is no such series (with those that there are).
    """
    steps: dict[str, list[str]] = {}
    for known in library():
        if match := re.fullmatch(r"(.+)_\d+", known):
            steps.setdefault(match[1], []).append(known)
    if name not in steps:
        raise MaterialError(f"no series of materials {name!r}; known are {', '.join(steps)}.")
    return [load_material(step) for step in sorted(steps[name], key=lambda s: (len(s), s))]


def load_material(name: str | Path) -> Material:
    """Read a material: one of gonio's by its name, or a user's file.

    Raises:
        FileNotFoundError: no such file, and no material of that name.
        MaterialError: not TOML, an unknown model or parameter, or a value out of range, with the line.
    """
    known = library()
    path = known.get(str(name), Path(name))
    if not path.is_file():
        near = difflib.get_close_matches(str(name), known, n=1)
        did = f"did you mean {near[0]!r}? " if near else ""
        raise FileNotFoundError(
            f"there is no material file {path}, nor a material of that name; {did}"
            "'gonio list --materials' shows them."
        )
    try:
        text = path.read_text(encoding="utf-8")
        table = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise MaterialError(f"{path}: not a TOML file: {error}.") from None
    description = table.pop("description", "")
    reader = _Reader(path, text)
    if not isinstance(description, str):
        raise reader.error("description", "description must be a text in quotes.")
    flakes, grows = reader.flakes(table), reader.grows(table)
    model = reader.model(table)
    for wanted, name in ((flakes, "flake_x"), (grows, "growth")):
        if wanted and name not in model.fields:
            raise reader.error("model", f"{model.name} has no {name}, which this file drives.")
    return Material(path.stem, model, description, reader.textures, reader.channels, flakes, grows)


def find(text: str, params: Iterable[str] = ()) -> Model | Material:
    """A model from text such as "eon:roughness=1" (see `gonio.materials.notation`), or a material by name.

    Raises:
        ModelError: neither a model nor a material, or parameters for a material.
    """
    name = text.partition(":")[0]
    known = library()
    if name in models() or name not in known:
        if name not in models() and (near := difflib.get_close_matches(name, known, n=1)):
            raise ModelError(
                f"no model and no material {name!r}; did you mean the material {near[0]!r}? "
                "'gonio list' and 'gonio list --materials' show all."
            )
        return parse_model(text, params)
    if text != name or list(params):
        raise ModelError(
            f"{name} is a material and has its parameters; copy {known[name]} to change them."
        )
    return load_material(name)


@dataclass
class _Reader:
    path: Path
    text: str
    textures: dict[str, Path] = field(default_factory=dict)
    channels: dict[str, str] = field(default_factory=dict)

    def flakes(self, table: dict[str, Any]) -> dict[str, Any]:
        """The settings of a [flakes] table, taken out of the file's table."""
        settings = table.pop("flakes", {})
        if not isinstance(settings, dict):
            raise self.error("flakes", "flakes is a table: write [flakes] and settings below.")
        for key, value in settings.items():
            if key not in FLAKE_SETTINGS:
                allowed = ", ".join(FLAKE_SETTINGS)
                raise self.error(key, f"no setting {key!r}; allowed are {allowed}.", "flakes.")
            if isinstance(value, bool) or not isinstance(value, (int, float)):
                raise self.error(key, f"{key} must be a number, got {value!r}.", "flakes.")
        return settings

    def grows(self, table: dict[str, Any]) -> bool:
        """Whether the file says growth = "mesh", which is taken out."""
        if table.get("growth") != "mesh":
            return False
        del table["growth"]
        return True

    def error(self, key: str, message: str, section: str = "") -> MaterialError:
        """An error at the line of a key in a section such as "base.", or at no line if there is none."""
        here = ""
        for number, line in enumerate(self.text.splitlines(), 1):
            if header := re.match(r"\s*\[\s*([^\]]+?)\s*\]", line):
                here = header[1].replace(" ", "").replace('"', "") + "."
            elif here == section and re.match(rf"\s*[\"']?{re.escape(key)}[\"']?\s*=", line):
                return MaterialError(f"{self.path}:{number}: {message}")
        return MaterialError(f"{self.path}: {message}")

    def model(self, table: dict[str, Any], section: str = "") -> Model:
        """The model of a table; `section` is the table's path with a dot behind, "" for the file."""
        known = models()
        name = table.pop("model", None)
        if name is None:
            where = f" under [{section[:-1]}]" if section else ""
            raise self.error(
                "model",
                f"the line 'model = \"NAME\"' is missing{where}; 'gonio list' shows the names.",
            )
        if not isinstance(name, str) or name not in known:
            near = difflib.get_close_matches(str(name), known, n=1)
            did = f"did you mean {near[0]!r}? " if near else ""
            raise self.error("model", f"no model {name!r}; {did}'gonio list' shows all.", section)
        cls = known[name]
        given = self._metal(cls, table, section)
        for key, value in table.items():
            declared = cls.fields.get(key)
            if isinstance(declared, Parameter) and isinstance(value, str):
                self._texture(declared, value, section)
                continue
            if isinstance(declared, Child) and isinstance(value, dict):
                given[key] = self.model(value, f"{section}{key}.")
                continue
            value = tuple(value) if isinstance(value, list) else value
            try:
                cls(**{key: value})
            except ModelError as error:
                raise self.error(key, str(error), section) from None
            given[key] = value
        try:
            return cls(**given)
        except ModelError as error:  # values that do not go together
            raise self.error("model", str(error), section) from None

    def _texture(self, declared: Parameter, value: str, section: str) -> None:
        """Note the picture that drives a parameter, after reading it."""
        key = declared.name
        name, channel = split_channel(value)
        picture = self.path.parent / name
        if not picture.is_file():
            message = f"{key} names a picture that does not exist: {picture}."
            raise self.error(key, message, section)
        try:
            texture_values(picture, channel, declared.width)
        except ImageError as error:
            raise self.error(key, f"{key}: picture {picture}: {error}.", section) from None
        self.textures[section + key] = picture
        if channel is not None:
            self.channels[section + key] = channel

    def _metal(self, cls: type[Model], table: dict[str, Any], section: str) -> dict[str, Any]:
        """eta and k of a named metal, if the table names one."""
        if "metal" not in table or "metal" in cls.fields:
            return {}
        from gonio.parts.metals import metal

        prefix = next((p for p in ("", "metal_") if {p + "eta", p + "k"} <= set(cls.fields)), None)
        if prefix is None:
            raise self.error("metal", f"{cls.name} has no eta and k for a metal.", section)
        try:
            indices = metal(table.pop("metal"), neutral=table.pop("neutral", False) is True)
        except (ValueError, TypeError) as error:
            raise self.error("metal", str(error), section) from None
        return {prefix + name: value for name, value in indices.items()}
