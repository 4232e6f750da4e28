"""Broken on purpose: lobes chosen by the mean of the channels, with a density that favours red a little."""

from gonio.lang import INV_PI, Color, Float, Sample, Vec2, Vec3, dot, select, vec3
from gonio.model import Model, param
from gonio.parts.distribution import RoundGGX
from gonio.parts.frame import half_vector
from gonio.parts.hemisphere import pdf_cosine, sample_cosine
from gonio.parts.lobes import average, choose, pdf_ggx_lobe, sample_ggx_lobe, shares
from gonio.parts.masking import V_smith_correlated


class TintedMixture(Model):
    """Coloured varnish over a grey ground; all is well as long as the varnish is grey as well."""

    ground: Float = param(0.4, 0, 0.5, "albedo of what is below")
    tint: Color = param((0.3, 0.3, 0.3), 0, 0.5, "reflectance of the varnish")
    alpha: Float = param(0.25, 0.03, 1, "width of its highlight")

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """Lambert and a highlight."""
        facets = RoundGGX(self.alpha)
        highlight = facets.D(half_vector(wi, wo)) * V_smith_correlated(facets, wi, wo)
        return self.ground * INV_PI + self.tint * highlight

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """One of the two, by their mean reflectances."""
        on_ground, v = choose(shares(self.ground, average(self.tint)).x, u)
        varnish = sample_ggx_lobe(RoundGGX(self.alpha), wo, v)
        wi = select(on_ground, sample_cosine(v), varnish)
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """By other weights of the channels."""
        P = shares(self.ground, dot(self.tint, vec3(0.35, 0.33, 0.32)))
        return P.x * pdf_cosine(wi) + P.y * pdf_ggx_lobe(RoundGGX(self.alpha), wi, wo)
