"""Sound, though unusual: grooves along y whose two flanks differ."""

from gonio.lang import INV_PI, Color, Float, Sample, Vec2, Vec3
from gonio.model import Model, param
from gonio.parts.hemisphere import pdf_cosine, sample_cosine


class Grooves(Model):
    """Diffuse flanks; brighter from one side."""

    rho: Color = param((0.5, 0.5, 0.5), 0, 0.9, "colour")
    slant: Float = param(0.5, 0, 1, "how much the flanks differ")
    isotropic = False

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """Reciprocal, smooth and not symmetric."""
        lit, seen = 1 + 0.5 * self.slant * wi.x, 1 + 0.5 * self.slant * wo.x
        return self.rho * (INV_PI / 2.25 * lit * seen)

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Cosine-weighted."""
        wi = sample_cosine(u)
        return Sample(wi, pdf_cosine(wi))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample`."""
        return pdf_cosine(wi)
