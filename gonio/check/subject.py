"""What is being checked: a model with its options chosen, and its free parameters over their whole range.

Checks give parameters as rows of numbers in [0, 1], one for each number and each channel of a colour. They
are evaluated in batches, many directions for every row, in one kernel whatever the values are.
"""

from __future__ import annotations

import functools
import math
import shlex
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from types import ModuleType
from typing import Any, Protocol, Self

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from gonio import backend
from gonio.arrays.kernel import opaque
from gonio.check import mistakes
from gonio.check.special import inner_models, literals
from gonio.check.variants import float32_range, is_wide, part_of, value_at
from gonio.claims import Claims, Kink, WhiteFurnace, as_tuple
from gonio.fields import Option, Parameter
from gonio.model import Child, Model

Array = NDArray[np.float64]

Case = tuple[Array, Array, Array]
"""Parameters in [0, 1], wi and wo."""


@dataclass(frozen=True)
class FreeNumber:
    """A number that may vary: a parameter, or a channel of a colour."""

    path: str
    channel: int
    declared: Parameter
    special: tuple[float, ...]
    """Values at which formulas may change: the default, whole numbers, and numbers in the source."""

    @functools.cached_property
    def parts(self) -> Array:
        """The parts in [0, 1] of the range at which something may change: both ends, and those values."""
        inside = part_of(self.declared, np.array(self.special, np.float64))
        return np.unique(np.concatenate([(0.0, 1.0), inside]))


@dataclass(frozen=True)
class Size:
    """A documented size of a departure."""

    size: float
    own: bool
    """Whether the model itself documents it for these options alone; else it is an upper bound only."""


@dataclass(frozen=True)
class Remark:
    """Something to know beside what is measured: what it belongs to, what it is about, and the words."""

    check: str
    what: str
    text: str


