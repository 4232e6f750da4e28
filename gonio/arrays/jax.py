"""JAX arrays in and out, with first derivatives, under jit and vmap."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import drjit as dr
import numpy as np

from gonio import backend
from gonio.arrays.kernel import Kernel, precision, pull_back, repack
from gonio.arrays.numpy import run


def call_jax(kernel: Kernel, values: Sequence[Any]) -> Any:
    """Evaluate a kernel on JAX arrays, through a callback on the host."""
    import jax
    import jax.numpy as jnp

    dtype = precision(values)
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
            lambda *host: run(
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
            gradients = pull_back(
                kernel, numbers[: len(inputs)], shapes, numbers[len(inputs) :], Float
            )
            return [g.numpy().reshape(s) for g, s in zip(gradients, shapes, strict=True)]

        shapes_ = [jax.ShapeDtypeStruct(a.shape, dtype) for a in arrays]
        return tuple(
            jax.pure_callback(host, shapes_, *arrays, *cotangents, vmap_method="sequential")
        )

    function = jax.custom_vjp(primal)
    function.defvjp(lambda *arrays: (primal(*arrays), arrays), pullback)
    return repack(kernel, function(*inputs))
