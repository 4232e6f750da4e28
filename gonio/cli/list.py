"""`gonio list`: models, ready materials, and parts.

Nothing is listed by hand. Parts are the public functions of the modules in `gonio.parts`, and of those
other modules of gonio whose docstring names a source. They are read from the files, which loads nothing.
"""

from __future__ import annotations

import ast
import dataclasses
import textwrap
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

import click
import numpy as np
from numpy.typing import NDArray

import gonio
from gonio.cli.program import echo_json, json_option
from gonio.description.about import module_notes, summary

ROOT = Path(gonio.__file__).parent
"""The folder whose files are read."""


@dataclass(frozen=True)
class Part:
    """A public function that is not a method of a model, or a value with methods."""

    name: str
    """Such as "V_smith", or "GGX.D" of a method."""
    module: str
    """Where it is imported from, such as "gonio.parts.distribution"."""
    summary: str
    """The first sentence of its docstring."""
    group: str
    """What its module holds, in one line."""
    source: str
    """The publications that its module names; "" if it needs none."""


def found_parts() -> list[Part]:
    """All parts, by module, in the order in which they are written."""
    return [part for name, tree in _modules() for part in _functions(name, tree)]


def lines(found: Iterable[Part]) -> Iterator[str]:
    """Parts as text: modules with their functions below."""
    for number, (module, group) in enumerate(groupby(found, lambda part: part.module)):
        listed = list(group)
        if number:
            yield ""
        yield f"{module}: {listed[0].group}"
        width = max(len(part.name) for part in listed)
        for part in listed:
            yield f"  {part.name:<{width}}  {part.summary}"
        if listed[0].source:
            yield from textwrap.wrap(
                f"Source: {listed[0].source}", 100, initial_indent="  ", subsequent_indent="    "
            )


def _modules() -> Iterator[tuple[str, ast.Module]]:
    """Names and contents of the files that hold parts: those of `gonio.parts` first."""
    inside = sorted((ROOT / "parts").glob("*.py"))
    outside = sorted(path for path in ROOT.rglob("*.py") if path.parent.name != "models")
    for path in [*inside, *(path for path in outside if path not in inside)]:
        tree = ast.parse(path.read_text(encoding="utf-8"))
        if path in inside or "source" in module_notes(ast.get_docstring(tree) or ""):
            yield ".".join(path.relative_to(ROOT.parent).with_suffix("").parts), tree


def _functions(module: str, tree: ast.Module) -> Iterator[Part]:
    notes = module_notes(ast.get_docstring(tree) or "")
    for name, item in _public(tree):
        summary = (ast.get_docstring(item) or "").partition("\n\n")[0].replace("\n", " ")
        yield Part(name, module, summary, notes["title"], notes.get("source", ""))


def _public(tree: ast.Module) -> Iterator[tuple[str, ast.FunctionDef | ast.ClassDef]]:
    """Functions, and values with methods, such as a distribution with its widths."""
    for item in tree.body:
        if isinstance(item, ast.FunctionDef) and not item.name.startswith("_"):
            yield item.name, item
        elif isinstance(item, ast.ClassDef) and any(
            isinstance(base, ast.Name) and base.id == "NamedTuple" for base in item.bases
        ):
            methods = [part for part in item.body if isinstance(part, ast.FunctionDef)]
            if methods:
                yield item.name, item
            yield from ((f"{item.name}.{method.name}", method) for method in methods)


@dataclass(frozen=True)
class Substance:
    """A named metal or dielectric, and what it reflects at normal incidence."""

    name: str
    """As it is written: metal=NAME, or eta=NAME."""
    kind: str
    eta: tuple[float, ...]
    """Linear RGB of metals; at the sodium line of dielectrics."""
    k: tuple[float, ...]
    f0: tuple[float, float, float]
    """Linear RGB."""
    srgb: str
    """The same as a colour picker shows it."""
    words: str


def substances() -> list[Substance]:
    """All that have a name: metals by symbol, then dielectrics by index."""
    from gonio.arrays.elementwise import elementwise
    from gonio.parts import fresnel, metals
    from gonio.parts.dielectrics import INDICES

    found = []
    for symbol, words in metals.metals().items():
        part = metals.metal(symbol)
        f0 = elementwise(fresnel.f0_from_conductor, part["eta"], part["k"])
        found.append(_substance(symbol, "metal", part["eta"], part["k"], f0, words))
    for name, eta in INDICES.items():
        grey = np.repeat(elementwise(fresnel.f0_from_eta, eta), 3)
        found.append(_substance(name, "dielectric", (eta,), (), grey, name.replace("_", " ")))
    return found


def _substance(
    name: str,
    kind: str,
    eta: tuple[float, ...],
    k: tuple[float, ...],
    f0: NDArray[np.float64],
    words: str,
) -> Substance:
    from gonio.render.tone import to_srgb

    r, g, b = (float(c) for c in f0)
    coded = to_srgb(np.array([[[r, g, b]]], np.float32))[0, 0]
    return Substance(name, kind, eta, k, (r, g, b), "#" + "".join(f"{c:02x}" for c in coded), words)


def table(found: Iterable[Substance]) -> Iterator[str]:
    """Substances as text."""
    yield f"{'name':<14}  {'index':<20}  {'extinction':<20}  {'F0, linear RGB':<20}  {'sRGB':<8}"
    for s in found:
        numbers = (" ".join(f"{c:.4g}" for c in part) for part in (s.eta, s.k, s.f0))
        eta, k, f0 = numbers
        yield f"{s.name:<14}  {eta:<20}  {k:<20}  {f0:<20}  {s.srgb:<8}  {s.words}"


@click.command("list", short_help="List all models, materials, or parts of models.")
@click.option("--materials", is_flag=True, help="The ready materials instead of the models.")
@click.option("--parts", is_flag=True, help="The functions that models are made of, and tools.")
@click.option("--f0", is_flag=True, help="Named metals and dielectrics: index, and F0 as colour.")
@json_option
def command(materials: bool, parts: bool, f0: bool, as_json: bool) -> None:
    """List all models with a line on each; with --materials, the ready materials.

    With --parts, every distribution, masking, Fresnel term, interface and table, with its source.

    \b
    Examples:
      gonio list
      gonio list --materials
      gonio list --parts
      gonio list --f0                          what metal=Au and eta=water stand for
      gonio list --json | jq -r '.[].name'
    """
    from gonio.materials import library, load_material

    if materials + parts + f0 > 1:
        raise click.UsageError("--materials, --parts and --f0 are three lists; choose one")
    if f0:
        if as_json:
            echo_json([dataclasses.asdict(substance) for substance in substances()])
        else:
            click.echo("\n".join(table(substances())))
        return
    if parts:
        if as_json:
            echo_json([dataclasses.asdict(part) for part in found_parts()])
        else:
            click.echo("\n".join(lines(found_parts())))
        return
    if materials:
        rows = [{"name": name, "summary": load_material(name).description} for name in library()]
    else:
        rows = [{"name": name, "summary": summary(cls)} for name, cls in gonio.models().items()]
    if as_json:
        echo_json(rows)
        return
    width = max(len(row["name"]) for row in rows)
    for row in rows:
        click.echo(f"{row['name']:<{width}}  {row['summary']}")
    if not materials:  # on stderr, so that a pipe gets the list alone
        click.echo(
            "\n--materials lists ready materials, --parts what models are made of.", err=True
        )
