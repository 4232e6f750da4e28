"""NumPy, PyTorch, JAX and Dr.Jit arrays in, the same kind out; and what is refused."""

from __future__ import annotations

import functools
from collections.abc import Iterator
from typing import Any

import drjit as dr
import jax
import numpy as np
import pytest
import torch
from support.directions import random_directions
from support.tolerances import NUMERIC_ALBEDO, SINGLE, SINGLE_LONG

import gonio
from gonio.check.variants import sweep
from gonio.fields import ModelError
from gonio.lang import INV_PI, Color, Float, Sample, Vec2, Vec3
from gonio.model import Model, child, param


@pytest.fixture
def scalar_backend() -> Iterator[None]:
    gonio.use("scalar")
    yield
    gonio.use("llvm")


@pytest.fixture
def unvalidated() -> Iterator[None]:
    gonio.use(validate=False)
    yield
    gonio.use(validate=True)


WI, WO = random_directions(50, 1), random_directions(50, 2)


# --- kinds ---------------------------------------------------------------------------------------


def test_numpy_arrays_come_back_with_their_precision() -> None:
    eon = gonio.EON(roughness=1)
    for dtype in (np.float32, np.float64):
        f = eon.eval(WI.astype(dtype), WO.astype(dtype))
        assert isinstance(f, np.ndarray)
        assert f.dtype == dtype
        assert f.shape == (50, 3)
        assert f.flags.c_contiguous
        assert f.flags.writeable
    wi, pdf = eon.sample(WO, np.full((50, 2), 0.5, np.float32))
    assert wi.shape == (50, 3)
    assert pdf.shape == (50,)
    assert eon.pdf(WI, WO).shape == (50,)
    assert eon.mean_albedo().shape == (3,)


def test_results_do_not_share_memory_with_later_ones() -> None:
    eon = gonio.EON()
    first = eon.eval(WI, WO)
    kept = first.copy()
    eon.eval(WO, WO)
    gonio.EON(roughness=1).eval(WI, WO)
    np.testing.assert_array_equal(first, kept)


def test_inputs_are_left_alone() -> None:
    wi, wo = WI.copy(), WO.copy()
    gonio.EON().eval(wi, wo)
    np.testing.assert_array_equal(wi, WI)
    np.testing.assert_array_equal(wo, WO)


def test_lists_and_integers_are_float32() -> None:
    f = gonio.Lambert(rho=0.5).eval([0, 0, 1], np.array([0, 0, 1]))
    assert f.dtype == np.float32
    np.testing.assert_allclose(f, 0.5 / np.pi, rtol=SINGLE)


def test_frameworks_agree() -> None:
    eon = gonio.EON(roughness=0.7, rho=(0.9, 0.5, 0.1))
    expected = eon.eval(WI, WO)
    t = eon.eval(torch.tensor(WI), torch.tensor(WO))
    assert isinstance(t, torch.Tensor)
    assert t.dtype == torch.float32
    np.testing.assert_allclose(t.numpy(), expected, rtol=SINGLE)
    j = eon.eval(jax.numpy.asarray(WI), jax.numpy.asarray(WO))
    assert isinstance(j, jax.Array)
    np.testing.assert_allclose(np.asarray(j), expected, rtol=SINGLE)
    d = eon.eval(dr.llvm.ad.Array3f(WI.T), dr.llvm.ad.Array3f(WO.T))
    assert type(d) is dr.llvm.ad.Array3f
    np.testing.assert_allclose(d.numpy().T, expected, rtol=SINGLE)
    d = eon.eval(dr.llvm.Array3f64(WI.T), dr.llvm.Array3f64(WO.T))
    assert type(d) is dr.llvm.Array3f64


def test_mixed_numpy_and_torch_is_torch_and_two_frameworks_are_refused() -> None:
    f = gonio.EON().eval(torch.tensor(WI), WO)
    assert isinstance(f, torch.Tensor)
    with pytest.raises(ValueError, match="jax and torch together; convert them to one framework"):
        gonio.EON().eval(torch.tensor(WI), jax.numpy.asarray(WO))


