"""First and second derivatives of a kernel at every point, as arrays.

A model's method knows nothing of its neighbours: at every point it is a function of a few numbers to one,
three or four. Its derivatives there are small matrices, and with these the frameworks' own products make
forward mode, Hessians and derivatives of gradients. The first ones are exact, by Dr.Jit's reverse mode.
Dr.Jit does not differentiate twice: the second ones are differences of the first, in float64.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import drjit as dr

from gonio.arrays.kernel import Kernel, pull_back
from gonio.arrays.leaf import Leaf

# Half the distance of the points whose gradients are compared. A millionth leaves ten digits of a float64,
# and is a hundredth of the sharpest highlight's width: (h / 1e-4)^2 / 6 = 2e-5 of its second derivative.
STEP = 1e-6

# Cosine below which none are compared: the next one would lie below the horizon.
STEEP = 1e-6

REFUSAL = (
    "gonio has first and second derivatives only; for third ones take differences of second derivatives "
    "in float64."
)


def outputs(kernel: Kernel) -> tuple[int, ...]:
    """Numbers per point of each result."""
    return {"pdf": (1,), "sample": (3, 1)}.get(kernel.method, (3,))


def jacobian(
    kernel: Kernel, flats: Sequence[Any], batch: tuple[int, ...], wanted: Sequence[int], Float: Any
) -> list[Any]:
    """Derivatives of all numbers of the results by some leaves.

    Args:
        kernel: what is differentiated.
        flats: one flat array for each leaf, component fastest, all of the batch's full shape.
        batch: its shape.
        wanted: numbers of the leaves.
        Float: type of the arrays.

    Returns:
        For each wanted leaf a flat array of shape (*batch, results' numbers, leaf's width).
    """
    size = math.prod(batch)
    shapes = [(*batch, leaf.width) if leaf.width > 1 else batch for leaf in kernel.leaves]
    widths = outputs(kernel)
    count = sum(widths)
    found = [dr.zeros(Float, size * count * kernel.leaves[i].width) for i in wanted]
    for number in range(count):
        # Evaluated again for each: Dr.Jit finds what is the same
        gradients = pull_back(
            kernel, flats, shapes, list(_unit(number, widths, size, Float)), Float, wanted=wanted
        )
        for target, gradient, i in zip(found, gradients, wanted, strict=True):
            width = kernel.leaves[i].width
            place = dr.arange(dr.uint32_array_t(Float), size * width)
            point, component = place // width, place % width
            dr.scatter(target, gradient, (point * count + number) * width + component)
    dr.eval(found)
    return found


def _unit(number: int, widths: Sequence[int], size: int, Float: Any) -> Iterator[Any]:
    """Cotangents of the results that are 1 for one of a point's numbers."""
    first = 0
    for width in widths:
        place = dr.arange(dr.uint32_array_t(Float), size * width) % width + first
        yield dr.select(place == number, Float(1), Float(0))
        first += width


def hessian(
    kernel: Kernel, flats: Sequence[Any], batch: tuple[int, ...], wanted: Sequence[int], Float: Any
) -> list[list[Any]]:
    """Second derivatives of all numbers of the results by some leaves, of the type `Float`.

    Returns:
        For each wanted leaf a list with a flat array for each wanted leaf, of shape
        (*batch, results' numbers, first leaf's width, second leaf's width).
    """
    Wide = dr.float64_array_t(Float)
    flats = [Wide(flat) for flat in flats]
    size, count = math.prod(batch), sum(outputs(kernel))
    UInt = dr.uint32_array_t(Wide)
    found = [
        [
            dr.zeros(Float, size * count * kernel.leaves[i].width * kernel.leaves[j].width)
            for j in wanted
        ]
        for i in wanted
    ]
    steep = _steep(kernel, flats, size)
    for column, j in enumerate(wanted):
        width = kernel.leaves[j].width
        place = dr.arange(UInt, size * width)
        for component in range(width):
            here = dr.gather(Wide, flats[j], dr.arange(UInt, size) * width + component)
            nodes = _nodes(_bounded(kernel.leaves[j], component), here)
            sums = [dr.zeros(Wide, size * count * kernel.leaves[i].width) for i in wanted]
            for offset, weight in nodes:
                moved = list(flats)
                step = dr.gather(Wide, offset, place // width)
                moved[j] = flats[j] + dr.select(place % width == component, step, 0)
                dr.eval(moved)  # arrays in memory: one compiled kernel serves all columns
                first = jacobian(kernel, moved, batch, wanted, Wide)
                for row, i in enumerate(wanted):
                    each = count * kernel.leaves[i].width
                    points = dr.arange(UInt, size * each) // each
                    sums[row] += first[row] * dr.gather(Wide, weight, points)
            for row, i in enumerate(wanted):
                each = count * kernel.leaves[i].width
                index = dr.arange(UInt, size * each)
                value = dr.select(dr.gather(type(steep), steep, index // each), sums[row], 0)
                dr.scatter(found[row][column], Float(value), index * width + component)
            dr.eval(found)
    return found


def _bounded(leaf: Leaf, component: int) -> tuple[float, float]:
    """Where a component may be moved to: inside its range, and not across where derivatives end."""
    if leaf.kind == "direction":
        return (STEEP, math.inf) if component == 2 else (-math.inf, math.inf)
    return (0.0, 1.0) if leaf.kind == "random" else (leaf.low, leaf.high)


def _steep(kernel: Kernel, flats: Sequence[Any], size: int) -> Any:
    """Where all directions are high enough to have derivatives."""
    Wide = type(flats[0])
    mask = dr.full(dr.mask_t(Wide), True, size)
    for leaf, flat in zip(kernel.leaves, flats, strict=True):
        if leaf.kind == "direction":
            place = dr.arange(dr.uint32_array_t(Wide), size) * 3 + 2
            mask &= dr.gather(Wide, flat, place) > STEEP
    return mask


def _nodes(bounds: tuple[float, float], here: Any) -> list[tuple[Any, Any]]:
    """Offsets and weights of a difference of second order, one-sided near a bound."""
    low, high = bounds
    Wide = type(here)
    below, above = here - STEP < low, here + STEP > high
    full = dr.zeros(Wide, dr.width(here))
    unit = 1 / STEP

    def chosen(middle: float, upwards: float, downwards: float) -> Any:
        return full + dr.select(below, upwards, dr.select(above, downwards, middle))

    nodes = [
        (chosen(-STEP, STEP, -STEP), chosen(-0.5 * unit, 2 * unit, -2 * unit)),
        (chosen(STEP, 2 * STEP, -2 * STEP), chosen(0.5 * unit, -0.5 * unit, 0.5 * unit)),
    ]
    if dr.any(below | above):
        nodes.append((full, chosen(0, -1.5 * unit, 1.5 * unit)))
    return nodes
