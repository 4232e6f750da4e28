"""Ashikhmin–Shirley: an anisotropic Phong highlight over a diffuse part that it takes its light from.

Source: Ashikhmin, Shirley, "An anisotropic Phong BRDF model", Journal of Graphics Tools 5(2), 2000: Eq. 4,
5 and, for samples, 6 to 9.
Deviation: (N.H) to its power is taken from the slopes of H, which a sharp lobe needs in float32.
"""

from gonio.albedos.quadrature import NumericAlbedo
from gonio.claims import Claims, Place, at_most, kink
from gonio.lang import (
    INV_PI,
    INV_TWO_PI,
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
    select,
    sin,
    sqrt,
    vec2,
    vec3,
)
from gonio.model import Model, param
from gonio.parts.distribution import RANDOM_MARGIN, blinn_phong_alpha
from gonio.parts.frame import half_length, half_vector, mirror
from gonio.parts.fresnel import schlick_weight, schlick_weight_half
from gonio.parts.hemisphere import pdf_cosine, sample_cosine
from gonio.parts.image import ImageLobes, schlick_albedo
from gonio.parts.lobes import average, choose, shares
from gonio.parts.masking import V_MAX
from gonio.parts.roughness import at_most_blinn_phong
from gonio.parts.special import expm1, log1p_over

# Eq. 5: 28 / 23 makes the diffuse part of a black highlight lose nothing.
DIFFUSE = 28 / 23


class AshikhminShirley(Model):
    """Brushed metal and varnished wood by two exponents. Reciprocal."""

    numeric = NumericAlbedo("half_vectors", stretched=True, round_part=True)
    isotropic = False

    rho: Color = param((0.5, 0.5, 0.5), 0, 1, "diffuse reflectance R_d, linear RGB")
    f0: Color = param((0.04, 0.04, 0.04), 0, 1, "reflectance R_s at normal incidence, linear RGB")
    shininess_x: Float = param(100, 0, 1e5, "exponent n_u along x", rougher=at_most_blinn_phong)
    shininess_y: Float = param(100, 0, 1e5, "exponent n_v along y", rougher=at_most_blinn_phong)
    caveats = (
        "Loses energy: with f0 = 1 and shininess 1 it reflects half of the light at the normal.",
        "Wastes the samples that a facet mirrors below the horizon: half of them at grazing angles, more "
        "with shininess 0.",
    )
    claims = Claims(
        wasted=at_most(0.71), kinks=kink(Place.EQUAL_COSINES), numeric_albedo=at_most(1e-4)
    )

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """Eq. 4 and 5: BRDF value in 1/sr, without the cosine."""
        F = lerp(self.f0, 1, schlick_weight_half(wi, wo))
        return self.eval_round(wi, wo) + F * self.highlight(wi, wo)

    def highlight(self, wi: Vec3, wo: Vec3) -> Float:
        """The highlight of Eq. 4 without F."""
        V = minimum(0.25 / half_length(wi, wo) / maximum(wi.z, wo.z), V_MAX)
        return self._weighed(half_vector(wi, wo), V)

    def highlight_albedo(self, split: Vec2) -> Color:
        """What the highlight reflects of light from everywhere, from its table's A and B."""
        return schlick_albedo(self.f0, 1, split)

    def image_lobes(self, mu: Float) -> ImageLobes:
        """The highlight and the diffuse part, for light from pictures."""
        a = self.slope_widths()
        # The light's factor of Eq. 5 integrates to 23 pi / 28 over the hemisphere.
        matte = self.rho * (1 - self.f0) * self._below(mu)
        return ImageLobes(sqrt(a.x * a.y), matte)

    def eval_round(self, wi: Vec3, wo: Vec3) -> Color:
        """The diffuse part, which is not stretched (Eq. 5)."""
        below = self._below(wi.z) * self._below(wo.z)
        return DIFFUSE * INV_PI * below * self.rho * (1 - self.f0)

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Cosine-weighted, or wo mirrored at a normal by its density (Eq. 6, 7 and 9)."""
        matte, v = choose(self._shares(wo).x, u)
        wi = select(matte, sample_cosine(v), mirror(wo, self._normal(v)))
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample` in 1/sr (Eq. 8)."""
        P = self._shares(wo)
        facets = self._weighed(half_vector(wi, wo), 0.25 / half_length(wi, wo))
        return P.x * pdf_cosine(wi) + P.y * facets

    def slope_widths(self) -> Vec2:
        """As those of Blinn-Phong lobes."""
        return vec2(blinn_phong_alpha(self.shininess_x), blinn_phong_alpha(self.shininess_y))

    def _below(self, mu: Float) -> Float:
        """1 - (1 - mu / 2)^5, with the factor mu taken out."""
        k = 1 - 0.5 * mu
        return 0.5 * mu * (1 + k * (1 + k * (1 + k * (1 + k))))

    def _weighed(self, m: Vec3, weight: Float) -> Float:
        """Density of normals, times a weight.

        sqrt((n_u + 1) (n_v + 1)) / (2 pi) (N.m)^(n_u cos^2 + n_v sin^2 of the azimuth).
        """
        # -log(N.m) (n_u x^2 + n_v y^2) / (x^2 + y^2) with log(N.m) = -log(1 + tan^2) / 2: the square of the
        # sine cancels
        x2, y2, z2 = m.x * m.x, m.y * m.y, m.z * m.z
        steep = 0.25 * log1p_over((x2 + y2) / z2) / z2
        norm = INV_TWO_PI * sqrt((self.shininess_x + 1) * (self.shininess_y + 1))
        # The root of the power, which twice has a place in a float32 where the power by itself has none
        root = exp(-(self.shininess_x * x2 + self.shininess_y * y2) * steep)
        return norm * root * (root * weight)

    def _normal(self, u: Vec2) -> Vec3:
        phi = TWO_PI * u.y
        x = cos(phi) / sqrt(self.shininess_x + 1)
        y = sin(phi) / sqrt(self.shininess_y + 1)
        r2 = x * x + y * y
        exponent = (self.shininess_x * x * x + self.shininess_y * y * y) / r2
        tan2 = expm1(-2 / (exponent + 1) * log(maximum(1 - u.x, RANDOM_MARGIN)))
        scale = safe_sqrt(tan2) / sqrt(r2)
        return normalize(vec3(x * scale, y * scale, 1))

    def _shares(self, wo: Vec3) -> Vec2:
        """Probabilities of the diffuse part and of the highlight."""
        F = lerp(self.f0, 1, schlick_weight(wo.z))
        return shares(average(self.rho * (1 - self.f0)), average(F))
