"""Albedos by product rules: some hundred values where a function is smooth, and nothing where it is not.

Rules of rising order cover the whole hemisphere; where two of them agree and the function is smooth, the
finer one is better than their difference, as they converge by factors. At kinks and jumps two rules agree
by chance now and then and are off by up to 1e-3: so searches and first looks use these, and what they
find is confirmed by adaptive integration. There are two charts. Half vectors have slopes that grow by
factors from the width of the lobe on, which the model's own samples tell; polar angles are cut where wi is
as high as wo and at right angles to it, where rough surfaces have their kinks. A rule that overlooks
something narrow agrees with every other one: so values at the model's samples, around the mirror direction
and around wo must not be higher than those that the rule has seen, nor may they change below the width of
the lobe. What does not settle is left to `gonio.check.hemisphere`.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import Any, Protocol

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from gonio.albedos.half_vectors import SLOPE_SCALE, last_slope, mirrored
from gonio.check import hemisphere
from gonio.check.kernels import draw, evaluate_only, reflect_only
from gonio.check.subject import (
    Array,
    Subject,
    even,
    gathered,
    number_type,
    repeated,
    stored,
)

# Nodes along each side of the rules over half vectors, and of those for each of the eight pieces of polar
# angles.
HALF_VECTORS, POLAR = (16, 24), (4, 6)

# The rules over half vectors for what these do not settle, one after the other.
FINER = (32, 48)

# Samples that tell a lobe's width, and which of their slopes, from the smallest on, is taken for it.
SAMPLES, NARROW = 64, 2

# Parts of that width (or of this part of wo's cosine, within which wi's is about the same) at which values
# may not differ by more than this part of the highest.
BELOW, LEVEL, FLAT = (0.0, 0.003, 0.02, 0.1, 0.3), 0.2, 0.25
AZIMUTHS = (0.7, 4.1)

# The same around wo, which is turned about the normal by these parts of how far it is from the mirror
# direction (as a slope, and the width on top, at most WIDEST): the rules' nodes are so far apart there.
NEAR, WIDEST = (0.0, 0.001, 0.005, 0.02), 1.5

# So many times the difference of two rules their error is not.
FAR = 5.0

# No value times its cosine may be so many times higher than the highest that a rule has seen.
HIGHER = 1.5


@dataclass(frozen=True)
class Albedos:
    """Albedos of points, (points, 3), and estimates of their errors, (points,), which are no bounds."""

    total: Array
    error: Array


def albedos(
    subject: Subject,
    parameters: Array,
    wo: Array,
    tolerance: float,
    levels: int = hemisphere.LEVELS,
    floor: float = -np.inf,
) -> Albedos:
    """By product rules, and by adaptive integration where those do not settle.

    What remains far below `floor` even then is left as the rules have it, with their error.
    """
    found, known = settled(subject, parameters, wo, tolerance)
    rows = np.flatnonzero(~known & ~(found.total.max(axis=1) + FAR * found.error < floor))
    if len(rows):
        at = parameters[rows], wo[rows]
        cut = hemisphere.partition(subject, *at, hemisphere.FEWER, hemisphere.FEWER_PROBES)
        rest = hemisphere.integrate(subject, *at, cut, tolerance, levels, albedo_only=True)
        found.total[rows], found.error[rows] = rest.total, rest.error
    return found


def settled(
    subject: Subject, parameters: Array, wo: Array, tolerance: float
) -> tuple[Albedos, NDArray[np.bool_]]:
    """Albedos by product rules, their last two rules' differences, and where they are within the tolerance.

    The tolerance is relative to the albedo where that is above 1.
    """
    n = len(parameters)
    values = subject.values(parameters)
    around = _looked_around(subject, parameters, wo)
    total, error, known = np.zeros((n, 3)), np.full(n, np.inf), np.zeros(n, bool)
    before = np.full((n, 3), np.nan)

    def settle(rows: NDArray[np.intp], chart: type[Chart], sizes: tuple[int, ...]) -> None:
        if not len(rows):
            return
        few = {path: v[rows] for path, v in values.items()}
        found, highest = _sums(subject, few, wo[rows], around.of(rows), chart, sizes)
        coarse = found[:, 0] if len(sizes) > 1 else before[rows]
        fine = found[:, -1]
        with np.errstate(invalid="ignore", over="ignore"):
            change = np.abs(fine - coarse).max(axis=1)
            seen = around.highest[rows] <= HIGHER * highest
            right = change <= tolerance * np.maximum(np.abs(fine).max(axis=1), 1)
            if chart is PolarAngles:  # which know nothing of lobes
                near = np.abs(fine - before[rows]).max(axis=1) <= np.maximum(error[rows], tolerance)
                right &= near
        known[rows] = right & seen
        better = known[rows] if chart is PolarAngles else slice(None)
        total[rows[better]], error[rows[better]] = fine[better], change[better]
        if chart is not PolarAngles:
            before[rows] = fine

    rows = np.flatnonzero(around.flat)
    settle(rows, HalfVectors, HALF_VECTORS)
    settle(rows[~known[rows]], PolarAngles, POLAR)
    for size in FINER:
        settle(rows[~known[rows]], HalfVectors, (size,))
    return Albedos(total, error), known


# --- what a rule might overlook ------------------------------------------------------------------


@dataclass(frozen=True)
class Around:
    """What is known of points before they are integrated."""

    scale: Array
    """From which slope of the half vectors on levels grow by factors."""
    side: Array
    """As in `hemisphere.Partition`."""
    highest: Array
    """The highest value times its cosine."""
    flat: NDArray[np.bool_]
    """Whether nothing changes below the scale."""

    def of(self, rows: NDArray[np.intp]) -> Around:
        """The same of some of the points."""
        return Around(self.scale[rows], self.side[rows], self.highest[rows], self.flat[rows])


def _looked_around(subject: Subject, parameters: Array, wo: Array) -> Around:
    n = len(parameters)
    index = repeated(n, SAMPLES)
    drawn, pdf = draw(subject, parameters, index, wo[index], np.tile(even(SAMPLES), (n, 1)))
    drawn, pdf = drawn.reshape(n, SAMPLES, 3).astype(np.float64), pdf.reshape(n, SAMPLES)
    side = hemisphere.sides(wo, drawn, pdf)
    turned = np.stack([side, side, np.ones(n)], -1)
    good = (pdf > 0) & (drawn[..., 2] > 0)
    drawn = np.where(good[..., None], drawn, wo[:, None])
    half = turned[:, None] * drawn + wo[:, None]
    with np.errstate(invalid="ignore", divide="ignore"):
        slope = np.hypot(half[..., 0], half[..., 1]) / half[..., 2]
    slope = np.sort(np.where(good & np.isfinite(slope), slope, np.inf), axis=1)
    scale = np.clip(slope[:, NARROW], SLOPE_SCALE, 1.0)

    probes = [drawn]
    for azimuth in AZIMUTHS:
        x, y = math.cos(azimuth), math.sin(azimuth)
        for part in BELOW:
            t = part * np.minimum(scale, LEVEL * wo[:, 2])
            m = np.stack([t * x, t * y, np.ones(n)], -1) / np.sqrt(1 + t * t)[:, None]
            w = 2 * (m * wo).sum(axis=1)[:, None] * m - wo
            probes.append((turned * w)[:, None])
    flat = np.hypot(wo[:, 0], wo[:, 1])
    angle = np.minimum(flat / np.maximum(wo[:, 2], 1e-9) + scale, WIDEST)
    aside = np.stack([-wo[:, 1], wo[:, 0], 0 * flat], -1) + np.array([1e-9, 0, 0])
    aside /= np.linalg.norm(aside, axis=1)[:, None]
    for part in NEAR:
        w = wo + (part * angle)[:, None] * aside
        probes.append((w / np.linalg.norm(w, axis=1)[:, None])[:, None])
    light = np.concatenate(probes, axis=1)
    each = light.shape[1]
    light[..., 2] = np.maximum(light[..., 2], 1e-9)
    index = repeated(n, each)
    f = evaluate_only(subject, parameters, index, light.reshape(-1, 3), wo[index])
    with np.errstate(invalid="ignore", over="ignore"):
        value = np.abs(f.astype(np.float64)).max(axis=1).reshape(n, each)
        count = len(BELOW) * len(AZIMUTHS)
        lobe, near = value[:, SAMPLES : SAMPLES + count], value[:, SAMPLES + count :]
        even_lobe = np.ptp(lobe, axis=1) <= FLAT * lobe.max(axis=1)
        even_near = np.ptp(near, axis=1) <= FLAT * near.max(axis=1)
        flat = (even_lobe | (scale <= SLOPE_SCALE)) & (even_near | (side < 0))
        highest = (value * light[..., 2]).max(axis=1)
    return Around(scale, side, highest, flat & np.isfinite(highest))


# --- the rules -----------------------------------------------------------------------------------


class Chart(Protocol):
    """Directions wi by meridians, and places on them."""

    @staticmethod
    def nodes(size: int) -> tuple[Array, Array]:
        """Places and weights of the meridians, (meridians, 2), and of the nodes on each, (nodes, 2)."""

    @staticmethod
    def meridian(wo: Any, scale: Any, u: Any, weight: Any) -> list[Any]:
        """What the nodes of a meridian share."""

    @staticmethod
    def down(wo: Any, scale: Any, side: Any, meridian: list[Any], v: Any) -> tuple[Any, Any]:
        """wi at a place on a meridian, and the solid angle per place, times the meridian's weight."""


