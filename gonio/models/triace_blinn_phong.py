"""tri-Ace Blinn–Phong: a normalised Blinn–Phong highlight with Fresnel, cheap enough for a console.

Source: Gotanda, "Beyond a simple physically based Blinn-Phong model in real-time", SIGGRAPH 2012
course "Practical physically based shading in film and game production", Eq. 1; Eq. 25 for the rough diffuse
part of its Figures 6, 11 and 14, which shares the highlight's exponent.
The course's shaders return pi f cos(theta_i); this is f. Its linear factor 0.0397436 n + 0.0856832 is a
fit of (n + 2) / (4 pi (2 - 2^(-n / 2))): within 0.6 % for n >= 10, 32 % too small at n = 1.
"""

from gonio.albedos.quadrature import NumericAlbedo
from gonio.claims import Claims, Place, at_most, kink
from gonio.lang import INV_PI, Color, Float, Sample, Vec2, Vec3, lerp, select
from gonio.model import Model, option, param
from gonio.parts import cltc
from gonio.parts.distribution import RoundGGX, blinn_phong_alpha
from gonio.parts.frame import tangential_dot
from gonio.parts.fresnel import schlick_weight, schlick_weight_half
from gonio.parts.image import ImageLobes, schlick_albedo
from gonio.parts.lobes import average, choose, pdf_ggx_lobe, sample_ggx_lobe, shares
from gonio.parts.matte_gloss import pdf_matte_gloss, sample_matte_gloss
from gonio.parts.oren_nayar import G_fujii, s_over_t_fujii
from gonio.parts.roughness import at_most_blinn_phong
from gonio.parts.triace import blinn_phong_highlight


class TriAceBlinnPhong(Model):
    """Lambert under a Blinn-Phong highlight with Schlick's Fresnel. Reciprocal."""

    numeric = NumericAlbedo("half_vectors")

    rho: Color = param((0.5, 0.5, 0.5), 0, 1, "diffuse albedo R_d, linear RGB")
    f0: Color = param((0.04, 0.04, 0.04), 0, 1, "reflectance at normal incidence, linear RGB")
    shininess: Float = param(50, 0, 1e5, "Blinn-Phong exponent n", rougher=at_most_blinn_phong)
    diffuse: str = option(
        "lambert", "oren_nayar", doc="Oren-Nayar is the course's Eq. 25, with the same shininess"
    )
    caveats = (
        "Loses energy: with f0 = 1 it reflects 36 % at the normal for shininess 1, 73 % for 10, "
        "93 % for 50, and less than 6 % at grazing angles from 50 on.",
        "Reflects more than it receives for white rho and low f0: at most 1.030 for f0 = 0.04 and "
        "1.066 for f0 = 0, at 80 degrees and high shininess.",
        "Has a kink where cos(phi_i - phi_o) changes sign, with diffuse='oren_nayar'.",
    )
    unlike = (
        ("blinn", "is the classic one, without Fresnel and normalisation."),
        (
            "phong",
            "measures from the mirror direction; its exponent is a fourth as large for the same width.",
        ),
    )
    claims = Claims(
        energy=at_most(1.066),
        # A power of a cosine far from 1 magnifies its last bit by the exponent
        float32=at_most(3e-5),
        kinks=(kink(Place.EQUAL_COSINES), kink(Place.SIDE_LIGHT, diffuse="oren_nayar")),
    )

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """Eq. 1 without the cosine and the factor pi: BRDF value in 1/sr."""
        F = lerp(self.f0, 1, schlick_weight_half(wi, wo))
        diffuse = self.rho * (1 - self.f0) * INV_PI
        if self.diffuse == "oren_nayar":
            n = self.shininess
            shape = s_over_t_fujii(tangential_dot(wi, wo), wi, wo)
            diffuse = diffuse * (1 - 1 / (2 + 0.65 * n) + 1 / (2.22222 + 0.1 * n) * shape)
        return diffuse + F * self.highlight(wi, wo)

    def highlight(self, wi: Vec3, wo: Vec3) -> Float:
        """The highlight of Eq. 1 without F."""
        return blinn_phong_highlight(wi, wo, self.shininess)

    def highlight_albedo(self, split: Vec2) -> Color:
        """What the highlight reflects of light from everywhere, from its table's A and B."""
        return schlick_albedo(self.f0, 1, split)

    def image_lobes(self, mu: Float) -> ImageLobes:
        """The highlight and the diffuse part, for light from pictures."""
        matte = self.rho * (1 - self.f0)
        if self.diffuse == "oren_nayar":
            n = self.shininess
            shape = 1 - 1 / (2 + 0.65 * n) + INV_PI * G_fujii(mu) / (2.22222 + 0.1 * n)
            matte = matte * shape
        return ImageLobes(blinn_phong_alpha(self.shininess), matte)

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Cosine-weighted, or the GGX lobe of the same width, whose longer tail bounds the weights."""
        alpha = blinn_phong_alpha(self.shininess)
        if self.diffuse == "lambert":
            wi = sample_matte_gloss(wo, alpha, self._shares(wo), u)
        else:
            matte, v = choose(self._shares(wo).x, u)
            rough = cltc.sample_cltc_matched(wo, self._roughness(), v)
            wi = select(matte, rough, sample_ggx_lobe(RoundGGX(alpha), wo, v))
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample` in 1/sr."""
        alpha, P = blinn_phong_alpha(self.shininess), self._shares(wo)
        if self.diffuse == "lambert":
            return pdf_matte_gloss(wi, wo, alpha, P)
        rough = cltc.pdf_cltc_matched(wi, wo, self._roughness())
        return P.x * rough + P.y * pdf_ggx_lobe(RoundGGX(alpha), wi, wo)

    def _roughness(self) -> Float:
        """EON's roughness with the same weight of s/t: B / A'."""
        n = self.shininess
        return 1 / ((2.22222 + 0.1 * n) * (1 - 1 / (2 + 0.65 * n)))

    def _shares(self, wo: Vec3) -> Vec2:
        """Probabilities of the diffuse lobe and of the highlight."""
        F = lerp(self.f0, 1, schlick_weight(wo.z))
        return shares(average(self.rho * (1 - self.f0)), average(F))
