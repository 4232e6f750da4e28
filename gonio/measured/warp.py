"""Bilinear functions on the unit square, with parameters between which they are mixed: sampled, inverted.

What RGL's files are made of. Source: Dupuy, Jakob, "An Adaptive Parameterization for Efficient Material
Acquisition and Rendering", SIGGRAPH Asia 2018, section 5; densities are bilinear, the rows are drawn
first.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gonio.measured.frames import Floats

# Two neighbours that differ by less of their sum are taken as equal: the root would lose its digits.
EVEN = 1e-4


class Bilinear:
    """Tables (p0, p1, ..., ny, nx) over the unit square, at places of their parameters p0, p1, ..."""

    def __init__(self, data: NDArray[Any], parameters: Sequence[Any] = ()) -> None:
        """Take tables; x is the last axis.

        Args:
            data: one axis for each parameter, then rows and columns, at least two of each.
            parameters: growing places of each parameter.
        """
        self.data = data
        self.parameters = [np.asarray(p, np.float64) for p in parameters]
        self.ny, self.nx = data.shape[len(self.parameters) : len(self.parameters) + 2]

    def slices(self, values: Sequence[Any], count: int) -> Iterator[tuple[tuple[Any, ...], Floats]]:
        """Indices of the tables around values of the parameters, and their weights."""
        around = []
        for places, value in zip(self.parameters, values, strict=True):
            value = np.broadcast_to(np.asarray(value, np.float64), count)
            low = np.clip(np.searchsorted(places, value, "right") - 1, 0, max(len(places) - 2, 0))
            if len(places) == 1:
                around.append([(low, np.ones(count))])
                continue
            width = places[low + 1] - places[low]
            part = np.clip((value - places[low]) / np.where(width > 0, width, 1), 0, 1)
            around.append([(low, 1 - part), (low + 1, part)])
        for corner in itertools.product(*around):
            weight = np.prod([w for _, w in corner], axis=0) if corner else np.ones(count)
            yield tuple(i for i, _ in corner), weight

    def eval(self, x: Any, y: Any, values: Sequence[Any] = ()) -> Floats:
        """The function at places (n,), for values of the parameters: (n,), or (n, channels)."""
        col, row, s, t = self._cell(x, y)
        return self._mix(self.data, row, col, s, t, list(self.slices(values, len(s))))

    def _cell(self, x: Any, y: Any) -> tuple[Any, Any, Floats, Floats]:
        x = np.clip(np.asarray(x, np.float64), 0, 1) * (self.nx - 1)
        y = np.clip(np.asarray(y, np.float64), 0, 1) * (self.ny - 1)
        col = np.minimum(x.astype(np.int64), self.nx - 2)
        row = np.minimum(y.astype(np.int64), self.ny - 2)
        return col, row, x - col, y - row

    @staticmethod
    def _mix(data: Any, row: Any, col: Any, s: Floats, t: Floats, slices: Any) -> Floats:
        wide = data.ndim > len(slices[0][0]) + 2
        total: Any = 0.0
        for index, weight in slices:
            for dy, dx in itertools.product((0, 1), (0, 1)):
                w = weight * (t if dy else 1 - t) * (s if dx else 1 - s)
                total = total + (w[:, None] if wide else w) * data[(*index, row + dy, col + dx)]
        return np.asarray(total)


class Density(Bilinear):
    """Tables scaled to densities: their integrals over the unit square are 1."""

    def __init__(self, data: NDArray[Any], parameters: Sequence[Any] = ()) -> None:
        """Take tables of numbers that are not negative. A table of zeros has no density: NaN."""
        super().__init__(np.asarray(data, np.float64), parameters)
        # Integrals in units of a cell: along rows, then of rows
        along = np.zeros_like(self.data)
        np.cumsum(0.5 * (self.data[..., 1:] + self.data[..., :-1]), -1, out=along[..., 1:])
        total = along[..., -1]
        down = np.zeros_like(total)
        np.cumsum(0.5 * (total[..., 1:] + total[..., :-1]), -1, out=down[..., 1:])
        scale = down[..., -1]
        with np.errstate(divide="ignore", invalid="ignore"):
            self.along = along / scale[..., None, None]
            self.down = down / scale[..., None]
            self.data = self.data / scale[..., None, None]
        self.cells = (self.nx - 1) * (self.ny - 1)

    def density(self, x: Any, y: Any, values: Sequence[Any] = ()) -> Floats:
        """The density at places (n,)."""
        return np.asarray(self.eval(x, y, values) * self.cells)

    def invert(self, x: Any, y: Any, values: Sequence[Any] = ()) -> tuple[Floats, Floats]:
        """The uniform numbers that `sample` turns into these places."""
        col, row, s, t = self._cell(x, y)
        slices = list(self.slices(values, len(s)))

        def look(data: Any, *place: Any) -> Floats:
            return np.asarray(sum(w * data[(*index, *place)] for index, w in slices))

        v00, v10 = look(self.data, row, col), look(self.data, row, col + 1)
        v01, v11 = look(self.data, row + 1, col), look(self.data, row + 1, col + 1)
        c0, c1 = (1 - t) * v00 + t * v01, (1 - t) * v10 + t * v11
        left = (1 - t) * look(self.along, row, col) + t * look(self.along, row + 1, col)
        last = self.nx - 1
        r0, r1 = look(self.along, row, last), look(self.along, row + 1, last)
        with np.errstate(divide="ignore", invalid="ignore"):
            u = (left + s * (c0 + 0.5 * s * (c1 - c0))) / ((1 - t) * r0 + t * r1)
        return u, look(self.down, row) + t * (r0 + 0.5 * t * (r1 - r0))

    def sample(self, u: Any, v: Any, table: tuple[int, ...] = ()) -> tuple[Floats, Floats]:
        """Places (n,), (n,) for uniform numbers, with the density of one of the tables."""
        u, v = np.asarray(u, np.float64), np.asarray(v, np.float64)
        data, along, down = self.data[table], self.along[table], self.down[table]
        row = np.clip(np.searchsorted(down, v, "left") - 1, 0, self.ny - 2)
        t = _inverse(v - down[row], along[row, -1], along[row + 1, -1])
        u = u * ((1 - t) * along[row, -1] + t * along[row + 1, -1])
        lines = (1 - t)[:, None] * along[row] + t[:, None] * along[row + 1]
        col = np.clip((lines < u[:, None]).sum(-1) - 1, 0, self.nx - 2)
        each = np.arange(len(u))
        s = _inverse(
            u - lines[each, col],
            (1 - t) * data[row, col] + t * data[row + 1, col],
            (1 - t) * data[row, col + 1] + t * data[row + 1, col + 1],
        )
        return (col + s) / (self.nx - 1), (row + t) / (self.ny - 1)


def _inverse(area: Floats, a: Floats, b: Floats) -> Floats:
    """Where the integral of a line from a to b over [0, 1] has reached an area."""
    even = ~(np.abs(a - b) > EVEN * (a + b))
    with np.errstate(divide="ignore", invalid="ignore"):
        straight = 2 * area / (a + b)
        bent = (a - np.sqrt(np.maximum(a * a - 2 * area * (a - b), 0))) / (a - b)
    return np.asarray(np.clip(np.nan_to_num(np.where(even, straight, bent)), 0, 1))
