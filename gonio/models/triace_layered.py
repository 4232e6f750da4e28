"""tri-Ace layered: two Blinn–Phong layers with an absorbing one between, made for game consoles.

Source: Gotanda, "Beyond a simple physically based Blinn-Phong model in real-time", SIGGRAPH 2012 course
"Practical physically based shading in film and game production", section 2. Symbols are the course's; the
alpha' of Eq. 3 is sigma_a times thickness here, as in Eq. 2.
Choices where the course is silent: the fraction of Eq. 1 and the transmittance of Eq. 5 have Schlick's F,
and Eq. 4 the exact one, all at wo.H; the lower layer uses directions that are not refracted, except in the
exact absorption; F_trans takes its part from the lower layer's diffuse reflection as well, which an option
turns off.
"""

from typing import NamedTuple

from gonio.albedos.quadrature import NumericAlbedo
from gonio.claims import Claims, Place, at_most, kink
from gonio.lang import (
    INV_PI,
    Color,
    Float,
    Sample,
    Vec2,
    Vec3,
    lerp,
    maximum,
    select,
    vec3,
)
from gonio.model import Model, option, param
from gonio.parts import cltc
from gonio.parts.coat import optical_depth, usual_cos_half
from gonio.parts.distribution import RoundGGX, blinn_phong_alpha
from gonio.parts.frame import cos_half, tangential_dot
from gonio.parts.fresnel import (
    F_below,
    F_dielectric_entering,
    f0_between,
    f0_from_eta,
    schlick_weight,
    schlick_weight_half,
    transmittance_below,
    transmittance_entering,
    transmittance_lazanyi,
)
from gonio.parts.hemisphere import pdf_cosine, sample_cosine
from gonio.parts.interface import LOBE_MIN, attenuation, refract
from gonio.parts.lobes import average, choose, pdf_ggx_lobe, sample_ggx_lobe, shares
from gonio.parts.oren_nayar import s_over_t_fujii
from gonio.parts.roughness import at_most_blinn_phong
from gonio.parts.triace import blinn_phong_highlight

# Smallest share of the samples that a highlight gets: it bounds their weights.
LOBE_SHARE_MIN = 0.1


class BottomFresnel(NamedTuple):
    """What Fresnel leaves of the lower layer's reflection, both crossings of the upper surface included."""

    glossy: Float
    """Factor of the glossy reflection (Eq. 4 or 5)."""
    matte: Float
    """Factor of the matte reflection (Eq. 9)."""


