"""Directions, parameters and random numbers that break shading code, in float32."""

from __future__ import annotations

import functools
import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from gonio.check.search import specialised
from gonio.check.subject import (
    Array,
    Subject,
    columns_of,
    compute,
    directions,
    number_type,
    stored,
)
from gonio.lang import MU_MIN

# Cosines at which published listings divide by zero, cancel or leave their range: both sides of where the
# horizon begins, every second decade above it, and the smallest float32 of all (a denormal).
COSINES = (
    *(0.0, 1e-42, 1e-30, 1.1e-18, 1e-16, 1e-14, 1e-12, 1e-10, 1e-8, 1e-7, 1e-6, 1e-4, 1e-3),
    *(0.017, 0.1, 0.5, 0.9, 0.99986, 0.999999, 1.0),
)
AZIMUTHS = (0.0, 1e-7, 1e-3, 0.5, 1.5707963, 1.5708, 2.0, 3.1414, 3.14159265)

# The smallest and the largest float32 random numbers, and some between.
RANDOM = (0.0, 2.0**-24, 1e-4, 0.25, 0.5, 0.75, 1 - 2.0**-24)

# Coordinates of a hard case beside its parameters: two cosines, two azimuths, how wi lies to wo, and two
# random numbers.
EXTRA = 7

# The smallest cosine of a search, and the smallest distance from the normal and the mirror direction, as
# powers of ten.
LOWEST, NEAREST = -17.9, -8.0


