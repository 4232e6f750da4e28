"""Broken on purpose: wrong just below the end of a parameter, and right at the end itself."""

from gonio.lang import INV_PI, Color, Float, Sample, Vec2, Vec3, select
from gonio.model import Model, param
from gonio.parts.hemisphere import pdf_cosine, sample_cosine


class NearAnEnd(Model):
    """Lambert, mixed with itself."""

    rho: Color = param((0.5, 0.5, 0.5), 0, 0.9, "colour")
    mix: Float = param(0.5, 0, 1, "of the same with the same")

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """Brighter than white where 1 - mix is between 1e-7 and 2e-5."""
        rest = 1 - self.mix
        wrong = select((rest > 1e-7) & (rest < 2e-5), 1.6, 1)
        return self.rho * (INV_PI * wrong)

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Cosine-weighted."""
        wi = sample_cosine(u)
        return Sample(wi, pdf_cosine(wi))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample`."""
        return pdf_cosine(wi)
