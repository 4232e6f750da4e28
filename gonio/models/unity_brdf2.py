"""Unity BRDF2: the cheaper shading that Unity's built-in render pipeline takes on mobile devices.

Source: UnityStandardBRDF.cginc of Unity 2018.2, which "PBR theory, part 1: foundations" (SZ's temple,
2019), section 5, names beside BRDF1; the highlight is the one of "Optimizing PBR for mobile", SIGGRAPH
2015 course: masking and Fresnel together are 1 / ((wo.H)^2 (alpha + 0.5)). Unity's own value is pi times f.
Where it departs from physics: the highlight has the colour F0 at every angle, and nothing masks grazing
directions. Unity's constants are kept: at roughness 0 there is no highlight at all.
BRDF3, the lowest of the three, is absent: it reads its highlight from a table that is not public.
"""

from gonio.albedos.quadrature import NumericAlbedo
from gonio.claims import Claims, Place, at_most, kink
from gonio.lang import INV_PI, Color, Float, Sample, Vec2, Vec3, lerp, maximum, sqrt
from gonio.model import Model, param
from gonio.parts.frame import cos_half, half_vector
from gonio.parts.image import ImageLobes
from gonio.parts.lobes import average, shares
from gonio.parts.matte_gloss import pdf_matte_gloss, sample_matte_gloss
from gonio.parts.roughness import at_least_perceptual

# Unity's dielectric reflectance (linear colour space).
F0_DIELECTRIC = 0.04

# Unity's limits: of (wo.H)^2, and what its 1.00001 adds to the denominator of D.
COS2_UNITY = 0.1
D_UNITY = 1e-5


class UnityBRDF2(Model):
    """Lambert plus a highlight without masking and Fresnel. Reciprocal; gains energy."""

    numeric = NumericAlbedo("half_vectors")

    base_color: Color = param((0.8, 0.8, 0.8), 0, 1, "diffuse colour, or F0 of metals, linear RGB")
    metallic: Float = param(0, 0, 1, "0 for dielectrics, 1 for metals")
    roughness: Float = param(
        0.5, 0, 1, "perceptual roughness, 1 - Unity's smoothness", rougher=at_least_perceptual
    )
    caveats = (
        "Reflects more than it receives: white metals 1.869 at the normal at most (roughness "
        "0.15), white dielectrics 1.035.",
        "Has no highlight at roughness 0, and little below 0.05: a white metal of roughness 0.03 "
        "reflects 15 %.",
        "Has a kink where light and viewer are 143 degrees apart, from Unity's max(0.1, "
        "(wo.H)^2): numeric albedos are good to 1e-3 only.",
    )
    unlike = (("unity_standard", "is BRDF1, the full quality."),)
    claims = Claims(
        energy=at_most(1.871), numeric_albedo=at_most(1e-3), kinks=kink(Place.ELSEWHERE)
    )

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """BRDF value in 1/sr, without the cosine."""
        return INV_PI * self._diffuse() + self._specular() * self.highlight(wi, wo)

    def highlight(self, wi: Vec3, wo: Vec3) -> Float:
        """The highlight without its colour."""
        a = self.roughness * self.roughness
        m = half_vector(wi, wo)
        c = cos_half(wi, wo)
        # (N.H)^2 (a^2 - 1) + 1.00001, without its cancellation
        d = m.x * m.x + m.y * m.y + a * a * m.z * m.z + D_UNITY
        return INV_PI * (a * a / (4 * maximum(c * c, COS2_UNITY) * (a + 0.5) * d * d))

    def highlight_albedo(self, split: Vec2) -> Color:
        """What the highlight reflects of light from everywhere, from its table's A and B."""
        return self._specular() * (split.x + split.y)

    def image_lobes(self, mu: Float) -> ImageLobes:
        """The highlight and the diffuse part, for light from pictures."""
        return ImageLobes(self._alpha(), self._diffuse())

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Cosine-weighted or a visible GGX normal, by the estimated albedos."""
        wi = sample_matte_gloss(wo, self._alpha(), self._shares(wo), u)
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample` in 1/sr."""
        return pdf_matte_gloss(wi, wo, self._alpha(), self._shares(wo))

    def _alpha(self) -> Float:
        """Width of the GGX that d is the denominator of: D_UNITY never lets it vanish."""
        a2 = self.roughness * self.roughness * self.roughness * self.roughness
        return sqrt((a2 + D_UNITY) / (1 + D_UNITY))

    def _diffuse(self) -> Color:
        return (1 - F0_DIELECTRIC) * (1 - self.metallic) * self.base_color

    def _specular(self) -> Color:
        return lerp(F0_DIELECTRIC, self.base_color, self.metallic)

    def _shares(self, wo: Vec3) -> Vec2:
        """Probabilities of the diffuse lobe and of the highlight."""
        # The highlight's albedo at the normal is near 1 / (a + 0.5), times the part that D_UNITY leaves.
        a = self.roughness * self.roughness
        # In two quotients, as alpha^2 may be less than a float32 holds.
        reflected = a / (a * a + D_UNITY) * (a / (a + 0.5))
        return shares(average(self._diffuse()), average(self._specular()) * reflected)
