"""Broken on purpose: 0 / 0 at the default of a parameter, and nowhere else."""

from gonio.lang import INV_PI, Color, Float, Sample, Vec2, Vec3
from gonio.model import Model, param
from gonio.parts.hemisphere import pdf_cosine, sample_cosine


class NanAtDefault(Model):
    """Lambert, darker away from a width of 0.35."""

    rho: Color = param((0.5, 0.5, 0.5), 0, 0.9, "colour")
    width: Float = param(0.35, 0.05, 0.9, "darkens")

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """(w - w0) / (w - w0) is 1, but for w = w0."""
        off = self.width - 0.35
        return self.rho * (INV_PI * (off / off))

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Cosine-weighted."""
        wi = sample_cosine(u)
        return Sample(wi, pdf_cosine(wi))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample`."""
        return pdf_cosine(wi)
