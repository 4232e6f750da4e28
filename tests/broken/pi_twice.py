"""Broken on purpose: EON whose energy compensation is divided by pi twice."""

from gonio.lang import INV_PI, Color, Vec3
from gonio.models.eon import EON
from gonio.models.fon import FON


class PiTwice(EON, register=False):
    """EON, but for the second lobe."""

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """FON + compensation / pi, in which 1 / pi is already contained."""
        single = FON.eval(self, wi, wo)
        return single + (EON.eval(self, wi, wo) - single) * INV_PI
