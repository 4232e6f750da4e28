"""Phong: a diffuse term and a highlight around the mirror direction.

Sources: Phong, "Illumination for computer generated pictures", Communications of the ACM 18(6), 1975;
Lafortune, Willems, "Using the modified Phong reflectance model for physically based rendering", 1994,
for the normalised form. alpha is the angle between wi and the mirror direction of wo.
Phong's formula gives the radiance f cos(theta_i); "classical" is that formula divided by the cosine.
"""

from gonio.albedos.quadrature import NumericAlbedo
from gonio.claims import Claims, Place, at_most, jump, kink
from gonio.lang import (
    INV_PI,
    INV_TWO_PI,
    PI,
    TWO_PI,
    Color,
    Float,
    Sample,
    Vec2,
    Vec3,
    absolute,
    clamp,
    cos,
    dot,
    exp,
    fma,
    lerp,
    log,
    minimum,
    normalize,
    safe_sqrt,
    select,
    sin,
    sqrt,
    vec3,
)
from gonio.model import Model, option, param
from gonio.parts.frame import azimuth
from gonio.parts.hemisphere import pdf_cosine, sample_cosine
from gonio.parts.image import ImageLobes
from gonio.parts.lobes import average, choose, shares
from gonio.parts.roughness import at_most_phong
from gonio.parts.special import LOG1P_SMALL, expm1, log1p_small

# Smallest cosine whose logarithm is taken: its reciprocal, the derivative, still is a float32.
COS_MIN = 1e-37


def cos_alpha(wi: Vec3, wo: Vec3) -> Float:
    """Cosine between wi and the mirror direction of wo: mu_i mu_o - wi.x wo.x - wi.y wo.y.

    Near 0 the three products cancel. The rounding errors of the last two and of their sum are carried
    along (Kahan's and Knuth's ways to find them), so that a broad lobe fades out with all its digits; the
    first product comes in with a single rounding, which is small beside what is left.
    """
    x, y = wi.x * wo.x, wi.y * wo.y
    s = x + y
    back_y = s - x
    error_s = (x - (s - back_y)) + (y - back_y)
    error = fma(wi.x, wo.x, -x) + fma(wi.y, wo.y, -y) + error_s
    return fma(wi.z, wo.z, -s) - error


def lobe(wi: Vec3, wo: Vec3, exponent: Float) -> Float:
    """max(0, cos(alpha))^exponent; half of all directions have 0 for exponent 0 as well."""
    # Inside, the digits of a sharp lobe are in 1 - cos(alpha): half the squared distance to the mirror
    # direction.
    apart = vec3(wi.x + wo.x, wi.y + wo.y, wi.z - wo.z)
    q = 0.5 * dot(apart, apart)
    c = cos_alpha(wi, wo)
    near = log1p_small(-minimum(q, LOG1P_SMALL))
    log_cos = select(q < LOG1P_SMALL, near, log(clamp(c, COS_MIN, 1)))
    return select(c > 0, exp(exponent * log_cos), 0)


def sample_lobe(wo: Vec3, exponent: Float, u: Vec2) -> Vec3:
    """A direction around wo's mirror image with density (n + 1) / (2 pi) cos(alpha)^n.

    What falls below the horizon is mirrored up again, so that no sample is wasted.
    """
    # cos(alpha) = (1 - u)^(1 / (n + 1)), and sin^2 = 1 - cos^2 without cancellation
    t = log(1 - u.x) / (exponent + 1)
    c, s = exp(t), safe_sqrt(-expm1(2 * t))
    phi = TWO_PI * u.y
    # A frame around the mirror direction: towards the normal, and level.
    axis = azimuth(wo)
    sin_o = safe_sqrt(wo.x * wo.x + wo.y * wo.y)
    x, y = s * cos(phi), s * sin(phi)
    outward = c * sin_o - x * wo.z
    up = c * wo.z + x * sin_o
    w = vec3(-axis.x * outward + axis.y * y, -axis.y * outward - axis.x * y, up)
    return normalize(vec3(w.x, w.y, absolute(w.z)))


