"""Foreign code as a subject of gonio's checks, as far as values go."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any

import drjit as dr
import numpy as np

from gonio.check.subject import Array, Case, FreeNumber, Remark, Size, stored
from gonio.check.variants import value_at
from gonio.claims import Claims, Kink, WhiteFurnace
from gonio.foreign.function import Foreign, picked
from gonio.foreign.rounding import ROUNDINGS, rounded


class ForeignSubject:
    """A function of foreign code, with its parameters over their ranges."""

    claims = Claims()
    claiming = textured = False
    chosen: Mapping[str, str] = {}
    varied: frozenset[str] = frozenset()
    isotropic = False  # not known beforehand
    whole = False
    float32 = True
    differentiable = False
    albedos = ""
    mean_closed = False
    left_out: Sequence[str] = ()

    def __init__(self, foreign: Foreign, drawn: bool = False, least: bool = False) -> None:
        """Take a function that is running.

        Args:
            foreign: the function.
            drawn: sample with the code's own sampler, which is to be judged; else with a cosine.
            least: take off its values what roundings may have added.
        """
        self.foreign, self.drawn, self.least = foreign, drawn, least
        self.name = foreign.name
        self.parameters: tuple[FreeNumber, ...] = tuple(
            FreeNumber(name, channel, declared, _special(declared.low, declared.high))
            for name, declared in foreign.parameters.items()
            for channel in range(declared.width)
        )

    def prepare(self) -> None:
        """It is running; that is all."""

    def notes(self) -> list[Remark]:
        """`gonio.foreign.verdicts` says what is assumed."""
        return []

    def fault(self, error: Exception) -> Exception:
        """What stops in a process of its own has its place already."""
        return error

    def values(self, parameters: Array, rounded: bool = False) -> dict[str, Array]:
        """Values of the parameters, (rows,) or (rows, 3), by name."""
        found: dict[str, list[Array]] = {}
        for number, free in enumerate(self.parameters):
            value = np.asarray(value_at(free.declared, np.asarray(parameters)[:, number]))
            found.setdefault(free.path, []).append(value.astype(np.float32).astype(np.float64))
        return {
            name: np.stack(channels, -1) if len(channels) > 1 else channels[0]
            for name, channels in found.items()
        }

    def at(self, parameters: Array, index: Any, Float: Any, rounded: bool = False) -> Any:
        """The function with the parameters of the rows that `index` names."""
        rows = index.numpy() if dr.is_array_v(index) else np.asarray(index)
        values = {name: v[rows] for name, v in self.values(parameters).items()}
        return _Bound(self.foreign, Float, values, self.drawn, self.least)

    def bound(self, values: Mapping[str, Any], Float: Any) -> Any:
        """The function with Dr.Jit values for its parameters."""
        plain = {
            name: np.asarray(dr.detach(v).numpy()).T if dr.is_array_v(v) else v
            for name, v in values.items()
        }
        return _Bound(self.foreign, Float, plain, self.drawn)

    def default(self) -> Array:
        """The row of the default parameters."""
        found = []
        for free in self.parameters:
            d = free.declared
            value = d.default[free.channel] if isinstance(d.default, tuple) else d.default
            found.append((value - d.low) / (d.high - d.low))
        return np.clip(np.array(found, np.float64), 0, 1)

    def tag(self) -> str:
        """No options."""
        return ""

    def with_options(self, choice: Mapping[str, str]) -> ForeignSubject:
        """No options."""
        return self

    def size(self, promise: str) -> Size | None:
        """Nothing is documented."""
        return None

    def kinks(self) -> list[tuple[Kink, bool]]:
        """Nothing is documented."""
        return []

    def furnaces(self) -> list[WhiteFurnace]:
        """Nothing is claimed."""
        return []

    def replay(
        self,
        parameters: Array,
        wi: Array,
        wo: Array,
        *,
        double: bool = True,
        u: Array | None = None,
        compare: str = "",
        derivatives: bool = False,
    ) -> str:
        """Directions and parameters, in words."""
        values = self.values(np.asarray(parameters)[None])
        words = [f"wi = ({_shown(wi)})", f"wo = ({_shown(wo)})"]
        words += [f"{name} = {_shown(v[0])}" for name, v in values.items()]
        return ", ".join(words)

    def recheck(self, check: str, case: Case | None = None, free: Collection[str] = ()) -> str:
        """The same words: `gonio.foreign.verdicts` makes the checks of code."""
        return "" if case is None else self.replay(*case)


def _shown(value: Any) -> str:
    return ", ".join(f"{x:.7g}" for x in np.atleast_1d(value))


def _special(low: float, high: float) -> tuple[float, ...]:
    return tuple(v for v in (0.0, 0.5, 1.0) if low <= v <= high)


class _Bound:
    """eval of the code, and its sampler or one of gonio's own that shows integrals where to look."""

    def __init__(
        self,
        foreign: Foreign,
        Float: Any,
        values: Mapping[str, Any],
        drawn: bool,
        least: bool = False,
    ) -> None:
        self.foreign, self.Float, self.values, self.least = foreign, Float, values, least
        self.sampler = foreign.sampler if drawn else None
        self.density = foreign.density if drawn else None

    def eval(self, wi: Any, wo: Any) -> Any:
        """BRDF without the cosine."""
        a, b = self._plain(wi), self._plain(wo)
        n = max(len(a), len(b))
        a, b = np.broadcast_to(a, (n, 3)), np.broadcast_to(b, (n, 3))
        if self.least:
            both = rounded(self.foreign, a, b, self.values)
            with np.errstate(invalid="ignore"):
                f = np.maximum(both.values - ROUNDINGS * both.rounding, 0)
        else:
            f = self.foreign.brdf(a, b, self.values)
        # What is not finite is a finding of its own, and must not hide what all the rest adds up to
        f = np.where(np.isfinite(f), f, 0.0)
        Vec = dr.replace_shape_t(self.Float, (3, -1))
        return Vec(*(stored(self.Float, c) for c in f.T))

    def _plain(self, w: Any) -> Array:
        Vec = dr.replace_shape_t(self.Float, (3, -1))
        return np.asarray(Vec(w).numpy(), np.float64).T

    def pdf(self, wi: Any, wo: Any) -> Any:
        """The code's density, or the cosine's."""
        if self.density is not None:
            a, b = self._plain(wi), self._plain(wo)
            n = max(len(a), len(b))
            found = self._densities(np.broadcast_to(a, (n, 3)), np.broadcast_to(b, (n, 3)))
            return stored(self.Float, found)
        return dr.select((wi.z > 0) & (wo.z > 0), wi.z / np.pi, 0)

    def sample(self, wo: Any, u: Any) -> tuple[Any, Any]:
        """By the code's sampler, or around the normal by the cosine."""
        Vec = dr.replace_shape_t(self.Float, (3, -1))
        if self.sampler is not None:
            return self._drawn(wo, u)
        r, phi = dr.sqrt(self.Float(u.x)), 2 * np.pi * self.Float(u.y)
        z = dr.sqrt(dr.maximum(1 - r * r, 0))
        wi = Vec(r * dr.cos(phi), r * dr.sin(phi), z)
        return wi, dr.select(wo.z > 0, z / np.pi, 0)

    def _drawn(self, wo: Any, u: Any) -> tuple[Any, Any]:
        assert self.sampler is not None
        Vec = dr.replace_shape_t(self.Float, (3, -1))
        b = self._plain(wo)
        random = np.stack([np.asarray(self.Float(x).numpy(), np.float64) for x in (u.x, u.y)], -1)
        n = max(len(b), len(random))
        b = np.ascontiguousarray(np.broadcast_to(b, (n, 3)))
        w, density = self.sampler.samples(b, np.broadcast_to(random, (n, 2)), self.values)
        missing = density < 0
        w = np.where(np.isfinite(w), w, 0.0)
        if missing.any():
            density = np.where(missing, self._densities(w, b), density)
        density = np.where((b[:, 2] > 0) & np.isfinite(density), density, 0.0)
        return Vec(*(stored(self.Float, c) for c in w.T)), stored(self.Float, density)

    def _densities(self, wi: Array, wo: Array) -> Array:
        """The code's, 0 below the horizon."""
        assert self.density is not None
        above = (wi[:, 2] > 0) & (wo[:, 2] > 0)
        found = np.zeros(len(wi))
        if above.any():
            values = picked(self.values, above)
            found[above] = self.density.raw(wi[above], wo[above], values)[:, 0]
        return np.where(np.isfinite(found), found, 0.0)
