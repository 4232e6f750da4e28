"""Car paint: metal flakes of all directions under a tinted clear coat.

Source: Elek, "Layered materials in real-time rendering", CESCG 2010, section 4.1: the layered model of
`weidlich_wilkie` over a metal whose normal alone is perturbed by a map of flakes, tiled and unfiltered.
`gonio.mitsuba.textures.flake_map` makes such maps. Spatial variation is the host's business: flake_x and
flake_y are numbers here, and a texture gives each point its own.
Deviations: by default light that leaves the coat spreads by 1 / eta^2, without which the metal is eta^2
times too bright; both crossings of the surface count at the mean normal, because 1 - F(wo.H) lets too much
of a tilted flake's light through; and a flake counts as much as both light and viewer see of it, so that
the model stays reciprocal. Options restore all three. The metal's index is taken relative to the coat.
"""

from gonio.claims import UNBOUNDED, Claims, Place, at_most, jump, kink
from gonio.lang import (
    MU_MIN,
    Color,
    Float,
    Sample,
    Vec2,
    Vec3,
    length,
    maximum,
    normalize,
    select,
    vec3,
)
from gonio.model import Model, option, param
from gonio.parts.coat import (
    attenuation_least,
    ggx_facets,
    optical_depth,
    through_facets,
    usual_cos_half,
)
from gonio.parts.distribution import ALPHA_MIN, RoundGGX, ggx_bound, pdf_visible
from gonio.parts.frame import cos_half, half_vector, mirror
from gonio.parts.fresnel import F_conductor_half, F_dielectric_entering, transmittance_entering
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
from gonio.parts.lobes import average, choose, pdf_ggx_lobe, sample_ggx_lobe, shares
from gonio.parts.metals import metal
from gonio.parts.roughness import at_least_alpha
from gonio.parts.tilt import flake_normal, from_tilted, seen, to_tilted
from gonio.quadrature import NumericAlbedo

CHROMIUM = metal("Cr", neutral=True)

# The coat gets at least a tenth as many samples as the metal: facets reflect more than the mean surface
# where they are tilted, and this bounds their weight.
COAT_SHARE_MIN = 0.1


