"""Every registered model as a Mitsuba BSDF: derivatives."""

from __future__ import annotations

import contextlib
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest
from support.directions import RANDOM, adversarial_pairs, polar
from support.plugins import (
    EACH,
    EACH_WITH_NUMBERS,
    SUN,
    Lambertian,
    ball,
    between,
    interaction,
    load,
    numbers,
    vector,
)

import gonio.mitsuba
from gonio.check.variants import value_at
from gonio.lang import INV_PI, Color, Vec3, select
from gonio.model import Model


def picture_and_derivative(scene: Any, key: str, value: float, **render: Any) -> tuple[Any, Any]:
    """The picture with a parameter at a value, and how it changes with it (all channels at once)."""
    parameters = mi.traverse(scene)
    parameters[key] = type(parameters[key])(value)
    dr.enable_grad(parameters[key])
    parameters.update()
    picture = mi.render(scene, parameters, **render)
    dr.forward(parameters[key])
    dr.disable_grad(parameters[key])
    return picture.numpy(), dr.grad(picture).numpy()


def central_difference(scene: Any, key: str, x: float, h: float, **render: Any) -> Any:
    parameters = mi.traverse(scene)

    def picture(value: float) -> Any:
        parameters[key] = type(parameters[key])(value)
        parameters.update()
        return mi.render(scene, **render).numpy()

    return (picture(x + h) - picture(x - h)) / (2 * h)


def sunlit_error(cls: type[Model]) -> float:
    """Error of the derivative along all parameters at once, relative to the picture's largest.

    Under the sun only the place in the pixel is random, and that is the same in all pictures.
    """
    gonio.mitsuba.register(cls)
    scene = mi.load_dict(ball({"type": f"gonio_{cls.name}"}, "prb", SUN))
    parameters = mi.traverse(scene)
    middle = between(cls, 0.4)
    keys = {name: f"ball.bsdf.{name}.value" for name in middle}

    def picture(t: float) -> Any:
        for name, key in keys.items():
            parameters[key] = type(parameters[key])(middle[name] * (1 + t))
        parameters.update()
        return mi.render(scene, spp=64, seed=2).numpy()

    h = 0.005
    expected = (picture(h) - picture(-h)) / (2 * h)
    for name, key in keys.items():
        parameters[key] = type(parameters[key])(middle[name])
        dr.enable_grad(parameters[key])
        dr.set_grad(parameters[key], middle[name])
    parameters.update()
    found = mi.render(scene, parameters, spp=64, seed=1, seed_grad=2)
    dr.enqueue(dr.ADMode.Forward, *(parameters[key] for key in keys.values()))
    dr.traverse(dr.ADMode.Forward)
    scale = np.abs(expected).max()
    assert scale > 1e-2, "the parameters do nothing"
    return float(np.abs(dr.grad(found).numpy() - expected).max() / scale)


# The step of 0.5 % leaves its curvature, and float32 leaves 1e-7 / 0.005.
DIFFERENCE = 2e-3


@EACH_WITH_NUMBERS
def test_derivative_of_a_sunlit_picture_is_its_central_difference(cls: type[Model]) -> None:
    assert sunlit_error(cls) < DIFFERENCE


class Detached(gonio.EON, register=False):
    """Half a percent of the value does not move with the parameters."""

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        value = super().eval(wi, wo)
        return 0.995 * value + 0.005 * dr.detach(value)


def test_a_derivative_that_is_half_a_percent_wrong_is_caught() -> None:
    assert sunlit_error(Detached) > 2 * DIFFERENCE


@pytest.mark.parametrize("name", ["rho", "roughness"])
def test_derivative_with_interreflection_is_the_central_difference(name: str) -> None:
    """Cosine samples stay where they are when the roughness changes, so a fixed seed has no noise."""
    bsdf = {
        "type": "gonio_eon",
        "sampler": "cosine",
        "rho": {"type": "rgb", "value": [0.9, 0.5, 0.2]},
    }
    scene = ball(bsdf, {"type": "prb", "max_depth": 4, "rr_depth": 100})
    scene["bowl"] = {
        "type": "sphere",
        "radius": 3.0,
        "center": [0, -3.5, 0],
        "bsdf": {"type": "gonio_eon", "sampler": "cosine", "roughness": 0.9},
    }
    loaded, key = mi.load_dict(scene), f"ball.bsdf.{name}.value"
    expected = central_difference(loaded, key, 0.5, 0.01, spp=64, seed=5)
    parameters = mi.traverse(loaded)
    parameters[key] = type(parameters[key])(0.5)
    dr.enable_grad(parameters[key])
    parameters.update()
    dr.set_grad(parameters[key], 1)
    dr.enqueue(dr.ADMode.Forward, parameters[key])
    dr.traverse(dr.ADMode.Forward, dr.ADFlag.ClearEdges)
    found = loaded.integrator().render_forward(loaded, parameters, sensor=0, spp=64, seed=5)
    np.testing.assert_allclose(found.numpy(), expected, atol=5e-3 * np.abs(expected).max())
    assert np.abs(expected).max() > 1e-3


def furnace_derivative(integrator: Any) -> float:
    """Mean derivative of a white furnace's picture with respect to roughness: 0, as it stays white."""
    bsdf = {"type": "gonio_eon", "rho": {"type": "rgb", "value": [1, 1, 1]}}
    scene = mi.load_dict(ball(bsdf, integrator))
    picture, derivative = picture_and_derivative(
        scene, "ball.bsdf.roughness.value", 0.5, spp=4096, seed=3
    )
    # What is left is the noise of the samples
    assert picture.mean() == pytest.approx(1, abs=2e-3)
    assert np.isfinite(derivative).all()
    return float(derivative.mean())


