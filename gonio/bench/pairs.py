"""Models on arrays of directions: gonio's kernels beside the C++ baseline, and NumPy beside both."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import drjit as dr
import numpy as np

import gonio
from gonio.bench import native
from gonio.bench.exported_loop import ExportedLoop, exported_loops
from gonio.bench.kernels import (
    changed_copies,
    exact_operations,
    launched,
    moved_bytes,
    needed_again,
)
from gonio.bench.native import Baseline, Directions, Floats
from gonio.bench.report import (
    BenchError,
    Column,
    Section,
    Value,
    goal_text,
    milliseconds,
    percent,
    ratio,
)
from gonio.bench.timing import SHORT_CALLS, Side, alternate, stopwatch
from gonio.export import export
from gonio.fields import Option
from gonio.model import Model

Progress = Callable[[str], None]

# How many times faster than the loop of calls a trial of the same formulas was, on two cores.
EVAL_GOALS = {"eon_fitted": 7.5, "eon_exact": 14.0, "oren_nayar": 35.0}
SAMPLE_GOALS = {"eon_exact": 11.0}

# What is asked of the models of many terms, evaluated and sampled.
COMPLETE_GOALS = {
    "torrance_sparrow": 8.0,
    "disney": 8.0,
    "weidlich_wilkie": 8.0,
    "weidlich_wilkie_two_coats": 8.0,
}

# Time with NumPy arrays in and out, as a multiple of the time with Dr.Jit arrays.
NUMPY_GOAL = 4.0

# Against the model's own C++ export, unless memory allows less.
EXPORT_GOAL = 1.3

# Both sides are float32, and the baseline takes the papers' formulas as they are printed: their
# differences of nearly equal numbers lose up to 5e-4 where directions graze. A wrong formula, or a
# parameter in another unit, is off by more than 1e-2.
TOLERANCE = 1e-3

# Values below this share of the mean are compared with that share: some are differences near zero.
SMALL = 1e-2

# Share of the pairs that may differ by more: where a masking term ends near the horizon, roundings of the
# parameters alone change the value by percents (sgd, one pair of 70,000). Another formula differs in more.
RARE = 1e-4

DISTRIBUTION = (
    "Directions are random: cosine uniform in (0, 1], azimuth uniform, wi and wo independent "
    "(seed 1), so all of them lie above the horizon."
)


@dataclass(frozen=True)
class Pairs:
    """The same random input as NumPy arrays, for C++, and as Dr.Jit arrays."""

    wi: Directions
    wo: Directions
    u: tuple[Floats, Floats]
    jit_wi: Any
    jit_wo: Any
    jit_u: Any

    @property
    def count(self) -> int:
        """How many pairs."""
        return len(self.wi[0])


def random_pairs(count: int) -> Pairs:
    """Directions uniform over the hemisphere (cosine in (0, 1]), and random numbers in [0, 1)."""
    random = np.random.default_rng(1)

    def directions() -> Directions:
        mu, phi = 1 - random.random(count), 2 * np.pi * random.random(count)
        sine = np.sqrt(1 - mu * mu)
        return _float32(sine * np.cos(phi)), _float32(sine * np.sin(phi)), _float32(mu)

    wi, wo = directions(), directions()
    u = (random.random(count, np.float32), random.random(count, np.float32))
    Array2f, Array3f = dr.llvm.ad.Array2f, dr.llvm.ad.Array3f
    jit = (_resident(Array3f, wi), _resident(Array3f, wo), _resident(Array2f, u))
    return Pairs(wi, wo, u, *jit)


def _float32(values: Any) -> Floats:
    return np.asarray(values, np.float32)


def _resident(Vector: Any, components: Sequence[Floats]) -> Any:
    """A copy in memory of Dr.Jit's own, aligned as it likes it."""
    Float = dr.value_t(Vector)
    vector = Vector(*(Float(c) + dr.opaque(Float, 0) for c in components))
    dr.eval(vector)
    return vector


