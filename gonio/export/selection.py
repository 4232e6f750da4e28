"""What is to be exported, as text says it: models and their names, languages, tables."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from gonio.export import materialx
from gonio.export.by_row import together
from gonio.export.coded import Request
from gonio.export.targets import TARGETS, did_you_mean_language
from gonio.export.tree import ExportError
from gonio.materials import Material, library, load
from gonio.model import Model
from gonio.model import models as registered


@dataclass(frozen=True)
class Selection:
    """Models by the names that their functions get, and what a user has to know of them."""

    models: dict[str, Model] = field(default_factory=dict)
    found: dict[str, Model | Material] = field(default_factory=dict)
    """The same, with what drives the materials' parameters."""
    notes: list[str] = field(default_factory=list)


def choose(
    texts: Iterable[str],
    params: Sequence[str] = (),
    everything: bool = False,
    materials: bool = False,
) -> Selection:
    """Find models from text: a model, a material, a .toml or .py file; NAME=... gives it another name.

    Args:
        texts: what to find.
        params: parameters and options for each of them, "name=value".
        everything: all models in place of texts.
        materials: all ready materials in place of texts.

    Raises:
        ModelError: an unknown model, parameter or option.
        ExportError: two models with the same name, or nothing to choose.
    """
    wanted = list(texts)
    if (everything or materials) and (wanted or params):
        raise ExportError("--all and --materials take no models and no parameters.")
    if everything:
        wanted += registered()
    if materials:
        wanted += library()
    if not wanted:
        raise ExportError("nothing to export; name a model, such as eon, or give --all.")
    found = Selection()
    for text in wanted:
        name, thing = named(text)
        what = load(thing, params)
        model = what.model if isinstance(what, Material) else what
        name = name or re.sub(r"\W", "_", what.name)
        if name in found.models:
            raise ExportError(
                f"two exports are called {name!r}; give one another name: other_{name}={thing}."
            )
        found.models[name] = model
        found.found[name] = what
        if isinstance(what, Material):
            found.notes.extend(_notes(name, what))
    return found


def named(text: str) -> tuple[str, str]:
    """What NAME=MODEL says: the name, empty where none is given, and the text of the model."""
    found = re.fullmatch(r"([A-Za-z]\w*)=(.+)", text)
    return (found[1], found[2]) if found else ("", text)


def _notes(name: str, material: Material) -> list[str]:
    """What the host has to feed, because it is not a number."""
    notes = [
        f"{name}: {path} comes from {picture.name}; read that texture into the struct."
        for path, picture in material.textures.items()
    ]
    if material.flakes:
        notes.append(
            f"{name}: {' and '.join(material.driven_by_maps())} come from a map of flakes; "
            "gonio.mitsuba.textures.flake_map makes it."
        )
    if material.grows:
        notes.append(
            f"{name}: growth comes from the mesh; gonio.mitsuba.textures.add_growth makes it."
        )
    return notes


def by_extension(output: str) -> str:
    """The language of a file's name, such as wgsl of x.wgsl; empty if it says none."""
    extension = Path(output).suffix.removeprefix(".")
    return next((t.name for t in TARGETS.values() if t.extension == extension), "")


def chosen_languages(names: Sequence[str], output: str | None = None) -> list[str]:
    """The languages that are asked for; "all" is all of them, none that of the file's name.

    Raises:
        ExportError: none is named, one that there is not, or another one than the file's name says.
    """
    found = [part.strip() for name in names for part in name.split(",") if part.strip()]
    of_file = by_extension(output or "")
    if not found and of_file:
        return [of_file]
    named = TARGETS.get(found[0]) if len(found) == 1 else None
    if of_file and named and named.extension != TARGETS[of_file].extension:
        raise ExportError(
            f"--to {named.name} and {output} do not agree; leave out --to, or name the file "
            f"NAME.{named.extension}."
        )
    known = [*TARGETS, materialx.NAME]
    if not found:
        raise ExportError(f"no language; add --to and one of {', '.join(known)}, all.")
    for name in found:
        if name not in (*known, "all"):
            did = did_you_mean_language(name, known)
            raise ExportError(f"no language {name!r}; {did}there are {', '.join(known)}, all.")
    return known if "all" in found else list(dict.fromkeys(found))


def by_rows(selection: Selection, name: str, tables: Request) -> tuple[Selection, Request]:
    """Models as one with a parameter that chooses the row, and the tables with all of their rows.

    Raises:
        ExportError: models that are not the same, or a material that a picture or the mesh drives.
    """
    for own, what in selection.found.items():
        if isinstance(what, Material) and (
            what.textures or what.driven_by_maps() or what.normal_map
        ):
            raise ExportError(
                f"{own} has parameters that come from a picture or the mesh, of which no row is; export it "
                "without --by-row."
            )
    model = together(selection.models)
    request = replace(tables, materials=tuple(selection.models.items()))
    return Selection({name: model}, {name: model}, selection.notes), request


def tables_of(names: Sequence[str], bits: int, found: Mapping[str, Model | Material]) -> Request:
    """The tables that are asked for; what textures and meshes drive is in none of them."""
    kinds = tuple(dict.fromkeys(part.strip() for name in names for part in name.split(",")))
    varying: set[str] = set()
    for what in found.values():
        if isinstance(what, Material):
            varying |= {*what.textures, *what.driven_by_maps()}
    return Request(kinds, bits, frozenset(varying))