class Subject(Protocol):
    """What the checks need to know; `ModelSubject` here, `MitsubaSubject` in gonio.check.mitsuba_bsdf."""

    name: str
    parameters: tuple[FreeNumber, ...]
    chosen: Mapping[str, str]
    varied: frozenset[str]
    """Options that are not the defaults."""
    claims: Claims
    claiming: bool
    """Whether it says what it promises; a plug-in of others is measured all the same."""
    textured: bool
    """Whether its parameters are a place in a texture."""
    isotropic: bool
    whole: bool
    """Whether every parameter is free, so that claims must be neither too small nor too large."""
    float32: bool
    """Whether it computes in single precision only."""
    differentiable: bool
    """Whether it has derivatives."""
    albedos: str
    """Where its own albedos come from: "closed form", "quadrature", or "" if it has none; "composed" if it
    makes them of inner models' quadratures, each of which takes as long as hundreds of values."""
    mean_closed: bool
    """Whether its mean albedo is a closed form."""
    left_out: Sequence[str]
    """Parts that are no function and are known by samples alone: what `at` gives has a `weight` then."""

    def prepare(self) -> None:
        """Raise a ValueError where it cannot be evaluated at all, with what to do about it."""

    def notes(self) -> list[Remark]:
        """What is left out of the checks, or else to be known before they are read."""

    def fault(self, error: Exception) -> Exception:
        """What to raise for an exception that came out of it: with the place in its own code."""

    def at(self, parameters: Array, index: Any, Float: Any, rounded: bool = False) -> Any:
        """Something with eval, sample, pdf (and albedo) on Dr.Jit arrays.

        Args:
            parameters: rows in [0, 1], (rows, numbers).
            index: Dr.Jit index of the row for every element.
            Float: the Dr.Jit number type.
            rounded: take parameters that float32 can hold.
        """

    def bound(self, values: Mapping[str, Any], Float: Any) -> Any:
        """The same with Dr.Jit values for the free parameters, by path."""

    def values(self, parameters: Array, rounded: bool = False) -> dict[str, Array]:
        """Values of the free parameters, (rows,) or (rows, 3), by path."""

    def default(self) -> Array:
        """The row of the default parameters, (numbers,)."""

    def tag(self) -> str:
        """The options that are not the defaults, for people."""

    def with_options(self, choice: Mapping[str, str]) -> Self:
        """The same with other options."""

    def size(self, promise: str) -> Size | None:
        """The documented size of a departure; None where it is promised."""

    def kinks(self) -> list[tuple[Kink, bool]]:
        """Documented kinks, and whether the model itself documents them."""

    def furnaces(self) -> list[WhiteFurnace]:
        """Every white furnace that is claimed, with whatever options."""

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
        """A shell command that shows the value at one pair of directions, or a sample.

        `compare` is what `gonio eval --compare` shows beside it; `derivatives` shows these too.
        """

    def recheck(self, check: str, case: Case | None = None, free: Collection[str] = ()) -> str:
        """A shell command that makes one check again with the case's parameters fixed, but those `free`.

        Without a case over the whole range, with all options. It is for what no pair of directions shows:
        an integral, a count of samples, a change along a parameter.
        """


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
        numbers = literals(model)
        self.parameters = tuple(
            FreeNumber(path, channel, declared, _special(declared, value, channel, numbers))
            for path, declared, value in model.parameters()
            if path not in fixed
            for channel in range(declared.width)
        )
        self.claims = model.claims
        self.claiming, self.textured = True, False
        self.chosen: Mapping[str, str] = _choices(model)
        self.varied = frozenset(n for n, v in self.chosen.items() if v != model.fields[n].default)
        self.isotropic = not model.follows_tangents()
        self.whole = not fixed
        self.float32 = False
        self.differentiable = True
        self.albedos = _origin(model)
        self.mean_closed = model.writes("mean_albedo")
        self.left_out: Sequence[str] = ()

    @functools.cached_property
    def _ranges(self) -> _Ranges:
        # Of many variants not all are looked at
        return _Ranges(self.parameters)

    def prepare(self) -> None:
        """Raise a ModelError about a mistake in the model's methods."""
        mistakes.find(self.model, number_type())

    def notes(self) -> list[Remark]:
        """What of the model's file is outside the language of models."""
        return [Remark("language", "file", t) for t in mistakes.notes(self.model, number_type())]

    def fault(self, error: Exception) -> Exception:
        """A ModelError with file, line and what to write, where the model's file is to blame."""
        return mistakes.stopped(self.model, error) or error

    def values(self, parameters: Array, rounded: bool = False) -> dict[str, Array]:
        """Values of the free parameters, (rows,) or (rows, 3), by path."""
        table = self._ranges.values(parameters)
        if rounded:
            table = self._ranges.single(table)
        columns: dict[str, list[int]] = {}
        for number, free in enumerate(self.parameters):
            columns.setdefault(free.path, []).append(number)
        return {
            path: table[:, these[0] : these[-1] + 1] if len(these) > 1 else table[:, these[0]]
            for path, these in columns.items()
        }

    def at(self, parameters: Array, index: Any, Float: Any, rounded: bool = False) -> Any:
        """The model, bound to the parameters of the rows that `index` names."""
        return self.bound(gathered(self.values(parameters, rounded), index, Float), Float)

    def bound(self, values: Mapping[str, Any], Float: Any) -> Any:
        """The model with Dr.Jit values for its free parameters, by path."""

        def convert(path: str, declared: Parameter, value: Any) -> Any:
            return values[path] if path in values else opaque(Float, declared.width, value)

        return self.model.bind(Float, convert)

    def default(self) -> Array:
        """The row of the model's own values."""
        values = {path: value for path, _, value in self.model.parameters()}
        return np.array(
            [
                float(part_of(f.declared, _channel(values[f.path], f.channel)))
                for f in self.parameters
            ]
        )

    def tag(self) -> str:
        """Options that are not the defaults, such as "sampler=ltc"."""
        return ", ".join(f"{n}={v}" for n, v in self.chosen.items() if n in self.varied)

    def with_options(self, choice: Mapping[str, str]) -> ModelSubject:
        """The model with other options."""
        return ModelSubject(self.model.replace(**choice), self.fixed, self.label)

    def size(self, promise: str) -> Size | None:
        """The documented size of a departure, that of inner models included; None where it is promised."""
        known = self.claims.known(promise, self.chosen)
        own = None if known is None else float(known.size)
        below = [
            size
            for inner in inner_models(self.model)
            if (size := inner.claims.size(promise, _choices(inner))) is not None
        ]
        if own is None and not below:
            return None
        # What other options do to it nobody has said
        exact = known is not None and self.varied <= set(known.options) and not below
        return Size(max([*below, *([] if own is None else [own])]), exact)

    def kinks(self) -> list[tuple[Kink, bool]]:
        """Documented kinks, and whether the model itself documents them."""
        found = [(kink, True) for kink in self.claims.known_kinks(self.chosen)]
        for inner in inner_models(self.model):
            found += [(kink, False) for kink in inner.claims.known_kinks(_choices(inner))]
        return found

    def furnaces(self) -> list[WhiteFurnace]:
        """Every white furnace that is claimed, with whatever options."""
        return list(as_tuple(self.claims.furnace))

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
        """The `gonio eval` line of one pair of directions, or of one sample."""
        given = [("wo", wo), ("wi", wi)] if u is None else [("wo", wo), ("u", u)]
        words = " ".join(
            f"--{name} {' '.join(repr(float(x)) for x in numbers)}" for name, numbers in given
        )
        precision = " --double" if double else ""
        beside = f" --compare {compare}" if compare else ""
        beside += " --derivatives" if derivatives else ""
        named = self._named(parameters, rounded=not double)
        return f"gonio eval {named} {words}{precision}{beside}"

    def recheck(self, check: str, case: Case | None = None, free: Collection[str] = ()) -> str:
        """The `gonio check` line of one check: parameters fixed but those `free`, or the whole range."""
        named = shlex.quote(self.label) if case is None else self._named(case[0], free=free)
        return f"gonio check {named} --only {check}"

    def _named(self, parameters: Array, rounded: bool = False, free: Collection[str] = ()) -> str:
        """The model with its options and parameters, as commands take it."""
        values = self.values(np.asarray(parameters)[None], rounded)
        texts = _assignments(self.model)
        for path, _, value in self.model.parameters():
            if path not in free:
                texts[path] = _number(values[path][0] if path in values else value)
        text = ",".join(f"{path}={value}" for path, value in texts.items())
        return shlex.quote(f"{self.label}{':' if text else ''}{text}")


