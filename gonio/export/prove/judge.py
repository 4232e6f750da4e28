"""Compares what an export computed with the float64 model, within a tolerance that says why.

The tolerance of a row is made of two things that have reasons. How much rounding matters there: the model
itself is computed in float32 and in float64 at the row and at neighbours whose inputs differ in the last
bit; what that changes is unavoidable for float32. And how exact the device's arithmetic is, compared to
correctly rounded operations: a constant per device, measured on it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from gonio.export import library
from gonio.export.entry import Entry
from gonio.export.prove.harness import GIVEN
from gonio.export.prove.lit import shaded
from gonio.export.prove.rows import LAST_RANDOM, clipped, with_parameters
from gonio.export.prove.tools import Rows
from gonio.lang import MU_MIN
from gonio.model import Model

Array = npt.NDArray[np.float64]

ULP = 2.0**-24
"""Relative rounding error of one float32 operation."""

NEIGHBOURS = 4
"""How many rows with inputs that differ in the last bit show how much rounding matters."""

CLOSER = 64
"""How many of them a row gets that seems to be off: near a kink only few of them are on its other side."""

CLOSER_REACH = 2
"""Units in the last place by which those move: devices round products and quotients by more than one."""


NOTHING = 1e-300
"""Stands for no tolerance at all, which cannot be divided by."""

CLOSE_LOOKS = 0.02
"""Share of the rows that may get a closer look (and ten always may); more are not near a kink by chance."""


@dataclass(frozen=True)
class Device:
    """How exact a runtime computes, and why."""

    factor: float
    """How many times the model's own rounding is allowed."""
    relative: float
    """Relative error that one function may add to any result."""
    logarithm: float
    """Absolute error of its logarithm near 1. What is made from log(1 - u), such as Beckmann's slopes,
    comes out as if u were off by as much."""
    weights: float
    """Relative error of a mean of samples' weights. Drivers may take the normal that a sample was mirrored
    at for the half vector of eval and not for that of pdf, or the other way round: they simplify
    (a - b) + b. The weights of the sharpest lobes scatter by 1 % then."""
    reason: str


NATIVE = Device(
    8,
    8 * ULP,
    0,
    0,
    "the processor's arithmetic and libm round correctly to 1 unit in the last place",
)
# Its logarithm is 20 times less exact than correct rounding, and models chain several such functions.
LLVMPIPE = Device(
    48,
    2e-6,
    2e-6,
    5e-4,
    "llvmpipe's exp is off by 6e-7, pow by 6e-7 (1 + |log|), log by 1.2e-6 near 1",
)
CYCLES = Device(
    64, 5e-5, 2e-6, 0, "OSL's exp and pow are polynomials, off by 1.4e-5; its log by 1.1e-6 near 1"
)

DEVICES = {
    "glsl": LLVMPIPE,
    "spirv": LLVMPIPE,
    "essl": LLVMPIPE,
    "wgsl": LLVMPIPE,
    "osl": CYCLES,
    "hlsl": NATIVE,
    "msl": NATIVE,
    "slang": NATIVE,
    "cpp": NATIVE,
    "cuda": NATIVE,
}


def device_for(language: str, name: str) -> Device:
    """What is known of the device that ran a language; graphics drivers were measured on llvmpipe."""
    device = DEVICES[language]
    if device is LLVMPIPE and "llvmpipe" not in name:
        return replace(device, reason=f"{device.reason}; not measured on {name}")
    return device


UNIT = 1e-5
"""Allowed deviation of a sampled direction's length from 1, a hundred float32 roundings."""

FLIPS = 1e-3
"""Share of the samples that may choose another lobe than the model does: random numbers within rounding
of a threshold. Such samples still have to have the density that the model gives them."""


@dataclass(frozen=True)
class Expected:
    """The float64 model on some rows, and how much float32 rounding changes it."""

    value: Array
    rounding: Array


