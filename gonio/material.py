"""Materials as small TOML files: the name of a model and its parameters.

    model = "eon"
    roughness = 0.9
    rho = [0.62, 0.35, 0.24]        # or rho = "clay.png", a picture relative to this file

Options take their names as strings. Strings for numbers and colours are textures, for pictures only.
"""

from __future__ import annotations

import difflib
import re
import tomllib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from gonio.model import Model, ModelError, Parameter, models


class MaterialError(ValueError):
    """A material file that cannot be used; the message names file, line and remedy."""


@dataclass(frozen=True)
class Material:
    """A model with its parameters, and textures for some of them."""

    name: str
    model: Model
    textures: dict[str, Path] = field(default_factory=dict)
    """Pictures by parameter name; the model has the default there."""

    def bsdf(self) -> dict[str, Any]:
        """The Mitsuba plug-in as a dict for `mitsuba.load_dict`."""
        from gonio.mitsuba import plugin

        node = plugin(self.model)
        for name, path in self.textures.items():
            width = self.model.fields[name].width  # type: ignore[union-attr]
            # Numbers are stored as they are, colours in sRGB.
            node[name] = {"type": "bitmap", "filename": str(path), "raw": width == 1}
        return node


def load_material(path: str | Path) -> Material:
    """Read a material file.

    Raises:
        FileNotFoundError: no such file.
        MaterialError: not TOML, an unknown model or parameter, or a value out of range, with the line.
    """
    path = Path(path)
    if not path.is_file():
        raise FileNotFoundError(f"there is no material file {path}.")
    try:
        text = path.read_text(encoding="utf-8")
        table = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise MaterialError(f"{path}: not a TOML file: {error}.") from None
    return _build(path, text, table)


def _build(path: Path, text: str, table: dict[str, Any]) -> Material:
    def fail(key: str, message: str) -> MaterialError:
        for number, line in enumerate(text.splitlines(), 1):
            if re.match(rf"\s*[\"']?{re.escape(key)}[\"']?\s*=", line):
                return MaterialError(f"{path}:{number}: {message}")
        return MaterialError(f"{path}: {message}")

    known = models()
    name = table.pop("model", None)
    if name is None:
        raise fail("model", 'the line \'model = "NAME"\' is missing; "gonio list" shows the names.')
    if not isinstance(name, str) or name not in known:
        near = difflib.get_close_matches(str(name), known, n=1)
        did = f"did you mean {near[0]!r}? " if near else ""
        raise fail("model", f"no model {name!r}; {did}'gonio list' shows all.")
    cls = known[name]
    given, textures = {}, {}
    for key, value in table.items():
        declared = cls.fields.get(key)
        if isinstance(value, list):
            value = tuple(value)
        if isinstance(declared, Parameter) and isinstance(value, str):
            picture = path.parent / value
            if not picture.is_file():
                raise fail(key, f"{key} names a picture that does not exist: {picture}.")
            textures[key] = picture
            continue
        try:
            cls(**{key: value})
        except ModelError as error:
            raise fail(key, str(error)) from None
        given[key] = value
    return Material(path.stem, cls(**given), textures)
