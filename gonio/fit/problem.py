"""Measured values beside a model's, as functions of its free numbers, with their derivatives."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from gonio import backend
from gonio.fields import Parameter
from gonio.fit.columns import Column
from gonio.fit.metrics import Metric
from gonio.lang import vec3
from gonio.measured import Measurement
from gonio.measured.spectra import to_rgb
from gonio.model import Model

Floats = NDArray[np.float64]

# Lanes of one kernel call, which bounds the memory to some hundred megabytes.
LANES = 1 << 20

# Where a range has no end, starts are drawn up to so many times the default value.
BEYOND = 3.0

Group = tuple[int, ...]
"""Columns that change different channels: one derivative tells them all."""


@dataclass
class Problem:
    """A model beside values, at directions.

    Raises:
        BackendError: there is no compiled backend, in which a fit would take hours.
    """

    model: Model
    """With the values of what is fixed."""
    free: tuple[Column, ...]
    wi: Floats
    """Unit vectors (n, 3)."""
    wo: Floats
    values: Floats
    """Linear RGB in 1/sr, (n, 3)."""
    weights: Floats
    """(n,), the mean of which is 1."""
    evaluations: int = field(default=0, init=False)

    def __post_init__(self) -> None:
        """Look for a backend."""
        if backend.current() == "scalar":
            raise backend.BackendError(
                f"a fit needs a compiled backend. {backend.missing_llvm_reason()}"
            )

    @property
    def cosines(self) -> Floats:
        """(n, 1), of the light."""
        return self.wi[:, 2:]

    @property
    def bounds(self) -> tuple[Floats, Floats]:
        """The allowed ranges of the free numbers."""
        return (
            np.array([c.low for c in self.free], np.float64),
            np.array([c.high for c in self.free], np.float64),
        )

    @property
    def width(self) -> Floats:
        """Of the ranges; 1 where one has no end."""
        low, high = self.bounds
        return np.where(np.isfinite(high - low), high - low, 1.0)

    def part(self, place: Any) -> Problem:
        """The same for some of the directions."""
        return Problem(
            self.model,
            self.free,
            self.wi[place],
            self.wo[place],
            self.values[place],
            self.weights[place],
        )

    def at(self, wi: Floats, wo: Floats) -> Problem:
        """The same model at other directions, beside nothing."""
        return Problem(self.model, self.free, wi, wo, np.zeros((len(wi), 3)), np.ones(len(wi)))

    def start(self) -> Floats:
        """The model's own values."""
        stored = {path: np.atleast_1d(value) for path, _, value in self.model.parameters()}
        first = (column.places[0] for column in self.free)
        return np.array([stored[path][c % len(stored[path])] for path, c in first], np.float64)

    def random(self, random: np.random.Generator, count: int) -> Floats:
        """Values all over the ranges, (count, numbers), each range in even steps of its own order."""
        low, high = self.bounds
        high = np.where(np.isfinite(high), high, low + BEYOND * np.maximum(self.start() - low, 1))
        steps = np.stack([random.permutation(count) for _ in low], -1)
        return np.asarray(low + (steps + random.random(steps.shape)) / count * (high - low))

    def made(self, x: Floats) -> Model:
        """The model with these numbers."""
        changed: dict[str, Any] = {}
        stored = {path: (p, value) for path, p, value in self.model.parameters()}
        for column, value in zip(self.free, x, strict=True):
            number = float(np.clip(value, column.low, column.high))
            for path, channel in column.places:
                declared, old = stored[path]
                if declared.width == 1:
                    changed[path] = number
                    continue
                old = old if isinstance(old, tuple) else (old,) * 3
                triple = list(changed.get(path, old))
                triple[channel] = number
                changed[path] = tuple(triple)
        return self.model.replace(**changed)

    def residuals(self, x: Floats, metric: Metric) -> Floats:
        """Weighted differences (3 n,), model minus measured."""
        f = metric.value(self.evaluate(x) * self.cosines)
        difference = f - metric.value(self.values * self.cosines)
        return np.asarray((difference * np.sqrt(self.weights)[:, None]).ravel())

    def jacobian(self, x: Floats, metric: Metric) -> Floats:
        """Their derivatives (3 n, numbers)."""
        f, slopes = self.slopes(x, [(j,) for j in range(len(x))])
        factor = metric.slope(f * self.cosines) * self.cosines * np.sqrt(self.weights)[:, None]
        return np.asarray((slopes * factor).reshape(len(x), -1).T)

    def evaluate(self, x: Floats) -> Floats:
        """Values (n, 3)."""
        return np.concatenate([f for _, f, _ in self.parts(x, ())]) if len(self.wi) else self.values

    def slopes(self, x: Floats, groups: Sequence[Group]) -> tuple[Floats, Floats]:
        """Values (n, 3), and derivatives (groups, n, 3)."""
        parts = list(self.parts(x, groups))
        return np.concatenate([p[1] for p in parts]), np.concatenate([p[2] for p in parts], 1)

    def parts(self, x: Floats, groups: Sequence[Group]) -> Iterator[tuple[slice, Floats, Floats]]:
        """The same for some of the directions after the other, so that memory has a bound."""
        self.evaluations += 1
        size = max(1, LANES // max(len(groups), 1))
        for start in range(0, len(self.wi), size):
            part = slice(start, min(start + size, len(self.wi)))
            yield part, *self._kernel(x, self.wi[part], self.wo[part], groups)

    def _kernel(
        self, x: Floats, wi: Floats, wo: Floats, groups: Sequence[Group]
    ) -> tuple[Floats, Floats]:
        """All directions once for each group, whose derivative is carried along."""
        module = backend.array_module()
        Float, UInt = module.Float64, module.UInt32
        Vec = dr.replace_shape_t(Float, (3, -1))
        count, each = len(wi), max(len(groups), 1)
        lane = dr.arange(UInt, count * each)
        index, turn = lane % dr.opaque(UInt, count), lane // dr.opaque(UInt, count)
        directions = [
            Vec(*(dr.gather(Float, Float(np.ascontiguousarray(w[:, c])), index) for c in range(3)))
            for w in (wi, wo)
        ]
        numbers: dict[tuple[str, int], Any] = {}
        given = Float(np.ascontiguousarray(x))
        dr.make_opaque(given)
        for place, column in enumerate(self.free):
            value = dr.gather(Float, given, UInt(place)) + dr.zeros(Float, count * each)
            turns = [n for n, group in enumerate(groups) if place in group]
            if turns:
                dr.enable_grad(value)
                dr.set_grad(value, dr.select(turn == turns[0], Float(1), Float(0)))
            numbers |= dict.fromkeys(column.places, value)

        def convert(path: str, declared: Parameter, stored: Any) -> Any:
            triple = stored if isinstance(stored, tuple) else (stored,) * declared.width
            found = [
                numbers[path, c] if (path, c) in numbers else dr.opaque(Float, v)
                for c, v in enumerate(triple)
            ]
            return found[0] if declared.width == 1 else vec3(*found)

        result = self.model.bind(Float, convert).eval(*directions)
        f = Vec(result) + dr.zeros(Float, count * each)
        if not groups:
            return np.asarray(dr.detach(f).numpy()).T, np.empty((0, count, 3))
        dr.forward_to(f)
        gradient = np.asarray(dr.grad(f).numpy()).T.reshape(each, count, 3)
        return np.asarray(dr.detach(f).numpy()).T[:count], gradient


def from_measurement(
    model: Model, free: tuple[Column, ...], data: Measurement, points: int | None, seed: int
) -> Problem:
    """The problem of a measurement: what was measured, without holes and extrapolated values.

    Args:
        model: a model.
        free: its free numbers.
        data: measured reflection.
        points: how many directions are drawn, without replacement; None for all.
        seed: of the draw.
    """
    place = usable(data)
    if points is not None and len(place) > points:
        place = np.sort(np.random.default_rng(seed).choice(place, points, replace=False))
    wi, wo = (unit(w[place]) for w in (data.wi, data.wo))
    values = to_rgb(data, data.values[place])[0]
    weights = data.weights[place].astype(np.float64)
    return Problem(model, free, wi, wo, values, weights / weights.mean())


def usable(data: Measurement) -> NDArray[np.intp]:
    """Where a measurement has a value that was measured."""
    use = data.valid if data.extrapolated is None else data.valid & ~data.extrapolated
    return np.flatnonzero(use)


def unit(w: Any) -> Floats:
    """Vectors (n, 3) of length 1 in double precision."""
    w = np.asarray(w, np.float64)
    return np.asarray(w / np.linalg.norm(w, axis=-1, keepdims=True))
