"""Broken on purpose: an anisotropic sampler that exchanges the widths along x and y."""

from gonio.albedos.quadrature import NumericAlbedo
from gonio.lang import Color, Float, Sample, Vec2, Vec3, vec2
from gonio.model import Model, param
from gonio.parts.distribution import ALPHA_MIN, GGX
from gonio.parts.frame import half_vector
from gonio.parts.lobes import pdf_ggx_lobe, sample_ggx_lobe
from gonio.parts.masking import V_smith_correlated


class SwappedWidths(Model):
    """White facets, the same along x and y by default."""

    alpha_x: Float = param(0.3, ALPHA_MIN, 1, "slope width along x")
    alpha_y: Float = param(0.3, ALPHA_MIN, 1, "slope width along y")
    numeric = NumericAlbedo("half_vectors", stretched=True)
    isotropic = False

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """D G / (4 mu_i mu_o)."""
        V = V_smith_correlated(GGX(self.alpha_x, self.alpha_y), wi, wo)
        return 1.0 * GGX(self.alpha_x, self.alpha_y).D(half_vector(wi, wo)) * V

    def slope_widths(self) -> Vec2:
        """As the facets'."""
        return vec2(self.alpha_x, self.alpha_y)

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Visible normals, with x for y."""
        wi = sample_ggx_lobe(GGX(self.alpha_y, self.alpha_x), wo, u)
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of the sampler that was meant."""
        return pdf_ggx_lobe(GGX(self.alpha_x, self.alpha_y), wi, wo)
