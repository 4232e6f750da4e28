"""Torrance–Sparrow: mirrors of microscopic size, with every published choice of D, G and F.

f = F D G / (4 mu_i mu_o). Also called Cook–Torrance, whose own paper prints 1 / pi in place of 1 / 4.

Sources:
Torrance, Sparrow, "Theory for off-specular reflection from roughened surfaces", JOSA 57, 1967;
Cook, Torrance, "A reflectance model for computer graphics", 1982;
Walter et al., "Microfacet models for refraction through rough surfaces", EGSR 2007;
Kulla, Conty, "Revisiting physically based shading at Imageworks", SIGGRAPH 2017 course;
Turquin, "Practical multiple scattering compensation for microfacet models", 2019;
Elek, "Layered materials in real-time rendering", CESCG 2010, Algorithm 1: a matte part below.
Those of D, G and F are named in gonio.parts.distribution, masking and fresnel.
"""

from typing import Any

from gonio.albedos.quadrature import NumericAlbedo
from gonio.claims import Claims, Place, at_most, jump, kink, white_furnace
from gonio.fields import ModelError
from gonio.lang import (
    INV_PI,
    Color,
    Float,
    Sample,
    Vec2,
    Vec3,
    clamp,
    lerp,
    minimum,
    select,
    sqrt,
    vec2,
)
from gonio.model import Model, option, param
from gonio.parts import distribution, frame, fresnel, ggx_loss, masking
from gonio.parts.coat import usual_cos_half, usual_sin2_half
from gonio.parts.distribution import (
    ALPHA_MIN,
    GGX,
    Beckmann,
    BlinnPhong,
    Gaussian,
    RoundBeckmann,
    RoundGGX,
    pdf_visible,
)
from gonio.parts.hemisphere import pdf_cosine, pdf_grazing, sample_cosine, sample_grazing
from gonio.parts.image import ImageLobes, facet_cosine, lost_at_facets, schlick_albedo
from gonio.parts.lobes import average, choose, pdf_ggx_lobe, sample_ggx_lobe, shares
from gonio.parts.metals import metal
from gonio.parts.roughness import at_least_alpha

GOLD = metal("Au")

# Range of the index: the smallest measured for metals is 0.02, the largest about 7.
ETA_MIN, ETA_MAX = 0.01, 20.0

# Gauss's rule with three nodes for the integral of F 2 mu over mu in [0, 1] (Gauss-Jacobi).
# It is exact for Schlick's F.
MU_1, MU_2, MU_3 = 0.21234053823915294, 0.59053313555926529, 0.91141204048729605
W_1, W_2, W_3 = 0.13965395980290825, 0.45848221271917249, 0.40186382747791926

# What is lost at a cosine mu goes like mu / (mu^2 + (1.5 alpha)^2), near enough to be sampled by.
LOST_WIDTH = 1.5

# Smallest share of the samples that the compensation gets, so that no weight grows without bound.
SHARE_MIN = 0.05


# Cook and Torrance's V-shaped grooves, and Kelemen's short form: they show facets that Smith's hide.
GROOVES = ("cook_torrance", "kelemen")

# Distributions that smith_walter fits Beckmann's masking for; GGX has its own.
FITTED = ("beckmann", "blinn_phong", "gaussian")