def _special_parts(free: FreeNumber) -> tuple[Array, Array]:
    """Parts of the range that stand for special values which roundings would miss, and these values."""
    special = np.array(free.special, np.float64)
    parts = part_of(free.declared, special)
    missed = value_at(free.declared, parts) != special
    parts, first = np.unique(parts[missed][::-1], return_index=True)
    return parts, special[missed][::-1][first]


class _Ranges:
    """All free numbers' ranges in one table, as `gonio.check.variants` has them one by one."""

    def __init__(self, parameters: Sequence[FreeNumber]) -> None:
        declared = [free.declared for free in parameters]
        self.declared = declared
        self.wide = np.flatnonzero([is_wide(d) for d in declared])
        self.low = np.array([d.low for d in declared], np.float64)
        self.span = np.array([0 if is_wide(d) else d.high - d.low for d in declared], np.float64)
        self.ends = np.array([float32_range(d) for d in declared], np.float32).reshape(-1, 2)
        special = [_special_parts(free) for free in parameters]
        self.special = np.flatnonzero([len(parts) for parts, _ in special])
        most = max((len(parts) for parts, _ in special), default=0)
        # One row for each number that has some, filled up with what is equal to nothing
        self.parts, self.exact = np.full((2, len(self.special), most), np.nan)
        for row, number in enumerate(self.special):
            parts, exact = special[number]
            self.parts[row, : len(parts)], self.exact[row, : len(parts)] = parts, exact

    def values(self, parameters: Array) -> Array:
        """Values (rows, numbers) at parts of the ranges."""
        t = np.asarray(parameters, np.float64)
        found = self.low + self.span * t
        for wide in self.wide:
            found[:, wide] = value_at(self.declared[wide], t[:, wide])
        if len(self.special):
            row, number, which = np.nonzero(t[:, self.special, None] == self.parts)
            found[row, self.special[number]] = self.exact[number, which]
        return found

    def single(self, values: Array) -> Array:
        """The nearest values that float32 can hold, within the ranges."""
        rounded = values.astype(np.float32)
        return np.clip(rounded, self.ends[:, 0], self.ends[:, 1]).astype(np.float64)


