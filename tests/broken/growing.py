"""Broken on purpose: claims that wear makes it darker, but it gets brighter."""

from gonio.claims import Claims
from gonio.lang import INV_PI, Color, Float, Sample, Vec2, Vec3
from gonio.model import Model, param
from gonio.parts.hemisphere import pdf_cosine, sample_cosine


class Growing(Model):
    """Lambert, brighter when worn."""

    rho: Color = param((0.5, 0.5, 0.5), 0, 0.9, "colour")
    wear: Float = param(0.5, 0, 1, "brightens")
    claims = Claims(falls=("wear",))

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """Half as bright when new."""
        return self.rho * (INV_PI * (0.5 + 0.5 * self.wear))

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Cosine-weighted."""
        wi = sample_cosine(u)
        return Sample(wi, pdf_cosine(wi))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample`."""
        return pdf_cosine(wi)