def test_scalar_backend_gives_the_same_values(scalar_backend: None) -> None:
    u = np.full((5, 2), 0.3, np.float32)
    for name, cls in gonio.models().items():
        model = cls()
        closed = cls.writes("albedo")  # quadrature in plain Python takes its time

        def compute(model: Model = model, closed: bool = closed) -> dict[str, Any]:
            wi, pdf = model.sample(WO[:5], u)
            found = {"eval": model.eval(WI[:5], WO[:5]), "wi": wi, "pdf": pdf}
            return found | ({"albedo": model.albedo(WO[:5])} if closed else {})

        gonio.use("scalar")
        found = compute()
        gonio.use("llvm")
        for quantity, value in compute().items():
            # Python computes in double precision; a sampled direction is several float32 steps away.
            np.testing.assert_allclose(
                found[quantity], value, rtol=1e-4, atol=1e-5, err_msg=f"{name} {quantity}"
            )


# --- broadcasting --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("wi", "wo", "roughness", "shape"),
    [
        ((3,), (3,), (), (3,)),
        ((50, 3), (3,), (), (50, 3)),
        ((3,), (50, 3), (50,), (50, 3)),
        ((4, 1, 3), (5, 3), (), (4, 5, 3)),
        ((5, 3), (4, 1, 3), (2, 1, 1), (2, 4, 5, 3)),
        ((1, 3), (1, 3), (7,), (7, 3)),
        ((0, 3), (3,), (), (0, 3)),
    ],
)
@pytest.mark.parametrize("framework", ["numpy", "torch", "jax"])
def test_broadcasting_is_that_of_numpy(
    wi: Any, wo: Any, roughness: Any, shape: Any, framework: str
) -> None:
    rng = np.random.default_rng(3)

    def directions(shape: Any) -> Any:
        w = rng.normal(size=shape)
        w[..., 2] = np.abs(w[..., 2])
        return (w / np.linalg.norm(w, axis=-1, keepdims=True)).astype(np.float32)

    wi, wo, r = directions(wi), directions(wo), rng.random(roughness).astype(np.float32)
    give: Any = {"numpy": np.asarray, "torch": torch.as_tensor, "jax": jax.numpy.asarray}[framework]
    f = np.asarray(gonio.EON(roughness=give(r)).eval(give(wi), give(wo)))
    assert f.shape == shape
    # Element by element, each a call of its own
    full = [
        np.broadcast_to(a, (*shape[:-1], *tail)) for a, tail in [(wi, (3,)), (wo, (3,)), (r, ())]
    ]
    for index in list(np.ndindex(shape[:-1]))[:10]:
        one = gonio.EON(roughness=float(full[2][index])).eval(full[0][index], full[1][index])
        np.testing.assert_allclose(f[index], one, rtol=SINGLE)


def test_views_that_are_not_contiguous_are_read_right() -> None:
    wide = np.repeat(WI, 2, axis=0)
    np.testing.assert_array_equal(gonio.EON().eval(wide[::2], WO), gonio.EON().eval(WI, WO))
    fortran = np.asfortranarray(WI)
    np.testing.assert_array_equal(gonio.EON().eval(fortran, WO), gonio.EON().eval(WI, WO))


def test_colour_parameters_take_arrays_and_greys() -> None:
    rho = np.random.default_rng(0).random((50, 3)).astype(np.float32)
    f = gonio.Lambert(rho=rho).eval(WI, WO)
    np.testing.assert_allclose(f, rho / np.pi, rtol=SINGLE)
    f = gonio.Lambert(rho=rho[:, :1]).eval(WI, WO)
    np.testing.assert_allclose(f, np.repeat(rho[:, :1], 3, 1) / np.pi, rtol=SINGLE)


