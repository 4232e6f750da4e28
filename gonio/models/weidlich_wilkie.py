"""Weidlich–Wilkie: a rough clear coat over any base, which may be coated itself.

Source: Elek, "Layered materials in real-time rendering", CESCG 2010, Eq. 2 to 4 and Algorithm 1, after
Weidlich, Wilkie, "Arbitrarily layered micro-facet surfaces", GRAPHITE 2007. Symbols are Elek's.
Deviations: refracted directions keep the azimuth of the ones they belong to (Algorithm 1 mirrors them at
the normal, which would turn an anisotropic base by 180 degrees); F is exact by default, not Lazányi's fit;
D carries the 1 / pi that Elek's lacks; a coloured coat, which has an index and an extinction for each
channel as in Algorithm 1, refracts by one index. What Eq. 2 leaves out can be switched on: Fresnel's
reflection at both crossings, the compression of solid angles, and the light that bounces between base and
surface.
"""

from gonio.albedos.quadrature import NumericAlbedo
from gonio.claims import Claims, Place, at_most, kink
from gonio.fields import ModelError
from gonio.lang import Color, Float, Sample, Vec2, Vec3, exp, maximum, minimum, safe_sqrt, select
from gonio.model import Model, child, option, param
from gonio.parts.coat import attenuation_least, optical_depth, past_facets, usual_cos_half
from gonio.parts.distribution import ALPHA_MIN, BlinnPhong, Gaussian, RoundBeckmann, RoundGGX
from gonio.parts.frame import cos_half, half_length, half_vector, mirror, pdf_mirror, sin2_half
from gonio.parts.fresnel import (
    F_conductor,
    F_dielectric_entering,
    F_lazanyi_half,
    split_conductor,
    transmittance_entering,
    transmittance_lazanyi,
    transmittance_lazanyi_conductor,
)
from gonio.parts.image import ImageCoat
from gonio.parts.interface import (
    LOBE_MIN,
    attenuation,
    critical_cosine,
    diffuse_reflectance,
    diffuse_return,
    gather,
    leave,
    pdf_leave,
    refract,
)
from gonio.parts.lobes import average, choose, pdf_ggx_lobe, sample_ggx_lobe, shares
from gonio.parts.masking import (
    G_cook_torrance,
    V_cook_torrance,
    V_smith,
    V_smith_correlated,
    lost_cook_torrance,
    lost_smith,
    lost_smith_correlated,
)
from gonio.parts.roughness import at_least_alpha

# The coat gets at least a tenth as many samples as the base: facets reflect more than the mean surface
# where they are tilted, and this bounds their weight.
COAT_SHARE_MIN = 0.1

# The coat reflects each channel by an index of its own.
COLOURED = ("conductor", "lazanyi_conductor")


