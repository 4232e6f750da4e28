"""The horizon, at which every model is zero: guards around what a model's file writes, and nowhere else.

Directions in it or below are replaced by the normal before the model sees them: the values are masked
anyway, and their derivatives stay finite that way. `gonio.model` puts the guards around the methods.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import drjit as dr

from gonio.lang import MU_MIN, Color, Sample, Vec2, Vec3, select, vec3

# Where derivatives end: they are 0 below this cosine, down to the horizon. The sharpest facets, of width
# 1e-4 and with V-cavities, reflect D / (4 mu^2) = 8e6 / mu^2 where both directions graze. Turning one tilts
# the half vector by 1 / (2 mu) as much, and D changes by its 1 / alpha: the slope is 4e10 / mu^3, which
# leaves a float32 below 5e-10. The products on the way to it, as reverse mode forms them, do so below
# 1.3e-8.
MU_STEEP = 1e-7


def _guard_eval(method: Any, model: Any, wi: Vec3, wo: Vec3) -> Color:
    above_i, above_o = wi.z > MU_MIN, wo.z > MU_MIN
    value = method(model, _upwards(above_i, wi), _upwards(above_o, wo))
    value = _steady((wi.z > MU_STEEP) & (wo.z > MU_STEEP), value)
    # A number of the kernel's type, in which a constant value is then returned
    return select(above_i & above_o, value, type(wi.z)(0))


def _guard_sample(method: Any, model: Any, wo: Vec3, u: Vec2) -> Sample:
    above = wo.z > MU_MIN
    wi, pdf = method(model, _upwards(above, wo), u)
    wi, pdf = _steady(wo.z > MU_STEEP, wi), _steady(wo.z > MU_STEEP, pdf)
    return Sample(wi, select(above & (wi.z > MU_MIN), pdf, 0))


def _guard_albedo(method: Any, model: Any, wo: Vec3) -> Color:
    above = wo.z >= 0  # the albedo has a limit at the horizon
    return select(above, method(model, _upwards(above, wo)), type(wo.z)(0))


def _steady(condition: Any, value: Any) -> Any:
    """A value without its derivative where the condition does not hold."""
    return select(condition, value, dr.detach(value)) if dr.grad_enabled(value) else value


def _upwards(above: Any, w: Vec3) -> Vec3:
    return vec3(select(above, w.x, 0), select(above, w.y, 0), select(above, w.z, 1))


def _guard_mean(method: Any, model: Any) -> Color:
    return method(model)  # no direction that could be below


GUARDS: dict[str, Callable[..., Any]] = {
    "eval": _guard_eval,
    "sample": _guard_sample,
    "pdf": _guard_eval,
    "albedo": _guard_albedo,
    "mean_albedo": _guard_mean,
}
"""The guard around each method: it takes the method as written, the bound model, and the directions."""