# --- refusals ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda m: m.eval(WI[:, :2], WO), r"wi has shape \(50, 2\); its last axis must hold 3"),
        (lambda m: m.eval(WI[:7], WO), r"do not broadcast.*wi \(7, 3\), wo \(50, 3\)"),
        (lambda m: m.eval(2 * WI, WO), r"wi\[0\] = .* has length 2; directions are unit vectors"),
        (lambda m: m.eval(WI, np.full((50, 3), np.nan, np.float32)), r"wo\[0\] = .* is not finite"),
        (lambda m: m.eval([np.inf, 0, 0], WO), r"wi = .* is not finite"),
        (lambda m: m.sample(WO, np.full((50, 2), 1.5)), r"u\[0, 0\] = 1.5 is out of range.*0 to 1"),
        (lambda m: m.eval("up", WO), r"wi must be an array or numbers with 3 components"),
        (lambda m: m.albedo(None), r"wo has shape \(\)|wo must be an array"),
        (
            lambda m: m.replace(roughness=np.array([0.5, 2])).albedo([0, 0, 1]),
            r"roughness\[1\] = 2.0",
        ),
        (lambda m: m.replace(rho=np.ones((4, 2))).albedo([0, 0, 1]), r"rho has shape \(4, 2\)"),
    ],
)
def test_bad_arrays_get_one_clear_line(call: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message) as caught:
        call(gonio.EON())
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("name", "parameters", "message"),
    [
        ("eon", {"roughness": 1.1}, r"eon: roughness=1.1 is out of range; allowed is 0 to 1"),
        ("eon", {"roughness": float("nan")}, r"roughness=nan is out of range"),
        ("eon", {"roughness": "rough"}, r"roughness must be a number, got 'rough'"),
        ("eon", {"roughness": (1, 1, 1)}, r"roughness takes one number"),
        ("eon", {"roughness": True}, r"roughness must be a number"),
        ("eon", {"rho": (1, 1)}, r"rho takes one or three numbers"),
        ("eon", {"rougness": 1}, r"no 'rougness'; did you mean 'roughness'\?"),
        ("eon", {"sampler": "cosin"}, r"sampler='cosin' is not known; allowed are cltc_matched"),
        ("ggx", {}, r"no model 'ggx'; .*'gonio list' shows all"),
        ("eno", {}, r"did you mean 'eon'\?"),
    ],
)
def test_bad_parameters_get_one_clear_line(name: str, parameters: Any, message: str) -> None:
    with pytest.raises(ModelError, match=message) as caught:
        gonio.model(name, **parameters)
    assert "\n" not in str(caught.value)


def test_validation_of_values_can_be_turned_off(unvalidated: None) -> None:
    assert gonio.EON().eval(2 * WI, WO).shape == (50, 3)


def test_a_parameter_at_the_float32_rounding_of_its_limit_is_accepted() -> None:
    gonio.QON(sigma=np.float32(np.pi / 2))
    sigma = np.full(50, np.pi / 2, np.float32)
    assert np.isfinite(gonio.QON(sigma=sigma).eval(WI, WO)).all()


def test_models_do_not_change() -> None:
    eon = gonio.EON()
    with pytest.raises(AttributeError, match=r"use model.replace\(roughness=1\)"):
        eon.roughness = 1
    assert eon.replace(roughness=1).roughness == 1
    assert eon.roughness == 0.5


# --- derivatives ---------------------------------------------------------------------------------

SPOTS = np.random.default_rng(8)


def finite_difference(parameters: Any, wi: Any, wo: Any, name: str, axis: int | None) -> Any:
    """Central difference of sum(f) in float64."""
    h = 1e-6

    def total(sign: int) -> float:
        p, i = dict(parameters), wi.copy()
        if name == "wi":
            i[:, axis] += sign * h
        else:
            p[name] = p[name] + sign * h
        return float(gonio.EON(**p).eval(i, wo).sum())

    return (total(1) - total(-1)) / (2 * h)


def test_torch_gradients_are_central_differences() -> None:
    wi, wo = WI.astype(np.float64), WO.astype(np.float64)
    parameters = {"roughness": np.array(0.4), "rho": np.array([0.7, 0.4, 0.2])}
    leaves = {k: torch.tensor(v, requires_grad=True) for k, v in parameters.items()}
    direction = torch.tensor(wi, requires_grad=True)
    gonio.EON(**leaves).eval(direction, torch.tensor(wo)).sum().backward()
    expected = finite_difference(parameters, wi, wo, "roughness", None)
    assert leaves["roughness"].grad.shape == ()
    assert float(leaves["roughness"].grad) == pytest.approx(expected, rel=SINGLE)
    assert leaves["rho"].grad.shape == (3,)
    for axis in range(3):
        expected = finite_difference(parameters, wi, wo, "wi", axis)
        assert float(direction.grad[:, axis].sum()) == pytest.approx(expected, rel=SINGLE_LONG)


def test_torch_gradcheck_passes() -> None:
    wi, wo = (torch.tensor(w[:4].astype(np.float64), requires_grad=True) for w in (WI, WO))
    r = torch.tensor(0.6, dtype=torch.float64, requires_grad=True)
    gonio.use(validate=False)  # gradcheck steps off the unit sphere
    try:
        assert torch.autograd.gradcheck(
            # gradcheck's own differences, by steps of 1e-6 in double precision
            lambda i, o, r: gonio.EON(roughness=r).eval(i, o),
            (wi, wo, r),
            atol=1e-6,
        )
    finally:
        gonio.use(validate=True)


