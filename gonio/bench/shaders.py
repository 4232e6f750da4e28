"""Exported shaders beside hand-written ones: length, accuracy and time; and two ways to compute acos.

The hand-written GLSL lies in gonio/bench/handwritten: eval of some models, made for this comparison with
the same parameters, the same signature and the same accuracy in mind.
"""

from __future__ import annotations

import re
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

import gonio
from gonio.bench import shader_times
from gonio.bench.report import Column, Section, Value
from gonio.bench.shader_times import Arc
from gonio.export import export
from gonio.export.entry import Export
from gonio.export.prove import judge, tools
from gonio.export.prove.opengl import run_glsl
from gonio.export.prove.rows import rows_for
from gonio.export.prove.tools import ProofError
from gonio.model import Model

FOLDER = Path(__file__).parent / "handwritten"

INSIDE = {"weidlich_wilkie": {"base": "weidlich_wilkie"}}
"""What is inside a model of the comparison, where that is not the default: one coat over another."""

ACCURACY_ROWS = 20_000

WELL_CONDITIONED = 1e-6
"""Rows count as well-conditioned where rounding the inputs changes the value by less than this."""

SMALL = 1e-3
"""Errors are relative to the value, or to this share of the median value where that is smaller."""


def subjects() -> dict[str, Model]:
    """The models that have a hand-written shader, by its name."""
    names = sorted(path.stem for path in FOLDER.glob("*.glsl"))
    return {name: gonio.model(name, **INSIDE.get(name, {})) for name in names}


def exported(name: str) -> Export:
    """`eval` of a subject as GLSL."""
    return export({name: subjects()[name]}, "glsl", only=["eval"])[0]


def handwritten(name: str) -> Export:
    """The hand-written shader of a subject, which defines the same names as the exported one."""
    return _written(name, FOLDER / f"{name}.glsl")


def plain(name: str) -> Export | None:
    """A hand-written shader of fewer digits, as engines have it, where there is one."""
    file = FOLDER / "plain" / f"{name}.glsl"
    return _written(name, file) if file.exists() else None


def _written(name: str, file: Path) -> Export:
    return replace(exported(name), source=file.read_text(encoding="utf-8"))


# --- length ----------------------------------------------------------------------------------------------

# Structure, and what has no counterpart in a machine's code: names of values, and the harness's reads.
SILENT = re.compile(
    r"Op(Function|FunctionParameter|FunctionEnd|Label|Variable|Return|Unreachable|SelectionMerge|LoopMerge"
    r"|Branch|Switch|Phi|CopyObject|CompositeConstruct|CompositeExtract|CompositeInsert|VectorShuffle)"
)
MEMORY = re.compile(r"Op(AccessChain|Load|Store)")

# Operations of these instructions, for vectors of n numbers: products, sums, a root, and a product each.
REDUCTIONS: Mapping[str, Callable[[int], int]] = {
    "OpDot": lambda n: 2 * n - 1,
    "Length": lambda n: 2 * n,
    "Normalize": lambda n: 3 * n,
}


@dataclass(frozen=True)
class Length:
    """How long an optimised shader is, less what its harness takes."""

    instructions: int
    """Of SPIR-V: arithmetic, comparisons, choices, conditional branches and calls of builtin functions."""
    operations: int
    """The same with every component of a vector counted, as GPUs compute them."""

    def __sub__(self, other: Length) -> Length:
        """What the other does not have."""
        return Length(self.instructions - other.instructions, self.operations - other.operations)


def length(shader: Export) -> Length:
    """Count what `eval` of a GLSL shader computes, after spirv-opt -O.

    Raises:
        ProofError: glslangValidator, spirv-opt or spirv-dis is missing, or the shader does not compile.
    """
    return _counted(_optimised(shader)) - _counted(_optimised(_constant(shader)))


def _constant(shader: Export) -> Export:
    """The shader with an `eval` that computes nothing."""
    entry = shader.entry
    source = shader.source.replace(f" {entry.prefix}_eval(", f" {entry.prefix}_replaced(")
    source += (
        f"\nvec3 {entry.prefix}_eval({entry.struct} params, vec3 wi, vec3 wo) {{\n"
        "    return vec3(0.0);\n}\n"
    )
    return replace(shader, source=source)


def _harness(shader: Export) -> str:
    """A compute shader whose rows are structs, so that reading them takes no arithmetic."""
    entry = shader.entry
    return (
        f"#version 450\n{shader.source}\n"
        "layout(local_size_x = 64) in;\n"
        f"struct Row {{ vec3 wi; vec3 wo; {entry.struct} params; }};\n"
        "layout(std430, binding = 0) readonly buffer Given { Row given[]; };\n"
        "layout(std430, binding = 1) writeonly buffer Made { vec3 made[]; };\n\n"
        "void main() {\n"
        "    uint row = gl_GlobalInvocationID.x;\n"
        f"    made[row] = {entry.prefix}_eval(given[row].params, given[row].wi, given[row].wo);\n}}\n"
    )


