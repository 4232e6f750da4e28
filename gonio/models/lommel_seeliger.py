"""Lommel–Seeliger: single scattering in a half space of dark dust, such as the Moon's.

Source: Seeliger, "Zur Photometrie des Saturnringes", Astronomische Nachrichten 109, 1884, in the form of
Hapke, "Bidirectional reflectance spectroscopy, 1: theory", Journal of Geophysical Research 86, 1981, Eq. 15
without its other orders, for grains that scatter evenly in all directions. The albedos are integrated here.
"""

from gonio.claims import Claims
from gonio.lang import MU_MIN, PI, Color, Float, Sample, Vec2, Vec3, log, maximum
from gonio.model import Model, param
from gonio.parts.hemisphere import pdf_uniform, sample_uniform
from gonio.parts.special import log1p

INV_FOUR_PI = 0.25 / PI

LOG_2 = 0.6931471805599453


class LommelSeeliger(Model):
    """Dark dust that scatters light once; a full moon without dark limbs. Reciprocal."""

    rho: Color = param((0.3, 0.3, 0.3), 0, 1, "single-scattering albedo w of a grain, linear RGB")
    caveats = (
        "Has no light that is scattered more than once, which white grains would have most of: they "
        "reflect 15 % at the normal and 50 % at grazing angles. `hapke` has it.",
    )
    claims = Claims()

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """w / (4 pi (mu_i + mu_o)): BRDF value in 1/sr, without the cosine."""
        return self.rho * (INV_FOUR_PI / (wi.z + wo.z))

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Uniform: the weight, w / 2 mu_i / (mu_i + mu_o), has a bound."""
        wi = sample_uniform(u)
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample` in 1/sr."""
        return pdf_uniform()

    def albedo(self, wo: Vec3) -> Color:
        """w / 2 (1 - mu_o log((1 + mu_o) / mu_o))."""
        mu = wo.z
        return self.rho * (0.5 - 0.5 * mu * (log1p(mu) - log(maximum(mu, MU_MIN))))

    def mean_albedo(self) -> Color:
        """2 / 3 w (1 - log 2)."""
        return self.rho * (2 / 3 * (1 - LOG_2))