def pdf_lobe(wi: Vec3, wo: Vec3, exponent: Float) -> Float:
    """Density of `sample_lobe` in 1/sr."""
    both = lobe(wi, wo, exponent) + lobe(vec3(wi.x, wi.y, -wi.z), wo, exponent)
    return INV_TWO_PI * (exponent + 1) * both


class Phong(Model):
    """Diffuse with a round highlight around the mirror direction, the classic of computer graphics."""

    numeric = NumericAlbedo("mirror")

    rho: Color = param((0.5, 0.5, 0.5), 0, 1, "albedo of the diffuse term, linear RGB")
    specular: Color = param((0.3, 0.3, 0.3), 0, 1, "weight of the highlight, linear RGB")
    shininess: Float = param(20, 0, 1e5, "exponent n of the highlight", rougher=at_most_phong)
    form: str = option(
        "normalized",
        "classical",
        doc="highlight specular (n+2)/(2 pi) cos^n, or Phong's specular cos^n / cos(theta_i)",
    )
    caveats = (
        "form='classical' is not reciprocal: swapping the directions multiplies the highlight by "
        "the ratio of their cosines.",
        "form='classical' reflects more than it receives for a strong broad highlight: specular 1 "
        "adds 6.28 / (n + 1) at the normal, more than 1 below shininess 5.28.",
        "form='normalized' adds exactly specular to the albedo at the normal, so rho + specular "
        "above 1 gains energy; at grazing angles little of it is left: 8.8 % for shininess 20.",
    )
    unlike = (
        (
            "triace_blinn_phong",
            "measures from the half vector; its exponent is about four times as large for the same width.",
        ),
    )
    claims = Claims(
        energy=(at_most(7.2832, form="classical"), at_most(2)),
        reciprocity=at_most(1, form="classical"),
        kinks=(
            kink(Place.RIGHT_ANGLE_TO_MIRROR),
            jump(Place.RIGHT_ANGLE_TO_MIRROR),
        ),
    )

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """BRDF value in 1/sr, without the cosine."""
        return self.rho * INV_PI + self.specular * self.highlight(wi, wo)

    def highlight(self, wi: Vec3, wo: Vec3) -> Float:
        """The highlight without its weight."""
        n = self.shininess
        if self.form == "classical":
            return lobe(wi, wo, n) / wi.z
        return INV_TWO_PI * (n + 2) * lobe(wi, wo, n)

    def highlight_albedo(self, split: Vec2) -> Color:
        """What the highlight reflects of light from everywhere, from its table's A and B."""
        return self.specular * (split.x + split.y)

    def image_lobes(self, mu: Float) -> ImageLobes:
        """The highlight and the diffuse part, for light from pictures."""
        # As wide as a Blinn-Phong lobe with four times its exponent
        alpha = sqrt(2 / (4 * self.shininess + 2))
        return ImageLobes(alpha, self.rho)

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Cosine-weighted, or around the mirror direction, by the estimated albedos."""
        first, v = choose(self._shares(wo).x, u)
        wi = select(first, sample_cosine(v), sample_lobe(wo, self.shininess, v))
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample` in 1/sr."""
        P = self._shares(wo)
        return P.x * pdf_cosine(wi) + P.y * pdf_lobe(wi, wo, self.shininess)

    def _shares(self, wo: Vec3) -> Vec2:
        """Probabilities of the diffuse lobe and of the highlight."""
        n = self.shininess
        if self.form == "classical":
            # Between the whole lobe at the normal and half of it at grazing angles
            highlight = PI / (n + 1) * (1 + wo.z)
        else:
            # 1 at the normal; in the horizon about 1 / sqrt(2 pi n), and 1/2 for n = 0
            highlight = lerp(0.5 / sqrt(1 + 0.5 * PI * n), 1, wo.z)
        return shares(average(self.rho), average(self.specular) * highlight)
