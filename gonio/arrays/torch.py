"""PyTorch tensors in and out, with first and second derivatives in both modes."""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from typing import Any

import drjit as dr
import numpy as np

from gonio import backend
from gonio.arrays import derivatives
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
    _refuse_forward_over_forward()
    shapes = [tuple(t.shape) for t in tensors]
    batch = kernel.batch_shape(shapes)
    if math.prod(batch) == 0 or (device.type == "cpu" and backend.current() == "scalar"):
        if any(t.requires_grad for t in tensors):
            raise ValueError("gradients need the llvm or cuda backend and at least one element.")
        arrays = [t.detach().cpu().contiguous().numpy() for t in tensors]
        return repack(
            kernel, [torch.from_numpy(a).to(device) for a in run(kernel, arrays, shapes, dtype)]
        )
    return repack(kernel, _torch_function().apply(kernel, *tensors))


def _refuse_forward_over_forward() -> None:
    """Raise where PyTorch would say 0: it does not differentiate a node's forward mode forwards again."""
    from torch._C import _functorch

    stack = _functorch.get_interpreter_stack() or ()
    if sum(level.key() == _functorch.TransformType.Jvp for level in stack) > 1:
        raise NotImplementedError(
            "PyTorch cannot differentiate forwards twice through a function that is not its own; use "
            "torch.func.hessian, or jacrev or grad for one of the two."
        )


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

    def shapes_of(tensors: Sequence[Any]) -> list[tuple[int, ...]]:
        return [tuple(t.shape) for t in tensors]

    def full(kernel: Kernel, tensors: Sequence[Any]) -> tuple[list[Any], tuple[int, ...], Any]:
        """Flat arrays of the batch's whole shape, that shape, and their type."""
        batch = kernel.batch_shape(shapes_of(tensors))
        wide = [
            t.expand(*batch, leaf.width) if leaf.width > 1 else t.expand(batch)
            for leaf, t in zip(kernel.leaves, tensors, strict=True)
        ]
        flat, Float = flats(wide)
        return flat, batch, Float

    def batched(kernel: Kernel, dims: Any, tensors: Sequence[Any], size: int) -> list[Any]:
        """Tensors whose mapped axis is the first one, of equal rank: they broadcast then."""
        shapes = [
            tuple(t.shape if d is None else t.movedim(d, 0).shape[1:])
            for d, t in zip(dims, tensors, strict=True)
        ]
        rank = len(kernel.batch_shape(shapes))
        moved = []
        for leaf, shape, dim, tensor in zip(kernel.leaves, shapes, dims, tensors, strict=True):
            front = tensor.unsqueeze(0) if dim is None else tensor.movedim(dim, 0)
            missing = rank + (leaf.width > 1) - len(shape)
            moved.append(front.reshape(front.shape[0], *(1,) * missing, *shape))
        if all(dim is None for dim in dims):
            moved[0] = moved[0].expand(size, *moved[0].shape[1:])
        return moved

    def column(kernel: Kernel, number: int, tensor: Any) -> Any:
        """A leaf's tensor with its components as an axis of its own."""
        return tensor if kernel.leaves[number].width > 1 else tensor.unsqueeze(-1)

    def summed(kernel: Kernel, number: int, total: Any, tensor: Any) -> Any:
        """A gradient (..., width) at every point, for a leaf that is shared by some."""
        if kernel.leaves[number].width == 1:
            total = total.squeeze(-1)
        return total.sum_to_size(tensor.shape)

    class Hessian(torch.autograd.Function):  # type: ignore[misc]
        """Second derivatives at every point: of all leaves by all, row by row."""

        @staticmethod
        def forward(kernel: Kernel, wanted: tuple[int, ...], *tensors: Any) -> tuple[Any, ...]:
            flat, batch, Float = full(kernel, tensors)
            rows = derivatives.hessian(kernel, flat, batch, wanted, Float)
            dr.sync_thread()
            count = sum(derivatives.outputs(kernel))
            widths = [kernel.leaves[i].width for i in wanted]
            return tuple(
                block.torch().clone().reshape(*batch, count, i, j)
                for row, i in zip(rows, widths, strict=True)
                for block, j in zip(row, widths, strict=True)
            )

        @staticmethod
        def setup_context(ctx: Any, inputs: Any, output: Any) -> None:
            pass

        @staticmethod
        def backward(ctx: Any, *cotangents: Any) -> Any:
            raise NotImplementedError(derivatives.REFUSAL)

        @staticmethod
        def jvp(ctx: Any, *tangents: Any) -> Any:
            raise NotImplementedError(derivatives.REFUSAL)

        @staticmethod
        def vmap(info: Any, in_dims: Any, kernel: Kernel, wanted: Any, *tensors: Any) -> Any:
            moved = batched(kernel, in_dims[2:], tensors, info.batch_size)
            found = Hessian.apply(kernel, wanted, *moved)
            return found, (0,) * len(found)

    class Jacobian(torch.autograd.Function):  # type: ignore[misc]
        """First derivatives at every point, by the wanted leaves."""

        @staticmethod
        def forward(kernel: Kernel, wanted: tuple[int, ...], *tensors: Any) -> tuple[Any, ...]:
            flat, batch, Float = full(kernel, tensors)
            found = derivatives.jacobian(kernel, flat, batch, wanted, Float)
            dr.sync_thread()
            count = sum(derivatives.outputs(kernel))
            return tuple(
                f.torch().clone().reshape(*batch, count, kernel.leaves[i].width)
                for f, i in zip(found, wanted, strict=True)
            )

        @staticmethod
        def setup_context(ctx: Any, inputs: Any, output: Any) -> None:
            ctx.kernel, ctx.wanted, *tensors = inputs
            ctx.save_for_backward(*tensors)
            ctx.save_for_forward(*tensors)

        @staticmethod
        def backward(ctx: Any, *cotangents: Any) -> tuple[Any, ...]:
            kernel, tensors = ctx.kernel, ctx.saved_tensors
            moving = [i for i, needed in enumerate(ctx.needs_input_grad[2:]) if needed]
            both = tuple(sorted({*ctx.wanted, *moving}))
            blocks = Hessian.apply(kernel, both, *tensors)
            gradients: list[Any] = [None] * len(tensors)
            for j in moving:
                total: Any = 0
                for i, cotangent in zip(ctx.wanted, cotangents, strict=True):
                    block = blocks[both.index(i) * len(both) + both.index(j)]
                    total = total + (block * cotangent.unsqueeze(-1)).sum((-3, -2))
                gradients[j] = summed(kernel, j, total, tensors[j])
            return None, None, *gradients

        @staticmethod
        def jvp(ctx: Any, _: Any, __: Any, *tangents: Any) -> tuple[Any, ...]:
            kernel, tensors = ctx.kernel, ctx.saved_tensors
            moving = [j for j, t in enumerate(tangents) if t is not None]
            both = tuple(sorted({*ctx.wanted, *moving}))
            blocks = Hessian.apply(kernel, both, *tensors)
            changes = []
            for i in ctx.wanted:
                total: Any = 0
                for j in moving:
                    block = blocks[both.index(i) * len(both) + both.index(j)]
                    step = column(kernel, j, tangents[j])
                    total = total + (block * step.unsqueeze(-2).unsqueeze(-2)).sum(-1)
                changes.append(total)
            return tuple(changes)

        @staticmethod
        def vmap(info: Any, in_dims: Any, kernel: Kernel, wanted: Any, *tensors: Any) -> Any:
            moved = batched(kernel, in_dims[2:], tensors, info.batch_size)
            found = Jacobian.apply(kernel, wanted, *moved)
            return found, (0,) * len(found)

    class Node(torch.autograd.Function):  # type: ignore[misc]
        @staticmethod
        def forward(kernel: Kernel, *tensors: Any) -> tuple[Any, ...]:
            flat, Float = flats(tensors)
            results, result_shapes, flag = kernel.evaluate(flat, shapes_of(tensors), Float)
            dr.eval(results, flag)
            kernel.complain(flag, lambda place: tensors[place].detach().cpu().numpy())
            dr.sync_thread()
            return tuple(
                r.torch().clone().reshape(s) for r, s in zip(results, result_shapes, strict=True)
            )

        @staticmethod
        def setup_context(ctx: Any, inputs: Any, output: Any) -> None:
            ctx.kernel, *tensors = inputs
            ctx.save_for_backward(*tensors)
            ctx.save_for_forward(*tensors)

        @staticmethod
        def backward(ctx: Any, *cotangents: Any) -> tuple[Any, ...]:
            kernel, tensors = ctx.kernel, ctx.saved_tensors
            moving = tuple(i for i, needed in enumerate(ctx.needs_input_grad[1:]) if needed)
            gradients: list[Any] = [None] * len(tensors)
            if not torch.is_grad_enabled():  # nobody differentiates the gradients
                flat, Float = flats([*tensors, *cotangents])
                count = len(tensors)
                found = pull_back(
                    kernel, flat[:count], shapes_of(tensors), flat[count:], Float, wanted=moving
                )
                dr.eval(found)
                dr.sync_thread()
                for i, gradient in zip(moving, found, strict=True):
                    gradients[i] = gradient.torch().clone().reshape(tensors[i].shape)
                return None, *gradients
            rows = torch.cat(
                [
                    c if width > 1 else c.unsqueeze(-1)
                    for c, width in zip(cotangents, derivatives.outputs(kernel), strict=True)
                ],
                -1,
            )
            matrices = Jacobian.apply(kernel, moving, *tensors)
            for i, matrix in zip(moving, matrices, strict=True):
                total = (matrix * rows.unsqueeze(-1)).sum(-2)
                gradients[i] = summed(kernel, i, total, tensors[i])
            return None, *gradients

        @staticmethod
        def jvp(ctx: Any, _: Any, *tangents: Any) -> tuple[Any, ...]:
            kernel, tensors = ctx.kernel, ctx.saved_tensors
            moving = tuple(i for i, t in enumerate(tangents) if t is not None)
            total: Any = 0
            for i, matrix in zip(moving, Jacobian.apply(kernel, moving, *tensors), strict=True):
                total = total + (matrix * column(kernel, i, tangents[i]).unsqueeze(-2)).sum(-1)
            widths = derivatives.outputs(kernel)
            parts = total.split(widths, -1)
            return tuple(
                p if width > 1 else p.squeeze(-1) for p, width in zip(parts, widths, strict=True)
            )

        @staticmethod
        def vmap(info: Any, in_dims: Any, kernel: Kernel, *tensors: Any) -> Any:
            moved = batched(kernel, in_dims[1:], tensors, info.batch_size)
            found = Node.apply(kernel, *moved)
            return found, (0,) * len(found)

    return Node
