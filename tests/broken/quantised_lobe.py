"""Broken on purpose: in float32 a narrow lobe's samples lie on a few rings, because of an arc cosine."""

from gonio.claims import Claims, at_most
from gonio.lang import (
    TWO_PI,
    Color,
    Float,
    Sample,
    Vec2,
    Vec3,
    cos,
    safe_acos,
    safe_sqrt,
    sin,
    vec3,
)
from gonio.model import Model, param
from gonio.parts.distribution import RoundGGX
from gonio.parts.frame import half_length, half_vector, mirror, pdf_mirror
from gonio.parts.masking import V_smith_correlated


class QuantisedLobe(Model):
    """Silver whose facets are sampled without regard for what wo sees."""

    alpha: Float = param(0.2, 0.001, 1, "slope width")
    claims = Claims(wasted=at_most(0.5))

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """D V."""
        facets = RoundGGX(self.alpha)
        return vec3(0.95, 0.93, 0.88) * (
            facets.D(half_vector(wi, wo)) * V_smith_correlated(facets, wi, wo)
        )

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """The cosine is right to 6e-8, and so the angle to 3e-4 only, near the normal."""
        t2 = self.alpha * self.alpha * u.x / (1 - u.x)
        theta = safe_acos(safe_sqrt(1 / (1 + t2)))
        m = vec3(sin(theta) * cos(TWO_PI * u.y), sin(theta) * sin(TWO_PI * u.y), cos(theta))
        wi = mirror(wo, m)
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """D cos(theta) / (4 wo.m)."""
        m = half_vector(wi, wo)
        return pdf_mirror(RoundGGX(self.alpha).density(m), half_length(wi, wo))