def arguments(function: str, rows: Rows, dtype: Any) -> tuple[Any, ...]:
    """The directions and random numbers that a function takes."""
    wi, wo, u = (rows[:, a:b].astype(dtype) for a, b in ((0, 3), (3, 6), (6, 8)))
    return {"eval": (wi, wo), "pdf": (wi, wo), "sample": (wo, u), "albedo": (wo,)}[function]


def evaluate(model: Model, entry: Entry, function: str, rows: Rows, dtype: Any) -> Array:
    """What the model computes for the rows, shape (N, width), in a precision."""
    if function == "sampled albedo":
        return _sampled_albedo(model, entry, rows, dtype)
    if function == "shade":
        return np.asarray(shaded(model, entry, entry.lights, rows, dtype), np.float64)
    made = getattr(with_parameters(model, entry.members, rows, dtype), function)(
        *arguments(function, rows, dtype)
    )
    if function == "sample":
        made = np.concatenate([made.wi, made.pdf[:, None]], 1)
    return np.asarray(made, np.float64).reshape(len(rows), -1)


def _sampled_albedo(model: Model, entry: Entry, rows: Rows, dtype: Any) -> Array:
    """The rule by which exports find albedos without a closed form, one sample per row."""
    steps = np.arange(library.ALBEDO_SAMPLES, dtype=np.float32) + np.float32(0.5)
    u = np.stack(
        [steps / np.float32(len(steps)), np.modf(steps * np.float32(library.GOLDEN))[0]], -1
    )
    every = np.repeat(rows, len(steps), axis=0)
    every[every[:, 5] < 0, 3:6] = 0, 0, 1  # not used
    every[:, 5] = np.maximum(every[:, 5], np.float32(library.HORIZON))
    every[:, 6:8] = np.tile(u, (len(rows), 1))
    drawn = evaluate(model, entry, "sample", every, dtype)
    f = with_parameters(model, entry.members, every, dtype).eval(
        drawn[:, :3].astype(dtype), every[:, 3:6].astype(dtype)
    )
    density = drawn[:, 3]
    weight = np.where(density > 0, drawn[:, 2] / np.where(density > 0, density, 1), 0)
    total = (np.asarray(f, np.float64) * weight[:, None]).reshape(len(rows), len(steps), -1)
    return np.asarray(np.where(rows[:, 5:6] >= 0, total.mean(1), 0))


def albedo_rule_errors(model: Model, entry: Entry, rows: Rows, expected: Expected) -> Array:
    """By how much that rule differs from the integral, in each row."""
    exact = evaluate(model, entry, "albedo", rows, np.float64)
    return np.asarray(np.abs(expected.value - exact).max(-1))


def neighbour(
    model: Model, entry: Entry, rows: Rows, seed: int, *, reach: int = 1, shift: float = 0
) -> Rows:
    """The rows with every input moved by up to `reach` units in the last place, up, down or not at all.

    Random numbers move by up to `shift` besides.
    """
    rng = np.random.default_rng(seed)
    way = rng.integers(-reach, reach + 1, rows.shape)
    moved = rows
    for step in range(reach):
        moved = np.where(way > step, np.nextafter(moved, np.float32(np.inf)), moved)
        moved = np.where(way < -step, np.nextafter(moved, np.float32(-np.inf)), moved)
    moved = np.where(rows == 0, rows, moved).astype(np.float32)
    moved[:, 6:8] += rng.uniform(-shift, shift, (len(rows), 2)).astype(np.float32)
    moved[:, 6:8] = np.clip(moved[:, 6:8], 0, LAST_RANDOM)
    declared = {path: parameter for path, parameter, _ in model.parameters()}
    column = GIVEN
    for member in entry.members:
        columns = slice(column, column + member.width)
        moved[:, columns] = clipped(declared[member.path], moved[:, columns])
        column += member.width
    return moved


