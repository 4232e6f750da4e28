"""QON: the qualitative Oren–Nayar model, the one most renderers mean by "Oren–Nayar".

Source: Oren, Nayar, "Generalization of Lambert's reflectance model", SIGGRAPH 1994, Eq. 30, in the
form of Portsmouth, Kutz, Hill, "EON", arXiv:2410.18026, Eq. 1 to 9.
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


class QON(Model):
    """Rough diffuse, qualitative form. Reciprocal; loses energy; too bright when lit from behind."""

    rho: Color = param((0.8, 0.8, 0.8), 0, 1, "single-scattering albedo, linear RGB")
    sigma: Float = param(0.5, 0, PI / 2, "standard deviation of the facet angle, radians")
    caveats = (
        "Loses energy: at sigma = pi/2 a white surface reflects 65 % on average.",
        "Reflects more than it receives at grazing angles for 0 < sigma < 0.326, at most 1.0152.",
        "Its slope jumps where cos(phi_i - phi_o) changes sign, a dark ring on a side-lit sphere.",
    )
    unlike = (
        (
            "oren_nayar",
            "the full model of the same paper; this one drops its C3 and the interreflection.",
        ),
        ("qon_fujii", "adds interreflection, in the colour of the surface."),
        ("qon_footnote", "has 0.57 where this one has 0.33."),
    )
    claims = Claims(
        energy=at_most(1.0152),
        kinks=(dark_ring(), kink(Place.EQUAL_COSINES)),
        falls=("sigma",),
    )

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """Eq. 1: BRDF value in 1/sr, without the cosine."""
        A, B = qualitative_coefficients(self.sigma, 0.33)
        s = tangential_dot(wi, wo)
        return self.rho * (INV_PI * (A + B * s_over_t_qualitative(s, wi, wo)))

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """EON's sampler, at the roughness with the same weight of s/t."""
        A, B = qualitative_coefficients(self.sigma, 0.33)
        wi = cltc.sample_cltc_matched(wo, B / A, u)
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample` in 1/sr."""
        A, B = qualitative_coefficients(self.sigma, 0.33)
        return cltc.pdf_cltc_matched(wi, wo, B / A)

    def albedo(self, wo: Vec3) -> Color:
        """Eq. 5."""
        A, B = qualitative_coefficients(self.sigma, 0.33)
        return self.rho * (A + B * INV_PI * G_qualitative(wo.z))

    def mean_albedo(self) -> Color:
        """Eq. 9."""
        A, B = qualitative_coefficients(self.sigma, 0.33)
        return self.rho * (A + B * MEAN_G_QUALITATIVE)
