"""Lambert sphere: light in a half space of white or coloured balls, each of them Lambertian.

Source: d'Eon, "An analytic BRDF for materials with spherical Lambertian scatterers", Computer Graphics
Forum 40(4), 2021: the phase function of a Lambertian ball once, and even scattering after that, with the
function H of Hapke, "Bidirectional reflectance spectroscopy, 1: theory", Journal of Geophysical Research,
1981, which d'Eon compares his own fit with.
"""

from gonio.claims import Claims, at_most
from gonio.lang import (
    PI,
    Color,
    Float,
    Sample,
    Vec2,
    Vec3,
    dot,
    length,
    maximum,
    minimum,
    select,
    smooth_sqrt,
    twice_atan_over,
)
from gonio.model import Model, param
from gonio.parts.hemisphere import pdf_uniform, sample_uniform

INV_FOUR_PI = 0.25 / PI

# 2 / (3 pi^2) makes the mean of the phase function over all directions 1 / (4 pi).
PHASE = 2 / (3 * PI * PI)

# Below this angle to the straight direction sin y - y cos y is taken by its series: it would cancel.
SMALL = 0.4


class LambertSphere(Model):
    """Chalk and other powders: flatter than Lambert, brighter back to the light. Reciprocal."""

    rho: Color = param((0.8, 0.8, 0.8), 0, 1, "albedo of a single ball, linear RGB")
    caveats = (
        "All scattering but the first counts as even, by Hapke's H, which is within 4 % of "
        "Chandrasekhar's: white balls seen from above reflect 18 % more than they receive.",
    )
    unlike = (
        ("hapke", "has the phase function of Henyey and Greenstein and an opposition effect."),
        ("lommel_seeliger", "scatters once only, and evenly."),
    )
    claims = Claims(energy=at_most(1.18))

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """BRDF value in 1/sr, without the cosine."""
        h_i, h_o = self._H_minus_1(wi.z), self._H_minus_1(wo.z)
        often = INV_FOUR_PI * (h_i + h_o + h_i * h_o)
        return self.rho * (self._phase(wi, wo) + often) / (wi.z + wo.z)

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Uniform: mu_i / (mu_i + mu_o) has a bound."""
        wi = sample_uniform(u)
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample` in 1/sr."""
        return pdf_uniform()

    def _H_minus_1(self, mu: Float) -> Color:
        """H - 1 of H = (1 + 2 mu) / (1 + 2 mu gamma) with gamma = sqrt(1 - w)."""
        gamma = smooth_sqrt(1 - self.rho)
        return 2 * mu * self.rho / ((1 + gamma) * (1 + 2 * mu * gamma))

    def _phase(self, wi: Vec3, wo: Vec3) -> Float:
        """2 (sin y - y cos y) / (3 pi^2) at the angle y that light is turned from its way."""
        # Twice the sine and cosine of half the angle between wi and wo; the smaller has all its digits
        across = smooth_sqrt(dot(wi - wo, wi - wo))
        along = length(wi + wo)
        t = minimum(across, along) / maximum(across, along)
        small = t * twice_atan_over(t)
        y = select(across < along, PI - small, small)
        y2 = y * y
        series = y * y2 / 3 * (1 - y2 / 10 * (1 - y2 / 28 * (1 - y2 / 54)))
        exact = 0.5 * across * along + y * dot(wi, wo)
        return PHASE * select(y < SMALL, series, exact)
