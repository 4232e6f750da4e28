"""Patina: copper that turns green, from bare metal to a closed layer.

Source: Elek, "Layered materials in real-time rendering", CESCG 2010, section 4.2: the layered model of
`weidlich_wilkie` with a coat of cuprite that also scatters, faded in by a map, which
`gonio.mitsuba.textures.growth_map` makes. Spatial variation is the host's business: growth is a number
here, and a texture gives each point its own.
Deviations: by default light that leaves the coat spreads by 1 / eta^2, without which the metal below is
eta^2 = 9.5 times too bright; facets are GGX's with Smith's masking instead of Beckmann's with V-cavities,
and F is exact instead of Lazányi's fit. Options restore each of these. The index that Elek mixes with the
patina's as that grows is the one of the environment's reflection alone: the metal below stays copper.
"""

from gonio.albedos.quadrature import NumericAlbedo
from gonio.claims import Claims, Place, at_most, kink
from gonio.lang import (
    INV_PI,
    Color,
    Float,
    Sample,
    Vec2,
    Vec3,
    clamp,
    length,
    lerp,
    maximum,
    normalize,
    select,
)
from gonio.model import Model, option, param
from gonio.parts.coat import (
    Round,
    attenuation_least,
    facets_of,
    pdf_facet,
    pdf_facets,
    reflected_by,
    sample_facet,
    sample_facets,
    through_facets,
    usual_cos_half,
    usual_sin2_half,
)
from gonio.parts.distribution import ALPHA_MIN
from gonio.parts.frame import cos_half, half_vector, mirror, sin2_half
from gonio.parts.fresnel import (
    F_conductor,
    F_conductor_half,
    F_lazanyi,
    F_lazanyi_half,
    Split,
    split_conductor,
    transmittance_lazanyi_conductor,
)
from gonio.parts.hemisphere import pdf_cosine, sample_cosine
from gonio.parts.image import ImageSurface
from gonio.parts.interface import (
    LOBE_MIN,
    attenuation,
    gather,
    leave,
    pdf_leave,
    refract,
    refracted_sin2_half,
    refracted_sum,
)
from gonio.parts.lobes import average, choose, shares
from gonio.parts.metals import metal
from gonio.parts.roughness import at_least_alpha
from gonio.parts.special import sum3

COPPER, CUPRITE = metal("Cu"), metal("Cu2O", neutral=True)

# Sharpest edge of the patina that can be asked for; 0 would divide by 0.
TRANSITION_MIN = 1e-3


