"""Broken on purpose: GGX facets whose D lacks its 1 / pi, as a well-known text prints it."""

from gonio.albedos.quadrature import NumericAlbedo
from gonio.lang import PI, Color, Float, Sample, Vec2, Vec3
from gonio.model import Model, param
from gonio.parts.distribution import ALPHA_MIN, RoundGGX
from gonio.parts.frame import half_vector
from gonio.parts.lobes import pdf_ggx_lobe, sample_ggx_lobe
from gonio.parts.masking import V_smith_correlated


class UnnormalisedD(Model):
    """White facets, pi times too many."""

    alpha: Float = param(0.3, ALPHA_MIN, 1, "slope width")
    numeric = NumericAlbedo("half_vectors")

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """pi D G / (4 mu_i mu_o)."""
        V = V_smith_correlated(RoundGGX(self.alpha), wi, wo)
        return PI * RoundGGX(self.alpha).D(half_vector(wi, wo)) * V

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Visible normals."""
        wi = sample_ggx_lobe(RoundGGX(self.alpha), wo, u)
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample`."""
        return pdf_ggx_lobe(RoundGGX(self.alpha), wi, wo)
