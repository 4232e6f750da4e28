"""Broken on purpose: a closed form of the albedo has no derivative at the end of a parameter's range."""

from gonio.lang import INV_PI, Color, Float, Sample, Vec2, Vec3, sqrt
from gonio.model import Model, param
from gonio.parts.hemisphere import pdf_cosine, sample_cosine


class AlbedoGradient(Model):
    """Lambert under grease that darkens grazing light."""

    rho: Color = param((0.5, 0.5, 0.5), 0, 1, "colour")
    grease: Float = param(0.2, 0, 1, "darkens")

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """rho / pi times (1 - g + g mu) of both directions, g half the grease."""
        g = 0.5 * self.grease
        return self.rho * ((1 - g + g * wi.z) * (1 - g + g * wo.z) * INV_PI)

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Cosine-weighted."""
        wi = sample_cosine(u)
        return Sample(wi, pdf_cosine(wi))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample`."""
        return pdf_cosine(wi)

    def albedo(self, wo: Vec3) -> Color:
        """The same, with an integral of 1 - g + 2 g / 3, and the root of a square for the grease."""
        g = 0.5 * sqrt(self.grease * self.grease)
        return self.rho * ((1 - g / 3) * (1 - g + g * wo.z))
