"""CUDA exports: compiled for GPUs by NVIDIA's runtime compiler, which needs none; run as C++."""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from gonio.export.entry import Export
from gonio.export.prove import tools
from gonio.export.prove.harness import (
    Results,
    given_rows,
    indented,
    input_columns,
    output_columns,
    statements,
)
from gonio.export.prove.native import cpp_dialect, run_cpp
from gonio.export.prove.tools import ProofError, Rows

VIRTUAL = "compute_80"
"""A virtual architecture that GPUs from 2020 on have."""


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
    with tempfile.TemporaryDirectory(prefix="gonio-") as name:
        folder = Path(name)
        compile_kernels([(e.source, kernel_text(e)) for e in exports], folder, VIRTUAL)
        complaints = [folder / f"{k}.error" for k in range(len(exports))]
        return [
            tools.refused(
                e,
                "NVRTC",
                c.read_text(encoding="utf-8", errors="replace"),
                e.source,
                r"export\.h\((\d+)\)",
            )
            if c.exists()
            else None
            for e, c in zip(exports, complaints, strict=True)
        ]


def compile_kernels(
    texts: Sequence[tuple[str, str]], folder: Path, architecture: str, *options: str
) -> None:
    """Compile kernels, each with the header that it includes as export.h, by one process for all of them.

    Args:
        texts: of each its header and its kernel.
        folder: where k.error is for what is refused, and k.cubin of a real architecture's machine code.
        architecture: compute_80 for a virtual one, sm_86 for a real one.
        options: more for the compiler.

    Raises:
        ProofError: NVRTC is missing or does not work.
    """
    library = tools.program("nvrtc", "compiles CUDA")
    for k, (header, kernel) in enumerate(texts):
        (folder / f"{k}.cuh").write_text(header, encoding="utf-8")
        (folder / f"{k}.cu").write_text(kernel, encoding="utf-8")
    script = str(Path(__file__).with_name("_nvrtc_worker.py"))
    command = [sys.executable, "-P", script, library, str(folder), architecture, *options]
    done = tools.run(command, folder, tools.SECONDS + tools.SECONDS_PER_JOB * len(texts))
    if done.returncode != 0:
        reason = (done.stderr.strip() or "no message").splitlines()[-1]
        raise ProofError(f"nvrtc does not work here ({reason}); {tools.INSTALL['nvrtc']}.")


def kernel_text(export: Export) -> str:
    """A kernel that calls every function for the row of each thread."""
    entry = export.entry
    return (
        '#include "export.h"\n\n'
        'extern "C" __global__ void run(const float* x, float* y, int rows'
        f"{given_rows(export, 'const float*')}) {{\n"
        "    int row = blockIdx.x * blockDim.x + threadIdx.x;\n"
        "    if (row >= rows) {\n        return;\n    }\n"
        f"    x += row * {input_columns(entry)};\n"
        f"    y += row * {output_columns(entry)};\n"
        f"{indented(statements(entry, cpp_dialect(entry.namespace + '::')))}\n}}\n"
    )
