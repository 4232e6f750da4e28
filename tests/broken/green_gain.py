"""Broken on purpose: gains energy in one channel of a saturated colour only."""

from gonio.lang import INV_PI, Color, Float, Sample, Vec2, Vec3, maximum, vec3
from gonio.model import Model, param
from gonio.parts.hemisphere import pdf_cosine, sample_cosine


class GreenGain(Model):
    """Lambert with a saturated green."""

    rho: Color = param((0.5, 0.5, 0.5), 0, 0.9, "colour")

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """A tenth more green, beyond what a colour may have."""
        green = maximum(self.rho.y - self.rho.x - 0.8, 0)
        return (self.rho + vec3(0 * green, 4 * green, 0 * green)) * INV_PI

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Cosine-weighted."""
        wi = sample_cosine(u)
        return Sample(wi, pdf_cosine(wi))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample`."""
        return pdf_cosine(wi)
