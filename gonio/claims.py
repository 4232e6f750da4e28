"""What a model promises, and the known sizes of what it does not: declared in the model's own file.

    claims = Claims(
        energy=at_most(1.0153),                                # the largest albedo, where it is above 1
        reciprocity=at_most(1, form="classical"),              # only with this option
        kinks=(dark_ring(), kink(Place.EQUAL_COSINES)),
        furnace=white_furnace(within=1e-6, rho=1),
    )

What is not mentioned is promised strictly: f(wi, wo) = f(wo, wi), no albedo above 1, no negative value,
no wasted sample, every direction that reflects is sampled, a smooth function. `gonio check` measures each
promise. It fails where one is broken, where a size is too small or far too large, and where a model keeps a
promise that it does not make. A size may be a few percent generous, and is never short.
"""

from __future__ import annotations

import enum
from collections.abc import Callable, Container, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

# The size of a departure that has no bound.
UNBOUNDED = float("inf")

Options = Mapping[str, str | tuple[str, ...]]


class Place(enum.Enum):
    """Where a function or its slope may jump, named by the pair of directions."""

    SIDE_LIGHT = "s = 0"
    """cos(phi_i - phi_o) changes its sign."""
    EQUAL_COSINES = "mu_i = mu_o"
    RIGHT_ANGLE = "wi.wo = 0"
    RIGHT_ANGLE_TO_MIRROR = "a right angle to the mirror direction"
    """Of wi, to wo's."""
    ELSEWHERE = "another place"
    IN_A_PARAMETER = "a value of a parameter"
    """The directions stay as they are."""


@dataclass(frozen=True)
class Known:
    """A known departure from a promise: its size, and the options that it belongs to (all if none)."""

    size: float
    options: Options = field(default_factory=dict)

    def applies(self, chosen: Mapping[str, str]) -> bool:
        """Whether it speaks of a model with these options."""
        return _matches(self.options, chosen)


@dataclass(frozen=True)
class Kink:
    """A place where the slope of the function jumps, or the function itself."""

    place: Place
    kind: str = "kink"
    """kink, jump, or "dark ring": a kink with a flat side."""
    options: Options = field(default_factory=dict)

    @property
    def name(self) -> str:
        """As it is shown, such as "kink at mu_i = mu_o"."""
        return f"{self.kind} at {self.place.value}"

    def applies(self, chosen: Mapping[str, str]) -> bool:
        """Whether it speaks of a model with these options."""
        return _matches(self.options, chosen)


@dataclass(frozen=True)
class WhiteFurnace:
    """Parameters and options with which the model reflects everything, to within `error`."""

    error: float
    values: Mapping[str, Any]


def at_most(size: float, **options: str | tuple[str, ...]) -> Known:
    """Declare a known departure; options limit it: at_most(0.52, masking=("kelemen", "implicit"))."""
    return Known(size, options)


def kink(place: Place, **options: str | tuple[str, ...]) -> Kink:
    """Declare a place where the slope jumps; options limit it."""
    return Kink(place, "kink", options)


def jump(place: Place, **options: str | tuple[str, ...]) -> Kink:
    """Declare a place where the value jumps; options limit it."""
    return Kink(place, "jump", options)


def dark_ring(**options: str | tuple[str, ...]) -> Kink:
    """Declare qualitative Oren-Nayar's kink, flat on one side; options limit it."""
    return Kink(Place.SIDE_LIGHT, "dark ring", options)


def white_furnace(*, within: float, **values: Any) -> WhiteFurnace:
    """Declare a white furnace: white_furnace(within=1e-6, rho=1), the albedo is 1 everywhere at rho = 1."""
    return WhiteFurnace(within, values)


def _matches(options: Options, chosen: Mapping[str, str]) -> bool:
    return all(
        chosen.get(name) in ((allowed,) if isinstance(allowed, str) else allowed)
        for name, allowed in options.items()
    )


