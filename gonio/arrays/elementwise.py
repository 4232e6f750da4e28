"""Parts of models on NumPy arrays.

Parts such as `gonio.parts.fresnel.F_conductor` are written for Dr.Jit; this evaluates one on arrays:

    from gonio.arrays.elementwise import elementwise
    from gonio.parts.fresnel import F_dielectric
    F = elementwise(F_dielectric, np.linspace(0, 1, 5), 1.5)
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gonio import backend


def elementwise(function: Callable[..., Any], *values: ArrayLike) -> NDArray[np.float64]:
    """A function of numbers on arrays, which broadcast as NumPy's do; computed in double precision."""
    arrays = np.broadcast_arrays(*(np.asarray(value, np.float64) for value in values))
    shape = arrays[0].shape
    if backend.current() == "scalar":
        flat = [
            function(*map(float, row)) for row in zip(*(a.ravel() for a in arrays), strict=True)
        ]
        return np.array(flat, np.float64).reshape(shape)
    Float = backend.array_module().Float64
    result = function(*(Float(np.ascontiguousarray(a.ravel())) for a in arrays))
    # A function that ignores its arguments gives one number.
    return np.broadcast_to(np.asarray(Float(result).numpy(), np.float64), arrays[0].size).reshape(
        shape
    )