def expect(model: Model, entry: Entry, function: str, rows: Rows) -> Expected:
    """The float64 model, and by how much the last bits of inputs and operations change it."""
    moved = [neighbour(model, entry, rows, seed) for seed in range(NEIGHBOURS)]
    return _around(model, entry, function, rows, moved)


def _look_closer(model: Model, entry: Entry, function: str, rows: Rows, device: Device) -> Expected:
    """The same from more and farther neighbours, for rows that seem to be off."""
    moved = [
        neighbour(model, entry, rows, seed, reach=CLOSER_REACH, shift=device.logarithm)
        for seed in range(CLOSER)
    ]
    return _around(model, entry, function, rows, moved)


def _around(
    model: Model, entry: Entry, function: str, rows: Rows, moved: Sequence[Rows]
) -> Expected:
    around = np.concatenate([rows, *moved])
    shape = (1 + len(moved), len(rows), -1)
    exact = evaluate(model, entry, function, around, np.float64)
    single = evaluate(model, entry, function, around, np.float32)
    own = np.abs(single - exact).reshape(shape).max(0)
    exact = exact.reshape(shape)
    spread = np.abs(exact[1:] - exact[0]).max(0)
    return Expected(exact[0], own + spread)


@dataclass(frozen=True)
class Verdict:
    """How one function of an export compares with the model."""

    rows: int
    error: float
    """Relative error in the row that is nearest to its tolerance, or farthest beyond."""
    tolerance: float
    """Relative tolerance in that row."""
    median: float
    """Relative error of the median row."""
    worst: int
    """Number of that row."""
    got: tuple[float, ...]
    expected: tuple[float, ...]
    failure: str
    """What is wrong, empty if nothing is."""
    note: str = ""


def judge(
    model: Model,
    entry: Entry,
    function: str,
    rows: Rows,
    got: Rows,
    device: Device,
    expected: Expected,
) -> Verdict:
    """Compare the outputs of one function with the model.

    Args:
        model: with its options; its parameters come from the rows.
        entry: of the export.
        function: "eval", "sample", "pdf", "albedo", or "sampled albedo" for the sum that exports of models
            without a closed form have.
        rows: of inputs.
        got: what the export computed for them.
        device: what computed it.
        expected: what `expect` says of these rows.
    """
    if function == "sample":
        return _judge_sample(model, entry, rows, got.astype(np.float64), device, expected)
    return _judge_values(model, entry, function, rows, got.astype(np.float64), device, expected)


# Below this cosine of wo one sample of a thousand may hold most of a sampled albedo, with a density that
# the last digits of a device's exp decide: such sums have to be finite, and are not compared one by one.
GRAZING_SUM = 1e-4


def _judge_values(
    model: Model,
    entry: Entry,
    function: str,
    rows: Rows,
    got: Array,
    device: Device,
    expected: Expected,
) -> Verdict:
    summing = 0.0
    if function == "sampled albedo":
        # Many numbers added one after the other round as many times
        summing = library.ALBEDO_SAMPLES * ULP + device.weights
    value = expected.value
    size = np.abs(value)
    typical = float(np.median(size[size > 0])) if (size > 0).any() else 1.0
    # A thousandth of the usual size is the smallest that relative errors are measured against
    scale = np.maximum(size, 1e-3 * typical)

    # Below the horizon everything is exactly 0
    lower = np.minimum(rows[:, 2], rows[:, 5])
    below = lower <= MU_MIN if function in {"eval", "pdf"} else rows[:, 5] < 0
    if function == "shade":  # where the horizon is, the frame's last digits decide
        below = np.zeros(len(rows), bool)

    def allowed(rounding: Array, chosen: Any) -> Array:
        usual = device.factor * rounding + (device.relative + summing) * scale[chosen]
        return np.where(below[chosen, None], NOTHING, usual)

    off = np.abs(got - value)
    limit = allowed(expected.rounding, slice(None))
    if function == "sampled albedo":
        limit[(rows[:, 5] > 0) & (rows[:, 5] < GRAZING_SUM)] = np.inf
    beyond = np.nonzero(~(off <= limit).all(-1))[0]
    if 0 < len(beyond) <= max(CLOSE_LOOKS * len(rows), 10):
        closer = _look_closer(model, entry, function, rows[beyond], device)
        limit[beyond] = np.maximum(limit[beyond], allowed(closer.rounding, beyond))
        beyond = beyond[~(off[beyond] <= limit[beyond]).all(-1)]
    strain = np.where(np.isfinite(got), off / limit, np.inf)
    place = np.unravel_index(int(np.argmax(strain)), strain.shape)
    worst = int(place[0])
    wild = int((~np.isfinite(got)).any(-1).sum())
    failure = f"off in {len(beyond)} of {len(rows)} rows" if len(beyond) else ""
    return Verdict(
        rows=len(rows),
        error=float(off[place] / scale[place]),
        tolerance=float(limit[place] / scale[place]),
        median=float(np.median(off / scale)),
        worst=worst,
        got=tuple(got[worst].tolist()),
        expected=tuple(value[worst].tolist()),
        failure=f"not finite in {wild} of {len(rows)} rows" if wild else failure,
    )


