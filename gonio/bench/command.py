"""`gonio bench`: measures gonio on this machine and reports what it found."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import drjit as dr

import gonio
from gonio import backend
from gonio.bench import albedos, machine, native, pictures, shaders, startup
from gonio.bench.pairs import (
    DISTRIBUTION,
    STREAM_BYTES,
    Entry,
    entries,
    eval_section,
    kernel_rows,
    numpy_section,
    random_pairs,
    sample_section,
    stream,
)
from gonio.bench.report import Column, Report, Section
from gonio.export.prove.tools import ProofError

SECTIONS = ("eval", "sample", "albedos", "numpy", "render", "shaders", "kernels", "startup")

NUMPY_PAIRS = 1_000_000
NUMPY_ROUNDS = 50

PICTURE_PIXELS = 256  # width and height
PICTURE_SAMPLES = 64
PICTURE_ROUNDS = 5


def bench(
    pairs: int = 4_000_000,
    repeat: int = 7,
    rows: Sequence[str] | None = None,
    output: Path | None = None,
    progress: Callable[[str], None] | None = None,
) -> Report:
    """Measure gonio beside C++, NumPy, Mitsuba's own plug-ins, shaders written by hand and the clock.

    Args:
        pairs: how many pairs of directions, at least 1.
        repeat: how many times the two sides of a comparison run in turn; the medians are reported.
        rows: what to measure: names of sections (eval, sample, albedos, numpy, render, shaders, kernels,
            startup), of models and of rows such as "eon_fitted". None measures everything.
        output: a file for the report: Markdown, or JSON if its name ends in .json.
        progress: is told what is measured next; None prints that to stderr.

    Raises:
        ValueError: a number below 1, or a name in `rows` that is not known.
        BackendError: there is no usable LLVM.
        BenchError: gonio and the baseline computed different values.
        RuntimeError: there is no C++ compiler; the message says what to install.
    """
    if pairs < 1 or repeat < 1:
        raise ValueError(f"pairs={pairs}, repeat={repeat}: both must be at least 1.")
    if not backend.available("llvm"):
        raise backend.BackendError(f"gonio bench needs LLVM. {backend.missing_llvm_reason()}")
    say = progress or _to_stderr
    say("compiling the C++ baseline")
    baseline = native.compile_baseline()
    sections, models = _chosen(rows, baseline)

    def only(entry: Entry) -> bool:
        return models is None or bool({entry.label, entry.model.name} & models)

    described = machine.describe()
    say("memory bandwidth")
    memory = stream(pairs)
    best = min(memory() for _ in range(8))
    triad = baseline.bandwidth(dr.thread_count(), repeat=8)
    described["memory"] = (
        f"{STREAM_BYTES * pairs / best / 1e9:.1f} GB/s read and written by a Dr.Jit kernel a + b x over "
        f"{STREAM_BYTES * pairs / 1e6:.3g} MB, {triad / 1e9:.1f} GB/s by STREAM's triad in C++ over "
        f"{12 * native.TRIAD_FLOATS / 1e6:.3g} MB"
    )
    arrays = random_pairs(pairs) if sections & {"eval", "sample"} else None
    found: list[Section] = []
    if arrays is not None and "eval" in sections:
        found.append(eval_section(baseline, arrays, memory, repeat, only, say))
    if arrays is not None and "sample" in sections:
        found.append(sample_section(baseline, arrays, memory, repeat, only, say))
    if "albedos" in sections:
        found.append(albedos.albedo_section(repeat, only, say))
    if "numpy" in sections:
        found.append(numpy_section(min(pairs, NUMPY_PAIRS), NUMPY_ROUNDS, say))
    if "render" in sections:
        found.append(pictures.render_section(PICTURE_PIXELS, PICTURE_SAMPLES, PICTURE_ROUNDS, say))
    if "kernels" in sections:
        found.append(kernel_section(say))
    if "startup" in sections:
        found.append(startup.startup_section(repeat, say))
    notes = [
        f"Times are medians of {repeat} rounds in which the sides of a comparison take turns. "
        "Arrays are float32 and in memory; compilation and the first call are not in the times. "
        "Models have their default parameters, which the kernels do not know as constants.",
        DISTRIBUTION,
    ]
    if "shaders" in sections:
        try:
            found.extend(shaders.shader_sections(repeat, say))
        except ProofError as error:
            say(f"leaving out the shaders: {error}")
            notes.append(f"The exported shaders were not measured: {error}")
    report = Report(described, notes, found)
    if output is not None:
        report.write(output)
    return report


def kernel_section(progress: Callable[[str], None]) -> Section:
    """How many kernels are compiled when a parameter gets another value."""
    rows = [*kernel_rows(progress), *pictures.kernel_rows(progress)]
    columns = (
        Column("row", "what is computed"),
        Column("changes", "changed values"),
        Column("compiled", "new kernels"),
    )
    note = (
        "Each parameter of a model gets another value, alone; Dr.Jit's kernel history is compared."
    )
    return Section("kernels", "Kernels compiled for changed parameters", [note], columns, rows)


def _chosen(
    names: Sequence[str] | None, baseline: native.Baseline
) -> tuple[set[str], set[str] | None]:
    """The sections to measure, and the models and labels in them (None: all)."""
    if names is None:
        return set(SECTIONS), None
    labels = {e.label for e in entries((*baseline.eval_names, *baseline.sample_names))}
    known = {*SECTIONS, *labels, *gonio.models()}
    for name in names:
        if name not in known:
            raise ValueError(f"no row {name!r} in the bench; known are {', '.join(sorted(known))}.")
    sections, models = set(names) & set(SECTIONS), set(names) - set(SECTIONS)
    if models and not sections & {"eval", "sample", "albedos"}:
        sections |= {"eval", "sample"}
    return sections, models or None


def _to_stderr(text: str) -> None:
    print(f"bench: {text} …", file=sys.stderr, flush=True)
