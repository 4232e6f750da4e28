"""Broken on purpose: FON with its albedo as printed, which is 0 / 0 at mu = 0."""

from gonio.lang import INV_PI, Color, Vec3, safe_acos, safe_sqrt
from gonio.models.eon import C1
from gonio.models.fon import FON


class NanAtHorizon(FON, register=False):
    """FON with a division by the cosine."""

    def albedo(self, wo: Vec3) -> Color:
        """rho (A_F + B_F G_F / pi), with tan(theta)."""
        mu = wo.z
        s = safe_sqrt(1 - mu * mu)
        G = s * (safe_acos(mu) - s * mu) + 2 / 3 * (s / mu * (1 - s * s * s) - s)
        return self.rho * ((1 + self.roughness * INV_PI * G) / (1 + C1 * self.roughness))
