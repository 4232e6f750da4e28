"""Broken on purpose: NaN at cosines around 1e-12, far below what one tries by hand."""

from gonio.lang import INV_PI, Color, Float, Sample, Vec2, Vec3, minimum, select, sqrt
from gonio.model import Model, param
from gonio.parts.hemisphere import pdf_cosine, sample_cosine


class NanAtTinyCosines(Model):
    """Lambert."""

    rho: Color = param((0.5, 0.5, 0.5), 0, 0.9, "colour")

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """The root of a number that is negative between 2e-14 and 1e-10."""
        mu = minimum(wi.z, wo.z)
        hidden = select((mu > 2e-14) & (mu < 1e-10), -1, 1)
        return self.rho * (INV_PI * sqrt(1.0 * hidden))

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Cosine-weighted."""
        wi = sample_cosine(u)
        return Sample(wi, pdf_cosine(wi))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample`."""
        return pdf_cosine(wi)
