"""Broken on purpose: a density that is 0.5 % too large."""

from gonio.lang import Float, Sample, Vec2, Vec3
from gonio.models.fon import FON


class PdfHalfPercent(FON, register=False):
    """FON with a wrong density."""

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """As FON, but for the density."""
        wi, _ = FON.sample(self, wo, u)
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """1.005 times that of FON."""
        return FON.pdf(self, wi, wo) * 1.005