@functools.cache
def hard_pairs(lowest: float = 0.0) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Pairs (wi, wo) of every combination of the cosines and azimuths above, and more.

    Among them: one or both in the horizon, wi = wo, and wi the mirror direction of wo, exactly. All are
    turned about the normal by random angles. Cosines between 0 and `lowest` are left out.
    """
    cosines = [mu for mu in COSINES if mu == 0 or mu >= lowest]
    cases = itertools.product(cosines, cosines, AZIMUTHS)
    mu_i, mu_o, phi = np.array(list(cases)).T
    rng = np.random.default_rng(7)
    # Every second one in the plane of x, where a term of y is exactly zero
    turn = np.where(np.arange(len(phi)) % 2, 2 * np.pi * rng.random(len(phi)), 0)
    wi = directions(mu_i, phi + turn).astype(np.float32)
    wo = directions(mu_o, turn).astype(np.float32)
    turned = directions(rng.random(2000), 2 * np.pi * rng.random(2000)).astype(np.float32)
    grazing = directions(10.0 ** np.linspace(-17, 0, 2000), np.linspace(0, 60, 2000))
    grazing = grazing.astype(np.float32)
    grazing = grazing[(grazing[:, 2] == 0) | (grazing[:, 2] >= lowest)]
    mirror = np.array([-1, -1, 1], np.float32)
    return (
        np.concatenate([wi, turned, turned * mirror, grazing, grazing * mirror]),
        np.concatenate([wo, turned, turned, grazing, grazing]),
    )


def hard_numbers(count: int, seed: int) -> NDArray[np.float32]:
    """Pairs of random numbers (count, 2) out of RANDOM."""
    return np.random.default_rng(seed).choice(np.array(RANDOM, np.float32), (count, 2))


def special_parts(subject: Subject) -> list[Array]:
    """For every free number the parts of its range at which something may change."""
    return [free.parts for free in subject.parameters]


def hard_parameters(subject: Subject, count: int, seed: int) -> Array:
    """Rows of parameters, (count, numbers): where models break, and everywhere else.

    A tenth are the defaults; a fifth the defaults but for one or two numbers; the others are random, with
    numbers at the ends of their ranges, at special values, beside them, equal to each other, and grey.
    """
    rng = np.random.default_rng(seed)
    numbers = len(subject.parameters)
    t = rng.random((count, numbers))
    if not numbers:
        return t
    t = specialised(rng, t, special_parts(subject), 0.25)
    # Channels of one colour
    grey = rng.random(count) < 0.4
    first = 0
    for number, free in enumerate(subject.parameters):
        first = number if free.channel == 0 else first
        t[grey, number] = t[grey, first]
    # Two numbers that are equal: differences of widths or indices vanish there
    equal = np.flatnonzero(rng.random(count) < 0.1)
    t[equal, rng.integers(0, numbers, len(equal))] = t[equal, rng.integers(0, numbers, len(equal))]
    default = subject.default()
    kind = rng.random(count)
    varied = rng.random(t.shape) < 1.5 / numbers
    t = np.where(((kind < 0.3)[:, None]) & ~varied, default, t)
    t[kind < 0.1] = default
    return t


@dataclass(frozen=True)
class Cases:
    """Rows of parameters with directions and random numbers that float32 can hold."""

    parameters: Array
    wi: Array
    wo: Array
    u: Array

    def __len__(self) -> int:
        """How many."""
        return len(self.wi)


def hard_cases(subject: Subject, points: Array, lowest: float = MU_MIN) -> Cases:
    """The cases that points in [0, 1]^(numbers + EXTRA) stand for, for searches near what is singular.

    Cosines between 0 and `lowest` are lifted to that.
    """
    count = len(subject.parameters)
    Float = number_type()
    wi, wo, u = placed([stored(Float, t) for t in points[:, count:].T], lowest)
    dr.eval(wi, wo, u)
    return Cases(points[:, :count], columns_of(wi), columns_of(wo), columns_of(u))


def placed(t: Sequence[Any], lowest: float = MU_MIN) -> tuple[Any, Any, Any]:
    """The same as Dr.Jit vectors (wi, wo, u) of numbers that float32 can hold, from EXTRA coordinates."""
    turn = 2 * np.pi * _angle(t[2])
    wo = _direction(_cosine(t[0]), turn)
    free = _direction(_cosine(t[1]), turn + 2 * np.pi * _angle(t[3]))
    Vector = type(wo)
    # wi anywhere, as high as wo, near the mirror direction, or near wo
    kind = 4 * t[4]
    flat = dr.sqrt(dr.square(free.x) + dr.square(free.y))
    sine = dr.sqrt(dr.square(wo.x) + dr.square(wo.y))
    scale = sine / dr.maximum(flat, 1e-300)
    level = dr.select(flat > 0, Vector(free.x * scale, free.y * scale, wo.z), wo)
    near = dr.select(kind < 3, Vector(-wo.x, -wo.y, wo.z), wo)
    # Some of those are the mirror direction itself, or wo
    offset = dr.select(t[1] > 0.95, 0, dr.power(10.0, NEAREST * t[1]))
    wi = dr.select(kind < 1, free, dr.select(kind < 2, level, near + offset * free))
    u = dr.replace_shape_t(type(t[0]), (2, -1))(_number(t[5]), _number(t[6]))
    return _single(dr.normalize(wi), lowest), _single(wo, lowest), rounded(u)


def rounded(value: Any) -> Any:
    """The nearest numbers that float32 can hold, in double precision."""
    Float = compute().Float
    shape = (dr.size_v(value), -1) if dr.depth_v(value) > 1 else ()
    single = dr.replace_shape_t(Float, shape)(value) if shape else Float(value)
    return type(value)(single)


def random_points(subject: Subject, count: int, seed: int) -> Array:
    """Points for `hard_cases`, their parameters as `hard_parameters` has them."""
    rng = np.random.default_rng(seed + 1)
    return np.concatenate(
        [hard_parameters(subject, count, seed), rng.random((count, EXTRA))], axis=1
    )


def _direction(cosine: Any, azimuth: Any) -> Any:
    sin, cos = dr.sincos(azimuth)
    sine = dr.sqrt((1 - cosine) * (1 + cosine))
    return dr.replace_shape_t(type(cosine), (3, -1))(sine * cos, sine * sin, cosine)


def _cosine(t: Any) -> Any:
    """A third each: grazing by powers of ten, even, and near the normal by powers of ten."""
    grazing = dr.power(10.0, LOWEST * (1 - 3 * dr.minimum(t, 1 / 3)))
    normal = 1 - 0.5 * dr.power(10.0, 2 * NEAREST * dr.maximum(3 * t - 2, 0))
    found = dr.select(t < 1 / 3, grazing, dr.select(t < 2 / 3, 3 * t - 1, normal))
    return dr.select(t == 1, 1, dr.clip(found, 0, 1))


def _angle(t: Any) -> Any:
    """A part of a full turn: half of them even, the others near multiples of a quarter."""
    eighths = 8 * dr.select(t < 0.5, t, t - 0.5)
    quarter = dr.floor(eighths)
    within = eighths - quarter
    near = 0.25 * quarter + dr.select(within < 0.1, 0, 0.1 * dr.power(10.0, -8 * within))
    return dr.select(t < 0.5, 2 * t, near)


def _number(t: Any) -> Any:
    """A random number: half of them even, the others near 0 and 1 by powers of two."""
    low = dr.exp2(-24 * dr.minimum(4 * t, 1))
    high = 1 - dr.exp2(-24 * dr.clip(4 * t - 3, 0, 1))
    found = dr.select(t < 0.25, low, dr.select(t > 0.75, high, 2 * t - 0.5))
    return dr.minimum(dr.select(t == 0, 0, found), 1 - 2.0**-24)


def _single(w: Any, lowest: float) -> Any:
    """Directions that float32 can hold; cosines between 0 and where the horizon begins are lifted."""
    low = (w.z > 0) & (w.z <= lowest)
    w = rounded(w)
    w.z = dr.select(low, float(np.float32(1.01 * lowest)), w.z)
    return w
