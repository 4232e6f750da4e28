"""Broken on purpose: a tangent that leaves the range of float32 at the horizon of the half vector."""

from gonio.lang import INV_PI, Color, Float, Sample, Vec2, Vec3, minimum
from gonio.model import Model, param
from gonio.parts.hemisphere import pdf_cosine, sample_cosine


class OverflowNearNormal(Model):
    """Lambert with a veil of dust."""

    rho: Color = param((0.5, 0.5, 0.5), 0, 0.9, "colour")

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """1 / mu^3 is no float32 below 1e-13."""
        mu = minimum(wi.z, wo.z)
        inv = 1 / mu
        veil = inv * inv * inv
        return self.rho * (INV_PI * (veil / (1 + veil)))

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Cosine-weighted."""
        wi = sample_cosine(u)
        return Sample(wi, pdf_cosine(wi))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample`."""
        return pdf_cosine(wi)
