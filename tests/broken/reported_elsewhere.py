"""Broken on purpose: in a corner of two parameters some samples report another density than `pdf`."""

from gonio.lang import INV_PI, Color, Float, Sample, Vec2, Vec3, select
from gonio.model import Model, param
from gonio.parts.hemisphere import pdf_cosine, sample_cosine


class ReportedElsewhere(Model):
    """Lambert, darker when worn and when dry."""

    rho: Color = param((0.5, 0.5, 0.5), 0, 0.9, "colour")
    wear: Float = param(0.2, 0, 1, "darkens")
    dry: Float = param(0.9, 0, 1, "darkens")

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """Lambert."""
        return self.rho * ((1 - 0.3 * self.wear) * (1 - 0.3 * self.dry) * INV_PI)

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Cosine-weighted; two in a hundred report a thousandth too little."""
        wi = sample_cosine(u)
        wrong = (u.y < 0.02) & (self.wear > 0.7) & (self.dry < 0.3)
        return Sample(wi, pdf_cosine(wi) * select(wrong, 0.999, 1))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample`."""
        return pdf_cosine(wi)
