"""Broken on purpose: a value that jumps while a parameter changes."""

from gonio.lang import INV_PI, Color, Float, Sample, Vec2, Vec3, select
from gonio.model import Model, param
from gonio.parts.hemisphere import pdf_cosine, sample_cosine


class SteppedParameter(Model):
    """Lambert, darker when worn."""

    rho: Color = param((0.5, 0.5, 0.5), 0, 0.9, "colour")
    wear: Float = param(0.2, 0, 1, "darkens")

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """A tenth darker at once from sqrt(1 / 3) on."""
        worn = select(self.wear * self.wear * 3 > 1, 0.1, 0)
        return self.rho * (INV_PI * (1 - 0.5 * self.wear - worn))

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Cosine-weighted."""
        wi = sample_cosine(u)
        return Sample(wi, pdf_cosine(wi))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample`."""
        return pdf_cosine(wi)
