"""Broken on purpose: FON with an interreflection that knows of the viewer's angle alone."""

from gonio.claims import Claims, Place, kink
from gonio.lang import INV_PI, Color, Vec3
from gonio.model import Model
from gonio.models.fon import FON


class NonReciprocal(FON, register=False):
    """Reflects no more than EON, but not the same both ways."""

    claims = Claims(kinks=(kink(Place.SIDE_LIGHT), kink(Place.EQUAL_COSINES)))

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """What FON loses towards the viewer, spread evenly and coloured twice."""
        lost = self.rho - FON.albedo(self, wo)
        return FON.eval(self, wi, wo) + self.rho * lost * INV_PI * 0.9

    def albedo(self, wo: Vec3) -> Color:
        """By quadrature."""
        return Model.albedo(self, wo)

    def mean_albedo(self) -> Color:
        """By quadrature."""
        return Model.mean_albedo(self)
