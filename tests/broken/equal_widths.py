"""Broken on purpose: 0 / 0 where two parameters are equal."""

from gonio.lang import INV_PI, Color, Float, Sample, Vec2, Vec3
from gonio.model import Model, param
from gonio.parts.hemisphere import pdf_cosine, sample_cosine


class EqualWidths(Model):
    """Lambert under two veils."""

    rho: Color = param((0.5, 0.5, 0.5), 0, 0.9, "colour")
    near: Float = param(0.2, 0, 1, "first veil")
    far: Float = param(0.6, 0, 1, "second veil")

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """A difference quotient, the mean of the two, without its limit."""
        mean = (self.near * self.near - self.far * self.far) / (self.near - self.far)
        return self.rho * (INV_PI * (1 - 0.25 * mean))

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Cosine-weighted."""
        wi = sample_cosine(u)
        return Sample(wi, pdf_cosine(wi))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample`."""
        return pdf_cosine(wi)
