"""What a model can be: every option, and its parameters over their whole range, from its declarations.

Searches vary parameters in [0, 1]; `value_at` says which value that is.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gonio.fields import ModelError, Option, Parameter
from gonio.model import Model

# Parts of a parameter's range: the ends, just inside them, and between.
PARTS = (0.0, 1e-7, 1e-3, 0.1, 0.5, 0.9, 1.0)

# Ranges that span more than this factor above 1 are walked by powers of ten.
WIDE = 100.0

# Where a range has no end, this much of it is walked.
ENDLESS = 1e6


def is_wide(declared: Parameter) -> bool:
    """Whether a range is walked by powers of ten."""
    return declared.high - declared.low > WIDE


def value_at(declared: Parameter, t: Any) -> Any:
    """The value at a part t in [0, 1] of a parameter's range; arrays work as well."""
    high = min(declared.high, declared.low + ENDLESS)
    if is_wide(declared):
        wide = declared.low + np.expm1(t * np.log1p(high - declared.low))
        return np.minimum(wide, high)  # the round trip may end a bit above
    return declared.low + (high - declared.low) * t


def part_of(declared: Parameter, value: Any) -> Any:
    """The part in [0, 1] of a value: the inverse of `value_at`."""
    high = min(declared.high, declared.low + ENDLESS)
    if is_wide(declared):
        t = np.log1p(np.asarray(value) - declared.low) / np.log1p(high - declared.low)
    else:
        t = (np.asarray(value) - declared.low) / (high - declared.low)
    return np.clip(t, 0, 1)


def options(cls: type[Model]) -> list[dict[str, str]]:
    """Every choice of every option, one at a time, starting with the defaults."""
    found: list[dict[str, str]] = [{}]
    for name, declared in cls.fields.items():
        if isinstance(declared, Option):
            found += [{name: value} for value in declared.values[1:]]
    return found


def pairs(cls: type[Model]) -> list[dict[str, str]]:
    """Choices in which every two choices of two options meet at least once: a covering array.

    Combinations that the model refuses are left out, and so are the pairs that `options` has.
    """
    declared = {n: d for n, d in cls.fields.items() if isinstance(d, Option)}
    todo = {
        ((a, x), (b, y))
        for (a, one), (b, other) in itertools.combinations(declared.items(), 2)
        for x, y in itertools.product(one.values[1:], other.values[1:])
    }
    found: list[dict[str, str]] = []
    for pair in sorted(todo):
        if pair not in todo:
            continue
        row = dict(pair)
        if not _accepts(cls, row):
            todo.discard(pair)
            continue
        for name, option in declared.items():
            if name in row:
                continue
            # The choice that meets the most of what has not met yet
            gain = {v: len(_met(row | {name: v}) & todo) for v in option.values}
            for value in sorted(option.values, key=lambda v: -gain[v]):
                if value == option.default or _accepts(cls, row | {name: value}):
                    row[name] = value
                    break
        row = {n: v for n, v in row.items() if v != declared[n].default}
        todo -= _met(row)
        found.append(row)
    return found


def _met(row: Mapping[str, str]) -> set[tuple[tuple[str, str], tuple[str, str]]]:
    return {(a, b) for a in row.items() for b in row.items() if a != b}


def _accepts(cls: type[Model], choice: Mapping[str, str]) -> bool:
    try:
        cls(**choice)
    except ModelError:
        return False
    return True


def chosen(cls: type[Model], choice: Mapping[str, str]) -> dict[str, str]:
    """The value of every option: the given ones and the defaults of the others."""
    return {n: d.default for n, d in cls.fields.items() if isinstance(d, Option)} | dict(choice)


def sweep(cls: type[Model]) -> list[dict[str, Any]]:
    """Each number in turn at each of PARTS, the others in the middle; colours white and tinted."""
    found: list[dict[str, Any]] = []
    numbers = [p for p in cls.fields.values() if isinstance(p, Parameter)]
    for varied in numbers:
        for t in PARTS:
            found.append({p.name: value_at(p, t if p is varied else 0.5) for p in numbers})
    tint = {
        p.name: tuple(value_at(p, t) for t in (0.95, 0.4, 0.05)) for p in numbers if p.width == 3
    }
    found.append({p.name: value_at(p, 0.7) for p in numbers} | tint)
    return [{k: v if isinstance(v, tuple) else float(v) for k, v in f.items()} for f in found]


def random_parameters(cls: type[Model], count: int, seed: int) -> dict[str, Any]:
    """float32 arrays over the whole range, with both ends among them."""
    rng = np.random.default_rng(seed)
    values: dict[str, Any] = {}
    for name, declared in cls.fields.items():
        if isinstance(declared, Parameter):
            shape = (count, 3) if declared.width == 3 else (count,)
            t = rng.random(shape)
            t[rng.random(shape) < 0.05] = 0
            t[rng.random(shape) < 0.05] = 1
            values[name] = single(declared, value_at(declared, t))
    return values


def single(declared: Parameter, value: NDArray[np.float64]) -> NDArray[np.float32]:
    """Values as float32 that are within the range in float64 as well."""
    low, high = float32_range(declared)
    return np.clip(value.astype(np.float32), low, high)


def float32_range(declared: Parameter) -> tuple[np.float32, np.float32]:
    """The smallest and the largest float32 that are within a parameter's range in float64."""
    low, high = np.float32(declared.low), np.float32(declared.high)
    if low < declared.low:
        low = np.nextafter(low, np.float32(np.inf))
    if high > declared.high:  # pi / 2 rounds up
        high = np.nextafter(high, np.float32(0))
    return low, high
