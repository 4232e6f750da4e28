"""Broken on purpose: a divisor of 1e24, whose square derivatives divide by: in float32 that is infinite."""

from gonio.lang import INV_PI, Color, Float, Sample, Vec2, Vec3
from gonio.model import Model, param
from gonio.parts.hemisphere import pdf_cosine, sample_cosine

# As long as a half vector's squares need; a root of their sum has to be taken before it divides.
LONGER = 2.0**40


class SteepDivisor(Model):
    """Lambert, darker where light and viewer are on one side: values have all digits."""

    rho: Color = param((0.5, 0.5, 0.5), 0, 1, "colour")

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """The squared sine of the half vector, of a long one."""
        h = LONGER * (wi + wo)
        tangential2 = h.x * h.x + h.y * h.y
        return self.rho * (INV_PI * (1 - 0.5 * (tangential2 / (tangential2 + h.z * h.z))))

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Cosine-weighted."""
        wi = sample_cosine(u)
        return Sample(wi, pdf_cosine(wi))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample`."""
        return pdf_cosine(wi)
