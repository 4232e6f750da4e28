"""Arrays in, the same kind out: NumPy, PyTorch, JAX and Dr.Jit around one kernel.

The component comes last, (..., 3), and everything broadcasts as in NumPy. Data enter Dr.Jit without a
copy where the frameworks allow it; broadcasting, the reordering of components and the checks of values
happen inside the model's own kernel, so that each array is read once.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import drjit as dr
import numpy as np

from gonio import backend
from gonio.lang import Sample, vec3

if TYPE_CHECKING:
    from gonio.model import Model, Parameter

# Accepted deviation of |w|² from 1: a hundred times the rounding of a float32 normalisation, and small
# enough that no model's value moves visibly.
UNIT_TOLERANCE = 1e-4


@dataclass(frozen=True)
class Leaf:
    """One array that goes into a kernel: what it is called, its width, and what is allowed in it."""

    name: str
    width: int
    kind: str
    """One of direction, random, parameter."""
    low: float = -math.inf
    high: float = math.inf


_DIRECTION_NAMES = {
    "eval": ("wi", "wo"),
    "pdf": ("wi", "wo"),
    "sample": ("wo", "u"),
    "albedo": ("wo",),
    "mean_albedo": (),
}


def is_array(value: Any) -> bool:
    """Whether a value is an array of a framework gonio knows (NumPy scalars and lists are not)."""
    return framework(value) is not None


def framework(value: Any) -> str | None:
    """Name of an array's framework (drjit, torch, jax, numpy), None for everything else."""
    if dr.is_array_v(value):
        return "drjit"
    if isinstance(value, np.ndarray):
        return "numpy"
    module = type(value).__module__.partition(".")[0]
    if module == "torch" and hasattr(value, "requires_grad"):
        return "torch"
    if module in {"jax", "jaxlib"} and hasattr(value, "dtype"):
        return "jax"
    return None


def call(model: Model, method: str, directions: Sequence[Any]) -> Any:
    """Evaluate a model's method on arrays of any framework and return the same kind.

    Raises:
        ValueError: wrong shapes; with validation on, also values that are not allowed.
    """
    leaves = [
        Leaf(name, 2 if name == "u" else 3, "random" if name == "u" else "direction")
        for name in _DIRECTION_NAMES[method]
    ]
    values = [
        v if is_array(v) else _from_numbers(v, leaf)
        for v, leaf in zip(directions, leaves, strict=True)
    ]
    slots: dict[str, int] = {}
    for path, declared, value in model.parameters():
        if is_array(value):
            width = declared.width
            if width == 3 and framework(value) != "drjit" and value.shape[-1:] == (1,):
                width, value = 1, value[..., 0]  # a grey colour, such as (100, 1)
            slots[path] = len(leaves)
            leaves.append(Leaf(path, width, "parameter", declared.lowest, declared.highest))
            values.append(value)
    kinds = {framework(v) for v in values}
    foreign = kinds - {"numpy"}
    if len(foreign) > 1:
        raise ValueError(
            f"{model.name}.{method} got arrays of {' and '.join(sorted(map(str, foreign)))} together; "
            "convert them to one framework."
        )
    kernel = Kernel(model, method, leaves, slots)
    kind = foreign.pop() if foreign else "numpy"
    return {"numpy": _call_numpy, "torch": _call_torch, "jax": _call_jax, "drjit": _call_drjit}[
        str(kind)
    ](kernel, values)


def _from_numbers(value: Any, leaf: Leaf) -> np.ndarray[Any, Any]:
    try:
        return np.asarray(value, np.float32)
    except (TypeError, ValueError):
        raise ValueError(
            f"{leaf.name} must be an array or numbers with {leaf.width} components last, "
            f"got {type(value).__name__}."
        ) from None


