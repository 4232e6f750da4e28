"""JAX arrays in and out, with first and second derivatives in both modes, under jit and vmap."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import drjit as dr
import numpy as np

from gonio import backend
from gonio.arrays import derivatives
from gonio.arrays.kernel import Kernel, precision, repack
from gonio.arrays.numpy import run


def call_jax(kernel: Kernel, values: Sequence[Any]) -> Any:
    """Evaluate a kernel on JAX arrays, through a callback on the host."""
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
    return repack(kernel, _Differentiated(kernel, dtype).value(*inputs))


class _Differentiated:
    """A kernel's values, and its derivatives at every point, each with the rule that gives the next."""

    def __init__(self, kernel: Kernel, dtype: type[np.generic]) -> None:
        import jax

        self.kernel, self.dtype = kernel, dtype
        self.value: Any = jax.custom_jvp(self._value)
        self.value.defjvp(self._value_jvp, symbolic_zeros=True)

    def _value(self, *arrays: Any) -> Any:
        batch = self.kernel.batch_shape([a.shape for a in arrays])
        shapes = [(*batch, w) if w > 1 else batch for w in derivatives.outputs(self.kernel)]

        def host(*given: Any) -> Any:
            found = [np.ascontiguousarray(g, self.dtype) for g in given]
            return run(self.kernel, found, [np.shape(g) for g in given], self.dtype)

        return self._callback(host, shapes, arrays)

    def _value_jvp(self, arrays: Any, tangents: Any) -> Any:
        import jax

        wanted = self._moving(tangents)
        results = self.value(*arrays)
        if not wanted:
            return results, [jax.numpy.zeros_like(r) for r in results]
        first: Any = jax.custom_jvp(lambda *a: self._jacobian(wanted, *a))
        first.defjvp(lambda a, t: self._jacobian_jvp(first, wanted, a, t), symbolic_zeros=True)
        moved = 0
        for i, matrix in zip(wanted, first(*arrays), strict=True):
            tangent = tangents[i] if self.kernel.leaves[i].width > 1 else tangents[i][..., None]
            moved = moved + (matrix * tangent[..., None, :]).sum(-1)
        parts, begin = [], 0
        for width in derivatives.outputs(self.kernel):
            part = moved[..., begin : begin + width]  # type: ignore[index]
            parts.append(part if width > 1 else part[..., 0])
            begin += width
        return results, parts

    def _jacobian(self, wanted: Sequence[int], *arrays: Any) -> Any:
        batch = self.kernel.batch_shape([a.shape for a in arrays])
        count = sum(derivatives.outputs(self.kernel))
        shapes = [(*batch, count, self.kernel.leaves[i].width) for i in wanted]

        def host(*given: Any) -> Any:
            found = derivatives.jacobian(self.kernel, *self._full(given), wanted, self._type())
            return [f.numpy() for f in found]

        return self._callback(host, shapes, arrays)

    def _jacobian_jvp(self, first: Any, wanted: Sequence[int], arrays: Any, tangents: Any) -> Any:
        """Derivatives by the leaves that move, of the first ones by the wanted leaves."""
        import jax

        moving = self._moving(tangents)
        matrices = first(*arrays)
        if not moving:
            return matrices, [jax.numpy.zeros_like(m) for m in matrices]
        both = sorted({*wanted, *moving})
        second: Any = jax.custom_jvp(lambda *a: self._hessian(both, *a))

        def refuse(_: Any, __: Any) -> Any:
            raise NotImplementedError(derivatives.REFUSAL)

        second.defjvp(refuse)
        blocks = second(*arrays)
        changes = []
        for i in wanted:
            total: Any = 0
            for j in moving:
                block = blocks[both.index(i) * len(both) + both.index(j)]
                wide = self.kernel.leaves[j].width > 1
                tangent = tangents[j] if wide else tangents[j][..., None]
                total = total + (block * tangent[..., None, None, :]).sum(-1)
            changes.append(total)
        return matrices, changes

    def _hessian(self, wanted: Sequence[int], *arrays: Any) -> Any:
        batch = self.kernel.batch_shape([a.shape for a in arrays])
        count = sum(derivatives.outputs(self.kernel))
        widths = [self.kernel.leaves[i].width for i in wanted]
        shapes = [(*batch, count, i, j) for i in widths for j in widths]

        def host(*given: Any) -> Any:
            found = derivatives.hessian(self.kernel, *self._full(given), wanted, self._type())
            return [block.numpy() for row in found for block in row]

        return self._callback(host, shapes, arrays)

    def _callback(self, host: Callable[..., Any], shapes: Sequence[Any], arrays: Any) -> Any:
        """Results of a function on NumPy arrays, one flat or shaped array for each of the shapes."""
        import jax

        # Under vmap the arrays on the host have more axes than the ones that are traced
        inner = len(self.kernel.batch_shape([a.shape for a in arrays]))

        def shaped(*given: Any) -> Any:
            batch = self.kernel.batch_shape([np.shape(g) for g in given])
            wanted = [(*batch, *shape[inner:]) for shape in shapes]
            if math.prod(batch) == 0:
                return [np.zeros(shape, self.dtype) for shape in wanted]
            return [
                np.reshape(found, shape).astype(self.dtype, copy=False)
                for found, shape in zip(host(*given), wanted, strict=True)
            ]

        results = [jax.ShapeDtypeStruct(shape, self.dtype) for shape in shapes]
        return jax.pure_callback(shaped, results, *arrays, vmap_method="expand_dims")

    def _full(self, given: Sequence[Any]) -> tuple[list[Any], tuple[int, ...]]:
        """Flat Dr.Jit arrays of the batch's whole shape, and that shape."""
        batch = self.kernel.batch_shape([np.shape(g) for g in given])
        flats = []
        for leaf, array in zip(self.kernel.leaves, given, strict=True):
            shape = (*batch, leaf.width) if leaf.width > 1 else batch
            full = np.broadcast_to(np.asarray(array, self.dtype), shape)
            flats.append(self._type()(np.ascontiguousarray(full).reshape(-1)))
        return flats, batch

    def _type(self) -> Any:
        module = backend.array_module()
        if module is dr.scalar:
            raise ValueError("gradients need the llvm or cuda backend: gonio.use('llvm').")
        return module.Float if self.dtype is np.float32 else module.Float64

    @staticmethod
    def _moving(tangents: Sequence[Any]) -> list[int]:
        """Numbers of the leaves by which is differentiated."""
        from jax.custom_derivatives import SymbolicZero

        return [i for i, t in enumerate(tangents) if not isinstance(t, SymbolicZero)]
