"""Broken on purpose: a sampler for which +x is a special side, in a model that is meant to be isotropic."""

from gonio.claims import Claims, at_most
from gonio.lang import INV_PI, Color, Float, Sample, Vec2, Vec3, absolute, select, vec3
from gonio.model import Model, param
from gonio.parts.hemisphere import pdf_cosine, sample_cosine


class HalfSampler(Model):
    """Lambert; the sampler says that it leaves out up to a half, and not that this half never turns."""

    claims = Claims(unreached=at_most(0.5))
    rho: Color = param((0.5, 0.5, 0.5), 0, 1, "colour")

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """Lambert's."""
        return self.rho * INV_PI

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Cosine-weighted, folded onto the side of +x."""
        wi = sample_cosine(u)
        wi = vec3(absolute(wi.x), wi.y, wi.z)
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample`."""
        return select(wi.x > 0, 2.0 * pdf_cosine(wi), 0.0)
