"""Arrays in, the same kind out: NumPy, PyTorch, JAX and Dr.Jit around one kernel.

The component comes last, (..., 3), and everything broadcasts as in NumPy. Data enter Dr.Jit without a
copy where the frameworks allow it; broadcasting, the reordering of components and the checks of values
happen inside the model's own kernel, so that each array is read once.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from gonio.arrays.drjit import call_drjit
from gonio.arrays.jax import call_jax
from gonio.arrays.kernel import DIRECTION_NAMES, Evaluated, Kernel
from gonio.arrays.leaf import Leaf
from gonio.arrays.numpy import call_numpy
from gonio.arrays.torch import call_torch
from gonio.fields import framework, is_array


def call(model: Evaluated, method: str, directions: Sequence[Any]) -> Any:
    """Evaluate a model's method on arrays of any framework and return the same kind.

    Raises:
        ValueError: wrong shapes; with validation on, also values that are not allowed.
    """
    leaves = [
        Leaf(name, 2 if name == "u" else 3, "random" if name == "u" else "direction")
        for name in DIRECTION_NAMES[method]
    ]
    values = [
        v if is_array(v) else _from_numbers(v, leaf)
        for v, leaf in zip(directions, leaves, strict=True)
    ]
    slots: dict[str, int] = {}
    for path, declared, value in model.parameters():
        if is_array(value):
            width = declared.width
            if width == 3 and framework(value) != "drjit" and value.shape[-1:] == (1,):
                width, value = 1, value[..., 0]  # a grey colour, such as (100, 1)
            slots[path] = len(leaves)
            leaves.append(Leaf(path, width, "parameter", declared.lowest, declared.highest))
            values.append(value)
    kinds = {framework(v) for v in values}
    foreign = kinds - {"numpy"}
    if len(foreign) > 1:
        raise ValueError(
            f"{model.name}.{method} got arrays of {' and '.join(sorted(map(str, foreign)))} together; "
            "convert them to one framework."
        )
    kernel = Kernel(model, method, leaves, slots)
    kind = foreign.pop() if foreign else "numpy"
    return {"numpy": call_numpy, "torch": call_torch, "jax": call_jax, "drjit": call_drjit}[
        str(kind)
    ](kernel, values)


def _from_numbers(value: Any, leaf: Leaf) -> np.ndarray[Any, Any]:
    try:
        return np.asarray(value, np.float32)
    except (TypeError, ValueError):
        raise ValueError(
            f"{leaf.name} must be an array or numbers with {leaf.width} components last, "
            f"got {type(value).__name__}."
        ) from None
