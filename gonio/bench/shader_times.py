"""How long shaders take: compute shaders run in turn by OpenGL, in a process of its own."""

from __future__ import annotations

import json
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from gonio.export.entry import Export
from gonio.export.prove import opengl, tools
from gonio.export.prove.harness import output_columns
from gonio.export.prove.rows import rows_for
from gonio.export.prove.tools import ProofError
from gonio.model import Model

PAIRS = 1 << 18
"""Pairs of directions per run."""

CALLS = 256
"""Calls of an arc function per number: they, not the memory, take the time."""


@dataclass(frozen=True)
class Arc:
    """One way to compute one function in GLSL."""

    name: str
    way: str
    body: str
    """GLSL in terms of x."""
    library: str
    """GLSL that the body calls."""


Values = npt.NDArray[np.float32]


def eval_times(model: Model, shaders: Sequence[Export], repeat: int) -> tuple[list[float], str]:
    """Median seconds per pair of directions of each shader, and the device.

    Raises:
        ProofError: a tool is missing, or a shader does not compile.
    """
    entry = shaders[0].entry
    # The rows of the proof, over and over: making so many takes longer than running them
    few = rows_for(model, entry.members, 1 << 12)
    rows = np.tile(few, (PAIRS // len(few), 1))
    texts = [opengl.compute_text(shader, PAIRS) for shader in shaders]
    seconds, _, device = _run(texts, rows, output_columns(entry), repeat)
    return [s / PAIRS for s in seconds], device


def arc_values_and_times(
    arcs: Sequence[Arc], x: Values, repeat: int
) -> tuple[list[tuple[Values, float]], str]:
    """What each way computes for each x, its median seconds per call, and the device.

    Raises:
        ProofError: a tool is missing, or a shader does not compile.
    """
    rows = x[:, None]
    _, values, device = _run([_arc_text(a, len(x), 0) for a in arcs], rows, 1, 1)
    long, _, _ = _run([_arc_text(a, len(x), CALLS) for a in arcs], rows, 1, repeat)
    calls = CALLS * len(x)
    return [(v[:, 0], s / calls) for v, s in zip(values, long, strict=True)], device


def _arc_text(arc: Arc, count: int, calls: int) -> str:
    """A compute shader for one value per row, or for the sum of many values near it."""
    value = "arc(x[row])"
    if calls:
        value = "total"
    return (
        f"#version 450\n{arc.library}\n"
        f"float arc(float x) {{\n    return {arc.body};\n}}\n"
        "layout(local_size_x = 64) in;\n"
        "layout(std430, binding = 0) readonly buffer Given { float x[]; };\n"
        "layout(std430, binding = 1) writeonly buffer Made { float y[]; };\n\n"
        "void main() {\n"
        "    int row = int(gl_GlobalInvocationID.x);\n"
        f"    if (row >= {count}) {{\n        return;\n    }}\n"
        "    float total = 0.0;\n"
        f"    for (int i = 0; i < {calls}; ++i) {{\n"
        f"        total += arc(x[row] * (1.0 - float(i) * {1 / max(calls, 1)!r}));\n    }}\n"
        f"    y[row] = {value};\n}}\n"
    )


def _run(
    texts: Sequence[str], rows: Values, columns: int, repeat: int
) -> tuple[list[float], list[Values], str]:
    """Median seconds and outputs of each compute shader, and the device."""
    tools.program("moderngl", "runs GLSL")
    with tempfile.TemporaryDirectory(prefix="gonio-") as name:
        folder = Path(name)
        for number, text in enumerate(texts):
            (folder / f"{number}.comp").write_text(text, encoding="utf-8")
        np.save(folder / "rows.npy", np.ascontiguousarray(rows, np.float32))
        job = {"shaders": len(texts), "columns": columns, "repeat": repeat}
        (folder / "job.json").write_text(json.dumps(job), encoding="utf-8")
        worker = Path(__file__).with_name("_shader_worker.py")
        # -P: the folder of the script is not searched for modules
        done = tools.run([sys.executable, "-P", str(worker), str(folder)], folder)
        if done.returncode != 0:
            last = (done.stderr.strip() or f"signal {-done.returncode}").splitlines()[-1]
            raise ProofError(f"the OpenGL driver does not work here: {last}")
        found = json.loads((folder / "times.json").read_text(encoding="utf-8"))
        values = [np.load(folder / f"{number}.npy") for number in range(len(texts))]
    return found["seconds"], values, found["device"]