class WeidlichWilkie(Model):
    """A clear, tinted coat over any base; nest it for more layers. Reciprocal if the base is."""

    numeric = NumericAlbedo("half_vectors")

    eta: Float = param(1.5, 1, 3, "index of the coat over that of the medium above it")
    alpha: Float = param(
        0.1,
        ALPHA_MIN,
        1,
        "slope width of the coat's facets; unused when smooth",
        rougher=at_least_alpha,
    )
    mirror_eta: Color = param(
        (1.5, 1.5, 1.5), 1, 10, "index by which a coloured coat reflects; eta refracts"
    )
    mirror_k: Color = param((0, 0, 0), 0, 10, "extinction by which a coloured coat reflects")
    sigma_a: Color = param((0, 0, 0), 0, 10, "absorption of the coat per unit of thickness")
    thickness: Float = param(1, 0, 1, "thickness of the coat, in the unit of sigma_a")
    base: Model = child("lambert", "what lies below; its indices are relative to the coat")
    interface: str = option(
        "rough", "smooth", doc="a smooth coat's mirror reflection is no function and is left out"
    )
    distribution: str = option(
        "beckmann",
        "ggx",
        "blinn_phong",
        "gaussian",
        doc="of the coat's facets; Blinn-Phong's exponent is 2 / alpha^2 - 2",
    )
    masking: str = option(
        "cook_torrance",
        "smith_correlated",
        "smith",
        doc="of the coat's facets, and G of Eq. 4; Smith's is GGX's own or Beckmann's",
    )
    fresnel: str = option(
        "exact",
        "lazanyi",
        "conductor",
        "lazanyi_conductor",
        doc="of the coat, exact or Lazányi's fit as in Elek's code; the last two are coloured, by "
        "mirror_eta and mirror_k",
    )
    transmission: str = option(
        "half_vector", "both_ways", doc="T12 t of Eq. 2 and 4, or T(wi) T(wo) at the mean surface"
    )
    solid_angle: str = option("none", "compressed", doc="1 / eta^2 for light that leaves the coat")
    bounces: str = option(
        "none", "diffuse", doc="light between surface and base, for a diffuse base: a series"
    )
    roughness_clamp: str = option(
        "on",
        "off",
        doc="the base's highlights are at least as wide as the coat's facets (Figure 2)",
    )
    caveats = (
        "As printed it reflects more than it receives: at eta 1.5 up to 1.68 over white Lambert (grazing) "
        "and 1.98 over a mirror (eta^2 = 2.25). transmission='both_ways' with solid_angle='compressed' "
        "stays below 1.",
        "bounces='diffuse' is exact for a smooth coat over Lambert; over rough white EON it gains up to "
        "6 %, and over a mirror it does not apply and gains up to 140 %. Of a base that reflects more than "
        "it receives it takes a mean albedo of 1.",
        "bounces='diffuse' needs the base's mean albedo: a base without a closed form is integrated at "
        "every point, which takes minutes.",
        "A rough coat loses what its facets reflect more than once: at eta 1.5, alpha 0.3 and 75 degrees a "
        "white base leaves 85 % with all options on.",
        "Wastes the samples that a facet mirrors below the horizon, with masking='cook_torrance': at most "
        "half of them, 51.3 % of Gaussian facets.",
        "A rough coat widens the highlights right below it: through a coat that is smooth or has "
        "roughness_clamp='off' it does not reach those below that one.",
        "A coat under a denser one, which needs eta < 1, is not covered: past the critical angle its light "
        "ends at a jump that numeric albedos miss by up to 1.5 %.",
        "float32 knows 1 - G of V-grooves to 1e-14, no better: where they begin to hide each other and wi "
        "is opposite to wo, both below cosines of 1e-9, one of 30,000 pairs aimed there is off by more "
        "than 1e-5, up to 1e-4. Exports know it to 1e-7: there 6 % at cosines of 1e-7, 4e-5 at 1e-3.",
        "Nothing scatters inside the coat, and refraction does not blur the base but for the roughness "
        "clamp.",
    )
    unlike = (
        (
            "triace_layered",
            "is one glossy layer over a glossy and matte one; this one covers any base.",
        ),
    )
    claims = Claims(
        energy=(
            at_most(10.13, bounces="diffuse"),
            at_most(2, interface="rough", transmission="half_vector"),
        ),
        wasted=(
            at_most(0.513, interface="rough", masking="cook_torrance", distribution="gaussian"),
            at_most(0.501, interface="rough", masking="cook_torrance"),
        ),
        numeric_albedo=(
            at_most(0.007, masking="cook_torrance", interface="rough"),
            at_most(1e-4, masking=("smith", "smith_correlated")),
        ),
        kinks=(
            kink(Place.EQUAL_COSINES, masking="cook_torrance", interface="rough"),
            kink(Place.ELSEWHERE, masking="cook_torrance", interface="rough"),
        ),
    )

    def check_together(self) -> None:
        """Refuse a series of bounces below a coloured coat."""
        if self.bounces != "none" and self.fresnel in COLOURED:
            raise ModelError(
                f"{self.name}: bounces={self.bounces!r} is a series of reflections by one index, got "
                f"fresnel={self.fresnel!r} with one for each channel; take 'exact' or 'lazanyi'."
            )

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """Eq. 2: BRDF value in 1/sr, without the cosine."""
        wi_t, wo_t = refract(wi, self.eta - 1), refract(wo, self.eta - 1)
        kept = attenuation(self.sigma_a, self.thickness, wi_t, wo_t)
        through = self._transmitted(wi, wo) * self._compression()
        below = self._below().eval_above(wi_t, wo_t) * (kept * through)
        if self.bounces == "diffuse":
            back = diffuse_return(self._optical_depth(), self.eta)
            below = below / (1 - self._returned() * back)
        if self.interface == "smooth":
            return below
        F = self._F(cos_half(wi, wo), sin2_half(wi, wo))
        coat = F * self._facets().D(half_vector(wi, wo)) * self._V(wi, wo)
        return below + coat

    def image_coat(self, wo: Vec3) -> ImageCoat:
        """The coat as light from a picture sees it, which comes from the mirror direction or all sides."""
        wo_t = refract(wo, self.eta - 1)
        tau, compression = self._optical_depth(), self._compression()
        T = self._T(wo.z)
        # In the mirror direction wi' is as steep as wo', and solid angles are eta^2 times as wide outside.
        stretch = self.eta * self.eta * compression
        glossy = T * T * stretch * attenuation(self.sigma_a, self.thickness, wo_t, wo_t)
        if self.transmission == "both_ways":
            through = T * (1 - diffuse_reflectance(self.eta))
        else:
            usual = self._T(usual_cos_half(wo))
            through = usual * usual
        # Mean of 1 / mu_i' over diffuse light from outside: 2 eta^2 (1 - sqrt(1 - 1 / eta^2))
        slant = 2 / (1 + safe_sqrt(1 - 1 / (self.eta * self.eta)))
        matte = through * compression * exp(-tau * (slant + 1 / wo_t.z))
        if self.bounces == "diffuse":
            matte = matte / (1 - self._returned() * diffuse_return(tau, self.eta))
        reflected = self._F_outside(wo.z) if self.interface == "rough" else 0
        least = self.alpha if self.interface == "rough" and self.roughness_clamp == "on" else 0
        c = critical_cosine(self.eta - 1)
        return ImageCoat(reflected, glossy, matte, wo_t, least, (1 - c) / (1 + c))

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """The coat by visible normals or the base below, chosen by what the coat reflects and absorbs."""
        wo_t = refract(wo, self.eta - 1)
        if self.interface == "smooth":
            wi = self._below().sample_leaving(wo_t, u, self.eta - 1)
            return Sample(wi, self.pdf(wi, wo))
        on_coat, v = choose(self._shares(wo, wo_t).x, u)
        w_base = self._below().sample_leaving(wo_t, v, self.eta - 1)
        wi = select(on_coat, self._sample_coat(wo, v), w_base)
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample` in 1/sr."""
        wo_t = refract(wo, self.eta - 1)
        below = self._below().pdf_leaving(wi, wo_t, self.eta - 1)
        if self.interface == "smooth":
            return below
        P = self._shares(wo, wo_t)
        return P.x * self._pdf_coat(wi, wo) + P.y * below

    def sample_leaving(self, wo: Vec3, u: Vec2, excess: Float) -> Vec3:
        """Of a coat under others. What comes from the base leaves all of them at once, by one index."""
        wo_t, deeper = refract(wo, self.eta - 1), self._excess_below(excess)
        if self.interface == "smooth":
            return self._below().sample_leaving(wo_t, u, deeper)
        on_coat, v = choose(self._shares(wo, wo_t).x, u)
        w_base = self._below().sample_leaving(wo_t, v, deeper)
        return select(on_coat, leave(self._sample_coat(wo, v), excess), w_base)

    def pdf_leaving(self, wi: Vec3, wo: Vec3, excess: Float) -> Float:
        """Density of `sample_leaving` in 1/sr."""
        wo_t = refract(wo, self.eta - 1)
        below = self._below().pdf_leaving(wi, wo_t, self._excess_below(excess))
        if self.interface == "smooth":
            return below
        P = self._shares(wo, wo_t)
        wi_here = refract(wi, excess)
        gathered = self._pdf_coat(gather(wi, excess), wo)
        coat = pdf_leave(self._pdf_coat(wi_here, wo), gathered, wi, wi_here, excess)
        return P.x * coat + P.y * below

    def _excess_below(self, excess: Float) -> Float:
        """The product of the indices down to this layer, minus 1; excess: down to the one above it."""
        return excess + (1 + excess) * (self.eta - 1)

    def facet_terms(self, wi: Vec3, wo: Vec3) -> dict[str, Float]:
        """D and G of the coat at a pair of directions; for plots."""
        return {"D": self._facets().D(half_vector(wi, wo)), "G": self._G(wi, wo)}

    def reflectances(self, cos_theta: Float) -> dict[str, Color]:
        """F of the coat at a cosine outside, and what both crossings let through; for plots."""
        T = self._T(cos_theta)
        return {"F, coat": self._F_outside(cos_theta), "T, there and back": T * T}

    def _sample_coat(self, wo: Vec3, u: Vec2) -> Vec3:
        """A direction that the coat mirrors.

        Visible normals need a G that is no larger than Smith's G1: with Cook-Torrance's the weights would
        grow like alpha / mu_o in the horizon. Those of all normals are at most 2.
        """
        if self.masking != "cook_torrance":
            return sample_ggx_lobe(RoundGGX(self.alpha), wo, u)
        return mirror(wo, self._facets().sample(u))

    def _pdf_coat(self, wi: Vec3, wo: Vec3) -> Float:
        if self.masking != "cook_torrance":
            return pdf_ggx_lobe(RoundGGX(self.alpha), wi, wo)
        density = self._facets().density(half_vector(wi, wo))
        return pdf_mirror(density, half_length(wi, wo))

    def _optical_depth(self) -> Color:
        """Optical depth of the coat along its normal (Eq. 3)."""
        return optical_depth(self.sigma_a, self.thickness)

    def _below(self) -> Model:
        """The base with the roughness that the coat leaves it."""
        if self.interface == "smooth" or self.roughness_clamp == "off":
            return self.base
        return self.base.at_least_as_rough(self.alpha)

    def _F_outside(self, mu: Float) -> Color:
        """At the mean surface."""
        return self._F(mu, (1 - mu) * (1 + mu))

    def _F(self, cos_h: Float, sin2_h: Float) -> Color:
        """At a facet."""
        if self.fresnel == "conductor":
            return F_conductor(cos_h, self.mirror_eta, self.mirror_k)
        if self.fresnel == "lazanyi_conductor":
            return F_lazanyi_half(cos_h, sin2_h, self.mirror_eta, self.mirror_k)
        if self.fresnel == "exact":
            return F_dielectric_entering(cos_h, self.eta)
        return F_lazanyi_half(cos_h, sin2_h, self.eta, 0)

    def _T(self, cos_theta: Float) -> Color:
        """1 - F."""
        if self.fresnel == "conductor":
            return split_conductor(cos_theta, self.mirror_eta, self.mirror_k).T
        if self.fresnel == "lazanyi_conductor":
            return transmittance_lazanyi_conductor(cos_theta, self.mirror_eta, self.mirror_k)
        if self.fresnel == "exact":
            return transmittance_entering(cos_theta, self.eta)
        return transmittance_lazanyi(cos_theta, self.eta)

    def _gray(self, F_or_T: Color) -> Float:
        """The mean of the channels of a coloured coat, to choose lobes with."""
        if self.fresnel in COLOURED:
            return average(F_or_T)
        return F_or_T

    def _facets(self) -> RoundBeckmann | RoundGGX | BlinnPhong | Gaussian:
        if self.distribution == "beckmann":
            return RoundBeckmann(self.alpha)
        if self.distribution == "blinn_phong":
            return BlinnPhong(self.alpha)
        if self.distribution == "gaussian":
            return Gaussian(self.alpha)
        return RoundGGX(self.alpha)

    def _masked(self) -> RoundBeckmann | RoundGGX:
        """Facets whose Smith masking it is: those that have none take that of Beckmann's, as wide."""
        if self.distribution == "ggx":
            return RoundGGX(self.alpha)
        return RoundBeckmann(self.alpha)

    def _G(self, wi: Vec3, wo: Vec3) -> Float:
        if self.masking == "cook_torrance":
            return G_cook_torrance(wi, wo)
        return 4 * wi.z * wo.z * self._V(wi, wo)

    def _V(self, wi: Vec3, wo: Vec3) -> Float:
        """G / (4 mu_i mu_o)."""
        if self.masking == "cook_torrance":
            return V_cook_torrance(wi, wo)
        if self.masking == "smith_correlated":
            return V_smith_correlated(self._masked(), wi, wo)
        return V_smith(self._masked(), wi, wo)

    def _transmitted(self, wi: Vec3, wo: Vec3) -> Color:
        """T12 t: what the surface lets in and out again."""
        if self.transmission == "both_ways":
            return self._T(wi.z) * self._T(wo.z)
        T = self._T(cos_half(wi, wo))
        if self.interface == "smooth":
            return T * T
        # Eq. 4
        return past_facets(T, self._lost(wi, wo))

    def _lost(self, wi: Vec3, wo: Vec3) -> Float:
        """1 - G."""
        if self.masking == "cook_torrance":
            return lost_cook_torrance(wi, wo)
        if self.masking == "smith_correlated":
            return lost_smith_correlated(self._masked(), wi, wo)
        return lost_smith(self._masked(), wi, wo)

    def _returned(self) -> Color:
        """What the base sends back of light from all sides."""
        # With a base that gains energy, as a coat does as printed, the series has no sum
        return minimum(self.base.mean_albedo(), 1)

    def _compression(self) -> Float:
        if self.solid_angle == "compressed":
            return 1 / (self.eta * self.eta)
        return 1

    def _shares(self, wo: Vec3, wo_t: Vec3) -> Vec2:
        """Probabilities of the coat and of the base: their parts of the light, if the base were white."""
        mu = usual_cos_half(wo) if self.transmission == "half_vector" else wo.z
        through = self._gray(self._T(mu)) * average(
            attenuation_least(self.sigma_a, self.thickness, wo_t)
        )
        reflected = maximum(self._gray(self._F_outside(wo.z)), COAT_SHARE_MIN * through + LOBE_MIN)
        return shares(reflected, through)
