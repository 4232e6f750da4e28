"""What shading languages lack, written in the vocabulary and exported where it is needed.

Arc cosine and sine are here because the builtin ones of graphics drivers may be off by 4e-4. These are
exact to 3e-7, at up to twice the time of the builtin alone (docs/performance.md). All are for float32.
"""

from gonio.lang import (
    MU_MIN,
    PI,
    Color,
    Float,
    Vec3,
    absolute,
    clamp,
    exp,
    fract,
    log,
    maximum,
    minimum,
    safe_sqrt,
    select,
    sqrt,
    twice_atan_fit,
    vec2,
    vec3,
)
from gonio.model import Model

# Steps of the rule in `sampled_albedo`: a Fibonacci number, and the golden ratio.
ALBEDO_SAMPLES = 987
GOLDEN = 0.6180339887498949

# Cosine that stands for wo in the horizon, where a sample has no density but the albedo a limit.
HORIZON = 1e-6

# 2 atan(v) / v in v^2 on [0, 1]; fitted, relative error below 2e-8.
ATAN_0, ATAN_1, ATAN_2, ATAN_3, ATAN_4, ATAN_5, ATAN_6, ATAN_7, ATAN_8 = twice_atan_fit

# erf(x) / x in x^2 below ERF_NEAR, relative error 1.2e-8; above, erfc(x) exp(x^2) in t = 1 / (1 + ERF_P x),
# absolute error of erf 3e-10. Fitted.
ERF_NEAR, ERF_P = 0.9, 0.47
ERF_0, ERF_1, ERF_2 = 1.128379154, -0.3761252327, 0.1128214077
ERF_3, ERF_4, ERF_5 = -0.02677890761, 0.005011961002, -0.0006090351104
ERFC_1, ERFC_2, ERFC_3 = 0.2627345196, 0.2854649797, 0.1743749649
ERFC_4, ERFC_5, ERFC_6 = 0.2435054861, 0.1368199822, -0.1032009059


def twice_atan_over(v: Float) -> Float:
    """2 atan(v) / v for v in [-1, 1], the angle whose half has the tangent v; 2 at v = 0."""
    q = v * v
    p = ATAN_4 + q * (ATAN_5 + q * (ATAN_6 + q * (ATAN_7 + q * ATAN_8)))
    return ATAN_0 + q * (ATAN_1 + q * (ATAN_2 + q * (ATAN_3 + q * p)))


def safe_asin(x: Float) -> Float:
    """Arc sine of x limited to [-1, 1]: twice the angle whose tangent is x / (1 + cos)."""
    c = safe_sqrt((1 - x) * (1 + x))
    v = clamp(x / (1 + c), -1, 1)
    return v * twice_atan_over(v)


def safe_acos(x: Float) -> Float:
    """Arc cosine of x limited to [-1, 1]: twice the angle whose tangent is sin / (1 + x)."""
    a = minimum(absolute(x), 1)
    v = safe_sqrt((1 - a) * (1 + a)) / (1 + a)
    angle = v * twice_atan_over(v)
    return select(x < 0, PI - angle, angle)


def erf(x: Float) -> Float:
    """Error function 2 / sqrt(pi) times the integral of exp(-t^2) over t in [0, x]."""
    a = absolute(x)
    near = minimum(a, ERF_NEAR)
    q = near * near
    p = near * (ERF_0 + q * (ERF_1 + q * (ERF_2 + q * (ERF_3 + q * (ERF_4 + q * ERF_5)))))
    # exp(-a^2) is 0 from there on, and the limit keeps a^2 in range
    far = minimum(a, 10)
    t = 1 / (1 + ERF_P * far)
    c = ERFC_1 + t * (ERFC_2 + t * (ERFC_3 + t * (ERFC_4 + t * (ERFC_5 + t * ERFC_6))))
    value = select(a < ERF_NEAR, p, 1 - exp(-far * far) * t * c)
    return select(x < 0, -value, value)


def erfinv(x: Float) -> Float:
    """Inverse of `erf`. Giles, "Approximating the erfinv function", GPU Computing Gems, 2012, single."""
    w = -log(maximum((1 - x) * (1 + x), MU_MIN))
    c = minimum(w, 5) - 2.5
    p = 3.43273939e-07 + 2.81022636e-08 * c
    p = -4.39150654e-06 + (-3.5233877e-06 + p * c) * c
    p = -0.00125372503 + (0.00021858087 + p * c) * c
    p = 1.50140941 + (0.246640727 + (-0.00417768164 + p * c) * c) * c
    t = sqrt(maximum(w, 5)) - 3
    q = 0.000100950558 - 0.000200214257 * t
    q = -0.00367342844 + (0.00134934322 + q * t) * t
    q = -0.0076224613 + (0.00573950773 + q * t) * t
    q = 2.83297682 + (1.00167406 + (0.00943887047 + q * t) * t) * t
    return x * select(w < 5, p, q)


def sampled_albedo(model: Model, wo: Vec3) -> Color:
    """Directional albedo of a model without a closed form: the mean weight of its own samples.

    For tables and previews; the random numbers are a Fibonacci lattice.
    """
    w = vec3(wo.x, wo.y, maximum(wo.z, HORIZON))
    total = vec3(0, 0, 0)
    for i in range(ALBEDO_SAMPLES):
        u = vec2((i + 0.5) / ALBEDO_SAMPLES, fract((i + 0.5) * GOLDEN))
        drawn = model.sample(w, u)
        weight = select(drawn.pdf > 0, drawn.wi.z / maximum(drawn.pdf, MU_MIN), 0)
        total = total + model.eval(drawn.wi, w) * weight
    return total / ALBEDO_SAMPLES