class CarPaint(Model):
    """One flake's worth of metallic paint; a map of flakes makes it sparkle. Reciprocal."""

    numeric = NumericAlbedo("half_vectors")
    isotropic = False

    eta: Float = param(1.5, 1, 3, "index of the clear coat")
    alpha: Float = param(
        0.03, ALPHA_MIN, 1, "slope width of the coat's facets", rougher=at_least_alpha
    )
    sigma_a: Color = param((0.15, 1.2, 1.4), 0, 10, "absorption of the coat per unit of thickness")
    thickness: Float = param(1, 0, 1, "thickness of the coat, in the unit of sigma_a")
    metal_eta: Color = param(
        CHROMIUM["eta"], 0.01, 20, "the flakes' index; the default is chromium"
    )
    metal_k: Color = param(CHROMIUM["k"], 0, 20, "the flakes' extinction")
    metal_alpha: Float = param(
        0.15, ALPHA_MIN, 1, "slope width of each flake, at least the coat's", rougher=at_least_alpha
    )
    flake_x: Float = param(0, -2, 2, "slope of the flake's normal along x; for a texture")
    flake_y: Float = param(0, -2, 2, "slope of the flake's normal along y; for a texture")
    distance: Float = param(1, 0, 1e6, "of the viewer; above 1 it evens out the flakes")
    transmission: str = option(
        "both_ways", "half_vector", doc="T(wi) T(wo) at the mean surface, or T12 t of Eq. 2 and 4"
    )
    solid_angle: str = option("compressed", "none", doc="1 / eta^2 for light that leaves the coat")
    flake_cosine: str = option(
        "reciprocal", "light", doc="a tilted flake counts as it is seen by both, or as lit (Elek)"
    )
    caveats = (
        "Loses what a tilted flake reflects below the horizon; nothing lights its neighbours.",
        "Wastes the samples that a tilted flake mirrors below the horizon, a fifth of them at "
        "moderate tilts and most where it is nearly edge-on.",
        "Has a kink where light or viewer passes behind a tilted flake, and at flakes that are not tilted.",
        "Elek's original reflects more than it receives with transmission='half_vector', because light "
        "enters at the half vector's angle; more with solid_angle='none', because it leaves into a wider "
        "angle than it came from; most at eta 3 with tilted flakes.",
        "flake_cosine='light' is not reciprocal, and jumps where viewer or light passes behind a flake: "
        "nearly edge-on, float32 may take the other side.",
    )
    claims = Claims(
        energy=(
            at_most(5.45, transmission="half_vector", solid_angle="none"),
            at_most(2.4, transmission="half_vector"),
            at_most(5.32, solid_angle="none"),
        ),
        reciprocity=at_most(1, flake_cosine="light"),
        wasted=at_most(0.9),
        float32=at_most(UNBOUNDED, flake_cosine="light"),
        numeric_albedo=at_most(1e-3),
        kinks=(kink(Place.ELSEWHERE), jump(Place.IN_A_PARAMETER, flake_cosine="light")),
    )

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """Eq. 2 with a tilted base: BRDF value in 1/sr, without the cosine."""
        cos_h = cos_half(wi, wo)
        facets = ggx_facets(half_vector(wi, wo), wi, wo, self.alpha)
        coat = F_dielectric_entering(cos_h, self.eta) * facets

        if self.transmission == "half_vector":
            through = through_facets(wi, wo, self.alpha, transmittance_entering(cos_h, self.eta))
        else:
            through = transmittance_entering(wi.z, self.eta) * transmittance_entering(
                wo.z, self.eta
            )
        if self.solid_angle == "compressed":
            through = through / (self.eta * self.eta)
        excess = self.eta - 1
        wi_t, wo_t = refract(wi, excess), refract(wo, excess)
        kept = attenuation(self._optical_depth(), wi_t, wo_t)
        both = refracted_sum(wi, wo, excess)
        F = F_conductor_half(
            0.5 * length(both) / self.eta,
            refracted_sin2_half(wi, wo, excess),
            self.metal_eta / self.eta,
            self.metal_k / self.eta,
        )
        return coat + F * self._flake(wi_t, wo_t, both) * (kept * through)

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Visible normals of the coat, or of the flake and then out through the coat."""
        n, wo_t = self._normal(), refract(wo, self.eta - 1)
        on_coat, v = choose(self._shares(wo, wo_t).x, u)
        w_coat = sample_ggx_lobe(RoundGGX(self.alpha), wo, v)
        facets = RoundGGX(self._flake_alpha())
        tilted = self._facing(to_tilted(wo_t, n))
        flake = mirror(tilted, facets.sample_visible(tilted, v, ggx_bound(facets.alpha, tilted)))
        # What the flake mirrors behind itself is wasted.
        w_flake = leave(select(flake.z > 0, from_tilted(flake, n), vec3(0, 0, -1)), self.eta - 1)
        wi = select(on_coat, w_coat, w_flake)
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample` in 1/sr."""
        excess = self.eta - 1
        wi_t, wo_t = refract(wi, excess), refract(wo, excess)
        refracted = self._pdf_flake(wi_t, wo_t, refracted_sum(wi, wo, excess))
        w = gather(wi, excess)
        gathered = self._pdf_flake(w, wo_t, w + wo_t)
        below = pdf_leave(refracted, gathered, wi, wi_t, excess)
        coat = pdf_ggx_lobe(RoundGGX(self.alpha), wi, wo)
        P = self._shares(wo, wo_t)
        return P.x * coat + P.y * below

    def image_surface(self, mu: Float) -> ImageSurface:
        """What the coat mirrors of a picture."""
        return ImageSurface(F_dielectric_entering(mu, self.eta), self.alpha)

    def _normal(self) -> Vec3:
        return flake_normal(self.flake_x, self.flake_y, self.distance)

    def _optical_depth(self) -> Color:
        return optical_depth(self.sigma_a, self.thickness)

    def _flake_alpha(self) -> Float:
        return maximum(self.metal_alpha, self.alpha)

    def _facing(self, w: Vec3) -> Vec3:
        """w, or the flake's normal in place of a direction behind it, which is masked elsewhere."""
        return select(w.z > MU_MIN, w, vec3(0, 0, 1))

    def _flake(self, wi_t: Vec3, wo_t: Vec3, both: Vec3) -> Float:
        """The flake's facets in its own frame; both: eta times the sum of the directions."""
        n, alpha = self._normal(), self._flake_alpha()
        tilted_i, tilted_o = to_tilted(wi_t, n), to_tilted(wo_t, n)
        wi, wo = self._facing(tilted_i), self._facing(tilted_o)
        if self.flake_cosine == "light":
            visible = maximum(tilted_i.z, 0) / wi_t.z
        else:
            visible = seen(tilted_i.z, wi_t.z) * seen(tilted_o.z, wo_t.z)
        m = normalize(to_tilted(both, n))
        return select(tilted_o.z > 0, ggx_facets(m, wi, wo, alpha) * visible, 0)

    def _pdf_flake(self, wi_t: Vec3, wo_t: Vec3, both: Vec3) -> Float:
        """Density inside the coat of the flake's part of `sample`; both: along the half vector."""
        n = self._normal()
        tilted_i, tilted_o = to_tilted(wi_t, n), to_tilted(wo_t, n)
        facets, tilted = RoundGGX(self._flake_alpha()), self._facing(tilted_o)
        m = normalize(to_tilted(both, n))
        density = pdf_visible(facets, tilted, m, ggx_bound(facets.alpha, tilted))
        return select((tilted_i.z > 0) & (wi_t.z > 0), density, 0)

    def _shares(self, wo: Vec3, wo_t: Vec3) -> Vec2:
        """Probabilities of the coat and of the flake."""
        mu = wo.z
        if self.transmission == "half_vector":
            mu = usual_cos_half(wo)
        below = transmittance_entering(mu, self.eta) * average(
            attenuation_least(self._optical_depth(), wo_t)
        )
        tilted = to_tilted(wo_t, self._normal())
        if self.flake_cosine == "light":
            lit = select(tilted.z > 0, below, 0)
        else:
            lit = below * seen(tilted.z, wo_t.z)
        coat = maximum(F_dielectric_entering(wo.z, self.eta), COAT_SHARE_MIN * below + LOBE_MIN)
        return shares(coat, lit)
