"""Shaders that are a sum, of a diffuse and a specular part for instance: taken apart, and each part named.

Of a part that is no known product the nearest is said.

A colour or a weight on which values depend linearly separates them: what is left at 0 is one part, and what
it adds the other. Metalness hides this, and is set to 0 first.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from gonio.fields import Parameter
from gonio.foreign import terms, widths
from gonio.foreign.expressions import Array
from gonio.foreign.function import Returns, Valued, probe

# Values are linear if the middle is so near to the mean of the ends, of the largest value there.
LINEAR = 2e-5
PAIRS = 200

# Parts that are no more than this of the largest value are roundings.
NOTHING = 1e-4

# Parts are taken apart so often.
DEPTH = 2

_METAL = re.compile(r"metal", re.I)


@dataclass(frozen=True)
class Sum:
    """Parts that were named, each with the parameter that scales it; the last one has none."""

    parts: tuple[tuple[str, terms.Product], ...]
    pinned: Mapping[str, float]
    """Parameters that were set, and to what."""
    last: Valued
    """The last part by itself."""

    @property
    def exact(self) -> bool:
        """Whether nothing but roundings is left in any part."""
        return all(p.exact for _, p in self.parts)


@dataclass
class _Part:
    """Code at one value of a parameter, or what the parameter adds."""

    whole: Valued
    name: str
    low: float
    high: float | None = None
    returns: Returns = field(init=False)

    def __post_init__(self) -> None:
        self.returns = self.whole.returns

    @property
    def parameters(self) -> dict[str, Parameter]:
        """Those that are left."""
        return {n: p for n, p in self.whole.parameters.items() if n != self.name}

    def raw(self, wi: Array, wo: Array, values: dict[str, Any] | None = None) -> Array:
        """Values of the part."""
        below = self.whole.raw(wi, wo, {**(values or {}), self.name: self.low})
        if self.high is None:
            return below
        above = self.whole.raw(wi, wo, {**(values or {}), self.name: self.high})
        return (above - below) / (self.high - self.low)


class _Scaled(_Part):
    """What a parameter adds, times the parameter, so that its colour is named as well."""

    @property
    def _width(self) -> int:
        return self.whole.parameters[self.name].width

    @property
    def parameters(self) -> dict[str, Parameter]:
        """All of them."""
        return self.whole.parameters

    def raw(self, wi: Array, wo: Array, values: dict[str, Any] | None = None) -> Array:
        """Values of the part."""
        size = np.asarray((values or {})[self.name], np.float64)
        return super().raw(wi, wo, values) * (size if self._width == 3 else size[..., None])


def identify(foreign: Valued) -> Sum | None:
    """The parts of a function that is a sum of known products, but for one; None if it is none."""
    pinned: dict[str, float] = {}
    whole = foreign
    for name, p in foreign.parameters.items():
        if _METAL.search(name) and p.width == 1:
            pinned[name] = p.low
            whole = _Part(whole, name, p.low)
    parts = _apart(whole, DEPTH)
    if len(parts) < 2:
        return None
    if not parts[-1].product.exact:
        last = parts[-1]
        parts[-1] = _Named(last.name, widths.identify(last.valued)[0], last.valued)
    named = tuple((part.name, part.product) for part in parts)
    return Sum(named, pinned, parts[-1].valued)


@dataclass(frozen=True)
class _Named:
    """One part, and by what it is scaled."""

    name: str
    product: terms.Product
    valued: Valued


def _apart(whole: Valued, depth: int) -> list[_Named]:
    """Parts with the parameter that each is linear in; the last one may be unknown.

    None at all if it is no product either, and nothing can be taken away from it.
    """
    known: list[_Named] = []
    if depth:
        for name, p in whole.parameters.items():
            if p.low != 0 or not 0 < p.high < np.inf or not _linear(whole, name, p.high):
                continue
            # A colour scales its part, which is identified with it: it may be the F0 of another
            scaled = _Scaled(whole, name, 0.0, p.high)
            added = terms.identify(scaled)
            if not (added and added[0].exact):
                continue
            left = _apart(_Part(whole, name, 0.0), depth - 1)
            parts = [_Named(name, added[0], scaled), *left]
            if left and left[-1].product.exact:
                return parts
            if left and not known:
                known = parts
    found = terms.identify(whole)
    if found and found[0].exact:
        return [_Named("", found[0], whole)]
    return known or [_Named("", p, whole) for p in found[:1]]


def _linear(whole: Valued, name: str, high: float) -> bool:
    """Whether values are linear in a parameter, neither constant nor 0 without it."""
    wi, wo = probe(PAIRS, 41)
    rng = np.random.default_rng(42)
    values: dict[str, Any] = {}
    for n, p in whole.parameters.items():
        t = rng.uniform(0.2, 0.9, len(wi))
        top = min(p.high, 100.0) if p.high > 10 else p.high
        t = p.low + (top - p.low) * t
        values[n] = np.repeat(t[:, None], 3, axis=1) if p.width == 3 else t
    none, half, full = (
        whole.raw(wi, wo, {**values, name: high * t})[:, 0] for t in (0.0, 0.5, 1.0)
    )
    good = np.isfinite(none) & np.isfinite(half) & np.isfinite(full)
    if not good.any():
        return False
    largest = np.abs(full[good]).max()
    off = np.abs(half - 0.5 * (none + full))[good] / np.maximum(
        np.abs(full[good]), NOTHING * largest
    )
    added = np.abs(full - none)[good].max()
    return bool(
        off.max() <= LINEAR and min(added, np.abs(none[good]).max()) > NOTHING * largest > 0
    )
