"""A model's method on flat Dr.Jit arrays, whatever framework they come from."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any, ClassVar, Protocol

import drjit as dr
import numpy as np

from gonio import backend
from gonio.arrays.leaf import Leaf, allowed, complaint
from gonio.fields import Parameter
from gonio.lang import Sample, vec3

DIRECTION_NAMES = {
    "eval": ("wi", "wo"),
    "pdf": ("wi", "wo"),
    "sample": ("wo", "u"),
    "albedo": ("wo",),
    "mean_albedo": (),
}


class Evaluated(Protocol):
    """What a kernel asks of a model; `gonio.model.Model` has it."""

    name: ClassVar[str]

    def parameters(self) -> Iterator[tuple[str, Parameter, Any]]:
        """Path, declaration and value of every parameter."""

    def bind(self, Float: Any, convert: Callable[[str, Parameter, Any], Any], *, keep: bool) -> Any:
        """A copy whose parameters are Dr.Jit values."""


class Kernel:
    """A model's method on flat Dr.Jit arrays: broadcasting, checks, evaluation, flattening."""

    def __init__(
        self, model: Evaluated, method: str, leaves: list[Leaf], slots: dict[str, int]
    ) -> None:
        """`slots` maps the paths of parameters that are arrays to their place in `leaves`."""
        self.model, self.method, self.leaves, self.slots = model, method, leaves, slots

    def batch_shape(self, shapes: Sequence[tuple[int, ...]]) -> tuple[int, ...]:
        """The common shape without the component, or a ValueError that names the misfit."""
        batches = [
            self._batch(leaf, shape) for leaf, shape in zip(self.leaves, shapes, strict=True)
        ]
        try:
            return np.broadcast_shapes(*batches)
        except ValueError:
            listing = ", ".join(
                f"{leaf.name} {tuple(s)}" for leaf, s in zip(self.leaves, shapes, strict=True)
            )
            raise ValueError(
                f"shapes do not broadcast (without the last axis of directions and colours): {listing}."
            ) from None

    @staticmethod
    def _batch(leaf: Leaf, shape: tuple[int, ...]) -> tuple[int, ...]:
        shape = tuple(shape)
        if leaf.width == 1:
            return shape
        if not shape or shape[-1] != leaf.width:
            grey = ", or (100, 1) for greys" if leaf.kind == "parameter" else ""
            raise ValueError(
                f"{leaf.name} has shape {shape}; its last axis must hold {leaf.width} components, "
                f"such as (100, {leaf.width}){grey}."
            )
        return shape[:-1]

    def evaluate(
        self, flats: Sequence[Any], shapes: Sequence[tuple[int, ...]], Float: Any
    ) -> tuple[list[Any], list[tuple[int, ...]], Any]:
        """Evaluate on flat Dr.Jit arrays.

        Returns the flat results (component fastest), their shapes, and an array with one number: that of
        a leaf (from 1) with a value that is not allowed, else 0 (None when validation is off).
        """
        batch = self.batch_shape(shapes)
        values = [
            _spread(flat, self._batch(leaf, shape), leaf.width, batch)
            for leaf, flat, shape in zip(self.leaves, flats, shapes, strict=True)
        ]
        flag = self._flag(values, Float) if backend.validating() else None
        bound = self.bind(Float, values)
        count = len(DIRECTION_NAMES[self.method])
        result = getattr(bound, self.method)(*values[:count])
        parts = list(result) if isinstance(result, Sample) else [result]
        if self.method in {"eval", "albedo", "mean_albedo"}:  # a Color, even if the model is grey
            parts = [dr.replace_shape_t(Float, (3, -1))(parts[0])]
        flat_results, result_shapes = [], []
        size = math.prod(batch)
        for part in parts:
            width = dr.size_v(part) if dr.depth_v(part) == 2 else 1
            wide = part + dr.zeros(type(part), shape=(width, size) if width > 1 else size)
            flat_results.append(dr.ravel(wide) if width > 1 else wide)
            result_shapes.append((*batch, width) if width > 1 else batch)
        return flat_results, result_shapes, flag

    def bind(self, Float: Any, values: Sequence[Any]) -> Any:
        """The model with the parameters that are arrays taken from the leaves' values."""

        def convert(path: str, parameter: Parameter, value: Any) -> Any:
            if path in self.slots:
                value = values[self.slots[path]]
                grey = self.leaves[self.slots[path]].width < parameter.width
                return vec3(value, value, value) if grey else value
            return opaque(Float, parameter.width, value)

        # Numbers alone: the bound model is kept, and its opaque numbers stay on the device.
        return self.model.bind(Float, convert, keep=not self.slots)

    def _flag(self, values: Sequence[Any], Float: Any) -> Any:
        UInt = dr.uint32_array_t(dr.detached_t(Float))
        wrong = UInt(0)
        for number, (leaf, value) in enumerate(zip(self.leaves, values, strict=True), 1):
            wrong = dr.select(allowed(leaf, dr.detach(value)), wrong, number)
        flag = dr.zeros(UInt, 1)
        dr.scatter(flag, wrong, UInt(0), active=wrong > 0)
        return flag

    def complain(self, flag: Any, arrays: Callable[[int], np.ndarray[Any, Any]]) -> None:
        """Raise a ValueError that shows the first value that is not allowed, if the flag is set."""
        if flag is not None and (number := int(flag[0])):
            raise ValueError(complaint(self.leaves[number - 1], arrays(number - 1)))


