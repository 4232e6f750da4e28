"""What is being checked: a model with its options chosen, over the places of its free parameters.

Checks work on points: rows of places in [0, 1], one for each number and each channel of a colour. They are
evaluated in batches, many directions at every point, in one kernel whatever the values are.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import ModuleType
from typing import Any, Protocol

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from gonio import backend
from gonio.arrays.kernel import opaque
from gonio.check.variants import place, place_of, single
from gonio.claims import Claims, as_tuple
from gonio.fields import Option, Parameter
from gonio.model import Child, Model

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Column:
    """One number that may vary: a parameter, or a channel of a colour."""

    path: str
    channel: int
    declared: Parameter


class Subject(Protocol):
    """What the checks need to know; `ModelSubject` here, `MitsubaSubject` in gonio.check.mitsuba_bsdf."""

    name: str
    columns: tuple[Column, ...]
    claims: Claims
    chosen: Mapping[str, str]
    isotropic: bool
    whole: bool
    """Whether every parameter is free, so that claims must be neither too small nor too large."""
    float32: bool
    """Whether it computes in single precision only."""

    def at(self, places: Array, index: Any, Float: Any, rounded: bool = False) -> Any:
        """Something with eval, sample, pdf (and albedo) on Dr.Jit arrays.

        Args:
            places: of the points, (points, columns).
            index: Dr.Jit index of the point for every element.
            Float: the Dr.Jit number type.
            rounded: take parameters that float32 can hold.
        """

    def default(self) -> Array:
        """The places of the default parameters, (columns,)."""

    def tag(self) -> str:
        """The options that are not the defaults, for people."""

    def replay(self, places: Array, wi: Array, wo: Array) -> str:
        """A shell command that shows the value at one point."""


def compute() -> ModuleType:
    """The Dr.Jit module whose arrays have no derivatives, of the backend in force.

    Raises:
        BackendError: only plain Python is to be had, in which a check would take hours.
    """
    name = backend.current()
    if name == "scalar":
        raise backend.BackendError(
            f"gonio check needs a compiled backend. {backend.missing_llvm_reason()}"
        )
    module: ModuleType = {"llvm": dr.llvm, "cuda": dr.cuda}[name]
    return module


class ModelSubject:
    """A model of gonio's kind as a subject."""

    def __init__(
        self, model: Model, fixed: frozenset[str] = frozenset(), label: str | None = None
    ) -> None:
        """Vary every parameter of `model` except those whose path is in `fixed`.

        `label` is how the model is called on the command line, if not by its name.
        """
        self.model = model
        self.name = model.name
        self.label = label or model.name
        self.fixed = fixed
        self.columns = tuple(
            Column(path, channel, declared)
            for path, declared, _ in model.parameters()
            if path not in fixed
            for channel in range(declared.width)
        )
        self.claims = model.claims
        self.chosen: Mapping[str, str] = {
            name: getattr(model, name) for name, f in model.fields.items() if isinstance(f, Option)
        }
        inner = [getattr(model, n) for n, f in model.fields.items() if isinstance(f, Child)]
        self.isotropic = model.isotropic and all(m.isotropic for m in inner)
        self.whole = not fixed
        self.float32 = False
        self.closed_form = type(model).albedo is not Model.albedo

    def values(self, places: Array, rounded: bool = False) -> dict[str, Array]:
        """Values of the free parameters at points, (points,) or (points, 3), by path."""
        found: dict[str, list[Array]] = {}
        for number, column in enumerate(self.columns):
            value = place(column.declared, places[:, number])
            if rounded:
                value = single(column.declared, value).astype(np.float64)
            found.setdefault(column.path, []).append(value)
        return {
            path: np.stack(channels, -1) if len(channels) > 1 else channels[0]
            for path, channels in found.items()
        }

    def at(self, places: Array, index: Any, Float: Any, rounded: bool = False) -> Any:
        """The model, bound to the parameters of the points that `index` names."""
        values = self.values(places, rounded)

        def convert(path: str, declared: Parameter, value: Any) -> Any:
            if path not in values:
                return opaque(Float, declared.width, value)
            if declared.width == 1:
                return dr.gather(Float, stored(Float, values[path]), index)
            channels = (dr.gather(Float, stored(Float, c), index) for c in values[path].T)
            return dr.replace_shape_t(Float, (3, -1))(*channels)

        return self.model.bind(Float, convert)

    def default(self) -> Array:
        """The places of the model's own values."""
        values = {path: value for path, _, value in self.model.parameters()}
        return np.array(
            [
                float(
                    place_of(
                        c.declared,
                        v[c.channel] if isinstance(v := values[c.path], tuple) else v,
                    )
                )
                for c in self.columns
            ]
        )

    def tag(self) -> str:
        """Options that are not the defaults, such as "sampler=ltc"."""
        return ", ".join(
            f"{name}={value}"
            for name, value in self.chosen.items()
            if value != self.model.fields[name].default
        )

    def replay(self, places: Array, wi: Array, wo: Array) -> str:
        """The `gonio eval` line of one point."""
        values = self.values(np.asarray(places)[None])
        texts = _assignments(self.model)
        for path, _, value in self.model.parameters():
            if path in values:
                texts[path] = _number(values[path][0])
            else:
                texts[path] = _number(value)
        text = ",".join(f"{path}={value}" for path, value in texts.items())
        directions = " ".join(
            f"--{name} {' '.join(repr(float(x)) for x in w)}"
            for name, w in (("wi", wi), ("wo", wo))
        )
        return f"gonio eval {self.label}{':' if text else ''}{text} {directions} --double"


