"""Disney: the principled model of 2012, all eleven parameters.

Source: Burley, "Physically-based shading at Disney", SIGGRAPH 2012 course notes, section 5 and appendix B,
and its reference code disney.brdf. In the notes the masking of the highlight has its own width
(0.5 + roughness / 2)^2, the same along x and y; the code was changed later to the highlight's own widths,
which masking="anisotropic" gives.
Deviation: base_color is linear here, the code takes it with a gamma of 2.2.
"""

from gonio.albedos.quadrature import NumericAlbedo
from gonio.claims import Claims, at_most
from gonio.lang import (
    INV_PI,
    PI,
    Color,
    Float,
    Sample,
    Vec2,
    Vec3,
    dot,
    lerp,
    maximum,
    select,
    sqrt,
    vec2,
    vec3,
)
from gonio.model import Model, option, param
from gonio.parts.distribution import GGX, GTR1, RoundGGX, anisotropic_alpha
from gonio.parts.frame import cos_half, half_length, half_vector, mirror, pdf_mirror
from gonio.parts.fresnel import schlick_complement, schlick_weight, schlick_weight_half
from gonio.parts.hemisphere import pdf_cosine, pdf_uniform, sample_cosine, sample_uniform
from gonio.parts.image import (
    ImageLobes,
    burley_albedo,
    lost_at_facets,
    scattered_albedo,
    schlick_albedo,
)
from gonio.parts.lobes import average, choose, pdf_ggx_lobe, sample_ggx_lobe, shares
from gonio.parts.masking import V_smith
from gonio.parts.roughness import at_least_perceptual

# The reference code's numbers.
ALPHA_DISNEY = 0.001  # smallest width of the highlight
F0_SPECULAR = 0.08  # F0 at specular 1
COAT_ALPHA_SATIN = 0.1  # width of the clearcoat without gloss
COAT_ALPHA_GLOSS = 0.001  # and with it
COAT_ALPHA_MASKING = 0.25  # width by which the clearcoat's facets hide each other
COAT_F0 = 0.04  # the clearcoat's, of an index of 1.5
COAT_STRENGTH = 0.25

# Estimate of the white sheen's albedo, for the choice of lobes only.
SHEEN_ALBEDO = 0.06

# Smallest luminance that is divided by.
LUMINANCE_MIN = 1e-18


