"""Sound, though unusual: a mixture of two models, whose departures it has in part."""

from gonio.albedos.quadrature import NumericAlbedo
from gonio.claims import Claims
from gonio.lang import Color, Float, Sample, Vec2, Vec3, clamp, lerp, select, vec2
from gonio.model import Model, child, param


class TwoChildren(Model):
    """Patches of two materials, too small to be seen."""

    first: Model = child("qon", "one of them")
    second: Model = child("torrance_sparrow", "the other one")
    cover: Float = param(0.3, 0.05, 0.95, "part of the second")
    numeric = NumericAlbedo("half_vectors", stretched=True)
    claims = Claims()

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """The mean."""
        return lerp(self.first.eval(wi, wo), self.second.eval(wi, wo), self.cover)

    def slope_widths(self) -> Vec2:
        """Those of the highlight."""
        return self.second.slope_widths()

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """One of the two by their parts."""
        on_second = u.x < self.cover
        x = select(on_second, u.x / self.cover, (u.x - self.cover) / (1 - self.cover))
        v = vec2(clamp(x, 0, 1 - 5.960464477539063e-08), u.y)
        wi = select(on_second, self.second.sample(wo, v).wi, self.first.sample(wo, v).wi)
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """The mean of both densities."""
        return lerp(self.first.pdf(wi, wo), self.second.pdf(wi, wo), self.cover)
