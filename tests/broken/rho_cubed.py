"""Broken on purpose: EON whose second lobe is multiplied by the colour once more, rho^3 for rho^2."""

from gonio.lang import Color, Vec3
from gonio.models.eon import EON
from gonio.models.fon import FON


class RhoCubed(EON, register=False):
    """EON, too dark unless it is white."""

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """The compensation times rho."""
        single = FON.eval(self, wi, wo)
        return single + (EON.eval(self, wi, wo) - single) * self.rho