class Disney(Model):
    """Artists' model of cloth, plastic, metal and lacquer. Reciprocal; gains energy at grazing angles."""

    numeric = NumericAlbedo("half_vectors", stretched=True, round_part=True)
    isotropic = False

    base_color: Color = param((0.8, 0.8, 0.8), 0, 1, "surface colour, linear RGB")
    subsurface: Float = param(0, 0, 1, "blend from rough diffuse to a flat subsurface look")
    metallic: Float = param(0, 0, 1, "0 for dielectrics, 1 for metals")
    specular: Float = param(0.5, 0, 1, "F0 of dielectrics in units of 0.08")
    specular_tint: Float = param(0, 0, 1, "how much of the base colour's hue the dielectric F0 has")
    roughness: Float = param(
        0.5, 0, 1, "perceptual roughness, alpha = roughness^2", rougher=at_least_perceptual
    )
    anisotropic: Float = param(0, 0, 1, "stretches the highlight along x: aspect sqrt(1 - 0.9 a)")
    sheen: Float = param(0, 0, 1, "additional grazing reflection, for cloth")
    sheen_tint: Float = param(0.5, 0, 1, "how much of the base colour's hue the sheen has")
    clearcoat: Float = param(0, 0, 1, "strength of a second, colourless highlight")
    clearcoat_gloss: Float = param(1, 0, 1, "0 for a satin clearcoat, 1 for a glossy one")
    masking: str = option(
        "remapped",
        "anisotropic",
        doc="width of the highlight's G: (0.5 + roughness/2)^2 of 2012, or the highlight's own",
    )
    caveats = (
        "Reflects more than it receives at grazing angles: at most 1.601 for white of roughness "
        "1, 1.689 with sheen, 1.734 with sheen, clearcoat and specular 1.",
        "Anisotropic metals gain energy, because the masking of 2012 does not know of the "
        "stretch: white of anisotropic 1 reaches 1.681 (roughness 0.85). masking='anisotropic' "
        "does not.",
        "Tints have a luminance of 1: blue's is 10, and a blue cloth with tinted sheen reflects "
        "up to 2.9 times the blue light; with an anisotropic specular tint as well, up to 3.82.",
        "Loses what facets reflect more than once: a white metal of roughness 1 reflects 31 % at "
        "the normal.",
        "Wastes the samples that the clearcoat's facets mirror below the horizon, at most 16 %.",
    )
    unlike = (
        (
            "metallic_roughness",
            "is the part of its parameters that games use, with another highlight's share.",
        ),
    )
    claims = Claims(
        energy=(at_most(3, masking="anisotropic"), at_most(3.82)),
        wasted=at_most(0.165),
        numeric_albedo=(at_most(4e-4, masking="anisotropic"), at_most(1e-4)),
    )

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """BRDF value in 1/sr, without the cosine."""
        F = lerp(self._f0(), 1, schlick_weight_half(wi, wo))
        return self.eval_round(wi, wo) + F * self.highlight(wi, wo)

    def highlight(self, wi: Vec3, wo: Vec3) -> Float:
        """The highlight without F."""
        return self._facets().D(half_vector(wi, wo)) * self._V(wi, wo)

    def highlight_albedo(self, split: Vec2) -> Color:
        """What the highlight reflects of light from everywhere, from its table's A and B."""
        return schlick_albedo(self._f0(), 1, split)

    def image_lobes(self, mu: Float) -> ImageLobes:
        """The highlight and the diffuse part, without clearcoat, for light from pictures."""
        widths = self.slope_widths()
        scattered = scattered_albedo(mu, self.roughness)
        flat = lerp(burley_albedo(mu, self.roughness), scattered, self.subsurface)
        sheen = self._sheen() * PI * lost_at_facets(mu)
        matte = (1 - self.metallic) * (flat * self.base_color + sheen)
        return ImageLobes(sqrt(widths.x * widths.y), matte)

    def eval_round(self, wi: Vec3, wo: Vec3) -> Color:
        """All but the highlight: diffuse, sheen and clearcoat, which are not stretched."""
        # Diffuse with retro-reflection
        F_i, F_o = schlick_weight(wi.z), schlick_weight(wo.z)
        c = cos_half(wi, wo)
        F90 = c * c * self.roughness
        rise = 2 * F90 - 0.5
        F_d = (1 + rise * F_i) * (1 + rise * F_o)
        # Hanrahan-Krueger's isotropic subsurface scattering; 1 + (F90 - 1) F as a sum of positive terms
        F_ss = (schlick_complement(wi.z) + F90 * F_i) * (schlick_complement(wo.z) + F90 * F_o)
        scattered = 1.25 * (F_ss * (1 / (wi.z + wo.z) - 0.5) + 0.5)
        diffuse = INV_PI * lerp(F_d, scattered, self.subsurface) * self.base_color
        F_H = schlick_weight_half(wi, wo)
        base = (1 - self.metallic) * (diffuse + F_H * self._sheen())

        D_c = self._coat().D_narrow(half_vector(wi, wo))
        V_c = V_smith(RoundGGX(COAT_ALPHA_MASKING), wi, wo)
        F_c = self.clearcoat * lerp(COAT_STRENGTH * COAT_F0, COAT_STRENGTH, F_H)
        return base + F_c * (D_c * V_c)

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Cosine-weighted, a visible GGX normal or a clearcoat normal, by the estimated albedos."""
        diffuse, v = choose(self._diffuse_shares(wo).x, u)
        highlight, w = choose(self._specular_shares(wo).x, v)
        coat = mirror(wo, self._coat().sample(w))
        specular = select(highlight, sample_ggx_lobe(self._facets(), wo, w), coat)
        uniform, t = choose(self._uniform_share(), v)
        wi = select(diffuse, select(uniform, sample_uniform(t), sample_cosine(t)), specular)
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample` in 1/sr."""
        P, Q = self._diffuse_shares(wo), self._specular_shares(wo)
        m = half_vector(wi, wo)
        coat = pdf_mirror(self._coat().D_narrow(m) * m.z, half_length(wi, wo))
        specular = Q.x * pdf_ggx_lobe(self._facets(), wi, wo) + Q.y * coat
        diffuse = lerp(pdf_cosine(wi), pdf_uniform(), self._uniform_share())
        return P.x * diffuse + P.y * specular

    def slope_widths(self) -> Vec2:
        """As the highlight's."""
        facets = self._facets()
        return vec2(facets.alpha_x, facets.alpha_y)

    def _facets(self) -> GGX:
        """The facets of the highlight."""
        alpha = self.roughness * self.roughness
        a = anisotropic_alpha(alpha, self.anisotropic)
        return GGX(maximum(a.x, ALPHA_DISNEY), maximum(a.y, ALPHA_DISNEY))

    def _V(self, wi: Vec3, wo: Vec3) -> Float:
        """Masking of the highlight, G / (4 mu_i mu_o)."""
        if self.masking == "anisotropic":
            return V_smith(self._facets(), wi, wo)
        alpha_g = (0.5 + 0.5 * self.roughness) * (0.5 + 0.5 * self.roughness)
        return V_smith(RoundGGX(alpha_g), wi, wo)

    def _coat(self) -> GTR1:
        """The clearcoat's facets."""
        return GTR1(lerp(COAT_ALPHA_SATIN, COAT_ALPHA_GLOSS, self.clearcoat_gloss))

    def _tint(self) -> Color:
        """The base colour's hue and saturation, with a luminance of 1."""
        color = self.base_color
        luminance = dot(color, vec3(0.3, 0.6, 0.1))
        tint = color / maximum(luminance, LUMINANCE_MIN)
        return select(luminance > 0, tint, 1)

    def _sheen(self) -> Color:
        return self.sheen * lerp(1, self._tint(), self.sheen_tint)

    def _f0(self) -> Color:
        dielectric = F0_SPECULAR * self.specular * lerp(1, self._tint(), self.specular_tint)
        return lerp(dielectric, self.base_color, self.metallic)

    def _uniform_share(self) -> Float:
        """Part of the diffuse samples that is uniform: the subsurface term is like 1 / mu at grazing."""
        return 0.5 * self.subsurface

    def _diffuse_shares(self, wo: Vec3) -> Vec2:
        """Probabilities of the diffuse lobe and of the two others."""
        base = self.base_color + SHEEN_ALBEDO * self._sheen()
        diffuse = average((1 - self.metallic) * base)
        return shares(diffuse, self._highlight_albedo(wo) + self._coat_albedo(wo))

    def _specular_shares(self, wo: Vec3) -> Vec2:
        """Probabilities of the highlight and of the clearcoat, if it is not the diffuse lobe."""
        return shares(self._highlight_albedo(wo), self._coat_albedo(wo))

    def _highlight_albedo(self, wo: Vec3) -> Float:
        """An estimate, for the choice of lobes."""
        return average(lerp(self._f0(), 1, schlick_weight(wo.z)))

    def _coat_albedo(self, wo: Vec3) -> Float:
        """An estimate, for the choice of lobes."""
        return COAT_STRENGTH * self.clearcoat * lerp(COAT_F0, 1, schlick_weight(wo.z))
