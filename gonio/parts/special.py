"""What plain arithmetic loses digits of: logarithms near 1, exp(x) - 1 near x = 0, sums that cancel."""

import math

from gonio.lang import MU_MIN, Float, Vec3, exp, log, maximum, minimum, polynomial, select
from gonio.parts.frame import tangent2

# Below this the series needs few terms; above, the plain logarithm of 1 + x is exact to 2e-7 in float32.
LOG1P_SMALL = 0.25

# Below this the series needs few terms; above, the plain difference is exact to 2e-7 in float32.
EXPM1_SMALL = 0.3

# 1 / 2!, 1 / 3!, ...; in double precision the series below are off by 2e-15 and 1e-16 at most.
INVERSE_FACTORIALS = tuple(1 / math.factorial(n) for n in range(2, 12))


def log1p_over(x: Float) -> Float:
    """log(1 + x) / x for x > -1; 1 at x = 0."""
    near = maximum(minimum(x, LOG1P_SMALL), -LOG1P_SMALL)
    small = (x > -LOG1P_SMALL) & (x < LOG1P_SMALL)
    far = select(small, 1, x)
    series = _atanh_over(near / (2 + near))
    return select(small, 2 / (2 + near) * series, log(1 + far) / far)


def log1p_small(x: Float) -> Float:
    """log(1 + x) for x from -LOG1P_SMALL to LOG1P_SMALL."""
    y = x / (2 + x)
    return 2 * y * _atanh_over(y)


def _atanh_over(y: Float) -> Float:
    """atanh(y) / y for |y| < 1 / 7; with y = x / (2 + x) it is half of log(1 + x)."""
    y2 = y * y
    return polynomial(y2, 1 / 49, 1, 1 / 3, 1 / 5, 1 / 7, 1 / 9, 1 / 11, 1 / 13, 1 / 15, 1 / 17)


def log1p(x: Float) -> Float:
    """log(1 + x) for x > -1, exact where x is small."""
    return x * log1p_over(x)


def log_cos(m: Vec3) -> Float:
    """log(m.z) of a unit vector that is not below the horizon, exact where it is near the normal."""
    # log(cos) = -atanh(sin^2 / (1 + cos^2)): a sharp lobe needs the digits of the sine, not of the cosine
    sin2 = m.x * m.x + m.y * m.y
    y = sin2 / (1 + m.z * m.z)
    return select(sin2 < LOG1P_SMALL, -y * _atanh_over(y), log(maximum(m.z, MU_MIN)))


def log_cos_along(h: Vec3) -> Float:
    """log(cos) of the angle between the normal and h, which need not be unit."""
    # log(cos) = -log(1 + tan^2) / 2 = -atanh(y)
    tan2 = tangent2(h)
    y = tan2 / (2 + tan2)
    return select(tan2 < LOG1P_SMALL, -y * _atanh_over(y), -0.5 * log(1 + tan2))


def expm1(x: Float) -> Float:
    """exp(x) - 1, exact where x is small."""
    near = maximum(minimum(x, EXPM1_SMALL), -EXPM1_SMALL)
    # Taylor's series
    over = polynomial(near, EXPM1_SMALL, 1, *INVERSE_FACTORIALS)
    return select((x > -EXPM1_SMALL) & (x < EXPM1_SMALL), near * over, exp(x) - 1)


def sum3(a: Float, b: Float, c: Float) -> Float:
    """a + b + c with the rounding error of a + b carried along (Knuth), for a c that cancels it."""
    ab = a + b
    back = ab - a
    error = (a - (ab - back)) + (b - back)
    return (ab + c) + error