@dataclass(frozen=True)
class Entry:
    """A model of the registry, and the row of the baseline that computes the same."""

    label: str
    model: Model
    in_baseline: bool

    @cached_property
    def parameters(self) -> tuple[float, ...]:
        """The numbers that `eval` reads, as the baseline takes them: in order, three for a colour."""
        made = export({"x": self.model}, "cpp", only=["eval"])[0]
        values = {path: value for path, _, value in self.model.parameters()}
        numbers: list[float] = []
        for member in made.entry.members:
            value = values[member.path]
            numbers.extend(value if isinstance(value, tuple) else (value,) * member.width)
        return tuple(numbers)


# A word in a row's name for a model inside the model, and what that is.
INNER = {"two_coats": {"base": "weidlich_wilkie"}}


def entries(names: Sequence[str]) -> Iterator[Entry]:
    """Every registered model with its defaults; names: the rows of the baseline.

    A row carries the model's name; or the name and the value of one of its options (`eon_fitted`), which
    takes the place of the default; or the name and a word of INNER, which comes beside it. A model
    without a row comes once, alone.
    """
    for name, cls in gonio.models().items():
        variants = {
            f"{name}_{value}": {option: value}
            for option, declared in cls.fields.items()
            if isinstance(declared, Option)
            for value in declared.values
        }
        found = {label: options for label, options in variants.items() if label in names}
        stacks = {f"{name}_{word}": given for word, given in INNER.items()}
        inner = {label: given for label, given in stacks.items() if label in names}
        for label, given in ((found or {name: {}}) | inner).items():
            yield Entry(label, cls(**given), label in names)


def finished(*results: Any) -> tuple[Any, ...]:
    """Compute the results, and wait until they are there."""
    dr.eval(*results)
    dr.sync_thread()
    return results


def difference(ours: Floats, theirs: Floats) -> float:
    """Largest relative difference but for a `RARE` share; infinite if anything is NaN or infinite."""
    if not (np.isfinite(ours).all() and np.isfinite(theirs).all()):
        return float("inf")
    worst = 0.0
    for a, b in zip(np.atleast_2d(ours), np.atleast_2d(theirs), strict=True):
        scale = np.maximum(np.abs(b), SMALL * np.mean(np.abs(b), dtype=np.float64))
        apart = np.abs(a - b)
        # Where both are zero everywhere there is nothing to divide by.
        relative = np.divide(apart, scale, out=np.zeros_like(scale), where=apart > 0)
        if len(relative):
            worst = max(worst, float(np.quantile(relative, 1 - RARE, method="higher")))
    return worst


def _agree(
    label: str, quantity: str, ours: Floats, theirs: Floats, whose: str = "the C++ baseline's"
) -> float:
    found = difference(ours, theirs)
    if not found <= TOLERANCE:
        raise BenchError(
            f"{label}: gonio's {quantity} and {whose} differ by {found:.2g} (relative), "
            f"allowed is {TOLERANCE:g}: times of different results cannot be compared."
        )
    return found


_EXPORTED = (
    Column("exact_operations", "quotients, roots"),
    Column("exported_seconds", "export, ms", milliseconds),
    Column("exported_ratio", "× export", ratio),
    Column("exported_goal", "goal (export)"),
)

_COLUMNS = (
    Column("row", "row"),
    Column("calls_seconds", "C++ calls, ms", milliseconds),
    Column("inlined_seconds", "C++ inlined, ms", milliseconds),
    Column("seconds", "gonio, ms", milliseconds),
    Column("seconds_per_pair", "ns/pair", lambda s: f"{1e9 * s:.2f}"),
    Column("calls_ratio", "× calls", ratio),
    Column("inlined_ratio", "× inlined", ratio),
    Column("goal", "goal (calls)"),
    Column("bytes_per_pair", "bytes/pair"),
    Column("bandwidth_share", "of bandwidth", percent),
    Column("difference", "difference, 99.99 %", lambda d: f"{d:.1e}"),
)

