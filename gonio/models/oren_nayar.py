"""Oren–Nayar: the full model of 1994, with interreflection.

Source: Oren, Nayar, "Generalization of Lambert's reflectance model", SIGGRAPH 1994, Eq. 27 to 29.
Deviations: tangents and differences of nearly equal terms are rearranged so that they stay exact at
grazing angles; the values are the same. Where the value passes through zero on its way to a negative one,
float32 keeps an absolute accuracy of 1e-6 rho / pi, not a relative one.
"""

from gonio.albedos.quadrature import NumericAlbedo
from gonio.claims import Claims, Place, at_most, kink
from gonio.lang import (
    INV_PI,
    MU_MIN,
    PI,
    Color,
    Float,
    Sample,
    Vec2,
    Vec3,
    absolute,
    maximum,
    minimum,
    safe_acos,
    safe_asin,
    select,
    sqrt,
)
from gonio.model import Model, param
from gonio.parts import cltc
from gonio.parts.frame import tangential_cross, tangential_dot
from gonio.parts.oren_nayar import qualitative_coefficients

# Smallest product of squared sines that is divided by. Directions nearer to the normal have no
# azimuth that matters, and the reciprocal's derivative still fits into a float32.
SIN4_MIN = 1e-20


# Mean of (L1 - C1 rho / pi) pi / rho over both hemispheres, divided by sigma^2 / (sigma^2 + 0.09), on which
# all of it depends in the same way. From tests/derive_anchors.py, at 40 digits.
K_MEAN = 0.027764286107928


class OrenNayar(Model):
    """Rough diffuse from V-shaped grooves, single and double scattering. Reciprocal; loses energy."""

    numeric = NumericAlbedo("angles")

    rho: Color = param((0.8, 0.8, 0.8), 0, 1, "albedo of the facets, linear RGB")
    sigma: Float = param(0.5, 0, PI / 2, "standard deviation of the facet angle, radians")
    caveats = (
        "Reflects more than it receives at grazing angles for 0 < sigma < 0.63 and rho > 0.95, "
        "at most 1.0511.",
        "Loses energy at larger sigma: at pi/2 a white surface reflects 72 % at the normal.",
        "Goes negative for sigma > 0.6 and dark rho when light and viewer graze on opposite sides: at "
        "most -0.27 rho / pi (sigma = pi/2). The published fit is kept as it is.",
    )
    unlike = (
        (
            "qon",
            "is what most renderers mean by Oren–Nayar: the qualitative form, without interreflection.",
        ),
    )
    claims = Claims(
        energy=at_most(1.0511),
        negative=at_most(0.0565),
        kinks=(kink(Place.SIDE_LIGHT), kink(Place.EQUAL_COSINES)),
    )

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """Eq. 27 + 29: BRDF value in 1/sr, without the cosine."""
        s2 = self.sigma * self.sigma
        # alpha is the larger, beta the smaller of the two polar angles.
        cos_alpha, cos_beta = minimum(wi.z, wo.z), maximum(wi.z, wo.z)
        sin2_i = wi.x * wi.x + wi.y * wi.y
        sin2_o = wo.x * wo.x + wo.y * wo.y
        sin_alpha = sqrt(maximum(maximum(sin2_i, sin2_o), MU_MIN))
        sin_beta = sqrt(maximum(minimum(sin2_i, sin2_o), MU_MIN))
        beta_complement = safe_asin(cos_beta)
        beta = PI / 2 - beta_complement
        tan_beta = sin_beta / cos_beta

        # c = cos(phi_i - phi_o), and 1 - |c| from the sine of that angle, which keeps its digits
        s = tangential_dot(wi, wo)
        cross = tangential_cross(wi, wo)
        q = sqrt(maximum(sin2_i * sin2_o, SIN4_MIN))
        c = s / q
        one_minus_c = (cross / q) * (cross / (q + absolute(s)))

        C1 = 1 - 0.5 * s2 / (s2 + 0.33)
        # C2 c tan(beta) for c < 0 needs sin(alpha) - (2 beta / pi)^3, in which two ones cancel when both
        # directions graze. With 2 beta / pi = 1 - delta they are gone.
        delta = 2 * INV_PI * beta_complement
        dip = delta * (3 - delta * (3 - delta)) - cos_alpha * cos_alpha / (1 + sin_alpha)
        C2 = 0.45 * s2 / (s2 + 0.09) * select(s >= 0, sin_alpha, dip)
        four_alpha_beta = 4 * INV_PI * INV_PI * safe_acos(cos_alpha) * beta
        C3 = 0.125 * s2 / (s2 + 0.09) * four_alpha_beta * four_alpha_beta
        tan_half = (sin_alpha + sin_beta) / (cos_alpha + cos_beta)
        L1 = C1 + c * C2 * tan_beta + one_minus_c * C3 * tan_half

        two_beta = 2 * INV_PI * beta
        L2 = 0.17 * s2 / (s2 + 0.13) * (1 - c * two_beta * two_beta)
        return self.rho * (INV_PI * L1) + self.rho * self.rho * (INV_PI * L2)

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """EON's sampler, at the roughness that fits the qualitative model."""
        A, B = qualitative_coefficients(self.sigma, 0.33)
        wi = cltc.sample_cltc_matched(wo, B / A, u)
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample` in 1/sr."""
        A, B = qualitative_coefficients(self.sigma, 0.33)
        return cltc.pdf_cltc_matched(wi, wo, B / A)

    def mean_albedo(self) -> Color:
        """Hemispherical mean of the albedo; the azimuth averages L2's c to nothing."""
        s2 = self.sigma * self.sigma
        single = 1 - 0.5 * s2 / (s2 + 0.33) + K_MEAN * s2 / (s2 + 0.09)
        return self.rho * (single + self.rho * (0.17 * s2 / (s2 + 0.13)))
