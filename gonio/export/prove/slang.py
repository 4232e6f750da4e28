"""Slang and HLSL exports: compiled by slangc to C++, that by g++, and called by ctypes.

HLSL is first compiled to SPIR-V by glslangValidator, a second front end that knows nothing of Slang.
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path

from gonio.export.buffer import resource
from gonio.export.entry import Export
from gonio.export.prove import tools
from gonio.export.prove.harness import (
    BUFFER,
    Dialect,
    Results,
    given_rows,
    indented,
    input_columns,
    output_columns,
    reads_buffer,
    statements,
)
from gonio.export.prove.native import FLAGS, RUN, call_library
from gonio.export.prove.tools import Rows

DEVICE = "processor, slangc and g++"

_FLOAT3 = {"vec2": "float2({0}, {1})", "vec3": "float3({0}, {1}, {2})"}
_TYPES = {"vec2_type": "float2", "vec3_type": "float3"}
HLSL = Dialect(**_FLOAT3, **_TYPES)
SLANG = Dialect(**_FLOAT3, **_TYPES, call="params.{function}({arguments})")


def run_slang(exports: Sequence[Export], rows: Sequence[Rows]) -> Results:
    """Compile each Slang or HLSL export and call it for every row."""
    slangc = tools.program("slangc", "compiles Slang and HLSL to C++")
    gxx = tools.program("g++", "compiles what slangc writes")
    hlsl = any(export.language == "hlsl" for export in exports)
    glslang = tools.program("glslangValidator", "compiles HLSL") if hlsl else ""

    def compile_and_run(batch: Sequence[Export], inputs: Sequence[Rows]) -> list[Rows]:
        with tempfile.TemporaryDirectory(prefix="gonio-") as name:
            folder = Path(name)
            for export in batch if hlsl else ():
                text = compute_text(export)
                (folder / "check.hlsl").write_text(text, encoding="utf-8")
                command = [glslang, "-D", "-V", "-e", "main", "-S", "comp", "check.hlsl"]
                line = r"check\.hlsl:(\d+):"
                tools.compile_with([*command, "-o", "check.spv"], folder, export, text, line)
            # An export whose functions run on different rows is there several times
            parts = [*dict.fromkeys(_on_processor(export) for export in batch)]
            parts += [loop_text(export, RUN.format(k)) for k, export in enumerate(batch)]
            text = "\n".join(parts)
            (folder / "export.slang").write_text(text, encoding="utf-8")
            command = [slangc, "export.slang", "-target", "cpp", "-o", "export.cpp"]
            line = r"(?:export\.slang\(|export\.slang:)(\d+)"
            tools.compile_with(command, folder, batch[0], text, line)
            text = (folder / "export.cpp").read_text(encoding="utf-8")
            command = [gxx, *FLAGS, "-w", "export.cpp", "-o", "library.so"]
            tools.compile_with(command, folder, batch[0], text, r"export\.cpp:(\d+):")
            return call_library(folder / "library.so", batch, inputs)

    return Results(tools.in_batches(compile_and_run, exports, rows), DEVICE)


def _on_processor(export: Export) -> str:
    """The source for a processor, on which there is no one who binds a buffer: a pointer has its name."""
    if export.buffer is None:
        return export.source
    name = _table(export)
    declared = resource(export.language, export.buffer.prefix, name)
    return export.source.replace(declared, f"static float4* {name};")


def _table(export: Export) -> str:
    assert export.buffer is not None
    return f"{export.buffer.prefix}_tables"


def loop_text(export: Export, name: str) -> str:
    """A function of this name, in Slang: the loop over all rows."""
    dialect = HLSL if export.language == "hlsl" else SLANG
    bound = ""
    if export.buffer is not None and reads_buffer(export):
        bound = f"    {_table(export)} = (float4*){BUFFER};\n"
    return (
        f"export __extern_cpp void {name}(float* x, float* y, int rows{given_rows(export, 'float*')})\n"
        f"{{\n{bound}"
        "    for (int row = 0; row < rows; ++row)\n    {\n"
        f"        int i = row * {input_columns(export.entry)};\n"
        f"        int o = row * {output_columns(export.entry)};\n"
        f"{indented(statements(export.entry, dialect), 8)}\n"
        "    }\n}\n"
    )


def compute_text(export: Export) -> str:
    """The source and a compute shader that calls every function, in HLSL or Slang."""
    dialect = HLSL if export.language == "hlsl" else SLANG
    return (
        f"{export.source}\n"
        "StructuredBuffer<float> x : register(t0);\nRWStructuredBuffer<float> y : register(u0);\n\n"
        "[numthreads(64, 1, 1)]\nvoid main(uint3 id : SV_DispatchThreadID)\n{\n"
        f"    uint i = id.x * {input_columns(export.entry)};\n"
        f"    uint o = id.x * {output_columns(export.entry)};\n"
        f"{indented(statements(export.entry, dialect))}\n}}\n"
    )
