"""Broken on purpose: claims to fall, but blue rises between two rare settings of another parameter."""

from gonio.claims import Claims
from gonio.lang import INV_PI, Color, Float, Sample, Vec2, Vec3, maximum, vec3
from gonio.model import Model, param
from gonio.parts.hemisphere import pdf_cosine, sample_cosine


class GrowingWhenWet(Model):
    """Plaster, darker when worn and when wet; wet plaster that is much worn turns blue for a while."""

    rho: Color = param((0.5, 0.5, 0.5), 0, 0.9, "colour")
    wear: Float = param(0.2, 0, 1, "darkens")
    wet: Float = param(0, 0, 1, "darkens")
    claims = Claims(falls=("wear",))

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """A cap in wear of half width 0.07 at 0.61, for wet from 0.8 on."""
        t = (self.wear - 0.61) / 0.07
        blue = maximum(1 - t * t, 0) * maximum(self.wet - 0.8, 0)
        dark = (1 - 0.2 * self.wear) * (1 - 0.3 * self.wet)
        return (self.rho * dark + vec3(0, 0, 0.3) * blue) * INV_PI

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Cosine-weighted."""
        wi = sample_cosine(u)
        return Sample(wi, pdf_cosine(wi))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample`."""
        return pdf_cosine(wi)
