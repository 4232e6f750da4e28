"""D from a table, in the language of models: what stands in the place of a distribution's own D.

And the row of F, where a parameter chooses it.

Source: Elek, "Layered materials in real-time rendering", CESCG 2010, section 3.1: one table over the
facet's angle and the width. His angles are stretched by the eighth power, so that sharp highlights do not
fall between two entries. Here the slope is met in units of the width, as q / (1 + q) with q =
(slope / width)^2: every width has the same number of entries in its highlight, rows can be evenly spaced in
the width, and no power or logarithm is left. The table holds the root of pi alpha^2 D, for 8 bits; of GGX
that is a straight line between 1 and alpha^2.
"""

from gonio.lang import (
    INV_PI,
    MU_MIN,
    Float,
    Vec2,
    Vec3,
    clamp,
    fract,
    maximum,
    minimum,
    safe_sqrt,
    vec2,
)
from gonio.lights.lookups import Lookups
from gonio.parts.frame import tangent2

# Stands for the slope of a facet that lies level, where any width along its azimuth will do.
LEVEL = 1e-30


def tilt(m: Vec3) -> Vec2:
    """Squared slope of a facet, as a quotient that has a value in the horizon."""
    return vec2(m.x * m.x + m.y * m.y, m.z * m.z)


def tilt_along(h: Vec3) -> Vec2:
    """The same for a facet whose normal is along h, above the horizon, which need not be unit."""
    return vec2(tangent2(h), 1)


def tabled_D(
    tilted: Vec2, alpha: Float, first: Float, last: Float, scale: Float, host: Lookups
) -> Float:
    """Density of facets of one width, in 1/sr, from the table's rows from `first` on, `last` more."""
    alpha2 = alpha * alpha
    root = host.distribution_table(tilted.x / (tilted.x + alpha2 * tilted.y), first + last * alpha)
    return scale * INV_PI / alpha2 * (root * root)


def tabled_D_anisotropic(
    t: Vec2,
    alpha_x: Float,
    alpha_y: Float,
    first: Float,
    last: Float,
    scale: Float,
    host: Lookups,
) -> Float:
    """Density of facets with two widths and the slopes t: along their azimuth they meet one, up to 1."""
    # Times the squares of both widths no width is a divisor
    x, y, a2 = alpha_y * t.x, alpha_x * t.y, alpha_x * alpha_y
    n, a4 = maximum(x * x + y * y, LEVEL), a2 * a2
    width = safe_sqrt(minimum(a4 * (t.x * t.x + t.y * t.y) / n, 1))
    root = host.distribution_table(n / (n + a4), first + last * width)
    return scale * INV_PI / a2 * (root * root)


def nearest_row(row: Float, last: Float) -> Float:
    """The whole number nearest to a row: the middle of a texel, where a filter mixes nothing in."""
    up = clamp(row, 0, last) + 0.5
    return up - fract(up)


def facet_slopes(m: Vec3) -> Vec2:
    """Of a unit normal, which may be in the horizon."""
    inv = 1 / maximum(m.z, MU_MIN)
    return vec2(m.x * inv, m.y * inv)
