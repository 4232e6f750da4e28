"""Materials as small TOML files: the name of a model and its parameters.

    model = "weidlich_wilkie"
    description = "Walnut under a clear lacquer."
    alpha = 0.05
    thickness = "orm.png:g"         # a picture relative to this file drives the parameter

    [base]                          # an inner model
    model = "eon"
    rho = [0.25, 0.12, 0.06]        # linear RGB, or "#8a6244" in sRGB

A picture for a number is grey, or its channel is named: "orm.png:g" (r, g, b, a, luminance), and taken as
it is stored; for a colour it is sRGB, or linear in .exr and .hdr. docs/materials.md describes every key.
Materials that come with gonio lie beside this file.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gonio.fields import ModelError, Parameter
from gonio.images import ImageError, Pixels
from gonio.materials.material import (
    FLAKE_PARAMETERS,
    GROWTH_PARAMETER,
    Material,
    MaterialError,
    inside,
)
from gonio.materials.notation import (
    extinction_of,
    hex_colour,
    metal_parameters,
    named_index,
    settings_of,
)
from gonio.materials.texture_file import split_channel, stored_values, texture_values
from gonio.materials.toml_lines import lines
from gonio.messages import did_you_mean, nearest, notice
from gonio.model import Child, Model, models

# What a [flakes] table may hold; gonio.mitsuba.textures.flake_map says what each does.
FLAKE_SETTINGS = {
    p.name: p
    for p in (
        Parameter(256, 1, 8192, "pixels along each side", "size"),
        Parameter(0.9, 0, 1, "share of the cells that hold a flake", "density"),
        Parameter(4, 1, 8192, "mean distance of neighbouring flakes in pixels", "flake_size"),
        Parameter(0.4, 0, 2, "standard deviation of the slopes", "spread"),
        Parameter(0, 0, 2**32 - 1, "of the random numbers", "seed"),
        Parameter(
            24, 1e-3, 1e6, "how often the map repeats along the texture coordinates", "tiles"
        ),
        Parameter(1, 1e-6, 1e9, "distance at which flakes begin to even out", "fade"),
    )
}
# What a table of a model, and the file itself, may say beside the model's parameters.
OF_MODEL = ("model", "metal")
OF_FILE = (*OF_MODEL, "description", "flakes", "normal_map", "texture_scale")

WHOLE_NUMBERS = ("size", "seed")

# How far values of a picture may leave their range by compression and filtering alone.
CLIPPED_IN_SILENCE = 1e-3


class CircleError(MaterialError):
    """Material files that name each other in a circle."""


Resolve = Callable[[str, Path], Model | Material]
"""Finds what a text names, as seen from a file."""


def read(path: Path, resolve: Resolve) -> Material:
    """Read a material file.

    Args:
        path: the file.
        resolve: finds inner models by name, or by a path relative to the file.

    Raises:
        MaterialError: not TOML, an unknown model or parameter, or a value out of range, with the line.
        OSError: the file cannot be read.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")
        table = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise MaterialError(f"{path}: not a TOML file: {error}.") from None
    except UnicodeDecodeError as error:
        line = error.object.count(b"\n", 0, error.start) + 1
        raise MaterialError(f"{path}:{line}: not a TOML file: save it as UTF-8.") from None
    except ValueError:  # of int, which reads no more than some thousand digits
        raise MaterialError(f"{path}: a number in it has too many digits.") from None
    except RecursionError:
        raise MaterialError(f"{path}: the values are nested too deeply.") from None
    reader = _Reader(path, text, resolve)
    description = table.pop("description", "")
    if not isinstance(description, str):
        raise reader.error("description", "description must be a text in quotes.")
    normal_map, scale = reader.normal_map(table), reader.scale(table)
    flakes, grows = reader.flakes(table), reader.grows(table)
    found = reader.model(table)
    driven = ""
    if flakes or grows:
        wanted = FLAKE_PARAMETERS[0] if flakes else GROWTH_PARAMETER
        paths = [p for p, _, _ in found.model.parameters() if p.rpartition(".")[2] == wanted]
        if not paths:
            said = "[flakes]" if flakes else 'growth = "mesh"'
            fitting = ", ".join(name for name, cls in models().items() if wanted in cls.fields)
            raise reader.error(
                "model",
                f"{found.model.name} has no {wanted}, which {said} drives; a model with it is {fitting}.",
            )
        driven = paths[0].removesuffix(wanted)
    elif found.flakes or found.grows:  # of a material inside
        flakes, grows, driven = found.flakes, found.grows, found.driven
    if scale is not None and not (found.textures or normal_map):
        raise reader.error("texture_scale", "texture_scale is for pictures, and no line names one.")
    return Material(
        path.stem,
        found.model,
        description,
        found.textures,
        found.channels,
        flakes,
        grows,
        driven,
        normal_map or found.normal_map,
        scale or found.texture_scale,
    )


