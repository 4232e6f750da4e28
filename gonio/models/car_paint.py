"""Car paint: metal flakes of all directions under a tinted clear coat.

Source: Elek, "Layered materials in real-time rendering", CESCG 2010, section 4.1: the layered model of
`weidlich_wilkie` over a metal whose normal alone is perturbed by a map of flakes, tiled and unfiltered.
`gonio.mitsuba.textures.flake_map` makes such maps. Spatial variation is the host's business: flake_x and
flake_y are numbers here, and a texture gives each point its own.
Deviations: by default light that leaves the coat spreads by 1 / eta^2, without which the metal is eta^2
times too bright; both crossings of the surface count at the mean normal, because 1 - F(wo.H) lets too much
of a tilted flake's light through; and a flake counts as much as both light and viewer see of it, so that
the model stays reciprocal. Facets are GGX's with Smith's masking instead of Beckmann's with V-cavities, F
is exact instead of Lazányi's fit, the coat absorbs along paths through the mean surface instead of the
flake, and a flake counts as much as the normal above it instead of half as much. Options restore each of
these. No option restores that Algorithm 1 weighs what the metal reflects by the cosine outside, which the
light that is shone on it has already. The metal's index is taken relative to the coat.
"""

from gonio.albedos.quadrature import NumericAlbedo
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
)
from gonio.parts.distribution import ALPHA_MIN
from gonio.parts.frame import cos_half, half_vector, mirror, sin2_half
from gonio.parts.fresnel import (
    F_conductor_half,
    F_dielectric_entering,
    F_lazanyi_half,
    transmittance_entering,
    transmittance_lazanyi,
)
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
from gonio.parts.tilt import flake_normal, flake_normal_added, from_tilted, seen, to_tilted

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
    distribution: str = option("ggx", "beckmann", doc="of the coat's facets and of the flakes'")
    masking: str = option(
        "smith_correlated",
        "cook_torrance",
        doc="of the facets; Elek's are V-cavities, cook_torrance",
    )
    fresnel: str = option("exact", "lazanyi", doc="of both layers; Elek's code has Lazányi's fit")
    absorption: str = option(
        "surface", "flake", doc="along paths at the mean surface, or at the flake's normal (Elek)"
    )
    tilt: str = option(
        "distance", "added", doc="a flake of 30 degrees tilts the normal by 15, or by 9.9 (Elek)"
    )
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
        "angle than it came from; most at eta 3 with tilted flakes. With V-cavities and "
        "flake_cosine='light' as well, which is all as printed, up to 8 times as much.",
        "flake_cosine='light' is not reciprocal, and jumps where viewer or light passes behind a flake: "
        "nearly edge-on, float32 may take the other side.",
    )
    claims = Claims(
        energy=(
            at_most(
                8,
                transmission="half_vector",
                solid_angle="none",
                masking="cook_torrance",
                flake_cosine="light",
            ),
            at_most(5.45, transmission="half_vector", solid_angle="none"),
            at_most(2, transmission="half_vector"),
            at_most(5.32, solid_angle="none"),
        ),
        reciprocity=at_most(1, flake_cosine="light"),
        wasted=at_most(0.9),
        float32=at_most(UNBOUNDED, flake_cosine="light"),
        # What the coat keeps inside is spread over all directions by its azimuth, which near an index of 1
        # meets the narrowest flakes' mirror direction by the last bits of the directions' float32; and what
        # leaves near the normal has been turned about a flake's by twice as many roundings
        float32_density=at_most(5e-3),
        # A narrow flake near where light begins to stay inside the coat; 3e-3 in 999 of 1,000 settings
        numeric_albedo=at_most(0.25),
        kinks=(
            kink(Place.ELSEWHERE),
            kink(Place.EQUAL_COSINES, masking="cook_torrance"),
            jump(Place.IN_A_PARAMETER, flake_cosine="light"),
        ),
    )

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """Eq. 2 with a tilted base: BRDF value in 1/sr, without the cosine."""
        m, cos_h = half_vector(wi, wo), cos_half(wi, wo)
        facets = self._facets()
        coat = self._F(cos_h, sin2_half(wi, wo)) * reflected_by(facets, wi, wo, m, self.masking)

        if self.transmission == "half_vector":
            T = self._T(cos_h)
            through = through_facets(facets, wi, wo, self.masking, T)
        else:
            through = self._T(wi.z) * self._T(wo.z)
        if self.solid_angle == "compressed":
            through = through / (self.eta * self.eta)
        excess = self.eta - 1
        wi_t, wo_t = refract(wi, excess), refract(wo, excess)
        both = refracted_sum(wi, wo, excess)
        cos_t = 0.5 * length(both) / self.eta
        metal_eta, metal_k = self.metal_eta / self.eta, self.metal_k / self.eta
        sin2_t = refracted_sin2_half(wi, wo, excess)
        if self.fresnel == "exact":
            F = F_conductor_half(cos_t, sin2_t, metal_eta, metal_k)
        else:
            F = F_lazanyi_half(cos_t, sin2_t, metal_eta, metal_k)
        flake = F * self._flake(wi_t, wo_t, both)
        return coat + flake * (self._kept(wi_t, wo_t) * through)

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Normals of the coat, or of the flake and then out through the coat."""
        n, wo_t = self._normal(), refract(wo, self.eta - 1)
        on_coat, v = choose(self._shares(wo, wo_t).x, u)
        w_coat = sample_facets(self._facets(), wo, v, self.masking)
        tilted = self._facing(to_tilted(wo_t, n))
        m = sample_facet(self._flake_facets(), tilted, v, self.masking)
        flake = mirror(tilted, m)
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
        coat = pdf_facets(self._facets(), wi, wo, self.masking)
        P = self._shares(wo, wo_t)
        return P.x * coat + P.y * below

    def image_surface(self, mu: Float) -> ImageSurface:
        """What the coat mirrors of a picture."""
        return ImageSurface(self._F(mu, (1 - mu) * (1 + mu)), self.alpha)

    def _F(self, cos_h: Float, sin2_h: Float) -> Float:
        """Of the coat."""
        if self.fresnel == "exact":
            return F_dielectric_entering(cos_h, self.eta)
        return F_lazanyi_half(cos_h, sin2_h, self.eta, 0)

    def _T(self, cos_theta: Float) -> Float:
        """1 - F of the coat."""
        if self.fresnel == "exact":
            return transmittance_entering(cos_theta, self.eta)
        return transmittance_lazanyi(cos_theta, self.eta)

    def _normal(self) -> Vec3:
        if self.tilt == "added":
            return flake_normal_added(self.flake_x, self.flake_y, self.distance)
        return flake_normal(self.flake_x, self.flake_y, self.distance)

    def _kept(self, wi_t: Vec3, wo_t: Vec3) -> Color:
        """What the coat does not absorb."""
        if self.absorption == "flake":
            n = self._normal()
            wi, wo = self._facing(to_tilted(wi_t, n)), self._facing(to_tilted(wo_t, n))
            return attenuation(self.sigma_a, self.thickness, wi, wo)
        return attenuation(self.sigma_a, self.thickness, wi_t, wo_t)

    def _facets(self) -> Round:
        return facets_of(self.alpha, self.distribution)

    def _flake_facets(self) -> Round:
        return facets_of(maximum(self.metal_alpha, self.alpha), self.distribution)

    def _facing(self, w: Vec3) -> Vec3:
        """w, or the flake's normal in place of a direction behind it, which is masked elsewhere."""
        return select(w.z > MU_MIN, w, vec3(0, 0, 1))

    def _flake(self, wi_t: Vec3, wo_t: Vec3, both: Vec3) -> Float:
        """The flake's facets in its own frame; both: eta times the sum of the directions."""
        n = self._normal()
        tilted_i, tilted_o = to_tilted(wi_t, n), to_tilted(wo_t, n)
        wi, wo = self._facing(tilted_i), self._facing(tilted_o)
        if self.flake_cosine == "light":
            visible = maximum(tilted_i.z, 0) / wi_t.z
        else:
            visible = seen(tilted_i.z, wi_t.z) * seen(tilted_o.z, wo_t.z)
        m = normalize(to_tilted(both, n))
        f = reflected_by(self._flake_facets(), wi, wo, m, self.masking)
        return select(tilted_o.z > 0, f * visible, 0)

    def _pdf_flake(self, wi_t: Vec3, wo_t: Vec3, both: Vec3) -> Float:
        """Density inside the coat of the flake's part of `sample`; both: along the half vector."""
        n = self._normal()
        tilted_i, tilted_o = to_tilted(wi_t, n), to_tilted(wo_t, n)
        m = normalize(to_tilted(both, n))
        cos_h, facing = cos_half(wi_t, wo_t), self._facing(tilted_o)
        density = pdf_facet(self._flake_facets(), facing, m, cos_h, self.masking)
        # Of a viewer behind the flake the half vector may be behind it as well, where no facet looks
        return select((tilted_i.z > 0) & (wi_t.z > 0) & (m.z > 0), density, 0)

    def _shares(self, wo: Vec3, wo_t: Vec3) -> Vec2:
        """Probabilities of the coat and of the flake."""
        mu = usual_cos_half(wo) if self.transmission == "half_vector" else wo.z
        below = self._T(mu) * average(attenuation_least(self.sigma_a, self.thickness, wo_t))
        tilted = to_tilted(wo_t, self._normal())
        if self.flake_cosine == "light":
            lit = select(tilted.z > 0, below, 0)
        else:
            lit = below * seen(tilted.z, wo_t.z)
        F = self._F(wo.z, (1 - wo.z) * (1 + wo.z))
        coat = maximum(F, COAT_SHARE_MIN * below + LOBE_MIN)
        return shares(coat, lit)
