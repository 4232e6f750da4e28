"""Sound, though unusual: white anisotropic GGX with a width for each axis, as sharp as it gets."""

from gonio.lang import Color, Float, Sample, Vec2, Vec3
from gonio.model import Model, param
from gonio.parts.distribution import ALPHA_MIN, GGX
from gonio.parts.frame import half_vector
from gonio.parts.lobes import pdf_ggx_lobe, sample_ggx_lobe
from gonio.parts.masking import V_smith_correlated


class ExactAnisotropicGgx(Model):
    """White facets; says neither how wide it is nor which rule would integrate it best."""

    f0: Color = param((1, 1, 1), 0, 1, "reflectance")
    alpha_x: Float = param(0.3, ALPHA_MIN, 1, "slope width along x")
    alpha_y: Float = param(0.1, ALPHA_MIN, 1, "slope width along y")
    isotropic = False

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """D G / (4 mu_i mu_o)."""
        V = V_smith_correlated(GGX(self.alpha_x, self.alpha_y), wi, wo)
        return self.f0 * GGX(self.alpha_x, self.alpha_y).D(half_vector(wi, wo)) * V

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Visible normals."""
        wi = sample_ggx_lobe(GGX(self.alpha_x, self.alpha_y), wo, u)
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample`."""
        return pdf_ggx_lobe(GGX(self.alpha_x, self.alpha_y), wi, wo)
