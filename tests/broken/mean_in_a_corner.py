"""Broken on purpose: the closed form of the mean albedo is off where a parameter is nearly at its end."""

from gonio.lang import INV_PI, Color, Float, Sample, Vec2, Vec3, maximum
from gonio.model import Model, param
from gonio.parts.hemisphere import pdf_cosine, sample_cosine


class MeanInACorner(Model):
    """Lambert under a veil that is bright towards the normal."""

    rho: Color = param((0.5, 0.5, 0.5), 0, 0.6, "colour")
    veil: Float = param(0.3, 0, 1, "part of the veil")

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """rho / pi (1 - veil + veil 9/4 mu_i mu_o)."""
        return self.rho * ((1 - self.veil + 2.25 * self.veil * wi.z * wo.z) * INV_PI)

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Cosine-weighted."""
        wi = sample_cosine(u)
        return Sample(wi, pdf_cosine(wi))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample`."""
        return pdf_cosine(wi)

    def albedo(self, wo: Vec3) -> Color:
        """The integral of mu_i^2 is 2 pi / 3."""
        return self.rho * (1 - self.veil + 1.5 * self.veil * wo.z)

    def mean_albedo(self) -> Color:
        """Rho, but not for the last twelfth of the veil."""
        return self.rho * (1 + 0.01 * maximum(self.veil - 11 / 12, 0))
