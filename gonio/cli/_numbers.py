"""Options that are numbers: all of them are finite, and a wrong one is told what is allowed."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import click


class Number(click.ParamType[float]):
    """A finite number, from a range where it has one."""

    name = "number"

    def __init__(
        self, low: float = -math.inf, high: float = math.inf, *, above: bool = False
    ) -> None:
        self.low, self.high = low, high
        self.above = above
        """Whether `low` itself is too low."""

    def convert(self, value: Any, param: Any, ctx: Any) -> float:
        """The number."""
        try:
            number = float(value)
        except ValueError:
            number = math.nan
        if not math.isfinite(number) or not self._has(number):
            few = "; too few numbers stand before it" if str(value).startswith("--") else ""
            self.fail(f"{value} is not {self._allowed()}{few}", param, ctx)
        return number

    def _has(self, number: float) -> bool:
        return self.low <= number <= self.high and not (self.above and number == self.low)

    def _allowed(self) -> str:
        if math.isfinite(self.high):
            ends = "above {:g}, up to {:g}" if self.above else "from {:g} to {:g}"
            return f"a number {ends.format(self.low, self.high)}"
        if self.above:
            return f"a finite number above {self.low:g}"
        least = f" of {self.low:g} or more" if math.isfinite(self.low) else ""
        return f"a finite number{least}"


class Numbers(click.ParamType[tuple[float, ...]]):
    """Finite numbers with commas between them."""

    name = "numbers"

    def __init__(self, what: str, allowed: Callable[[tuple[float, ...]], bool]) -> None:
        """`what` they are, with an example, for messages; `allowed` says whether they are that."""
        self.what, self.allowed = what, allowed

    def convert(self, value: Any, param: Any, ctx: Any) -> tuple[float, ...]:
        """The numbers."""
        if isinstance(value, tuple):
            return value
        try:
            found = tuple(float(piece) for piece in str(value).split(","))
        except ValueError:
            found = (math.nan,)
        if not all(map(math.isfinite, found)) or not self.allowed(found):
            self.fail(f"{str(value)!r} is not {self.what}", param, ctx)
        return found


VIEW = Numbers(
    "AZIMUTH,ELEVATION in degrees, such as 30,20, with an elevation from -90 to 90",
    lambda found: len(found) == 2 and abs(found[1]) <= 90,
)
POLAR_ANGLES = Numbers(
    "a list of degrees from 0 to less than 90, such as 0,30,60",
    lambda found: all(0 <= angle < 90 for angle in found),
)
AZIMUTHS = Numbers("a list of degrees, such as 0,90", lambda found: True)
