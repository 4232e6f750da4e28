"""Broken on purpose: two options that are right one by one, and gain energy together."""

from gonio.lang import INV_PI, Color, Float, Sample, Vec2, Vec3
from gonio.model import Model, option, param
from gonio.parts.hemisphere import pdf_cosine, sample_cosine


class PairOfOptions(Model):
    """Lambert with two ways to count the same light."""

    rho: Color = param((0.5, 0.5, 0.5), 0, 0.9, "colour")
    sky: str = option("part", "whole", "none", doc="how much of the sky counts")
    ground: str = option("part", "whole", doc="how much of the ground counts")

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """A half each at most, but both halves are counted twice when both are whole."""
        share = 0.25
        if self.sky == "whole":
            share = 0.5
        if self.sky == "none":
            share = 0.0
        if self.ground == "whole":
            share = 1.5 * share + 0.25
        return self.rho * (1.2 * INV_PI * share)

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Cosine-weighted."""
        wi = sample_cosine(u)
        return Sample(wi, pdf_cosine(wi))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample`."""
        return pdf_cosine(wi)
