"""Integrals over the hemisphere in float64, adaptive, for lobes of any sharpness in any direction.

Directions wi are charted by half vectors: u is the azimuth of m = normalize(wi + wo) from wo's (crowded at
quarter turns), v the level of its slope (gonio.albedos.half_vectors) as a part of that at which wi meets
the horizon. A mirror's lobe of any width then takes up a fair share of the unit square. The square is first
cut into cells that the model's own samples fill equally (so that a lobe anywhere is seen), and cells are
cut again until Lobatto's rule has converged. Where a sampler sends its samples back to wo rather than to
the mirror direction, the chart is turned by half a turn about the normal.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from gonio.albedos.half_vectors import last_slope, level_of, mirrored, slope_at
from gonio.check.kernels import draw, reflect, reflect_only
from gonio.check.subject import (
    Array,
    Subject,
    even,
    gathered,
    number_type,
    repeated,
    stored,
    vectors,
)

# Cells at the start (a power of two) and samples by which they are cut. A quarter of the samples is
# spread evenly, so that what the sampler does not know of is resolved as well.
DEPTH = 6
CELLS = 2**DEPTH
PROBES = 4096

# The same where many integrals are compared.
FEWER, FEWER_PROBES = 4, 1024

# Nodes of the rule along each side of a cell: Lobatto's, of degree 9, with nodes at both ends. A kink near
# a cell's edge would lie beside all of Gauss's, cut after cut; these see it. The ends are a bit inside,
# where the horizon, in which every value is 0, is not hit.
NODES = 6
INSIDE = 1e-9

# A cell with at least this many samples is cut as well while more than this part of them keeps to one of
# its halves: the nodes might all lie beside them, and find that nothing changes.
CROWD, CROWDED = 6, 0.85

# Cells are cut no more often than this: a narrow lobe seen at grazing angles is 1e-6 of the square wide.
LEVELS = 22

# At most so many cells of a point are cut at once, those along a jump double with every cut; and with
# tolerances below CAREFUL.
OPEN, OPEN_CAREFUL = 3000, 12000

# Albedos above 1 are integrated to within the tolerance times them, or times this.
ENORMOUS = 1e6

# With tolerances below this every cell is cut twice at least.
CAREFUL = 5e-7

# Evaluations of one thread in a kernel call: what they write stays in its cache.
BATCH = 100_000


def axes(wo: Any) -> tuple[Any, Any]:
    """Cosine and sine of wo's azimuth; (1, 0) at the normal."""
    radius = dr.sqrt(wo.x * wo.x + wo.y * wo.y)
    far = radius > 1e-150
    inv = 1 / dr.select(far, radius, 1)
    return dr.select(far, wo.x * inv, 1), dr.select(far, wo.y * inv, 0)


def _reach(wo: Any, c: Any) -> tuple[Any, Any]:
    """sin(theta_o) cos(phi), and the level of the slope at which wi meets the horizon."""
    toward = dr.sqrt(wo.x * wo.x + wo.y * wo.y) * c
    return toward, level_of(last_slope(toward, wo.z))


def chart(wo: Any, u: Any, v: Any, side: Any = 1) -> tuple[Any, Any]:
    """The direction wi at a point of the unit square, and the solid angle per area there.

    `side` is 1 for a chart around the mirror direction, -1 for one around wo.
    """
    return _down(wo, _meridian(wo, u), v, side)


class Meridian(NamedTuple):
    """The half vectors of one u: what they share, which costs most of a chart."""

    x: Any
    y: Any
    """Their direction seen from above, a unit vector."""
    toward: Any
    end: Any
    """As `_reach` has them."""
    turn: Any
    """Azimuth per u."""


def _meridian(wo: Any, u: Any) -> Meridian:
    phi, turn = _crowd(u)
    s, c = dr.sincos(phi)
    ax, ay = axes(wo)
    return Meridian(c * ax - s * ay, c * ay + s * ax, *_reach(wo, c), turn)


