"""What is known about a model, read from its own file: as data, and as text for people."""

from __future__ import annotations

import inspect
import math
import re
import shlex
import textwrap
from collections.abc import Iterator
from typing import Any

from gonio.fields import Option, Parameter
from gonio.materials import model_file
from gonio.model import Child, Model


def describe(cls: type[Model]) -> dict[str, Any]:
    """All that is known about a model, as plain dicts and lists that JSON can hold."""
    notes = module_notes(inspect.getdoc(inspect.getmodule(cls)) or "")
    fields = cls.fields.values()
    inside = [f for f in fields if isinstance(f, Child)]
    return {
        "name": cls.name,
        "class": cls.__name__,
        "title": notes.pop("title"),
        "description": cls.description,
        "source": notes.pop("source", None),
        "notes": notes,
        "parameters": [
            {
                "name": f.name,
                "type": "color" if f.width == 3 else "float",
                "default": f.default,
                "low": f.low,
                "high": f.high if math.isfinite(f.high) else None,
                "meaning": f.doc,
            }
            for f in fields
            if isinstance(f, Parameter)
        ],
        "options": [
            {"name": f.name, "default": f.default, "values": list(f.values), "meaning": f.doc}
            for f in fields
            if isinstance(f, Option)
        ],
        "models": [{"name": f.name, "default": f.default, "meaning": f.doc} for f in inside],
        "methods": {
            method: (inspect.getdoc(getattr(cls, method)) or "").partition("\n")[0]
            for method in ("eval", "sample", "pdf", "albedo", "mean_albedo")
        },
        "closed_form": {method: cls.writes(method) for method in ("albedo", "mean_albedo")},
        "claims": [
            {"kind": "promised", "text": "isotropic" + (" if what is inside is" if inside else "")}
            if cls.isotropic
            else {"kind": "known", "text": "anisotropic"},
            *({"kind": kind, "text": text} for kind, text in dict.fromkeys(cls.claims.lines())),
        ],
        "caveats": list(cls.caveats),
        "unlike": dict(cls.unlike),
        "mitsuba": f"gonio_{cls.name}",
        "file": model_file.path_of(cls),
    }


def summary(cls: type[Model]) -> str:
    """What a model is, in one line: the first of its class's docstring."""
    return cls.description.partition("\n")[0]


def module_notes(docstring: str) -> dict[str, str]:
    """The paragraphs of a file's docstring: its title, and those that start with "Word:"."""
    title, _, rest = docstring.partition("\n")
    notes = {"title": title}
    current = "remarks"
    for line in rest.splitlines():
        if match := re.match(r"([A-Z][a-z]+):\s*(.*)", line):
            current, line = match[1].lower().replace("sources", "source"), match[2]
        elif not line.strip():
            current = "remarks"
        notes[current] = f"{notes.get(current, '')} {line.strip()}".strip()
    return {key: text for key, text in notes.items() if text or key == "title"}


def _wrapped(text: str, indent: str, first: str | None = None) -> list[str]:
    lead = indent if first is None else first
    return textwrap.wrap(
        text, 96, initial_indent=lead, subsequent_indent=indent, break_long_words=False
    )


