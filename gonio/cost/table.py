"""The table of `gonio cost`: models in rows, GPUs in columns, a model to compare with in the same run."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial

from gonio.bench import shader_times
from gonio.bench.report import Column, Section, Value
from gonio.cost import amd, nvidia
from gonio.cost.gpus import Gpu
from gonio.cost.measured import Measured
from gonio.cost.program import Program, empty, of_function, of_model
from gonio.export import export
from gonio.export.buffer import check_unread
from gonio.export.prove.harness import WIDTHS
from gonio.model import Model

FUNCTIONS = ("eval", "sample", "pdf")
"""What is measured when nothing is named: an albedo is not computed per pixel where a renderer samples."""

NOTES = (
    "Machine code for GPUs that need not be there, of one call: AMD's by Mesa's driver RADV (-O as for "
    "games), NVIDIA's by NVRTC with fast functions. The harness that writes zeros is taken away; reading "
    "directions and parameters is included.",
    "Cycles are the compiler's estimate of what 64 threads take from a busy unit. "
    "Registers are vector registers of a thread: more of them leave room for fewer threads.",
    "There is no share of a GPU's peak: that is a rate of fused multiply-adds in a second, and code that "
    "was compiled but not run has no seconds.",
)

NO_GPU = (
    "That is a processor: a GPU's time can only be measured where there is one, by --time there."
)

LOOPS = (
    "A loop counts once in the instructions, and in the cycles as if it had some 16 turns, "
    "however many it has."
)


def measure(programs: Sequence[Program], gpu: Gpu) -> list[Measured | None]:
    """Numbers of each program on a GPU; None for what has no text for it.

    Raises:
        ProofError: a compiler is missing, or refuses a program.
    """
    if gpu.vendor == "amd":
        return list(amd.measure(programs, gpu))
    with_kernel = [k for k, program in enumerate(programs) if program.cuda[1]]
    found = nvidia.measure([programs[k] for k in with_kernel], gpu)
    numbers = dict(zip(with_kernel, found, strict=True))
    return [numbers.get(k) for k in range(len(programs))]


def cost(
    models: Mapping[str, Model],
    files: Sequence[str] = (),
    *,
    functions: Sequence[str] = FUNCTIONS,
    language: str = "glsl",
    gpus: Sequence[Gpu],
    against: tuple[str, Model] | None = None,
    mapping: Sequence[str] = (),
    rounds: int = 0,
    progress: Callable[[str], None] = lambda text: None,
) -> Section:
    """What the shaders of models cost on GPUs.

    Args:
        models: by the names that their rows get.
        files: functions in GLSL files, "FILE#FUNCTION"; compared with `eval`.
        functions: of "eval", "sample", "pdf", "albedo".
        language: in which the models are exported for AMD's GPUs, one of `program.LANGUAGES`.
        gpus: for which machine code is made.
        against: a model to which all are compared, function by function.
        mapping: what the arguments of functions in files are.
        rounds: how often each is run on the GPU that is there, for its time; 0 for no times.
        progress: is told what is compiled next.

    Raises:
        ProofError: a compiler is missing, or refuses a shader.
        ExportError: a model cannot be exported.
        ForeignError: a function in a file is not understood.
    """
    rows: list[dict[str, Value]] = []
    device = ""
    for function in functions:
        subjects = dict(models)
        if against is not None:
            subjects.setdefault(*against)
        programs = [of_model(name, model, function, language) for name, model in subjects.items()]
        if function == "eval":
            programs += [of_function(text, mapping) for text in files]
        new: list[dict[str, Value]] = [{"row": program.label} for program in programs]
        baseline = None if against is None else list(subjects).index(against[0])
        for gpu in gpus:
            progress(f"cost: {function} on {gpu.name}")
            found = measure([*programs, empty(WIDTHS[function])], gpu)
            nothing = found.pop()
            assert nothing is not None
            for row, numbers in zip(new, found, strict=True):
                row |= _cells(gpu, numbers and numbers - nothing)
            if baseline is not None:
                _compare(new, f"{gpu.name}_price", f"{gpu.name}_ratio", baseline)
        if rounds and function == "eval":
            progress("cost: time of eval")
            device = _times(new, subjects, rounds)
            if baseline is not None:
                _compare(new, "seconds", "seconds_ratio", baseline)
        rows += new
    return Section(
        "cost",
        "What shaders cost",
        [
            *NOTES,
            *([LOOPS] if files else []),
            *([f"Times are per call of eval on {device}."] if device else []),
            *([NO_GPU] if "llvmpipe" in device else []),
        ],
        _columns(gpus, None if against is None else against[0], bool(device)),
        rows,
    )


def _cells(gpu: Gpu, numbers: Measured | None) -> dict[str, Value]:
    if numbers is None:
        return {}
    return {
        f"{gpu.name}_instructions": numbers.instructions,
        f"{gpu.name}_registers": numbers.registers,
        f"{gpu.name}_cycles": numbers.cycles,
        f"{gpu.name}_latency": numbers.latency,
        f"{gpu.name}_price": numbers.price,
    }


def _compare(rows: Sequence[dict[str, Value]], key: str, ratio: str, baseline: int) -> None:
    """Give each row its ratio to one of them."""
    base = rows[baseline].get(key)
    for row in rows:
        value = row.get(key)
        if isinstance(value, (int, float)) and isinstance(base, (int, float)) and base:
            row[ratio] = value / base


def _times(rows: Sequence[dict[str, Value]], models: Mapping[str, Model], rounds: int) -> str:
    """Fill in seconds of `eval` of each model, and return what ran it."""
    device = ""
    for row, (name, model) in zip(rows, models.items(), strict=False):
        shader = export({name: model}, "glsl", only=["eval"])[0]
        check_unread(shader.buffer, "this program")
        seconds, device = shader_times.eval_times(model, [shader], rounds)
        row["seconds"] = seconds[0]
    return device


def _columns(gpus: Sequence[Gpu], against: str | None, timed: bool) -> list[Column]:
    columns = [Column("row", "function")]
    for gpu in gpus:
        if gpu.vendor == "amd":
            columns.append(Column(f"{gpu.name}_cycles", f"{gpu.name} cycles"))
        columns.append(Column(f"{gpu.name}_instructions", f"{gpu.name} instructions"))
        columns.append(Column(f"{gpu.name}_registers", "registers"))
        if against is not None:
            columns.append(Column(f"{gpu.name}_ratio", f"× {against}", _two))
    if timed:
        columns.append(Column("seconds", "ns", _nanoseconds))
        if against is not None:
            columns.append(Column("seconds_ratio", f"× {against}", _two))
    return columns


_two = partial("{:.2f}".format)


def _nanoseconds(seconds: float) -> str:
    return f"{1e9 * seconds:.2f}"
