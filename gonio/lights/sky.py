"""Diffuse light from all sides, as nine spherical harmonics of the radiance.

Source: Ramamoorthi, Hanrahan, "An efficient representation for irradiance environment maps", SIGGRAPH 2001.
`gonio bake harmonics` prints the nine colours of an environment.
"""

from typing import NamedTuple

from gonio.lang import Color, Vec3, maximum

# Convolution with the cosine, pi, 2 pi / 3 and pi / 4, times the norms of the harmonics.
CONSTANT = 0.886226925  # sqrt(pi) / 2
LINEAR = 1.02332671  # sqrt(pi / 3)
QUADRATIC = 0.858085531  # sqrt(15 pi) / 8
QUADRATIC_ZZ = 0.247707956  # sqrt(5 pi) / 16
QUADRATIC_XX = 0.429042765  # sqrt(15 pi) / 16


class Harmonics(NamedTuple):
    """The first nine real spherical harmonics of the radiance, linear RGB, in the world's axes."""

    one: Color
    """Of 1."""
    y: Color
    """Of y."""
    z: Color
    """Of z."""
    x: Color
    """Of x."""
    xy: Color
    """Of x y."""
    yz: Color
    """Of y z."""
    zz: Color
    """Of 3 z^2 - 1."""
    xz: Color
    """Of x z."""
    xx_yy: Color
    """Of x^2 - y^2."""


class Bands(NamedTuple):
    """Irradiance by the bands of the harmonics that it comes from."""

    constant: Color
    """What is the same for every normal."""
    linear: Color
    """What goes with the normal's components."""
    quadratic: Color
    """What goes with their products."""


def irradiance_bands(sky: Harmonics, n: Vec3) -> Bands:
    """Irradiance at a normal, unit, in the world: the sum of the three."""
    linear = LINEAR * (n.y * sky.y + n.z * sky.z + n.x * sky.x)
    mixed = QUADRATIC * (n.x * n.y * sky.xy + n.y * n.z * sky.yz + n.x * n.z * sky.xz)
    zz = QUADRATIC_ZZ * (3 * n.z * n.z - 1) * sky.zz
    xx_yy = QUADRATIC_XX * (n.x - n.y) * (n.x + n.y) * sky.xx_yy
    return Bands(CONSTANT * sky.one, linear, mixed + zz + xx_yy)


def irradiance(sky: Harmonics, n: Vec3) -> Color:
    """Irradiance at a normal, unit, in the world; at least 0."""
    bands = irradiance_bands(sky, n)
    return maximum(bands.constant + bands.linear + bands.quadratic, 0)
