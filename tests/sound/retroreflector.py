"""Sound, though unusual: a lobe around the viewer, the mirror image of GGX's."""

from gonio.lang import Color, Float, Sample, Vec2, Vec3, vec3
from gonio.model import Model, param
from gonio.parts.distribution import RoundGGX
from gonio.parts.frame import half_vector
from gonio.parts.lobes import pdf_ggx_lobe, sample_ggx_lobe
from gonio.parts.masking import V_smith_correlated


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
        V = V_smith_correlated(RoundGGX(self.alpha), w, wo)
        return self.tint * RoundGGX(self.alpha).D(half_vector(w, wo)) * V

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Visible normals, turned."""
        wi = back(sample_ggx_lobe(RoundGGX(self.alpha), wo, u))
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample`."""
        return pdf_ggx_lobe(RoundGGX(self.alpha), back(wi), wo)
