"""GLSL exports, compiled by glslangValidator and by the driver, run through OpenGL without a window.

GLSL 4.5 runs as a compute shader. GLSL ES 3.00 runs as a fragment shader that gets its rows from a texture,
because it has no compute shaders: as on a web page.
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path

from gonio.export.entry import Export
from gonio.export.prove import tools
from gonio.export.prove.harness import (
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

_HEADS = {
    "glsl": "#version 450\n",
    "essl": "#version 300 es\nprecision highp float;\nprecision highp int;\n",
}

# Mesa writes 0:12(3): error; other drivers 0(12) : error or ERROR: 0:12:
LINE = r"\b0[:(](\d+)"


def run_glsl(exports: Sequence[Export], rows: Sequence[Rows]) -> Results:
    """Compile each export of GLSL 4.5 twice and run it as a compute shader."""
    return _run(exports, rows, ".comp")


def run_essl(exports: Sequence[Export], rows: Sequence[Rows]) -> Results:
    """Compile each export of GLSL ES 3.00 twice and run it as a fragment shader."""
    return _run(exports, rows, ".frag")


def _run(exports: Sequence[Export], rows: Sequence[Rows], suffix: str) -> Results:
    validator = tools.program("glslangValidator", "compiles GLSL")
    tools.program("moderngl", "runs GLSL")
    text_of = compute_text if suffix == ".comp" else fragment_text

    def check(export: Export, inputs: Rows) -> Rows:
        text = text_of(export, len(inputs))
        with tempfile.TemporaryDirectory(prefix="gonio-") as name:
            folder = Path(name)
            (folder / f"export{suffix}").write_text(text, encoding="utf-8")
            # GLSL ES has no SPIR-V before 3.10
            to_spirv = ["-V", "-o", "export.spv"] if suffix == ".comp" else []
            command = [validator, *to_spirv, f"export{suffix}"]
            offset = _HEADS[export.language].count("\n")
            tools.compile_with(command, folder, export, export.source, r":(\d+):", offset)
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
        )
        for k in good
    ]
    outputs, device = tools.run_worker(
        "_egl_worker.py", suffix, jobs, "the OpenGL driver", "moderngl"
    )
    found = dict(zip(good, outputs, strict=True))
    return Results([found.get(k, result) for k, result in enumerate(checked)], device)


def compute_text(export: Export, count: int) -> str:
    """The source with a compute shader that calls every function for each row."""
    entry = export.entry
    return (
        f"{_HEADS[export.language]}{export.source}\n"
        "layout(local_size_x = 64) in;\n"
        "layout(std430, binding = 0) readonly buffer Given { float x[]; };\n"
        "layout(std430, binding = 1) writeonly buffer Made { float y[]; };\n\n"
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
        f"{_HEADS[export.language]}{export.source}\n"
        f"uniform highp sampler2D rows;\n{targets}\nvoid main() {{\n{indented(lines)}\n}}\n"
    )
