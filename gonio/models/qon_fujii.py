"""Fujii QON: the qualitative Oren–Nayar model with a coloured interreflection term.

Source: Fujii, "A tiny improvement of Oren-Nayar reflectance model", 2013, its first proposal; named
and plotted in Portsmouth, Kutz, Hill, "EON", arXiv:2410.18026, section 1.
"""

from gonio.claims import Claims, Place, at_most, kink
from gonio.lang import INV_PI, PI, Color, Float, Sample, Vec2, Vec3
from gonio.model import Model, param
from gonio.parts import cltc
from gonio.parts.frame import tangential_dot
from gonio.parts.oren_nayar import (
    MEAN_G_FUJII,
    G_fujii,
    qualitative_coefficients,
    s_over_t_fujii,
)


class QONFujii(Model):
    """Rough diffuse close to full Oren–Nayar, at QON's cost. Reciprocal; loses energy."""

    rho: Color = param((0.8, 0.8, 0.8), 0, 1, "single-scattering albedo, linear RGB")
    sigma: Float = param(0.5, 0, PI / 2, "standard deviation of the facet angle, radians")
    caveats = (
        "Reflects more than it receives at grazing angles for 0 < sigma < 0.46 and rho > 0.97, "
        "at most 1.0287.",
        "Loses energy at larger sigma: at pi/2 a white surface reflects 72 % at the normal.",
    )
    unlike = (
        ("fon", "is Fujii's other proposal: by r in place of sigma, and without a dark ring."),
        ("qon", "leaves out the light that facets send to each other."),
    )
    claims = Claims(
        energy=at_most(1.0287),
        kinks=(kink(Place.SIDE_LIGHT), kink(Place.EQUAL_COSINES)),
    )

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """BRDF value in 1/sr, without the cosine: A grows with the colour."""
        _, B = self._coefficients()
        s = tangential_dot(wi, wo)
        return self.rho * (INV_PI * (self._A() + B * s_over_t_fujii(s, wi, wo)))

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """EON's sampler, at the roughness with the same weight of s/t."""
        A, B = self._coefficients()
        wi = cltc.sample_cltc_matched(wo, B / A, u)
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample` in 1/sr; that of the colourless part."""
        A, B = self._coefficients()
        return cltc.pdf_cltc_matched(wi, wo, B / A)

    def albedo(self, wo: Vec3) -> Color:
        """rho (A + B G_F / pi)."""
        _, B = self._coefficients()
        return self.rho * (self._A() + B * INV_PI * G_fujii(wo.z))

    def mean_albedo(self) -> Color:
        """rho (A + B <G_F> / pi)."""
        _, B = self._coefficients()
        return self.rho * (self._A() + B * MEAN_G_FUJII)

    def _coefficients(self) -> tuple[Float, Float]:
        return qualitative_coefficients(self.sigma, 0.33)

    def _A(self) -> Color:
        """A with the interreflection, one value per channel."""
        A, _ = self._coefficients()
        s2 = self.sigma * self.sigma
        return A + self.rho * (0.17 * s2 / (s2 + 0.13))
