"""Broken on purpose: brighter than white where two parameters are both in a narrow window."""

from gonio.lang import INV_PI, Color, Float, Sample, Vec2, Vec3, absolute, select
from gonio.model import Model, param
from gonio.parts.hemisphere import pdf_cosine, sample_cosine


class NarrowWindows(Model):
    """Lambert, mixed with itself, twice."""

    rho: Color = param((0.5, 0.5, 0.5), 0, 0.99, "colour")
    mix: Float = param(0.5, 0, 1, "of the same with the same")
    more: Float = param(0.5, 0, 1, "of the same with the same")

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """A tenth more where both are within a hundredth."""
        inside = (absolute(40 * self.mix - 15.3) < 0.4) & (absolute(40 * self.more - 33.4) < 0.4)
        return self.rho * (INV_PI * select(inside, 1.1, 1))

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Cosine-weighted."""
        wi = sample_cosine(u)
        return Sample(wi, pdf_cosine(wi))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample`."""
        return pdf_cosine(wi)
