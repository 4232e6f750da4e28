"""Minnaert: limb darkening of planets as a power of both cosines.

Source: Minnaert, "The reciprocity principle in lunar photometry", Astrophysical Journal 93, 1941,
normalised such that rho is the albedo at the normal. k = 1 is Lambert; the full Moon has about k = 0.5.
"""

from gonio.claims import UNBOUNDED, Claims, at_most
from gonio.lang import (
    INV_TWO_PI,
    MU_MIN,
    TWO_PI,
    Color,
    Float,
    Sample,
    Vec2,
    Vec3,
    cos,
    exp,
    maximum,
    power,
    safe_sqrt,
    sin,
    vec3,
)
from gonio.model import Model, param
from gonio.parts.special import expm1, log1p


class Minnaert(Model):
    """Planets and moons by one exponent: darker limbs above k = 1, brighter ones below. Reciprocal."""

    rho: Color = param((0.8, 0.8, 0.8), 0, 1, "albedo at the normal, linear RGB")
    k: Float = param(0.7, 0, 2, "limb darkening: 1 is Lambert, 0.5 a flat full moon")
    caveats = (
        "Reflects more than it receives for k < 1 at grazing angles, without bound: rho times the cosine "
        "to the power k - 1.",
    )
    claims = Claims(energy=at_most(UNBOUNDED))

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """rho (k + 1) / (2 pi) (mu_i mu_o)^(k - 1): BRDF value in 1/sr, without the cosine."""
        k = self.k
        return self.rho * (INV_TWO_PI * (k + 1) * power(wi.z, k - 1) * power(wo.z, k - 1))

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """A direction with a density like mu_i^k, which leaves a constant weight."""
        t = log1p(-u.x) / (self.k + 1)
        r, phi = safe_sqrt(-expm1(2 * t)), TWO_PI * u.y
        wi = vec3(r * cos(phi), r * sin(phi), exp(t))
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample` in 1/sr."""
        return INV_TWO_PI * (self.k + 1) * power(wi.z, self.k)

    def albedo(self, wo: Vec3) -> Color:
        """rho mu_o^(k - 1)."""
        return self.rho * power(maximum(wo.z, MU_MIN), self.k - 1)

    def mean_albedo(self) -> Color:
        """Hemispherical mean of `albedo`."""
        return self.rho * (2 / (self.k + 1))
