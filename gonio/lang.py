"""The vocabulary in which models are written: types, constants and functions.

A model file uses these names and Python's arithmetic, nothing else, so that the same text can be
evaluated by Dr.Jit and translated into shading languages. Every function takes Dr.Jit arrays or
Python numbers and works per component on vectors, unless it says otherwise. All of them stay finite,
and have finite derivatives, wherever their description says so.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, NamedTuple

import drjit as dr

from gonio.polynomials import terms_in_single

# Types are names for the reader, the checker of parameters and the translator. Values are Dr.Jit
# arrays of any backend and precision (or Python numbers), hence Any for type checkers.
Float = Annotated[Any, "float"]
Vec2 = Annotated[Any, "vec2"]
Vec3 = Annotated[Any, "vec3"]
Color = Annotated[Any, "color"]
Mask = Annotated[Any, "mask"]


class Sample(NamedTuple):
    """A sampled direction and its density: what every model's `sample` returns."""

    wi: Vec3
    """Direction towards the light, unit, local frame, shape (..., 3)."""
    pdf: Float
    """Density of `wi` in 1/sr, shape (...); 0 marks a wasted sample."""


PI = 3.141592653589793
TWO_PI = 2 * PI
INV_PI = 1 / PI
INV_TWO_PI = 1 / TWO_PI

# Where the horizon begins: eval, pdf and sample see no smaller cosine, and are 0 there. So a quotient
# 1 / mu and its derivative fit in a float32, and the half vector of two directions has a length.
MU_MIN = 1e-18  # cosine of the horizon


def vec2(x: Float, y: Float) -> Vec2:
    """Two numbers as a vector."""
    return _vector((x, y))


def vec3(x: Float, y: Float, z: Float) -> Vec3:
    """Three numbers as a vector."""
    return _vector((x, y, z))


def _vector(components: tuple[Any, ...]) -> Any:
    number = dr.expr_t(*components)
    shape = (len(components),)
    if not dr.is_array_v(number):
        return (dr.scalar.Array2f64, dr.scalar.Array3f64)[len(components) - 2](*components)
    return dr.replace_shape_t(number, (*shape, -1))(*components)


def minimum(a: Any, b: Any) -> Any:
    """The smaller of two values."""
    return dr.minimum(a, b)


def maximum(a: Any, b: Any) -> Any:
    """The larger of two values."""
    return dr.maximum(a, b)


def clamp(x: Any, low: Any, high: Any) -> Any:
    """`x` limited to [low, high]."""
    return dr.clip(x, low, high)


def lerp(a: Any, b: Any, t: Any) -> Any:
    """a (1 − t) + b t."""
    return dr.lerp(a, b, t)


def select(condition: Mask, yes: Any, no: Any) -> Any:
    """`yes` where the condition holds, else `no`. Both are computed, so both have to be finite.

    Of two Python numbers the result has single precision.
    """
    if type(yes) is int and type(no) is int:  # they would become integers, which have no sine
        return dr.select(condition, float(yes), float(no))
    return dr.select(condition, _like(no, yes), _like(yes, no))


def _like(other: Any, value: Any) -> Any:
    """A vector of Python numbers in the precision of the vector or number that it stands beside."""
    if not dr.is_array_v(value) or dr.is_jit_v(value) or not dr.is_jit_v(other):
        return value
    if dr.depth_v(other) > 1:
        return type(other)(value)
    # Not type(other)(value), which takes the components for as many rows
    return dr.replace_shape_t(other, (len(value), -1))(*value)


def absolute(x: Any) -> Any:
    """|x|."""
    return dr.abs(x)


def fract(x: Any) -> Any:
    """What is left of `x` above the next lower whole number, in [0, 1)."""
    return x - dr.floor(x)


def sqrt(x: Any) -> Any:
    """Square root of a value that is greater than zero."""
    return dr.sqrt(x)


def safe_sqrt(x: Any) -> Any:
    """Square root; 0 for negative values, and a finite derivative at 0."""
    return dr.safe_sqrt(x)


def smooth_sqrt(x: Any) -> Any:
    """Square root of a value that is not negative, with a finite derivative at 0.

    NaN of a negative one, as in shaders.
    """
    return dr.select(x < 0, math.nan, dr.safe_sqrt(x))


def safe_acos(x: Any) -> Any:
    """Arc cosine of `x` limited to [−1, 1], with a finite derivative at both ends."""
    return dr.safe_acos(x)


def safe_asin(x: Any) -> Any:
    """Arc sine of `x` limited to [−1, 1], with a finite derivative at both ends."""
    return dr.safe_asin(x)


# The next function in v² for single precision, from the lowest power on; fitted, relative error below 2e-8.
twice_atan_fit = (
    *(1.99999997, -0.6666614668, 0.3998523874),
    *(-0.284072885, 0.2128186638, -0.1500858548),
    *(0.08538299588, -0.03213723158, 0.005699772642),
)


def twice_atan_over(v: Any) -> Any:
    """2 atan(v) / v for `v` in [−1, 1], the angle whose half has the tangent `v`; 2 at v = 0."""
    if _is_single(v):
        return polynomial(v * v, 1, *twice_atan_fit)
    zero = v == 0
    return dr.select(zero, 2, 2 * dr.atan(v) / dr.select(zero, 1, v))


def sin(x: Any) -> Any:
    """Sine of an angle in radians."""
    return dr.sin(x)


def cos(x: Any) -> Any:
    """Cosine of an angle in radians."""
    return dr.cos(x)


def exp(x: Any) -> Any:
    """Natural exponential."""
    return dr.exp(x)


def log(x: Any) -> Any:
    """Natural logarithm of a value that is greater than zero."""
    return dr.log(x)


def power(x: Any, exponent: Any) -> Any:
    """`x` to a power, for x greater than zero; with a whole number as exponent, for any x."""
    found = dr.power(x, exponent)
    if isinstance(exponent, (int, float)) and float(exponent).is_integer():
        return found  # products, which have a sign
    # Dr.Jit has -inf in double precision where the result is below 2^-1022
    return dr.maximum(found, 0)


def erf(x: Any) -> Any:
    """Error function 2 / sqrt(pi) times the integral of exp(-t^2) over t in [0, x]."""
    return dr.erf(x)


def erfinv(x: Any) -> Any:
    """Inverse of `erf` for x in (-1, 1), to 1e-7; its slope has no bound at the ends."""
    return dr.erfinv(x)


def fma(a: Any, b: Any, c: Any) -> Any:
    """a b + c with a single rounding where the machine can."""
    return dr.fma(a, b, c)


def polynomial(x: Any, bound: float, c0: float, c1: float, *further: float) -> Any:
    """c0 + c1 x + c2 x² + … for `x` in [−bound, bound].

    Single precision, which shaders have, leaves out the last terms where their sum is below its digits.
    """
    coefficients = (c0, c1, *further)
    count = terms_in_single(bound, coefficients) if _is_single(x) else len(coefficients)
    value: Any = coefficients[count - 1]
    for coefficient in coefficients[count - 2 :: -1]:
        value = dr.fma(value, x, coefficient)
    return value


def _is_single(x: Any) -> bool:
    return bool(dr.is_array_v(x) and dr.type_v(x) == dr.VarType.Float32)


def dot(a: Vec3, b: Vec3) -> Float:
    """Inner product."""
    return dr.dot(a, b)


def length(v: Vec3) -> Float:
    """Euclidean length of a vector that is not zero."""
    return dr.norm(v)


def normalize(v: Vec3) -> Vec3:
    """`v` scaled to unit length; `v` must not be zero."""
    return dr.normalize(v)
