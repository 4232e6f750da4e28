"""Sum: the light of two models on one surface, each with a weight; nested, of any number of them.

f = w1 f1 + w2 f2. Measured materials are often fitted with such sums: Lambert and one or more lobes.
Sources: Ngan, Durand, Matusik, "Experimental analysis of BRDF models", EGSR 2005, section 3; Lafortune,
Foo, Torrance, Greenberg, "Non-linear approximation of reflectance functions", SIGGRAPH 1997, Eq. 8.
"""

from gonio.claims import Claims, at_most
from gonio.lang import Color, Float, Sample, Vec2, Vec3, select
from gonio.model import Model, child, param
from gonio.parts.lobes import average, choose, shares


class Sum(Model):
    """Two models added, such as a diffuse one and a highlight. Reciprocal if both are."""

    first: Model = child("lambert", "one of the two, such as what is diffuse")
    second: Model = child("torrance_sparrow", "the other one, such as a highlight, or another sum")
    first_weight: Color = param((0.5, 0.5, 0.5), 0, 1, "what the first one is multiplied by")
    second_weight: Color = param((0.5, 0.5, 0.5), 0, 1, "what the second one is multiplied by")
    caveats = (
        "Nothing is taken from one for what the other reflects: weights that add up to more than 1 may "
        "reflect more than they receive, up to the sum of the models' own albedos.",
        "A rough coat does not widen what is in a sum below it.",
    )
    unlike = (
        ("weidlich_wilkie", "lays a coat over a model and takes from it what the coat reflects."),
    )
    claims = Claims(
        energy=at_most(2),
        numeric_albedo=at_most(0.01),
    )

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """BRDF value in 1/sr, without the cosine."""
        first = self.first_weight * self.first.eval_above(wi, wo)
        return first + self.second_weight * self.second.eval_above(wi, wo)

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """One of the two, in proportion to their weights."""
        on_first, v = choose(self._shares().x, u)
        w_first, w_second = self.first.sample(wo, v).wi, self.second.sample(wo, v).wi
        wi = select(on_first, w_first, w_second)
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample` in 1/sr."""
        P = self._shares()
        return P.x * self.first.pdf(wi, wo) + P.y * self.second.pdf(wi, wo)

    def albedo(self, wo: Vec3) -> Color:
        """Directional albedo: that of each, with its weight."""
        return self.first_weight * self.first.albedo(wo) + (
            self.second_weight * self.second.albedo(wo)
        )

    def _shares(self) -> Vec2:
        """Probabilities of the two."""
        return shares(average(self.first_weight), average(self.second_weight))
