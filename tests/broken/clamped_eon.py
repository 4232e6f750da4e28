"""Broken on purpose: EON that clamps dot(wi, wo) at 0, as a well-known GLSL port does."""

from gonio.lang import INV_PI, Color, Vec3, dot, maximum, select
from gonio.models.eon import C1, EON


class ClampedEon(EON, register=False):
    """EON, too bright where light and viewer are more than a right angle apart."""

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """s is computed from the clamped dot product."""
        true = dot(wi, wo) - wi.z * wo.z
        clamped = maximum(dot(wi, wo), 0) - wi.z * wo.z
        t = select(true > 0, maximum(wi.z, wo.z), 1)
        A_F = 1 / (1 + C1 * self.roughness)
        change = INV_PI * A_F * self.roughness * (clamped - true) / t
        return EON.eval(self, wi, wo) + self.rho * change
