"""Hapke: light in a half space of grains, as planetary science reads the Moon and asteroids.

Source: Hapke, "Bidirectional reflectance spectroscopy, 1: theory", Journal of Geophysical Research, 1981:
Eq. 16 with the function H of its two-stream solution; the opposition effect in the form of "Bidirectional
reflectance spectroscopy, 4: the extinction coefficient and the opposition effect", Icarus 67, 1986. Grains
scatter by the function of Henyey, Greenstein, "Diffuse radiation in the galaxy", Astrophysical Journal 93,
1941. Macroscopic roughness is not there.
"""

from gonio.claims import Claims, at_most
from gonio.lang import PI, Color, Float, Sample, Vec2, Vec3, dot, length, smooth_sqrt, sqrt
from gonio.model import Model, param
from gonio.parts.hemisphere import pdf_uniform, sample_uniform

INV_FOUR_PI = 0.25 / PI


class Hapke(Model):
    """Regolith: dust that scatters once by its phase function, and often. Reciprocal."""

    rho: Color = param((0.3, 0.3, 0.3), 0, 1, "single-scattering albedo w of a grain, linear RGB")
    asymmetry: Float = param(
        -0.2, -0.8, 0.8, "b of Henyey and Greenstein: below 0 back to the light, above 0 onwards"
    )
    opposition: Float = param(0.8, 0, 1, "strength B0 of the brighter spot around the light")
    opposition_width: Float = param(0.06, 0.02, 1, "width h of that spot; radians, about")
    caveats = (
        "H is Hapke's approximation of 1981, within 4 % of Chandrasekhar's.",
        "Scattering that is not even counts for the first order only, and so does the opposition effect: "
        "white grains gain or lose what it brings.",
    )
    claims = Claims(energy=at_most(1.7), numeric_albedo=at_most(1e-3))

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """Eq. 16 over mu_i: BRDF value in 1/sr, without the cosine."""
        once = (1 + self._opposition(wi, wo)) * self._phase(wi, wo)
        # H_i H_o - 1 without its cancellation
        h_i, h_o = self._H_minus_1(wi.z), self._H_minus_1(wo.z)
        often = h_i + h_o + h_i * h_o
        return self.rho * (once + often) * (INV_FOUR_PI / (wi.z + wo.z))

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Uniform: mu_i / (mu_i + mu_o) has a bound."""
        wi = sample_uniform(u)
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample` in 1/sr."""
        return pdf_uniform()

    def _H_minus_1(self, mu: Float) -> Color:
        """H - 1 of H = (1 + 2 mu) / (1 + 2 mu gamma) with gamma = sqrt(1 - w)."""
        gamma = smooth_sqrt(1 - self.rho)
        return 2 * mu * self.rho / ((1 + gamma) * (1 + 2 * mu * gamma))

    def _phase(self, wi: Vec3, wo: Vec3) -> Float:
        """Henyey and Greenstein's function at the phase angle between light and viewer, mean 1."""
        b = self.asymmetry
        # 1 + 2 b cos(g) + b^2 as a sum of squares
        v = wi + b * wo
        q = dot(v, v)
        return (1 - b) * (1 + b) / (q * sqrt(q))

    def _opposition(self, wi: Vec3, wo: Vec3) -> Float:
        """B0 / (1 + tan(g / 2) / h), with the tangent from the lengths of difference and sum."""
        scaled = self.opposition_width * length(wi + wo)
        return self.opposition * scaled / (scaled + smooth_sqrt(dot(wi - wo, wi - wo)))
