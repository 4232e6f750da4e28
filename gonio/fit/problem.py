"""Measured values beside a model's, as functions of its free parameters, with all derivatives "
"in one kernel."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from gonio import backend
from gonio.fields import ModelError, Parameter, is_array
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


@dataclass(frozen=True)
class Column:
    """A number that is free: a parameter, or a channel of a colour."""

    path: str
    channel: int
    declared: Parameter

    @property
    def name(self) -> str:
        """For people: the path, with the channel of a colour."""
        return self.path if self.declared.width == 1 else f"{self.path}.{'rgb'[self.channel]}"


def columns(model: Model, fixed: Iterable[str] = ()) -> tuple[Column, ...]:
    """The free numbers of a model, those of inner models included.

    Raises:
        ModelError: a fixed name that is no parameter, a parameter that is an array, or nothing left free.
    """
    kept = set(fixed)
    paths = {path for path, _, _ in model.parameters()}
    if unknown := kept - paths:
        raise ModelError(
            f"{model.name} has no parameter {sorted(unknown)[0]!r} to fix; it has {', '.join(paths)}."
        )
    found: list[Column] = []
    for path, declared, value in model.parameters():
        if is_array(value):
            raise ModelError(f"{model.name}: {path} is an array; a fit takes numbers.")
        if path not in kept:
            found += [Column(path, c, declared) for c in range(declared.width)]
    if not found:
        raise ModelError(
            f"{model.name} has no free parameter; leave one out of those that are fixed."
        )
    return tuple(found)


class Problem:
    """Residuals of a model against measured values, and their Jacobian."""

    def __init__(
        self,
        model: Model,
        free: tuple[Column, ...],
        wi: Floats,
        wo: Floats,
        values: Floats,
        weights: Floats,
    ) -> None:
        """Take data.

        Args:
            model: with the values of what is fixed.
            free: its free numbers.
            wi: unit vectors (n, 3).
            wo: likewise.
            values: linear RGB in 1/sr, (n, 3).
            weights: (n,), the mean of which is 1.

        Raises:
            BackendError: there is no compiled backend, in which a fit would take hours.
        """
        if backend.current() == "scalar":
            raise backend.BackendError(
                f"a fit needs a compiled backend. {backend.missing_llvm_reason()}"
            )
        self.model, self.free = model, free
        self.wi, self.wo, self.values = wi, wo, values
        self.roots = np.sqrt(weights)[:, None]
        self.cosines = wi[:, 2:]
        self.evaluations = 0

    @property
    def bounds(self) -> tuple[Floats, Floats]:
        """The allowed ranges of the free numbers."""
        return (
            np.array([c.declared.low for c in self.free], np.float64),
            np.array([c.declared.high for c in self.free], np.float64),
        )

    def start(self) -> Floats:
        """The model's own values."""
        values = {path: np.atleast_1d(value) for path, _, value in self.model.parameters()}
        return np.array([values[c.path][c.channel % len(values[c.path])] for c in self.free], float)

    def random(self, random: np.random.Generator) -> Floats:
        """Values all over the ranges."""
        low, high = self.bounds
        high = np.where(np.isfinite(high), high, low + BEYOND * np.maximum(self.start() - low, 1))
        return np.asarray(random.uniform(low, high))

    def made(self, x: Floats) -> Model:
        """The model with these numbers."""
        changed: dict[str, Any] = {}
        for column, value in zip(self.free, x, strict=True):
            low, high = column.declared.low, column.declared.high
            number = float(np.clip(value, low, high))
            if column.declared.width == 1:
                changed[column.path] = number
            else:
                changed[column.path] = (*changed.get(column.path, ()), number)
        return self.model.replace(**changed)

    def residuals(self, x: Floats, metric: Metric) -> Floats:
        """Weighted differences (3 n,), model minus measured."""
        f, _ = self._evaluate(x, derivatives=False)
        return self._differences(f, metric)

    def jacobian(self, x: Floats, metric: Metric) -> Floats:
        """Their derivatives (3 n, numbers)."""
        f, slopes = self._evaluate(x, derivatives=True)
        factor = metric.slope(f * self.cosines) * self.cosines * self.roots
        return np.asarray((slopes * factor).reshape(len(x), -1).T)

    def _differences(self, f: Floats, metric: Metric) -> Floats:
        difference = metric.value(f * self.cosines) - metric.value(self.values * self.cosines)
        return np.asarray((difference * self.roots).ravel())

    def _evaluate(self, x: Floats, derivatives: bool) -> tuple[Floats, Floats]:
        """Values (n, 3), and derivatives (numbers, n, 3)."""
        self.evaluations += 1
        count = len(self.wi)
        each = len(x) if derivatives else 1
        f = np.empty((count, 3))
        slopes = np.empty((each if derivatives else 0, count, 3))
        size = max(1, LANES // each)
        for start in range(0, count, size):
            part = slice(start, min(start + size, count))
            value, slope = self._kernel(x, self.wi[part], self.wo[part], derivatives)
            f[part] = value
            if derivatives:
                slopes[:, part] = slope
        return f, slopes

    def _kernel(
        self, x: Floats, wi: Floats, wo: Floats, derivatives: bool
    ) -> tuple[Floats, Floats | None]:
        """All directions once for each number, whose own derivative is carried along."""
        module = backend.array_module()
        Float, UInt = module.Float64, module.UInt32
        Vec = dr.replace_shape_t(Float, (3, -1))
        count = len(wi)
        each = len(x) if derivatives else 1
        lane = dr.arange(UInt, count * each)
        index, turn = lane % count, lane // count
        directions = [
            Vec(*(dr.gather(Float, Float(np.ascontiguousarray(w[:, c])), index) for c in range(3)))
            for w in (wi, wo)
        ]
        numbers = {}
        given = Float(np.ascontiguousarray(x))
        dr.make_opaque(given)
        for place, column in enumerate(self.free):
            value = dr.gather(Float, given, UInt(place)) + dr.zeros(Float, count * each)
            if derivatives:
                dr.enable_grad(value)
                dr.set_grad(value, dr.select(turn == place, Float(1), Float(0)))
            numbers[column.path, column.channel] = value

        def convert(path: str, declared: Parameter, stored: Any) -> Any:
            if (path, 0) in numbers:
                if declared.width == 1:
                    return numbers[path, 0]
                return vec3(*(numbers[path, c] for c in range(3)))
            if declared.width == 1:
                return dr.opaque(Float, stored)
            triple = stored if isinstance(stored, tuple) else (stored,) * 3
            return vec3(*(dr.opaque(Float, v) for v in triple))

        result = self.model.bind(Float, convert).eval(*directions)
        f = Vec(result) + dr.zeros(Float, count * each)
        if not derivatives:
            return np.asarray(dr.detach(f).numpy()).T, None
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
    use = data.valid
    if data.extrapolated is not None:
        use = use & ~data.extrapolated
    place = np.flatnonzero(use)
    if points is not None and len(place) > points:
        place = np.sort(np.random.default_rng(seed).choice(place, points, replace=False))
    wi, wo = (_unit(w[place].astype(np.float64)) for w in (data.wi, data.wo))
    values = to_rgb(data, data.values[place])[0]
    weights = data.weights[place].astype(np.float64)
    return Problem(model, free, wi, wo, values, weights / weights.mean())


def _unit(w: Floats) -> Floats:
    return np.asarray(w / np.linalg.norm(w, axis=-1, keepdims=True))