def _special(
    declared: Parameter, value: Any, channel: int, numbers: Sequence[float]
) -> tuple[float, ...]:
    """Values of a parameter at which a formula may change."""
    default = _channel(declared.default, channel)
    candidates = [_channel(value, channel), default, 0.0, 0.5, 1.0, 2.0, *numbers]
    return tuple(dict.fromkeys(v for v in candidates if declared.low <= v <= declared.high))


def _origin(model: Model) -> str:
    """Where a model's albedos come from."""
    if not model.writes("albedo"):
        return "quadrature"
    inner = inner_models(model)
    return "closed form" if all(m.writes("albedo") for m in inner) else "composed"


def _channel(value: Any, channel: int) -> float:
    return float(value[channel] if isinstance(value, tuple) else value)


def _choices(model: Model) -> dict[str, str]:
    return {name: getattr(model, name) for name, f in model.fields.items() if isinstance(f, Option)}


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

DTYPES = {"Float": np.float32, "Float64": np.float64, "UInt": np.uint32}


def stored(Type: Any, values: NDArray[Any]) -> Any:
    """Numbers in the device's memory, so that kernels depend neither on them nor on their address."""
    dtype = DTYPES[Type.__name__]
    size = np.dtype(dtype).itemsize
    buffer = np.empty(len(values) + ALIGNMENT // size, dtype)
    start = -buffer.__array_interface__["data"][0] % ALIGNMENT // size
    aligned = buffer[start : start + len(values)]
    aligned[:] = values
    array = Type(aligned)
    if len(values) == 1:  # one number alone would be compiled into the kernels
        dr.make_opaque(array)
    return array


def vectors(Float: Any, w: Array) -> Any:
    """NumPy directions (n, 3), or random numbers (n, 2), as a Dr.Jit vector."""
    return dr.replace_shape_t(Float, (w.shape[-1], -1))(*(stored(Float, c) for c in w.T))


def columns_of(value: Any) -> NDArray[Any]:
    """An evaluated Dr.Jit vector as a NumPy array (n, components)."""
    columns = [c.numpy() for c in value]
    found = np.empty((len(columns[0]), len(columns)), columns[0].dtype)
    for number, column in enumerate(columns):
        found[:, number] = column
    return found


def number_type(single_precision: bool = False) -> Any:
    """The Dr.Jit number type without derivatives."""
    module = compute()
    return module.Float if single_precision else module.Float64


def gathered(values: Mapping[str, Array], index: Any, Float: Any) -> dict[str, Any]:
    """Values (rows,) or (rows, 3) by path, as Dr.Jit values of the rows that `index` names."""
    if not values:
        return {}
    columns = np.column_stack(list(values.values()))
    rows, width = columns.shape
    if rows == 1:  # alone it would be compiled for itself
        columns = np.repeat(columns, 2, axis=0)
    table = stored(Float, columns.ravel())
    first = index * width
    found, number = {}, 0
    for path, value in values.items():
        channels = [dr.gather(Float, table, first + number + c) for c in range(value[0].size)]
        number += len(channels)
        found[path] = (
            channels[0] if len(channels) == 1 else dr.replace_shape_t(Float, (3, -1))(*channels)
        )
    return found


def number_of(values: dict[str, Array], free: FreeNumber) -> Array:
    """One number of the parameters' values by path, (rows,): a view."""
    value = values[free.path]
    return value if value.ndim == 1 else value[:, free.channel]


def repeated(rows: int, each: int) -> NDArray[np.uint32]:
    """0 0 0 1 1 1 2 2 2 ...: the index of `rows` rows with `each` directions."""
    return np.repeat(np.arange(rows, dtype=np.uint32), each)


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
    """A cosine for a number in [0, 1], crowded at grazing angles and at the normal; 0 and 1 at the ends."""
    t = np.asarray(t, np.float64)
    return np.minimum(t**3 * (10 - 15 * t + 6 * t * t), 1.0)


def finite(value: float) -> float:
    """A number that JSON can hold: the largest float for infinity."""
    return value if math.isfinite(value) else math.copysign(1.7976931348623157e308, value)
