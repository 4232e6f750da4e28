"""Fresnel reflectance and its approximations.

cos_theta is the cosine at which light meets the (micro)surface, in [0, 1]. Reflectances are those of
unpolarised light. eta is the relative index n_inside / n_outside, k the extinction over n_outside; both
may be numbers or colours.
"""

from typing import NamedTuple

from gonio.lang import (
    Color,
    Float,
    Vec3,
    absolute,
    fma,
    maximum,
    select,
    smooth_sqrt,
    sqrt,
)
from gonio.parts.frame import cos_half, sin2_half

# Smallest value whose square root is taken: the root's derivative, 5e7, still leaves room in a float32.
# It is reached at the edge of total internal reflection, where the true derivative is infinite.
ROOT_MIN = 1e-16

# A trace of absorption, which keeps a conductor's roots from 0, and their squares from where GPUs take them
# for 0. By itself it reflects where the index is matched in the horizon, (ABSORPTION_MIN / (2 mu^2))^2.
ABSORPTION_MIN = 1e-17

# Brings numbers from 1e-17 to 1e7, and what their derivatives need, to where squares are float32 numbers.
SIZE_SCALE = 2.0**40

# Cosine from which on the square of the sine is the smaller of the two, and keeps the digits.
NEAR_NORMAL = 0.75


def schlick_weight(cos_theta: Float) -> Float:
    """(1 - cos_theta)^5 of Schlick's approximation."""
    k = 1 - cos_theta
    k2 = k * k
    return k2 * k2 * k


def F_schlick(cos_theta: Float, f0: Color, f90: Color) -> Color:
    """Schlick, "An inexpensive BRDF model for physically-based rendering", 1994, Eq. 15, with an F90."""
    return F_schlick_half(cos_theta, _sin2(cos_theta), f0, f90)


def F_schlick_half(cos_h: Float, sin2_h: Float, f0: Color, f90: Color) -> Color:
    """Schlick's F at a facet, from cosine and squared sine there: f0 may be 0, and all is the weight."""
    return f0 * schlick_complement(cos_h) + f90 * _weight(cos_h, sin2_h)


def F_dielectric(cos_theta: Float, eta: Color) -> Color:
    """Exact reflectance of a dielectric. Below eta = 1 all light is reflected past the critical angle."""
    return F_dielectric_half(cos_theta, _sin2(cos_theta), eta)


def F_dielectric_half(cos_h: Float, sin2_h: Float, eta: Color) -> Color:
    """Exact reflectance of a dielectric at a facet, from cosine and squared sine of the angle there."""
    # Of a small index little but eta^2 - sin^2 is left near the normal
    g2 = select(cos_h > NEAR_NORMAL, eta * eta - sin2_h, refracted_cos2(cos_h, eta))
    # r_s = (c - g) / (c + g) with g = eta cos(theta_t). Multiplied out with g^2 = eta^2 - 1 + c^2, the
    # difference leaves eta^2 - 1 as a factor: nothing cancels. And r_p = r_s (c g - sin2) / (c g + sin2),
    # so that the mean of both squares is a product.
    c = cos_h
    g = sqrt(maximum(g2, ROOT_MIN))
    s, p = c + g, c * g
    r_s = (eta - 1) * (eta + 1) / (s * s)
    q = p + sin2_h
    F = r_s * r_s * ((p * p + sin2_h * sin2_h) / (q * q))
    return select(g2 > ROOT_MIN, F, 1)


def F_conductor(cos_theta: Float, eta: Color, k: Color) -> Color:
    """Exact reflectance of a conductor with the complex index eta + i k; a dielectric's for k = 0."""
    return F_conductor_half(cos_theta, _sin2(cos_theta), eta, k)