@dataclass
class _Reader:
    path: Path
    text: str
    resolve: Resolve

    def flakes(self, table: dict[str, Any]) -> dict[str, Any]:
        """The settings of a [flakes] table, taken out of the file's table."""
        if "flakes" not in table:
            return {}
        settings = table.pop("flakes")
        if not isinstance(settings, dict):
            allowed = ", ".join(FLAKE_SETTINGS)
            message = f"flakes is a table, got {settings!r}; write [flakes] and below it any of {allowed}."
            raise self.error("flakes", message)
        for key, value in settings.items():
            if key not in FLAKE_SETTINGS:
                did = did_you_mean(key.lower(), FLAKE_SETTINGS)
                allowed = ", ".join(FLAKE_SETTINGS)
                message = f"flakes: no setting {key!r}; {did}allowed are {allowed}."
                raise self.error(key, message, "flakes.")
            declared = FLAKE_SETTINGS[key]
            if key in WHOLE_NUMBERS and (isinstance(value, bool) or not isinstance(value, int)):
                allowed = f"{declared.low:.0f} to {declared.high:.0f}"
                message = (
                    f"flakes: {key} must be a whole number, got {value!r}; allowed is {allowed}."
                )
                raise self.error(key, message, "flakes.")
            try:
                declared.check("flakes", value)
            except ModelError as error:
                raise self.error(key, str(error), "flakes.") from None
        size, flake_size = (
            settings.get(key, FLAKE_SETTINGS[key].default) for key in ("size", "flake_size")
        )
        if flake_size > size:
            blamed = "flake_size" if "flake_size" in settings else "size"
            message = f"flakes: flake_size={flake_size} is larger than the map's size={size}."
            raise self.error(blamed, message, "flakes.")
        return settings or {"seed": 0}

    def normal_map(self, table: dict[str, Any]) -> Path | None:
        """The picture of normals that the file names, taken out."""
        if "normal_map" not in table:
            return None
        value = table.pop("normal_map")
        if not isinstance(value, str):
            raise self.error("normal_map", f"normal_map is a picture in quotes, got {value!r}.")
        picture = self._picture("normal_map", value, "")
        with self._picture_errors("normal_map", picture, ""):
            stored_values(picture)
        return picture

    def scale(self, table: dict[str, Any]) -> tuple[float, float] | None:
        """How often pictures repeat, taken out; None where the file does not say it."""
        if "texture_scale" not in table:
            return None
        value = table.pop("texture_scale")
        numbers = value if isinstance(value, list) else [value, value]
        if len(numbers) != 2 or not all(
            isinstance(n, (int, float)) and not isinstance(n, bool) and 0 < n < math.inf
            for n in numbers
        ):
            raise self.error(
                "texture_scale",
                f"texture_scale is a number above 0, or two for u and v, got {value!r}.",
            )
        return float(numbers[0]), float(numbers[1])

    def grows(self, table: dict[str, Any]) -> bool:
        """Whether the file says growth = "mesh", which is taken out."""
        if table.get("growth") != "mesh":
            return False
        del table["growth"]
        return True

    def error(self, key: str, message: str, section: str = "") -> MaterialError:
        """An error at the line of a key in a section such as "base.", or of what the key is missing in."""
        path = f"{section}{key}"
        found = lines(self.text)
        while path and path not in found:
            path = path.rpartition(".")[0]
        place = f"{self.path}:{found[path]}" if path else f"{self.path}"
        return MaterialError(f"{place}: {message}")

    def model(self, table: dict[str, Any], section: str = "") -> Material:
        """The model of a table; `section` is the table's path with a dot behind, "" for the file."""
        start = self._start(table, section)
        cls = start.model.written
        given: dict[str, Any] = self._metal(cls, table, section)
        children: dict[str, Material] = {}
        textures: dict[str, Path] = {}
        channels: dict[str, str] = {}
        for key, value in table.items():
            declared = cls.fields.get(key)
            if isinstance(declared, Parameter) and isinstance(value, str):
                number = self._word(cls.name, declared, value, section)
                if number is None:
                    textures[key], channel = self._texture(declared, value, section)
                    channels |= {key: channel} if channel else {}
                    continue
                if named_index(cls.name, declared, value) is not None:
                    beside = extinction_of(key)
                    if beside in cls.fields and beside not in table:
                        given[beside] = 0.0
                value = number
            elif isinstance(declared, Child):
                children[key] = self._child(key, value, section)
                given[key] = children[key].model
                continue
            value = tuple(value) if isinstance(value, list) else value
            if key not in cls.fields and "." not in key:
                raise self.error(key, _unknown_key(cls, key, section), section)
            try:
                start.model.replace(**{key: value})
            except (ModelError, TypeError) as error:
                raise self.error(key, str(error), section) from None
            given[key] = value
        try:
            changed = start.replace(**given)
            made = inside(changed.model, children, changed.model.name)
        except ModelError as error:  # values that do not go together
            raise self.error("model", str(error), section) from None
        maps = changed
        pictures = changed.textures | textures
        channels = {p: c for p, c in changed.channels.items() if p not in textures} | channels
        if isinstance(made, Material):  # pictures or maps inside
            maps, made = made, made.model
            pictures, channels = pictures | maps.textures, channels | maps.channels
        return Material(
            start.name, made, "", pictures, channels, maps.flakes, maps.grows, maps.driven
        )

    def _start(self, table: dict[str, Any], section: str) -> Material:
        """What the line 'model = ...' names, before the other lines change it."""
        name = table.pop("model", None)
        if name is None:
            where = f" under [{section[:-1]}]" if section else ""
            raise self.error(
                "model",
                f"the line 'model = \"NAME\"' is missing{where}; 'gonio list' shows the names.",
                section,
            )
        if not isinstance(name, str):
            raise self.error("model", f"model must be a name in quotes, got {name!r}.", section)
        return self._found("model", name, section)

    def _found(self, key: str, name: str, section: str) -> Material:
        try:
            found = self.resolve(name, self.path)
        except CircleError:  # one line is enough, however often the circle was gone round
            raise
        except (ValueError, OSError) as error:
            raise self.error(key, str(error), section) from None
        return found if isinstance(found, Material) else Material(found.name, found)

    def _child(self, key: str, value: Any, section: str) -> Material:
        if isinstance(value, dict):
            return self.model(value, f"{section}{key}.")
        if isinstance(value, str):
            return self._found(key, value, section)
        raise self.error(
            key,
            f"{key} is a model: write its name, a file, or a table [{section}{key}], not {value!r}.",
            section,
        )

    def _word(
        self, model: str, declared: Parameter, value: str, section: str
    ) -> float | tuple[float, float, float] | None:
        """A colour such as "#c08040" or an index such as "water"; None for the name of a picture."""
        if declared.width == 3 and (colour := hex_colour(value)) is not None:
            return colour
        if value.startswith("#") and not (self.path.parent / split_channel(value)[0]).is_file():
            message = f"{declared.name} takes one number, and {value} is a colour."
            if declared.width == 3:
                message = f"{declared.name}: {value} is not a colour such as #c08040."
            raise self.error(declared.name, message, section)
        try:
            return named_index(model, declared, value)
        except ModelError as error:
            raise self.error(declared.name, str(error), section) from None

    def _texture(self, declared: Parameter, value: str, section: str) -> tuple[Path, str | None]:
        """The picture that drives a parameter, after reading it, and the channel that is named."""
        key = declared.name
        name, channel = split_channel(value)
        picture = self._picture(key, name, section)
        with self._picture_errors(key, picture, section):
            values = texture_values(picture, channel, declared.width)
        self._say_what_is_clipped(declared, picture, values, section)
        return picture, channel

    def _picture(self, key: str, name: str, section: str) -> Path:
        picture = self.path.parent / name
        if not picture.is_file():
            message = f"{key} names a picture that does not exist: {picture}."
            raise self.error(key, message, section)
        return picture

    @contextmanager
    def _picture_errors(self, key: str, picture: Path, section: str) -> Iterator[None]:
        try:
            yield
        except ImageError as error:
            raise self.error(key, f"{key}: picture {picture}: {error}.", section) from None

    def _say_what_is_clipped(
        self, declared: Parameter, picture: Path, values: Pixels, section: str
    ) -> None:
        slack = CLIPPED_IN_SILENCE * max(1.0, min(abs(declared.high), 1e6))
        outside = (values < declared.low - slack) | (values > declared.high + slack)
        if outside.any():
            count, pixels = int(outside.any(axis=2).sum()), values.shape[0] * values.shape[1]
            message = (
                f"{declared.name}: picture {picture}: {count} of {pixels} pixels are out of range "
                f"({declared.range_text()}) and are clipped; its values are {values.min():g} to "
                f"{values.max():g}."
            )
            notice(str(self.error(declared.name, message, section)))

    def _metal(self, cls: type[Model], table: dict[str, Any], section: str) -> dict[str, Any]:
        """eta and k of a named metal, if the table names one."""
        if "metal" not in table or "metal" in cls.fields:
            return {}
        neutral = table.pop("neutral", False)
        if not isinstance(neutral, bool):
            raise self.error("neutral", f"neutral is true or false, got {neutral!r}.", section)
        symbol = table.pop("metal")
        if not isinstance(symbol, str):
            raise self.error("metal", f"metal is a symbol in quotes, got {symbol!r}.", section)
        try:
            indices = metal_parameters(cls, symbol, neutral)
        except ModelError as error:
            raise self.error("metal", str(error), section) from None
        if twice := sorted(set(indices) & set(table)):
            raise self.error(twice[0], f"metal says what {twice[0]} is; leave one out.", section)
        return indices


