"""Unity Standard: BRDF1, the full-quality shading of Unity's built-in render pipeline.

Source: "PBR theory, part 1: foundations" (SZ's temple, 2019), section 5, which walks through
UnityStandardBRDF.cginc of Unity 2018.2. Unity's own value is pi times f: its diffuse term is not divided
by pi and its highlight is multiplied by it. The article misses a division by 4 mu_i mu_o, but Unity's V
holds it already.
Where it departs from physics: k_d is the constant 0.96 (1 - metallic) in place of 1 - F, so that the
diffuse term takes no notice of the Fresnel reflection above it; V replaces sqrt(mu^2 + alpha^2 sin^2) of
Smith by mu (1 - alpha) + alpha.
Deviation: Unity adds 1e-5 to V's and 1e-7 to D's denominator, against division by zero; neither is here.
The second dims its highlights: the peak by 4 % at roughness 0.2, 28 % at 0.15 and 91 % at 0.1.
"""

from gonio.albedos.quadrature import NumericAlbedo
from gonio.claims import Claims, at_most
from gonio.lang import INV_PI, Color, Float, Sample, Vec2, Vec3, dot, lerp, maximum
from gonio.model import Model, param
from gonio.parts.distribution import RoundGGX
from gonio.parts.frame import half_vector
from gonio.parts.fresnel import schlick_weight, schlick_weight_half
from gonio.parts.image import ImageLobes, burley_albedo, schlick_albedo
from gonio.parts.lobes import average, shares
from gonio.parts.matte_gloss import pdf_matte_gloss, sample_matte_gloss
from gonio.parts.roughness import at_least_perceptual

F0_DIELECTRIC = 0.04  # reflectance of dielectrics (linear colour space)
ALPHA_UNITY = 0.002  # lower limit of alpha


class UnityStandard(Model):
    """Burley diffuse plus a GGX highlight with a cheaper Smith term. Reciprocal; gains energy."""

    numeric = NumericAlbedo("half_vectors")

    base_color: Color = param((0.8, 0.8, 0.8), 0, 1, "diffuse colour, or F0 of metals, linear RGB")
    metallic: Float = param(0, 0, 1, "0 for dielectrics, 1 for metals")
    roughness: Float = param(
        0.5, 0, 1, "perceptual roughness, 1 - Unity's smoothness", rougher=at_least_perceptual
    )
    caveats = (
        "Reflects more than it receives at grazing angles: a white dielectric 1.581 at most "
        "(roughness 1), and 1.007 at the normal.",
        "Against metallic_roughness, base colour 0.5: albedo 0.978 to 1.035 times as high at the "
        "normal, 0.889 (roughness 0) to 1.274 (roughness 1) times at 80 degrees.",
        "Its V is up to 29 % below height-correlated Smith (alpha 0.01), and equal at alpha 1.",
        "Loses what facets reflect more than once: a white metal of roughness 1 reflects 31 % at "
        "the normal.",
    )
    unlike = (
        ("unity_brdf2", "is the cheaper one of mobile devices."),
        (
            "metallic_roughness",
            "takes the highlight's light from the diffuse lobe; here its share is constant.",
        ),
    )
    claims = Claims(energy=at_most(1.581))

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """BRDF value in 1/sr, without the cosine."""
        r = self.roughness
        # F90 = 0.5 + 2 roughness cos^2(theta_d), and 2 cos^2(theta_d) = 1 + dot(wi, wo)
        rise = r * (1 + dot(wi, wo)) - 0.5
        burley = (1 + rise * schlick_weight(wi.z)) * (1 + rise * schlick_weight(wo.z))
        F = lerp(self._f0(), 1, schlick_weight_half(wi, wo))
        return INV_PI * burley * self._diffuse() + F * self.highlight(wi, wo)

    def highlight(self, wi: Vec3, wo: Vec3) -> Float:
        """D V: the highlight without F."""
        alpha = self._alpha()
        lambda_v = wi.z * lerp(alpha, 1, wo.z)
        lambda_l = wo.z * lerp(alpha, 1, wi.z)
        D = RoundGGX(alpha).D(half_vector(wi, wo))
        return D * (0.5 / (lambda_v + lambda_l))

    def highlight_albedo(self, split: Vec2) -> Color:
        """What the highlight reflects of light from everywhere, from its table's A and B."""
        return schlick_albedo(self._f0(), 1, split)

    def image_lobes(self, mu: Float) -> ImageLobes:
        """The highlight and the diffuse part, for light from pictures."""
        matte = self._diffuse() * burley_albedo(mu, self.roughness)
        return ImageLobes(self._alpha(), matte)

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Cosine-weighted or a visible GGX normal, by the estimated albedos."""
        wi = sample_matte_gloss(wo, self._alpha(), self._shares(wo), u)
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample` in 1/sr."""
        return pdf_matte_gloss(wi, wo, self._alpha(), self._shares(wo))

    def _alpha(self) -> Float:
        return maximum(self.roughness * self.roughness, ALPHA_UNITY)

    def _diffuse(self) -> Color:
        return (1 - F0_DIELECTRIC) * (1 - self.metallic) * self.base_color

    def _f0(self) -> Color:
        return lerp(F0_DIELECTRIC, self.base_color, self.metallic)

    def _shares(self, wo: Vec3) -> Vec2:
        """Probabilities of the diffuse lobe and of the highlight."""
        F = lerp(self._f0(), 1, schlick_weight(wo.z))
        return shares(average(self._diffuse()), average(F))