def F_conductor_half(cos_h: Float, sin2_h: Float, eta: Color, k: Color) -> Color:
    """Exact reflectance of a conductor, eta + i k, from cosine and squared sine at a facet."""
    # As for a dielectric, in complex numbers: contrast = (eta + i k)^2 - 1, g^2 = w = contrast + c^2
    c = cos_h
    contrast_re, half_im = (eta - 1) * (eta + 1) - k * k, eta * k + ABSORPTION_MIN
    c2 = c * c
    # The same as eta^2 - k^2 - sin^2, of which a small index leaves little else near the normal
    w_re = select(cos_h > NEAR_NORMAL, eta * eta - k * k - sin2_h, contrast_re + c2)
    im = 2 * half_im
    w_abs = _size(w_re, im)
    # Of the two parts of the root, the larger has no cancellation; the smaller follows from it.
    g2 = 0.5 * (w_abs + absolute(w_re))
    g_re = select(w_re > 0, g2, half_im) * (1 / sqrt(g2))
    # |c + g|^2 = c^2 + |w| + cross, and |c g -+ sin2_h|^2 = p -+ cross sin2_h
    cross = 2 * c * g_re
    s_abs2 = c2 + w_abs + cross
    p = c2 * w_abs + sin2_h * sin2_h
    return _reflected(contrast_re, im, s_abs2, p, p + cross * sin2_h)


# Of the following functions exports take the second ones, whose derivatives leave a float32 for a matched
# index in the horizon.


def _size(re: Color, im: Color) -> Color:
    """|re + i im| for im of at least 2 ABSORPTION_MIN."""
    x, y = SIZE_SCALE * re, SIZE_SCALE * im
    return sqrt(x * x + y * y) / SIZE_SCALE


def _size_value(re: Color, im: Color) -> Color:
    """|re + i im| for im of at least 2 ABSORPTION_MIN."""
    return sqrt(re * re + im * im)


def _reflected(re: Color, im: Color, s2: Color, p: Color, q: Color) -> Color:
    """|re + i im|^2 / s2^2 p / q."""
    r_re, r_im = re / s2, im / s2
    return (r_re * r_re + r_im * r_im) * (p / q)


def _reflected_value(re: Color, im: Color, s2: Color, p: Color, q: Color) -> Color:
    """|re + i im|^2 / s2^2 p / q."""
    # In two quotients, as the square of s2 is 1e-34 for a matched index in the horizon
    return (re * re + im * im) / s2 * (p / (s2 * q))


def _sin2(cos_theta: Float) -> Float:
    return (1 - cos_theta) * (1 + cos_theta)


def F_lazanyi(cos_theta: Float, eta: Color, k: Color) -> Color:
    """Lazányi and Szirmay-Kalos, "Fresnel term approximations for metals", WSCG 2005, Eq. 4.

    Schlick's curve through the exact F0 of a metal. Within 0.03 of `F_conductor` for gold, silver and
    copper; it has no dip before the horizon, and is up to 0.13 too bright there for aluminium, 0.27 for
    chromium.
    """
    return F_lazanyi_half(cos_theta, _sin2(cos_theta), eta, k)


def F_lazanyi_half(cos_h: Float, sin2_h: Float, eta: Color, k: Color) -> Color:
    """Lazányi's F at a facet, from cosine and squared sine there: the weight alone if eta is 1."""
    below = eta - 1
    above = eta + 1
    k2 = k * k
    weight = _weight(cos_h, sin2_h)
    return (below * below + 4 * eta * weight + k2) / (above * above + k2)


def f0_from_eta(eta: Color) -> Color:
    """Reflectance of a dielectric at normal incidence, ((eta - 1) / (eta + 1))^2."""
    r = (eta - 1) / (eta + 1)
    return r * r


def f0_from_conductor(eta: Color, k: Color) -> Color:
    """Reflectance of a conductor at normal incidence."""
    below, above = eta - 1, eta + 1
    return (below * below + k * k) / (above * above + k * k)


def eta_from_f0(f0: Color) -> Color:
    """Index of the dielectric (eta >= 1) with this reflectance at normal incidence, for f0 < 1."""
    r = sqrt(maximum(f0, ROOT_MIN))
    # 1 - r = (1 - f0) / (1 + r); f0 = 1 would be an infinite index
    return (1 + r) * (1 + r) / maximum(1 - f0, ROOT_MIN)


def refracted_cos2(mu: Float, eta: Float) -> Float:
    """eta^2 cos^2(theta_t) = mu^2 + eta^2 - 1; negative where light is reflected totally."""
    # The difference of two squares as a product, and mu^2 with its rounding error: at grazing angles, and
    # at the critical one, little else is left.
    return fma(mu, mu, (eta - 1) * (eta + 1))


class Split(NamedTuple):
    """What becomes of light at a surface."""

    F: Color
    """Is reflected."""
    T: Color
    """Enters."""


