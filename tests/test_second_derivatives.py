"""Forward mode and second derivatives in PyTorch and JAX, beside closed forms and differences of values."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import jax
import numpy as np
import pytest
import torch
from support.directions import random_directions
from support.tolerances import SINGLE_LONG

import gonio
from gonio.arrays import derivatives

# Differences of exact first derivatives over 2e-6, in float64: their rounding over the step, 1e-16 / 1e-6.
SECOND = 1e-8

# Second differences of values at steps of 1e-3: the step's square, and 1e-16 / 1e-6 of rounding.
OF_VALUES = 1e-4

# PyTorch's own forward mode uses what PyTorch itself deprecates
pytestmark = pytest.mark.filterwarnings("ignore:`torch.jit.script:DeprecationWarning")

WI, WO = (
    w / np.linalg.norm(w, axis=1, keepdims=True)
    for w in (random_directions(5, seed).astype(np.float64) for seed in (1, 2))
)
RHO = (0.7, 0.4, 0.2)


@pytest.fixture(autouse=True)
def double() -> Iterator[None]:
    with jax.enable_x64(True):
        yield


def minnaert(k: float, mu: float) -> tuple[float, float, float]:
    """(k + 1) / (2 pi) mu^(k - 1) and its first two derivatives by k, for mu the product of the cosines."""
    scale, log = mu ** (k - 1) / (2 * math.pi), math.log(mu)
    first = scale * (1 + (k + 1) * log)
    return scale * (k + 1), first, scale * log * (2 + (k + 1) * log)


MODES = {
    "jax": {
        "forward": jax.jacfwd,
        "reverse": jax.jacrev,
        "hessian": jax.hessian,
        "forward twice": lambda f: jax.jacfwd(jax.jacfwd(f)),
        "reverse twice": lambda f: jax.jacrev(jax.jacrev(f)),
        "reverse of forward": lambda f: jax.jacrev(jax.jacfwd(f)),
        "compiled": lambda f: jax.jit(jax.hessian(f)),
    },
    "torch": {
        "forward": torch.func.jacfwd,
        "reverse": torch.func.jacrev,
        "hessian": torch.func.hessian,
        "reverse twice": lambda f: torch.func.jacrev(torch.func.jacrev(f)),
        "reverse of forward": lambda f: torch.func.jacrev(torch.func.jacfwd(f)),
        "autograd": lambda f: lambda x: torch.autograd.functional.hessian(f, x),
    },
}
ARRAY = {
    "jax": jax.numpy.asarray,
    "torch": lambda values: torch.tensor(values, dtype=torch.float64),
}


@pytest.mark.parametrize(("kind", "mode"), [(k, m) for k, modes in MODES.items() for m in modes])
def test_derivatives_by_a_parameter_are_the_closed_form(kind: str, mode: str) -> None:
    wi, wo = ARRAY[kind](WI), ARRAY[kind](WO)

    def total(k: Any) -> Any:
        return gonio.model("minnaert", k=k, rho=RHO).eval(wi, wo).sum()

    found = float(MODES[kind][mode](total)(ARRAY[kind](0.6)))
    order = 1 if mode in ("forward", "reverse") else 2
    expected = sum(RHO) * sum(minnaert(0.6, mu)[order] for mu in WI[:, 2] * WO[:, 2])
    assert found == pytest.approx(expected, rel=SECOND)


@pytest.mark.parametrize(
    ("kind", "method"),
    [("jax", "eval"), ("torch", "pdf"), ("torch", "sample"), ("jax", "albedo")],
)
def test_hessians_of_all_methods_are_second_differences_of_values(kind: str, method: str) -> None:
    """By parameters and direction at once: mixed ones too."""
    given = np.array([0.6, 0.7, *WO[0]])  # roughness, grey and the viewer

    def value(x: Any, asarray: Any) -> Any:
        model = gonio.EON(roughness=x[0], rho=x[1:2])
        wo = x[2:5]
        if method == "sample":
            wi, pdf = model.sample(wo, asarray([0.3, 0.6]))
            return wi.sum() + pdf
        extra = (asarray(WI[0]),) if method in ("eval", "pdf") else ()
        return getattr(model, method)(*extra, wo).sum()

    hessian = jax.hessian if kind == "jax" else torch.func.hessian
    found = np.asarray(hessian(lambda x: value(x, ARRAY[kind]))(ARRAY[kind](given)))
    step = 1e-3 * np.eye(5)
    gonio.use(validate=False)  # differences leave the unit sphere
    try:
        expected = [
            [(at(a + b) - at(a - b) - at(b - a) + at(-a - b)) / 4e-6 for b in step]
            for a in step
            for at in [lambda d: float(value(given + d, np.asarray))]
        ]
    finally:
        gonio.use(validate=True)
    np.testing.assert_allclose(found, expected, rtol=OF_VALUES, atol=OF_VALUES)
    np.testing.assert_allclose(found, found.T, rtol=SECOND, atol=SECOND)


def test_a_wrong_step_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(derivatives, "STEP", 0.02)

    def total(k: Any) -> Any:
        return gonio.model("minnaert", k=k, rho=1).eval(torch.tensor(WI), torch.tensor(WO)).sum()

    found = float(torch.func.hessian(total)(torch.tensor(0.6)))
    expected = 3 * sum(minnaert(0.6, mu)[2] for mu in WI[:, 2] * WO[:, 2])
    assert abs(found / expected - 1) > 1e3 * SECOND


@pytest.mark.parametrize("k", [0.0, 2.0])
def test_second_derivatives_at_the_ends_of_a_range_stay_inside(k: float) -> None:
    mu = float(WI[0, 2] * WO[0, 2])
    f = jax.hessian(lambda x: gonio.model("minnaert", k=x, rho=1).eval(WI[0], WO[0])[0])
    assert float(f(k)) == pytest.approx(minnaert(k, mu)[2], rel=1e-5)  # of second order in the step


def test_below_the_steepest_cosine_all_derivatives_are_zero() -> None:
    low = np.array([math.sqrt(1 - 1e-14), 0, 1e-7])
    f = gonio.model("torrance_sparrow", alpha=0.1)
    assert not np.asarray(jax.hessian(lambda w: f.eval(w, WO[0]).sum())(low)).any()
    flat = np.array([math.sqrt(1 - 4e-12), 0, 2e-6])
    assert np.isfinite(jax.hessian(lambda w: f.eval(w, WO[0]).sum())(flat)).all()


def test_vmap_of_hessians_is_a_loop_and_shared_arrays_are_summed() -> None:
    ks = np.linspace(0.3, 1.8, 5)
    expected = [3 * minnaert(k, float(i[2] * o[2]))[2] for k, i, o in zip(ks, WI, WO, strict=True)]

    def total(k: Any, i: Any, o: Any) -> Any:
        return gonio.model("minnaert", k=k, rho=1).eval(i, o).sum()

    np.testing.assert_allclose(jax.vmap(jax.hessian(total))(ks, WI, WO), expected, rtol=SECOND)
    arrays = [torch.tensor(a) for a in (ks, WI, WO)]
    found = torch.func.vmap(torch.func.hessian(total))(*arrays)
    np.testing.assert_allclose(found, expected, rtol=SECOND)
    jacobian = torch.func.jacfwd(
        lambda k: gonio.model("minnaert", k=k, rho=1).eval(arrays[1], arrays[2]).sum(-1)
    )
    shared = sum(3 * minnaert(0.5, float(m))[1] for m in WI[:, 2] * WO[:, 2])
    assert float(jacobian(torch.tensor(0.5)).sum()) == pytest.approx(shared, rel=SECOND)


def test_single_precision_gets_its_second_derivatives_from_double() -> None:
    k = torch.tensor(0.6, dtype=torch.float32)
    wi, wo = (torch.tensor(w, dtype=torch.float32) for w in (WI, WO))
    found = torch.func.hessian(lambda k: gonio.model("minnaert", k=k, rho=1).eval(wi, wo).sum())(k)
    assert found.dtype == torch.float32
    expected = 3 * sum(minnaert(0.6, float(mu))[2] for mu in WI[:, 2] * WO[:, 2])
    assert float(found) == pytest.approx(expected, rel=SINGLE_LONG)


def test_torch_gradients_of_gradients_pass_torchs_own_check() -> None:
    wi = torch.tensor(WI[:2], requires_grad=True)
    k = torch.tensor([0.6, 1.2], dtype=torch.float64, requires_grad=True)
    gonio.use(validate=False)  # the check leaves the unit sphere
    try:
        assert torch.autograd.gradgradcheck(
            lambda i, k: gonio.model("minnaert", k=k).eval(i, torch.tensor(WO[:2])), (wi, k)
        )
    finally:
        gonio.use(validate=True)


def test_what_cannot_be_done_is_refused_with_the_way_round() -> None:
    def total(k: Any) -> Any:
        return gonio.model("minnaert", k=k).eval(WI, WO).sum()

    def torchs(k: Any) -> Any:
        return gonio.model("minnaert", k=k).eval(torch.tensor(WI), torch.tensor(WO)).sum()

    k = torch.tensor(0.6, dtype=torch.float64)
    for third in (
        lambda: jax.jacfwd(jax.hessian(total))(0.6),
        lambda: jax.jacrev(jax.hessian(total))(0.6),
        lambda: torch.func.jacrev(torch.func.hessian(torchs))(k),
    ):
        with pytest.raises(NotImplementedError, match="differences of second derivatives"):
            third()
    # PyTorch itself says 0 there
    with pytest.raises(NotImplementedError, match=r"use torch\.func\.hessian"):
        torch.func.jacfwd(torch.func.jacfwd(torchs))(k)
