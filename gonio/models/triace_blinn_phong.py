"""tri-Ace Blinn–Phong: a normalised Blinn–Phong highlight with Fresnel, cheap enough for a console.

Source: Gotanda, "Beyond a simple physically based Blinn-Phong model in real-time", SIGGRAPH 2012
course "Practical physically based shading in film and game production", Eq. 1.
The course's shaders return pi f cos(theta_i); this is f. Its linear factor 0.0397436 n + 0.0856832 is a
fit of (n + 2) / (4 pi (2 - 2^(-n / 2))): within 0.6 % for n >= 10, 32 % too small at n = 1.
"""

from gonio.claims import Claims, Place, at_most, kink
from gonio.lang import INV_PI, Color, Float, Sample, Vec2, Vec3, lerp
from gonio.model import Model, param
from gonio.parts.distribution import blinn_phong_alpha
from gonio.parts.fresnel import schlick_weight, schlick_weight_half
from gonio.parts.lobes import average, shares
from gonio.parts.matte_gloss import pdf_matte_gloss, sample_matte_gloss
from gonio.parts.roughness import at_most_blinn_phong
from gonio.parts.triace import blinn_phong_highlight


class TriAceBlinnPhong(Model):
    """Lambert under a Blinn-Phong highlight with Schlick's Fresnel. Reciprocal."""

    albedo_rule = "half_vectors"

    rho: Color = param((0.5, 0.5, 0.5), 0, 1, "diffuse albedo R_d, linear RGB")
    f0: Color = param((0.04, 0.04, 0.04), 0, 1, "reflectance at normal incidence, linear RGB")
    shininess: Float = param(50, 0, 1e5, "Blinn-Phong exponent n", rougher=at_most_blinn_phong)
    caveats = (
        "Loses energy: with f0 = 1 it reflects 36 % at the normal for shininess 1, 73 % for 10, "
        "93 % for 50, and less than 6 % at grazing angles from 50 on.",
        "Reflects more than it receives for white rho and low f0: at most 1.030 for f0 = 0.04 and "
        "1.066 for f0 = 0, at 80 degrees and high shininess.",
    )
    claims = Claims(energy=at_most(1.066), kinks=kink(Place.EQUAL_COSINES))

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """Eq. 1 without the cosine and the factor pi: BRDF value in 1/sr."""
        F = lerp(self.f0, 1, schlick_weight_half(wi, wo))
        highlight = blinn_phong_highlight(wi, wo, self.shininess)
        return self.rho * (1 - self.f0) * INV_PI + F * highlight

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Cosine-weighted, or the GGX lobe of the same width, whose longer tail bounds the weights."""
        alpha = blinn_phong_alpha(self.shininess)
        wi = sample_matte_gloss(wo, alpha, self._shares(wo), u)
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample` in 1/sr."""
        alpha = blinn_phong_alpha(self.shininess)
        return pdf_matte_gloss(wi, wo, alpha, self._shares(wo))

    def _shares(self, wo: Vec3) -> Vec2:
        """Probabilities of the diffuse lobe and of the highlight."""
        F = lerp(self.f0, 1, schlick_weight(wo.z))
        return shares(average(self.rho * (1 - self.f0)), average(F))
