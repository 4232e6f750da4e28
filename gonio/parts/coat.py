"""What a layer over another one is made of: its facets' reflection, and what it lets in and out.

Source: Elek, "Layered materials in real-time rendering", CESCG 2010, Eq. 2 to 4.
"""

from gonio.lang import Color, Float, Vec2, Vec3, vec3
from gonio.parts.distribution import RoundBeckmann, RoundGGX, ggx_bound, pdf_bounded
from gonio.parts.frame import half_length, half_vector, mirror, pdf_mirror
from gonio.parts.interface import attenuation
from gonio.parts.lobes import pdf_ggx_lobe, sample_ggx_lobe
from gonio.parts.masking import (
    V_cook_torrance,
    V_smith_correlated,
    lost_cook_torrance,
    lost_smith_correlated,
)

# --- facets ----------------------------------------------------------------------------------------
# masking is "smith_correlated" or "cook_torrance": V-cavities. m is the half vector.

Round = RoundBeckmann | RoundGGX


def facets_of(alpha: Float, distribution: str) -> Round:
    """Facets of a width; distribution is "ggx" or "beckmann"."""
    if distribution == "beckmann":
        return RoundBeckmann(alpha)
    return RoundGGX(alpha)


def reflected_by(facets: Round, wi: Vec3, wo: Vec3, m: Vec3, masking: str) -> Float:
    """D G / (4 mu_i mu_o); F is missing."""
    if masking == "cook_torrance":
        return facets.D(m) * V_cook_torrance(wi, wo)
    return facets.D(m) * V_smith_correlated(facets, wi, wo)


def through_facets(facets: Round, wi: Vec3, wo: Vec3, masking: str, T: Color) -> Color:
    """T12 t of Eq. 2 and 4 with t = (1 - G) + T21 G, T21 = T12 = T at the half vector."""
    if masking == "cook_torrance":
        return past_facets(T, lost_cook_torrance(wi, wo))
    return past_facets(T, lost_smith_correlated(facets, wi, wo))


def past_facets(T: Color, lost: Float) -> Color:
    """T12 t of Eq. 2 and 4 with lost = 1 - G."""
    # 1 - G F would lose the digits of a small T
    return T * (T + lost * (1 - T))


# Visible normals need a G that is no larger than Smith's G1: with V-cavities the weights would grow like
# alpha / mu_o in the horizon. Those of all normals are at most 2. GGX's normals serve for Beckmann facets,
# whose density is at most 4 / e of theirs.


def sample_facet(facets: Round, wo: Vec3, u: Vec2, masking: str) -> Vec3:
    """A facet's normal."""
    if masking == "cook_torrance":
        return facets.sample(u)
    return RoundGGX(facets.alpha).sample_bounded(wo, u, ggx_bound(facets.alpha, wo))


def pdf_facet(facets: Round, wo: Vec3, m: Vec3, cos_h: Float, masking: str) -> Float:
    """Density of wo mirrored at `sample_facet`, in 1/sr."""
    if masking == "cook_torrance":
        return pdf_mirror(facets.density(m), cos_h)
    return pdf_bounded(RoundGGX(facets.alpha), wo, m, ggx_bound(facets.alpha, wo))


def sample_facets(facets: Round, wo: Vec3, u: Vec2, masking: str) -> Vec3:
    """A direction that the uppermost facets mirror."""
    if masking == "cook_torrance":
        return mirror(wo, facets.sample(u))
    return sample_ggx_lobe(RoundGGX(facets.alpha), wo, u)


def pdf_facets(facets: Round, wi: Vec3, wo: Vec3, masking: str) -> Float:
    """Density of `sample_facets` in 1/sr."""
    if masking == "cook_torrance":
        return pdf_mirror(facets.density(half_vector(wi, wo)), half_length(wi, wo))
    return pdf_ggx_lobe(RoundGGX(facets.alpha), wi, wo)


# --- absorption ------------------------------------------------------------------------------------


def optical_depth(sigma_a: Color, thickness: Float) -> Color:
    """Absorption times thickness, for each channel."""
    return sigma_a * vec3(thickness, thickness, thickness)


def attenuation_least(sigma_a: Color, thickness: Float, wo: Vec3) -> Color:
    """The most that `attenuation` leaves of light that goes out along wo: it came in along the normal."""
    return attenuation(sigma_a, thickness, vec3(0, 0, 1), wo)


def usual_cos_half(wo: Vec3) -> Float:
    """A cosine at which light from anywhere meets the facets that it enters by, to choose lobes with.

    Halfway between wo.z (the mirror direction) and 1 (wi = wo): at grazing angles tilted facets let in more
    than the mean surface, whose transmittance is nearly 0 there.
    """
    return 0.5 + 0.5 * wo.z


def usual_sin2_half(wo: Vec3) -> Float:
    """1 minus the square of `usual_cos_half`, with its digits: near the normal, total reflection begins."""
    below_one = 0.5 - 0.5 * wo.z
    return below_one * (2 - below_one)
