"""Burley diffuse: the diffuse lobe of Disney's principled model.

Source: Burley, "Physically-based shading at Disney", SIGGRAPH 2012 course notes, section 5.3.
The albedo's closed form is ours: the BRDF is a polynomial in cosines once 2 cos^2(theta_d) is written
as 1 + dot(wi, wo), so it can be integrated term by term.
"""

from gonio.claims import Claims, at_most
from gonio.lang import INV_PI, Color, Float, Sample, Vec2, Vec3, dot
from gonio.model import Model, param
from gonio.parts.fresnel import schlick_weight
from gonio.parts.hemisphere import pdf_cosine, sample_cosine

# Integrals of (1 - mu)^5 mu^k over mu in [0, 1], k = 1, 2, 3.
I1, I2, I3 = 1 / 42, 1 / 168, 1 / 504


class BurleyDiffuse(Model):
    """Diffuse with darker edges when smooth and a bright rim when rough. Reciprocal."""

    rho: Color = param((0.8, 0.8, 0.8), 0, 1, "base colour, linear RGB")
    roughness: Float = param(0.5, 0, 1, "perceptual roughness, not alpha")
    caveats = (
        "Reflects more than it receives at grazing angles for roughness > 0.4, at most 1.5575 (at 1).",
        "Loses energy when smooth: white of roughness 0 reflects 97.6 % at the normal, 48.8 % grazing.",
    )
    unlike = (("disney", "is the whole principled model; this is its diffuse lobe."),)
    claims = Claims(energy=at_most(1.5576))

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """BRDF value in 1/sr, without the cosine."""
        # F90 = 0.5 + 2 roughness cos^2(theta_d), and 2 cos^2(theta_d) = 1 + dot(wi, wo)
        rise = self.roughness * (1 + dot(wi, wo)) - 0.5
        fresnel_i = 1 + rise * schlick_weight(wi.z)
        fresnel_o = 1 + rise * schlick_weight(wo.z)
        return self.rho * (INV_PI * fresnel_i * fresnel_o)

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Cosine-weighted: the weight is the product of two Fresnel factors of at most 2.5."""
        wi = sample_cosine(u)
        return Sample(wi, pdf_cosine(wi))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample` in 1/sr."""
        return pdf_cosine(wi)

    def albedo(self, wo: Vec3) -> Color:
        """Integral of `eval` times the cosine."""
        r = self.roughness
        a = r - 0.5
        mu, w = wo.z, schlick_weight(wo.z)
        both = (
            a * a * I1
            + 2 * a * r * mu * I2
            + r * r * (mu * mu * I3 + (1 - mu * mu) * (I1 - I3) / 2)
        )
        return self.rho * (1 + 2 * (a * I1 + r * mu * I2) + w * (a + 2 / 3 * r * mu) + 2 * w * both)

    def mean_albedo(self) -> Color:
        """Hemispherical mean of `albedo`."""
        r = self.roughness
        a = r - 0.5
        both = a * a * I1 * I1 + 2 * a * r * I2 * I2 + r * r * (I3 * I3 + (I1 - I3) * (I1 - I3) / 2)
        return self.rho * (1 + 4 * a * I1 + 8 / 3 * r * I2 + 4 * both)
