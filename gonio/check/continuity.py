"""Continuity: looks for parameters where the function or its slope jumps, and says which they are.

wi moves along great circles; where the second difference stands out the step is made smaller and smaller.
At a kink second differences shrink like the step, in a smooth place like its square, at a jump not at all.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gonio.check.adversarial import hard_parameters, special_parts
from gonio.check.kernels import evaluate_only
from gonio.check.report import FAIL, KNOWN, PASS, Effort, Finding, Report
from gonio.check.subject import Array, Subject, directions
from gonio.claims import Kink, Place, kink

# Length of a path in radians, and its points.
LENGTH, POINTS = 1.2, 193

# Places of a path that are looked at closely, and how: so many times, each time so much closer.
CANDIDATES, ZOOMS, CLOSER = 3, 7, 8
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

# A place that shows less than this part of both is not looked at more closely.
HALF = 0.5

# A place is one of the known ones if it is this near to it: the last look's step is 3e-9, and kinks are
# found to within one. Among a thousand paths kinks that lie elsewhere come as near as 1e-5 by chance.
NEAR = 4 * LENGTH / (POINTS - 1) / CLOSER**ZOOMS

# One side is flat if its slope is this much smaller than the other's.
FLAT = 1e-3

# The lowest cosine of wi on a path.
LOW = 1e-3

# With so many paths a declared kink has to show, if need be after so many further looks at as many others:
# half of the looks at car paint miss the flakes that are seen edge-on.
ENOUGH, LOOKS = 512, 16

# Walks along a parameter: how many for each effort's path, random steps of each, and how often a step
# that may hold a jump is cut into CLOSER.
WALKS, WALK_STEPS, WALK_ZOOMS = 4, 48, 14

# The change over the last step, relative to the highest value, that is a jump.
WALK_JUMP = 1e-4


def check(subject: Subject, effort: Effort) -> Report:
    """Kinks and jumps, each named, against those that the model declares."""
    start = time.perf_counter()
    if subject.float32:  # float32 has too few digits for small steps
        return Report("continuity", subject.name, (), 0.0)
    paths = max(effort.population // 4, 64)
    found = _look(subject, paths)
    known = subject.kinks()
    names = {entry.name for entry, _ in known}
    # A dark ring of a model inside is no longer flat when something is added
    names |= {kink(k.place).name for k, own in known if not own and k.kind == "dark ring"}
    findings = []
    for seen in found:
        declared = seen.kink.name in names
        spelled = f"{seen.kink.kind}(Place.{seen.kink.place.name})"
        if seen.kink.kind == "dark ring":
            spelled = "dark_ring()"
        text = "documented" if declared else f"not declared: kinks={spelled} in the model's claims"
        what = "value" if seen.kink.kind == "jump" else "slope"
        per = "" if what == "value" else " per radian"
        case = (seen.parameters, seen.wi, seen.wo)
        findings.append(
            Finding(
                seen.kink.name,
                seen.size,
                KNOWN if declared else FAIL,
                f"{text}; {what} jumps by this{per}, relative to the highest value{seen.where}",
                subject.tag(),
                subject.recheck("continuity", case, seen.free),
                case,
            )
        )
    # With further options than it was declared for it may be gone
    own = {entry.name for entry, here in known if here and subject.varied <= set(entry.options)}
    missing = own - {seen.kink.name for seen in found}
    if subject.whole and paths >= ENOUGH:
        for turn in range(1, LOOKS):
            missing -= (
                {seen.kink.name for seen in _look(subject, paths, turn)} if missing else set()
            )
        text = "declared, but it is not found"
        again = subject.recheck("continuity")
        findings += [
            Finding(name, 0.0, FAIL, text, subject.tag(), again) for name in sorted(missing)
        ]
    if not findings:
        findings.append(Finding("kinks and jumps", 0.0, PASS, "smooth", subject.tag()))
    return Report("continuity", subject.name, tuple(findings), time.perf_counter() - start)


@dataclass(frozen=True)
class Found:
    """The worst kink of one name."""

    kink: Kink
    size: float
    parameters: Array
    wi: Array
    wo: Array
    where: str = ""
    """In words."""
    free: frozenset[str] = frozenset()
    """The parameter along which it is seen."""


def _look(subject: Subject, paths: int, turn: int = 0) -> list[Found]:
    walks = max(paths // WALKS, 32)
    return [*find(subject, paths, turn), *find_in_parameters(subject, walks, turn)]


def find(subject: Subject, paths: int, turn: int = 0) -> list[Found]:
    """All kinks and jumps that show on so many random paths, the worst of each name; others each turn."""
    rng = np.random.default_rng(51 + 1000 * turn)
    where = hard_parameters(subject, paths, 52 + 1000 * turn)
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
        # Two neighbours together: how a kink lies between the points changes each, not the sum
        sizes.append((second[:, :-1] + second[:, 1:]).max(axis=1) / step)
        # Neither a slope nor a value can jump by more than what is seen from farther away
        level = HALF * highest[row]
        kept = ~((sizes[-1] < VISIBLE * level) & (sizes[-1] * step < JUMP * level))
        row, centre, values = row[kept], centre[kept], values[kept]
        sizes = [size[kept] for size in sizes]
        if not len(row):
            return []
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
    f = evaluate_only(subject, where, index, flat, wo[index])
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
    jumps = np.all([g > JUMPING for g in growth], axis=0) & (0.5 * last * step > JUMP * level)
    steady = np.all([(g > STEADY) & (g < 1 / STEADY) for g in growth], axis=0)
    kinks = steady & (last > VISIBLE * level)
    wi = _on_path(middle[row], across[row], centre[:, None])[:, 0]
    v = wo[row]
    s = wi[:, 0] * v[:, 0] + wi[:, 1] * v[:, 1]
    near = {
        Place.SIDE_LIGHT: np.abs(s),
        Place.EQUAL_COSINES: np.abs(wi[:, 2] - v[:, 2]),
        Place.RIGHT_ANGLE: np.abs(s + wi[:, 2] * v[:, 2]),
        Place.RIGHT_ANGLE_TO_MIRROR: np.abs(wi[:, 2] * v[:, 2] - s),
    }
    # Slopes on both sides of the kink, at the ends of the last look
    left = np.abs(values[:, 2] - values[:, 0]) / (2 * step)
    right = np.abs(values[:, -1] - values[:, -3]) / (2 * step)
    flat = np.minimum(left, right) < FLAT * np.maximum(left, right)
    found: dict[str, Found] = {}
    for k in np.flatnonzero(kinks | jumps):
        nearest = min(near, key=lambda place: float(near[place][k]))
        place = nearest if near[nearest][k] < NEAR else Place.ELSEWHERE
        kind = "jump" if jumps[k] else "kink"
        if (kind, place) == ("kink", Place.SIDE_LIGHT) and flat[k]:
            kind = "dark ring"
        name = Kink(place, kind)
        size = float(last[k] * (0.5 * step if jumps[k] else 1.0) / level[k])
        if name.name not in found or size > found[name.name].size:
            angle = np.degrees(np.arccos(np.clip(wi[k, 2], -1, 1)))
            turn = np.degrees(np.arctan2(wi[k, 1], wi[k, 0]) - np.arctan2(v[k, 1], v[k, 0])) % 360
            text = f"; where wi is at {angle:.5g} degrees, turned by {turn:.5g} from wo"
            found[name.name] = Found(name, size, where[row[k]], wi[k], v[k], text)
    return [found[name] for name in sorted(found)]


# --- along parameters ----------------------------------------------------------------------------


def find_in_parameters(subject: Subject, walks: int, turn: int = 0) -> list[Found]:
    """The largest jump of the value while one parameter changes, if there is one; as in `find`."""
    numbers = len(subject.parameters)
    if not numbers:
        return []
    rng = np.random.default_rng(53 + 1000 * turn)
    rows = hard_parameters(subject, walks, 54 + 1000 * turn)
    moved = np.arange(walks) % numbers
    wo = directions(0.05 + 0.9 * rng.random(walks), 2 * np.pi * rng.random(walks))
    wi = directions(0.05 + 0.9 * rng.random(walks), 2 * np.pi * rng.random(walks))
    # Half of them within a lobe
    near = wo * np.array([-1.0, -1.0, 1.0]) + 0.2 * wi
    near /= np.linalg.norm(near, axis=1, keepdims=True)
    wi = np.where((rng.random(walks) < 0.5)[:, None], near, wi)
    special = special_parts(subject)
    most = max(len(parts) for parts in special)
    # Random steps, and steps from just below to just above every special value; the ends themselves are
    # left out, where a model may be something else
    steps = (np.arange(WALK_STEPS) + rng.random((walks, WALK_STEPS))) / WALK_STEPS
    beside = np.stack([np.resize(special[n], most) for n in moved])
    steps = np.concatenate([steps, beside - 1e-9, beside, beside + 1e-9], axis=1)
    steps = np.sort(np.clip(steps, 1e-9, 1 - 1e-9), axis=1)
    f = _walked(subject, rows, moved, wi, wo, steps)
    level = np.nan_to_num(np.abs(f), nan=0.0).max(axis=(1, 2)) + 1e-12
    # A jump may be less than what the value changes by in a step anyway: of each walk the largest step is
    # looked at, and the one that stands out from its neighbours
    looks: list[tuple[Array, Array, Array]] = []
    for chosen in (_largest_step, _outstanding_step):
        low, high, change = chosen(steps, f)
        for _ in range(WALK_ZOOMS):
            inner = low[:, None] + (high - low)[:, None] * np.linspace(0, 1, CLOSER + 1)
            low, high, change = chosen(inner, _walked(subject, rows, moved, wi, wo, inner))
        looks.append((high, change, level))
    high, change, level = (np.concatenate(each) for each in zip(*looks, strict=True))
    sizes = change / level
    worst = int(np.argmax(np.nan_to_num(sizes, nan=0.0)))
    if not sizes[worst] > WALK_JUMP:
        return []
    best = worst % walks
    rows[best, moved[best]] = high[worst]
    free = subject.parameters[moved[best]]
    value = subject.values(rows[best][None])[free.path][0]
    text = f"; at {free.path} = {np.atleast_1d(value)[min(free.channel, np.size(value) - 1)]:.9g}"
    here = Kink(Place.IN_A_PARAMETER, "jump")
    along = frozenset({free.path})
    return [Found(here, float(sizes[worst]), rows[best], wi[best], wo[best], text, along)]


def _walked(
    subject: Subject, rows: Array, moved: NDArray[np.intp], wi: Array, wo: Array, steps: Array
) -> Array:
    """Values (walks, steps, 3) with one number of each row at the given parts of its range."""
    each = steps.shape[1]
    parameters = np.repeat(rows, each, axis=0)
    parameters[np.arange(len(parameters)), np.repeat(moved, each)] = steps.ravel()
    index = np.arange(len(parameters), dtype=np.uint32)
    f = evaluate_only(
        subject, parameters, index, np.repeat(wi, each, axis=0), np.repeat(wo, each, axis=0)
    )
    return np.asarray(f.reshape(len(rows), each, 3))


def _largest_step(steps: Array, f: Array) -> tuple[Array, Array, Array]:
    """Begin, end and size of the step with the largest change of any channel."""
    change = np.nan_to_num(np.abs(np.diff(f, axis=1)).max(axis=2), nan=0.0, posinf=0.0)
    best = change.argmax(axis=1)
    walk = np.arange(len(steps))
    return steps[walk, best], steps[walk, best + 1], change[walk, best]


def _outstanding_step(steps: Array, f: Array) -> tuple[Array, Array, Array]:
    """The same of the step whose change differs most from what the slopes beside it say."""
    width, change = np.diff(steps, axis=1), np.diff(f, axis=1)
    slope = change / np.where(width > 0, width, 1)[..., None]  # special values may fall together
    around = np.pad(slope, ((0, 0), (1, 1), (0, 0)), mode="reflect")
    # The neighbour that is more like it: beside a jump, only one of both is; at an end there is only one
    off = np.minimum(np.abs(slope - around[:, :-2]), np.abs(slope - around[:, 2:])).max(axis=2)
    best = np.nan_to_num(off * width, nan=0.0, posinf=0.0).argmax(axis=1)
    walk = np.arange(len(steps))
    size = np.nan_to_num(np.abs(change[walk, best]).max(axis=1), nan=0.0, posinf=0.0)
    return steps[walk, best], steps[walk, best + 1], size