def _down(wo: Any, m: Meridian, v: Any, side: Any) -> tuple[Any, Any]:
    """wi at a part v of a meridian, from the normal to the horizon, and the solid angle."""
    slope, steepness = slope_at(v * m.end)
    wi, area = mirrored(wo, m.x, m.y, m.toward, slope)
    wi = type(wo)(side * wi.x, side * wi.y, wi.z)
    return wi, area * steepness * m.end * m.turn


def _crowd(u: Any) -> tuple[Any, Any]:
    """Azimuth of m, crowded at a quarter turn from wo's on both sides, and its derivative.

    Seen from a grazing wo all directions but the mirror's nearest have their half vectors there.
    """
    quarter = dr.minimum(dr.floor(4 * u), 3)
    r = 4 * u - quarter
    from_below = (quarter == 0) | (quarter == 2)
    x = dr.select(from_below, 1 - r, r)
    cube = x * x * x
    part = dr.select(from_below, 1 - cube, cube)
    return 0.5 * np.pi * (quarter + part), 6 * np.pi * x * x


def _uncrowd(turn: Any) -> Any:
    """u from the azimuth in turns: the inverse of `_crowd`."""
    quarter = dr.minimum(dr.floor(4 * turn), 3)
    part = 4 * turn - quarter
    from_below = (quarter == 0) | (quarter == 2)
    x = dr.cbrt(dr.clip(dr.select(from_below, 1 - part, part), 0, 1))
    return (quarter + dr.select(from_below, 1 - x, x)) / 4


def unchart(wo: Any, wi: Any, side: Any = 1) -> tuple[Any, Any]:
    """The point of a direction in the unit square: the inverse of `chart`."""
    h = type(wo)(side * wi.x + wo.x, side * wi.y + wo.y, wi.z + wo.z)
    ax, ay = axes(wo)
    x, y = h.x * ax + h.y * ay, h.y * ax - h.x * ay
    radius = dr.sqrt(x * x + y * y)
    turn = dr.atan2(y, x) / (2 * np.pi)
    c = dr.select(radius > 0, x / dr.maximum(radius, 1e-300), 1)
    _, end = _reach(wo, c)
    v = level_of(radius / dr.maximum(h.z, 1e-300)) / end
    return _uncrowd(dr.select(turn < 0, turn + 1, turn)), dr.clip(v, 0, 1)


@dataclass(frozen=True)
class Partition:
    """The unit square of each point cut into cells: boxes, and the cuts as trees to find them again."""

    boxes: Array
    """u from, u to, v from, v to: (points, cells, 4)."""
    cuts: Array
    """Where each node of the tree is cut, breadth first: (points, cells - 1)."""
    probes: Array
    """Places of the samples, (n, 2), sorted by their cells."""
    cell: NDArray[np.intp]
    """The cell of each of them, counted through all points."""
    side: Array
    """1 where the chart is around the mirror direction, -1 where it is around wo, (points,)."""


def drawn(subject: Subject, parameters: Array, wo: Array, probes: int) -> tuple[Array, Array]:
    """So many evenly spread samples of each point, one point after the other, and their densities."""
    index = repeated(len(parameters), probes)
    u = np.tile(even(probes), (len(parameters), 1))
    return draw(subject, parameters, index, wo[index], u)


