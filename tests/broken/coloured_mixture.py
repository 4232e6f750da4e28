"""Broken on purpose: a mixture chosen by luminance, with a density that takes the mean."""

from gonio.lang import INV_PI, Color, Float, Sample, Vec2, Vec3, dot, select, vec2, vec3
from gonio.model import Model, param
from gonio.parts.hemisphere import pdf_cosine, pdf_uniform, sample_cosine, sample_uniform
from gonio.parts.lobes import average


class ColouredMixture(Model):
    """Two diffuse layers; the same for all greys."""

    rho: Color = param((0.4, 0.4, 0.4), 0, 0.5, "colour")

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """Lambert and a flat layer."""
        return (self.rho + 0.3) * INV_PI

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Uniform with the probability of the luminance."""
        P = dot(self.rho, vec3(0.2126, 0.7152, 0.0722))
        uniform = u.x < P
        v = vec2(select(uniform, u.x / (P + 1e-9), (u.x - P) / (1 - P)), u.y)
        wi = select(uniform, sample_uniform(v), sample_cosine(v))
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Uniform with the probability of the mean."""
        P = average(self.rho)
        return P * pdf_uniform() + (1 - P) * pdf_cosine(wi)
