"""Foreign code as one of gonio's models, wherever values are enough: plots, tables, fits.

Its values come from the code's own process, its derivatives from central differences of them. It samples by
the code's own sampler, or with a cosine. Nothing can be exported, and renderers cannot call it.
"""

from __future__ import annotations

import re
import types
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import drjit as dr
import numpy as np

from gonio.check.subject import FreeNumber, stored
from gonio.fields import Parameter
from gonio.foreign.expressions import Array
from gonio.foreign.function import Foreign, probe
from gonio.foreign.source import ForeignError
from gonio.foreign.subject import ForeignSubject
from gonio.lang import Color, Float, Sample, Vec2, Vec3
from gonio.model import Model, param

# Half the step of a derivative, of a parameter's range or of 1: float32's roundings are 1e-4 of the change.
STEP = 2e-3

# Differences by a turn about the normal up to which code is isotropic, of the larger value.
ISOTROPIC = 1e-4

# Angles of each rule of an albedo in both coordinates, and how half vectors crowd around the normal.
NODES, CROWDED = 48, 4

# Viewers in one call, and angles and azimuths of a mean.
PART = 56
MEAN, TURNS = 8, 4

_READABLE = "code that others wrote; its values can be checked, compared, plotted and fitted"


class ForeignModel(Model, register=False):
    """Values of foreign code. `as_model` makes classes with its parameters."""

    not_exported: ClassVar[str] = _READABLE
    foreign: ClassVar[Foreign]

    def _numbers(self) -> dict[str, Any]:
        return {name: getattr(self, name) for name in self.foreign.parameters}

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """The code's value, without the cosine."""
        numbers = self._numbers()
        return _values(self.foreign, self.float_type, wi, wo, numbers)

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """By the code's sampler, or around the normal by the cosine."""
        wi, density = self._bound_code().sample(wo, u)
        return Sample(wi, density)

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """The density of `sample`."""
        return self._bound_code().pdf(wi, wo)

    def albedo(self, wo: Vec3) -> Color:
        """By a rule of some thousand directions, to 1e-3."""
        kind = self._compiled()
        values = {n: _parameter(kind, v) for n, v in self._numbers().items()}
        found = albedos(self.foreign, _plain(kind, wo), values)
        return dr.replace_shape_t(kind, (3, -1))(*(stored(kind, c) for c in found.T))

    def mean_albedo(self) -> Color:
        """The mean of `albedo` over the hemisphere."""
        kind = self._compiled()
        values = {n: _parameter(kind, v) for n, v in self._numbers().items()}
        count = max([len(v) for v in values.values()], default=1)
        x, w = np.polynomial.legendre.leggauss(MEAN)
        theta = 0.25 * np.pi * (x + 1)
        total = np.zeros((count, 3))
        for angle, weight in zip(theta, 0.25 * np.pi * w, strict=True):
            for turn in np.arange(TURNS if not self.isotropic else 1) * 2 * np.pi / TURNS + 0.2:
                wo = [np.sin(angle) * np.cos(turn), np.sin(angle) * np.sin(turn), np.cos(angle)]
                E = albedos(self.foreign, np.tile(wo, (count, 1)), values)
                total += E * weight * np.sin(2 * angle) / (1 if self.isotropic else TURNS)
        return dr.replace_shape_t(kind, (3, -1))(*(stored(kind, c) for c in total.T))

    def _compiled(self) -> Any:
        if self.float_type is float:
            raise ForeignError(
                f"albedos and samples of {self.name} need a compiled backend; see 'gonio doctor'."
            )
        return self.float_type

    def _bound_code(self) -> Any:
        kind = self._compiled()
        values = {n: _parameter(kind, v) for n, v in self._numbers().items()}
        return _Fixed(self.foreign, values, drawn=True).at(np.zeros((1, 0)), None, kind)


class _Fixed(ForeignSubject):
    """Code whose parameters have values."""

    def __init__(self, foreign: Foreign, values: Mapping[str, Any], drawn: bool = False) -> None:
        super().__init__(foreign, drawn and foreign.sampler is not None)
        self.parameters: tuple[FreeNumber, ...] = ()
        self._values = dict(values)

    def at(self, parameters: Array, index: Any, Float: Any, rounded: bool = False) -> Any:
        """The function with these values; those of one row for each direction follow the index."""
        values = self._values
        if index is not None and len(parameters) > 1:
            rows = index.numpy() if dr.is_array_v(index) else np.asarray(index)
            values = {n: v[rows] if len(v) == len(parameters) else v for n, v in values.items()}
        return self.bound({n: v[0] if len(v) == 1 else v for n, v in values.items()}, Float)


