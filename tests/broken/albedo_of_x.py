"""Broken on purpose: FON with an albedo of wo.x for sin(theta), right in the plane of x alone."""

from gonio.lang import INV_PI, Color, Vec3, absolute, safe_acos
from gonio.models.eon import C1
from gonio.models.fon import FON


class AlbedoOfX(FON, register=False):
    """FON with a wrong sine."""

    def albedo(self, wo: Vec3) -> Color:
        """rho (A_F + B_F G_F / pi)."""
        mu = wo.z
        s = absolute(wo.x)
        G = s * (safe_acos(mu) - s * mu) + 2 / 3 * s * (mu * (1 + s + s * s) / (1 + s) - 1)
        return self.rho * ((1 + self.roughness * INV_PI * G) / (1 + C1 * self.roughness))
