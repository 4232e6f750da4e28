"""Broken on purpose: claims to fall, but rises between two steps of a coarse grid."""

from gonio.claims import Claims
from gonio.lang import INV_PI, Color, Float, Sample, Vec2, Vec3, exp
from gonio.model import Model, param
from gonio.parts.hemisphere import pdf_cosine, sample_cosine


class BumpInParameter(Model):
    """Lambert, darker when worn."""

    rho: Color = param((0.5, 0.5, 0.5), 0, 0.9, "colour")
    wear: Float = param(0.2, 0, 1, "darkens")
    claims = Claims(falls=("wear",))

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """Falls, but for a bump of width 0.03 around 0.4375."""
        d = (self.wear - 0.4375) / 0.03
        return self.rho * (INV_PI * (1 - 0.5 * self.wear + 0.05 * exp(-d * d)))

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Cosine-weighted."""
        wi = sample_cosine(u)
        return Sample(wi, pdf_cosine(wi))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample`."""
        return pdf_cosine(wi)
