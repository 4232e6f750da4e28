"""What to cite: the publications behind a model, as BibTeX.

    gonio.description.citations.of_model(gonio.EON)            # [Publication(key="portsmouth2025", ...)]
    print(gonio.description.citations.bibtex([gonio.EON()]))

Nothing lists models. A model's file names its sources in its docstring, each by its title in quotes
("Source: Burley, "Physically-based shading at Disney", ..."), and `bibliography.bib` beside this file says
what is to be printed for a title.
"""

from __future__ import annotations

import functools
import inspect
import re
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from importlib import resources
from types import ModuleType

from gonio.description.about import module_notes
from gonio.fields import ModelError
from gonio.model import Child, Model

PARTS = "gonio.parts."


class CitationError(ModelError):
    """A model whose file names no source."""


@dataclass(frozen=True)
class Publication:
    """One entry of the bibliography."""

    key: str
    kind: str
    """BibTeX's type of entry, such as "article"."""
    fields: dict[str, str]
    """By BibTeX's names, values as LaTeX has them."""

    @property
    def names(self) -> Iterator[str]:
        """The titles by which docstrings may name it, in plain letters."""
        yield _plain(self.fields["title"])
        if "alias" in self.fields:
            yield _plain(self.fields["alias"])

    def bibtex(self) -> str:
        """The entry as text for a .bib file."""
        lines = (f"  {name} = {{{text}}}" for name, text in self.fields.items() if name != "alias")
        return f"@{self.kind}{{{self.key},\n" + ",\n".join(lines) + "\n}"


@functools.cache
def bibliography() -> dict[str, Publication]:
    """All publications by key."""
    text = (
        resources.files("gonio.description")
        .joinpath("bibliography.bib")
        .read_text(encoding="utf-8")
    )
    found = {}
    for entry in re.finditer(r"^@(\w+)\{(\w+),\n(.*?)\n\}$", text, re.DOTALL | re.MULTILINE):
        fields = dict(re.findall(r"^  (\w+) = \{(.*)\},?$", entry[3], re.MULTILINE))
        found[entry[2]] = Publication(entry[2], entry[1], fields)
    return found


def named(text: str) -> list[Publication]:
    """The publications that a text names: by titles in quotes, or by the name of a source file.

    In the order of the text.
    """
    text = _plain(text)
    places: dict[str, int] = {}
    for publication in bibliography().values():
        for name in publication.names:
            # A name without blanks is a file's (disney.brdf), or a short title that needs its quotes
            place = text.find(name if "." in name else f'"{name}"')
            if place >= 0:
                places.setdefault(publication.key, place)
    return [bibliography()[key] for key in sorted(places, key=lambda key: places[key])]


def unknown_titles(text: str) -> list[str]:
    """Titles in quotes that the bibliography has neither as a title nor as that of a volume."""
    known = {name for publication in bibliography().values() for name in publication.names}
    volumes = [_plain(p.fields.get("booktitle", "")) for p in bibliography().values()]
    titles = re.findall(r'"(\w[^"]* [^"]*)"', text)
    return [
        title
        for title in titles
        if _plain(title) not in known and not any(_plain(title) in volume for volume in volumes)
    ]


def of_model(model: Model | type[Model], *, parts: bool = False) -> list[Publication]:
    """The publications that a model's file names as its sources.

    Args:
        model: a model, or its class. Models inside a model count as well.
        parts: also those that the files in `gonio.parts` name which the model's file imports.

    Raises:
        CitationError: the file names no source. (Sources that the bibliography does not have come as
            entries of type "misc" that hold the docstring's own words.)
    """
    found: dict[str, Publication] = {}
    for cls in _classes(model):
        for publication in _own(cls):
            found.setdefault(publication.key, publication)
        if parts:
            for module in _imported_parts(_module(cls)):
                for publication in named(_all_docstrings(module)):
                    found.setdefault(publication.key, publication)
    return list(found.values())


def bibtex(models: Iterable[Model | type[Model]], *, parts: bool = False) -> str:
    """BibTeX of several models' sources, each publication once; see `of_model`."""
    found = {p.key: p for model in models for p in of_model(model, parts=parts)}
    return "\n\n".join(publication.bibtex() for publication in found.values()) + "\n"


def _classes(model: Model | type[Model]) -> Iterator[type[Model]]:
    if isinstance(model, type):
        yield model
        return
    yield model.written
    for name, declared in model.fields.items():
        if isinstance(declared, Child):
            yield from _classes(getattr(model, name))


def _module(cls: type[Model]) -> ModuleType:
    return sys.modules[cls.__module__]


def _own(cls: type[Model]) -> list[Publication]:
    docstring = inspect.getdoc(_module(cls)) or ""
    source = module_notes(docstring).get("source", "")
    if not source:
        raise CitationError(
            f"{cls.name} names no source: its file's docstring has no line that begins with 'Source:'. "
            'Write one, such as: Source: Author, "Title", year, Eq. 1.'
        )
    found = named(docstring)
    if unknown_titles(source) or not found:
        title = module_notes(docstring)["title"].partition(":")[0]
        words = {"title": title, "note": _latex(source)}
        found.append(Publication(f"{cls.name}_source", "misc", words))
    return found


def _imported_parts(module: ModuleType) -> list[ModuleType]:
    """The modules of `gonio.parts` from which a module has something, in the order of its names."""
    names: dict[str, None] = {}
    for value in vars(module).values():
        home = value.__name__ if isinstance(value, ModuleType) else getattr(value, "__module__", "")
        if str(home).startswith(PARTS):
            names[home] = None
    return [sys.modules[name] for name in names]


def _all_docstrings(module: ModuleType) -> str:
    own = (value for value in vars(module).values() if inspect.isfunction(value))
    texts = [inspect.getdoc(f) or "" for f in own if f.__module__ == module.__name__]
    return "\n".join([inspect.getdoc(module) or "", *texts])


def _plain(text: str) -> str:
    """Lower case without LaTeX's braces and accents, with one blank between words."""
    text = re.sub(r"\{\\\W\{?(\w)\}?\}", r"\1", text)
    text = text.replace("{", "").replace("}", "").replace("\\", "").replace("–", "-")
    return " ".join(text.split()).casefold()


def _latex(text: str) -> str:
    return re.sub(r"([&%$#_{}])", r"\\\1", text)
