"""Every registered model as a Mitsuba BSDF: kernels."""

from __future__ import annotations

import contextlib
import gc
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from support.plugins import EACH_WITH_NUMBERS, SUN, ball, between
from support.tolerances import SINGLE

from gonio.model import Model


@contextlib.contextmanager
def new_kernels() -> Any:
    """Yields a list that holds, after the block, the kernels that were compiled or read from disk."""
    found: list[Any] = []
    with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
        dr.kernel_history_clear()
        yield found
        kernels = dr.kernel_history([dr.KernelType.JIT])
        assert kernels
        found += [k for k in kernels if k["cache_disk"] or not k["cache_hit"]]


@EACH_WITH_NUMBERS
def test_changed_values_need_no_new_kernel(cls: type[Model]) -> None:
    def picture(t: float) -> Any:
        """In a scene that is gone afterwards; Dr.Jit numbers the objects that live together."""
        scene = mi.load_dict(ball({"type": f"gonio_{cls.name}", **between(cls, t)}))
        return mi.render(scene, spp=1).numpy()

    gc.collect()
    before = picture(0.2)
    with new_kernels() as kernels:
        fresh = picture(0.9)
        scene = mi.load_dict(ball({"type": f"gonio_{cls.name}", **between(cls, 0.2)}))
        parameters = mi.traverse(scene)
        assert (mi.render(scene, spp=1).numpy() == before).all()
        for name, value in between(cls, 0.9).items():
            parameters[f"ball.bsdf.{name}.value"] = mi.Float(value)
        parameters.update()
        updated = mi.render(scene, spp=1).numpy()
    assert not kernels
    assert np.abs(fresh - before).max() > 0.01
    np.testing.assert_allclose(updated, fresh, rtol=SINGLE)


def test_a_new_kernel_is_noticed() -> None:
    """A value that is baked into the code, as options are."""
    mi.render(mi.load_dict(ball({"type": "gonio_eon", "sampler": "cosine"})), spp=1)
    with new_kernels() as kernels:
        mi.render(mi.load_dict(ball({"type": "gonio_eon", "sampler": "uniform"})), spp=1)
    assert kernels


def test_a_frozen_function_follows_the_parameters() -> None:
    scene = mi.load_dict(ball({"type": "gonio_eon"}, emitter=SUN))
    parameters = mi.traverse(scene)

    @dr.freeze
    def frozen(scene: Any) -> Any:
        return mi.render(scene, spp=1, seed=1)

    for roughness in (0.1, 0.9):
        parameters["ball.bsdf.roughness.value"] = mi.Float(roughness)
        parameters.update()
        expected = mi.render(scene, spp=1, seed=1).numpy()
        np.testing.assert_allclose(frozen(scene).numpy(), expected, rtol=SINGLE)
