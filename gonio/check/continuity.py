"""Continuity: looks for places where the function or its slope jumps, and says which they are.

wi moves along great circles; where the second difference stands out the step is made smaller and smaller.
At a kink second differences shrink like the step, in a smooth place like its square, at a jump not at all.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gonio.check.adversarial import places as random_places
from gonio.check.report import FAIL, KNOWN, PASS, Effort, Finding, Report
from gonio.check.subject import Array, Subject, directions, evaluate, known_kinks

# Length of a path in radians, and its points.
LENGTH, POINTS = 1.2, 193

# Places of a path that are looked at closely, and how: so many times, each time so much closer.
CANDIDATES, ZOOMS, CLOSER = 3, 5, 8
ZOOM_POINTS = 4 * CLOSER + 1

# When the step is divided by CLOSER, the second difference over the step stays the same at a kink, is
# divided by CLOSER where the function is smooth, and multiplied by it at a jump; so much may be missing,
# twice in a row.
# Lobes sharper than the last step, and roots, are neither.
STEADY, JUMPING = 0.7, 0.7 * CLOSER

# Jumps of the slope count from this on, per radian and relative to the highest value on the path.
VISIBLE = 0.02

# Jumps of the value count from this on, relative to the value; roundings in sharp lobes stay below.
JUMP = 1e-5

# A place is one of the known ones if it is this near to it.
NEAR = 3e-5

# One side is flat if its slope is this much smaller than the other's.
FLAT = 1e-3

# The lowest cosine of wi on a path.
LOW = 1e-3

DARK_RING = "dark ring at s = 0"


def check(subject: Subject, effort: Effort) -> Report:
    """Kinks and jumps, each named, against those that the model declares."""
    start = time.perf_counter()
    if subject.float32:  # float32 has too few digits for small steps
        return Report("continuity", subject.name, (), 0.0)
    found = find(subject, max(effort.population // 4, 64))
    known = known_kinks(subject)
    findings = []
    for kink in found:
        declared = kink.name in known
        text = "documented" if declared else "not declared: kinks=kink(...) in the model's claims"
        case = (kink.places, kink.wi, kink.wo)
        findings.append(
            Finding(
                kink.name,
                kink.size,
                KNOWN if declared else FAIL,
                f"{text}; slope jumps by this per radian, relative to the path's highest value",
                subject.tag(),
                subject.replay(*case),
                case,
            )
        )
    names = [kink.name for kink in found]
    for name in dict.fromkeys(known):
        if name not in names and subject.whole:
            text = "declared, but it is not found"
            findings.append(Finding(name, 0.0, FAIL, text, subject.tag()))
    if not findings:
        findings.append(Finding("kinks and jumps", 0.0, PASS, "smooth", subject.tag()))
    return Report("continuity", subject.name, tuple(findings), time.perf_counter() - start)


@dataclass(frozen=True)
class Found:
    """The worst kink of one name."""

    name: str
    size: float
    places: Array
    wi: Array
    wo: Array


def find(subject: Subject, paths: int) -> list[Found]:
    """All kinks and jumps that show on so many random paths, the worst of each name."""
    rng = np.random.default_rng(51)
    where = random_places(paths, len(subject.columns), 52)
    wo = directions(0.05 + 0.94 * rng.random(paths), 2 * np.pi * rng.random(paths))
    middle = directions(0.1 + 0.85 * rng.random(paths), 2 * np.pi * rng.random(paths))
    # A third of the paths lead through the mirror direction's surroundings
    mirror = wo * np.array([-1.0, -1.0, 1.0])
    middle = np.where((np.arange(paths) % 3 == 0)[:, None], mirror + 0.1 * middle, middle)
    middle /= np.linalg.norm(middle, axis=1, keepdims=True)
    across = np.cross(middle, rng.normal(size=(paths, 3)))
    across /= np.linalg.norm(across, axis=1, keepdims=True)

    step = LENGTH / (POINTS - 1)
    t = np.linspace(-LENGTH / 2, LENGTH / 2, POINTS)
    f = _along(subject, where, np.arange(paths), middle, across, wo, np.tile(t, (paths, 1)))
    second = _second(f)
    # What stands out from its surroundings
    padded = np.pad(second, ((0, 0), (3, 3)), mode="edge")
    around = np.median(np.stack([padded[:, k : k + second.shape[1]] for k in (0, 1, 5, 6)]), axis=0)
    highest = np.nan_to_num(np.abs(f), nan=0.0).max(axis=1)
    contrast = second / (around + 1e-9 * highest[:, None] + 1e-300)
    rows, columns = [], []
    for _ in range(CANDIDATES):
        best = contrast.argmax(axis=1)
        rows.append(np.arange(paths))
        columns.append(best)
        for shift in range(-3, 4):
            contrast[np.arange(paths), np.clip(best + shift, 0, contrast.shape[1] - 1)] = 0
    row, column = np.concatenate(rows), np.concatenate(columns)

    centre = t[column + 1]
    sizes: list[Array] = []
    values = f
    for _ in range(ZOOMS):
        half = 2 * step
        step = step / CLOSER
        local = centre[:, None] + np.linspace(-half, half, ZOOM_POINTS)
        values = _along(subject, where, row, middle, across, wo, local)
        second = _second(values)
        peak = second.argmax(axis=1)
        centre = local[np.arange(len(row)), peak + 1]
        sizes.append(second.max(axis=1) / step)
    return _named(subject, where, row, middle, across, wo, centre, step, sizes, values, highest)


def _along(
    subject: Subject,
    where: Array,
    row: NDArray[np.intp],
    middle: Array,
    across: Array,
    wo: Array,
    t: Array,
) -> Array:
    """Values (rows, points), the mean of the channels, on great circles; NaN near the horizon and below."""
    wi = _on_path(middle[row], across[row], t)
    each = t.shape[1]
    flat = wi.reshape(-1, 3)
    index = np.repeat(row, each).astype(np.uint32)
    f, _ = evaluate(subject, where, index, flat, wo[index])
    # Values end in the horizon, and some grow without bound before: nothing is to be found there
    f = np.where(flat[:, 2:] > LOW, f, np.nan)
    return np.asarray(f.mean(axis=1).reshape(len(row), each))


def _on_path(middle: Array, across: Array, t: Array) -> Array:
    t = t[..., None]
    return np.asarray(middle[:, None] * np.cos(t) + across[:, None] * np.sin(t))


def _second(f: Array) -> Array:
    """Absolute second differences; 0 where the path is below the horizon."""
    return np.nan_to_num(np.abs(f[:, 2:] - 2 * f[:, 1:-1] + f[:, :-2]), nan=0.0, posinf=0.0)


def _named(
    subject: Subject,
    where: Array,
    row: NDArray[np.intp],
    middle: Array,
    across: Array,
    wo: Array,
    centre: Array,
    step: float,
    sizes: list[Array],
    values: Array,
    highest: Array,
) -> list[Found]:
    """Those candidates that are kinks or jumps, the worst of each name."""
    level = highest[row] + 1e-12
    last = sizes[-1]
    growth = [b / np.maximum(a, 1e-300) for a, b in pairwise(sizes[-3:])]
    jumps = np.all([g > JUMPING for g in growth], axis=0) & (last * step > JUMP * level)
    steady = np.all([(g > STEADY) & (g < 1 / STEADY) for g in growth], axis=0)
    kinks = steady & (last > VISIBLE * level)
    wi = _on_path(middle[row], across[row], centre[:, None])[:, 0]
    v = wo[row]
    s = wi[:, 0] * v[:, 0] + wi[:, 1] * v[:, 1]
    near = {
        "s = 0": np.abs(s),
        "mu_i = mu_o": np.abs(wi[:, 2] - v[:, 2]),
        "wi.wo = 0": np.abs(s + wi[:, 2] * v[:, 2]),
        "a right angle to the mirror direction": np.abs(wi[:, 2] * v[:, 2] - s),
    }
    # Slopes on both sides of the kink, at the ends of the last look
    left = np.abs(values[:, 2] - values[:, 0]) / (2 * step)
    right = np.abs(values[:, -1] - values[:, -3]) / (2 * step)
    flat = np.minimum(left, right) < FLAT * np.maximum(left, right)
    found: dict[str, Found] = {}
    for k in np.flatnonzero(kinks | jumps):
        place = min(near, key=lambda name: float(near[name][k]))
        at = place if near[place][k] < NEAR else "another place"
        name = f"{'jump' if jumps[k] else 'kink'} at {at}"
        if name == "kink at s = 0" and flat[k]:
            name = DARK_RING
        size = float(last[k] * (step if jumps[k] else 1.0) / level[k])
        if name not in found or size > found[name].size:
            found[name] = Found(name, size, where[row[k]], wi[k], v[k])
    return [found[name] for name in sorted(found)]