class HalfVectors:
    """Half vectors by azimuth from wo's, and by levels of their slopes up to the horizon."""

    @staticmethod
    def nodes(size: int) -> tuple[Array, Array]:
        """Even steps around, which converge by factors in what comes back to itself, and Gauss's down."""
        around = np.stack([(np.arange(size) + 0.5) / size, np.full(size, 1 / size)], -1)
        return around, _gauss(size)

    @staticmethod
    def meridian(wo: Any, scale: Any, u: Any, weight: Any) -> list[Any]:
        """The nearer wo is to the horizon, the more they crowd at right angles to it, smoothly."""
        crowd = 1 - dr.clip(wo.z, 0, 1)
        s, c = dr.sincos(2 * np.pi * u + 0.5 * crowd * dr.sin(4 * np.pi * u))
        turn = 2 * np.pi * (1 + crowd * dr.cos(4 * np.pi * u))
        ax, ay = hemisphere.axes(wo)
        toward = dr.sqrt(wo.x * wo.x + wo.y * wo.y) * c
        end = dr.asinh(last_slope(toward, wo.z) / scale)
        return [c * ax - s * ay, c * ay + s * ax, toward, end, turn * weight]

    @staticmethod
    def down(wo: Any, scale: Any, side: Any, meridian: list[Any], v: Any) -> tuple[Any, Any]:
        """From the mirror direction, or from wo, to the horizon."""
        x, y, toward, end, turn = meridian
        grown = dr.exp(v * end)
        inv = 1 / grown
        wi, area = mirrored(wo, x, y, toward, 0.5 * scale * (grown - inv))
        wi = type(wo)(side * wi.x, side * wi.y, wi.z)
        return wi, area * 0.5 * scale * (grown + inv) * end * turn


