"""Broken on purpose: a sampler that turns its lobe by -phi_o, which is right in the plane of x alone."""

from gonio.lang import Color, Float, Sample, Vec2, Vec3, vec3
from gonio.model import Model, param
from gonio.parts.distribution import ALPHA_MIN, D_ggx
from gonio.parts.frame import half_vector
from gonio.parts.lobes import pdf_ggx_lobe, sample_ggx_lobe
from gonio.parts.masking import V_smith_correlated_ggx


class TurnedSampler(Model):
    """White facets."""

    alpha: Float = param(0.3, ALPHA_MIN, 1, "slope width")
    albedo_rule = "half_vectors"

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """D G / (4 mu_i mu_o)."""
        V = V_smith_correlated_ggx(wi, wo, self.alpha, self.alpha)
        return 1.0 * D_ggx(half_vector(wi, wo), self.alpha, self.alpha) * V

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Visible normals of a viewer on the other side of x."""
        w = sample_ggx_lobe(vec3(wo.x, -wo.y, wo.z), self.alpha, self.alpha, u)
        return Sample(w, self.pdf(w, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of the sampler that was meant."""
        return pdf_ggx_lobe(wi, wo, self.alpha, self.alpha)
