"""The strongest peer of gonio's arrays: its own C++ export in a loop that the compiler vectorises.

What such a loop needs, and what people who use the header do as well: parameters in a local copy, so that
stores cannot change them; pointers that do not overlap, as arguments (g++ ignores __restrict elsewhere);
x, y and z in arrays of their own; the whole model inlined (flatten); and -Ofast -march=native, since
square roots and choices are vectorised only where errno and NaN do not matter.
"""

from __future__ import annotations

import ctypes
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from gonio.bench.native import Directions, Floats, Timed, compiled_library, pointers
from gonio.export import export
from gonio.export.buffer import check_unread
from gonio.export.entry import Entry
from gonio.model import Model

# A library that is linked with -Ofast tells the processor to flush small numbers, for the whole program
# that loads it; the start files that do so are left out.
FLAGS = ("-std=c++17", "-Ofast", "-march=native", "-fPIC", "-shared", "-nostartfiles", "-pthread")


def exported_loops(
    models: Mapping[str, Model], flags: Sequence[str] = FLAGS
) -> dict[str, ExportedLoop]:
    """Compile the loops over the exports of some models, all in one library.

    Args:
        models: by names, which are those of C++ too.
        flags: of the compiler.

    Raises:
        ExportError: a model cannot be exported.
        RuntimeError: there is no C++ compiler, or it refuses the headers.
    """
    shaders = {
        name: export({name: model}, "cpp", only=["eval"])[0] for name, model in models.items()
    }
    texts = [INCLUDES]
    for name, shader in shaders.items():
        check_unread(shader.buffer, "this loop")
        texts += [shader.source, _loop(shader.entry, name)]
    with tempfile.TemporaryDirectory(prefix="gonio-") as folder:
        source = Path(folder) / "loops.cpp"
        source.write_text("\n".join(texts), encoding="utf-8")
        library = ctypes.CDLL(str(compiled_library(source, flags, f"export-{next(iter(models))}")))
    return {
        name: ExportedLoop(library[f"run_{name}"], _numbers(models[name], shader.entry))
        for name, shader in shaders.items()
    }


class ExportedLoop:
    """`eval` of a model's C++ export over arrays."""

    def __init__(self, run: Any, numbers: Floats) -> None:
        """Take the compiled function, and the parameters as it reads them."""
        self._run, self._numbers = run, numbers
        self._run.restype = ctypes.c_double

    def eval(self, wi: Directions, wo: Directions, threads: int) -> Timed:
        """Values for every pair, and how long that took."""
        out = np.empty((3, len(wi[0])), np.float32)
        seconds = self._run(
            self._numbers.ctypes.data_as(ctypes.POINTER(ctypes.c_float)),
            pointers([*wi, *wo]),
            pointers(list(out)),
            ctypes.c_size_t(out.shape[1]),
            ctypes.c_int(threads),
        )
        return Timed(float(seconds), out)


def _numbers(model: Model, entry: Entry) -> Floats:
    """The parameters as the struct of the export has them, in order."""
    values: dict[str, Any] = {path: value for path, _, value in model.parameters()}
    found: list[float] = []
    for member in entry.members:
        value = values[member.path]
        found.extend(value if isinstance(value, Sequence) else [value] * member.width)
    return np.array(found, np.float32)


INCLUDES = "#include <chrono>\n#include <cstddef>\n#include <thread>\n#include <vector>\n"


def _loop(entry: Entry, name: str) -> str:
    """The loop over all pairs and the threads that share them: the function run_NAME."""
    scope = f"{entry.namespace}::"
    lines, column = [], 0
    for member in entry.members:
        numbers = ", ".join(f"p[{k}]" for k in range(column, column + member.width))
        value = f"{scope}Vec3{{{numbers}}}" if member.width == 3 else numbers
        lines.append(f"    params.{member.place} = {value};")
        column += member.width
    assigned = "\n".join(lines)
    axes = [f"{w}_{c}" for w in ("wi", "wo") for c in "xyz"]
    read = ", ".join(f"const float* __restrict {axis}" for axis in axes)
    written = ", ".join(f"float* __restrict {channel}" for channel in "rgb")
    given = ", ".join([*(f"in[{k}]" for k in range(6)), *(f"out[{k}]" for k in range(3))])
    return f"""
namespace loop_{name} {{

__attribute__((hot, flatten, noinline))
static void loop(
    const {scope}{entry.struct} params, std::size_t first, std::size_t last, {read}, {written}) {{
    for (std::size_t i = first; i < last; ++i) {{
        const {scope}Vec3 f = {scope}{entry.prefix}_eval(
            params, {scope}Vec3{{wi_x[i], wi_y[i], wi_z[i]}}, {scope}Vec3{{wo_x[i], wo_y[i], wo_z[i]}});
        r[i] = f.x;
        g[i] = f.y;
        b[i] = f.z;
    }}
}}

static void part(
    const float* p, const float* const* in, float* const* out, std::size_t first, std::size_t last) {{
    {scope}{entry.struct} params;
{assigned}
    loop(params, first, last, {given});
}}

extern "C" double run_{name}(
    const float* p, const float* const* in, float* const* out, std::size_t n, int threads) {{
    const auto start = std::chrono::steady_clock::now();
    std::vector<std::thread> others;
    for (int t = 0; t + 1 < threads; ++t)
        others.emplace_back(part, p, in, out, n * t / threads, n * (t + 1) / threads);
    part(p, in, out, n * (threads - 1) / threads, n);
    for (std::thread& other : others) other.join();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}}

}}  // namespace loop_{name}
"""
