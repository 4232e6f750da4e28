"""Sampling of a matte lobe with a glossy one: cosine-weighted, or wo mirrored at a visible GGX normal."""

from gonio.lang import Float, Vec2, Vec3, select
from gonio.parts.distribution import RoundGGX
from gonio.parts.hemisphere import pdf_cosine, sample_cosine
from gonio.parts.lobes import choose, pdf_ggx_lobe, sample_ggx_lobe


def sample_matte_gloss(wo: Vec3, alpha: Float, shares: Vec2, u: Vec2) -> Vec3:
    """A direction of one of the two lobes; shares: the probabilities of the matte one and of the other."""
    matte, v = choose(shares.x, u)
    return select(matte, sample_cosine(v), sample_ggx_lobe(RoundGGX(alpha), wo, v))


def pdf_matte_gloss(wi: Vec3, wo: Vec3, alpha: Float, shares: Vec2) -> Float:
    """Density of `sample_matte_gloss` in 1/sr."""
    return shares.x * pdf_cosine(wi) + shares.y * pdf_ggx_lobe(RoundGGX(alpha), wi, wo)
