"""QON with the coefficient of a footnote: 0.57 in place of 0.33, a little brighter.

Source: Oren, Nayar, "Generalization of Lambert's reflectance model", SIGGRAPH 1994, Eq. 30 and its
footnote; in the form of Portsmouth, Kutz, Hill, "EON", arXiv:2410.18026, Eq. 1 to 9.
"""

from gonio.claims import Claims, Place, at_most, dark_ring, kink
from gonio.lang import INV_PI, PI, Color, Float, Sample, Vec2, Vec3
from gonio.model import Model, param
from gonio.parts import cltc
from gonio.parts.frame import tangential_dot
from gonio.parts.oren_nayar import (
    MEAN_G_QUALITATIVE,
    G_qualitative,
    qualitative_coefficients,
    s_over_t_qualitative,
)


class QONFootnote(Model):
    """QON made brighter to stand in for interreflection. Reciprocal; gains energy at grazing angles."""

    rho: Color = param((0.8, 0.8, 0.8), 0, 1, "single-scattering albedo, linear RGB")
    sigma: Float = param(0.5, 0, PI / 2, "standard deviation of the facet angle, radians")
    caveats = (
        "Reflects more than it receives at grazing angles for 0 < sigma < 0.55, at most 1.0444.",
        "Loses energy at larger sigma: at pi/2 a white surface reflects 68 % at the normal.",
        "Its slope jumps where cos(phi_i - phi_o) changes sign, a dark ring on a side-lit sphere.",
    )
    unlike = (
        ("qon", "has 0.33 where this one has 0.57, which stands in for interreflection."),
        ("qon_fujii", "has a term for interreflection instead."),
    )
    claims = Claims(
        energy=at_most(1.0444),
        kinks=(dark_ring(), kink(Place.EQUAL_COSINES)),
    )

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """Eq. 1: BRDF value in 1/sr, without the cosine."""
        A, B = qualitative_coefficients(self.sigma, 0.57)
        s = tangential_dot(wi, wo)
        return self.rho * (INV_PI * (A + B * s_over_t_qualitative(s, wi, wo)))

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """EON's sampler, at the roughness with the same weight of s/t."""
        A, B = qualitative_coefficients(self.sigma, 0.57)
        wi = cltc.sample_cltc_matched(wo, B / A, u)
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample` in 1/sr."""
        A, B = qualitative_coefficients(self.sigma, 0.57)
        return cltc.pdf_cltc_matched(wi, wo, B / A)

    def albedo(self, wo: Vec3) -> Color:
        """Eq. 5."""
        A, B = qualitative_coefficients(self.sigma, 0.57)
        return self.rho * (A + B * INV_PI * G_qualitative(wo.z))

    def mean_albedo(self) -> Color:
        """Eq. 9."""
        A, B = qualitative_coefficients(self.sigma, 0.57)
        return self.rho * (A + B * MEAN_G_QUALITATIVE)
