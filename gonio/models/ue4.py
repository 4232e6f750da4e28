"""UE4: the shading model of Unreal Engine 4 as it was published.

Source: Karis, "Real shading in Unreal Engine 4", SIGGRAPH 2013 course "Physically based shading in
theory and practice": Lambert, GGX with alpha = roughness^2, Schlick's masking with
k = (roughness + 1)^2 / 8 for punctual lights and k = alpha / 2 for image-based light, F0 = 0.08 specular
for dielectrics.
Deviations: the Fresnel term is Schlick's power, which the engine replaces by
2^((-5.55473 (wo.H) - 6.98316) (wo.H)), at most 0.0038 from it; alpha is at least ALPHA_MIN.
"""

from gonio.albedos.quadrature import NumericAlbedo
from gonio.claims import Claims, at_most
from gonio.lang import INV_PI, Color, Float, Sample, Vec2, Vec3, lerp, maximum
from gonio.model import Model, option, param
from gonio.parts.distribution import ALPHA_MIN, RoundGGX
from gonio.parts.frame import half_vector
from gonio.parts.fresnel import schlick_weight, schlick_weight_half
from gonio.parts.image import ImageLobes, schlick_albedo
from gonio.parts.lobes import average, shares
from gonio.parts.masking import V_schlick, schlick_k_ggx, schlick_k_ue4
from gonio.parts.matte_gloss import pdf_matte_gloss, sample_matte_gloss
from gonio.parts.roughness import at_least_perceptual

# F0 of a dielectric with specular = 1; the default of 0.5 gives 0.04.
F0_SPECULAR = 0.08


class UE4(Model):
    """Lambert plus a GGX highlight, simply added. Reciprocal; white dielectrics gain energy."""

    numeric = NumericAlbedo("half_vectors")

    base_color: Color = param((0.8, 0.8, 0.8), 0, 1, "diffuse colour, or F0 of metals, linear RGB")
    metallic: Float = param(0, 0, 1, "0 for dielectrics, 1 for metals")
    specular: Float = param(0.5, 0, 1, "F0 of dielectrics in units of 0.08")
    roughness: Float = param(
        0.5, 0, 1, "perceptual roughness, alpha = roughness^2", rougher=at_least_perceptual
    )
    light: str = option(
        "punctual", "image", doc="which k the masking has: (roughness + 1)^2 / 8 or alpha / 2"
    )
    caveats = (
        "light='punctual' reflects more than it receives for white dielectrics: 1.040 at the "
        "normal, at most 1.171 (specular 1, roughness 0, 80 degrees), because Lambert is not "
        "reduced.",
        "light='image' does so too: at most 1.96 (specular 1, roughness 0, towards 90 degrees).",
        "Loses what facets reflect more than once: a white metal of roughness 1 reflects 31 % at "
        "the normal.",
    )
    unlike = (
        (
            "metallic_roughness",
            "takes the highlight's light from the diffuse lobe; this one adds the two.",
        ),
    )
    claims = Claims(energy=(at_most(1.171, light="punctual"), at_most(1.96, light="image")))

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """BRDF value in 1/sr, without the cosine."""
        F = lerp(self._f0(), 1, schlick_weight_half(wi, wo))
        diffuse = INV_PI * (1 - self.metallic) * self.base_color
        return diffuse + F * self.highlight(wi, wo)

    def highlight(self, wi: Vec3, wo: Vec3) -> Float:
        """D G / (4 mu_i mu_o): the highlight without F."""
        D = RoundGGX(self._alpha()).D(half_vector(wi, wo))
        return D * V_schlick(wi, wo, self._k())

    def highlight_albedo(self, split: Vec2) -> Color:
        """What the highlight reflects of light from everywhere, from its table's A and B."""
        return schlick_albedo(self._f0(), 1, split)

    def image_lobes(self, mu: Float) -> ImageLobes:
        """The highlight and the diffuse part, for light from pictures."""
        return ImageLobes(self._alpha(), (1 - self.metallic) * self.base_color)

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Cosine-weighted or a visible GGX normal, by the estimated albedos."""
        wi = sample_matte_gloss(wo, self._alpha(), self._shares(wo), u)
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample` in 1/sr."""
        return pdf_matte_gloss(wi, wo, self._alpha(), self._shares(wo))

    def _alpha(self) -> Float:
        return maximum(self.roughness * self.roughness, ALPHA_MIN)

    def _k(self) -> Float:
        """Schlick's k of the masking."""
        if self.light == "image":
            return schlick_k_ggx(self._alpha())
        return schlick_k_ue4(self.roughness)

    def _f0(self) -> Color:
        return lerp(F0_SPECULAR * self.specular, self.base_color, self.metallic)

    def _shares(self, wo: Vec3) -> Vec2:
        """Probabilities of the diffuse lobe and of the highlight."""
        F = lerp(self._f0(), 1, schlick_weight(wo.z))
        return shares(average((1 - self.metallic) * self.base_color), average(F))
