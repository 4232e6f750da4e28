"""Parameter values that cover a model's whole range, made from its own declarations."""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from gonio.model import Model, Option, Parameter

# Places in a parameter's range: the ends, just inside them, and between.
PLACES = (0.0, 1e-7, 1e-3, 0.1, 0.5, 0.9, 1.0)

# Ranges that span more than this factor above 1 are walked by powers of ten.
WIDE = 100.0

# Choices with a kink inside the highlight, at which numeric albedos lose digits (see gonio.quadrature).
KINKED = {
    "cook_torrance": 1e-3,
    "neumann": 1e-3,
    "smith_walter": 1e-3,
    "dielectric": 0.03,  # the edge of total internal reflection, for indices below 1
}


def place(declared: Parameter, t: Any) -> Any:
    """The value at a place t in [0, 1] of a parameter's range; arrays work as well."""
    if declared.high - declared.low > WIDE:
        wide = declared.low + np.expm1(t * np.log1p(declared.high - declared.low))
        return np.minimum(wide, declared.high)  # the round trip may end a bit above
    return declared.low + (declared.high - declared.low) * t


def options(cls: type[Model]) -> list[dict[str, str]]:
    """Every choice of every option, one at a time, starting with the defaults."""
    found: list[dict[str, str]] = [{}]
    for name, declared in cls.fields.items():
        if isinstance(declared, Option):
            found += [{name: value} for value in declared.values[1:]]
    return found


def chosen(cls: type[Model], choice: dict[str, str]) -> dict[str, str]:
    """The value of every option: the given ones and the defaults of the others."""
    return {n: d.default for n, d in cls.fields.items() if isinstance(d, Option)} | choice


def admits(cls: type[Model], choice: dict[str, str], words: str) -> bool:
    """Whether a caveat has these words; one that names options (x='y') speaks of those only."""
    values = set(chosen(cls, choice).items())
    for caveat in cls.caveats:
        named = set(re.findall(r"(\w+)='(\w+)'", caveat))
        if words in caveat and (not named or named & values):
            return True
    return False


def kink_error(cls: type[Model], choice: dict[str, str]) -> float:
    """How much numeric albedos may be off because of kinks that no rule can know of."""
    declared = 1e-3 if admits(cls, choice, "Has a kink") else 0.0
    return max([KINKED.get(v, 0.0) for v in chosen(cls, choice).values()] + [declared])


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


def strong(cls: type[Model]) -> dict[str, Any]:
    """A setting at which effects show: default colours, numbers above the middle, wide ranges low."""
    return {
        p.name: float(place(p, 0.0 if p.high - p.low > WIDE else 0.6))
        for p in cls.fields.values()
        if isinstance(p, Parameter) and p.width == 1
    }


def thinned(cls: type[Model], step: int, choice: dict[str, str]) -> list[dict[str, Any]]:
    """Every step-th of `sweep`, or fewer, for slow tests; the last one has tinted colours.

    At most 14 with default options and 5 with others; half of that where albedos are quadratures of
    sharp lobes, which take seconds each.
    """
    every = sweep(cls)
    found = every[:-1:step]
    limit = 4 if choice else 13
    if cls.albedo_rule != "angles":
        limit = 1 if choice else 5
    return [*found[:: -(-len(found) // limit)], every[-1]]


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
            values[name] = np.clip(
                place(declared, t).astype(np.float32), np.float32(declared.low), None
            )
            if np.isfinite(declared.high):
                high = np.float32(declared.high)
                if high > declared.high:  # pi / 2 rounds up
                    high = np.nextafter(high, np.float32(0))
                values[name] = np.minimum(values[name], high)
    return values