class Entering(NamedTuple):
    """What becomes of light at the surface of something denser."""

    F: Float
    """Is reflected."""
    T: Float
    """Enters."""


def F_dielectric_entering(mu: Float, eta: Float) -> Float:
    """Exact reflectance of a dielectric with eta >= 1, never total, at a cosine outside, mu > 0."""
    return _split_entering(mu, eta).F


def transmittance_entering(mu: Float, eta: Float) -> Float:
    """1 - F of a smooth dielectric with eta >= 1 at a cosine mu outside; exact where it nearly vanishes."""
    return _split_entering(mu, eta).T


def _split_entering(mu: Float, eta: Float) -> Entering:
    """F and T = 1 - F of a smooth dielectric with eta >= 1 at a cosine mu outside, mu > 0."""
    # r_s = (1 - eta^2) / s^2 with s = c + g, and r_p = r_s (c g - sin2) / q with q = c g + sin2. So
    # 1 - r_s^2 = 4 c g / s^2, and 1 - r_p^2 = 4 c g eta^2 / (s q)^2. One quotient serves all.
    c = mu
    g = smooth_sqrt(refracted_cos2(c, eta))
    s, p, sin2 = c + g, c * g, 1 - c * c
    q = p + sin2
    s2, q2 = s * s, q * q
    inv = 1 / (s2 * q2)
    r_s = (eta - 1) * (eta + 1) * (q2 * inv)
    F = r_s * r_s * ((p * p + sin2 * sin2) * (s2 * inv))
    return Entering(F, p * inv * (2 * (q2 + eta * eta)))


def transmittance(mu: Float, eta: Float) -> Float:
    """1 - F of a smooth dielectric, 0 where it reflects totally."""
    return transmittance_half(mu, _sin2(mu), eta)


def transmittance_schlick_half(cos_h: Float, sin2_h: Float, f0: Color, f90: Color) -> Color:
    """1 - F_schlick_half, without its cancellation."""
    return (1 - f0) * schlick_complement(cos_h) + (1 - f90) * _weight(cos_h, sin2_h)


def transmittance_half(cos_h: Float, sin2_h: Float, eta: Color) -> Color:
    """1 - F_dielectric_half, exact where it nearly vanishes."""
    c = cos_h
    g2 = select(c > NEAR_NORMAL, eta * eta - sin2_h, refracted_cos2(c, eta))
    g = sqrt(maximum(g2, ROOT_MIN))
    s, q = c + g, c * g + sin2_h
    # As in `_split_entering`; one quotient after the other, for small indices in the horizon
    T = 2 * c * g / (s * s) * (1 + eta / q * (eta / q))
    return select(g2 > ROOT_MIN, T, 0)


def transmittance_conductor_half(cos_h: Float, sin2_h: Float, eta: Color, k: Color) -> Color:
    """1 - F_conductor_half, exact where it nearly vanishes."""
    # The roots are those of F_conductor_half, the sum is that of `split_conductor`
    c = cos_h
    contrast_re, half_im = (eta - 1) * (eta + 1) - k * k, eta * k + ABSORPTION_MIN
    eps_re, im = (eta - k) * (eta + k), 2 * half_im
    w_re = select(c > NEAR_NORMAL, eps_re - sin2_h, contrast_re + c * c)
    w_abs = _size(w_re, im)
    g2 = 0.5 * (w_abs + absolute(w_re))
    inv = 1 / sqrt(g2)
    large, small = g2 * inv, half_im * inv
    g_re, g_im = select(w_re > 0, large, small), select(w_re > 0, small, large)
    p_re, p_im = eps_re * c + g_re, im * c + g_im
    T_s = g_re / (c * c + w_abs + 2 * c * g_re)
    return 2 * c * (T_s + (eps_re * g_re + im * g_im) / (p_re * p_re + p_im * p_im))


def transmittance_lazanyi(cos_theta: Float, eta: Float) -> Float:
    """1 - F of Lazányi's approximation, which is Schlick's for a dielectric."""
    above = eta + 1
    return 4 * eta / (above * above) * schlick_complement(cos_theta)


def transmittance_lazanyi_conductor(cos_theta: Float, eta: Color, k: Color) -> Color:
    """1 - F of Lazányi's approximation for a metal."""
    above = eta + 1
    return 4 * eta / (above * above + k * k) * schlick_complement(cos_theta)


