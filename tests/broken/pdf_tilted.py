"""Broken on purpose: a density 0.5 % too large on one side and too small on the other; its sum is right."""

from gonio.lang import Float, Sample, Vec2, Vec3, select
from gonio.models.lambert import Lambert


class PdfTilted(Lambert, register=False):
    """Lambert with a wrong density that integrates to one."""

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """As Lambert, but for the density."""
        wi, _ = Lambert.sample(self, wo, u)
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Half a percent up on one side, down on the other."""
        return Lambert.pdf(self, wi, wo) * select(wi.x > 0, 1.005, 0.995)
