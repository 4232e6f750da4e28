"""Blinn: a diffuse term and a highlight around the half vector, as early hardware shaded it.

Source: Blinn, "Models of light reflection for computer synthesized pictures", SIGGRAPH 1977: Phong's
formula with the angle between the normal and the half vector in place of that to the mirror direction.
The formula gives the radiance f cos(theta_i), which is divided by the cosine here.
"""

from gonio.albedos.quadrature import NumericAlbedo
from gonio.claims import Claims, at_most
from gonio.lang import INV_PI, PI, Color, Float, Sample, Vec2, Vec3
from gonio.model import Model, param
from gonio.parts.distribution import blinn_phong_alpha
from gonio.parts.image import ImageLobes
from gonio.parts.lobes import average, cos_power, shares
from gonio.parts.matte_gloss import pdf_matte_gloss, sample_matte_gloss
from gonio.parts.roughness import at_most_blinn_phong


class Blinn(Model):
    """The classic Blinn-Phong: diffuse, specular and gloss, without Fresnel or normalisation."""

    numeric = NumericAlbedo("half_vectors")

    rho: Color = param((0.5, 0.5, 0.5), 0, 1, "albedo of the diffuse term, linear RGB")
    specular: Color = param((0.3, 0.3, 0.3), 0, 1, "weight of the highlight, linear RGB")
    shininess: Float = param(
        50, 0, 1e5, "exponent n of the highlight, its gloss", rougher=at_most_blinn_phong
    )
    caveats = (
        "Is not reciprocal: swapping the directions multiplies the highlight by the ratio of their "
        "cosines.",
        "Reflects more than it receives for a strong broad highlight: specular 1 adds "
        "8 pi / (n + 2) (1 - 2^(-n/2 - 1)) at the normal, more than 1 below shininess 23.1.",
        "A sharp highlight nearly vanishes: its peak stays the same while it gets narrower.",
    )
    unlike = (
        (
            "triace_blinn_phong",
            "has Fresnel, is normalised and reciprocal.",
        ),
        (
            "phong",
            "measures from the mirror direction; its exponent is a fourth as large for the same width.",
        ),
    )
    # A power of a cosine far from 1 magnifies its last bit by the exponent
    claims = Claims(energy=at_most(7.2832), reciprocity=at_most(1), float32=at_most(5e-5))

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """BRDF value in 1/sr, without the cosine."""
        return self.rho * INV_PI + self.specular * self.highlight(wi, wo)

    def highlight(self, wi: Vec3, wo: Vec3) -> Float:
        """The highlight without its weight."""
        return cos_power(wi + wo, self.shininess) / wi.z

    def highlight_albedo(self, split: Vec2) -> Color:
        """What the highlight reflects of light from everywhere, from its table's A and B."""
        return self.specular * (split.x + split.y)

    def image_lobes(self, mu: Float) -> ImageLobes:
        """The highlight and the diffuse part, for light from pictures."""
        return ImageLobes(blinn_phong_alpha(self.shininess), self.rho)

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Cosine-weighted, or the GGX lobe of the same width, whose longer tail bounds the weights."""
        wi = sample_matte_gloss(wo, blinn_phong_alpha(self.shininess), self._shares(wo), u)
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample` in 1/sr."""
        return pdf_matte_gloss(wi, wo, blinn_phong_alpha(self.shininess), self._shares(wo))

    def _shares(self, wo: Vec3) -> Vec2:
        """Probabilities of the diffuse lobe and of the highlight."""
        # 4 mu_h dw_h of a narrow lobe; half of it lies below the horizon at grazing angles
        highlight = 4 * PI / (self.shininess + 2) * (1 + wo.z)
        return shares(average(self.rho), average(self.specular) * highlight)
