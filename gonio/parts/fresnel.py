"""Fresnel reflectance and its approximations.

cos_theta is the cosine at which light meets the (micro)surface, in [0, 1]. Reflectances are those of
unpolarised light. eta is the relative index n_inside / n_outside, k the extinction over n_outside; both
may be numbers or colours.
"""

from gonio.lang import (
    Color,
    Float,
    absolute,
    fma,
    maximum,
    select,
    sqrt,
)

# Smallest value whose square root is taken: the root's derivative, 5e7, still leaves room in a float32.
# It is reached at the edge of total internal reflection, where the true derivative is infinite.
ROOT_MIN = 1e-16


def schlick_weight(cos_theta: Float) -> Float:
    """(1 - cos_theta)^5 of Schlick's approximation."""
    k = 1 - cos_theta
    k2 = k * k
    return k2 * k2 * k


def F_schlick(cos_theta: Float, f0: Color, f90: Color) -> Color:
    """Schlick, "An inexpensive BRDF model for physically-based rendering", 1994, Eq. 15, with an F90."""
    # 1 - k^5 with k = 1 - c, without its cancellation in the horizon
    k = 1 - cos_theta
    rest = cos_theta * (1 + k * (1 + k * (1 + k * (1 + k))))
    return f0 * rest + f90 * schlick_weight(cos_theta)


def F_denser(cos_theta: Float, eta: Color) -> Color:
    """Exact reflectance of a dielectric with eta >= 1, which never reflects all light."""
    # r_s = (c - g) / (c + g) with g = eta cos(theta_t). Multiplied out with g^2 = eta^2 - 1 + c^2, the
    # difference leaves eta^2 - 1 as a factor: nothing cancels. And r_p = r_s (c g - sin2) / (c g + sin2),
    # so that the mean of both squares is a product.
    c = cos_theta
    contrast = (eta - 1) * (eta + 1)
    sin2 = 1 - c * c
    # c^2 with its rounding error: at grazing angles, and at the critical one, little else is left
    g = sqrt(maximum(fma(c, c, contrast), ROOT_MIN))
    s, p = c + g, c * g
    r_s = contrast / (s * s)
    q = p + sin2
    return r_s * r_s * ((p * p + sin2 * sin2) / (q * q))


def F_dielectric(cos_theta: Float, eta: Color) -> Color:
    """Exact reflectance of a dielectric. Below eta = 1 all light is reflected past the critical angle."""
    g2 = fma(cos_theta, cos_theta, (eta - 1) * (eta + 1))
    return select(g2 > ROOT_MIN, F_denser(cos_theta, eta), 1)


def F_conductor(cos_theta: Float, eta: Color, k: Color) -> Color:
    """Exact reflectance of a conductor with the complex index eta + i k; `F_dielectric` for k = 0."""
    # As `F_dielectric`, in complex numbers: contrast = (eta + i k)^2 - 1, g^2 = w = contrast + c^2
    c = cos_theta
    # A trace of absorption keeps the roots below from 0
    contrast_re, half_im = (eta - 1) * (eta + 1) - k * k, eta * k + ROOT_MIN
    c2 = c * c
    sin2 = 1 - c2
    w_re = contrast_re + c2
    im2 = 4 * half_im * half_im
    w_abs = sqrt(w_re * w_re + im2)
    # Of the two parts of the root, the larger has no cancellation; the smaller follows from it.
    large = sqrt(0.5 * (w_abs + absolute(w_re)))
    g_re = select(w_re > 0, large, half_im / large)
    # |c + g|^2 = c^2 + |w| + cross, and |c g -+ sin2|^2 = p -+ cross sin2
    cross = 2 * c * g_re
    s_abs2 = c2 + w_abs + cross
    p = c2 * w_abs + sin2 * sin2
    # One quotient after the other: for a matched index in the horizon the squares would leave a float32
    R_s = (contrast_re * contrast_re + im2) / s_abs2 / s_abs2
    return R_s * (p / (p + cross * sin2))


def F_lazanyi(cos_theta: Float, eta: Color, k: Color) -> Color:
    """Lazányi and Szirmay-Kalos, "Fresnel term approximations for metals", WSCG 2005, Eq. 4.

    Schlick's curve through the exact F0 of a metal. Within 0.03 of `F_conductor` for gold, silver and
    copper; it has no dip before the horizon, and is up to 0.13 too bright there for aluminium, 0.27 for
    chromium.
    """
    below = eta - 1
    above = eta + 1
    k2 = k * k
    return (below * below + 4 * eta * schlick_weight(cos_theta) + k2) / (above * above + k2)


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
