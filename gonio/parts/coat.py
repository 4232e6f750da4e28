"""What a layer over another one is made of: its facets' reflection, and what it lets in and out.

Source: Elek, "Layered materials in real-time rendering", CESCG 2010, Eq. 2 to 4.
"""

from gonio.lang import Color, Float, Vec3, vec3
from gonio.parts.distribution import RoundGGX
from gonio.parts.interface import attenuation
from gonio.parts.masking import V_smith_correlated


def ggx_facets(m: Vec3, wi: Vec3, wo: Vec3, alpha: Float) -> Float:
    """D G / (4 mu_i mu_o) of GGX with height-correlated Smith at the half vector m; F is missing."""
    facets = RoundGGX(alpha)
    return facets.D(m) * V_smith_correlated(facets, wi, wo)


def through_facets(wi: Vec3, wo: Vec3, alpha: Float, T: Color) -> Color:
    """T12 t of Eq. 2 and 4 with t = (1 - G) + T21 G, T21 = T12 = T at the half vector, and GGX's G."""
    G = 4 * wi.z * wo.z * V_smith_correlated(RoundGGX(alpha), wi, wo)
    return T * ((1 - G) + T * G)


def optical_depth(sigma_a: Color, thickness: Float) -> Color:
    """Absorption times thickness, for each channel."""
    return sigma_a * vec3(thickness, thickness, thickness)


def attenuation_least(optical_depth: Color, wo: Vec3) -> Color:
    """The most that `attenuation` leaves of light that goes out along wo: it came in along the normal."""
    return attenuation(optical_depth, vec3(0, 0, 1), wo)


def usual_cos_half(wo: Vec3) -> Float:
    """A cosine at which light from anywhere meets the facets that it enters by, to choose lobes with.

    Halfway between wo.z (the mirror direction) and 1 (wi = wo): at grazing angles tilted facets let in more
    than the mean surface, whose transmittance is nearly 0 there.
    """
    return 0.5 + 0.5 * wo.z
