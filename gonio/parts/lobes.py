"""What models of several lobes share: Schlick's terms at the half vector, lobe choice, a GGX lobe.

The one-sample mixture: a lobe is chosen with a probability near its share of the albedo, the random
number that chose it is stretched back to [0, 1) and used again, and the density is the whole mixture's.
"""

from typing import NamedTuple

from gonio.lang import (
    MU_MIN,
    Color,
    Float,
    Mask,
    Vec2,
    Vec3,
    absolute,
    clamp,
    exp,
    maximum,
    minimum,
    select,
    vec2,
    vec3,
)
from gonio.parts.distribution import GGX, RoundGGX
from gonio.parts.frame import half_vector, mirror
from gonio.parts.special import log_cos_along

# Added to the first lobe's weight, so that two black lobes still leave something to choose and the
# reciprocal of their sum has a derivative; no albedo that can be seen is that small.
BLACK = 1e-12

# The smallest weight of the second lobe. Float32 ends there, and GPUs take what is smaller for 0, while a
# grazing direction may have a density of 1e22 in that lobe.
WEIGHT_MIN = 1e-37

# The albedos that choose are estimates. A lobe gets at least this share, unless even ESTIMATE_TRUST times
# its estimate is less: then the weight of the lobe stays bounded where the estimate is that much too low.
SHARE_LEAST = 0.1
ESTIMATE_TRUST = 50

# Smallest probability that is divided by: a random number falls below it once in a million million.
SHARE_MIN = 1e-12

# The largest float32 below 1, up to which random numbers go.
RANDOM_MAX = 1 - 2.0**-24


def average(color: Color) -> Float:
    """Mean of the three channels, by which lobes are weighed against each other."""
    return (color.x + color.y + color.z) / 3


def shares(first: Float, second: Float) -> Vec2:
    """Probabilities of two lobes with the given albedos; the first is all but certain if both are black."""
    a, b = first + BLACK, maximum(second, WEIGHT_MIN)
    inv = 1 / (a + b)
    P_first, P_second = _raised(a * inv), _raised(b * inv)
    # The smaller one by itself: 1 minus a probability near 1 has no digits left.
    smaller = a < b
    return vec2(select(smaller, P_first, 1 - P_second), select(smaller, 1 - P_first, P_second))


def _raised(probability: Float) -> Float:
    return maximum(probability, minimum(SHARE_LEAST, ESTIMATE_TRUST * probability))


def share(first: Float, second: Float) -> Float:
    """The first of the two probabilities."""
    return shares(first, second).x


class Choice(NamedTuple):
    """Which of two lobes a sample is taken from."""

    is_first: Mask
    """Whether it is the first one."""
    u: Vec2
    """Fresh random numbers, made of those that chose."""


def choose(probability: Float, u: Vec2) -> Choice:
    """Choose the first of two lobes with a probability, and make fresh random numbers of the used ones."""
    first = u.x < probability
    below = u.x / maximum(probability, SHARE_MIN)
    above = (u.x - probability) / maximum(1 - probability, SHARE_MIN)
    return Choice(first, vec2(clamp(select(first, below, above), 0, RANDOM_MAX), u.y))


def sample_ggx_lobe(facets: GGX | RoundGGX, wo: Vec3, u: Vec2) -> Vec3:
    """wo mirrored at a visible normal; what would leave below the horizon is mirrored up again.

    No sample is wasted, and as the density is the sum of both, no weight grows. Without the normals that
    mirror below the horizon, the rim of those that are left would be a jump of the density.
    """
    w = mirror(wo, facets.sample_visible(wo, u))
    return vec3(w.x, w.y, absolute(w.z))


def pdf_ggx_lobe(facets: GGX | RoundGGX, wi: Vec3, wo: Vec3) -> Float:
    """Density of `sample_ggx_lobe` in 1/sr."""
    seen = 0.5 / (wo.z + facets.area(wo))  # Smith's G1 over 4 mu_o
    straight = facets.D(half_vector(wi, wo))
    # The normal that mirrors wo to wi's image below the horizon; it exists if wo is the higher of both. Of
    # cosines that are nearly equal the difference is exact; lifted before, they would lose its digits. The
    # lift keeps derivatives finite: where heights differ by no more, this is not the density of samples.
    exists = wo.z > wi.z
    across = vec3(wi.x, wi.y, select(exists, wo.z - wi.z, wi.z))
    folded = facets.D(half_vector(across, vec3(wo.x, wo.y, select(exists, MU_MIN, wo.z))))
    return (straight + select(exists, folded, 0)) * seen


def cos_power(h: Vec3, exponent: Float) -> Float:
    """(N.m)^exponent of the normal m along h, exact for sharp lobes."""
    return exp(exponent * log_cos_along(h))
