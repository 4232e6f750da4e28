"""D from a table, in the language of models: what stands in the place of a distribution's own D.

Source: Elek, "Layered materials in real-time rendering", CESCG 2010, section 3.1: one table over the
facet's angle and the width. His angles are stretched by the eighth power, so that sharp highlights do not
fall between two entries. Here the sine is met in units of the width, as q / (1 + q) with
q = (sine / width)^2: every width has the same number of entries in its highlight, rows can be evenly spaced
in the width, and no power or logarithm is left. The table holds the root of pi alpha^2 D, for 8 bits.
"""

from gonio.lang import INV_PI, Float, Vec3, dot, length, maximum, minimum, safe_sqrt
from gonio.lights.lookups import Lookups

# Stands for the squared sine of a facet that lies level, where any width along its azimuth will do.
SIN2_MIN = 1e-30


def facet_sin2(m: Vec3) -> Float:
    """Squared sine of a facet's angle."""
    return m.x * m.x + m.y * m.y


def sin2_along(h: Vec3) -> Float:
    """Squared sine of the facet whose normal is along h, without making it unit."""
    return (h.x * h.x + h.y * h.y) / dot(h, h)


def unit(h: Vec3) -> Vec3:
    """The normal along h."""
    return h / length(h)


def tabled_D(
    sin2: Float, alpha: Float, first: Float, last: Float, scale: Float, host: Lookups
) -> Float:
    """Density of facets of one width, in 1/sr, from the table's rows from `first` on, `last` more."""
    alpha2 = alpha * alpha
    root = host.distribution_table(sin2 / (sin2 + alpha2), first + last * alpha)
    return scale * INV_PI / alpha2 * (root * root)


def tabled_D_anisotropic(
    m: Vec3,
    alpha_x: Float,
    alpha_y: Float,
    first: Float,
    last: Float,
    scale: Float,
    host: Lookups,
) -> Float:
    """Density of facets of two widths, in 1/sr: along its azimuth the facet meets one, up to 1."""
    x, y = m.x / alpha_x, m.y / alpha_y
    q = maximum(x * x + y * y, SIN2_MIN)
    alpha2 = (m.x * m.x + m.y * m.y) / q
    width = safe_sqrt(minimum(alpha2, 1))
    root = host.distribution_table(q / (1 + q), first + last * width)
    return scale * INV_PI / (alpha_x * alpha_y) * (root * root)