def albedos(foreign: Foreign, wo: Array, values: Mapping[str, Array]) -> Array:
    """Directional albedos (n, 3) at n viewers, by two rules that share the integrand.

    One is even over the projected hemisphere, the other crowds half vectors around the normal; each
    takes the part of the integrand that its density has of both.
    """
    n = len(wo)
    found = np.empty((n, 3))
    for start in range(0, n, PART):
        part = slice(start, min(start + PART, n))
        chosen = {k: v[part] if len(v) == n and n > 1 else v for k, v in values.items()}
        found[part] = _albedos(foreign, wo[part], chosen)
    return found


def _albedos(foreign: Foreign, wo: Array, values: Mapping[str, Array]) -> Array:
    x, w = np.polynomial.legendre.leggauss(NODES)
    t, w = 0.5 * (x + 1), 0.5 * w
    phi = 2 * np.pi * (np.arange(NODES) + 0.5) / NODES
    t, phi = (a.ravel() for a in np.meshgrid(t, phi, indexing="ij"))
    area = np.repeat(w, NODES) / NODES
    n, size = len(wo), len(t)
    o = np.repeat(wo, size, axis=0)
    turn = np.arctan2(o[:, 1], o[:, 0]) + np.tile(phi, n)
    # Even over the projected hemisphere: the squared sine is even in [0, 1]
    sine, cosine = np.sqrt(np.tile(t, n)), np.sqrt(1 - np.tile(t, n))
    first = np.stack([sine * np.cos(turn), sine * np.sin(turn), cosine], -1)
    theta = 0.5 * np.pi * np.tile(t, n) ** CROWDED
    m = np.stack([np.sin(theta) * np.cos(turn), np.sin(theta) * np.sin(turn), np.cos(theta)], -1)
    second = 2 * (m * o).sum(1, keepdims=True) * m - o
    total = np.zeros((n, 3))
    rows = {
        k: np.repeat(v, size, axis=0) if len(v) == n and n > 1 else v for k, v in values.items()
    }
    rows = {k: v[0] if len(v) == 1 else v for k, v in rows.items()}
    for wi, which in ((first, 0), (second, 1)):
        p = _densities(wi, o)
        good = (wi[:, 2] > 1e-6) & (p[which] > 0)
        f = np.nan_to_num(foreign.brdf(np.where(good[:, None], wi, [0.0, 0.0, 1.0]), o, rows))
        weight = np.where(good, wi[:, 2] / np.maximum(p[0] + p[1], 1e-300) * np.tile(area, n), 0)
        total += (f * weight[:, None]).reshape(n, size, 3).sum(axis=1)
    return total


def _densities(wi: Array, wo: Array) -> tuple[Array, Array]:
    """Of both rules' directions, in 1/sr."""
    m = wi + wo
    m /= np.maximum(np.linalg.norm(m, axis=1, keepdims=True), 1e-300)
    theta = np.maximum(np.arccos(np.clip(m[:, 2], -1, 1)), 1e-9)
    t = (2 * theta / np.pi) ** (1 / CROWDED)
    slope = 0.5 * np.pi * CROWDED * t ** (CROWDED - 1)
    across = 1 / (2 * np.pi * np.sin(theta) * slope)
    cos_d = np.maximum((m * wo).sum(1), 1e-9)
    return np.maximum(wi[:, 2], 0) / np.pi, across / (4 * cos_d)


def _plain(kind: Any, w: Any) -> Array:
    Vec = dr.replace_shape_t(kind, (3, -1))
    return np.ascontiguousarray(np.asarray(dr.detach(Vec(w)).numpy(), np.float64).T)


def _parameter(kind: Any, value: Any) -> Array:
    """A parameter's value in a kernel, (n,) or (n, 3)."""
    if dr.size_v(value) == 3 and dr.depth_v(value) == 2:
        return np.asarray(dr.detach(value).numpy(), np.float64).T
    return np.asarray(dr.detach(kind(value)).numpy(), np.float64)


def _values(foreign: Foreign, kind: Any, wi: Any, wo: Any, numbers: Mapping[str, Any]) -> Any:
    if kind is float:
        a, b = (np.array([[float(c) for c in w]]) for w in (wi, wo))
        plain = {n: np.array(v) if np.ndim(v) else float(v) for n, v in numbers.items()}
        return dr.scalar.Array3f64(foreign.brdf(a, b, plain)[0].tolist())
    Vec = dr.replace_shape_t(kind, (3, -1))
    return dr.custom(_Call, foreign, kind, Vec(wi), Vec(wo), dict(numbers))