def _assignments(model: Model, prefix: str = "") -> dict[str, str]:
    """Options and inner models that are not the defaults, by path."""
    texts: dict[str, str] = {}
    for name, declared in model.fields.items():
        value = getattr(model, name)
        if isinstance(declared, Option) and value != declared.default:
            texts[prefix + name] = value
        elif isinstance(declared, Child):
            if value.name != declared.default:
                texts[prefix + name] = value.name
            texts |= _assignments(value, f"{prefix}{name}.")
    return texts


def _number(value: Any) -> str:
    numbers = [float(v) for v in np.atleast_1d(value)]
    if len(set(numbers)) == 1:
        numbers = numbers[:1]
    return "/".join(repr(v) for v in numbers)


# --- evaluation in batches -----------------------------------------------------------------------


# Dr.Jit takes NumPy's memory as it is, and compiles other kernels where it is not aligned like its own.
ALIGNMENT = 64


def stored(Type: Any, values: NDArray[Any]) -> Any:
    """Numbers in the device's memory, so that kernels depend neither on them nor on their address."""
    dtype = {"Float": np.float32, "Float64": np.float64, "UInt": np.uint32}[Type.__name__]
    size = len(values)
    buffer = np.empty(size * np.dtype(dtype).itemsize + ALIGNMENT, np.uint8)
    start = -buffer.ctypes.data % ALIGNMENT
    aligned = buffer[start : start + size * np.dtype(dtype).itemsize].view(dtype)
    aligned[:] = values
    array = Type(aligned)
    dr.make_opaque(array)  # one number alone would be compiled into the kernels
    return array


def vectors(Float: Any, w: Array) -> Any:
    """NumPy directions (n, 3), or random numbers (n, 2), as a Dr.Jit vector."""
    return dr.replace_shape_t(Float, (w.shape[-1], -1))(*(stored(Float, c) for c in w.T))


def columns_of(value: Any, Float: Any, width: int = 3) -> NDArray[Any]:
    """A Dr.Jit vector, evaluated, as a NumPy array (n, width)."""
    return np.asarray(dr.replace_shape_t(Float, (width, -1))(value).numpy()).T


def number_type(single_precision: bool = False) -> Any:
    """The Dr.Jit number type without derivatives."""
    module = compute()
    return module.Float if single_precision else module.Float64


def evaluate(
    subject: Subject,
    places: Array,
    index: NDArray[np.uint32],
    wi: Array,
    wo: Array,
    *,
    single_precision: bool = False,
    rounded: bool = False,
) -> tuple[NDArray[Any], NDArray[Any]]:
    """BRDF (n, 3) and density (n,) for n pairs of directions at the points that `index` names."""
    Float = number_type(single_precision)
    UInt = dr.uint32_array_t(Float)
    model = subject.at(places, stored(UInt, index), Float, rounded)
    wi_, wo_ = vectors(Float, wi), vectors(Float, wo)
    f = dr.replace_shape_t(Float, (3, -1))(model.eval(wi_, wo_))
    pdf = Float(model.pdf(wi_, wo_)) + dr.zeros(Float, len(wi))
    f = f + dr.zeros(Float, len(wi))
    dr.eval(f, pdf)
    return columns_of(f, Float), pdf.numpy()


