"""Broken on purpose: not reciprocal, but in the plane of incidence."""

from gonio.lang import INV_PI, Color, Float, Sample, Vec2, Vec3
from gonio.model import Model, param
from gonio.parts.hemisphere import pdf_cosine, sample_cosine


class Twisted(Model):
    """Lambert with a twist: it turns with the pair of directions, and is isotropic."""

    rho: Color = param((0.5, 0.5, 0.5), 0, 0.9, "colour")

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """The sine of the azimuth between the two changes its sign when they are exchanged."""
        twist = wi.x * wo.y - wi.y * wo.x
        return self.rho * (INV_PI * (1 + 0.1 * twist * wi.z * wo.z))

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Cosine-weighted."""
        wi = sample_cosine(u)
        return Sample(wi, pdf_cosine(wi))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample`."""
        return pdf_cosine(wi)
