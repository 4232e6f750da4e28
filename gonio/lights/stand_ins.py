"""Pictures and tables by formulas: a host for tests of shaders, the same in Python and every language."""

from gonio.lang import Color, Float, Vec2, Vec3, sqrt, vec2, vec3
from gonio.lights.lookups import Lookups


def environment(direction: Vec3, alpha: Float) -> Color:
    """A sky that has another colour on every side, and less contrast the more it is blurred."""
    contrast = 1 - 0.5 * alpha
    x, y, z = direction.x * contrast, direction.y * contrast, direction.z * contrast
    return vec3(
        0.9 + 0.5 * x + 0.2 * y * z, 0.8 + 0.6 * y - 0.1 * x * z, 0.7 - 0.4 * z + 0.2 * x * y
    )


def split_sum(mu: Float, alpha: Float) -> Vec2:
    """About as GGX's."""
    root = sqrt(1 + 8 * alpha * mu * mu)
    return vec2((0.2 + 0.8 * mu) / root, 0.3 * (1 - mu) / (1 + 2 * alpha))


class StandIn(Lookups):
    """The formulas as a host."""

    def environment(self, direction: Vec3, alpha: Float) -> Color:
        """As the function."""
        return environment(direction, alpha)

    def split_sum(self, mu: Float, alpha: Float) -> Vec2:
        """As the function."""
        return split_sum(mu, alpha)