class Patina(Model):
    """Copper under a growing green layer of cuprite. Reciprocal."""

    numeric = NumericAlbedo("half_vectors")

    growth: Float = param(0.5, 0, 1, "the map: where it is dark, the patina grows first")
    extent: Float = param(0.45, -1, 2, "from -transition (bare) to 1 + transition (closed)")
    transition: Float = param(0.65, TRANSITION_MIN, 1, "softness of the patina's edges")
    thickness: Float = param(1, 0, 5, "thickness of the patina, in the unit of sigma_a")
    sigma_a: Color = param((0.66, 0.3, 0.42), 0, 1, "absorption; 1 - sigma_a is the colour")
    alpha: Float = param(
        0.5, ALPHA_MIN, 1, "slope width of the patina's facets", rougher=at_least_alpha
    )
    bare_alpha: Float = param(
        0.15, ALPHA_MIN, 1, "slope width of the metal's facets where bare", rougher=at_least_alpha
    )
    grown_alpha: Float = param(
        0.5, ALPHA_MIN, 1, "slope width of the metal's facets below patina", rougher=at_least_alpha
    )
    metal_eta: Color = param(COPPER["eta"], 0.01, 20, "the metal's index; the default is copper")
    metal_k: Color = param(COPPER["k"], 0, 20, "the metal's extinction")
    coat_eta: Color = param(CUPRITE["eta"], 1, 5, "the patina's index; the default is cuprite")
    coat_k: Color = param(CUPRITE["k"], 0, 3, "the patina's extinction, at its surface only")
    tarnish: Float = param(0.5, 0, 1, "how much the metal has darkened; a texture can drive it")
    tarnish_tint: Color = param((0.45, 0.2, 0.08), 0, 1, "colour of the metal at tarnish 1")
    solid_angle: str = option("compressed", "none", doc="1 / eta^2 for light that leaves the coat")
    distribution: str = option("ggx", "beckmann", doc="of the patina's facets and of the metal's")
    masking: str = option(
        "smith_correlated",
        "cook_torrance",
        doc="of the facets; Elek's are V-cavities, cook_torrance",
    )
    fresnel: str = option("exact", "lazanyi", doc="of both layers; Elek's code has Lazányi's fit")
    caveats = (
        "Wastes the samples that the metal below the patina mirrors sideways: less than 1 % by default, "
        "and at most 5.5 %, where the patina's index is 1; half of them with V-cavities.",
        "The patina's diffuse part is added without being taken from what passes through it, so that a "
        "thin white patina over a mirror reflects more than it receives, and much more with every index "
        "free or solid_angle='none'. The default stays below 0.83.",
    )
    claims = Claims(
        energy=(at_most(15, solid_angle="none"), at_most(3.05)),
        wasted=(at_most(0.51, masking="cook_torrance"), at_most(0.059)),
        kinks=(
            kink(Place.EQUAL_COSINES, masking="cook_torrance"),
            kink(Place.ELSEWHERE, masking="cook_torrance"),
        ),
        # Near the normal, where what the patina keeps inside leaves by the azimuth that it had: the last
        # bits of that decide whether the narrowest facets mirror it
        float32_density=at_most(0.02),
        # A metal without absorption, whose index is below 1
        numeric_albedo=at_most(0.02),
    )

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """The bare and the coated metal, mixed: BRDF value in 1/sr, without the cosine."""
        m, cos_h = half_vector(wi, wo), cos_half(wi, wo)
        F = self._metal_F(cos_h, sin2_half(wi, wo))
        bare = F * reflected_by(self._bare_facets(), wi, wo, m, self.masking)
        return self._bare() * bare + self._grown() * self._coated(wi, wo)

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """One of the bare metal, the patina's surface, its diffuse part, and the metal below."""
        P_bare, P_coat, P_diffuse = self._shares(wo)
        excess = self._excess()
        on_bare, v = choose(P_bare.x, u)
        on_coat, s = choose(P_coat.x, v)
        on_diffuse, t = choose(P_diffuse.x, s)
        w_bare = sample_facets(self._bare_facets(), wo, v, self.masking)
        w_coat = sample_facets(self._facets(), wo, s, self.masking)
        wo_t = refract(wo, excess)
        m = sample_facet(self._facets_below(), wo_t, t, self.masking)
        w_below = leave(mirror(wo_t, m), excess)
        w_patina = select(on_coat, w_coat, select(on_diffuse, sample_cosine(t), w_below))
        wi = select(on_bare, w_bare, w_patina)
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample` in 1/sr."""
        P_bare, P_coat, P_diffuse = self._shares(wo)
        excess = self._excess()
        wi_t, wo_t = refract(wi, excess), refract(wo, excess)
        refracted = self._pdf_below(wi_t, wo_t, normalize(refracted_sum(wi, wo, excess)))
        w = gather(wi, excess)
        gathered = self._pdf_below(w, wo_t, half_vector(w, wo_t))
        below = pdf_leave(refracted, gathered, wi, wi_t, excess)
        coat = pdf_facets(self._facets(), wi, wo, self.masking)
        bare = pdf_facets(self._bare_facets(), wi, wo, self.masking)
        inside = P_diffuse.x * pdf_cosine(wi) + P_diffuse.y * below
        return P_bare.x * bare + P_bare.y * (P_coat.x * coat + P_coat.y * inside)

    def _pdf_below(self, wi_t: Vec3, wo_t: Vec3, m: Vec3) -> Float:
        """Density of what the metal below mirrors, inside the patina."""
        return pdf_facet(self._facets_below(), wo_t, m, cos_half(wi_t, wo_t), self.masking)

    def image_surface(self, mu: Float) -> ImageSurface:
        """What the surface mirrors of a picture: the index is mixed as the patina grows (Elek)."""
        bare, grown = self._bare(), self._grown()
        eta = bare * self.metal_eta + grown * self.coat_eta
        k = bare * self.metal_k + grown * self.coat_k
        alpha = bare * self._metal_alpha() + grown * self.alpha
        if self.fresnel == "lazanyi":
            return ImageSurface(F_lazanyi(mu, eta, k), alpha)
        return ImageSurface(F_conductor(mu, eta, k), alpha)

    def _grown(self) -> Float:
        """extentFactor: 1 - smoothstep(extent - transition, extent + transition, growth)."""
        rest = sum3(self.extent, -self.growth, self.transition) / (2 * self.transition)
        t = clamp(rest, 0, 1)
        return t * t * (3 - 2 * t)

    def _bare(self) -> Float:
        """1 - extentFactor, with all its digits: a sharp highlight counts however little of it is left."""
        rise = sum3(self.growth, -self.extent, self.transition) / (2 * self.transition)
        t = clamp(rise, 0, 1)
        return t * t * (3 - 2 * t)

    def _metal_alpha(self) -> Float:
        return self._bare() * self.bare_alpha + self._grown() * self.grown_alpha

    def _facets(self) -> Round:
        return facets_of(self.alpha, self.distribution)

    def _bare_facets(self) -> Round:
        return facets_of(self._metal_alpha(), self.distribution)

    def _facets_below(self) -> Round:
        """The metal's under the patina, at least as wide as those of the patina itself (Figure 2)."""
        return facets_of(maximum(self._metal_alpha(), self.alpha), self.distribution)

    def _excess(self) -> Float:
        """The patina's index for refraction, the mean of its channels, minus 1."""
        return average(self.coat_eta - 1)

    def _metal_F(self, cos_h: Float, sin2_h: Float) -> Color:
        """The metal's reflectance, as far as it has tarnished."""
        tint = lerp(1, self.tarnish_tint, self.tarnish)
        if self.fresnel == "lazanyi":
            return F_lazanyi_half(cos_h, sin2_h, self.metal_eta, self.metal_k) * tint
        return F_conductor_half(cos_h, sin2_h, self.metal_eta, self.metal_k) * tint

    def _surface(self, cos_h: Float, sin2_h: Float) -> Split:
        """Of the patina."""
        if self.fresnel == "lazanyi":
            return Split(
                F_lazanyi_half(cos_h, sin2_h, self.coat_eta, self.coat_k),
                transmittance_lazanyi_conductor(cos_h, self.coat_eta, self.coat_k),
            )
        return split_conductor(cos_h, self.coat_eta, self.coat_k)

    def _coated(self, wi: Vec3, wo: Vec3) -> Color:
        """Eq. 2 with a coat that scatters."""
        m, cos_h, excess = half_vector(wi, wo), cos_half(wi, wo), self._excess()
        index, surface = 1 + excess, self._surface(cos_h, sin2_half(wi, wo))
        facets = self._facets()
        glossy = reflected_by(facets, wi, wo, m, self.masking)
        coat = surface.F * glossy + (1 - self.sigma_a) * surface.T * INV_PI

        through = through_facets(facets, wi, wo, self.masking, surface.T)
        if self.solid_angle == "compressed":
            through = through / (index * index)
        wi_t, wo_t = refract(wi, excess), refract(wo, excess)
        kept = attenuation(self.sigma_a, self.thickness, wi_t, wo_t)
        both = refracted_sum(wi, wo, excess)
        cos_t = 0.5 * length(both) / index
        F = self._metal_F(cos_t, refracted_sin2_half(wi, wo, excess))
        below = self._facets_below()
        metal = F * reflected_by(below, wi_t, wo_t, normalize(both), self.masking)
        return coat + metal * through * kept

    def _shares(self, wo: Vec3) -> tuple[Vec2, Vec2, Vec2]:
        """Probabilities: bare metal or patina; of that, surface or not; of the rest, diffuse or below."""
        grown = self._grown()
        wo_t = refract(wo, self._excess())
        mu, sin2 = wo.z, (1 - wo.z) * (1 + wo.z)
        F = self._surface(mu, sin2).F
        T = self._surface(usual_cos_half(wo), usual_sin2_half(wo)).T
        F_metal = self._metal_F(mu, sin2)
        bare = self._bare() * average(F_metal)
        coat = grown * average(F)
        diffuse = grown * average((1 - self.sigma_a) * T)
        kept = attenuation_least(self.sigma_a, self.thickness, wo_t)
        below = grown * average(T * kept * F_metal) + LOBE_MIN
        inside = diffuse + below
        P_bare, P_coat = shares(bare, coat + inside), shares(coat, inside)
        P_diffuse = shares(diffuse, below)
        return P_bare, P_coat, P_diffuse