# 1.5 million samples leave a standard error of 2e-4.
FURNACE = 1e-3
BSDF_ONLY = {"type": "direct", "emitter_samples": 0, "bsdf_samples": 1}


@pytest.mark.parametrize("integrator", [BSDF_ONLY, "direct", "path", "prb"])
def test_a_white_furnace_has_no_derivative(integrator: Any) -> None:
    if integrator == "direct":
        integrator = {"type": "direct"}
    assert abs(furnace_derivative(integrator)) < FURNACE


def test_a_derivative_that_follows_the_samples_is_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    """Samples that change over from the uniform lobe to CLTC's make it wrong by 0.01."""
    monkeypatch.setattr(dr, "suspend_grad", contextlib.nullcontext)
    assert abs(furnace_derivative(BSDF_ONLY)) > 5 * FURNACE


def test_backward_derivatives_are_the_forward_ones() -> None:
    scene = mi.load_dict(ball({"type": "gonio_eon"}, "prb"))
    key = "ball.bsdf.roughness.value"
    _, forward = picture_and_derivative(scene, key, 0.5, spp=64, seed=1, seed_grad=2)
    parameters = mi.traverse(scene)
    parameters[key] = mi.Float(0.5)
    dr.enable_grad(parameters[key])
    parameters.update()
    picture = mi.render(scene, parameters, spp=64, seed=1, seed_grad=2)
    dr.backward(dr.sum(picture, axis=None))
    # The same derivative by the other mode: sums of single precision over all pixels
    assert dr.grad(parameters[key])[0] == pytest.approx(forward.sum(), rel=1e-3)


def end_error(cls: type[Model], arrays: type[Model]) -> float:
    """Relative error of derivatives at both ends of each range against those of the array API."""
    wi, wo = polar(1.0, 2), polar(0.4)
    worst = 0.0
    for p in numbers(cls):
        for t in (0.0, 1.0):
            end = float(np.float32(value_at(p, t)))
            bsdf, leaf = load(cls), mi.Float(end)
            dr.enable_grad(leaf)
            value = mi.Vector3f(leaf) if p.width == 3 else leaf
            f = arrays(**{p.name: value}).eval(mi.Vector3f(wi), mi.Vector3f(wo))
            dr.forward(leaf)
            expected = dr.grad(f).numpy()[:, 0] * np.cos(1.0)

            parameters, key = mi.traverse(bsdf), f"{p.name}.value"
            parameters[key] = type(parameters[key])(end)
            dr.enable_grad(parameters[key])
            parameters.update()
            value = bsdf.eval(mi.BSDFContext(), interaction(wo), vector(wi))
            dr.forward(parameters[key])
            scale = max(np.abs(expected).max(), 1e-3)
            worst = max(worst, float(np.abs(dr.grad(value).numpy()[:, 0] - expected).max() / scale))
    return worst


@pytest.mark.parametrize("name", ["eon", "oren_nayar", "triace_oren_nayar"])
def test_derivatives_at_the_ends_of_the_range_remain(name: str) -> None:
    """An optimiser that has limited a value to its range must be able to leave the end again."""
    cls = gonio.models()[name]
    assert end_error(cls, cls) < 1e-4


def test_a_derivative_that_ends_before_the_range_does_is_caught() -> None:
    """What dr.clip does: it has no derivative at its lower end."""

    class Clipped(gonio.EON, register=False):
        def eval(self, wi: Vec3, wo: Vec3) -> Color:
            inside = select(self.roughness > 0, 1, 0)
            value = super().eval(wi, wo)
            return inside * value + (1 - inside) * dr.detach(value)

    assert end_error(Clipped, gonio.EON) > 0.9


def derivatives_are_finite(cls: type[Model], **choice: str) -> bool:
    """Of sample weights along all parameters and the view, at every end of all that goes in."""
    wo = adversarial_pairs()[1]
    u = mi.Point2f(
        *map(mi.Float, np.random.default_rng(3).choice(np.float32(RANDOM), (2, len(wo))))
    )
    bsdf = load(cls, **choice)
    parameters, keys = mi.traverse(bsdf), [f"{p.name}.value" for p in numbers(cls)]
    finite = True
    for t in (0.0, 0.5, 1.0):
        si = interaction(wo)
        for key, value in zip(keys, between(cls, t).values(), strict=True):
            parameters[key] = type(parameters[key])(value)
            dr.enable_grad(parameters[key])
            dr.set_grad(parameters[key], 1)
        parameters.update()
        dr.enable_grad(si.wi)
        dr.set_grad(si.wi, mi.Vector3f(-si.wi.z, 0.5, si.wi.x))
        _, weight = bsdf.sample(mi.BSDFContext(), si, 0.5, u)
        dr.enqueue(dr.ADMode.Forward, si.wi, *(parameters[key] for key in keys))
        dr.traverse(dr.ADMode.Forward)
        finite &= bool(np.isfinite(dr.grad(weight).numpy()).all())
    return finite


@EACH
def test_derivatives_through_samples_are_finite(cls: type[Model]) -> None:
    assert derivatives_are_finite(cls)


@pytest.mark.parametrize("sampler", gonio.EON.fields["sampler"].values)
def test_derivatives_through_each_sampler_are_finite(sampler: str) -> None:
    assert derivatives_are_finite(gonio.EON, sampler=sampler)


def test_an_infinite_derivative_is_caught() -> None:
    class Root(Lambertian, register=False):
        def eval(self, wi: Vec3, wo: Vec3) -> Color:
            return dr.sqrt(self.rho) * INV_PI

    assert derivatives_are_finite(Lambertian)
    assert not derivatives_are_finite(Root)
