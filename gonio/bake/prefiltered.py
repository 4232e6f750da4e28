"""A host of lights in Python: what exported shaders look up, from baked pictures and tables."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from gonio.bake.cube import Cube
from gonio.bake.split_sum import look_up
from gonio.lang import Color, Float, Vec2, Vec3
from gonio.lights.lookups import Lookups


@dataclass(frozen=True)
class Prefiltered(Lookups):
    """A cube and a table, looked up as a graphics card does.

    host = Prefiltered(prefiltered(sky), split_sum_table(model))
    gonio.lights.shading.shade(model, ["image"], ..., sky=sky.harmonics(), host=host)
    """

    cube: Cube
    table: NDArray[Any]

    def environment(self, direction: Vec3, alpha: Float) -> Color:
        """From the cube."""
        w = np.asarray(direction.numpy(), np.float64).reshape(3, -1).T
        width = np.broadcast_to(np.asarray((alpha + 0 * direction.x).numpy()), len(w))
        return _vector(direction.x, self.cube.radiance(w, width))

    def split_sum(self, mu: Float, alpha: Float) -> Vec2:
        """From the table."""
        return _vector(mu, look_up(self.table, mu.numpy(), (alpha + 0 * mu).numpy()))


def _vector(like: Any, rows: NDArray[Any]) -> Any:
    number = type(like)
    kind = dr.replace_shape_t(number, (rows.shape[1], -1))
    return kind(*(number(np.ascontiguousarray(c)) for c in rows.T))
