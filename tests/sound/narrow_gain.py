"""Sound: gains energy in a hundredth of a parameter's range only, and says how much."""

from gonio.claims import Claims, at_most
from gonio.lang import Color, Float, Vec3, exp
from gonio.model import param
from gonio.models.lambert import Lambert

PLACE, WIDTH, GAIN = 0.387, 0.005, 0.8


class NarrowGain(Lambert, register=False):
    """Lambert, brighter where a parameter is near PLACE."""

    where: Float = param(0.5, 0, 1, "Where it is; it gains near PLACE.")

    claims = Claims(energy=at_most(1 + GAIN))

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """Lambert's times 1 + GAIN at PLACE."""
        x = (self.where - PLACE) / WIDTH
        return Lambert.eval(self, wi, wo) * (1 + GAIN * exp(-x * x))

    def albedo(self, wo: Vec3) -> Color:
        """As much brighter."""
        x = (self.where - PLACE) / WIDTH
        return Lambert.albedo(self, wo) * (1 + GAIN * exp(-x * x))

    def mean_albedo(self) -> Color:
        """As `albedo`, which is the same everywhere."""
        x = (self.where - PLACE) / WIDTH
        return self.rho * (1 + GAIN * exp(-x * x))
