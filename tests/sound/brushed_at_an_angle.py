"""Sound, though unusual: anisotropic GGX whose axes an angle turns; keeps its digits in the horizon."""

from typing import NamedTuple

from gonio.lang import Color, Float, Sample, Vec2, Vec3, cos, sin, vec3
from gonio.model import Model, param
from gonio.parts.distribution import GGX
from gonio.parts.frame import half_vector
from gonio.parts.lobes import pdf_ggx_lobe, sample_ggx_lobe
from gonio.parts.masking import V_smith_correlated


class Turned(NamedTuple):
    """Facets whose axes are turned; two directions are added before, never after."""

    facets: GGX
    cos: Float
    sin: Float

    def inside(self, w: Vec3) -> Vec3:
        """In the frame of the facets."""
        return vec3(self.cos * w.x + self.sin * w.y, self.cos * w.y - self.sin * w.x, w.z)

    def outside(self, w: Vec3) -> Vec3:
        """The inverse."""
        return vec3(self.cos * w.x - self.sin * w.y, self.cos * w.y + self.sin * w.x, w.z)

    def D(self, m: Vec3) -> Float:
        """Density of facets."""
        return self.facets.D(self.inside(m))

    def area(self, w: Vec3) -> Float:
        """Projected area, as GGX has it."""
        return self.facets.area(self.inside(w))


class BrushedAtAnAngle(Model):
    """Metal whose brushing runs in any direction."""

    f0: Color = param((0.9, 0.7, 0.4), 0, 1, "reflectance")
    alpha_x: Float = param(0.3, 0.02, 1, "slope width along the brushing")
    alpha_y: Float = param(0.1, 0.02, 1, "slope width across")
    angle: Float = param(0, 0, 3.14159, "of the brushing, radians")
    isotropic = False

    def _facets(self) -> Turned:
        return Turned(GGX(self.alpha_x, self.alpha_y), cos(self.angle), sin(self.angle))

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """D G / (4 mu_i mu_o)."""
        facets = self._facets()
        return self.f0 * (facets.D(half_vector(wi, wo)) * V_smith_correlated(facets, wi, wo))

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Visible normals."""
        facets = self._facets()
        wi = facets.outside(sample_ggx_lobe(facets.facets, facets.inside(wo), u))
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample`."""
        return pdf_ggx_lobe(self._facets(), wi, wo)
