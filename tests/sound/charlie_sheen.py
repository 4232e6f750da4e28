"""Sound, though unusual: cloth with Charlie's distribution, which is brightest at the horizon."""

from gonio.lang import INV_TWO_PI, Color, Float, Sample, Vec2, Vec3, exp, log, maximum
from gonio.model import Model, param
from gonio.parts.frame import half_vector
from gonio.parts.hemisphere import pdf_uniform, sample_uniform

# Smallest sine whose power is taken: its logarithm is finite.
SINE2_MIN = 1e-14


class CharlieSheen(Model):
    """Velvet: D of Estevez and Kulla with Neubelt's masking, scaled down to lose energy."""

    tint: Color = param((0.5, 0.5, 0.5), 0, 1, "colour")
    alpha: Float = param(0.5, 0.2, 1, "roughness of the fibres")

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """(2 + 1 / alpha) sin^(1 / alpha) / (2 pi), over 4 (mu_i + mu_o - mu_i mu_o)."""
        m = half_vector(wi, wo)
        sine2 = maximum(m.x * m.x + m.y * m.y, SINE2_MIN)
        D = (2 + 1 / self.alpha) * exp(0.5 * log(sine2) / self.alpha) * INV_TWO_PI
        return self.tint * (0.5 * D / (4 * (wi.z + wo.z * (1 - wi.z))))

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Uniform."""
        return Sample(sample_uniform(u), pdf_uniform())

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample`."""
        return pdf_uniform() + 0 * wi.z