class PolarAngles:
    """Azimuth and angle to the normal, in pieces: quarter turns from wo's azimuth, above and below wo."""

    @staticmethod
    def nodes(size: int) -> tuple[Array, Array]:
        """Gauss's in every piece; places from 1 on are those below wo."""
        x, w = _gauss(size).T
        around = np.concatenate([np.stack([0.25 * (q + x), 0.25 * w], -1) for q in range(4)])
        return around, np.stack([np.append(x, 1 + x), np.append(w, w)], -1)

    @staticmethod
    def meridian(wo: Any, scale: Any, u: Any, weight: Any) -> list[Any]:
        """Its direction seen from above, and wo's angle."""
        s, c = dr.sincos(2 * np.pi * u)
        ax, ay = hemisphere.axes(wo)
        return [c * ax - s * ay, c * ay + s * ax, dr.safe_acos(wo.z), 2 * np.pi * weight]

    @staticmethod
    def down(wo: Any, scale: Any, side: Any, meridian: list[Any], v: Any) -> tuple[Any, Any]:
        """From the normal to wo, and on to the horizon."""
        x, y, theta, turn = meridian
        above = v < 1
        width = dr.select(above, theta, 0.5 * np.pi - theta)
        s, c = dr.sincos(dr.select(above, v * theta, theta + (v - 1) * width))
        return type(wo)(s * x, s * y, c), s * width * turn


def _gauss(size: int) -> Array:
    x, w = np.polynomial.legendre.leggauss(size)
    return np.stack([(x + 1) / 2, w / 2], -1)


