"""Broken on purpose: tan^2 of the half vector as 1 / z^2 - 1, which loses a sharp lobe in float32."""

from gonio.albedos.quadrature import NumericAlbedo
from gonio.lang import INV_PI, Color, Float, Sample, Vec2, Vec3
from gonio.model import Model, param
from gonio.parts.distribution import ALPHA_MIN, RoundGGX
from gonio.parts.frame import half_vector
from gonio.parts.lobes import pdf_ggx_lobe, sample_ggx_lobe
from gonio.parts.masking import V_smith_correlated


class CancellingHalfVector(Model):
    """White facets."""

    alpha: Float = param(0.3, ALPHA_MIN, 1, "slope width")
    numeric = NumericAlbedo("half_vectors")

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """D G / (4 mu_i mu_o)."""
        z = half_vector(wi, wo).z
        a2 = self.alpha * self.alpha
        s = z * z * (a2 - 1) + 1
        V = V_smith_correlated(RoundGGX(self.alpha), wi, wo)
        return 1.0 * (INV_PI * a2 / (s * s)) * V

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Visible normals."""
        wi = sample_ggx_lobe(RoundGGX(self.alpha), wo, u)
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample`."""
        return pdf_ggx_lobe(RoundGGX(self.alpha), wi, wo)
