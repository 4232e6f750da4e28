"""What is compiled: a function of a model, a function in a file, or a whole shader."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from gonio.export import export
from gonio.export.buffer import BINDINGS
from gonio.export.prove import cuda, opengl, slang, tools
from gonio.export.prove.harness import indented
from gonio.export.prove.lit import with_stand_ins
from gonio.export.prove.tools import ProofError
from gonio.foreign.function import parse_map, split
from gonio.foreign.harness import statements
from gonio.foreign.roles import match
from gonio.foreign.source import ForeignError, read
from gonio.model import Model

ROWS = 1 << 20
"""How many pairs the harness stops at; which number it is costs nothing."""

LANGUAGES = ("glsl", "hlsl", "slang")
"""Those that have a compiler to SPIR-V, which AMD's driver takes."""

BUFFERS = ("buffer", "buffer")
"""Where rows are read from and results go."""


@dataclass(frozen=True)
class Program:
    """A compute shader, and the same as a CUDA kernel if there is one."""

    label: str
    text: str
    language: str = "glsl"
    cuda: tuple[str, str] = ("", "")
    """A header and the kernel that includes it as export.h; empty texts: there is no such kernel."""
    bindings: tuple[str, ...] = BUFFERS
    """What the shader's bindings are, in their order: "buffer" or "texture"."""

    def spirv(self) -> bytes:
        """The shader as SPIR-V.

        Raises:
            ProofError: its compiler is missing, or refuses it.
        """
        with tempfile.TemporaryDirectory(prefix="gonio-") as name:
            folder = Path(name)
            if self.language == "slang":
                program = tools.program("slangc", "compiles Slang")
                file = "shader.slang"
                options = ["-target", "spirv", "-O0", "-entry", "main", "-stage", "compute"]
            else:
                program = tools.program("glslangValidator", "compiles GLSL and HLSL")
                file = "shader.comp" if self.language == "glsl" else "shader.hlsl"
                options = ["-V", "-e", "main", "-S", "comp", *(["-D"] * (self.language == "hlsl"))]
            (folder / file).write_text(self.text, encoding="utf-8")
            done = tools.run([program, file, *options, "-o", "shader.spv"], folder)
            if done.returncode != 0:
                said = [s for s in (done.stdout + done.stderr).splitlines() if "error" in s.lower()]
                reason = re.sub(
                    r"^ERROR: \S+?:(\d+):", r"line \1:", said[0] if said else "no message"
                )
                raise ProofError(f"{self.label} does not compile as {self.language}: {reason}")
            return (folder / "shader.spv").read_bytes()


def of_model(name: str, model: Model, function: str, language: str = "glsl") -> Program:
    """One function of a model, called for rows of directions and parameters.

    Raises:
        ExportError: the model cannot be exported.
    """
    shader = export({name: model}, language, only=[function])[0]
    header = with_stand_ins(export({name: model}, "cuda", only=[function])[0])
    text = opengl.compute_text(shader, ROWS) if language == "glsl" else slang.compute_text(shader)
    kernel = (header.source, cuda.kernel_text(header))
    # With tables, whose binding leaves some between unused
    bindings = BUFFERS if shader.buffer is None else ("buffer",) * (BINDINGS["glsl"][1] + 1)
    return Program(f"{name}, {function}", text, language, kernel, bindings)


def of_function(text: str, mapping: Sequence[str] = ()) -> Program:
    """A function in somebody's GLSL file: "FILE#FUNCTION".

    Args:
        text: where it is.
        mapping: what its arguments are, as `gonio check --map` takes it.

    Raises:
        ForeignError: it is not GLSL, or its arguments are not understood.
    """
    file, function = split(text)
    source = read(file)
    if source.language not in ("glsl", "essl"):
        raise ForeignError(
            f"{text}: the cost of {source.language} that others wrote is not measured; only GLSL's is."
        )
    found = source.find(function)
    matched = match(source, found, parse_map(mapping), {}, {})
    texels = [
        f"vec4 gonio_texel{k} = vec4({', '.join(_column(4 * k + c, matched.columns) for c in range(4))});"
        for k in range(-(-matched.columns // 4))
    ]
    lines = [*texels, "vec4 gonio_made;", *statements(source, found, matched)]
    lines += [f"y[o + {k}] = gonio_made.{c};" for k, c in enumerate("xyz")]
    return Program(f"{Path(file).name}#{found.name}", _glsl(source.text, matched.columns, 3, lines))


def _column(column: int, columns: int) -> str:
    return f"x[i + {column}]" if column < columns else "0.0"


def _glsl(source: str, columns: int, results: int, lines: Sequence[str]) -> str:
    """A compute shader over rows, as `gonio.export.prove.opengl` has it for exports."""
    bare = re.sub(r"(?m)^[ \t]*(#version.*|precision .*;)$", "", source)
    return (
        f"{opengl.HEAD}#line 1\n{bare}\n"
        "layout(local_size_x = 64) in;\n"
        "layout(std430, binding = 0) readonly buffer Given { float x[]; };\n"
        "layout(std430, binding = 1) buffer Made { float y[]; };\n\n"
        "void main() {\n    int row = int(gl_GlobalInvocationID.x);\n"
        f"    if (row >= {ROWS}) {{\n        return;\n    }}\n"
        f"    int i = row * {columns};\n    int o = row * {results};\n"
        f"{indented(lines)}\n}}\n"
    )


def empty(results: int = 3) -> Program:
    """The harness alone: it writes zeros. What it takes is no model's cost."""
    zeros = [f"y[o + {k}] = 0.0;" for k in range(results)]
    kernel = (
        'extern "C" __global__ void run(const float* x, float* y, int rows) {\n'
        "    int row = blockIdx.x * blockDim.x + threadIdx.x;\n"
        "    if (row >= rows) {\n        return;\n    }\n"
        f"    y += row * {results};\n{indented([f'y[{k}] = 0.0f;' for k in range(results)])}\n}}\n"
    )
    return Program("empty", _glsl("", 0, results, zeros), cuda=("", kernel))
