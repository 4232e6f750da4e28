"""Sound, though unusual: a lobe around the viewer, the mirror image of GGX's."""

from gonio.lang import Color, Float, Sample, Vec2, Vec3, vec3
from gonio.model import Model, param
from gonio.parts.distribution import D_ggx
from gonio.parts.frame import half_vector
from gonio.parts.lobes import pdf_ggx_lobe, sample_ggx_lobe
from gonio.parts.masking import V_smith_correlated_ggx


def back(w: Vec3) -> Vec3:
    """A direction turned by half a turn about the normal."""
    return vec3(-w.x, -w.y, w.z)


class Retroreflector(Model):
    """Sends light back where it came from, as traffic signs do."""

    tint: Color = param((0.9, 0.9, 0.9), 0, 1, "colour")
    alpha: Float = param(0.1, 0.001, 1, "width")

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """GGX with wi turned."""
        w = back(wi)
        V = V_smith_correlated_ggx(w, wo, self.alpha, self.alpha)
        return self.tint * D_ggx(half_vector(w, wo), self.alpha, self.alpha) * V

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Visible normals, turned."""
        wi = back(sample_ggx_lobe(wo, self.alpha, self.alpha, u))
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample`."""
        return pdf_ggx_lobe(back(wi), wo, self.alpha, self.alpha)
