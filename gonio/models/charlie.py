"""Charlie: sheen of cloth, fibres that stand up.

Source: Estevez, Kulla, "Production friendly microfacet sheen BRDF", SIGGRAPH 2017 course, Eq. 2 for the
distribution; its masking grows without bound in the horizon, and real-time renderers took that of Neubelt,
Pettineo, "Crafting a next-gen material pipeline for The Order: 1886", SIGGRAPH 2013 course, which is here.
"""

from gonio.claims import Claims, at_most
from gonio.lang import INV_TWO_PI, Color, Float, Sample, Vec2, Vec3, exp, log, maximum
from gonio.model import Model, param
from gonio.parts.frame import half_vector
from gonio.parts.hemisphere import pdf_uniform, sample_uniform

# Smallest squared sine of a half vector: below it grazing directions have no digits left for it.
SIN2_LEAST = 1e-12


class Charlie(Model):
    """Velvet and felt: bright at the edges, to be laid over a base. Reciprocal."""

    rho: Color = param((0.8, 0.8, 0.8), 0, 1, "colour of the sheen, linear RGB")
    alpha: Float = param(0.4, 0.05, 1, "roughness of the fibres; 1 / alpha is the sine's exponent")
    caveats = (
        "Reflects little but at grazing angles: the base below has to be dimmed by what it reflects.",
        "Reflects more than it receives at grazing angles when fibres stand upright (small alpha).",
    )
    claims = Claims(energy=at_most(1.86))

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """D / (4 (mu_i + mu_o - mu_i mu_o)): BRDF value in 1/sr, without the cosine."""
        m = half_vector(wi, wo)
        inv = 1 / self.alpha
        sin2 = maximum(m.x * m.x + m.y * m.y, SIN2_LEAST)
        D = INV_TWO_PI * (2 + inv) * exp(0.5 * inv * log(sin2))
        return self.rho * (0.25 * D / (wi.z + wo.z * (1 - wi.z)))

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Uniform: mu_i / (mu_i + mu_o) has a bound."""
        wi = sample_uniform(u)
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample` in 1/sr."""
        return pdf_uniform()
