"""Broken on purpose: white, and gains 0.3 % at one angle of a narrow range of a parameter."""

from gonio.lang import INV_PI, Color, Float, Sample, Vec2, Vec3, exp
from gonio.model import Model, param
from gonio.parts.hemisphere import pdf_cosine, sample_cosine


def bump(x: Float, centre: Float) -> Float:
    """1 at the centre, and nothing a tenth away."""
    t = (x - centre) / 0.05
    return exp(-t * t)


class SlightGain(Model):
    """Lambert, corrected by a table with a flaw."""

    rho: Color = param((0.5, 0.5, 0.5), 0, 1, "colour")
    wear: Float = param(0.2, 0, 1, "where the flaw is")

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """Reciprocal; what is gained around one cosine is lost at the others."""
        flaw = bump(wi.z, 0.62) + bump(wo.z, 0.62) - 0.25
        return self.rho * (INV_PI * (1 + 0.003 * bump(self.wear, 0.43) * flaw))

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Cosine-weighted."""
        wi = sample_cosine(u)
        return Sample(wi, pdf_cosine(wi))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample`."""
        return pdf_cosine(wi)