def partition(
    subject: Subject,
    parameters: Array,
    wo: Array,
    depth: int = DEPTH,
    probes: int = PROBES,
    samples: tuple[Array, Array] | None = None,
) -> Partition:
    """Cut the square of every point into 2^depth cells that the model's samples fill equally.

    `samples` are what `drawn` gives, where they are known already.
    """
    points = len(parameters)
    index = repeated(points, probes)
    wi, pdf = samples or drawn(subject, parameters, wo, probes)
    Float = number_type()
    side = sides(wo, wi.reshape(points, probes, 3), pdf.reshape(points, probes))
    a, b = unchart(vectors(Float, wo[index]), vectors(Float, wi), stored(Float, side[index]))
    places = np.stack([a.numpy(), b.numpy()])
    lost = ~(pdf > 0) | ~np.isfinite(places).all(axis=0)
    lost.reshape(points, probes)[:, ::4] = True
    spread = np.tile(even(probes)[::-1], (points, 1))
    for axis in range(2):
        np.copyto(places[axis], spread[:, axis], where=lost)

    # Which of the samples are in each group, (groups, samples)
    group = np.arange(points * probes).reshape(points, probes)
    boxes = np.tile(np.array([0.0, 1.0, 0.0, 1.0]), (points, 1, 1))
    cuts = []
    for level in range(depth):
        axis, half = level % 2, group.shape[1] // 2
        value = places[axis][group]
        order = np.argpartition(value, (half - 1, half), axis=1)
        row = np.arange(len(group))
        cut = 0.5 * (value[row, order[:, half - 1]] + value[row, order[:, half]])
        cut = cut.reshape(points, -1)
        low, high = boxes[..., 2 * axis], boxes[..., 2 * axis + 1]
        # A cell keeps some width even where all samples coincide
        margin = 1e-9 * (high - low)
        cut = np.clip(cut, low + margin, high - margin)
        cuts.append(cut)
        lower, upper = boxes.copy(), boxes.copy()
        lower[..., 2 * axis + 1] = cut
        upper[..., 2 * axis] = cut
        boxes = np.stack([lower, upper], 2).reshape(points, -1, 4)
        group = np.take_along_axis(group, order, axis=1).reshape(-1, half)
    sample = group.ravel()
    cell = np.repeat(np.arange(points * 2**depth), probes // 2**depth)
    kept = ~lost[sample]
    return Partition(
        boxes, np.concatenate(cuts, axis=1), places[:, sample[kept]].T, cell[kept], side
    )


def sides(wo: Array, wi: Array, pdf: Array) -> Array:
    """-1 for the points whose samples keep nearer to wo than to its mirror direction."""
    # Some of them are enough
    wi, reached = wi[:, ::4], pdf[:, ::4] > 0
    back = np.einsum("pnk,pk->pn", wi, wo)
    mirror = np.einsum("pnk,pk->pn", wi, wo * np.array([-1.0, -1.0, 1.0]))
    # Median distances: a few stray samples count little
    with np.errstate(invalid="ignore"):
        far_back = np.median(np.where(reached, 1 - back, 1.0), axis=1)
        far_mirror = np.median(np.where(reached, 1 - mirror, 1.0), axis=1)
    return np.where(far_back < RETRO * far_mirror, -1.0, 1.0)


# A lobe is one around wo if half of its samples are so many times nearer to it.
RETRO = 0.5


def cell_of(cuts: Any, tree: Any, u: Any, v: Any) -> Any:
    """The cell of a place in the square of point `tree`, by walking down its cuts (a Dr.Jit array)."""
    UInt = type(tree)
    node = 0 * tree
    first = 0
    for level in range(DEPTH):
        cut = dr.gather(type(u), cuts, tree * UInt(CELLS - 1) + UInt(first) + node)
        node = 2 * node + dr.select((u, v)[level % 2] >= cut, UInt(1), UInt(0))
        first += 2**level
    return node


# What is integrated, one column each.
ALBEDO = slice(0, 3)
PDF, SECOND, COSINE_SECOND, UNREACHED = 3, 4, 5, 6
COLUMNS = 7


@dataclass(frozen=True)
class Integrals:
    """Integrals over every cell, (points, cells, COLUMNS), and bounds of their errors."""

    cells: Array
    cell_error: Array
    """Of the albedo and of the density's integral over every cell, (points, cells)."""

    @property
    def error(self) -> Array:
        """Of the same over the whole hemisphere, (points,)."""
        return np.asarray(self.cell_error.sum(axis=1))

    @property
    def total(self) -> Array:
        """Over the whole hemisphere, (points, COLUMNS)."""
        return np.asarray(self.cells.sum(axis=1))


def integrate(
    subject: Subject,
    parameters: Array,
    wo: Array,
    cut: Partition,
    tolerance: float = 2e-6,
    levels: int = LEVELS,
    albedo_only: bool = False,
) -> Integrals:
    """Integrate f μi, the density, and second moments of weights over every cell.

    Cells are cut until one more cut changes the albedo by less than the tolerance over the number of
    cells' root, or `levels` are reached; `error` says how much the last cuts have changed. With
    `albedo_only` the other columns are left out, which takes half the time, and the tolerance is relative
    to albedos above 1.
    """
    width = ALBEDO.stop if albedo_only else COLUMNS
    points, count = cut.boxes.shape[:2]
    totals = np.zeros((points * count, width))
    error = np.zeros(points * count)
    root = np.arange(points * count)
    box = cut.boxes.reshape(-1, 4)
    probe, cell = cut.probes, cut.cell
    values = subject.values(parameters)
    limit = np.full(points, tolerance / np.sqrt(count))
    # A kink near a cell's corner may lie beside all nodes of one cut
    first = 1 if tolerance < CAREFUL else 0
    allowed = points * (OPEN_CAREFUL if tolerance < CAREFUL else OPEN)
    coarse = np.zeros((0, width))
    for level in range(levels):
        children = _split(box)
        point, boxes = np.repeat(root // count, 4), children
        if level == 0:  # both at once
            point, boxes = np.append(root // count, point), np.append(box, boxes, axis=0)
        fine = _cells(subject, values, wo, cut.side, point, boxes, width)
        if level == 0:
            coarse, fine = fine[: len(box)], fine[len(box) :]
            if albedo_only:  # of which some have no bound
                about = np.nan_to_num(coarse.reshape(points, count, width).sum(axis=1))
                limit *= np.clip(about.max(axis=1), 1, ENORMOUS)
        summed = fine.reshape(-1, 4, width).sum(axis=1)
        with np.errstate(invalid="ignore"):  # values that are not finite are found in `change`
            change = np.abs(summed - coarse)[:, :4].max(axis=1)
        # Not a comparison with >, which NaN would pass
        done = ~(change > limit[root // count]) & ~_crowded(box, cell, probe) & (level >= first)
        if level == levels - 1 or np.count_nonzero(~done) > allowed:
            done[:] = True
        np.add.at(totals, root[done], summed[done])
        np.add.at(error, root[done], change[done])
        open_ = np.flatnonzero(~done)
        if not len(open_):
            break
        probe, cell = _follow(box, cell, probe, open_)
        root = np.repeat(root[open_], 4)
        keep = (4 * open_[:, None] + np.arange(4)).ravel()
        box, coarse = children[keep], fine[keep]
    # The sum over smaller cells is nearer to the integral than its distance from the larger ones: by
    # 4 even across a kink.
    return Integrals(totals.reshape(points, count, width), error.reshape(points, count) / 4)


def _crowded(box: Array, cell: NDArray[np.intp], probe: Array) -> NDArray[np.bool_]:
    """Which boxes have samples that keep to one half of them; `cell` is the samples' box, sorted."""
    found = np.zeros(len(box), bool)
    if not len(cell):
        return found
    first = np.flatnonzero(np.diff(cell, prepend=-1))
    count = np.diff(first, append=len(cell))
    upper = np.add.reduceat((probe >= _middle(box[cell])).astype(np.float64), first)
    share = upper / count[:, None]
    crowded = (np.abs(share - 0.5) > CROWDED - 0.5).any(axis=1)
    found[cell[first]] = crowded & (count >= CROWD)
    return found


def _middle(box: Array) -> Array:
    return np.asarray(np.stack([box[:, 0] + box[:, 1], box[:, 2] + box[:, 3]], -1) / 2)


def _follow(
    box: Array, cell: NDArray[np.intp], probe: Array, open_: NDArray[np.intp]
) -> tuple[Array, NDArray[np.intp]]:
    """The samples in boxes that are cut, and which of the new boxes each is in, sorted."""
    place = np.full(len(box), -1)
    place[open_] = np.arange(len(open_))
    kept = place[cell] >= 0
    cell, probe = cell[kept], probe[kept]
    side = probe >= _middle(box[cell])
    cell = 4 * place[cell] + side[:, 0] + 2 * side[:, 1]
    order = np.argsort(cell, kind="stable")
    return probe[order], cell[order]


def _split(box: Array) -> Array:
    """Every box in four, (4 n, 4)."""
    a, b, c, d = box.T
    e, g = 0.5 * (a + b), 0.5 * (c + d)
    quarters = [(a, e, c, g), (e, b, c, g), (a, e, g, d), (e, b, g, d)]
    return np.stack([np.stack(q, -1) for q in quarters], 1).reshape(-1, 4)


def lobatto(count: int) -> tuple[Array, Array]:
    """Nodes in [-1, 1] with both ends, and weights that add up to 2."""
    legendre = np.polynomial.Legendre.basis(count - 1)
    inner = np.sort(legendre.deriv().roots().real)
    x = np.concatenate([[-1.0], inner, [1.0]])
    return x, 2 / (count * (count - 1) * legendre(x) ** 2)


_X, _W = lobatto(NODES)
_X = _X * (1 - INSIDE)
# Place in the cell, and weight, of every node of one coordinate.
_NODES = np.stack([(_X + 1) / 2, _W / 2], axis=-1)


def _cells(
    subject: Subject,
    values: dict[str, Array],
    wo: Array,
    side: Array,
    point: NDArray[np.intp],
    box: Array,
    width: int,
) -> Array:
    """The integrals over cells by one rule each, (cells, width)."""
    each = NODES * NODES
    parts, together = [], dr.thread_count() * BATCH // each
    for start in range(0, len(box), together):
        part = slice(start, start + together)
        parts.append(
            _rule(subject, values, wo, side, point[part].astype(np.uint32), box[part], width)
        )
    return np.concatenate(parts)


def _rule(
    subject: Subject,
    values: dict[str, Array],
    wo: Array,
    side: Array,
    point: NDArray[np.uint32],
    box: Array,
    width: int,
) -> Array:
    each = NODES * NODES
    Float = number_type()
    UInt = dr.uint32_array_t(Float)
    boxes, nodes, viewers = (stored(Float, t.ravel()) for t in (box, _NODES, wo))
    points, sides = stored(UInt, point), stored(Float, side)

    def viewer(cell: Any) -> tuple[Any, Any]:
        """The index of a cell's point, and its wo."""
        index = dr.gather(UInt, points, cell)
        Vec = dr.replace_shape_t(Float, (3, -1))
        return index, Vec(*(dr.gather(Float, viewers, 3 * index + k) for k in range(3)))

    # Six nodes lie on one meridian
    row = dr.arange(UInt, len(box) * NODES)
    cell = row // NODES
    u0, u1, v0, v1 = (dr.gather(Float, boxes, 4 * cell + k) for k in range(4))
    _, wo_ = viewer(cell)
    m = _meridian(wo_, u0 + (u1 - u0) * dr.gather(Float, nodes, 2 * (row - cell * NODES)))
    m = m._replace(turn=m.turn * ((u1 - u0) * (v1 - v0)))
    dr.eval(m)
    lane = dr.arange(UInt, len(box) * each)
    cell, row = lane // each, lane // NODES
    node = lane - row * NODES
    v0, v1 = (dr.gather(Float, boxes, 4 * cell + k) for k in (2, 3))
    index, wo_ = viewer(cell)
    b = dr.gather(Float, nodes, 2 * node)
    m = Meridian(*(dr.gather(Float, column, row) for column in m))
    wi, solid = _down(wo_, m, v0 + (v1 - v0) * b, dr.gather(Float, sides, index))
    other = row - cell * NODES
    solid *= dr.gather(Float, nodes, 2 * node + 1) * dr.gather(Float, nodes, 2 * other + 1)
    # Kernels that know nothing of the model are the same for all
    dr.eval(index, wi, wo_, solid)
    model = subject.bound(gathered(values, index, Float), Float)
    f, pdf = (reflect_only(model, wi, wo_), None) if width == 3 else reflect(model, wi, wo_)
    cosine = dr.maximum(wi.z, 0)
    sums = [f.x * cosine, f.y * cosine, f.z * cosine]
    if pdf is not None:
        mean = (f.x + f.y + f.z) / 3
        reached = pdf > 0
        sums += [
            pdf,
            dr.select(reached, dr.square(mean * cosine) / dr.select(reached, pdf, 1), 0),
            np.pi * dr.square(mean) * cosine,
            dr.select(reached, 0, mean * cosine),
        ]
    totals = [dr.block_sum(s * solid, each) for s in sums]
    dr.eval(totals)
    return np.stack([t.numpy() for t in totals], -1)