def test_torch_backward_can_run_twice_and_under_torch_func() -> None:
    wi, wo = torch.tensor(WI), torch.tensor(WO)
    r = torch.tensor(0.4, requires_grad=True)
    f = gonio.EON(roughness=r).eval(wi, wo)
    (first,) = torch.autograd.grad(f[0].sum(), r, retain_graph=True)
    (second,) = torch.autograd.grad(f[1].sum(), r)
    assert float(first) != float(second)
    for row, found in ((0, first), (1, second)):
        one = torch.func.grad(lambda r, n=row: gonio.EON(roughness=r).eval(wi[n], wo[n]).sum())
        assert float(one(torch.tensor(0.4))) == pytest.approx(float(found), rel=SINGLE_LONG)


def test_torch_vmap_gives_what_a_loop_gives() -> None:
    import torch

    wi, wo = (torch.from_numpy(random_directions(6, seed=s)).double() for s in (5, 6))
    roughness = torch.linspace(0.1, 0.9, 6, dtype=torch.float64)

    def value(i: Any, o: Any, r: Any) -> Any:
        return gonio.EON(roughness=r).eval(i, o)

    looped = torch.stack([value(*each) for each in zip(wi, wo, roughness, strict=True)])
    torch.testing.assert_close(torch.func.vmap(value)(wi, wo, roughness), looped)
    shared = torch.func.vmap(lambda i: value(i, wo[0], roughness[0]))(wi)
    torch.testing.assert_close(shared, torch.stack([value(i, wo[0], roughness[0]) for i in wi]))

    def slope(i: Any, o: Any, r: Any) -> Any:
        return torch.func.grad(lambda x: value(i, o, x).sum())(r)

    gradients = torch.stack([slope(*each) for each in zip(wi, wo, roughness, strict=True)])
    torch.testing.assert_close(torch.func.vmap(slope)(wi, wo, roughness), gradients)


def test_jax_gradients_under_jit_and_vmap() -> None:
    wi, wo = jax.numpy.asarray(WI), jax.numpy.asarray(WO)

    def total(r: Any) -> Any:
        return gonio.EON(roughness=r, rho=(0.7, 0.4, 0.2)).eval(wi, wo).sum()

    parameters = {"roughness": np.array(0.4), "rho": (0.7, 0.4, 0.2)}
    expected = finite_difference(
        parameters, WI.astype(np.float64), WO.astype(np.float64), "roughness", None
    )
    for gradient in (jax.grad(total), jax.jit(jax.grad(total))):
        # A derivative in single precision, summed over all pairs, beside a difference
        assert float(gradient(0.4 * jax.numpy.ones(()))) == pytest.approx(expected, rel=1e-4)
    one = jax.vmap(lambda i, o: gonio.EON().eval(i, o))(wi, wo)
    np.testing.assert_allclose(one, gonio.EON().eval(WI, WO), rtol=SINGLE)
    half = jax.vmap(lambda i: gonio.EON().eval(i, wo[0]))(wi)
    np.testing.assert_allclose(half, gonio.EON().eval(WI, WO[0]), rtol=SINGLE)
    per_sample = jax.vmap(
        jax.grad(lambda r, i: gonio.EON(roughness=r).eval(i, wo[0]).sum()), (0, 0)
    )
    gradients = per_sample(jax.numpy.linspace(0.1, 0.9, 50), wi)
    assert gradients.shape == (50,)
    assert np.isfinite(gradients).all()


def test_jax_gradient_of_a_broadcast_direction_is_summed() -> None:
    wo = jax.numpy.asarray(WO)
    g = jax.grad(lambda i: gonio.EON().eval(i, wo).sum())(jax.numpy.asarray(WI[0]))
    assert g.shape == (3,)
    each = jax.grad(lambda i: gonio.EON().eval(i, wo).sum())(
        jax.numpy.asarray(np.tile(WI[0], (50, 1)))
    )
    # Sums of single precision in another order, of terms with both signs
    np.testing.assert_allclose(g, each.sum(0), rtol=1e-4)


