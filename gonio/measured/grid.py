"""Values between the places of a table: multilinear, aware of holes and of azimuths that go round."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gonio.measured.frames import Floats
from gonio.measured.measurement import Mask

# Directions that are looked up at once, which bounds the memory.
BATCH = 1 << 17


class Grid:
    """A table with one axis for each coordinate and the channels last."""

    def __init__(self, values: NDArray[Any], valid: NDArray[Any], periodic: Sequence[bool]) -> None:
        """Take a table.

        Args:
            values: (n0, n1, ..., channels).
            valid: (n0, n1, ...), where there is a value.
            periodic: for each axis whether the place after the last is the first one again.
        """
        self.values, self.valid, self.periodic = values, valid, tuple(periodic)

    def __call__(self, *places: Any) -> tuple[Floats, Mask]:
        """Values (n, channels) and where at least half of them by weight was measured (n,).

        Args:
            places: for each axis where to look (n,), in steps: 0 at its first place. What is outside takes
                the value at the axis's end.
        """
        count = len(places[0])
        found = np.zeros((count, self.values.shape[-1]))
        covered = np.zeros(count, bool)
        for start in range(0, count, BATCH):
            part = slice(start, start + BATCH)
            found[part], covered[part] = self._look([np.asarray(p[part], float) for p in places])
        return found, covered

    def _look(self, places: list[Floats]) -> tuple[Floats, Mask]:
        corners = []
        for place, extent, periodic in zip(places, self.valid.shape, self.periodic, strict=True):
            if not periodic:
                place = np.clip(place, 0, extent - 1)
            first = np.floor(place)
            part = place - first
            low = first.astype(np.int64)
            high = low + 1
            if periodic:
                low, high = low % extent, high % extent
            else:
                high = np.minimum(high, extent - 1)
            corners.append(((low, 1 - part), (high, part)))
        total = np.zeros((len(places[0]), self.values.shape[-1]))
        weight = np.zeros(len(places[0]))
        for corner in itertools.product(*corners):
            index = tuple(i for i, _ in corner)
            w = np.prod([w for _, w in corner], axis=0) * self.valid[index]
            total += w[:, None] * self.values[index]
            weight += w
        return total / np.where(weight > 0, weight, 1)[:, None], weight >= 0.5


def between(places: Any, values: Any) -> Floats:
    """Where values are on an axis with growing places, in steps; outside of them at the ends."""
    places = np.asarray(places, np.float64)
    return np.asarray(np.interp(values, places, np.arange(len(places), dtype=np.float64)))
