"""Broken on purpose: a mean albedo, beside a quadrature, that is off in a sixth of a parameter's range."""

from gonio.lang import INV_PI, Color, Float, Sample, Vec2, Vec3, select
from gonio.model import Model, param
from gonio.parts.hemisphere import pdf_cosine, sample_cosine


class MeanInAPart(Model):
    """Lambert under a veil that is bright towards the normal."""

    rho: Color = param((0.5, 0.5, 0.5), 0, 0.6, "colour")
    veil: Float = param(0.3, 0, 1, "part of the veil")

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """rho / pi (1 - veil + veil 9/4 mu_i mu_o)."""
        return self.rho * ((1 - self.veil + 2.25 * self.veil * wi.z * wo.z) * INV_PI)

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Cosine-weighted."""
        wi = sample_cosine(u)
        return Sample(wi, pdf_cosine(wi))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample`."""
        return pdf_cosine(wi)

    def mean_albedo(self) -> Color:
        """Rho, but a thousandth more for a sixth of the veil."""
        wrong = (self.veil > 0.35) & (self.veil < 0.35 + 1 / 6)
        return self.rho * select(wrong, 1.001, 1)
