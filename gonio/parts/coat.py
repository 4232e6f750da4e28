"""What a layer over another one is made of: its facets' reflection, and what it lets in and out.

Source: Elek, "Layered materials in real-time rendering", CESCG 2010, Eq. 2 to 4.
"""

from gonio.lang import Color, Float, Vec3, vec3
from gonio.parts.distribution import D_ggx
from gonio.parts.frame import half_vector
from gonio.parts.interface import absorbed
from gonio.parts.masking import V_smith_correlated_ggx


def ggx_facets(wi: Vec3, wo: Vec3, alpha: Float) -> Float:
    """D G / (4 mu_i mu_o) of GGX with height-correlated Smith: times F it is a reflection."""
    D = D_ggx(half_vector(wi, wo), alpha, alpha)
    return D * V_smith_correlated_ggx(wi, wo, alpha, alpha)


def through_facets(wi: Vec3, wo: Vec3, alpha: Float, T: Color) -> Color:
    """T12 t of Eq. 2 and 4 with t = (1 - G) + T21 G, T21 = T12 = T at the half vector, and GGX's G."""
    G = 4 * wi.z * wo.z * V_smith_correlated_ggx(wi, wo, alpha, alpha)
    return T * ((1 - G) + T * G)


def optical_depth(sigma_a: Color, thickness: Float) -> Color:
    """Absorption times thickness, for each channel."""
    return sigma_a * vec3(thickness, thickness, thickness)


def absorbed_least(depth: Color, wo: Vec3) -> Color:
    """The most that `absorbed` leaves of light that goes out along wo: it came in along the normal."""
    up = vec3(0 * wo.z, 0 * wo.z, 0 * wo.z + 1)
    return absorbed(depth, up, wo)


def usual_cos_half(wo: Vec3) -> Float:
    """A cosine at which light from anywhere meets the facets that it enters by, to choose lobes with.

    Halfway between wo.z (the mirror direction) and 1 (wi = wo): at grazing angles tilted facets let in more
    than the mean surface, whose transmittance is nearly 0 there.
    """
    return 0.5 + 0.5 * wo.z
