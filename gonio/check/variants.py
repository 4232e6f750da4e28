"""What a model can be: every option, and its parameters over their whole range, from its declarations."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gonio.fields import Option, Parameter
from gonio.model import Model

# Places in a parameter's range: the ends, just inside them, and between.
PLACES = (0.0, 1e-7, 1e-3, 0.1, 0.5, 0.9, 1.0)

# Ranges that span more than this factor above 1 are walked by powers of ten.
WIDE = 100.0

# Where a range has no end, this much of it is walked.
ENDLESS = 1e6


def place(declared: Parameter, t: Any) -> Any:
    """The value at a place t in [0, 1] of a parameter's range; arrays work as well."""
    high = min(declared.high, declared.low + ENDLESS)
    if high - declared.low > WIDE:
        wide = declared.low + np.expm1(t * np.log1p(high - declared.low))
        return np.minimum(wide, high)  # the round trip may end a bit above
    return declared.low + (high - declared.low) * t


def place_of(declared: Parameter, value: Any) -> Any:
    """The place in [0, 1] of a value: the inverse of `place`."""
    high = min(declared.high, declared.low + ENDLESS)
    if high - declared.low > WIDE:
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


def chosen(cls: type[Model], choice: Mapping[str, str]) -> dict[str, str]:
    """The value of every option: the given ones and the defaults of the others."""
    return {n: d.default for n, d in cls.fields.items() if isinstance(d, Option)} | dict(choice)


def sweep(cls: type[Model]) -> list[dict[str, Any]]:
    """Each number in turn at each of PLACES, the others in the middle; colours white and tinted."""
    found: list[dict[str, Any]] = []
    numbers = [p for p in cls.fields.values() if isinstance(p, Parameter)]
    for varied in numbers:
        for t in PLACES:
            found.append({p.name: place(p, t if p is varied else 0.5) for p in numbers})
    tint = {p.name: tuple(place(p, t) for t in (0.95, 0.4, 0.05)) for p in numbers if p.width == 3}
    found.append({p.name: place(p, 0.7) for p in numbers} | tint)
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
            values[name] = single(declared, place(declared, t))
    return values


def single(declared: Parameter, value: NDArray[np.float64]) -> NDArray[np.float32]:
    """Values as float32 that are within the range in float64 as well."""
    rounded = np.clip(value.astype(np.float32), np.float32(declared.low), None)
    if np.isfinite(declared.high):
        high = np.float32(declared.high)
        if high > declared.high:  # pi / 2 rounds up
            high = np.nextafter(high, np.float32(0))
        rounded = np.minimum(rounded, high)
    if np.float32(declared.low) < declared.low:
        rounded = np.maximum(rounded, np.nextafter(np.float32(declared.low), np.float32(np.inf)))
    return rounded