@dataclass(frozen=True)
class Claims:
    """A model's promises. Of several sizes for one promise the first that fits the options counts."""

    energy: Known | tuple[Known, ...] = ()
    """Largest directional albedo of any parameters and angle, where it is above 1."""
    reciprocity: Known | tuple[Known, ...] = ()
    """Largest |f(wi, wo) - f(wo, wi)| relative to the larger of the two; 1 at most, if f >= 0."""
    negative: Known | tuple[Known, ...] = ()
    """How far below zero values go, times pi; UNBOUNDED if there is no lower bound."""
    wasted: Known | tuple[Known, ...] = ()
    """Largest part of the samples that has no direction above the horizon."""
    unreached: Known | tuple[Known, ...] = ()
    """Largest albedo in directions that the sampler never draws."""
    float32: Known | tuple[Known, ...] = ()
    """Relative error of float32 values, where it is more than 1e-5."""
    float32_density: Known | tuple[Known, ...] = ()
    """That of the densities of samples, beyond what the directions' own roundings change in them, where
    these change much: light that a coat keeps inside, say, leaves by the last bits of its azimuth."""
    numeric_albedo: Known | tuple[Known, ...] = ()
    """Error of albedos that are quadratures, where it is more than 3e-5."""
    kinks: Kink | tuple[Kink, ...] = ()
    """Where the value or its slope jumps."""
    furnace: WhiteFurnace | tuple[WhiteFurnace, ...] = ()
    """With which parameters nothing is lost."""
    falls: tuple[str, ...] = ()
    """Parameters that lower the mean albedo, or leave it, when they grow."""

    def faults(
        self, is_parameter: Callable[[str], bool], options: Mapping[str, Container[str]]
    ) -> Iterator[str]:
        """What says nothing, each in words: a value of another kind, and names that the model lacks.

        Args:
            is_parameter: whether a name is one of the model's numbers.
            options: its options, with their values.
        """
        for name in PROMISES:
            for entry in as_tuple(getattr(self, name)):
                if not isinstance(entry, Known) or not _is_size(entry.size):
                    given = entry.size if isinstance(entry, Known) else entry
                    write = "at_most(SIZE) with a number from 0 up, or several in ( )"
                    yield f"{name} is {write}, not {given!r}"
                else:
                    yield from _unknown(name, entry.options, options)
        for entry in as_tuple(self.kinks):
            if not isinstance(entry, Kink) or not isinstance(entry.place, Place):
                given = entry.place if isinstance(entry, Kink) else entry
                write = "kink(Place.EQUAL_COSINES), a jump, or dark_ring(), or several in ( )"
                yield f"kinks is {write}, not {given!r}"
            else:
                yield from _unknown(entry.kind, entry.options, options)
        for entry in as_tuple(self.furnace):
            if not isinstance(entry, WhiteFurnace) or not _is_size(entry.error):
                given = entry.error if isinstance(entry, WhiteFurnace) else entry
                yield f"furnace is white_furnace(within=1e-6, rho=1), or several in ( ), not {given!r}"
                continue
            chosen = {k: v for k, v in entry.values.items() if isinstance(v, str)}
            yield from _unknown("white_furnace", chosen, options)
            for path in entry.values:
                if path not in chosen and not is_parameter(path):
                    yield f"white_furnace has {path}, which is no parameter"
        falls: Any = self.falls
        if not isinstance(falls, tuple):
            yield f"falls is names of parameters in ( ), such as {(falls,)!r}, not {falls!r}"
            return
        for path in falls:
            if not is_parameter(path):
                yield f"falls has {path!r}, which is no parameter"

    def known(self, promise: str, chosen: Mapping[str, str]) -> Known | None:
        """The known departure with these options; None where the promise is kept."""
        entries: tuple[Known, ...] = as_tuple(getattr(self, promise))
        return next((entry for entry in entries if entry.applies(chosen)), None)

    def size(self, promise: str, chosen: Mapping[str, str]) -> float | None:
        """Its size."""
        entry = self.known(promise, chosen)
        return None if entry is None else float(entry.size)

    def known_kinks(self, chosen: Mapping[str, str]) -> list[Kink]:
        """The kinks and jumps that a model with these options has."""
        return [k for k in as_tuple(self.kinks) if k.applies(chosen)]

    def furnaces(self, chosen: Mapping[str, str]) -> list[WhiteFurnace]:
        """The white furnaces that are claimed with these options."""
        return [
            entry
            for entry in as_tuple(self.furnace)
            if all(chosen.get(k) == v for k, v in entry.values.items() if isinstance(v, str))
        ]

    def lines(self) -> Iterator[tuple[str, str]]:
        """What is promised, and what is known not to be kept, as pairs of heading and text."""
        for name, (kept, broken, extent) in PROMISES.items():
            entries = as_tuple(getattr(self, name))
            if not entries:
                yield "promised", kept
            for entry in entries:
                size = " without bound"
                if entry.size != UNBOUNDED:
                    size = extent.format(f"{entry.size:g}")
                yield "known", f"{broken}{size}{_condition(entry.options)}"
            if entries and all(entry.options for entry in entries):
                yield "promised", f"{kept} with the other options"
        for entry in as_tuple(self.kinks):
            yield "known", f"{entry.name}{_condition(entry.options)}"
        for entry in as_tuple(self.furnace):
            values = ", ".join(f"{name}={value}" for name, value in entry.values.items())
            yield "promised", f"reflects everything to within {entry.error:g} with {values}"
        for name in self.falls:
            yield "promised", f"the mean albedo never grows with {name}"


def _is_size(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and value >= 0


def _unknown(name: str, limits: Options, options: Mapping[str, Container[str]]) -> Iterator[str]:
    """Options that the model lacks, and values that they do not have."""
    for option, allowed in limits.items():
        if option not in options:
            yield f"{name} has {option}, which is no option"
            continue
        for value in (allowed,) if isinstance(allowed, str) else allowed:
            if value not in options[option]:
                yield f"{name} has {option}={value!r}, which is no choice of {option}"


def as_tuple(entry: Any) -> tuple[Any, ...]:
    """One entry or several as a tuple."""
    return entry if isinstance(entry, tuple) else (entry,)


def _condition(options: Options) -> str:
    texts = (
        f"{name}={allowed if isinstance(allowed, str) else '|'.join(allowed)}"
        for name, allowed in options.items()
    )
    return f", with {', '.join(texts)}" if options else ""


# How each promise reads when it is kept, and when its departure is known: what departs, and how far.
PROMISES = {
    "energy": ("reflects no more than it receives", "albedo", " up to {}"),
    "reciprocity": (
        "reciprocal",
        "swapping the directions changes the value",
        " by up to {} of it",
    ),
    "negative": ("never negative", "goes below zero", " by up to {} / pi"),
    "wasted": ("wastes no sample", "wastes", " up to {} of the samples"),
    "unreached": (
        "samples every direction that reflects",
        "albedo that is never sampled",
        ", up to {}",
    ),
    "float32": (
        "float32 values within 1e-5 of float64",
        "float32 values differ from float64",
        " by up to {}",
    ),
    "float32_density": (
        "float32 densities as near to float64 as values",
        "float32 densities differ from float64, beyond roundings of the directions,",
        " by up to {}",
    ),
    "numeric_albedo": ("albedos within 3e-5", "albedos", " within {}"),
}