def _judge_sample(
    model: Model, entry: Entry, rows: Rows, got: Array, device: Device, expected: Expected
) -> Verdict:
    """Directions, and the densities that come with them.

    A density is compared with the model's at the returned direction, so that a sample that fell on the
    other side of a threshold is not compared with the one it would have been.
    """
    wi = got[:, :3]
    wild = ~np.isfinite(got).all(-1)
    length = np.where(wild, 1, np.linalg.norm(wi, axis=-1))
    crooked = np.abs(length - 1) > UNIT
    off = np.linalg.norm(wi - expected.value[:, :3], axis=-1)
    limit = device.factor * np.linalg.norm(expected.rounding[:, :3], axis=-1) + device.relative
    # Where a sample is wasted anyway, its direction does not matter
    off = np.where((got[:, 3] == 0) & (expected.value[:, 3] == 0), 0, off)
    beyond = np.nonzero(~(off <= limit))[0]
    if 0 < len(beyond) <= max(CLOSE_LOOKS * len(rows), 10):
        closer = _look_closer(model, entry, "sample", rows[beyond], device).rounding[:, :3]
        limit[beyond] = np.maximum(
            limit[beyond], device.factor * np.linalg.norm(closer, axis=-1) + device.relative
        )
    strain = np.where(wild, np.inf, off / limit)
    flips = int((strain > 1).sum())
    failure, worst = "", int(np.argmax(np.where(strain > 1, 0, strain)))
    if wild.any():
        failure, worst = f"not finite in {wild.sum()} of {len(rows)} rows", int(np.argmax(wild))
    elif crooked.any():
        failure, worst = f"no unit vector in {crooked.sum()} rows", int(np.argmax(crooked))
    elif flips > FLIPS * len(rows):
        failure = f"other directions in {flips} of {len(rows)} rows"
        worst = int(np.argmax(strain))
    note = f"{flips} of {len(rows)} samples chose another lobe" if flips else ""
    direction = Verdict(
        rows=len(rows),
        error=float(off[worst]),
        tolerance=float(limit[worst]),
        median=float(np.median(off)),
        worst=worst,
        got=tuple(got[worst].tolist()),
        expected=tuple(expected.value[worst].tolist()),
        failure=failure,
        note=note,
    )
    if failure:
        return direction
    there = rows.copy()
    there[:, :3] = wi
    density = _judge_values(
        model, entry, "pdf", there, got[:, 3:], device, expect(model, entry, "pdf", there)
    )
    if density.failure or density.error / density.tolerance > strain[worst]:
        failure = density.failure and f"density {density.failure}"
        return replace(density, note=note, failure=failure)
    return direction
