"""Broken on purpose: a density that squares the width for the roughest fifth of its range."""

from gonio.albedos.quadrature import NumericAlbedo
from gonio.lang import Color, Float, Sample, Vec2, Vec3, select
from gonio.model import Model, param
from gonio.parts.distribution import ALPHA_MIN, RoundGGX
from gonio.parts.frame import half_vector
from gonio.parts.lobes import pdf_ggx_lobe, sample_ggx_lobe
from gonio.parts.masking import V_smith_correlated


class WidthInAPart(Model):
    """Coloured facets."""

    f0: Color = param((0.9, 0.7, 0.4), 0, 1, "reflectance")
    alpha: Float = param(0.3, ALPHA_MIN, 1, "slope width")
    numeric = NumericAlbedo("half_vectors")

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """F D G / (4 mu_i mu_o)."""
        facets = RoundGGX(self.alpha)
        return self.f0 * (facets.D(half_vector(wi, wo)) * V_smith_correlated(facets, wi, wo))

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Visible normals."""
        wi = sample_ggx_lobe(RoundGGX(self.alpha), wo, u)
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of narrower facets where alpha is above 0.8."""
        alpha = select(self.alpha > 0.8, self.alpha * self.alpha, self.alpha)
        return pdf_ggx_lobe(RoundGGX(alpha), wi, wo)
