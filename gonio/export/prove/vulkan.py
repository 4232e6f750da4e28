"""GLSL exports a second time: made SPIR-V by glslangValidator, and run through wgpu, by Vulkan on Linux."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path

from gonio.export.buffer import BINDINGS
from gonio.export.entry import Export
from gonio.export.prove import tools
from gonio.export.prove.harness import Results, output_columns
from gonio.export.prove.opengl import HEAD, compile_glsl, compute_text
from gonio.export.prove.tools import ProofError, Rows


def run_spirv(exports: Sequence[Export], rows: Sequence[Rows]) -> Results:
    """Compile each export of GLSL 4.5 to SPIR-V and run it for every row."""
    tools.program("glslangValidator", "compiles GLSL")
    tools.program("wgpu", "runs SPIR-V")

    def compiled(export: Export, inputs: Rows) -> tools.Job:
        text = compute_text(export, len(inputs))
        with tempfile.TemporaryDirectory(prefix="gonio-") as name:
            compile_glsl(export, text, HEAD, ".comp", ["-V", "-o", "export.spv"], Path(name))
            words = (Path(name) / "export.spv").read_bytes()
        # wgpu speaks of words, not of lines
        binding = {"tables": BINDINGS["spirv"]}
        return tools.Job(export, words, inputs, output_columns(export.entry), r"(?!)", binding)

    made = tools.side_by_side(compiled, exports, rows)
    good = {k: job for k, job in enumerate(made) if not isinstance(job, ProofError)}
    outputs, device = tools.run_worker(
        "_wgpu_worker.py", ".spv", list(good.values()), "wgpu", "wgpu"
    )
    ran = dict(zip(good, outputs, strict=True))
    refused = {k: error for k, error in enumerate(made) if isinstance(error, ProofError)}
    return Results([(ran | refused)[k] for k in range(len(made))], device)