@dataclass(frozen=True)
class Nodes:
    """One rule after the other."""

    meridians: Array
    """Places and weights, (meridians, 2)."""
    row: NDArray[np.uint32]
    """The meridian of every node."""
    places: Array
    """Place on the meridian and weight of every node, (nodes, 2)."""
    sizes: tuple[int, ...]
    """Nodes of each rule."""


@functools.cache
def _nodes(chart: type[Chart], sizes: tuple[int, ...]) -> Nodes:
    meridians, row, places = [], [], []
    first = 0
    for size in sizes:
        around, down = chart.nodes(size)
        meridians.append(around)
        row.append(first + np.repeat(np.arange(len(around)), len(down)))
        places.append(np.tile(down, (len(around), 1)))
        first += len(around)
    return Nodes(
        np.concatenate(meridians),
        np.concatenate(row).astype(np.uint32),
        np.concatenate(places),
        tuple(len(p) for p in places),
    )


def _sums(
    subject: Subject,
    values: dict[str, Array],
    wo: Array,
    around: Around,
    chart: type[Chart],
    sizes: tuple[int, ...],
) -> tuple[Array, Array]:
    """Albedos by every rule, (points, rules, 3), and the highest value times its cosine."""
    nodes = _nodes(chart, sizes)
    each = len(nodes.row)
    together = max(dr.thread_count() * hemisphere.BATCH // each, 1)
    sums, highest = [], []
    for start in range(0, len(wo), together):
        part = slice(start, start + together)
        few = {path: v[part] for path, v in values.items()}
        total, top = _batch(
            subject, few, wo[part], around.scale[part], around.side[part], chart, nodes
        )
        sums.append(total)
        highest.append(top)
    return np.concatenate(sums), np.concatenate(highest)


def _batch(
    subject: Subject,
    values: dict[str, Array],
    wo: Array,
    scale: Array,
    side: Array,
    chart: type[Chart],
    nodes: Nodes,
) -> tuple[Array, Array]:
    Float = number_type()
    UInt = dr.uint32_array_t(Float)
    Vec = dr.replace_shape_t(Float, (3, -1))
    points, each, rows = len(wo), len(nodes.row), len(nodes.meridians)
    given = stored(Float, np.column_stack([wo, scale, side]).ravel())
    at, places = stored(Float, nodes.meridians.ravel()), stored(Float, nodes.places.ravel())

    def viewer(index: Any) -> tuple[Any, Any, Any]:
        """wo, scale and side of points."""
        x, y, z, s, t = (dr.gather(Float, given, 5 * index + k) for k in range(5))
        return Vec(x, y, z), s, t

    row = dr.arange(UInt, points * rows)
    index = row // rows
    node = row - index * rows
    u, weight = (dr.gather(Float, at, 2 * node + k) for k in range(2))
    wo_, s, _ = viewer(index)
    meridian = chart.meridian(wo_, s, u, weight)
    dr.eval(meridian)
    lane = dr.arange(UInt, points * each)
    index = lane // each
    node = lane - index * each
    row = index * rows + dr.gather(UInt, stored(UInt, nodes.row), node)
    meridian = [dr.gather(Float, column, row) for column in meridian]
    v, weight = (dr.gather(Float, places, 2 * node + k) for k in range(2))
    wo_, s, t = viewer(index)
    wi, solid = chart.down(wo_, s, t, meridian, v)
    solid *= weight
    # Kernels that know nothing of the model are the same for all
    dr.eval(index, wi, wo_, solid)
    model = subject.bound(gathered(values, index, Float), Float)
    f = reflect_only(model, wi, wo_)
    cosine = dr.maximum(wi.z, 0)
    block = math.gcd(*nodes.sizes)
    sums = [dr.block_sum(c * cosine * solid, block) for c in f]
    largest = dr.maximum(dr.maximum(dr.abs(f.x), dr.abs(f.y)), dr.abs(f.z)) * cosine
    top = dr.block_reduce(dr.ReduceOp.Max, largest, each)
    dr.eval(sums, top)
    found = np.stack([s.numpy() for s in sums], -1).reshape(points, -1, 3)
    first = np.cumsum((0, *nodes.sizes[:-1])) // block
    return np.add.reduceat(found, first, axis=1), top.numpy()