def split_conductor(cos_theta: Float, eta: Color, k: Color) -> Split:
    """F of a conductor denser than the medium above, and 1 - F, exact where it nearly vanishes."""
    # With eps = (eta + i k)^2 and g^2 = eps - 1 + c^2: 1 - R_s = 4 c Re(g) / |c + g|^2, and 1 - R_p is
    # 4 c Re(conj(g) eps) / |eps c + g|^2. The roots are those of F.
    c = cos_theta
    contrast_re, half_im = (eta - 1) * (eta + 1) - k * k, eta * k + ABSORPTION_MIN
    eps_re, eps_im = (eta - k) * (eta + k), 2 * half_im
    c2, sin2 = c * c, _sin2(c)
    w_re = contrast_re + c2
    w_abs = _size(w_re, eps_im)
    g2 = 0.5 * (w_abs + absolute(w_re))
    inv = 1 / sqrt(g2)
    large, small = g2 * inv, half_im * inv
    g_re, g_im = select(w_re > 0, large, small), select(w_re > 0, small, large)
    cross = 2 * c * g_re
    s_abs2 = c2 + w_abs + cross
    p = c2 * w_abs + sin2 * sin2
    p_re, p_im = eps_re * c + g_re, eps_im * c + g_im
    T_p = (eps_re * g_re + eps_im * g_im) / (p_re * p_re + p_im * p_im)
    F = _reflected(contrast_re, eps_im, s_abs2, p, p + cross * sin2)
    return Split(F, 2 * c * (g_re / s_abs2 + T_p))


def F_below(cos_theta: Float, n1: Float, n2: Float) -> Float:
    """Exact reflectance of the lower surface, between layers of n1 and n2, at a cosine above the upper one.

    Both indices are at least 1, relative to where the cosine is: nothing is reflected totally.
    """
    # With g = n cos(theta) on both sides: r_s = (g1 - g2) / (g1 + g2), r_p = (n2^2 g1 - n1^2 g2) / p. Both
    # differences leave n1^2 - n2^2 as a factor, and g from the cosine above has no cancellation.
    g1, g2 = _below(cos_theta, n1), _below(cos_theta, n2)
    a, b = n1 * n1, n2 * n2
    sin2 = _sin2(cos_theta)
    contrast = (n1 - n2) * (n1 + n2)
    s, p = g1 + g2, b * g1 + a * g2
    r_s, r_p = contrast / (s * s), contrast * (a * b - sin2 * (a + b)) / (p * p)
    return 0.5 * (r_s * r_s + r_p * r_p)


def transmittance_below(cos_theta: Float, n1: Float, n2: Float) -> Float:
    """1 - F_below; exact where it nearly vanishes."""
    g1, g2 = _below(cos_theta, n1), _below(cos_theta, n2)
    a, b = n1 * n1, n2 * n2
    s, p = g1 + g2, b * g1 + a * g2
    return 2 * (g1 / s * (g2 / s) + a * b * (g1 / p) * (g2 / p))


def _below(cos_theta: Float, n: Float) -> Float:
    """n times the cosine inside a layer of index n."""
    return smooth_sqrt(refracted_cos2(cos_theta, n))


def f0_between(n1: Float, n2: Float) -> Float:
    """`F_below` at normal incidence."""
    r = (n2 - n1) / (n2 + n1)
    return r * r


def schlick_weight_half(wi: Vec3, wo: Vec3) -> Float:
    """(1 - c)^5 at c = wo . m, the half vector's cosine."""
    return _weight(cos_half(wi, wo), sin2_half(wi, wo))


def _weight(cos_h: Float, sin2_h: Float) -> Float:
    """(1 - c)^5 at a facet, from cosine and squared sine there."""
    # 1 - c = (1 - c^2) / (1 + c), and 1 - c^2 is the square of half the distance of wi and wo: the
    # weight keeps its digits where the two meet and it goes to 0.
    k = sin2_h / (1 + cos_h)
    k2 = k * k
    return k2 * k2 * k


def schlick_complement(c: Float) -> Float:
    """1 - (1 - c)^5, with the factor c taken out so that it keeps its digits as c goes to 0."""
    k = 1 - c
    k2 = k * k
    return c * ((1 + k) * (1 + k2) + k2 * k2)
