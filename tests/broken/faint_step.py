"""Broken on purpose: a jump in a parameter, small beside what it changes anyway."""

from gonio.lang import INV_PI, Color, Float, Sample, Vec2, Vec3, select
from gonio.model import Model, param
from gonio.parts.hemisphere import pdf_cosine, sample_cosine


class FaintStep(Model):
    """Lambert under dust, whose two fits do not meet."""

    rho: Color = param((0.5, 0.5, 0.5), 0, 0.9, "colour")
    dust: Float = param(0.2, 0, 1, "darkens")

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """Above 0.61 another fit, by 0.06 % too dark."""
        clear = 1 - 0.8 * self.dust
        return self.rho * (INV_PI * select(self.dust > 0.61, 0.9994 * clear, clear))

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Cosine-weighted."""
        wi = sample_cosine(u)
        return Sample(wi, pdf_cosine(wi))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample`."""
        return pdf_cosine(wi)