def description(about: dict[str, Any]) -> Iterator[str]:
    """The lines of what `describe` returns, for a terminal."""
    yield from _wrapped(about["title"], "")
    for paragraph in about["description"].split("\n\n"):
        yield from _wrapped(paragraph, "")
    for heading, text in (("Source", about["source"]), *about["notes"].items()):
        if text:
            yield from ("", heading.capitalize(), *_wrapped(_sentence(text), "  "))
    if about["parameters"]:
        yield from ("", "Parameters")
        yield from _parameter_rows(about["parameters"])
    if about["options"]:
        yield from ("", "Options")
        for option in about["options"]:
            values = [f"{v} (default)" if v == option["default"] else v for v in option["values"]]
            yield f"  {option['name']} = {' | '.join(values)}"
            yield from _wrapped(option["meaning"], "      ")
    if about["models"]:
        yield from ("", "Inner models")
        for inner in about["models"]:
            lead = f"  {inner['name']} = {inner['default']} (default)  "
            yield from _wrapped(inner["meaning"], " " * len(lead), lead)
    yield from ("", "Methods")
    for method, how in about["methods"].items():
        if about["closed_form"].get(method) is False:
            how = "By numeric quadrature; no closed form is known or written here."
        elif method in about["closed_form"]:
            how = f"Closed form: {how}"
        yield from _wrapped(how, " " * 15, f"  {method:<11}  ")
    yield from ("", "Claims, measured by 'gonio check'")
    for kind, heading in (("promised", "Promised"), ("known", "Known not to hold")):
        texts = [claim["text"] for claim in about["claims"] if claim["kind"] == kind]
        if texts:
            yield from _wrapped(f"{'; '.join(texts)}.", "    ", f"  {heading}: ")
    if about["caveats"]:
        yield from ("", "What is known to be wrong")
        for caveat in about["caveats"]:
            yield from _wrapped(caveat, "    ", "  - ")
    if about["unlike"]:
        yield from ("", "Not to be confused with")
        for other, difference in about["unlike"].items():
            yield from _wrapped(f"{other}: {difference}", "    ", "  - ")
    yield from ("", "Use", *(f"  {where:<7}  {line}" for where, line in uses(about).items()))


def _sentence(text: str) -> str:
    """With a capital letter, unless it begins with a symbol such as f."""
    return text if text[1:2].isspace() else text[:1].upper() + text[1:]


def _parameter_rows(parameters: list[dict[str, Any]]) -> Iterator[str]:
    rows = []
    for p in parameters:
        high = "inf" if p["high"] is None else f"{p['high']:.7g}"
        allowed = f"[{p['low']:g}, {high}]"
        rows.append((p["name"], p["type"], _short(p["default"]), allowed, p["meaning"]))
    widths = [max(len(row[i]) for row in rows) for i in range(4)]
    for row in rows:
        cells = (f"{cell:<{width}}" for cell, width in zip(row[:4], widths, strict=True))
        lead = "  " + "  ".join(cells) + "  "
        yield from _wrapped(row[4], " " * len(lead), lead)


def uses(about: dict[str, Any]) -> dict[str, str]:
    """One line each on how the model of `describe` is used, by where."""
    floats = [p for p in about["parameters"] if p["type"] == "float"]
    first = (floats or about["parameters"])[:1]
    python = "".join(f"{p['name']}={_literal(p['default'])}" for p in first)
    mitsuba = "".join(f', "{p["name"]}": {_literal(p["default"])}' for p in floats[:1])
    tags = "".join(f'<float name="{p["name"]}" value="{p["default"]:g}"/>' for p in floats[:1])
    shell = "".join(f" --param {p['name']}={_literal(p['default'])}" for p in floats[:1])
    plugin, file = about["mitsuba"], about["file"]
    made = f"gonio.{about['class']}({python})"
    known = "import gonio.mitsuba"
    if file is not None:
        text = "".join(f":{p['name']}={_written(p['default'])}" for p in first)
        made = f'gonio.load("{file}{text}")'
        known = f'gonio.mitsuba.register(gonio.load("{file}").written)'
    argument = about["name"] if file is None else shlex.quote(file)
    return {
        "Python": f"{made}.eval(wi, wo)",
        "Mitsuba": f"{known}, then {{'type': '{plugin}'{mitsuba.replace(chr(34), chr(39))}}}",
        "XML": f'<bsdf type="{plugin}">{tags}</bsdf>',
        "Shell": f"gonio eval {argument} --theta-i 30 --theta-o 60{shell}",
        "Shader": f"gonio export {argument} --to wgsl",
    }


def _written(value: Any) -> str:
    """A number or a colour inside the text that names a model."""
    return "/".join(map(_literal, value if isinstance(value, tuple) else (value,)))


def _literal(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else repr(value)


def _short(value: Any) -> str:
    if isinstance(value, (list, tuple)):
        distinct = value[:1] if len(set(value)) == 1 else value
        return ", ".join(f"{v:.7g}" for v in distinct)
    return f"{value:.7g}"