_PEER = (
    "Export: the model's own C++ export in a loop that g++ vectorises (-Ofast -march=native, on the same "
    "threads; gonio/bench/exported_loop.py shows how), the strongest peer of the arrays. -Ofast lets g++ "
    "make quotients and roots of estimates with 14 bits and a step of Newton's (vrcp14ps, vrsqrt14ps), and "
    "take exp and log of vectors that are off by up to four roundings (libmvec). Dr.Jit estimates "
    "reciprocals of roots alone; its quotients and other roots are exact, as many as the column before "
    "says, and take several times as long. Written with such reciprocals wherever they serve, "
    "torrance_sparrow's 28 became 13 and its kernel took about a tenth less time, which suggests that "
    "products, of which both sides do the same, bound rows of many terms: there the goal is out of reach. "
    "Memory allows: what × export would be if the arrays did nothing but read and write their bytes at "
    "100 % of the bandwidth; said where that is below the goal."
)

_HOW = (
    "C++ calls: one call through a pointer for each pair, as a renderer calls its BSDF; C++ inlined: "
    "the compiler sees loop and model together and may vectorise.",
    "× is the C++ time divided by gonio's, goals are what an earlier trial reached against the calls, "
    "and 8 for models of many terms.",
    "Bytes are what the kernel's own code reads and writes per pair; 100 % of the bandwidth is what "
    "the simplest Dr.Jit kernel (a + b x) over 36 bytes per pair reaches in the same rounds.",
)


def eval_section(
    baseline: Baseline, pairs: Pairs, memory: Side, repeat: int, only: Only, progress: Progress
) -> Section:
    """`eval` of every registered model, in turn with its row of the baseline."""
    rows = []
    for entry in entries(baseline.eval_names):
        if not only(entry):
            continue
        progress(f"eval {entry.label}")
        model = entry.model

        def work(model: Model = model) -> Any:
            return finished(model.eval(pairs.jit_wi, pairs.jit_wo))

        theirs = partial(_baseline_values, baseline, entry, pairs) if entry.in_baseline else None
        loop = exported_loops({entry.label: model})[entry.label]
        different = compare_values(entry, pairs, loop, theirs)
        row = _measure(
            entry.label,
            work,
            theirs,
            pairs.count,
            memory,
            repeat,
            EVAL_GOALS | COMPLETE_GOALS,
            partial(loop.eval, pairs.wi, pairs.wo, dr.thread_count()),
        )
        row["difference"] = different
        rows.append(row)
    title = f"eval of {_millions(pairs.count)} pairs of directions"
    return Section("eval", title, (*_HOW, _PEER), (*_COLUMNS, *_EXPORTED), rows)


def sample_section(
    baseline: Baseline, pairs: Pairs, memory: Side, repeat: int, only: Only, progress: Progress
) -> Section:
    """`sample`, its pdf and `eval` at the sampled direction, for the rows the baseline has."""
    rows = []
    for entry in entries(baseline.sample_names):
        if not entry.in_baseline or not only(entry):
            continue
        progress(f"sample {entry.label}")
        model = entry.model

        def work(model: Model = model) -> Any:
            wi, pdf = model.sample(pairs.jit_wo, pairs.jit_u)
            return finished(wi, pdf, model.eval(wi, pairs.jit_wo))

        theirs = partial(_baseline_samples, baseline, entry, pairs)
        different = compare_samples(entry, pairs, theirs())
        row = _measure(
            entry.label, work, theirs, pairs.count, memory, repeat, SAMPLE_GOALS | COMPLETE_GOALS
        )
        row["difference"] = different
        rows.append(row)
    title = f"sample + pdf + eval, {_millions(pairs.count)} times"
    note = (
        "pdf and value are compared at the directions that C++ sampled: the same density may map the "
        "same random numbers to other directions."
    )
    return Section("sample", title, [note], _COLUMNS, rows)


def _baseline_values(
    baseline: Baseline, entry: Entry, pairs: Pairs, *, inlined: bool = False
) -> native.Timed:
    return baseline.eval(
        entry.label,
        pairs.wi,
        pairs.wo,
        entry.parameters,
        threads=dr.thread_count(),
        repeat=1,
        inlined=inlined,
    )


