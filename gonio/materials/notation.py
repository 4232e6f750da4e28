"""Models and materials written as text, as on the command line: eon:roughness=1,rho=0.8/0.3/0.1."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from gonio.fields import ModelError, Parameter
from gonio.materials.material import Material, inside
from gonio.model import Child, Model
from gonio.parts.dielectrics import dielectric
from gonio.parts.metals import metal

Resolve = Callable[[str], Model | Material]
"""Finds what the text of an inner model names."""


def split(text: str) -> tuple[str, list[str]]:
    """The name or path in front of the colon, and the assignments behind it.

    Raises:
        ModelError: nothing behind the colon, or something that is not name=value.
    """
    # A path may hold colons of its own; what follows the last one has to look like name=value.
    found = re.fullmatch(r"(.+?):([^=:,]*=.*)", text, flags=re.S)
    if found is None:
        name, _, rest = text.partition(":")
        if text.endswith(":"):
            raise ModelError(f"{text!r} ends in a colon; write {text}name=value or {text[:-1]}.")
        return (name, [rest]) if rest and re.fullmatch(r"\w{2,}", name) else (text, [])
    pieces = found[2].split(",")
    for before, piece in itertools.pairwise(pieces):
        if "=" in before and "=" not in piece:
            raise ModelError(
                f"{text!r}: {piece!r} is not name=value; in a model's text a colour has slashes, such "
                "as rho=0.8/0.3/0.1."
            )
    return found[1], pieces


def terms(text: str) -> list[str]:
    """What a sum such as "lambert:rho=0.2+torrance_sparrow" adds; one text if it is no sum.

    Raises:
        ModelError: nothing on one side of a plus sign.
    """
    # The plus sign of 1e+5 or of +.5 is a number's
    found = [term.strip() for term in re.split(r"\+(?!\.?\d)", text)]
    if len(found) > 1 and not all(found):
        raise ModelError(f"{text!r} has nothing on one side of a plus sign; write model+model.")
    return found


def assign(
    start: Model | Material, assignments: Iterable[str], resolve: Resolve
) -> Model | Material:
    """A model or material with what is assigned to it.

    Args:
        start: with its defaults, or as it was read.
        assignments: each "name=value". A colour is 0.8/0.3/0.1, 0.8,0.3,0.1 or #c08040 (sRGB), an angle
            may be pi/2. A model inside is named, its parameters have their path: base=lambert,
            base.rho=0.5. metal=Cu stands for eta and k, and eta=water for the index of water, with k = 0
            where a metal's would stand.
        resolve: finds the inner models that are named.

    Raises:
        ModelError: an unknown model, name or value, something that is not name=value, or a name twice.
    """
    model = start.model if isinstance(start, Material) else start
    texts = _texts(model, assignments)
    if not texts:
        return start
    children: dict[str, Material] = {}
    values: dict[str, Any] = {}
    # Inner models first, from the outside to the inside: they decide which names there are.
    for path in sorted(texts, key=lambda p: p.count(".")):
        if isinstance(_declaration(model, path, children), Child):
            found = resolve(texts[path])
            children[path] = found if isinstance(found, Material) else Material(found.name, found)
            values[path] = children[path].model
    for path, text in texts.items():
        if path in children:
            continue
        declared = _declaration(model, path, children)
        outer, _, name = path.rpartition(".")
        if declared is None and name == "metal":
            owner = _owner(model, outer, children)
            symbols = metal_parameters(owner, text) if owner is not None else {}
            for twice in (f"{outer}.{n}" if outer else n for n in symbols):
                if twice in texts:
                    raise ModelError(
                        f"{model.name}: metal says what {twice} is; leave one of them out."
                    )
            values |= {f"{outer}.{n}" if outer else n: v for n, v in symbols.items()}
        elif isinstance(declared, Parameter):
            values[path] = parse_number(model.name, declared, text)
            if named_index(model.name, declared, text) is not None:
                values |= dict.fromkeys(_extinction(path, texts, model, children), 0.0)
        else:  # an option, or unknown, of which the model complains
            values[path] = text
    if isinstance(start, Material):
        changed: Model | Material = start.replace(**values)
        if any(c.textures or c.flakes or c.grows for c in children.values()):
            raise ModelError(
                f"{start.name}: {' and '.join(children)} bring pictures or maps of their own; write a "
                "material file with a table for each instead."
            )
        return changed
    made = model.replace(**values)
    given = {path: child.replace(**_below(path, values)) for path, child in children.items()}
    return inside(made, given, made.name)


def _below(path: str, values: Mapping[str, Any]) -> dict[str, Any]:
    """What is assigned to the inner model at a path, by names inside it."""
    lead = f"{path}."
    return {name.removeprefix(lead): v for name, v in values.items() if name.startswith(lead)}


def _texts(model: Model, assignments: Iterable[str]) -> dict[str, str]:
    texts: dict[str, str] = {}
    for assignment in assignments:
        path, equals, value = (part.strip() for part in assignment.partition("="))
        if not equals or not path:
            names = ", ".join(model.fields)
            raise ModelError(
                f"{model.name}: {assignment!r} is not name=value; its names are {names}."
            )
        if path in texts:
            raise ModelError(f"{model.name}: {path} is given twice.")
        texts[path] = value
    return texts


def _owner(model: Model, path: str, children: Mapping[str, Material]) -> Model | None:
    """The inner model at a path, or the model itself for ""."""
    walked = ""
    for name in path.split(".") if path else []:
        if not isinstance(model.fields.get(name), Child):
            return None
        walked = f"{walked}.{name}" if walked else name
        model = children[walked].model if walked in children else getattr(model, name)
    return model


# Angles as people write them: pi, pi/4, 3pi/8, 0.5*pi.
MULTIPLE_OF_PI = re.compile(r"(?P<times>[\d.]+)?\s*\*?\s*(?:pi|π)\s*(?:/\s*(?P<over>[\d.]+))?")


def parse_angle(text: str) -> float:
    """A number, or a multiple of pi such as pi/4.

    Raises:
        ValueError: neither.
    """
    found = MULTIPLE_OF_PI.fullmatch(text.strip().lower())
    if found is None:
        return float(text)
    over = float(found["over"] or 1)
    if over == 0:
        raise ValueError(f"{text} divides by zero.")
    return float(found["times"] or 1) * math.pi / over


def _declaration(model: Model, path: str, children: Mapping[str, Material]) -> Any:
    """The declaration behind a path such as base.rho, None for an unknown one."""
    outer, _, name = path.rpartition(".")
    owner = _owner(model, outer, children)
    return None if owner is None else owner.fields.get(name)


def _extinction(
    path: str, texts: Mapping[str, str], model: Model, children: Mapping[str, Material]
) -> list[str]:
    """The path of k beside an eta, unless there is none or it is given."""
    beside = extinction_of(path)
    known = isinstance(_declaration(model, beside, children), Parameter)
    return [beside] if known and beside not in texts else []


def extinction_of(index: str) -> str:
    """The name of k that stands beside an index: a dielectric named there has none."""
    return index.removesuffix("eta") + "k"


def metal_parameters(
    model: Model | type[Model], symbol: Any, neutral: bool = False
) -> dict[str, Any]:
    """Index and extinction of a named metal, by the names that they have in a model.

    Raises:
        ModelError: an unknown metal, or a model without a metal.
    """
    fields = set(model.fields)
    prefix = next((p for p in ("", "metal_") if {p + "eta", p + "k"} <= fields), None)
    if prefix is None:
        raise ModelError(f"{model.name} has no eta and k for a metal.")
    try:
        indices = metal(symbol, neutral=neutral)
    except (ValueError, TypeError) as error:
        raise ModelError(str(error)) from None
    return {prefix + name: value for name, value in indices.items()}


def parse_number(model: str, declared: Parameter, text: str) -> float | tuple[float, ...]:
    """The value of a parameter written as text.

    Raises:
        ModelError: not a number, or not one or three for a colour.
    """
    if declared.width == 3 and (colour := hex_colour(text)) is not None:
        return colour
    if (index := named_index(model, declared, text)) is not None:
        return index
    try:
        if declared.width == 1 and MULTIPLE_OF_PI.fullmatch(text.strip().lower()):
            return parse_angle(text)
        parts = re.split(r"[,/]", text)
        numbers = tuple(float(part) for part in parts)
    except ValueError:
        wish = (
            "a number"
            if declared.width == 1
            else "one or three numbers, such as 0.8/0.3/0.1, or #c08040"
        )
        raise ModelError(
            f"{model}: {declared.name}={text} is not {wish}; allowed is {declared.range_text()}."
        ) from None
    return numbers[0] if len(numbers) == 1 else numbers


def named_index(model: str, declared: Parameter, text: str) -> float | None:
    """The index of refraction that a word stands for, such as water; None for what is no word for one.

    Raises:
        ModelError: a word that is no dielectric's name, for a parameter that is an index.
    """
    index = declared.kind == "index" or declared.name.rpartition("_")[2] in ("eta", "ior")
    if not index or re.fullmatch(r"[A-Za-z][A-Za-z _-]*", text.strip()) is None:
        return None
    if text.strip().lower() in ("nan", "inf", "infinity"):
        return None
    try:
        return dielectric(text)
    except ValueError as error:
        raise ModelError(f"{model}: {declared.name}={text}: {error}") from None


def hex_colour(text: str) -> tuple[float, float, float] | None:
    """Linear RGB of a colour in sRGB written as #c08040 or #c84; None for another text."""
    found = re.fullmatch(r"#([0-9a-fA-F]{6}|[0-9a-fA-F]{3})", text.strip())
    if found is None:
        return None
    digits = found[1] if len(found[1]) == 6 else "".join(2 * d for d in found[1])
    r, g, b = (_linear(int(digits[at : at + 2], 16) / 255) for at in (0, 2, 4))
    return r, g, b


def _linear(value: float) -> float:
    """IEC 61966-2-1, from the encoded value."""
    return value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4


def model_text(made: Model) -> str:
    """A model as it is read, such as "weidlich_wilkie:alpha=0.4,base.rho=0.5"."""
    settings = []
    for path, value in settings_of(made):
        if isinstance(value, tuple):
            value = "/".join(f"{v:.9g}" for v in value)
        settings.append(f"{path}={value}")
    return made.name + (":" if settings else "") + ",".join(settings)


def settings_of(made: Model, prefix: str = "") -> list[tuple[str, Any]]:
    """Paths and values of all that differs from the defaults, inner models' names first."""
    found: list[tuple[str, Any]] = []
    for name, declared in made.fields.items():
        value = getattr(made, name)
        if isinstance(value, Model):
            if value.name != getattr(declared, "default", ""):
                found.append((prefix + name, value.name))
            found += settings_of(value, f"{prefix}{name}.")
        elif not declared.is_default(value):
            found.append((prefix + name, value))
    return found
