"""Models from their texts to a table of errors: exported in each language, compiled, run and compared."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from gonio.export import materialx
from gonio.export.by_row import at_row
from gonio.export.coded import ARRAY_PLACES, Request
from gonio.export.entry import Export
from gonio.export.host import OBJECTS
from gonio.export.lit import export_lit
from gonio.export.prove.proof import prove, table
from gonio.export.prove.runners import each_way
from gonio.export.prove.tabled import price
from gonio.export.text import FUNCTIONS, PROVABLE, export
from gonio.export.tree import ExportError
from gonio.lights.catalogue import usual
from gonio.model import Model


@dataclass(frozen=True)
class Proven:
    """The outcome of a proof."""

    lines: list[str]
    failed: bool


# Languages whose proofs read tables from a buffer.
BUFFERED = ("glsl", "wgsl")


def prove_models(
    models: Mapping[str, Model],
    to: Sequence[str],
    rows: int,
    only: Sequence[str] = FUNCTIONS,
    progress: Callable[[str], None] = lambda text: None,
    *,
    lit: Sequence[str] | None = None,
    tables: Request | None = None,
) -> Proven:
    """Export models, compile and run them, and compare with the float64 models.

    With `lit`, names of lights or none for the usual ones, the material function is compared too; what it
    looks up is then computed by formulas. With `tables`, texts are compared with the tables' own
    interpolation in NumPy, and that with the models; where they are arrays in shaders, D has fewer entries.

    Raises:
        ProofError: a compiler or runtime is not installed.
        ExportError: what cannot be exported.
    """
    if tables is not None and "eval" not in only:
        raise ExportError("tables stand for functions that eval calls; prove that as well.")
    runnable = [language for language in to if language != materialx.NAME]
    if not runnable:
        raise ExportError(
            "MaterialX's documents are not run by --prove; prove essl, which has the same formulas."
        )

    def exported(name: str, model: Model, language: str) -> Export:
        used, lookups = tables, "host"
        if tables is not None and language not in BUFFERED:
            lookups = PROVABLE
            if language not in OBJECTS:
                used = replace(tables, places=ARRAY_PLACES)
        if lit is None:
            made = export({name: model}, language, only=only, tables=used, lookups=lookups)
            return made[0]
        lights = lit or usual(model)
        return export_lit(model, name, lights, language, only=only, tables=used, lookups=lookups)

    pairs = [
        (model, way)
        for name, model in models.items()
        for language in runnable
        for way in each_way(exported(name, model, language))
    ]
    proofs = prove(pairs, rows, progress=progress)
    lines = table(proofs).splitlines()
    if tables is not None:
        for name, model in models.items():
            lines += _table_errors(name, model, tables, rows)
    return Proven(lines, not all(p.holds for p in proofs))


def _table_errors(name: str, model: Model, tables: Request, rows: int) -> list[str]:
    """What the tables cost a material, row by row and as a whole."""
    made = export({name: model}, "cpp", only=["eval"], tables=tables)[0]
    assert made.tables is not None
    lines = [line for one in made.tables.all for line in one.said()]
    if not tables.materials:
        return [f"{name}: {line}" for line in [*lines, price(model, made, rows)]]
    for row, (own, material) in enumerate(tables.materials):
        lines.append(f"{own}: {price(at_row(model, material, row), made, rows)}")
    return [f"{name}: {line}" for line in lines]