def _baseline_samples(
    baseline: Baseline, entry: Entry, pairs: Pairs, *, inlined: bool = False
) -> native.TimedSamples:
    return baseline.sample_pdf_eval(
        entry.label,
        pairs.wo,
        *pairs.u,
        entry.parameters,
        threads=dr.thread_count(),
        repeat=1,
        inlined=inlined,
    )


def compare_values(
    entry: Entry, pairs: Pairs, loop: ExportedLoop, theirs: Callable[[], native.Timed] | None
) -> float | None:
    """How much the values of C++ differ from the model's at most; None without a row of the baseline.

    Raises:
        BenchError: they, or those of the export, differ by more than TOLERANCE.
    """
    (value,) = finished(entry.model.eval(pairs.jit_wi, pairs.jit_wo))
    ours = value.numpy()
    exported = loop.eval(pairs.wi, pairs.wo, dr.thread_count()).value
    _agree(entry.label, "value", ours, exported, "its C++ export's")
    return None if theirs is None else _agree(entry.label, "value", ours, theirs().value)


def compare_samples(entry: Entry, pairs: Pairs, samples: native.TimedSamples) -> float:
    """How much pdf and value of C++ differ at most from the model's, at the directions of its samples.

    Raises:
        BenchError: by more than TOLERANCE.
    """
    # Rounding may push a sample into the horizon, where gonio's guard returns zero.
    above = samples.wi[2] > 0
    wi = dr.llvm.ad.Array3f(*(np.ascontiguousarray(c[above]) for c in samples.wi))
    wo = dr.llvm.ad.Array3f(*(np.ascontiguousarray(c[above]) for c in pairs.wo))
    pdf, value = finished(entry.model.pdf(wi, wo), entry.model.eval(wi, wo))
    return max(
        _agree(entry.label, "pdf", pdf.numpy(), samples.pdf[above]),
        _agree(entry.label, "value", value.numpy(), samples.value[:, above]),
    )


def _measure(
    label: str,
    work: Callable[[], tuple[Any, ...]],
    theirs: Callable[..., native.Timed] | None,
    count: int,
    memory: Side,
    repeat: int,
    goals: Mapping[str, float],
    exported: Callable[[], native.Timed] | None = None,
) -> dict[str, Value]:
    sides = {"gonio": stopwatch(work, SHORT_CALLS), "memory": memory}
    if exported is not None:
        sides["exported"] = lambda: min(exported().seconds for _ in range(SHORT_CALLS))
    if theirs is not None:
        sides["calls"] = lambda: theirs(inlined=False).seconds
        sides["inlined"] = lambda: theirs(inlined=True).seconds
    work()  # the first call may also fill tables
    kernels = launched(work)
    if [kernel.size for kernel in kernels] != [count]:
        raise BenchError(
            f"{label}: expected one kernel over {count} pairs, Dr.Jit ran kernels over "
            f"{[kernel.size for kernel in kernels]}; time and bytes per pair would mean nothing."
        )
    seconds = alternate(sides, repeat)
    ours, moved = seconds["gonio"], moved_bytes(kernels[0])
    row: dict[str, Value] = {
        "row": label,
        "seconds": ours,
        "seconds_per_pair": ours / count,
        "bytes_per_pair": moved,
        "exact_operations": exact_operations(kernels[0]),
        "bandwidth_share": (moved / ours) / (STREAM_BYTES / seconds["memory"]),
    }
    for side in ("calls", "inlined", "exported"):
        if side in seconds:
            row[f"{side}_seconds"] = seconds[side]
            row[f"{side}_ratio"] = seconds[side] / ours
    if exported is not None:
        moving = moved * seconds["memory"] / STREAM_BYTES
        row["exported_goal"] = export_goal(seconds["exported"], ours, moving)
    if label in goals and "calls" in seconds:
        row["goal"] = goal_text(seconds["calls"] / ours, at_least=goals[label])
    return row