class TorranceSparrow(Model):
    """Rough metal, or the reflection of a rough dielectric. Reciprocal; loses energy when rough."""

    numeric = NumericAlbedo("half_vectors", stretched=True)
    isotropic = False

    alpha: Float = param(
        0.3,
        ALPHA_MIN,
        1,
        "width of the facets' slopes: GGX's alpha, Beckmann's m",
        rougher=at_least_alpha,
    )
    anisotropy: Float = param(
        0, 0, 1, "0 round, 1 smoothest along y; only ggx and beckmann have it"
    )
    eta: Color = param(GOLD["eta"], ETA_MIN, ETA_MAX, "index of refraction; the default is gold's")
    k: Color = param(
        GOLD["k"], 0, 20, "extinction, the imaginary part of the index; not for dielectric"
    )
    rho: Color = param((0.5, 0.5, 0.5), 0, 1, "albedo of the matte part below; only with diffuse")
    f0: Color = param((0.9, 0.9, 0.9), 0, 1, "reflectance at normal incidence; only for schlick")
    f90: Color = param((1, 1, 1), 0, 1, "reflectance at grazing incidence; only for schlick")
    distribution: str = option(
        "ggx",
        "beckmann",
        "blinn_phong",
        "gaussian",
        doc="D: how the facets are tilted; Blinn-Phong's exponent is 2 / alpha^2 - 2",
    )
    masking: str = option(
        "smith_correlated",
        "smith",
        "smith_walter",
        "cook_torrance",
        "kelemen",
        "neumann",
        "implicit",
        "schlick_ggx",
        "schlick_beckmann",
        doc="G: how facets hide each other; Smith's is GGX's own or Beckmann's, smith_walter fits that",
    )
    fresnel: str = option(
        "conductor",
        "dielectric",
        "schlick",
        "lazanyi",
        "white",
        doc="F: exact, or Schlick's with f0 and f90, or Lazanyi's with eta and k; white is 1",
    )
    compensation: str = option(
        "none",
        "kulla_conty",
        "turquin",
        doc="puts back what facets reflect more than once; for ggx with smith_correlated",
    )
    diffuse: str = option(
        "none",
        "lambert",
        doc="a matte part below, with what F at the half vector leaves it; not with a compensation",
    )
    caveats = (
        "Loses what facets reflect more than once: white GGX of alpha 1 reflects 31 % at the normal. "
        "compensation='kulla_conty' or 'turquin' puts it back to 0.4 %.",
        "Wastes the samples that a facet mirrors below the horizon, with the maskings of grooves and with "
        "all facets but GGX's and Blinn-Phong's: at most 52 % of them, 74 % of stretched ones.",
        "compensation='turquin' is not reciprocal.",
        "Reflects more than it receives with maskings that do not belong to the distribution, up to: "
        "schlick_ggx 2.99, schlick_beckmann 1.83, neumann 1.58; with Beckmann's masking for other facets, "
        "blinn_phong 1.78, gaussian 1.08.",
        "diffuse='lambert' gains at grazing angles: 1 - F at the half vector leaves nearly all of the "
        "matte part beside the highlight. White under smooth facets reaches 2.0; with "
        "schlick_ggx 3.92, with schlick_beckmann 2.77.",
        "The compensations do not know of the stretch: anisotropic facets gain up to 8 % (kulla_conty) "
        "and 9 % (turquin).",
    )
    claims = Claims(
        energy=(
            # What facets reflect, and nearly all of the matte part beside it
            at_most(3.995, diffuse="lambert", masking="schlick_ggx"),
            at_most(2.829, diffuse="lambert", masking="schlick_beckmann"),
            at_most(2.02, diffuse="lambert"),
            at_most(1.778, distribution="blinn_phong"),
            at_most(1.084, distribution="gaussian"),
            at_most(1.582, masking="neumann"),
            at_most(2.995, masking="schlick_ggx"),
            at_most(1.829, masking="schlick_beckmann"),
            at_most(1.08, compensation="kulla_conty"),
            at_most(1.09, compensation="turquin"),
        ),
        reciprocity=at_most(0.7, compensation="turquin"),
        wasted=(
            at_most(0.705, distribution="beckmann", masking=GROOVES),
            at_most(0.664, distribution="beckmann"),
            at_most(0.5, distribution="blinn_phong", masking=GROOVES),
            # By the integral over all normals: most at a cosine of 0.3
            at_most(0.513, distribution="gaussian"),
            at_most(0.74, distribution="ggx", masking=GROOVES),
        ),
        numeric_albedo=(
            # Total reflection begins at a jump of the slope: in metals without absorption as well
            at_most(0.03, fresnel=("dielectric", "conductor")),
            at_most(1e-3, masking=("cook_torrance", "smith_walter")),
            at_most(1e-3),
        ),
        kinks=(
            kink(Place.EQUAL_COSINES, masking=("cook_torrance", "neumann")),
            kink(Place.ELSEWHERE, masking="cook_torrance"),
            # Walter's fit reaches 1.00006 where it ends
            jump(Place.ELSEWHERE, masking="smith_walter", distribution=FITTED),
        ),
        furnace=(
            white_furnace(
                within=2.5e-3, fresnel="white", compensation="kulla_conty", anisotropy=0.0
            ),
            white_furnace(within=0.004, fresnel="white", compensation="turquin", anisotropy=0.0),
        ),
    )

    def check_together(self) -> None:
        """Refuse a compensation for what it was not made for."""
        made_for = self.distribution == "ggx" and self.masking == "smith_correlated"
        if self.compensation != "none" and not made_for:
            raise ModelError(
                f"{self.name}: compensation={self.compensation!r} is made for distribution='ggx' with "
                f"masking='smith_correlated', got {self.distribution!r} with {self.masking!r}."
            )
        if self.compensation != "none" and self.diffuse != "none":
            raise ModelError(
                f"{self.name}: compensation={self.compensation!r} is made for facets with nothing below "
                f"them, got diffuse={self.diffuse!r}; leave one of the two at 'none'."
            )

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """BRDF value in 1/sr, without the cosine."""
        cos_h = frame.cos_half(wi, wo)
        single = self._F(cos_h, frame.sin2_half(wi, wo)) * self.highlight(wi, wo)
        if self.compensation == "kulla_conty":
            # Kulla and Conty, pages 8 and 14
            lost = ggx_loss.loss(wi.z, self.alpha) * ggx_loss.loss(wo.z, self.alpha)
            return single + self._colour() * (INV_PI * lost / ggx_loss.mean_loss(self.alpha))
        if self.compensation == "turquin":
            # Turquin, Eq. 16
            lost = ggx_loss.loss(wo.z, self.alpha)
            return single * (1 + self._F(1, 0) * (lost / (1 - lost)))
        if self.diffuse == "lambert":
            # Elek, Algorithm 1, line 23
            return single + self.rho * (INV_PI * self._T(cos_h, frame.sin2_half(wi, wo)))
        return single

    def highlight(self, wi: Vec3, wo: Vec3) -> Float:
        """D G / (4 mu_i mu_o): what facets reflect once, without F."""
        return self._facets().D(frame.half_vector(wi, wo)) * self._V(wi, wo)

    def highlight_albedo(self, split: Vec2) -> Color:
        """What the highlight reflects of light from everywhere, from its table's A and B."""
        if self.fresnel in ("schlick", "white"):
            f0, f90 = (self.f0, self.f90) if self.fresnel == "schlick" else (1, 1)
            single = schlick_albedo(f0, f90, split)
        else:
            c = facet_cosine(split)
            single = self._F(c, (1 - c) * (1 + c)) * (split.x + split.y)
        lost = 1 - split.x - split.y
        if self.compensation == "kulla_conty":
            return single + self._colour() * lost
        if self.compensation == "turquin":
            return single * (1 + self._F(1, 0) * (lost / (1 - lost)))
        return single

    def image_lobes(self, mu: Float) -> ImageLobes:
        """The highlight and the diffuse part, for light from pictures."""
        a = self.slope_widths()
        alpha = sqrt(a.x * a.y)
        if self.diffuse == "lambert":
            # As if F went from the normal to grazing angles by Schlick's weight
            lost = lost_at_facets(mu)
            return ImageLobes(alpha, self.rho * lerp(self._T(1, 0), self._T(0, 1), lost))
        return ImageLobes(alpha, 0)

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Visible normals where the masking has them, else normals; with lobes for what is added."""
        if self.compensation == "kulla_conty":
            share = self._diffuse_share(wo)
            diffuse = u.x < share
            u1 = select(diffuse, u.x / share, (u.x - share) / (1 - share))
            facet = self._sample_facets(wo, vec2(u1, u.y))
            lost = sample_grazing(LOST_WIDTH * self.alpha, vec2(u1, u.y))
            wi = select(diffuse, lost, facet)
        elif self.diffuse == "lambert":
            matte, v = choose(self._shares(wo).x, u)
            wi = select(matte, sample_cosine(v), self._sample_facets(wo, v))
        else:
            wi = self._sample_facets(wo, u)
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample` in 1/sr."""
        specular = self._pdf_facets(wi, wo)
        if self.compensation == "kulla_conty":
            share = self._diffuse_share(wo)
            lost = pdf_grazing(wi, LOST_WIDTH * self.alpha)
            return share * lost + (1 - share) * specular
        if self.diffuse == "lambert":
            P = self._shares(wo)
            return P.x * pdf_cosine(wi) + P.y * specular
        return specular

    def facet_terms(self, wi: Vec3, wo: Vec3) -> dict[str, Float]:
        """D and G of a pair of directions; for plots."""
        D = self._facets().D(frame.half_vector(wi, wo))
        return {"D": D, "G": 4 * wi.z * wo.z * self._V(wi, wo)}

    def reflectances(self, cos_theta: Float) -> dict[str, Color]:
        """F at a cosine; for plots."""
        return {"F": self._F(cos_theta, (1 - cos_theta) * (1 + cos_theta))}

    def single_scattering(self) -> Model:
        """What facets reflect once."""
        return self.replace(compensation="none")

    def follows_tangents(self) -> bool:
        """Whether the facets can be stretched."""
        return self.distribution in ("ggx", "beckmann")

    def slope_widths(self) -> Vec2:
        """As the facets' slopes."""
        if self.distribution in ("blinn_phong", "gaussian"):
            return vec2(self.alpha, self.alpha)
        return distribution.anisotropic_alpha(self.alpha, self.anisotropy)

    def _facets(self) -> Any:
        """D and its widths."""
        if self.distribution == "blinn_phong":
            return BlinnPhong(self.alpha)
        if self.distribution == "gaussian":
            return Gaussian(self.alpha)
        a = self.slope_widths()
        if self.distribution == "beckmann":
            return Beckmann(a.x, a.y)
        return GGX(a.x, a.y)

    def _masked(self) -> Any:
        """Facets whose Smith masking it is: those that have none take that of Beckmann's, as wide."""
        if self.distribution in ("blinn_phong", "gaussian"):
            return RoundBeckmann(self.alpha)
        return self._facets()

    def _V(self, wi: Vec3, wo: Vec3) -> Float:
        """G / (4 mu_i mu_o)."""
        if self.masking == "cook_torrance":
            return masking.V_cook_torrance(wi, wo)
        if self.masking == "kelemen":
            return masking.V_kelemen(frame.half_length(wi, wo))
        if self.masking == "neumann":
            return masking.V_neumann(wi, wo)
        if self.masking == "implicit":
            return masking.V_implicit()
        if self.masking == "schlick_ggx":
            return masking.V_schlick(wi, wo, masking.schlick_k_ggx(self.alpha))
        if self.masking == "schlick_beckmann":
            return masking.V_schlick(wi, wo, masking.schlick_k_beckmann(self.alpha))
        if self.masking == "smith_correlated":
            return masking.V_smith_correlated(self._masked(), wi, wo)
        if self.masking == "smith_walter" and self.distribution != "ggx":
            return masking.V_smith_walter(self._masked(), wi, wo)
        return masking.V_smith(self._masked(), wi, wo)

    def _F(self, cos_h: Float, sin2_h: Float) -> Color:
        if self.fresnel == "conductor":
            return fresnel.F_conductor_half(cos_h, sin2_h, self.eta, self.k)
        if self.fresnel == "dielectric":
            return fresnel.F_dielectric_half(cos_h, sin2_h, self.eta)
        if self.fresnel == "schlick":
            return fresnel.F_schlick_half(cos_h, sin2_h, self.f0, self.f90)
        if self.fresnel == "lazanyi":
            return fresnel.F_lazanyi_half(cos_h, sin2_h, self.eta, self.k)
        return 1

    def _T(self, cos_h: Float, sin2_h: Float) -> Color:
        """1 - F."""
        if self.fresnel == "conductor":
            return fresnel.transmittance_conductor_half(cos_h, sin2_h, self.eta, self.k)
        if self.fresnel == "dielectric":
            return fresnel.transmittance_half(cos_h, sin2_h, self.eta)
        if self.fresnel == "schlick":
            return fresnel.transmittance_schlick_half(cos_h, sin2_h, self.f0, self.f90)
        if self.fresnel == "lazanyi":
            return fresnel.transmittance_lazanyi_conductor(minimum(cos_h, 1), self.eta, self.k)
        return 0

    def _F_mean(self) -> Color:
        """Mean of F over the hemisphere, by Gauss's rule."""
        F_1, F_2 = self._F(MU_1, 1 - MU_1 * MU_1), self._F(MU_2, 1 - MU_2 * MU_2)
        return W_1 * F_1 + W_2 * F_2 + W_3 * self._F(MU_3, 1 - MU_3 * MU_3)

    def _colour(self) -> Color:
        """What is left of light after two and more reflections. Kulla and Conty, page 14."""
        F = self._F_mean()
        lost = ggx_loss.mean_loss(self.alpha)
        return F * F * (1 - lost) / (1 - F * lost)

    def _shares(self, wo: Vec3) -> Vec2:
        """Probabilities of the matte part and of the facets."""
        mu = wo.z
        through = average(self.rho * self._T(usual_cos_half(wo), usual_sin2_half(wo)))
        if self.fresnel == "white":
            return shares(through, 1)
        return shares(through, average(self._F(mu, (1 - mu) * (1 + mu))))

    def _diffuse_share(self, wo: Vec3) -> Float:
        """How many samples the compensation gets: as much as it reflects of white."""
        return clamp(ggx_loss.loss(wo.z, self.alpha), SHARE_MIN, 1 - SHARE_MIN)

    def _sample_facets(self, wo: Vec3, u: Vec2) -> Vec3:
        """wo mirrored at a visible normal, or at any.

        Visible normals need Smith's G1, and a G that is no larger than it. With the G of grooves their
        weights grow like alpha / mu_o in the horizon, but those of all normals are at most 2.
        """
        if self.masking in GROOVES or self.distribution == "gaussian":
            return frame.mirror(wo, self._facets().sample(u))
        if self.distribution == "beckmann":
            return frame.mirror(wo, self._facets().sample_visible(wo, u))
        if self.distribution == "blinn_phong":
            # GGX's longer tail: Blinn-Phong's own normals have weights without bound in the horizon
            return sample_ggx_lobe(RoundGGX(self.alpha), wo, u)
        return sample_ggx_lobe(self._facets(), wo, u)

    def _pdf_facets(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `_sample_facets`."""
        m = frame.half_vector(wi, wo)
        if self.masking in GROOVES or self.distribution == "gaussian":
            return frame.pdf_mirror(self._facets().density(m), frame.half_length(wi, wo))
        if self.distribution == "beckmann":
            return pdf_visible(self._facets(), wo, m)
        if self.distribution == "blinn_phong":
            return pdf_ggx_lobe(RoundGGX(self.alpha), wi, wo)
        return pdf_ggx_lobe(self._facets(), wi, wo)
