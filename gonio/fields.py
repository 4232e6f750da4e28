"""What models declare: parameters and options, and the check of a value that a user gives."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from numbers import Real
from typing import Any

import drjit as dr
import numpy as np


class ModelError(ValueError):
    """An unknown model, parameter or option, or a value out of its range."""

    about: str = ""
    """The declaration or method of a class that is wrong, for whoever knows the class's file."""


def wrong(about: str, message: str) -> ModelError:
    """An error about a declaration or a method of a class."""
    error = ModelError(message)
    error.about = about
    return error


@dataclass
class Parameter:
    """A number or colour that a model takes, with its default, its allowed range and its meaning."""

    default: Any
    low: float
    high: float
    doc: str
    name: str = ""
    width: int = 1
    """1 for a Float, 3 for a Color."""
    rougher: Callable[[Any, Any], Any] | None = None
    """For widths of highlights: the value that is at least as rough as facets of a given alpha."""
    kind: str = ""
    """What the number is, where its name does not say so; see `gonio.export.manifest.kind`."""

    @property
    def lowest(self) -> float:
        """The lower end, or its float32 rounding where that is smaller."""
        return min(self.low, float(np.float32(self.low)))

    @property
    def highest(self) -> float:
        """The upper end, or its float32 rounding where that is larger: pi / 2 is, for example."""
        return max(self.high, float(np.float32(self.high)))

    def check(self, model: str, value: Any) -> Any:
        """Return a number or tuple of numbers that is in range, or an array as it is; else raise."""
        if is_array(value):
            return value
        values = tuple(value) if isinstance(value, (tuple, list)) else (value,)
        if not all(isinstance(v, Real) and not isinstance(v, bool) for v in values):
            raise ModelError(
                f"{model}: {self.name} must be a number"
                f"{' or three numbers' if self.width == 3 else ''}, got {value!r}; "
                f"allowed is {self.range_text()}."
            )
        if len(values) not in {1, self.width} or (
            isinstance(value, (tuple, list)) and self.width == 1
        ):
            raise ModelError(
                f"{model}: {self.name} takes {'one or three numbers' if self.width == 3 else 'one number'}"
                f", got {value!r}; allowed is {self.range_text()}."
            )
        values = tuple(rounded_end(float(v), self.low, self.high) for v in values)
        for v in values:
            if not self.lowest <= v <= self.highest:  # NaN fails this as well
                raise ModelError(
                    f"{model}: {self.name}={value!r} is out of range; allowed is {self.range_text()}."
                )
        return values if len(values) > 1 else values[0]

    def range_text(self) -> str:
        """The range for people, such as "0 to 1" or "at least 0"."""
        return (
            f"{self.low:.7g} to {self.high:.7g}"
            if math.isfinite(self.high)
            else f"at least {self.low:g}"
        )

    def is_default(self, value: Any) -> bool:
        """Whether a value is the default."""
        return not is_array(value) and bool(value == self.default)

    def key(self, value: Any) -> Any:
        """What two values share if and only if they are the same; arrays are if they are one object."""
        if is_array(value):
            return id(value)
        return value if isinstance(value, tuple) else (value,) * self.width

    def explained(self) -> str:
        """Meaning, range and default in one line."""
        return f"{self.doc}; {self.range_text()}, default {shown(self.default)}"


@dataclass
class Option:
    """A choice between variants of the code, fixed for each object."""

    values: tuple[str, ...]
    doc: str
    name: str = ""

    @property
    def default(self) -> str:
        """The first value."""
        return self.values[0]

    def check(self, model: str, value: Any) -> str:
        """Return the value if it is one of the allowed names, else raise."""
        if value not in self.values:
            raise ModelError(
                f"{model}: {self.name}={value!r} is not known; allowed are {', '.join(self.values)}."
            )
        return str(value)

    def is_default(self, value: Any) -> bool:
        """Whether a value is the default."""
        return bool(value == self.default)

    def key(self, value: str) -> str:
        """What two values share if and only if they are the same."""
        return value

    def range_text(self) -> str:
        """The allowed values for people."""
        return ", ".join(repr(value) for value in self.values)

    def explained(self) -> str:
        """Meaning, values and default in one line."""
        return f"{self.doc}; {self.range_text()}; default {self.default!r}"


def shown(value: Any) -> str:
    """A parameter's value in a few characters: numbers with seven digits, arrays by their shape."""
    if is_array(value):
        return f"array of shape {tuple(value.shape)}"
    if isinstance(value, tuple):
        return f"({', '.join(map(shown, value))})"
    return f"{value:.7g}" if isinstance(value, float) else repr(value)


def few_digits(values: Any) -> list[float]:
    """Python numbers that print as few digits as the precision of an array, shape (n,), needs."""
    return [float(str(x)) for x in np.asarray(values)]


# Digits with which people write an end of a range that has no short decimal: 1.571, 1.5708 for pi / 2.
ROUNDED_DIGITS = range(4, 9)


def rounded_end(value: float, low: float, high: float) -> float:
    """The end of a range that a value outside is the rounding of; else the value."""
    if low <= value <= high:
        return value
    for end in (low, high):
        if any(value == float(f"{end:.{digits}g}") for digits in ROUNDED_DIGITS):
            return end
    return value


def is_array(value: Any) -> bool:
    """Whether a value is an array of a framework gonio knows (NumPy scalars and lists are not)."""
    return framework(value) is not None


def framework(value: Any) -> str | None:
    """Name of an array's framework (drjit, torch, jax, numpy), None for everything else."""
    if dr.is_array_v(value):
        return "drjit"
    if isinstance(value, np.ndarray):
        return "numpy"
    module = type(value).__module__.partition(".")[0]
    if module == "torch" and hasattr(value, "requires_grad"):
        return "torch"
    if module in {"jax", "jaxlib"} and hasattr(value, "dtype"):
        return "jax"
    return None
