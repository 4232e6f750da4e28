"""What `gonio export` does, for Python as well: named models in, files or text out."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from gonio.export import materialx
from gonio.export.targets import TARGETS
from gonio.export.text import FUNCTIONS, export
from gonio.export.tree import ExportError
from gonio.material import Material, find, library, load_material
from gonio.model import Model
from gonio.model import models as registered


@dataclass(frozen=True)
class Selection:
    """Models by the names that their functions get, and what a user has to know of them."""

    models: dict[str, Model] = field(default_factory=dict)
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
        renamed = re.fullmatch(r"([A-Za-z]\w*)=(.+)", text)
        name, thing = (renamed[1], renamed[2]) if renamed else ("", text)
        what = _find(thing, params)
        model = what.model if isinstance(what, Material) else what
        name = name or re.sub(r"\W", "_", what.name)
        if name in found.models:
            raise ExportError(
                f"two exports are called {name!r}; give one another name: other_{name}={thing}."
            )
        found.models[name] = model
        if isinstance(what, Material):
            found.notes.extend(_notes(name, what))
    return found


def _find(text: str, params: Sequence[str]) -> Model | Material:
    if text.endswith(".toml"):
        return load_material(text)
    return find(text, params)


def _notes(name: str, material: Material) -> list[str]:
    """What the host has to feed, because it is not a number."""
    notes = [
        f"{name}: {path} comes from {picture.name}; read that texture into the struct."
        for path, picture in material.textures.items()
    ]
    if material.flakes:
        notes.append(
            f"{name}: flake_x and flake_y come from a map of flakes; gonio.textures.flake_map makes it."
        )
    if material.grows:
        notes.append(f"{name}: growth comes from the mesh; gonio.textures.add_growth makes it.")
    return notes


def languages(names: Sequence[str]) -> list[str]:
    """The languages that are asked for; "all" is all of them.

    Raises:
        ExportError: none is named.
    """
    found = [part for name in names for part in name.split(",") if part]
    if not found:
        known = ", ".join(TARGETS)
        raise ExportError(f"no language; add --to and one of {known}, {materialx.NAME}, all.")
    if "all" in found:
        return [*TARGETS, materialx.NAME]
    return list(dict.fromkeys(found))


@dataclass(frozen=True)
class Proven:
    """The outcome of a proof."""

    lines: list[str]
    failed: bool


def prove(
    models: Mapping[str, Model],
    to: Sequence[str],
    rows: int,
    only: Sequence[str] = FUNCTIONS,
    progress: Callable[[str], None] = lambda text: None,
) -> Proven:
    """Export models, compile and run them, and compare with the float64 models.

    Raises:
        ProofError: a compiler or runtime is not installed.
        ExportError: what cannot be exported.
    """
    from gonio.export.prove import each_way, table
    from gonio.export.prove import prove as compare

    runnable = [language for language in to if language != materialx.NAME]
    if not runnable:
        raise ExportError(
            "MaterialX's documents are not run by --prove; prove essl, which has the same formulas."
        )
    pairs = [
        (model, way)
        for name, model in models.items()
        for language in runnable
        for way in each_way(export({name: model}, language, only=only)[0])
    ]
    proofs = compare(pairs, rows, progress=progress)
    return Proven(table(proofs).splitlines(), not all(p.holds for p in proofs))
