"""What users write to name a surface: a model, a ready material, a material file, a model file.

    gonio.load("eon:roughness=1,rho=0.8/0.3/0.1")
    gonio.load("gold:alpha=0.3")                    # a ready material, changed
    gonio.load("oak.toml"), gonio.load("my_model.py:rho=0.5")
    gonio.load("paint.binary:scale=0.5")            # measured reflection, of any format that gonio reads
    gonio.load("lambert:rho=0.2+gold:alpha=0.1")    # a sum, as the model sum

The same texts work wherever a command takes a MODEL.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from pathlib import Path

from gonio import measured
from gonio.materials import model_file, notation, toml_file
from gonio.materials.material import Material, MaterialError, inside
from gonio.messages import did_you_mean
from gonio.model import Model, model, models

__all__ = [
    "Material",
    "MaterialError",
    "library",
    "load",
    "load_material",
    "load_model",
    "load_series",
]

LIBRARY = Path(__file__).parent

# A file that names a file that names a file ... deeper than this goes round in a circle.
FILES_DEEP = 32


def library() -> dict[str, Path]:
    """The files of the materials that come with gonio, by name, sorted."""
    return {path.stem: path for path in sorted(LIBRARY.glob("*.toml"))}


def load(text: str | Path, params: Iterable[str] = ()) -> Model | Material:
    """A model or a material from text.

    Args:
        text: a model's or a ready material's name, or the path of a .toml or .py file or of one of measured
            reflection; then, after a colon, parameters and options with commas between them:
            eon:roughness=1,rho=0.8/0.3/0.1.
        params: further assignments, each "name=value". Those in the text win.

    Raises:
        ModelError: an unknown model, material, name or value.
        MaterialError: a material file that cannot be used, with the line.
        FileNotFoundError: no such file.
    """
    return _load(str(text), params, Path(), 0)


def load_model(text: str | Path, params: Iterable[str] = ()) -> tuple[Model, list[str]]:
    """As `load`, for what has no surface: a model, and notes on what a surface would give it.

    Raises:
        ModelError: as `load`, or a picture drives a parameter.
    """
    found = load(text, params)
    return found.plain() if isinstance(found, Material) else (found, [])


def load_material(name: str | Path) -> Material:
    """A material: one of gonio's by its name, or a user's file.

    Raises:
        FileNotFoundError: no such file, and no material of that name.
        MaterialError: a file that cannot be used, with the line.
    """
    known = library()
    path = known.get(str(name), Path(name))
    if not path.is_file():
        raise FileNotFoundError(
            f"there is no material file {path}, nor a material of that name; "
            f"{did_you_mean(str(name), known)}"
            "'gonio list --materials' shows them."
        )
    return _material(path, 0)


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
    names = sorted(steps[name], key=lambda step: (len(step), step))
    return [_material(library()[step], 0) for step in names]


def _load(text: str, params: Iterable[str], folder: Path, depth: int) -> Model | Material:
    terms = notation.terms(text)
    if len(terms) > 1 and not (folder / notation.split(text)[0]).exists():
        return notation.assign(_sum([_load(t, (), folder, depth) for t in terms]), params, load)
    name, pieces = notation.split(text)
    start = _start(name, folder, depth)

    def resolve(inner: str) -> Model | Material:
        return _load(inner, (), folder, depth)

    # Those in the text win, wherever the same name is given twice.
    named = {piece.partition("=")[0].strip() for piece in pieces}
    outside = [p for p in params if p.partition("=")[0].strip() not in named]
    return notation.assign(start, [*outside, *pieces], resolve)


def _sum(terms: Sequence[Model | Material]) -> Model | Material:
    """Terms as sums of two, one in the other, with all weights 1."""
    if len(terms) == 1:
        return terms[0]
    parts = {"first": terms[0], "second": _sum(terms[1:])}
    plain = {n: t.model if isinstance(t, Material) else t for n, t in parts.items()}
    made = model("sum", first_weight=1.0, second_weight=1.0, **plain)
    given = {n: t if isinstance(t, Material) else Material(t.name, t) for n, t in parts.items()}
    return inside(made, given, made.name)


def _start(name: str, folder: Path, depth: int) -> Model | Material:
    """What a name or path stands for, with its defaults."""
    if name in models():
        return model(name)
    if name in (known := library()):
        return _material(known[name], depth)
    if model_file.is_model_file(name):
        return model_file.load(folder / name)()
    if Path(name).suffix.lower() == ".toml":
        if not (folder / name).is_file():
            raise FileNotFoundError(f"there is no material file {folder / name}.")
        return _material(folder / name, depth)
    if measured.is_named_like_data(folder / name):
        return measured.as_model(folder / name)
    raise toml_file.unknown(name, known)


def _material(path: Path, depth: int) -> Material:
    if depth > FILES_DEEP:
        raise toml_file.CircleError(f"{path}: material files name each other in a circle.")

    def resolve(name: str, seen_from: Path) -> Model | Material:
        return _load(name, (), seen_from.parent, depth + 1)

    return toml_file.read(path, resolve)
