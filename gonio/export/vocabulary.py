"""What each function of `gonio.lang` means to the exporter: how many arguments, and the type of the result.

How a language spells it stands in `gonio.export.targets`; what a language lacks, in
`gonio.export.library`. Every function of `gonio.lang` has a row here, which a test compares.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from gonio.export.tree import Type

VECTORS: dict[str, int] = {"vec2": 2, "vec3": 3, "bool3": 3}


def widest(types: tuple[Type, ...]) -> Type:
    """The vector among some types, or a number."""
    for t in types:
        if t in ("vec2", "vec3"):
            return t
    return "float"


@dataclass(frozen=True)
class Rule:
    """A function of the vocabulary."""

    count: int
    result: Callable[[tuple[Type, ...]], Type] = widest
    splat: bool = True
    """Whether numbers among the arguments are repeated to the width of the vectors."""
    takes: tuple[Type, ...] = ("float", "vec3")
    """Types of the arguments."""


def _float(types: tuple[Type, ...]) -> Type:
    return "float"


RULES: dict[str, Rule] = {
    "minimum": Rule(2),
    "maximum": Rule(2),
    "clamp": Rule(3),
    "lerp": Rule(3),
    "absolute": Rule(1),
    "fract": Rule(1),
    "sqrt": Rule(1),
    "safe_sqrt": Rule(1),
    "smooth_sqrt": Rule(1),
    "safe_acos": Rule(1, takes=("float",)),
    "safe_asin": Rule(1, takes=("float",)),
    "twice_atan_over": Rule(1, takes=("float",)),
    "sin": Rule(1),
    "cos": Rule(1),
    "exp": Rule(1),
    "log": Rule(1),
    "power": Rule(2),
    "erf": Rule(1, takes=("float",)),
    "erfinv": Rule(1, takes=("float",)),
    "fma": Rule(3),
    "dot": Rule(2, _float, splat=False, takes=("vec3",)),
    "length": Rule(1, _float, takes=("vec3",)),
    "normalize": Rule(1, takes=("vec3",)),
    "polynomial": Rule(4, takes=("float",)),  # or more
    # Not per component; gonio.export.builtin_calls knows them by name.
    "select": Rule(3),
    "vec2": Rule(2),
    "vec3": Rule(3),
}
