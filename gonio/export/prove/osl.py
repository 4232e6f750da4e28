"""OSL exports: compiled by oslc and run by Cycles, both from Blender's Python package bpy."""

from __future__ import annotations

from collections.abc import Sequence

from gonio.export.entry import Entry, Export
from gonio.export.prove import tools
from gonio.export.prove.harness import Results, output_columns
from gonio.export.prove.tools import Rows

_OUTPUTS = {
    "eval": [("f", 3)],
    "sample": [("sampled_wi", 3), ("sampled_pdf", 1)],
    "pdf": [("pdf", 1)],
    "albedo": [("albedo", 3)],
}


def run_osl(exports: Sequence[Export], rows: Sequence[Rows]) -> Results:
    """Compile each shader and run it for every row."""
    tools.program("bpy", "compiles and runs OSL")
    jobs = [
        tools.Job(
            export,
            export.source,
            inputs,
            output_columns(export.entry),
            r"\.osl:(\d+):",
            {"inputs": parameters(export.entry), "outputs": outputs(export.entry)},
        )
        for export, inputs in zip(exports, rows, strict=True)
    ]
    return Results(*tools.run_worker("_cycles_worker.py", ".osl", jobs, "oslc", "bpy"))


def parameters(entry: Entry) -> list[tuple[str, int]]:
    """Name and width of the shader's inputs, in the order of the columns."""
    given = [("wi", 3), ("wo", 3), ("u1", 1), ("u2", 1)]
    return given + [(m.name or m.path.replace(".", "_"), m.width) for m in entry.members]


def outputs(entry: Entry) -> list[tuple[str, int]]:
    """Name and width of the shader's outputs, in the order of the columns."""
    return [pair for name, pairs in _OUTPUTS.items() if name in entry.functions for pair in pairs]