def _optimised(shader: Export) -> str:
    """The harness as SPIR-V in words."""
    validator = tools.program("glslangValidator", "compiles GLSL")
    optimiser = tools.program("spirv-opt", "optimises SPIR-V")
    text = _harness(shader)
    with tempfile.TemporaryDirectory(prefix="gonio-") as name:
        folder = Path(name)
        (folder / "shader.comp").write_text(text, encoding="utf-8")
        command = [validator, "-V", "-o", "shader.spv", "shader.comp"]
        tools.compile_with(command, folder, shader, text, r":(\d+):")
        words = tools.run([optimiser, "-O", "shader.spv", "-o", "short.spv"], folder)
        if words.returncode == 0:
            reader = Path(optimiser).with_name("spirv-dis")
            words = tools.run([str(reader), "--raw-id", "--no-color", "short.spv"], folder)
    if words.returncode != 0:
        raise ProofError(f"{shader.entry.prefix}: spirv-opt says: {words.stderr.strip()}")
    return words.stdout


def _counted(words: str) -> Length:
    """Instructions of the only function that is left."""
    widths: dict[str, int] = {}  # of types
    types: dict[str, str] = {}  # of values
    local: set[str] = set()
    instructions = operations = 0
    inside = False
    for line in words.splitlines():
        parsed = re.match(r"\s*(?:(%\w+) = )?(Op\w+)(.*)", line)
        if parsed is None:
            continue
        result, name, operands = parsed[1], parsed[2], parsed[3].split()
        if name == "OpTypeVector":
            widths[result] = int(operands[1])
        if result and operands:
            types[result] = operands[0]
        inside = inside or name == "OpFunction"
        if not inside:
            continue
        if name == "OpVariable":
            local.add(result)
        if MEMORY.fullmatch(name):
            # A variable of the shader that was not made a value is read and written
            if not local & set(operands):
                continue
        elif SILENT.fullmatch(name):
            continue
        instructions += 1
        builtin = operands[2] if name == "OpExtInst" else name
        if builtin in REDUCTIONS:
            operations += REDUCTIONS[builtin](widths.get(types[operands[-1]], 1))
        else:
            operations += widths.get(operands[0], 1) if result else 1
    return Length(instructions, operations)


# --- accuracy --------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Accuracy:
    """Relative errors of a shader on a GPU, or on what stands for one."""

    median: float
    high: float
    """Exceeded by one value in a thousand."""
    worst: float
    """In rows where the rounding of the inputs does not matter; see `WELL_CONDITIONED`."""


def accuracy(
    model: Model, shaders: Sequence[Export], count: int = ACCURACY_ROWS
) -> tuple[list[Accuracy], str]:
    """Compare shaders with the float64 model on the same random and adversarial rows.

    Returns:
        Per shader its errors, and the device that ran them.

    Raises:
        ProofError: a tool is missing, or a shader does not compile.
    """
    entry = shaders[0].entry
    rows = rows_for(model, entry.members, count)
    expected = judge.expect(model, entry, "eval", rows)
    ran = run_glsl(shaders, [rows] * len(shaders))
    value = expected.value
    scale = np.maximum(np.abs(value), SMALL * np.median(np.abs(value[value != 0])))
    well = expected.rounding / scale < WELL_CONDITIONED
    found = []
    for output in ran.outputs:
        if isinstance(output, ProofError):
            raise output
        error = np.where(np.isfinite(output), np.abs(output - value) / scale, np.inf)
        found.append(
            Accuracy(
                float(np.median(error)),
                float(np.quantile(error, 0.999, method="higher")),
                float(error[well].max()),
            )
        )
    return found, ran.device


# --- arc functions ---------------------------------------------------------------------------------------


def arcs() -> list[Arc]:
    """Arc cosine and sine: the builtin ones, and those of exported code."""
    both = export({"oren_nayar": gonio.model("oren_nayar")}, "glsl", only=["eval"])[0].source
    return [
        Arc("acos", "builtin", "acos(clamp(x, -1.0, 1.0))", ""),
        Arc("acos", "polynomial", "oren_nayar_safe_acos(x)", both),
        Arc("asin", "builtin", "asin(clamp(x, -1.0, 1.0))", ""),
        Arc("asin", "polynomial", "oren_nayar_safe_asin(x)", both),
    ]


