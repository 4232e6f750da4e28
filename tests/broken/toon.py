"""Broken on purpose: two tones with an edge between them."""

from gonio.lang import INV_PI, Color, Float, Sample, Vec2, Vec3, dot, select
from gonio.model import Model, param
from gonio.parts.hemisphere import pdf_cosine, sample_cosine


class Toon(Model):
    """Lambert, darker where light and viewer are more than 60 degrees apart."""

    rho: Color = param((0.5, 0.5, 0.5), 0, 0.9, "colour")

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """Bright or dark."""
        return self.rho * select(dot(wi, wo) > 0.5, INV_PI, 0.5 * INV_PI)

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Cosine-weighted."""
        wi = sample_cosine(u)
        return Sample(wi, pdf_cosine(wi))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample`."""
        return pdf_cosine(wi)