def test_drjit_gradient_with_respect_to_an_array_parameter() -> None:
    r = dr.llvm.ad.Float(np.linspace(0.1, 0.9, 50))
    dr.enable_grad(r)
    f = gonio.EON(roughness=r).eval(dr.llvm.ad.Array3f(WI.T), dr.llvm.ad.Array3f(WO.T))
    dr.backward(dr.sum(f, axis=None))
    assert dr.width(dr.grad(r)) == 50
    assert np.abs(dr.grad(r).numpy()).min() > 0


# --- kernels -------------------------------------------------------------------------------------


class Baked(Model, register=False):
    """A model whose number is compiled into its kernel: what the contract is there to prevent."""

    rho: Color = param(0.5, 0, 1, "albedo")

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        return vars(self)["secret"] * INV_PI + 0 * wi

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        raise NotImplementedError

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        raise NotImplementedError


def compiled(calls: Any) -> int:
    """Number of kernels that had to be compiled or read from disk during `calls`."""
    with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
        dr.kernel_history_clear()
        calls()
        history = dr.kernel_history()
    return sum(1 for k in history if k["type"] == dr.KernelType.JIT and not k["cache_hit"])


def test_a_changed_parameter_compiles_nothing() -> None:
    wi, wo = WI[:17], WO[:17]
    for name, cls in gonio.models().items():
        gonio.model(name).eval(wi, wo)
        for parameters in sweep(cls):
            model = cls(**parameters)
            assert compiled(functools.partial(model.eval, wi, wo)) == 0, (name, parameters)


def test_a_number_baked_into_the_kernel_is_caught() -> None:
    def use(value: float) -> None:
        model = Baked()
        object.__setattr__(model, "secret", value)
        bound = model.bind(dr.llvm.ad.Float, lambda path, p, v: v)
        object.__setattr__(bound, "secret", value)
        dr.eval(bound.eval(dr.llvm.ad.Array3f(WI.T), dr.llvm.ad.Array3f(WO.T)))

    rng = np.random.default_rng()  # numbers that no earlier run left in the cache on disk
    use(rng.random())
    assert compiled(lambda: use(rng.random())) == 1


# --- models inside models ------------------------------------------------------------------------


class Half(Model, register=False):
    """A base that reflects half of what it does: the smallest model with a model inside."""

    base: Model = child("eon", "what is dimmed")
    share: Float = param(0.5, 0, 1, "share of the base")

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        return self.base.eval(wi, wo) * self.share

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        return self.base.sample(wo, u)

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        return self.base.pdf(wi, wo)


def test_models_nest_to_any_depth() -> None:
    f = Half(base=Half(base=gonio.Lambert(rho=0.8), share=0.25)).eval(WI, WO)
    np.testing.assert_allclose(f, 0.8 / np.pi / 8, rtol=SINGLE)
    by_name = Half(base="lambert", **{"base.rho": 0.8}).eval(WI, WO)
    np.testing.assert_allclose(by_name, 0.8 / np.pi / 2, rtol=SINGLE)
    rho = np.random.default_rng(0).random((50, 3)).astype(np.float32)
    f = Half(base=Half(base=gonio.Lambert(rho=rho))).eval(WI, WO)
    np.testing.assert_allclose(f, rho / np.pi / 4, rtol=SINGLE)
    np.testing.assert_allclose(Half(base="lambert").mean_albedo(), 0.4, rtol=NUMERIC_ALBEDO)


def test_derivatives_reach_inner_parameters() -> None:
    r = torch.tensor(0.4, requires_grad=True)
    outer = Half(base=gonio.EON(roughness=r)).eval(torch.tensor(WI), torch.tensor(WO)).sum()
    (found,) = torch.autograd.grad(outer, r)
    inner = gonio.EON(roughness=r).eval(torch.tensor(WI), torch.tensor(WO)).sum()
    (expected,) = torch.autograd.grad(inner, r)
    assert float(found) == pytest.approx(0.5 * float(expected), rel=SINGLE_LONG)


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"base": 3}, r"half: base takes a model or a model's name, got 3"),
        ({"base": "ggx"}, r"no model 'ggx'"),
        ({"base.rougness": 1}, r"eon has no 'rougness'; did you mean 'roughness'"),
        ({"base.roughness": 2}, r"eon: roughness=2 is out of range"),
        ({"share.rho": 1}, r"half has no 'share.rho'"),
        ({"bse": "eon"}, r"half has no 'bse'; did you mean 'base'\?"),
    ],
)
def test_bad_inner_parameters_get_one_clear_line(parameters: Any, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        Half(**parameters)
