"""Parameters that only scale what code gives back: a colour, an occlusion, a weight, 1 - metalness.

They are taken off before anything else is tried, however many they are.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from gonio.fields import Parameter
from gonio.foreign.expressions import Array
from gonio.foreign.function import Returns, Valued, probe

# Values are proportional to a parameter if they are so near to it, of float32's 6e-8; at so many places,
# and at such parts of its range for the three channels of colours.
PROPORTIONAL = 1e-5
PAIRS = 120
PARTS = (0.25, 0.5, 0.75)

# Values below this part of the largest one may be roundings.
FAINT = 1e-6


@dataclass
class Unscaled:
    """Code with the parameters that scale it set to where they are 1."""

    whole: Valued
    scales: dict[str, float]
    """Parameters, and the values at which they change nothing."""

    @property
    def returns(self) -> Returns:
        """As of the whole."""
        return self.whole.returns

    @property
    def parameters(self) -> dict[str, Parameter]:
        """Those that are left."""
        return {n: p for n, p in self.whole.parameters.items() if n not in self.scales}

    @property
    def text(self) -> str:
        """What was taken off; empty if nothing was."""
        above = sorted(n for n, one in self.scales.items() if one)
        without = sorted(f"(1 - {n})" for n, one in self.scales.items() if not one)
        return f"times {' '.join([*above, *without])}" if self.scales else ""

    def raw(self, wi: Array, wo: Array, values: dict[str, Any] | None = None) -> Array:
        """What the code gives back without them."""
        return self.whole.raw(wi, wo, {**(values or {}), **self.scales})


def unscaled(foreign: Valued) -> Unscaled:
    """Code without the parameters that it is proportional to, or to 1 - them."""
    wi, wo = probe(PAIRS, 61)
    good = wi[:, 2] > 0.05
    wi, wo = wi[good], wo[good]
    rng = np.random.default_rng(62)
    base: dict[str, Any] = {}
    for name, p in foreign.parameters.items():
        high = p.high if np.isfinite(p.high) else p.low + 1
        base[name] = p.low + (high - p.low) * rng.uniform(0.2, 0.9, len(wi))
        if p.width == 3:
            base[name] = np.repeat(base[name][:, None], 3, axis=1)
    scales: dict[str, float] = {}
    for name, p in foreign.parameters.items():
        if p.low != 0 or not p.high >= 1:
            continue
        for one in (1.0, 0.0) if p.high == 1 and p.width == 1 else (1.0,):
            full = foreign.raw(wi, wo, {**base, name: _spread(p, (one, one, one), len(wi))})
            parts = PARTS if p.width == 3 else PARTS[1:2] * 3
            some = foreign.raw(wi, wo, {**base, name: _spread(p, parts, len(wi))})
            share = np.array(parts) if one else 1 - np.array(parts)
            largest = np.nanmax(np.where(np.isfinite(full), np.abs(full), 0))
            seen = np.isfinite(full) & np.isfinite(some) & (np.abs(full) > FAINT * largest)
            off = np.abs(some - share * full)[seen] / np.abs(full)[seen]
            if seen.sum() > PAIRS // 2 and off.max() < PROPORTIONAL:
                scales[name] = one
                break
    return Unscaled(foreign, scales)


def _spread(p: Parameter, parts: tuple[float, ...], count: int) -> Array:
    """One value, or one colour, at all places."""
    return np.tile(parts, (count, 1)) if p.width == 3 else np.full(count, parts[0])