def draw(
    subject: Subject,
    places: Array,
    index: NDArray[np.uint32],
    wo: Array,
    u: Array,
    *,
    single_precision: bool = False,
) -> tuple[NDArray[Any], NDArray[Any]]:
    """Sampled directions (n, 3) and the densities that the sampler reports (n,)."""
    Float = number_type(single_precision)
    UInt = dr.uint32_array_t(Float)
    model = subject.at(places, stored(UInt, index), Float, single_precision)
    wi, pdf = model.sample(vectors(Float, wo), vectors(Float, u))
    zero = dr.zeros(Float, len(wo))
    wi, pdf = dr.replace_shape_t(Float, (3, -1))(wi) + zero, Float(pdf) + zero
    dr.eval(wi, pdf)
    return columns_of(wi, Float), pdf.numpy()


def repeated(points: int, each: int) -> NDArray[np.uint32]:
    """0 0 0 1 1 1 2 2 2 ...: the index of `points` points with `each` directions."""
    return np.repeat(np.arange(points, dtype=np.uint32), each)


# --- sequences of random numbers -----------------------------------------------------------------

# Roberts' R2 sequence: the plastic number's powers, which fill the square most evenly.
_PLASTIC = 1.32471795724474602596
R2 = (1 / _PLASTIC, 1 / _PLASTIC**2)


@functools.cache
def even(count: int) -> Array:
    """Evenly spread numbers in [0, 1)², (count, 2), the same every time."""
    n = np.arange(1, count + 1)[:, None]
    return np.asarray((0.5 + n * np.array(R2)) % 1.0)


def directions(cosine: Any, azimuth: Any) -> Array:
    """Unit vectors (n, 3) from cosines and azimuths in radians."""
    mu = np.asarray(cosine, np.float64)
    s = np.sqrt((1 - mu) * (1 + mu))
    return np.stack([s * np.cos(azimuth), s * np.sin(azimuth), mu], -1)


def cosine_at(t: Any) -> Any:
    """A cosine for a place in [0, 1], crowded at grazing angles and at the normal; 0 and 1 at the ends."""
    t = np.asarray(t, np.float64)
    return np.minimum(t**3 * (10 - 15 * t + 6 * t * t), 1.0)


def known_size(subject: Subject, promise: str) -> float | None:
    """The documented size of a departure, that of inner models included; None where it is promised."""
    size = subject.claims.size(promise, subject.chosen)
    model = getattr(subject, "model", None)
    if isinstance(model, Model):
        for inner in inner_models(model):
            choices = {
                n: getattr(inner, n) for n, f in inner.fields.items() if isinstance(f, Option)
            }
            below = inner.claims.size(promise, choices)
            size = max((s for s in (size, below) if s is not None), default=None)
    return size


def inner_models(model: Model) -> list[Model]:
    """All models inside a model, at every depth."""
    found = []
    for name, declared in model.fields.items():
        if isinstance(declared, Child):
            inner = getattr(model, name)
            found += [inner, *inner_models(inner)]
    return found


def known_kinks(subject: Subject) -> list[str]:
    """Documented kinks, those of inner models included."""
    found = subject.claims.known_kinks(subject.chosen)
    model = getattr(subject, "model", None)
    if isinstance(model, Model):
        for inner in inner_models(model):
            choices = {
                n: getattr(inner, n) for n, f in inner.fields.items() if isinstance(f, Option)
            }
            found += inner.claims.known_kinks(choices)
    return found


def whites(subject: Subject) -> list[Any]:
    """The white furnaces that the options of a subject allow."""
    found = []
    for entry in as_tuple(subject.claims.furnace):
        choice = {k: v for k, v in entry.values.items() if isinstance(v, str)}
        if all(subject.chosen.get(k) == v for k, v in choice.items()):
            found.append(entry)
    return found


def finite(value: float) -> float:
    """A number that JSON can hold: the largest float for infinity."""
    return value if math.isfinite(value) else math.copysign(1.7976931348623157e308, value)
