"""Broken on purpose: an albedo that is not a number for a black colour."""

from gonio.lang import INV_PI, Color, Float, Sample, Vec2, Vec3
from gonio.model import Model, param
from gonio.parts.hemisphere import pdf_cosine, sample_cosine


class NanAlbedo(Model):
    """Lambert."""

    rho: Color = param((0.5, 0.5, 0.5), 0, 0.9, "colour")

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """rho / pi."""
        return self.rho * INV_PI

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Cosine-weighted."""
        wi = sample_cosine(u)
        return Sample(wi, pdf_cosine(wi))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample`."""
        return pdf_cosine(wi)

    def albedo(self, wo: Vec3) -> Color:
        """rho, but 0 / 0 for 0."""
        return self.rho * (self.rho / self.rho)