def arguments(count: int, seed: int = 0) -> npt.NDArray[np.float32]:
    """Numbers in [-1, 1]: spread evenly, near 0, and near both ends."""
    rng = np.random.default_rng(seed)
    near = np.exp(rng.uniform(np.log(1e-7), 0, (3, count // 4)))
    parts = [rng.uniform(-1, 1, count - 3 * (count // 4)), near[0], 1 - near[1], near[2] - 1]
    return np.concatenate(parts).astype(np.float32)


# --- sections --------------------------------------------------------------------------------------------


def shader_sections(repeat: int, progress: Callable[[str], None]) -> list[Section]:
    """Tables of the exported and hand-written shaders, and of the arc functions.

    Raises:
        ProofError: a tool is missing; its one line says which, and how to install it.
    """
    return [shader_section(repeat, progress), arc_section(repeat, progress)]


def shader_section(repeat: int, progress: Callable[[str], None]) -> Section:
    """Length, accuracy and time of the exported shaders beside the hand-written ones."""
    rows: list[dict[str, Value]] = []
    device = ""
    for name, model in subjects().items():
        progress(f"shaders: {name}")
        pair = [exported(name), handwritten(name)]
        lengths = [length(shader) for shader in pair]
        errors, _ = accuracy(model, pair)
        times, device = shader_times.eval_times(model, pair, repeat)
        rows.append(
            {
                "row": name,
                "instructions": lengths[0].instructions,
                "instructions_by_hand": lengths[1].instructions,
                "operations": lengths[0].operations,
                "operations_by_hand": lengths[1].operations,
                "error": errors[0].high,
                "error_by_hand": errors[1].high,
                "worst": errors[0].worst,
                "worst_by_hand": errors[1].worst,
                "seconds": times[0],
                "seconds_by_hand": times[1],
                "time_ratio": times[0] / times[1],
            }
        )
    return Section(
        "shaders",
        "Exported shaders beside hand-written ones",
        [
            "eval as GLSL, exported and by hand (gonio/bench/handwritten).",
            "Instructions: what the SPIR-V of glslangValidator computes after spirv-opt -O, less the "
            "harness; a dot product or a square root is one.",
            "Operations: the same with every component of a vector counted.",
            "Errors are relative, against the float64 model on random and grazing directions: what one "
            "value in a thousand exceeds, and the worst where the rounding of the inputs does not matter.",
            f"Times are of {device}, per pair, reading and writing included.",
        ],
        (
            Column("row", "model"),
            Column("instructions", "instructions"),
            Column("instructions_by_hand", "by hand"),
            Column("operations", "operations"),
            Column("operations_by_hand", "by hand"),
            Column("error", "error, 99.9 %", "{:.1e}".format),
            Column("error_by_hand", "by hand", "{:.1e}".format),
            Column("worst", "worst", "{:.1e}".format),
            Column("worst_by_hand", "by hand", "{:.1e}".format),
            Column("seconds", "ns", _nanoseconds),
            Column("seconds_by_hand", "by hand", _nanoseconds),
            Column("time_ratio", "× by hand", "{:.2f}".format),
        ),
        rows,
    )


def arc_section(repeat: int, progress: Callable[[str], None]) -> Section:
    """Accuracy and time of builtin arc functions beside the polynomials of exported code."""
    progress("shaders: acos and asin")
    ways = arcs()
    x = arguments(1 << 16)
    found, device = shader_times.arc_values_and_times(ways, x, repeat)
    rows: list[dict[str, Value]] = []
    for arc, (value, seconds) in zip(ways, found, strict=True):
        exact = getattr(np, f"arc{arc.name[1:]}")(x.astype(np.float64))
        off = np.abs(value - exact)
        rows.append(
            {
                "row": arc.name,
                "way": arc.way,
                "absolute": float(off.max()),
                "relative": float((off[exact != 0] / np.abs(exact[exact != 0])).max()),
                "seconds": seconds,
            }
        )
    return Section(
        "arcs",
        "Arc functions in exported shaders",
        [
            "acos and asin of GLSL, and the polynomials that exported code has in their place "
            "(gonio/export/library.py), for 65,536 numbers in [-1, 1], many of them near 0 and the ends: "
            f"largest errors, and time per call, on {device}.",
        ],
        (
            Column("row", "function"),
            Column("way", "computed by"),
            Column("absolute", "absolute error", "{:.1e}".format),
            Column("relative", "relative error", "{:.1e}".format),
            Column("seconds", "ns", _nanoseconds),
        ),
        rows,
    )


def _nanoseconds(seconds: float) -> str:
    return f"{1e9 * seconds:.2f}"
