"""Student-t: facets whose slopes have tails of any length, between Beckmann's and longer than GGX's.

Source: Ribardière, Bringier, Meneveaux, Simonot, "STD: Student's t-distribution of slopes for microfacet
based BSDFs", Computer Graphics Forum 36(2), 2017: D and its samples. gamma = 2 is GGX, and large gammas
come near Beckmann. Burley's GTR, "Physically-based shading at Disney", 2012, has the same family of tails.
Deviation: G is Cook and Torrance's, which is exact for V-cavities of any facets and needs no fit.
"""

from gonio.albedos.quadrature import NumericAlbedo
from gonio.claims import Claims, Place, at_most, kink
from gonio.lang import (
    INV_PI,
    TWO_PI,
    Color,
    Float,
    Sample,
    Vec2,
    Vec3,
    cos,
    exp,
    lerp,
    log,
    maximum,
    minimum,
    normalize,
    safe_sqrt,
    sin,
    vec3,
)
from gonio.model import Model, param
from gonio.parts.distribution import RANDOM_MARGIN
from gonio.parts.frame import half_length, half_vector, mirror, pdf_mirror
from gonio.parts.fresnel import schlick_weight_half
from gonio.parts.image import ImageLobes, schlick_albedo
from gonio.parts.masking import V_cook_torrance
from gonio.parts.roughness import at_least_alpha
from gonio.parts.special import expm1, log1p

# Range of gamma: at 1.5 the mean slope has no end, and at 40 D is Beckmann's to a percent.
GAMMA_MIN, GAMMA_MAX = 1.55, 40.0

# Smallest width, below which a float32 has no digits left for the slopes.
ALPHA_LEAST = 1e-3

# Largest squared slope in units of the widths: more leaves a float32, and D is 0 long before.
RATIO_MAX = 1e37


class StudentT(Model):
    """Metals and plastics whose highlights have the tail that was measured. Reciprocal."""

    numeric = NumericAlbedo("half_vectors")

    f0: Color = param((0.9, 0.9, 0.9), 0, 1, "reflectance at normal incidence, linear RGB")
    alpha: Float = param(
        0.3, ALPHA_LEAST, 1, "slope width: GGX's alpha at gamma = 2", rougher=at_least_alpha
    )
    gamma: Float = param(
        2, GAMMA_MIN, GAMMA_MAX, "tail: 2 is GGX's, smaller is longer, 40 is nearly Beckmann's"
    )
    caveats = (
        "Loses what facets reflect more than once.",
        "Wastes the samples that a facet mirrors below the horizon.",
    )
    claims = Claims(
        wasted=at_most(0.575),
        float32=at_most(2e-5),
        numeric_albedo=at_most(3e-4),
        kinks=(kink(Place.EQUAL_COSINES), kink(Place.ELSEWHERE)),
    )

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """F D G / (4 mu_i mu_o): BRDF value in 1/sr, without the cosine."""
        return lerp(self.f0, 1, schlick_weight_half(wi, wo)) * self.highlight(wi, wo)

    def highlight(self, wi: Vec3, wo: Vec3) -> Float:
        """D G / (4 mu_i mu_o): the highlight without F."""
        m = half_vector(wi, wo)
        return self._D(m) * V_cook_torrance(wi, wo)

    def highlight_albedo(self, split: Vec2) -> Color:
        """What the highlight reflects of light from everywhere, from its table's A and B."""
        return schlick_albedo(self.f0, 1, split)

    def image_lobes(self, mu: Float) -> ImageLobes:
        """The highlight, for light from pictures; its table belongs to this gamma."""
        return ImageLobes(self.alpha, 0)

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """wo mirrored at a normal by its density."""
        wi = mirror(wo, self._normal(u))
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample` in 1/sr."""
        m = half_vector(wi, wo)
        return pdf_mirror(self._D(m) * m.z, half_length(wi, wo))

    def _D(self, m: Vec3) -> Float:
        """1 / (pi a^2 z^4 (1 + x)^g) with x = tan^2 / ((g - 1) a^2)."""
        a2, z2 = self.alpha * self.alpha, m.z * m.z
        slope2 = (m.x * m.x + m.y * m.y) / ((self.gamma - 1) * a2)
        # z^-4 (1 + x)^-g = (z^2 + slope2)^-2 (1 + x)^(2 - g), finite in the horizon; log1p keeps the digits
        # that a large g multiplies
        x = minimum(slope2 / z2, RATIO_MAX)
        whole = z2 + slope2
        return INV_PI / a2 / (whole * whole) * exp((2 - self.gamma) * log1p(x))

    def _normal(self, u: Vec2) -> Vec3:
        """tan^2 = (g - 1) a^2 ((1 - u)^(1 / (1 - g)) - 1)."""
        spread = expm1(log(maximum(1 - u.x, RANDOM_MARGIN)) / (1 - self.gamma))
        tangent = self.alpha * safe_sqrt((self.gamma - 1) * spread)
        phi = TWO_PI * u.y
        return normalize(vec3(tangent * cos(phi), tangent * sin(phi), 1))
