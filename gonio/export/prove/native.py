"""C++ and MSL exports, compiled by g++ into a library and called by ctypes."""

from __future__ import annotations

import ctypes
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

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
from gonio.export.prove.tools import Rows

# -O1 compiles in half the time of -O2. Products and sums are not contracted, so that processors agree.
# Tables in inline functions would be one for all libraries of the process, whichever was loaded first.
FLAGS = ("-std=c++17", "-O1", "-ffp-contract=off", "-fPIC", "-shared", "-fno-gnu-unique")

# Users compile headers with warnings on; parameters that a model does not need stay in signatures.
WARNINGS = ("-Wall", "-Wextra", "-Werror", "-Wno-unused-parameter")

# CUDA's words mean nothing to g++, which checks the rest.
CUDA = ("-D__host__=", "-D__device__=", "-D__forceinline__=inline")

# Metal's literals are single precision. g++ keeps quiet about MSL's own words and attributes.
METAL = Path(__file__).with_name("metal")
METAL_FLAGS = ("-fsingle-precision-constant", "-Wno-attributes", "-x", "c++", f"-I{METAL}")

RUN = "run_{}"
"""Name of the function that runs all rows of an export, of several in one library."""


def run_cpp(exports: Sequence[Export], rows: Sequence[Rows]) -> Results:
    """Compile each header, without a warning, and call it for every row."""
    return _run(exports, rows, "compiles C++", "processor, g++")


def run_msl(exports: Sequence[Export], rows: Sequence[Rows]) -> Results:
    """Compile each MSL export as C++ against a stand-in of Metal's library; call it for every row."""
    device = "processor, g++ with a stand-in for Metal"
    return _run(exports, rows, "compiles MSL as C++", device)


def _run(exports: Sequence[Export], rows: Sequence[Rows], purpose: str, device: str) -> Results:
    compiler = tools.program("g++", purpose)

    def compile_and_run(batch: Sequence[Export], inputs: Sequence[Rows]) -> list[Rows]:
        with tempfile.TemporaryDirectory(prefix="gonio-") as name:
            folder = Path(name)
            # An export whose functions run on different rows is there several times
            headers = {e.source: f"export{k}.h" for k, e in enumerate(batch)}
            for source, header in headers.items():
                (folder / header).write_text(source, encoding="utf-8")
            text = [f'#include "{header}"\n' for header in headers.values()]
            text += [loop_text(export, RUN.format(k)) for k, export in enumerate(batch)]
            (folder / "main.cpp").write_text("\n".join(text), encoding="utf-8")
            flags = {"cuda": CUDA, "msl": METAL_FLAGS}.get(batch[0].language, ())
            command = [compiler, *FLAGS, *WARNINGS, *flags, "main.cpp", "-o", "library.so"]
            tools.compile_with(command, folder, batch[0], batch[0].source, r"export0\.h:(\d+):")
            return call_library(folder / "library.so", batch, inputs)

    return Results(tools.in_batches(compile_and_run, exports, rows), device)


def loop_text(export: Export, name: str) -> str:
    """A function of this name: the loop over all rows."""
    entry = export.entry
    dialect = METAL_DIALECT if export.language == "msl" else cpp_dialect(entry.namespace + "::")
    return (
        f'extern "C" void {name}(const float* x, float* y, int rows'
        f"{given_rows(export, 'const float*')}) {{\n"
        f"    for (int row = 0; row < rows; ++row, x += {input_columns(entry)}, "
        f"y += {output_columns(entry)}) {{\n"
        f"{indented(statements(entry, dialect), 8)}\n    }}\n}}\n"
    )


def cpp_dialect(scope: str) -> Dialect:
    """C++ and CUDA; `scope` is the namespace of the export."""
    return Dialect(
        vec2=f"{scope}Vec2{{{{{{0}}, {{1}}}}}}",
        vec3=f"{scope}Vec3{{{{{{0}}, {{1}}, {{2}}}}}}",
        vec2_type=f"{scope}Vec2",
        vec3_type=f"{scope}Vec3",
        read="x[{column}]",
        write="y[{0}] = {1};",
        scope=scope,
    )


METAL_DIALECT = Dialect(
    vec2="float2({0}, {1})",
    vec3="float3({0}, {1}, {2})",
    vec2_type="float2",
    vec3_type="float3",
    read="x[{column}]",
    write="y[{0}] = {1};",
    buffer=f"reinterpret_cast<const float4*>({BUFFER})",
)


def call_library(library: Path, exports: Sequence[Export], rows: Sequence[Rows]) -> list[Rows]:
    """Call the library's function of each export for all its rows, in this process."""
    loaded = ctypes.CDLL(str(library))
    functions = [loaded[RUN.format(k)] for k in range(len(exports))]
    return [_called(*call) for call in zip(functions, exports, rows, strict=True)]


def _called(function: Any, export: Export, inputs: Rows) -> Rows:
    inputs = np.ascontiguousarray(inputs, np.float32)
    outputs = np.full((len(inputs), output_columns(export.entry)), np.nan, np.float32)
    pointer = ctypes.POINTER(ctypes.c_float)
    arguments = [inputs.ctypes.data_as(pointer), outputs.ctypes.data_as(pointer), len(inputs)]
    function.argtypes, function.restype = [pointer, pointer, ctypes.c_int], None
    if export.buffer is not None and reads_buffer(export):
        rows = aligned(export.buffer.rows())
        function.argtypes = [*function.argtypes, pointer]
        arguments.append(rows.ctypes.data_as(pointer))
    function(*arguments)
    return outputs


def aligned(rows: Rows) -> Rows:
    """The same numbers where vectors of four may lie."""
    space = np.zeros(rows.size + 16, np.float32)
    start = -space.ctypes.data % 64 // 4
    found = space[start : start + rows.size].reshape(rows.shape)
    found[:] = rows
    return found