class Kernel:
    """A model's method on flat Dr.Jit arrays: broadcasting, checks, evaluation, flattening."""

    def __init__(
        self, model: Model, method: str, leaves: list[Leaf], slots: dict[str, int]
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
        bound = self._bind(Float, values)
        count = len(_DIRECTION_NAMES[self.method])
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

    def _bind(self, Float: Any, values: Sequence[Any]) -> Model:
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
            wrong = dr.select(_allowed(leaf, dr.detach(value)), wrong, number)
        flag = dr.zeros(UInt, 1)
        dr.scatter(flag, wrong, UInt(0), active=wrong > 0)
        return flag

    def complain(self, flag: Any, arrays: Callable[[int], np.ndarray[Any, Any]]) -> None:
        """Raise a ValueError that shows the first value that is not allowed, if the flag is set."""
        if flag is not None and (number := int(flag[0])):
            raise ValueError(_complaint(self.leaves[number - 1], arrays(number - 1)))


def _allowed(leaf: Leaf, value: Any) -> Any:
    """A mask that is true where a value is allowed; NaN fails every comparison."""
    if leaf.kind == "direction":
        return dr.abs(dr.squared_norm(value) - 1) <= UNIT_TOLERANCE
    low, high = (0, 1) if leaf.kind == "random" else (leaf.low, leaf.high)
    inside = (value >= low) & (value <= high)
    return inside if leaf.width == 1 else dr.all(inside, axis=0)


def _complaint(leaf: Leaf, array: np.ndarray[Any, Any]) -> str:
    """The sentence for the first value of `array` that is not allowed."""
    array = np.asarray(array, np.float64)
    if leaf.kind == "direction":
        with np.errstate(invalid="ignore", over="ignore"):
            bad = ~(np.abs(np.sum(array**2, -1) - 1) <= UNIT_TOLERANCE)
        index = tuple(int(i) for i in np.argwhere(bad)[0])
        w = array[index]
        at = f"{leaf.name}[{', '.join(map(str, index))}]" if index else leaf.name
        if not np.isfinite(w).all():
            return f"{at} = {w.tolist()} is not finite; directions are unit vectors."
        norm = float(np.linalg.norm(w))
        return (
            f"{at} = {w.tolist()} has length {norm:.6g}; directions are unit vectors: "
            f"divide by np.linalg.norm({leaf.name}, axis=-1, keepdims=True)."
        )
    low, high = (0.0, 1.0) if leaf.kind == "random" else (leaf.low, leaf.high)
    bad = ~((array >= low) & (array <= high))
    index = tuple(int(i) for i in np.argwhere(bad)[0])
    at = f"{leaf.name}[{', '.join(map(str, index))}]" if index else leaf.name
    allowed = f"{low:.7g} to {high:.7g}" if math.isfinite(high) else f"at least {low:g}"
    return f"{at} = {float(array[index])!r} is out of range; allowed is {allowed}."


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


def _precision(values: Sequence[Any]) -> type[np.generic]:
    """float64 as soon as one array has it, else float32."""
    return np.float64 if any(str(v.dtype).endswith("float64") for v in values) else np.float32


def _repack(kernel: Kernel, outputs: Sequence[Any]) -> Any:
    return Sample(*outputs) if kernel.method == "sample" else outputs[0]


def _call_numpy(kernel: Kernel, values: Sequence[Any]) -> Any:
    dtype = _precision(values)
    arrays = [np.ascontiguousarray(v, dtype) for v in values]
    shapes = [v.shape for v in values]  # ascontiguousarray makes 0-d arrays 1-d
    return _repack(kernel, _run(kernel, arrays, shapes, dtype))


def _run(
    kernel: Kernel,
    arrays: Sequence[np.ndarray[Any, Any]],
    shapes: Sequence[tuple[int, ...]],
    dtype: type[np.generic],
) -> list[np.ndarray[Any, Any]]:
    module = backend.array_module()
    if module is dr.scalar:
        return _run_scalar(kernel, arrays, shapes, dtype)
    Float = module.Float if dtype is np.float32 else module.Float64
    if math.prod(kernel.batch_shape(shapes)) == 0:
        return _empty(kernel, shapes, dtype)
    flats = [Float(a.reshape(-1)) for a in arrays]
    results, result_shapes, flag = kernel.evaluate(flats, shapes, Float)
    dr.eval(results, flag)
    kernel.complain(flag, lambda place: arrays[place].reshape(shapes[place]))
    # NumPy keeps the results' memory alive; nobody else refers to it.
    return [r.numpy().reshape(s) for r, s in zip(results, result_shapes, strict=True)]


def _empty(
    kernel: Kernel, shapes: Sequence[tuple[int, ...]], dtype: type[np.generic]
) -> list[np.ndarray[Any, Any]]:
    batch = kernel.batch_shape(shapes)
    widths = {"pdf": (1,), "sample": (3, 1)}.get(kernel.method, (3,))
    return [np.zeros((*batch, w) if w > 1 else batch, dtype) for w in widths]


def _run_scalar(
    kernel: Kernel,
    arrays: Sequence[np.ndarray[Any, Any]],
    shapes: Sequence[tuple[int, ...]],
    dtype: type[np.generic],
) -> list[np.ndarray[Any, Any]]:
    """One element after the other in plain Python: slow, but it needs no compiler."""
    batch = kernel.batch_shape(shapes)
    spread = []
    for leaf, array, shape in zip(kernel.leaves, arrays, shapes, strict=True):
        array = array.reshape(shape)
        if backend.validating():
            value = array if leaf.width == 1 else np.moveaxis(array, -1, 0)
            if leaf.kind == "direction":
                with np.errstate(invalid="ignore", over="ignore"):
                    good = np.abs((value.astype(np.float64) ** 2).sum(0) - 1) <= UNIT_TOLERANCE
            else:
                low, high = (0, 1) if leaf.kind == "random" else (leaf.low, leaf.high)
                good = (value >= low) & (value <= high)
            if not good.all():
                raise ValueError(_complaint(leaf, array))
        spread.append(np.broadcast_to(array, (*batch, leaf.width) if leaf.width > 1 else batch))
    outputs = _empty(kernel, shapes, dtype)
    types = {1: float, 2: dr.scalar.Array2f64, 3: dr.scalar.Array3f64}
    count = len(_DIRECTION_NAMES[kernel.method])
    for index in np.ndindex(batch):
        values = [
            types[leaf.width](a[index].tolist())
            for leaf, a in zip(kernel.leaves, spread, strict=True)
        ]
        bound = kernel._bind(float, values)
        result = getattr(bound, kernel.method)(*values[:count])
        for output, part in zip(
            outputs, result if isinstance(result, Sample) else (result,), strict=True
        ):
            output[index] = part
    return outputs


def _call_torch(kernel: Kernel, values: Sequence[Any]) -> Any:
    import torch

    dtype = _precision(values)
    device = next(v.device for v in values if framework(v) == "torch")
    tensors = [
        torch.as_tensor(v).to(
            device=device, dtype=torch.float64 if dtype is np.float64 else torch.float32
        )
        for v in values
    ]
    shapes = [tuple(t.shape) for t in tensors]
    batch = kernel.batch_shape(shapes)
    if math.prod(batch) == 0 or (device.type == "cpu" and backend.current() == "scalar"):
        if any(t.requires_grad for t in tensors):
            raise ValueError("gradients need the llvm or cuda backend and at least one element.")
        arrays = [t.detach().cpu().contiguous().numpy() for t in tensors]
        return _repack(
            kernel, [torch.from_numpy(a).to(device) for a in _run(kernel, arrays, shapes, dtype)]
        )
    return _repack(kernel, _torch_function().apply(kernel, shapes, *tensors))


@functools.cache
def _torch_function() -> Any:
    """The autograd node around a kernel.

    Dr.Jit's own bridge (`dr.wrap`) keeps one recorded graph, and a second backward pass through it,
    as `torch.autograd.functional.jacobian` makes, silently returns the first one's gradients. This
    node evaluates the kernel again for every backward pass instead.
    """
    import torch

    def flats(tensors: Sequence[Any]) -> tuple[list[Any], Any]:
        # A tensor decides the device, whatever backend NumPy arrays use.
        module = backend.array_module("cuda" if tensors[0].is_cuda else "llvm")
        Float = module.Float if tensors[0].dtype == torch.float32 else module.Float64
        if tensors[0].is_cuda:
            torch.cuda.current_stream().synchronize()
        return [Float(t.detach().contiguous().reshape(-1)) for t in tensors], Float

    class Pull(torch.autograd.Function):  # type: ignore[misc]
        """The backward pass as a node of its own, which torch.func asks for."""

        @staticmethod
        def forward(kernel: Kernel, shapes: Any, *tensors: Any) -> tuple[Any, ...]:
            flat, Float = flats(tensors)
            gradients = _pull_back(kernel, flat[: len(shapes)], shapes, flat[len(shapes) :], Float)
            dr.sync_thread()
            return tuple(
                g.torch().clone().reshape(s) for g, s in zip(gradients, shapes, strict=True)
            )

        @staticmethod
        def setup_context(ctx: Any, inputs: Any, output: Any) -> None:
            pass

        @staticmethod
        def backward(ctx: Any, *cotangents: Any) -> Any:
            raise NotImplementedError("gonio has first derivatives only.")

    class Node(torch.autograd.Function):  # type: ignore[misc]
        @staticmethod
        def forward(kernel: Kernel, shapes: Any, *tensors: Any) -> tuple[Any, ...]:
            flat, Float = flats(tensors)
            results, result_shapes, flag = kernel.evaluate(flat, shapes, Float)
            dr.eval(results, flag)
            kernel.complain(flag, lambda place: tensors[place].detach().cpu().numpy())
            dr.sync_thread()
            return tuple(
                r.torch().clone().reshape(s) for r, s in zip(results, result_shapes, strict=True)
            )

        @staticmethod
        def setup_context(ctx: Any, inputs: Any, output: Any) -> None:
            ctx.kernel, ctx.shapes, *tensors = inputs
            ctx.save_for_backward(*tensors)

        @staticmethod
        def backward(ctx: Any, *cotangents: Any) -> tuple[Any, ...]:
            gradients = Pull.apply(ctx.kernel, ctx.shapes, *ctx.saved_tensors, *cotangents)
            return None, None, *gradients

    return Node


def _call_jax(kernel: Kernel, values: Sequence[Any]) -> Any:
    import jax
    import jax.numpy as jnp

    dtype = _precision(values)
    # Under vmap every input gains a leading axis at the same place, so all ranks have to agree.
    shapes = [tuple(np.shape(v)) for v in values]
    rank = len(kernel.batch_shape(shapes))
    inputs = []
    for leaf, value in zip(kernel.leaves, values, strict=True):
        array = jnp.asarray(value, dtype)
        missing = rank + (leaf.width > 1) - array.ndim
        inputs.append(array.reshape((1,) * missing + array.shape))

    def primal(*arrays: Any) -> Any:
        batch = kernel.batch_shape([a.shape for a in arrays])
        widths = {"pdf": (1,), "sample": (3, 1)}.get(kernel.method, (3,))
        results = [jax.ShapeDtypeStruct((*batch, w) if w > 1 else batch, dtype) for w in widths]
        return jax.pure_callback(
            lambda *host: _run(
                kernel,
                [np.ascontiguousarray(h, dtype) for h in host],
                [np.shape(h) for h in host],
                dtype,
            ),
            results,
            *arrays,
            vmap_method="expand_dims",
        )

    def pullback(arrays: Any, cotangents: Any) -> Any:
        def host(*flat: Any) -> Any:
            module = backend.array_module()
            if module is dr.scalar:
                raise ValueError("gradients need the llvm or cuda backend.")
            Float = module.Float if dtype is np.float32 else module.Float64
            numbers = [Float(np.ascontiguousarray(f, dtype).reshape(-1)) for f in flat]
            shapes = [np.shape(f) for f in flat[: len(inputs)]]
            gradients = _pull_back(
                kernel, numbers[: len(inputs)], shapes, numbers[len(inputs) :], Float
            )
            return [g.numpy().reshape(s) for g, s in zip(gradients, shapes, strict=True)]

        shapes_ = [jax.ShapeDtypeStruct(a.shape, dtype) for a in arrays]
        return tuple(
            jax.pure_callback(host, shapes_, *arrays, *cotangents, vmap_method="sequential")
        )

    function = jax.custom_vjp(primal)
    function.defvjp(lambda *arrays: (primal(*arrays), arrays), pullback)
    return _repack(kernel, function(*inputs))


def _pull_back(
    kernel: Kernel,
    flats: Sequence[Any],
    shapes: Sequence[tuple[int, ...]],
    cotangents: Sequence[Any],
    Float: Any,
) -> list[Any]:
    """Evaluated flat gradients with respect to flat arrays, given those of the flat results."""
    dr.enable_grad(flats)
    results, _, _ = kernel.evaluate(flats, shapes, Float)
    for result, cotangent in zip(results, cotangents, strict=True):
        dr.set_grad(result, cotangent)
    dr.enqueue(dr.ADMode.Backward, results)
    dr.traverse(dr.ADMode.Backward)
    # Where the results do not depend on an array, its gradient is one zero; give it its full size.
    gradients = [
        dr.grad(flat) + dr.zeros(Float, math.prod(shape))
        for flat, shape in zip(flats, shapes, strict=True)
    ]
    gradients = [dr.detach(g) for g in gradients]
    dr.eval(gradients)
    return gradients


def _call_drjit(kernel: Kernel, values: Sequence[Any]) -> Any:
    """Dr.Jit arrays pass straight through: nothing is evaluated, copied or checked here."""
    native = next(v for v in values if framework(v) == "drjit")
    Number = type(native)
    while dr.depth_v(Number) > 1:
        Number = dr.value_t(Number)
    Float = Number if dr.is_jit_v(Number) else float
    converted = [
        v if framework(v) == "drjit" else _from_numpy(v, leaf, Number)
        for v, leaf in zip(values, kernel.leaves, strict=True)
    ]
    converted = [
        dr.replace_shape_t(Float, (leaf.width, -1))(v)
        if leaf.width > 1 and Float is not float
        else v
        for v, leaf in zip(converted, kernel.leaves, strict=True)
    ]
    bound = kernel._bind(Float, converted)
    return getattr(bound, kernel.method)(*converted[: len(_DIRECTION_NAMES[kernel.method])])


def _from_numpy(value: np.ndarray[Any, Any], leaf: Leaf, Number: Any) -> Any:
    if leaf.width == 1:
        return Number(value.reshape(-1))
    columns = np.moveaxis(value, -1, 0).reshape(leaf.width, -1)
    return dr.replace_shape_t(Number, (leaf.width, -1))(
        *(Number(np.ascontiguousarray(c)) for c in columns)
    )
