"""CUDA exports: compiled for GPUs by NVIDIA's runtime compiler, which needs none; run as C++."""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from gonio.export.entry import Export
from gonio.export.prove import tools
from gonio.export.prove.harness import Results, indented, input_columns, output_columns, statements
from gonio.export.prove.native import cpp_dialect, run_cpp
from gonio.export.prove.tools import ProofError, Rows


def run_cuda(exports: Sequence[Export], rows: Sequence[Rows]) -> Results:
    """Compile each header in a kernel for the GPU, and as C++; call the latter for every row."""
    errors = _compile(exports)
    good = [k for k, error in enumerate(errors) if error is None]
    ran = run_cpp([exports[k] for k in good], [rows[k] for k in good])
    outputs = dict(zip(good, ran.outputs, strict=True))
    found = [error or outputs[k] for k, error in enumerate(errors)]
    return Results(found, f"{ran.device}; compiled by NVRTC")


def _compile(exports: Sequence[Export]) -> list[ProofError | None]:
    """Why NVRTC refuses each export, or None, from one process for all of them."""
    library = tools.program("nvrtc", "compiles CUDA")
    with tempfile.TemporaryDirectory(prefix="gonio-") as name:
        folder = Path(name)
        for k, export in enumerate(exports):
            (folder / f"{k}.cuh").write_text(export.source, encoding="utf-8")
            (folder / f"{k}.cu").write_text(kernel_text(export), encoding="utf-8")
        script = str(Path(__file__).with_name("_nvrtc_worker.py"))
        command = [sys.executable, "-P", script, library, name]
        done = tools.run(command, folder, tools.SECONDS + tools.SECONDS_PER_JOB * len(exports))
        if done.returncode != 0:
            reason = (done.stderr.strip() or "no message").splitlines()[-1]
            raise ProofError(f"nvrtc does not work here ({reason}); {tools.INSTALL['nvrtc']}.")
        complaints = [folder / f"{k}.error" for k in range(len(exports))]
        return [
            tools.refused(
                e, "NVRTC", c.read_text(encoding="utf-8"), e.source, r"export\.h\((\d+)\)"
            )
            if c.exists()
            else None
            for e, c in zip(exports, complaints, strict=True)
        ]


def kernel_text(export: Export) -> str:
    """A kernel that calls every function for the row of each thread."""
    entry = export.entry
    return (
        '#include "export.h"\n\n'
        'extern "C" __global__ void run(const float* x, float* y, int rows) {\n'
        "    int row = blockIdx.x * blockDim.x + threadIdx.x;\n"
        "    if (row >= rows) {\n        return;\n    }\n"
        f"    x += row * {input_columns(entry)};\n"
        f"    y += row * {output_columns(entry)};\n"
        f"{indented(statements(entry, cpp_dialect(entry.namespace + '::')))}\n}}\n"
    )
