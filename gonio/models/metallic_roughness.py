"""Metallic–roughness: one colour, a metalness and a roughness, the way games describe materials.

Source: "PBR theory, part 1: foundations" (SZ's temple, 2019), section 4, after Burley 2012: Lambert with
k_d = 1 - F and c_d = base_color (1 - metallic), Cook-Torrance with GGX, Smith and Schlick, F0 between
0.04 and the base colour. The text leaves Smith's form open: both are here.
Deviation: alpha = roughness^2 is at least ALPHA_MIN, where the highlight still is a function.
"""

from gonio.albedos.quadrature import NumericAlbedo
from gonio.claims import Claims, at_most
from gonio.lang import INV_PI, Color, Float, Sample, Vec2, Vec3, lerp, maximum
from gonio.model import Model, option, param
from gonio.parts.distribution import ALPHA_MIN, RoundGGX
from gonio.parts.frame import cos_half, half_vector
from gonio.parts.fresnel import schlick_complement, schlick_weight, schlick_weight_half
from gonio.parts.image import ImageLobes, left_by_facets, schlick_albedo
from gonio.parts.lobes import average, shares
from gonio.parts.masking import V_smith, V_smith_correlated
from gonio.parts.matte_gloss import pdf_matte_gloss, sample_matte_gloss
from gonio.parts.roughness import at_least_perceptual

# Reflectance of every dielectric at normal incidence.
F0_DIELECTRIC = 0.04


class MetallicRoughness(Model):
    """Diffuse below a GGX highlight, which takes its share of the light facet by facet. Reciprocal."""

    numeric = NumericAlbedo("half_vectors")

    base_color: Color = param((0.8, 0.8, 0.8), 0, 1, "diffuse colour, or F0 of metals, linear RGB")
    metallic: Float = param(0, 0, 1, "0 for dielectrics, 1 for metals")
    roughness: Float = param(
        0.5, 0, 1, "perceptual roughness, alpha = roughness^2", rougher=at_least_perceptual
    )
    masking: str = option(
        "smith_correlated", "smith", doc="Smith's G, correlated by height or G1(wi) G1(wo)"
    )
    caveats = (
        "Reflects more than it receives at grazing angles: k_d = 1 - F at the half vector leaves "
        "nearly all of the diffuse term beside the highlight. A white dielectric reaches 1.93 "
        "(roughness 0, 90 degrees).",
        "Loses what facets reflect more than once: a white metal of roughness 1 reflects 31 % at "
        "the normal.",
    )
    unlike = (
        ("ue4", "adds its two lobes; this one takes the highlight's light from the diffuse one."),
        ("unity_standard", "has Burley's diffuse lobe and a constant share."),
    )
    claims = Claims(energy=at_most(1.93))

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """BRDF value in 1/sr, without the cosine."""
        f0 = self._f0()
        F = lerp(f0, 1, schlick_weight_half(wi, wo))
        # 1 - F without its cancellation
        k_d = (1 - f0) * schlick_complement(cos_half(wi, wo))
        diffuse = INV_PI * (1 - self.metallic) * self.base_color * k_d
        return diffuse + F * self.highlight(wi, wo)

    def highlight(self, wi: Vec3, wo: Vec3) -> Float:
        """D G / (4 mu_i mu_o): the highlight without F."""
        facets = RoundGGX(self._alpha())
        D = facets.D(half_vector(wi, wo))
        if self.masking == "smith":
            return D * V_smith(facets, wi, wo)
        return D * V_smith_correlated(facets, wi, wo)

    def highlight_albedo(self, split: Vec2) -> Color:
        """What the highlight reflects of light from everywhere, from its table's A and B."""
        return schlick_albedo(self._f0(), 1, split)

    def image_lobes(self, mu: Float) -> ImageLobes:
        """The highlight and the diffuse part, for light from pictures."""
        k_d = (1 - self._f0()) * left_by_facets(mu)
        return ImageLobes(self._alpha(), (1 - self.metallic) * self.base_color * k_d)

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Cosine-weighted or a visible GGX normal, by the estimated albedos."""
        wi = sample_matte_gloss(wo, self._alpha(), self._shares(wo), u)
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample` in 1/sr."""
        return pdf_matte_gloss(wi, wo, self._alpha(), self._shares(wo))

    def _alpha(self) -> Float:
        return maximum(self.roughness * self.roughness, ALPHA_MIN)

    def _f0(self) -> Color:
        return lerp(F0_DIELECTRIC, self.base_color, self.metallic)

    def _shares(self, wo: Vec3) -> Vec2:
        """Probabilities of the diffuse lobe and of the highlight."""
        f0 = self._f0()
        diffuse = (1 - self.metallic) * self.base_color * (1 - f0)
        return shares(average(diffuse), average(lerp(f0, 1, schlick_weight(wo.z))))
