"""Light from pictures, as shaders reckon with it: factors for prefiltered environments and harmonics.

Source: Gotanda, "Beyond a simple physically based Blinn-Phong model in real-time", SIGGRAPH 2012 course
"Practical physically based shading in film and game production", Eq. 6 to 9 and 26 to 29. Symbols are the
course's: f and g are its A' and B of Eq. 25, n is Blinn-Phong's shininess, depth is alpha'.
The signs of Eq. 27 and 28 are damaged in print and chosen here such that both give f at mu = 1 and f + g at
mu = 0, as its Figures 8 and 9 do. Both fit the integral over the half plane in which the viewer stands
(`in_plane_integral`); over the hemisphere the model reflects f + 0.288 g at grazing angles, not f + g
(`gonio.TriAceOrenNayar.albedo`).
"""

from gonio.lang import MU_MIN, PI, Color, Float, maximum, safe_acos, safe_sqrt


def specular_image_absorption(depth: Color, mu: Float) -> Color:
    """Eq. 6 and 7: what absorption leaves of a mirrored picture, max(0, 1 - 2 depth / mu_o)."""
    return maximum(1 - 2 * depth / maximum(mu, MU_MIN), 0)


def diffuse_image_absorption(depth: Color, mu: Float) -> Color:
    """Eq. 8 and 9: what it leaves of diffuse light from everywhere, max(0, 1 - depth (2 + 1 / mu_o))."""
    return maximum(1 - depth * (2 + 1 / maximum(mu, MU_MIN)), 0)


def oren_nayar_f(shininess: Float) -> Float:
    """f = 1 - 1 / (2 + 0.65 n), the A' of Eq. 25."""
    return 1 - 1 / (2 + 0.65 * shininess)


def oren_nayar_g(shininess: Float) -> Float:
    """g = 1 / (2.22222 + 0.1 n), the B of Eq. 25."""
    return 1 / (2.22222 + 0.1 * shininess)


def harmonic_dc_scale(mu: Float, shininess: Float) -> Float:
    """Eq. 27: factor of the constant harmonic at mu = N.E, f + g / 2 (1 + 2 / pi acos mu - mu)."""
    fall = 1 + 2 / PI * safe_acos(mu) - mu
    return oren_nayar_f(shininess) + 0.5 * oren_nayar_g(shininess) * fall


def harmonic_dc_scale_cheap(mu: Float, shininess: Float) -> Float:
    """Eq. 28: the same without the arc cosine, f + g (1 - mu)."""
    return oren_nayar_f(shininess) + oren_nayar_g(shininess) * (1 - mu)


def harmonic_linear_scale(mu: Float, shininess: Float) -> Float:
    """Eq. 29: factor of the linear spherical harmonics, S = f + (f - 1)(1 - mu), which flattens them."""
    f = oren_nayar_f(shininess)
    return f + (f - 1) * (1 - mu)


def harmonic_linear_scale_halved(mu: Float, shininess: Float) -> Float:
    """Eq. 29 with half its effect, for the average case (caption of Figure 10)."""
    f = oren_nayar_f(shininess)
    return f + 0.5 * (f - 1) * (1 - mu)


def in_plane_integral(mu: Float, shininess: Float) -> Float:
    """What Eq. 27 and 28 fit: the integral of Eq. 25 over the viewer's half plane, exact.

    f + g sin(theta) (1 - cos(theta) / 2).
    """
    sine = safe_sqrt((1 - mu) * (1 + mu))
    return oren_nayar_f(shininess) + oren_nayar_g(shininess) * sine * (1 - 0.5 * mu)
