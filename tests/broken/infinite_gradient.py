"""Broken on purpose: a root with an infinite derivative at one end of its parameter's range."""

from gonio.lang import INV_PI, Color, Float, Sample, Vec2, Vec3, sqrt
from gonio.model import Model, param
from gonio.parts.hemisphere import pdf_cosine, sample_cosine


class InfiniteGradient(Model):
    """Lambert, darker when worn."""

    rho: Color = param((0.5, 0.5, 0.5), 0, 0.9, "colour")
    wear: Float = param(0.6, 0, 1, "darkens")

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """The root of 0 is 0, its derivative is not a number that one can use."""
        return self.rho * (INV_PI * (1 - 0.5 * sqrt(self.wear)))

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Cosine-weighted."""
        wi = sample_cosine(u)
        return Sample(wi, pdf_cosine(wi))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample`."""
        return pdf_cosine(wi)
