"""FON: Fujii's simplified Oren–Nayar model.

Source: Fujii, "A tiny improvement of Oren-Nayar reflectance model", 2013, in the form of Portsmouth,
Kutz, Hill, "EON", arXiv:2410.18026, Eq. 10 to 15.
"""

from gonio.claims import Claims, Place, kink
from gonio.lang import INV_PI, PI, Color, Float, Sample, Vec2, Vec3
from gonio.model import Model, param
from gonio.parts import cltc
from gonio.parts.oren_nayar import MEAN_G_FUJII, G_fujii, fujii_shape

C1 = 0.5 - 2 / (3 * PI)  # A_F = 1 / (1 + C1 r)


class FON(Model):
    """Rough diffuse without a dark ring. Reciprocal; never gains energy, but loses up to 22 %."""

    rho: Color = param((0.8, 0.8, 0.8), 0, 1, "single-scattering albedo, linear RGB")
    roughness: Float = param(0.5, 0, 1, "unitless r; not the Oren-Nayar angle sigma")
    caveats = (
        "Loses energy: at roughness 1 a white surface reflects 77.7 % at the normal and 83.3 % on average.",
    )
    unlike = (
        ("eon", "adds the light that this one loses."),
        ("qon_fujii", "is Fujii's other proposal: by sigma, an angle, in place of r."),
    )
    claims = Claims(kinks=(kink(Place.SIDE_LIGHT), kink(Place.EQUAL_COSINES)), falls=("roughness",))

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """Eq. 10: BRDF value in 1/sr, without the cosine."""
        r = self.roughness
        return self.rho * (INV_PI / (1 + C1 * r) * fujii_shape(wi, wo, r))

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """EON's sampler, made for the same shape."""
        wi = cltc.sample_cltc_matched(wo, self.roughness, u)
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample` in 1/sr."""
        return cltc.pdf_cltc_matched(wi, wo, self.roughness)

    def albedo(self, wo: Vec3) -> Color:
        """Eq. 12."""
        r = self.roughness
        return self.rho * ((1 + r * INV_PI * G_fujii(wo.z)) / (1 + C1 * r))

    def mean_albedo(self) -> Color:
        """Eq. 15."""
        r = self.roughness
        return self.rho * ((1 + MEAN_G_FUJII * r) / (1 + C1 * r))