class _Call(dr.CustomOp):  # type: ignore[misc]
    """A call of the code, whose derivatives are differences."""

    def eval(self, foreign: Foreign, kind: Any, wi: Any, wo: Any, numbers: dict[str, Any]) -> Any:
        """The values."""
        self.foreign, self.kind = foreign, kind
        self.given = {n: _parameter(kind, v) for n, v in numbers.items()}
        self.wi, self.wo = _plain(kind, wi), _plain(kind, wo)
        n = max(len(self.wi), len(self.wo), *(len(v) for v in self.given.values()), 1)
        self.wi, self.wo = (np.broadcast_to(w, (n, 3)) for w in (self.wi, self.wo))
        self.given = {k: np.broadcast_to(v, (n, *v.shape[1:])) for k, v in self.given.items()}
        return self._made(self.foreign.brdf(self.wi, self.wo, self.given))

    def _made(self, f: Array) -> Any:
        return dr.replace_shape_t(self.kind, (3, -1))(*(stored(self.kind, c) for c in f.T))

    def _along(self, slopes: Mapping[str, Array]) -> Array:
        """The derivative along changes of the parameters."""
        ends = []
        for sign in (1, -1):
            moved = {}
            for name, value in self.given.items():
                p = self.foreign.parameters[name]
                step = sign * STEP * slopes.get(name, np.zeros(1))
                moved[name] = np.clip(value + step * _scale(p), p.low, p.high)
            ends.append((moved, self.foreign.brdf(self.wi, self.wo, moved)))
        # Where an end of the range cuts a step, the derivative is of what is left
        left = np.ones(len(self.wi))
        for name, slope in slopes.items():
            p = self.foreign.parameters[name]
            whole = 2 * STEP * slope * _scale(p)
            with np.errstate(all="ignore"):
                part = (ends[0][0][name] - ends[1][0][name]) / np.where(whole == 0, 1, whole)
            part = np.where(whole == 0, 1, part)
            left = np.minimum(left, part.min(axis=1) if part.ndim > 1 else part)
        return np.asarray((ends[0][1] - ends[1][1]) / (2 * STEP * np.maximum(left, 1e-3))[:, None])

    def forward(self) -> None:
        """Carry derivatives along."""
        slopes = {}
        for name, value in self.grad_in("numbers").items():
            slope = _parameter(self.kind, value) / _scale(self.foreign.parameters[name])
            slopes[name] = np.broadcast_to(slope, self.given[name].shape)
        self.set_grad_out(self._made(self._along(slopes)))

    def backward(self) -> None:
        """Derivatives of every parameter, one after the other."""
        out = _plain(self.kind, self.grad_out())
        found = {}
        for name, value in self.given.items():
            channels = []
            for c in range(value.shape[1] if value.ndim > 1 else 1):
                unit = np.zeros_like(value)
                unit[..., c if value.ndim > 1 else ...] = 1
                slope = self._along({name: unit}) / _scale(self.foreign.parameters[name])
                channels.append((slope * out).sum(axis=1))
            numbers = [stored(self.kind, c) for c in channels]
            Vec = dr.replace_shape_t(self.kind, (3, -1))
            found[name] = Vec(*numbers) if len(numbers) == 3 else numbers[0]
        self.set_grad_in("numbers", found)

    def name(self) -> str:
        """For Dr.Jit's pictures of computations."""
        return "foreign code"


def _scale(p: Parameter) -> float:
    return min(p.high - p.low, 100.0)


def _turns(foreign: Foreign) -> bool:
    """Whether turning both directions about the normal changes the value."""
    wi, wo = probe(128, 5)
    c, s = np.cos(0.7), np.sin(0.7)
    about = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    straight, turned = foreign.brdf(wi, wo), foreign.brdf(wi @ about, wo @ about)
    with np.errstate(invalid="ignore"):
        apart = np.abs(straight - turned) > 1e-6 + ISOTROPIC * np.abs(straight)
    return bool(np.mean(apart.any(axis=1)) > 0.05)


def as_model(foreign: Foreign) -> Model:
    """A model of gonio's that has the code's values and parameters.

    Args:
        foreign: a function that is running; it runs as long as the model lives.
    """
    plain = re.sub(r"\W+", "_", foreign.name).strip("_").lower()
    members: dict[str, Any] = {
        "__doc__": f"{foreign.name}, code that others wrote.",
        "__module__": __name__,
        "__annotations__": {
            n: Color if p.width == 3 else Float for n, p in foreign.parameters.items()
        },
        "foreign": foreign,
        "isotropic": not _turns(foreign),
    }
    for n, p in foreign.parameters.items():
        if n in _TAKEN:
            raise ForeignError(
                f"{foreign.name}: a parameter of a model cannot be called {n!r}; give it another name "
                f'with --map "{n}={n}_".'
            )
        members[n] = param(p.default, p.low, p.high, p.doc)
    made: type[Model] = types.new_class(
        "".join(word.title() for word in plain.split("_")) or "Code",
        (ForeignModel,),
        {"register": False},
        lambda namespace: namespace.update(members),
    )
    made.name = foreign.name  # as commands take it
    return made()


_TAKEN: Sequence[str] = [name for name in dir(ForeignModel) if not name.startswith("__")]
