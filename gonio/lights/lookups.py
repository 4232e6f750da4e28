"""What a host looks up: the only functions of shaders that are not written in the language.

A light takes them as its last argument, `host`. In Python that is an object such as
`gonio.bake.prefiltered.Prefiltered`; the exporter writes them with textures, or leaves them to the host.
Tables of F and D stand in the place of functions of the model (`gonio.export.tabled`).
"""

from gonio.lang import Color, Float, Vec2, Vec3

# Levels of a prefiltered environment: level k is blurred by alpha = (k / LAST_LEVEL)^2.
LAST_LEVEL = 5


class Lookups:
    """What lights ask of their host."""

    def environment(self, direction: Vec3, alpha: Float) -> Color:
        """Radiance from a direction of the world, blurred by a GGX lobe of this width, linear RGB."""
        raise NotImplementedError

    def split_sum(self, mu: Float, alpha: Float) -> Vec2:
        """A and B of the highlight's table, at the viewer's cosine mu: its albedo is f0 A + f90 B."""
        raise NotImplementedError

    def fresnel_table(self, cos_theta: Float, row: Float) -> Color:
        """F, or 1 - F, of the row's material at a cosine, from the table."""
        raise NotImplementedError

    def distribution_table(self, u: Float, row: Float) -> Float:
        """Root of D over its peak, from the table: u is q / (1 + q) with q = (slope / width)^2."""
        raise NotImplementedError
