"""What is checked, as text names it: a model over its whole range, a material as it is."""

from __future__ import annotations

from collections.abc import Iterable

from gonio.check import subjects
from gonio.check.subject import Subject
from gonio.materials import Material, load
from gonio.materials.notation import split


def subjects_of(text: str, params: Iterable[str] = ()) -> list[Subject]:
    """What a text on the command line names: a model, a material, or a model file.

    A bare name is a model over its whole range and all its options. Parameters and options that are given,
    as in eon:sampler=cosine,rho=0.5, stay fixed, and the others keep their whole range or the default
    option. A material is fixed altogether.

    Raises:
        ValueError: an unknown name, a parameter out of range, a file without a usable model.
    """
    given = list(params)
    name, pieces = split(text)
    found = load(text, given)
    if isinstance(found, Material):
        return _of_material(found)
    if not (pieces or given):
        return subjects(found.written, label=name)
    named = {piece.partition("=")[0].strip() for piece in [*pieces, *given]}
    return subjects(found, named, name)


def _of_material(material: Material) -> list[Subject]:
    """A material as it is; what pictures, flakes and growth drive keeps its whole range."""
    driven = {*material.textures, *material.driven_by_maps()}
    model = material.model
    paths = {path for path, _, _ in model.parameters()}
    found = subjects(model, (paths - driven) | set(model.fields) - driven, model.name)
    for subject in found:
        subject.name = material.name
    return found
