"""Broken on purpose: dims the mirror direction by 1 - cos, of which float32 has no digits there."""

from gonio.lang import INV_PI, Color, Float, Sample, Vec2, Vec3, dot, maximum, vec3
from gonio.model import Model, param
from gonio.parts.hemisphere import pdf_cosine, sample_cosine


class DimmedMirror(Model):
    """Lambert without the glare that a camera cannot hold."""

    rho: Color = param((0.5, 0.5, 0.5), 0, 0.9, "colour")

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """rho / pi d / (d + 1e-5), where d is 1 - cos to the mirror direction."""
        d = maximum(1 - dot(wi, vec3(-wo.x, -wo.y, wo.z)), 0)
        return self.rho * (INV_PI * (d / (d + 1e-5)))

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Cosine-weighted."""
        wi = sample_cosine(u)
        return Sample(wi, pdf_cosine(wi))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample`."""
        return pdf_cosine(wi)
