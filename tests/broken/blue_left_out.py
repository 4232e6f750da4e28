"""Broken on purpose: blue alone decides which lobe is drawn; without blue the matte one never is."""

from gonio.lang import (
    INV_PI,
    INV_TWO_PI,
    TWO_PI,
    Color,
    Float,
    Sample,
    Vec2,
    Vec3,
    cos,
    maximum,
    safe_sqrt,
    select,
    sin,
    vec3,
)
from gonio.model import Model, param
from gonio.parts.hemisphere import pdf_cosine, sample_cosine
from gonio.parts.lobes import choose

# The cosine at which the bright patch around the normal ends.
RIM = 0.5


class BlueLeftOut(Model):
    """Lambert, and a patch around the normal that is brighter."""

    rho: Color = param((0.5, 0.4, 0.3), 0, 0.6, "colour")
    patch: Color = param((0.1, 0.1, 0.2), 0.05, 0.3, "around the normal")

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """Both; the patch ends smoothly."""
        inside = maximum(wi.z - RIM, 0) * maximum(wo.z - RIM, 0)
        return (self.rho + self.patch * (inside * inside)) * INV_PI

    def _matte(self) -> Float:
        return self.rho.z / (self.rho.z + self.patch.z)

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Cosine-weighted, or evenly over the patch."""
        matte, v = choose(self._matte(), u)
        z = 1 - (1 - RIM) * v.x
        r = safe_sqrt((1 - z) * (1 + z))
        cap = vec3(r * cos(TWO_PI * v.y), r * sin(TWO_PI * v.y), z)
        wi = select(matte, sample_cosine(v), cap)
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Of both."""
        share = self._matte()
        even = select(wi.z > RIM, INV_TWO_PI / (1 - RIM), 0)
        return share * pdf_cosine(wi) + (1 - share) * even
