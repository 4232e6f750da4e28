"""Lights on arrays: what exported shaders compute, in Python.

from gonio.lights.shading import shade
shade(model, ["directional"], normals, tangents, views, light=(0, 1, 0), irradiance=(3, 3, 3))
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gonio.arrays.functions import applied
from gonio.fields import ModelError
from gonio.lights.catalogue import Chosen, chosen
from gonio.lights.frames import normal_frame, surface_frame
from gonio.lights.lookups import Lookups
from gonio.model import Model


def shade(
    model: Model,
    lights: Sequence[str],
    normal: ArrayLike,
    tangent: ArrayLike,
    view: ArrayLike,
    *,
    host: Lookups | None = None,
    dtype: type[np.generic] = np.float64,
    **given: ArrayLike,
) -> NDArray[Any]:
    """Radiance towards the viewer: the function `shade` of a lit export.

    Args:
        model: whose parameters may be arrays of the points' number.
        lights: of `gonio.lights`, with their choices, as `gonio export --lit` takes them.
        normal: shape (points, 3) or (3,), in the world; need not be unit.
        tangent: the same; (0, 0, 0) where there is none.
        view: unit, towards the viewer.
        host: what looks up pictures and tables, for lights that ask for them.
        dtype: in which it is computed.
        given: what the lights take, such as light=..., irradiance=..., sky=...; nine harmonics have the
            shape (9, 3) or (points, 9, 3).

    Returns:
        Shape (points, 3).

    Raises:
        ModelError: a light that is not there or that the model cannot have, or a missing argument.
    """
    taken = chosen(model, lights)
    kinds: dict[str, Any] = {}
    for light in taken:
        kinds |= light.form.arguments
        if light.form.looks_up and host is None:
            raise ModelError(
                f"the light {light.form.light!r} looks up pictures or tables; give host=."
            )
    if set(kinds) != set(given):
        raise ModelError(f"these lights take {', '.join(kinds)}; got {', '.join(given) or 'none'}.")
    columns = [_columns(v, 1) for v in (normal, tangent, view)]
    places: dict[str, slice] = {}
    for name, kind in kinds.items():
        fields = getattr(kind, "_fields", (name,))
        places[name] = slice(len(columns), len(columns) + len(fields))
        columns += _split(given[name], len(fields))

    follows = model.follows_tangents()

    def run(bound: Any, *values: Any) -> Any:
        frame = surface_frame(values[0], values[1]) if follows else normal_frame(values[0])
        wo = frame.to_local(values[2])
        total = 0
        for light in taken:
            own = [_made(kinds[n], values[places[n]]) for n in light.form.arguments]
            total = total + _called(light, bound, frame, wo, own, host)
        return total

    return applied(run, model, columns, dtype=dtype)


def _called(
    light: Chosen, model: Any, frame: Any, wo: Any, own: Sequence[Any], host: Lookups | None
) -> Any:
    named = dict(zip(light.form.arguments, own, strict=True)) | dict(light.choices)
    if light.form.looks_up:
        named["host"] = host
    return light.form.function(model, frame, wo, **named)


def _made(kind: Any, values: Sequence[Any]) -> Any:
    return kind(*values) if hasattr(kind, "_fields") else values[0]


def _columns(value: ArrayLike, least: int) -> NDArray[Any]:
    array = np.asarray(value)
    return array if array.ndim > least else array[None]


def _split(value: ArrayLike, count: int) -> list[NDArray[Any]]:
    """An argument as the columns that it is made of."""
    if count == 1:
        array = np.asarray(value)
        return [array[None] if array.ndim in (0, 1) and array.shape in ((), (3,)) else array]
    array = _columns(value, 2)
    if array.shape[-2:] != (count, 3):
        raise ModelError(f"harmonics have the shape ({count}, 3), got {np.shape(value)}.")
    return [array[:, i] for i in range(count)]
