"""Exports beside shaders written by hand: cycles of eval on GPUs of AMD, instructions on NVIDIA's."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from gonio.bench import shaders
from gonio.bench.report import Column, Section, Value, ratio
from gonio.cost import amd, glsl_as_cuda, nvidia
from gonio.cost.gpus import Gpu
from gonio.cost.program import ROWS, Program, empty
from gonio.export.entry import Export
from gonio.export.prove import opengl

NOTES = (
    "GLSL that `gonio export` writes, beside shaders of the same functions written by hand "
    "(gonio/bench/handwritten): with all digits of a float32 in the whole range that the model promises; "
    "and as engines have them, where that is another shader. A ratio is the export's cost over theirs.",
    "Both keep two promises that cost cycles: nothing is infinite where both directions are in the "
    "horizon, and no digits are lost between opposite ones there, whose half vectors are so short that a "
    "GPU takes their squares for 0. Without them weidlich_wilkie by hand needs 203 cycles on navi21 (206 "
    "with), disney 173 (179) and triace_blinn_phong 62 (65); that weidlich_wilkie is infinite in six of "
    "the tested values there, and off by hundreds in others.",
    "weidlich_wilkie is one coat over another. NVIDIA's compiler gets both as C++ with GLSL's "
    "types, so that both texts go the same way; it tells no cycles.",
)


def by_hand(gpus: Sequence[Gpu], progress: Callable[[str], None] = lambda text: None) -> Section:
    """The exports that have a shader written by hand, measured for some GPUs.

    Cycles of AMD's, whose compiler tells them; instructions of NVIDIA's.

    Raises:
        ProofError: a compiler is missing, or refuses a shader.
    """
    names = list(shaders.subjects())
    columns = [Column("row", "eval")]
    rows: list[dict[str, Value]] = [{"row": name} for name in names]
    kinds = {"": "", "_by_hand": " by hand", "_plain": " as in engines"}
    for gpu in gpus:
        unit = "cycles" if gpu.vendor == "amd" else "instructions"
        progress(f"cost: exports and shaders written by hand on {gpu.name}")
        _measure(rows, names, gpu)
        for kind, heading in kinds.items():
            columns.append(Column(f"{gpu.name}{kind}", f"{gpu.name} {unit}{heading}"))
            if kind:
                columns.append(Column(f"{gpu.name}{kind}_ratio", "ratio", ratio))
    return Section("by_hand", "Exports beside shaders written by hand", NOTES, columns, rows)


def _measure(rows: Sequence[dict[str, Value]], names: Sequence[str], gpu: Gpu) -> None:
    """Fill in a GPU's cells."""
    found = [
        (row, kind, shader)
        for row, name in zip(rows, names, strict=True)
        for kind, shader in (
            ("", shaders.exported(name)),
            ("_by_hand", shaders.handwritten(name)),
            ("_plain", shaders.plain(name)),
        )
        if shader is not None
    ]
    for (row, kind, _), price in zip(found, _prices(found, gpu), strict=True):
        row[f"{gpu.name}{kind}"] = price
        if kind:
            ours = row[gpu.name]
            assert isinstance(ours, int)
            row[f"{gpu.name}{kind}_ratio"] = ours / price


def _prices(found: Sequence[tuple[dict[str, Value], str, Export]], gpu: Gpu) -> list[int]:
    """Of each shader, less what the harness takes."""
    labelled = [(f"{row['row']}{kind}", shader) for row, kind, shader in found]
    if gpu.vendor == "amd":
        programs = [Program(label, opengl.compute_text(shader, ROWS)) for label, shader in labelled]
        *measured, nothing = amd.measure([*programs, empty()], gpu)
    else:
        kernels = [glsl_as_cuda.kernel(shader, label) for label, shader in labelled]
        *measured, nothing = nvidia.measure([*kernels, empty()], gpu, *glsl_as_cuda.OPTIONS)
    return [(numbers - nothing).price for numbers in measured]
