"""GLSL exports, compiled by the driver and run through OpenGL without a window.

GLSL 4.5 runs as a compute shader, here and a second time in gonio.export.prove.vulkan. GLSL ES 3.00 runs as
a fragment shader that gets its rows from a texture, because it has no compute shaders: as on a web page.
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from gonio.export.buffer import BINDINGS, WIDTH
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

GLSL = Dialect(vec2="vec2({0}, {1})", vec3="vec3({0}, {1}, {2})")
ESSL = Dialect(
    vec2=GLSL.vec2, vec3=GLSL.vec3, read="texel{texel}.{component}", write="made[{0}] = {1};"
)

HEAD = "#version 450\n"
HEAD_ES = "#version 300 es\nprecision highp float;\nprecision highp int;\n"

# Mesa writes 0:12(3): error; other drivers 0(12) : error or ERROR: 0:12:
LINE = r"\b0[:(](\d+)"


def run_glsl(exports: Sequence[Export], rows: Sequence[Rows]) -> Results:
    """Compile each export of GLSL 4.5 twice and run it as a compute shader."""
    return _run(exports, rows, ".comp", ["-V", "-o", "export.spv"])


def run_essl(exports: Sequence[Export], rows: Sequence[Rows]) -> Results:
    """Compile each export of GLSL ES 3.00 twice and run it as a fragment shader."""
    return _run(exports, rows, ".frag", [])  # GLSL ES has no SPIR-V before 3.10


def compile_glsl(
    export: Export, text: str, head: str, suffix: str, options: Sequence[str], folder: Path
) -> None:
    """Let glslangValidator compile a shader in a folder, or raise a ProofError that quotes a line."""
    validator = tools.program("glslangValidator", "compiles GLSL")
    (folder / f"export{suffix}").write_text(text, encoding="utf-8")
    command = [validator, *options, f"export{suffix}"]
    tools.compile_with(command, folder, export, export.source, r":(\d+):", head.count("\n"))


def _run(
    exports: Sequence[Export], rows: Sequence[Rows], suffix: str, options: Sequence[str]
) -> Results:
    tools.program("glslangValidator", "compiles GLSL")
    tools.program("moderngl", "runs GLSL")
    text_of, head = (compute_text, HEAD) if suffix == ".comp" else (fragment_text, HEAD_ES)

    def check(export: Export, inputs: Rows) -> Rows:
        with tempfile.TemporaryDirectory(prefix="gonio-") as name:
            text = text_of(export, len(inputs))
            compile_glsl(export, text, head, suffix, options, Path(name))
        return inputs

    checked = tools.side_by_side(check, exports, rows)
    good = [k for k, result in enumerate(checked) if not isinstance(result, tools.ProofError)]
    jobs = [
        tools.Job(
            exports[k],
            text_of(exports[k], len(rows[k])),
            rows[k],
            output_columns(exports[k].entry),
            LINE,
            _tables_of(exports[k]),
        )
        for k in good
    ]
    outputs, device = tools.run_worker(
        "_egl_worker.py", suffix, jobs, "the OpenGL driver", "moderngl"
    )
    found = dict(zip(good, outputs, strict=True))
    return Results([found.get(k, result) for k, result in enumerate(checked)], device)


def _tables_of(export: Export) -> dict[str, Any]:
    """The number of the buffer, or the name and width of the texture."""
    if export.buffer is None:
        return {}
    return {
        "tables": {
            "buffer": BINDINGS["glsl"][1],
            "texture": f"{export.buffer.prefix}_tables",
            "width": WIDTH,
        }
    }


def compute_text(export: Export, count: int) -> str:
    """The source with a compute shader that calls every function for each row."""
    entry = export.entry
    read = f"float {CODE}(int k) {{\n    return x[k];\n}}\n\n" if CODE in export.source else ""
    return (
        f"{HEAD}{export.source}\n"
        "layout(local_size_x = 64) in;\n"
        "layout(std430, binding = 0) readonly buffer Given { float x[]; };\n"
        "layout(std430, binding = 1) buffer Made { float y[]; };\n\n"
        f"{read}"
        "void main() {\n"
        "    int row = int(gl_GlobalInvocationID.x);\n"
        f"    if (row >= {count}) {{\n        return;\n    }}\n"
        f"    int i = row * {input_columns(entry)};\n"
        f"    int o = row * {output_columns(entry)};\n"
        f"{indented(statements(entry, GLSL))}\n}}\n"
    )


def fragment_text(export: Export, count: int) -> str:
    """The source with a fragment shader whose pixel is one row."""
    entry = export.entry
    texels, colours = -(-input_columns(entry) // 4), -(-output_columns(entry) // 4)
    fetched = [
        f"vec4 texel{k} = texelFetch(rows, pixel * ivec2({texels}, 1) + ivec2({k}, 0), 0);"
        for k in range(texels)
    ]
    targets = "".join(f"layout(location = {k}) out vec4 colour{k};\n" for k in range(colours))
    written = [
        f"colour{k} = vec4({', '.join(f'made[{4 * k + c}]' for c in range(4))});"
        for k in range(colours)
    ]
    lines = [
        "ivec2 pixel = ivec2(gl_FragCoord.xy);",
        *fetched,
        f"float made[{4 * colours}];",
        *statements(entry, ESSL),
        *written,
    ]
    return (
        f"{HEAD_ES}{export.source}\n"
        f"uniform highp sampler2D rows;\n{targets}\nvoid main() {{\n{indented(lines)}\n}}\n"
    )
