"""PyTorch tensors in and out, with first and second derivatives in both modes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from gonio import backend
from gonio.arrays.kernel import Kernel, precision, repack
from gonio.arrays.numpy import run
from gonio.fields import framework


def call_torch(kernel: Kernel, values: Sequence[Any]) -> Any:
    """Evaluate a kernel on PyTorch tensors, on the device they are on."""
    import torch

    from gonio.arrays import torch_nodes

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
    return repack(kernel, torch_nodes.values(kernel, *tensors))


def _refuse_forward_over_forward() -> None:
    """Raise where PyTorch would say 0: it does not differentiate a node's forward mode forwards again."""
    from torch._C import _functorch

    stack = _functorch.get_interpreter_stack() or ()
    if sum(level.key() == _functorch.TransformType.Jvp for level in stack) > 1:
        raise NotImplementedError(
            "PyTorch cannot differentiate forwards twice through a function that is not its own; use "
            "torch.func.hessian, or jacrev or grad for one of the two."
        )
