"""PyTorch tensors in and out, with first derivatives."""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from typing import Any

import drjit as dr
import numpy as np

from gonio import backend
from gonio.arrays.kernel import Kernel, precision, pull_back, repack
from gonio.arrays.numpy import run
from gonio.fields import framework


def call_torch(kernel: Kernel, values: Sequence[Any]) -> Any:
    """Evaluate a kernel on PyTorch tensors, on the device they are on."""
    import torch

    dtype = precision(values)
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
        return repack(
            kernel, [torch.from_numpy(a).to(device) for a in run(kernel, arrays, shapes, dtype)]
        )
    return repack(kernel, _torch_function().apply(kernel, shapes, *tensors))


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

    def batched(kernel: Kernel, shapes: Any, dims: Any, tensors: Sequence[Any]) -> tuple[Any, Any]:
        """Shapes and tensors whose mapped axis is the first one, of equal rank: they broadcast then."""
        rank = len(kernel.batch_shape(shapes))
        moved = []
        for leaf, shape, dim, tensor in zip(kernel.leaves, shapes, dims, tensors, strict=True):
            front = tensor.unsqueeze(0) if dim is None else tensor.movedim(dim, 0)
            missing = rank + (leaf.width > 1) - len(shape)
            moved.append(front.reshape(front.shape[0], *(1,) * missing, *shape))
        return [tuple(t.shape) for t in moved], moved

    class Pull(torch.autograd.Function):  # type: ignore[misc]
        """The backward pass as a node of its own, which torch.func asks for."""

        @staticmethod
        def forward(kernel: Kernel, shapes: Any, *tensors: Any) -> tuple[Any, ...]:
            flat, Float = flats(tensors)
            gradients = pull_back(kernel, flat[: len(shapes)], shapes, flat[len(shapes) :], Float)
            dr.sync_thread()
            return tuple(
                g.torch().clone().reshape(s) for g, s in zip(gradients, shapes, strict=True)
            )

        @staticmethod
        def setup_context(ctx: Any, inputs: Any, output: Any) -> None:
            pass

        @staticmethod
        def backward(ctx: Any, *cotangents: Any) -> Any:
            raise NotImplementedError(
                "gonio has first derivatives only; for second ones take differences of first derivatives "
                "in float64."
            )

        @staticmethod
        def vmap(info: Any, in_dims: Any, kernel: Kernel, shapes: Any, *tensors: Any) -> Any:
            count = len(shapes)
            _, moved = batched(kernel, shapes, in_dims[2 : 2 + count], tensors[:count])
            size = info.batch_size
            full = [t.expand(size, *t.shape[1:]) for t in moved]
            shapes = [tuple(t.shape) for t in full]
            cotangents = [
                t.unsqueeze(0).expand(size, *t.shape) if d is None else t.movedim(d, 0)
                for t, d in zip(tensors[count:], in_dims[2 + count :], strict=True)
            ]
            found = Pull.apply(kernel, shapes, *full, *(c.contiguous() for c in cotangents))
            like = zip(found, tensors[:count], in_dims[2 : 2 + count], strict=True)
            return tuple(
                g.reshape(size, *(t.shape if d is None else t.movedim(d, 0).shape[1:]))
                for g, t, d in like
            ), (0,) * count

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

        @staticmethod
        def vmap(info: Any, in_dims: Any, kernel: Kernel, shapes: Any, *tensors: Any) -> Any:
            mapped, moved = batched(kernel, shapes, in_dims[2:], tensors)
            found = Node.apply(kernel, mapped, *moved)
            return found, (0,) * len(found)

    return Node
