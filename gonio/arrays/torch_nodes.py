"""PyTorch's autograd nodes around a kernel: its values, first and second derivatives.

Dr.Jit's own bridge (`dr.wrap`) keeps one recorded graph, and a second backward pass through it, as
`torch.autograd.functional.jacobian` makes, silently returns the first one's gradients. These nodes evaluate
the kernel again for every backward pass instead: `_Values` is differentiated by `_Jacobian`,
and that by `_Hessian`.

Imports PyTorch, so that it is imported only where tensors come.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import drjit as dr
import torch

from gonio import backend
from gonio.arrays import derivatives
from gonio.arrays.kernel import Kernel, pull_back


def values(kernel: Kernel, *tensors: Any) -> tuple[Any, ...]:
    """What a kernel gives for tensors, as a node of PyTorch's graph."""
    results: tuple[Any, ...] = _Values.apply(kernel, *tensors)
    return results


def _flats(tensors: Sequence[Any]) -> tuple[list[Any], Any]:
    # A tensor decides the device, whatever backend NumPy arrays use.
    module = backend.array_module("cuda" if tensors[0].is_cuda else "llvm")
    Float = module.Float if tensors[0].dtype == torch.float32 else module.Float64
    if tensors[0].is_cuda:
        torch.cuda.current_stream().synchronize()
    return [Float(t.detach().contiguous().reshape(-1)) for t in tensors], Float


def _shapes_of(tensors: Sequence[Any]) -> list[tuple[int, ...]]:
    return [tuple(t.shape) for t in tensors]


def _full(kernel: Kernel, tensors: Sequence[Any]) -> tuple[list[Any], tuple[int, ...], Any]:
    """Flat arrays of the batch's whole shape, that shape, and their type."""
    batch = kernel.batch_shape(_shapes_of(tensors))
    wide = [
        t.expand(*batch, leaf.width) if leaf.width > 1 else t.expand(batch)
        for leaf, t in zip(kernel.leaves, tensors, strict=True)
    ]
    flat, Float = _flats(wide)
    return flat, batch, Float


def _batched(kernel: Kernel, dims: Any, tensors: Sequence[Any], size: int) -> list[Any]:
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


def _column(kernel: Kernel, number: int, tensor: Any) -> Any:
    """A leaf's tensor with its components as an axis of its own."""
    return tensor if kernel.leaves[number].width > 1 else tensor.unsqueeze(-1)


def _summed(kernel: Kernel, number: int, total: Any, tensor: Any) -> Any:
    """A gradient (..., width) at every point, for a leaf that is shared by some."""
    if kernel.leaves[number].width == 1:
        total = total.squeeze(-1)
    return total.sum_to_size(tensor.shape)


class _Hessian(torch.autograd.Function):  # type: ignore[misc]
    """Second derivatives at every point: of all leaves by all, row by row."""

    @staticmethod
    def forward(kernel: Kernel, wanted: tuple[int, ...], *tensors: Any) -> tuple[Any, ...]:
        flat, batch, Float = _full(kernel, tensors)
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
        moved = _batched(kernel, in_dims[2:], tensors, info.batch_size)
        found = _Hessian.apply(kernel, wanted, *moved)
        return found, (0,) * len(found)


class _Jacobian(torch.autograd.Function):  # type: ignore[misc]
    """First derivatives at every point, by the wanted leaves."""

    @staticmethod
    def forward(kernel: Kernel, wanted: tuple[int, ...], *tensors: Any) -> tuple[Any, ...]:
        flat, batch, Float = _full(kernel, tensors)
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
        blocks = _Hessian.apply(kernel, both, *tensors)
        gradients: list[Any] = [None] * len(tensors)
        for j in moving:
            total: Any = 0
            for i, cotangent in zip(ctx.wanted, cotangents, strict=True):
                block = blocks[both.index(i) * len(both) + both.index(j)]
                total = total + (block * cotangent.unsqueeze(-1)).sum((-3, -2))
            gradients[j] = _summed(kernel, j, total, tensors[j])
        return None, None, *gradients

    @staticmethod
    def jvp(ctx: Any, _: Any, __: Any, *tangents: Any) -> tuple[Any, ...]:
        kernel, tensors = ctx.kernel, ctx.saved_tensors
        moving = [j for j, t in enumerate(tangents) if t is not None]
        both = tuple(sorted({*ctx.wanted, *moving}))
        blocks = _Hessian.apply(kernel, both, *tensors)
        changes = []
        for i in ctx.wanted:
            total: Any = 0
            for j in moving:
                block = blocks[both.index(i) * len(both) + both.index(j)]
                step = _column(kernel, j, tangents[j])
                total = total + (block * step.unsqueeze(-2).unsqueeze(-2)).sum(-1)
            changes.append(total)
        return tuple(changes)

    @staticmethod
    def vmap(info: Any, in_dims: Any, kernel: Kernel, wanted: Any, *tensors: Any) -> Any:
        moved = _batched(kernel, in_dims[2:], tensors, info.batch_size)
        found = _Jacobian.apply(kernel, wanted, *moved)
        return found, (0,) * len(found)


class _Values(torch.autograd.Function):  # type: ignore[misc]
    """What a kernel gives. Gradients that nobody differentiates again are pulled back without matrices."""

    @staticmethod
    def forward(kernel: Kernel, *tensors: Any) -> tuple[Any, ...]:
        flat, Float = _flats(tensors)
        results, result_shapes, flag = kernel.evaluate(flat, _shapes_of(tensors), Float)
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
            flat, Float = _flats([*tensors, *cotangents])
            count = len(tensors)
            found = pull_back(
                kernel, flat[:count], _shapes_of(tensors), flat[count:], Float, wanted=moving
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
        matrices = _Jacobian.apply(kernel, moving, *tensors)
        for i, matrix in zip(moving, matrices, strict=True):
            total = (matrix * rows.unsqueeze(-1)).sum(-2)
            gradients[i] = _summed(kernel, i, total, tensors[i])
        return None, *gradients

    @staticmethod
    def jvp(ctx: Any, _: Any, *tangents: Any) -> tuple[Any, ...]:
        kernel, tensors = ctx.kernel, ctx.saved_tensors
        moving = tuple(i for i, t in enumerate(tangents) if t is not None)
        total: Any = 0
        for i, matrix in zip(moving, _Jacobian.apply(kernel, moving, *tensors), strict=True):
            total = total + (matrix * _column(kernel, i, tangents[i]).unsqueeze(-2)).sum(-1)
        widths = derivatives.outputs(kernel)
        parts = total.split(widths, -1)
        return tuple(
            p if width > 1 else p.squeeze(-1) for p, width in zip(parts, widths, strict=True)
        )

    @staticmethod
    def vmap(info: Any, in_dims: Any, kernel: Kernel, *tensors: Any) -> Any:
        moved = _batched(kernel, in_dims[1:], tensors, info.batch_size)
        found = _Values.apply(kernel, *moved)
        return found, (0,) * len(found)
