"""Retroreflective: any model with its light turned by half a turn, so that highlights go back to the light.

Source: Belcour, Pacanowski, Delahaie, Laville-Geay, Eupherte, "Bidirectional reflectance distribution
function measurements and analysis of retroreflective materials", Journal of the Optical Society of America
A 31(12), 2014: the back vector, which lies between wo and wi mirrored at the normal, takes the place of the
half vector.
"""

from gonio.claims import Claims, at_most
from gonio.lang import Color, Float, Sample, Vec2, Vec3, vec3
from gonio.model import Model, child


class Retroreflective(Model):
    """Road signs and safety tape: bright where the light comes from. Reciprocal if the base is."""

    base: Model = child("torrance_sparrow", "whose mirror direction becomes that of the light")
    caveats = (
        "Has no highlight in the mirror direction; add one by the model sum.",
        "Over a base that looks different after half a turn, as measured ones may, it is not reciprocal.",
        "What the base claims holds here as well, with the light turned.",
    )
    claims = Claims(numeric_albedo=at_most(0.03))

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """The base's value for light from the other side."""
        return self.base.eval_above(self._turned(wi), wo)

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """As the base, turned."""
        wi = self._turned(self.base.sample(wo, u).wi)
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample` in 1/sr."""
        return self.base.pdf(self._turned(wi), wo)

    def albedo(self, wo: Vec3) -> Color:
        """That of the base: a turn about the normal changes no cosine."""
        return self.base.albedo(wo)

    def _turned(self, w: Vec3) -> Vec3:
        """By half a turn about the normal."""
        return vec3(-w.x, -w.y, w.z)