def _unknown_key(cls: type[Model], key: str, section: str) -> str:
    if section and key in OF_FILE:
        return f"{key} is for the whole file; write it without {section[:-1]!r}."
    beside = OF_MODEL if section else OF_FILE
    did = did_you_mean(key.lower(), [*cls.fields, *beside])
    return (
        f"{cls.name} has no {key!r}; {did}known are {', '.join(cls.fields)}, and beside them "
        f"{', '.join(beside)}."
    )


def unknown(name: str, materials: dict[str, Path]) -> ModelError:
    """The error for a name that is neither a model nor a material."""
    known = models()
    near = nearest(name, [*known, *materials])
    did = ""
    if near:
        did = f" did you mean the {'model' if near[0] in known else 'material'} {near[0]!r}?"
    return ModelError(
        f"no model, material or file {name!r};{did} 'gonio list' and 'gonio list --materials' show all."
    )


def to_toml(material: Material) -> str:
    """A material as the text of a file that reads as the same one; pictures by their path."""
    lines = [f'model = "{material.model.name}"']
    if material.description:
        lines.append(f"description = {_quoted(material.description)}")
    sections: dict[str, list[str]] = {"": lines}
    for path, value in settings_of(material.model):
        outer, _, name = path.rpartition(".")
        if isinstance(value, str) and _is_child(material.model, path):
            sections.setdefault(path, []).append(f'model = "{value}"')
        elif path not in material.textures:
            sections.setdefault(outer, []).append(f"{name} = {_value(value)}")
    for path, picture in material.textures.items():
        outer, _, name = path.rpartition(".")
        sections.setdefault(outer, []).append(
            f"{name} = {_quoted(picture.as_posix() + _suffix(material, path))}"
        )
    for path in [p for p in sections if p]:
        if not sections[path][0].startswith("model = "):
            sections[path].insert(0, f'model = "{_at(material.model, path).name}"')
    if material.normal_map is not None:
        lines.append(f"normal_map = {_quoted(material.normal_map.as_posix())}")
    if material.texture_scale != (1.0, 1.0):
        lines.append(f"texture_scale = {_value(material.texture_scale)}")
    if material.grows:
        lines.append('growth = "mesh"')
    text = "\n".join(lines) + "\n"
    for path in sorted(p for p in sections if p):
        text += f"\n[{path}]\n" + "\n".join(sections[path]) + "\n"
    if material.flakes:
        text += "\n[flakes]\n" + "".join(f"{k} = {_value(v)}\n" for k, v in material.flakes.items())
    return text


def _suffix(material: Material, path: str) -> str:
    return f":{material.channels[path]}" if path in material.channels else ""


def _at(model: Model, path: str) -> Model:
    for name in path.split("."):
        model = getattr(model, name)
    return model


def _is_child(model: Model, path: str) -> bool:
    outer, _, name = path.rpartition(".")
    return isinstance((_at(model, outer) if outer else model).fields.get(name), Child)


def _value(value: Any) -> str:
    if isinstance(value, tuple):
        return "[" + ", ".join(repr(float(v)) for v in value) + "]"
    return _quoted(value) if isinstance(value, str) else repr(value)


def _quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
    return f'"{escaped}"'
