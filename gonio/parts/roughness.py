"""Parameters of highlights that are to be at least as wide as facets of a given alpha.

What a rough layer does to the base below it, for each scale on which models give the width of a highlight:
`param(..., rougher=at_least_alpha)` says which scale a parameter has. The conversions are those of
gonio.parts.distribution; a Phong lobe is as wide as a Blinn-Phong lobe with four times its exponent.
"""

from gonio.lang import Float, maximum, minimum, sqrt
from gonio.parts.distribution import blinn_phong_exponent


def at_least_alpha(own: Float, alpha: Float) -> Float:
    """For slope widths: GGX's alpha, Beckmann's m."""
    return maximum(own, alpha)


def at_least_perceptual(own: Float, alpha: Float) -> Float:
    """For perceptual roughness, whose square is alpha."""
    return maximum(own, sqrt(alpha))


def at_most_blinn_phong(own: Float, alpha: Float) -> Float:
    """For exponents of Blinn-Phong."""
    return minimum(own, blinn_phong_exponent(alpha))


def at_most_phong(own: Float, alpha: Float) -> Float:
    """For exponents of Phong."""
    return minimum(own, 0.25 * blinn_phong_exponent(alpha))
