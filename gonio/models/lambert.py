"""Lambert: ideal diffuse reflection.

Source: Johann Heinrich Lambert, "Photometria", 1760.
"""

from gonio.claims import Claims, white_furnace
from gonio.lang import INV_PI, Color, Float, Sample, Vec2, Vec3
from gonio.model import Model, param
from gonio.parts.hemisphere import pdf_cosine, sample_cosine


class Lambert(Model):
    """Ideal diffuse: the same radiance in every direction. Reciprocal; the albedo is rho."""

    rho: Color = param((0.8, 0.8, 0.8), 0, 1, "albedo, linear RGB")
    claims = Claims(furnace=white_furnace(within=1e-6, rho=1))

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """rho / pi."""
        return self.rho * INV_PI

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Cosine-weighted, which is exact here."""
        wi = sample_cosine(u)
        return Sample(wi, pdf_cosine(wi))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """cos(theta_i) / pi."""
        return pdf_cosine(wi)

    def albedo(self, wo: Vec3) -> Color:
        """rho."""
        return self.rho

    def mean_albedo(self) -> Color:
        """rho."""
        return self.rho
