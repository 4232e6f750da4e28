"""WGSL exports: compiled and run as compute shaders through wgpu (naga, then Vulkan, Metal or D3D12)."""

from __future__ import annotations

from collections.abc import Sequence

from gonio.export.buffer import BINDINGS
from gonio.export.entry import Export
from gonio.export.prove import tools
from gonio.export.prove.harness import (
    CODE,
    Dialect,
    Results,
    indented,
    input_columns,
    output_columns,
    statements,
)
from gonio.export.prove.tools import Rows

WGSL = Dialect(
    vec2="vec2f({0}, {1})",
    vec3="vec3f({0}, {1}, {2})",
    variable="let {name} = {value};",
    declaration="var {name}: {type};",
)


def run_wgsl(exports: Sequence[Export], rows: Sequence[Rows]) -> Results:
    """Compile each export and run it for every row."""
    tools.program("wgpu", "compiles and runs WGSL")
    jobs = [
        tools.Job(
            export,
            compute_text(export, len(inputs)),
            inputs,
            output_columns(export.entry),
            r"wgsl:(\d+):",
            {"tables": BINDINGS["wgsl"]},
        )
        for export, inputs in zip(exports, rows, strict=True)
    ]
    return Results(*tools.run_worker("_wgpu_worker.py", ".wgsl", jobs, "wgpu", "wgpu"))


def compute_text(export: Export, count: int) -> str:
    """The source with a compute shader that calls every function for each row."""
    entry = export.entry
    read = f"fn {CODE}(k: i32) -> f32 {{\n    return x[k];\n}}\n\n" if CODE in export.source else ""
    return (
        f"{export.source}\n"
        "@group(0) @binding(0) var<storage, read> x: array<f32>;\n"
        "@group(0) @binding(1) var<storage, read_write> y: array<f32>;\n\n"
        f"{read}"
        "@compute @workgroup_size(64)\n"
        "fn main(@builtin(global_invocation_id) id: vec3u) {\n"
        f"    if (id.x >= {count}u) {{\n        return;\n    }}\n"
        f"    let i = id.x * {input_columns(entry)}u;\n"
        f"    let o = id.x * {output_columns(entry)}u;\n"
        f"{indented(statements(entry, WGSL))}\n}}\n"
    )