class TriAceLayered(Model):
    """A glossy layer over a glossy and matte one, with absorption between. Reciprocal."""

    numeric = NumericAlbedo("half_vectors")

    top_eta: Float = param(1.33333, 1, 3, "index n1 of the upper layer")
    top_shininess: Float = param(
        200, 0, 1e5, "Blinn-Phong exponent of the upper layer", rougher=at_most_blinn_phong
    )
    bottom_eta: Float = param(1.5, 1, 3, "index n2 of the lower layer, as it would be in air")
    bottom_shininess: Float = param(
        20, 0, 1e5, "Blinn-Phong exponent of the lower layer", rougher=at_most_blinn_phong
    )
    rho: Color = param((0.5, 0.5, 0.5), 0, 1, "diffuse albedo R_d of the lower layer, linear RGB")
    sigma_a: Color = param((0, 0, 0), 0, 10, "absorption of the upper layer per unit of thickness")
    thickness: Float = param(1, 0, 1, "thickness of the upper layer, in the unit of sigma_a")
    absorption: str = option("exact", "linear", doc="Eq. 2 with refracted paths, or Eq. 3")
    bottom_fresnel: str = option("exact", "constant", doc="Eq. 4, or Eq. 5 with two constants")
    top_transmission: str = option(
        "on", "off", doc="whether F_trans of Eq. 5 multiplies all that comes from below"
    )
    diffuse: str = option(
        "lambert", "oren_nayar", doc="below; Oren-Nayar is the course's Eq. 25, bottom_shininess"
    )
    caveats = (
        "Has a kink where Eq. 3 reaches 0, with absorption='linear'.",
        "Has a kink where cos(phi_i - phi_o) changes sign, with diffuse='oren_nayar'.",
        "float32 loses digits where bottom_eta is nearly 1.",
        "Eq. 2 to 5 have no light that bounces between the layers and no compression of solid angles.",
        "Reflects more than it receives with rho 1, because light enters at the half vector's angle: most "
        "with sharp layers of indices 1 and 1.17, at 81 degrees; more at eta 3 with "
        "top_transmission='off', which takes nothing for the crossings.",
        "absorption='linear' is black beyond the angle where Eq. 3 ends; near it, float32 keeps an "
        "absolute accuracy of 1e-6, not a relative one.",
    )
    unlike = (
        ("weidlich_wilkie", "covers any base, and nests; this one is two layers of one kind."),
    )
    claims = Claims(
        energy=(
            at_most(1.25, top_transmission="off"),
            at_most(1.05, bottom_fresnel="constant"),
            at_most(1.095),
        ),
        float32=at_most(2e-4),
        numeric_albedo=(at_most(1e-3, diffuse="oren_nayar"), at_most(1e-3, absorption="linear")),
        kinks=(
            kink(Place.EQUAL_COSINES),
            kink(Place.SIDE_LIGHT, diffuse="oren_nayar"),
            kink(Place.ELSEWHERE, absorption="linear"),
        ),
    )

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """Eq. 1 twice, with Eq. 2 to 5 between: BRDF value in 1/sr, without the cosine."""
        cos_h = cos_half(wi, wo)
        F_top = lerp(f0_from_eta(self.top_eta), 1, schlick_weight_half(wi, wo))
        top = F_top * blinn_phong_highlight(wi, wo, self.top_shininess)
        glossy, matte = self._bottom_fresnel(cos_h)
        bottom = glossy * blinn_phong_highlight(wi, wo, self.bottom_shininess)
        below = bottom + matte * self.rho * (INV_PI * self._diffuse_shape(wi, wo))
        return top + below * self._absorption(wi, wo)

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Diffuse, or the GGX lobe as wide as one of the highlights, chosen by what they reflect."""
        P_top, P_bottom = self._shares(wo)
        on_top, v = choose(P_top.x, u)
        on_bottom, t = choose(P_bottom.x, v)
        w_top = sample_ggx_lobe(self._top(), wo, v)
        w_bottom = sample_ggx_lobe(self._bottom(), wo, t)
        if self.diffuse == "lambert":
            w_matte = sample_cosine(t)
        else:
            w_matte = cltc.sample_cltc_matched(wo, self._roughness(), t)
        wi = select(on_top, w_top, select(on_bottom, w_bottom, w_matte))
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample` in 1/sr."""
        P_top, P_bottom = self._shares(wo)
        top = pdf_ggx_lobe(self._top(), wi, wo)
        bottom = pdf_ggx_lobe(self._bottom(), wi, wo)
        if self.diffuse == "lambert":
            matte = pdf_cosine(wi)
        else:
            matte = cltc.pdf_cltc_matched(wi, wo, self._roughness())
        return P_top.x * top + P_top.y * (P_bottom.x * bottom + P_bottom.y * matte)

    def reflectances(self, cos_theta: Float) -> dict[str, Float]:
        """F of the upper layer, and the factor of the lower layer's highlight; for plots."""
        F_top = lerp(f0_from_eta(self.top_eta), 1, schlick_weight(cos_theta))
        glossy, _ = self._bottom_fresnel(cos_theta)
        return {"F, upper layer": F_top, "lower layer": glossy}

    def _top(self) -> RoundGGX:
        """Facets that the upper highlight is sampled by: as wide, with a longer tail."""
        return RoundGGX(blinn_phong_alpha(self.top_shininess))

    def _bottom(self) -> RoundGGX:
        """Facets that the lower highlight is sampled by: as wide, with a longer tail."""
        return RoundGGX(blinn_phong_alpha(self.bottom_shininess))

    def _bottom_fresnel(self, cos_h: Float) -> BottomFresnel:
        """Factors of the lower layer's glossy and matte reflection (Eq. 4 or 5, and Eq. 9)."""
        n1, n2 = self.top_eta, self.bottom_eta
        if self.bottom_fresnel == "exact":
            # Both crossings of the upper surface have the same F at angles that belong together.
            F, T = F_dielectric_entering(cos_h, n1), transmittance_entering(cos_h, n1)
            glossy, lost = T * T * F_below(cos_h, n1, n2), T * transmittance_below(cos_h, n1, n2)
            # 1 - T F_below and 1 - T T F_below without their cancellation
            if self.top_transmission == "on":
                return BottomFresnel(glossy, T * (F + lost))
            return BottomFresnel(glossy, F * (1 + T) + T * lost)
        T = transmittance_lazanyi(cos_h, n1)  # with k = 0, which is Schlick's
        inner = f0_between(n1, n2) * (1 - f0_from_eta(n1))
        if self.top_transmission == "on":
            return BottomFresnel(T * inner, T * (1 - inner))
        return BottomFresnel(inner, 1 - inner)

    def _optical_depth(self) -> Color:
        return optical_depth(self.sigma_a, self.thickness)

    def _absorption(self, wi: Vec3, wo: Vec3) -> Color:
        """Eq. 2 or 3."""
        if self.absorption == "exact":
            return attenuation(
                self.sigma_a,
                self.thickness,
                refract(wi, self.top_eta - 1),
                refract(wo, self.top_eta - 1),
            )
        return maximum(1 - self._optical_depth() * (1 / wi.z + 1 / wo.z), 0)

    def _diffuse_shape(self, wi: Vec3, wo: Vec3) -> Float:
        if self.diffuse == "lambert":
            return 1
        A, B = self._coefficients()
        return A + B * s_over_t_fujii(tangential_dot(wi, wo), wi, wo)

    def _coefficients(self) -> tuple[Float, Float]:
        """A' and B of Eq. 25."""
        n = self.bottom_shininess
        A, B = 1 - 1 / (2 + 0.65 * n), 1 / (2.22222 + 0.1 * n)
        return A, B

    def _roughness(self) -> Float:
        A, B = self._coefficients()
        return B / A

    def _shares(self, wo: Vec3) -> tuple[Vec2, Vec2]:
        """Probabilities: upper highlight or lower layer; of that, its highlight or its diffuse part."""
        glossy, matte = self._bottom_fresnel(usual_cos_half(wo))
        # The shortest way in, the light's, bounds what the absorption can leave.
        kept = self._absorption(vec3(0, 0, 1), wo)
        top = lerp(f0_from_eta(self.top_eta), 1, schlick_weight(wo.z))
        bottom, diffuse = glossy * average(kept), matte * average(kept * self.rho) + LOBE_MIN
        lower = bottom + diffuse
        # Half vectors away from the normal reflect more than this estimate, which is made for the normal.
        P_top = shares(maximum(top, LOBE_SHARE_MIN * lower), lower)
        P_bottom = shares(maximum(bottom, LOBE_SHARE_MIN * diffuse), diffuse)
        return P_top, P_bottom