def export_goal(exported: float, ours: float, moving: float) -> str:
    """Whether the arrays are fast enough beside the C++ export, or what memory allows where that is less.

    moving: the seconds that the arrays' bytes take by themselves.
    """
    if exported / ours < EXPORT_GOAL and exported / moving < EXPORT_GOAL:
        return f"memory allows {exported / moving:.2f}"
    return goal_text(exported / ours, at_least=EXPORT_GOAL)


STREAM_BYTES = 36
"""Bytes that `stream` moves per pair: as many as an `eval` that reads wi and wo and writes a colour."""


def stream(pairs: int) -> Side:
    """A side that runs the simplest kernel, a + b x, over STREAM_BYTES per pair."""
    Float, floats = dr.llvm.Float, STREAM_BYTES // 12 * pairs
    x = dr.opaque(Float, 0.5)
    a, b = (dr.full(Float, v, floats) for v in (1.0, 2.0))
    dr.make_opaque(a, b)
    return stopwatch(lambda: finished(dr.fma(b, x, a)), SHORT_CALLS)


def numpy_section(count: int, repeat: int, progress: Progress) -> Section:
    """EON on NumPy arrays beside the same on Dr.Jit arrays."""
    progress("NumPy in and out")
    pairs = random_pairs(count)
    wi, wo = np.stack(pairs.wi, -1), np.stack(pairs.wo, -1)
    model = gonio.model("eon")

    def unchecked() -> Any:
        validating = gonio.backend.validating()
        gonio.use(validate=False)
        try:
            return model.eval(wi, wo)
        finally:
            gonio.use(validate=validating)

    # One call in turn: with several in a row, the arrays of the first kind would stay in the cache.
    sides = {
        "drjit": stopwatch(lambda: finished(model.eval(pairs.jit_wi, pairs.jit_wo))),
        "numpy": stopwatch(lambda: model.eval(wi, wo)),
        "unchecked": stopwatch(unchecked),
    }
    seconds = alternate(sides, repeat)
    names = {
        "drjit": "Dr.Jit arrays",
        "numpy": "NumPy arrays",
        "unchecked": "NumPy arrays, gonio.use(validate=False)",
    }
    rows: list[dict[str, Value]] = []
    for side, name in names.items():
        multiple = seconds[side] / seconds["drjit"]
        rows.append({"row": name, "seconds": seconds[side], "multiple": multiple})
    rows[1]["goal"] = goal_text(seconds["numpy"] / seconds["drjit"], at_most=NUMPY_GOAL)
    columns = (
        Column("row", "arrays"),
        Column("seconds", "ms", milliseconds),
        Column("multiple", "× Dr.Jit", ratio),
        Column("goal", "goal"),
    )
    note = (
        "EON with its defaults; float32 arrays of shape (n, 3) in and out, with the checks of length "
        "and range that a call makes, and without them."
    )
    return Section("numpy", f"NumPy, {_millions(count)} pairs", [note], columns, rows)


def kernel_rows(progress: Progress) -> list[dict[str, Value]]:
    """New kernels for another value of each parameter, of every model, on Dr.Jit and NumPy arrays."""
    progress("kernels of changed parameters")
    pairs = random_pairs(64)
    host = np.stack(pairs.wi, -1), np.stack(pairs.wo, -1)
    return [
        _changes("eval of every model, Dr.Jit arrays", pairs.jit_wi, pairs.jit_wo),
        _changes("eval of every model, NumPy arrays", *host),
    ]


def _changes(name: str, wi: Any, wo: Any) -> dict[str, Value]:
    changes = compiled = 0
    for cls in gonio.models().values():
        model = cls()
        for _, copy in changed_copies(model):
            changes += 1
            compiled += needed_again(
                partial(_evaluate, model, wi, wo), partial(_evaluate, copy, wi, wo)
            )
    return {"row": name, "changes": changes, "compiled": compiled}


def _evaluate(model: Model, wi: Any, wo: Any) -> None:
    dr.eval(model.eval(wi, wo))


Only = Callable[[Entry], bool]
"""Which entries to measure."""


def _millions(count: int) -> str:
    return f"{count / 1e6:g} million" if count >= 100_000 else f"{count:,}"