def opaque(Float: Any, width: int, value: Any) -> Any:
    """A number or triple as Dr.Jit values whose content is not compiled into kernels."""
    if not dr.is_jit_v(Float):
        Color = dr.scalar.Array3f64
        return float(value) if width == 1 else Color(value)
    if width == 1:
        return dr.opaque(Float, value)
    Color = dr.replace_shape_t(Float, (3, -1))
    numbers = value if isinstance(value, tuple) else (value,) * 3
    return Color(*(dr.opaque(Float, v) for v in numbers))


def _spread(flat: Any, shape: tuple[int, ...], width: int, batch: tuple[int, ...]) -> Any:
    """Gather a flat array (component fastest) into a Dr.Jit value that has the batch's shape.

    An array with one element stays one element wide, which Dr.Jit broadcasts by itself.
    """
    Flat = type(flat)
    UInt = dr.uint32_array_t(Flat)
    size = math.prod(batch)
    if math.prod(shape) == 1:
        index = UInt(0)
    elif shape == batch:
        if width == 1:
            return flat
        index = dr.arange(UInt, size)
    else:
        position, index, stride = dr.arange(UInt, size), UInt(0), 1
        shape = (1,) * (len(batch) - len(shape)) + shape
        for extent, full in zip(reversed(shape), reversed(batch), strict=True):
            if extent > 1:
                index += (position % full) * stride
                stride *= extent
            position //= full
    if width == 1:
        return dr.gather(Flat, flat, index)
    return dr.gather(dr.replace_shape_t(Flat, (width, -1)), flat, index)


def precision(values: Sequence[Any]) -> type[np.generic]:
    """float64 as soon as one array has it, else float32."""
    return np.float64 if any(str(v.dtype).endswith("float64") for v in values) else np.float32


def repack(kernel: Kernel, outputs: Sequence[Any]) -> Any:
    """The results of a method as it returns them: a `Sample`, or one array."""
    return Sample(*outputs) if kernel.method == "sample" else outputs[0]


def pull_back(
    kernel: Kernel,
    flats: Sequence[Any],
    shapes: Sequence[tuple[int, ...]],
    cotangents: Sequence[Any],
    Float: Any,
    wanted: Sequence[int] | None = None,
) -> list[Any]:
    """Flat gradients by all flat arrays, or the wanted ones, given those of the flat results."""
    flats = [dr.detach(flat) for flat in flats]  # else what was found before would be added
    numbers = range(len(flats)) if wanted is None else wanted
    for number in numbers:
        dr.enable_grad(flats[number])
    results, _, _ = kernel.evaluate(flats, shapes, Float)
    for result, cotangent in zip(results, cotangents, strict=True):
        dr.set_grad(result, cotangent)
    dr.enqueue(dr.ADMode.Backward, results)
    dr.traverse(dr.ADMode.Backward)
    # Where the results do not depend on an array, its gradient is one zero; give it its full size.
    return [dr.detach(dr.grad(flats[n]) + dr.zeros(Float, math.prod(shapes[n]))) for n in numbers]
