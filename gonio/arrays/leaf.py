"""One array that goes into a kernel, and what is allowed in it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import drjit as dr
import numpy as np

# Accepted deviation of |w|² from 1: a hundred times the rounding of a float32 normalisation, and small
# enough that no model's value moves visibly.
UNIT_TOLERANCE = 1e-4


@dataclass(frozen=True)
class Leaf:
    """One array that goes into a kernel: what it is called, its width, and what is allowed in it."""

    name: str
    width: int
    kind: str
    """One of direction, random, parameter."""
    low: float = -math.inf
    high: float = math.inf


def allowed(leaf: Leaf, value: Any) -> Any:
    """A mask that is true where a value is allowed; NaN fails every comparison."""
    if leaf.kind == "direction":
        return dr.abs(dr.squared_norm(value) - 1) <= UNIT_TOLERANCE
    low, high = (0, 1) if leaf.kind == "random" else (leaf.low, leaf.high)
    inside = (value >= low) & (value <= high)
    return inside if leaf.width == 1 else dr.all(inside, axis=0)


def complaint(leaf: Leaf, array: np.ndarray[Any, Any]) -> str:
    """The sentence for the first value of `array` that is not allowed."""
    array = np.asarray(array, np.float64)
    if leaf.kind == "direction":
        with np.errstate(invalid="ignore", over="ignore"):
            bad = ~(np.abs(np.sum(array**2, -1) - 1) <= UNIT_TOLERANCE)
        index = tuple(int(i) for i in np.argwhere(bad)[0])
        w = array[index]
        at = f"{leaf.name}[{', '.join(map(str, index))}]" if index else leaf.name
        if not np.isfinite(w).all():
            return f"{at} = {w.tolist()} is not finite; directions are unit vectors."
        norm = float(np.linalg.norm(w))
        return (
            f"{at} = {w.tolist()} has length {norm:.6g}; directions are unit vectors: "
            f"divide by np.linalg.norm({leaf.name}, axis=-1, keepdims=True)."
        )
    low, high = (0.0, 1.0) if leaf.kind == "random" else (leaf.low, leaf.high)
    bad = ~((array >= low) & (array <= high))
    index = tuple(int(i) for i in np.argwhere(bad)[0])
    at = f"{leaf.name}[{', '.join(map(str, index))}]" if index else leaf.name
    allowed = f"{low:.7g} to {high:.7g}" if math.isfinite(high) else f"at least {low:g}"
    return f"{at} = {float(array[index])!r} is out of range; allowed is {allowed}."
