"""Broken on purpose: a sampler that turns its lobe by -phi_o, which is right in the plane of x alone."""

from gonio.albedos.quadrature import NumericAlbedo
from gonio.lang import Color, Float, Sample, Vec2, Vec3, vec3
from gonio.model import Model, param
from gonio.parts.distribution import ALPHA_MIN, RoundGGX
from gonio.parts.frame import half_vector
from gonio.parts.lobes import pdf_ggx_lobe, sample_ggx_lobe
from gonio.parts.masking import V_smith_correlated


class TurnedSampler(Model):
    """White facets."""

    alpha: Float = param(0.3, ALPHA_MIN, 1, "slope width")
    numeric = NumericAlbedo("half_vectors")

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """D G / (4 mu_i mu_o)."""
        V = V_smith_correlated(RoundGGX(self.alpha), wi, wo)
        return 1.0 * RoundGGX(self.alpha).D(half_vector(wi, wo)) * V

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Visible normals of a viewer on the other side of x."""
        w = sample_ggx_lobe(RoundGGX(self.alpha), vec3(wo.x, -wo.y, wo.z), u)
        return Sample(w, self.pdf(w, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of the sampler that was meant."""
        return pdf_ggx_lobe(RoundGGX(self.alpha), wi, wo)
