"""Broken on purpose: a sampled direction with an infinite derivative at u.x = 0, of constant density."""

from gonio.lang import (
    INV_TWO_PI,
    TWO_PI,
    Color,
    Float,
    Sample,
    Vec2,
    Vec3,
    cos,
    maximum,
    sin,
    sqrt,
    vec3,
)
from gonio.model import Model, param
from gonio.parts.hemisphere import pdf_uniform


class SteepSampler(Model):
    """Lommel-Seeliger with the textbook's uniform hemisphere."""

    rho: Color = param((0.5, 0.5, 0.5), 0, 1, "single-scattering albedo")

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """As it should be."""
        return self.rho * (0.5 * INV_TWO_PI / (wi.z + wo.z))

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """The root of 0 where the direction is the normal."""
        z, phi = 1 - u.x, TWO_PI * u.y
        r = sqrt(maximum(1 - z * z, 0))
        wi = vec3(r * cos(phi), r * sin(phi), z)
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample`."""
        return pdf_uniform()
