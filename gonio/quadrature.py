"""Numeric albedos, for models that have no closed form.

Gauss–Legendre in angles: θi is split at θo, and the azimuth into quarters measured from wo's, because
that is where the published models have their kinks (max(θi, θo), and the sign of cos(φi − φo)). Nodes
crowd at θo from both sides, where a grazing wo makes the integrand steep.
"""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Any

import drjit as dr
import numpy as np

from gonio.lang import Color, Vec3, cos, safe_acos, sin, vec3

if TYPE_CHECKING:
    from gonio.model import Model

# Nodes on each smooth piece; tests/test_albedo.py holds the result against closed forms at 1e-5.
# Fewer leave more than float32 rounding.
THETA_NODES = 16
PHI_NODES = 8
CROWDING = 3


@functools.cache
def _table(Float: Any) -> tuple[Any, ...]:
    """Distance from θo, azimuth (cos, sin) and weight of every node, as Dr.Jit arrays."""
    x, w = np.polynomial.legendre.leggauss(THETA_NODES)
    x = (x + 1) / 2
    theta, theta_weight = x**CROWDING, CROWDING * x ** (CROWDING - 1) * w / 2
    x, w = np.polynomial.legendre.leggauss(PHI_NODES)
    phi = 0.5 * np.pi * (np.arange(4)[:, None] + (x + 1) / 2).ravel()
    phi_weight = np.tile(0.25 * np.pi * w, 4)
    columns = (
        np.repeat(theta, len(phi)),
        np.tile(np.cos(phi), len(theta)),
        np.tile(np.sin(phi), len(theta)),
        np.outer(theta_weight, phi_weight).ravel(),
    )
    return tuple(c.tolist() if Float is float else Float(c) for c in columns)


def _take(column: Any, index: Any) -> Any:
    return column[index] if isinstance(column, list) else dr.gather(type(column), column, index)


def directional_albedo(model: Model, wo: Vec3) -> Color:
    """∫ f μi dωi over the upper hemisphere, for a model that is already bound to Dr.Jit values."""
    Float: Any = type(wo.z)
    theta_o = safe_acos(wo.z)
    rho = dr.sqrt(dr.maximum(wo.x * wo.x + wo.y * wo.y, 1e-30))
    cos_o, sin_o = wo.x / rho, wo.y / rho
    table = _table(Float)
    count = len(table[0])

    def step(index: Any, total: Any) -> tuple[Any, Any]:
        node, c, s, weight = (_take(column, index) for column in table)
        for extent in (-theta_o, 0.5 * np.pi - theta_o):
            theta = theta_o + node * extent
            sin_theta, cos_theta = sin(theta), cos(theta)
            wi = vec3(
                sin_theta * (c * cos_o - s * sin_o),
                sin_theta * (s * cos_o + c * sin_o),
                cos_theta,
            )
            total += model.eval(wi, wo) * (sin_theta * cos_theta * weight * dr.abs(extent))
        return index + 1, total

    # One loop in the kernel instead of `count` copies of the model. Only its sum is carried along, so
    # max_iterations=-1 lets derivatives run it again instead of storing every step.
    zero = 0 * model.eval(wo, wo)
    index = 0 if Float is float else dr.uint32_array_t(Float)(0)
    _, total = dr.while_loop(
        (index, zero), lambda i, _: i < count, step, max_iterations=-1, label="albedo"
    )
    return total


def mean_albedo(model: Model) -> Color:
    """(1/π) ∫ albedo(wo) μo dωo of an isotropic model that is already bound to Dr.Jit values."""
    Float = model.float_type
    x, w = np.polynomial.legendre.leggauss(THETA_NODES)
    total: Any = 0
    for theta, weight in zip(0.25 * np.pi * (x + 1), 0.25 * np.pi * w, strict=True):
        s, c = float(np.sin(theta)), float(np.cos(theta))
        total += model.albedo(vec3(Float(s), Float(0), Float(c))) * float(2 * s * c * weight)
    return total
