"""The layered reference as a Mitsuba plug-in: against arrays, and against Mitsuba's own plastic."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import drjit as dr
import numpy as np
import pytest
from support.directions import polar
from support.tolerances import SINGLE

import gonio
import gonio.mitsuba
from gonio.fields import ModelError
from gonio.reference import Layer, Stack

import mitsuba as mi  # isort: skip  (after gonio, which finds an LLVM)
from gonio.mitsuba.nodes import node

LIMIT = 4.5
"""Standard errors that one number may be off."""

STACKS = {
    "smooth": Stack([Layer(1.5, sigma_a=(0.1, 0.2, 0.3))], gonio.Lambert(rho=0.8)),
    "rough": Stack([Layer(1.5, 0.2)], gonio.EON(rho=(0.9, 0.5, 0.2))),
    "two": Stack(
        [Layer(1.3, 0.2, 0.1, 0.5, "beckmann"), Layer(1.3, sigma_a=0.1)], gonio.Lambert(rho=0.9)
    ),
}


@pytest.fixture(autouse=True)
def compiled() -> Iterator[None]:
    before = mi.variant()
    mi.set_variant("llvm_ad_rgb")
    yield
    if before is not None:
        mi.set_variant(before)


def interactions(wo: Any, count: int) -> Any:
    """Places all over a plane, seen from wo: each has random numbers of its own."""
    rng = np.random.default_rng(3)
    if "scalar" in mi.variant():
        si = mi.SurfaceInteraction3f()
        si.p = rng.random(3).tolist()
    else:
        si = dr.zeros(mi.SurfaceInteraction3f, count)
        si.p = mi.Point3f(*(mi.Float(rng.random(count).astype(np.float32)) for _ in range(3)))
    si.wi = mi.Vector3f(*map(float, wo))
    return si


def numbers(count: int, seed: int) -> tuple[Any, Any]:
    rng = np.random.default_rng(seed)
    if "scalar" in mi.variant():
        return float(rng.random()), mi.Point2f(*rng.random(2).tolist())
    u = [mi.Float(rng.random(count).astype(np.float32)) for _ in range(3)]
    return u[0], mi.Point2f(u[1], u[2])


@pytest.mark.parametrize("name", STACKS)
def test_the_plugin_agrees_with_arrays(name: str) -> None:
    count, stack = 100_000, STACKS[name]
    bsdf = mi.load_dict(node(stack) | {"walks": 2})
    wi, wo = polar(0.9, 2.0), polar(0.6)
    si, ctx = interactions(wo, count), mi.BSDFContext()
    value, pdf = bsdf.eval_pdf(ctx, si, mi.Vector3f(*map(float, wi)))
    truth, density = stack.eval(wi, wo, walks=200_000), stack.pdf(wi, wo, walks=200_000)
    for c in range(3):
        found = np.array(value[c], np.float64) / wi[2]
        error = math.hypot(found.std() / count**0.5, truth.error[c])
        assert error < 0.01 * truth.value[c]
        assert abs(found.mean() - truth.value[c]) < LIMIT * error
    found = np.array(pdf, np.float64)
    error = math.hypot(found.std() / count**0.5, float(density.error))
    assert abs(found.mean() - 1e-4 - float(density.value)) < LIMIT * error
    weights = np.array(bsdf.sample(ctx, si, *numbers(count, 4))[1], np.float64)
    albedo = stack.albedo(wo, walks=200_000)
    for c in range(3):
        error = math.hypot(weights[c].std() / count**0.5, albedo.error[c])
        assert abs(weights[c].mean() - albedo.value[c]) < LIMIT * error


def test_the_same_question_has_the_same_answer() -> None:
    bsdf = mi.load_dict(node(STACKS["rough"]))
    si, ctx, wi = interactions(polar(0.6), 100), mi.BSDFContext(), mi.Vector3f(0.6, 0, 0.8)
    first, again = (bsdf.eval_pdf(ctx, si, wi) for _ in range(2))
    np.testing.assert_array_equal(np.array(first[0]), np.array(again[0]))
    np.testing.assert_array_equal(np.array(first[1]), np.array(again[1]))
    bs, _ = bsdf.sample(ctx, si, *numbers(100, 4))
    # What a sample says of its density is what pdf says of its direction.
    np.testing.assert_array_equal(np.array(bs.pdf), np.array(bsdf.pdf(ctx, si, bs.wo)))


def picture(bsdf: dict[str, Any], **integrator: Any) -> Any:
    """A sphere under a bright and a dim light, so that samples of both kinds matter."""
    scene = {
        "type": "scene",
        "integrator": {"type": "direct", **integrator},
        "sensor": {
            "type": "perspective",
            "to_world": mi.ScalarTransform4f().look_at([0, -4, 1], [0, 0, 0], [0, 0, 1]),
            "fov": 30,
            "film": {"type": "hdrfilm", "width": 16, "height": 16, "rfilter": {"type": "box"}},
        },
        "ball": {"type": "sphere", "bsdf": bsdf},
        "sky": {"type": "constant", "radiance": 0.5},
        "lamp": {
            "type": "sphere",
            "center": [3, -3, 3],
            "radius": 1.0,
            "emitter": {"type": "area", "radiance": {"type": "rgb", "value": 8.0}},
        },
    }
    return np.array(mi.render(mi.load_dict(scene), spp=1024), np.float64)


def test_a_picture_is_that_of_mitsubas_plastic() -> None:
    # The same smooth coat over a matte base, in closed form, by Mitsuba's authors
    plastic = {
        "type": "plastic",
        "nonlinear": True,
        "int_ior": 1.5,
        "ext_ior": 1.0,
        "diffuse_reflectance": {"type": "rgb", "value": 0.7},
    }
    ours = picture(node(Stack([Layer(1.5)], gonio.Lambert(rho=0.7))))
    theirs = picture(plastic)
    # 256 pixels of 1024 samples: their mean is known to a thousandth
    assert ours.mean() == pytest.approx(theirs.mean(), rel=2e-3)
    assert np.quantile(np.abs(ours - theirs) / theirs, 0.95) < 0.06
    # and 2 % in the base's colour would be seen
    plastic["diffuse_reflectance"] = {"type": "rgb", "value": 0.71}
    # The same noise
    assert ours.mean() != pytest.approx(picture(plastic).mean(), rel=2e-3)


def test_multiple_importance_sampling_does_not_change_the_picture() -> None:
    # Both kinds of samples, those of the BSDF alone, and those of the lights alone
    bsdf = node(STACKS["rough"])
    both = picture(bsdf).mean()
    # The lamp is small: samples of the BSDF alone seldom find it, and have several times the noise
    assert both == pytest.approx(picture(bsdf, emitter_samples=0, bsdf_samples=1).mean(), rel=5e-3)
    assert both == pytest.approx(picture(bsdf, emitter_samples=1, bsdf_samples=0).mean(), rel=5e-3)


def test_scalar_and_mono_variants() -> None:
    wi, wo = [float(x) for x in polar(0.9, 2.0)], [float(x) for x in polar(0.6)]
    coated = node(Stack([Layer(1.5, 0.3)], gonio.Lambert(rho=0.8))) | {"walks": 400}
    expected = Stack([Layer(1.5, 0.3)], gonio.Lambert(rho=0.8)).eval(wi, wo, walks=100_000)
    for variant in ("scalar_rgb", "llvm_ad_mono"):
        mi.set_variant(variant)
        si = dr.zeros(mi.SurfaceInteraction3f)
        si.wi = mi.Vector3f(*wo)
        bsdf = mi.load_dict(coated)
        value = np.ravel(np.array(bsdf.eval(mi.BSDFContext(), si, mi.Vector3f(*wi))))[0] / wi[2]
        # 400 walks scatter by about 3 %
        assert value == pytest.approx(float(expected.value[0]), rel=0.15)
        bs, weight = bsdf.sample(mi.BSDFContext(), si, 0.3, mi.Point2f(0.2, 0.7))
        assert np.all(np.isfinite(np.array(weight)))
        assert np.all(np.array(bs.pdf) >= 0)


@pytest.mark.parametrize(
    "variant", ["llvm_ad_spectral", "scalar_spectral", "llvm_ad_mono_polarized"]
)
def test_each_wavelength_has_its_own_absorption(variant: str) -> None:
    wi, wo = [float(x) for x in polar(0.9, 2.0)], [float(x) for x in polar(0.6)]
    mi.set_variant(variant)
    low, high = mi.MI_CIE_MIN, mi.MI_CIE_MAX
    sigma = {"type": "regular", "values": "0, 2", "wavelength_min": low, "wavelength_max": high}
    grey = {"type": "gonio_lambert", "rho": {"type": "uniform", "value": 0.8}}
    node = {"type": "gonio_layered_reference", "alpha": 0.3, "base": grey, "walks": 400}
    # Mitsuba's own spectra do not load in a mono variant.
    bsdf = mi.load_dict(node | {"sigma_a": 0.5 if mi.is_monochromatic else sigma})
    count = 1 if "scalar" in variant else 500
    si = interactions(wo, count)
    if not mi.is_monochromatic:
        si.wavelengths = [450.0, 550.0, 650.0, 800.0]
    value = bsdf.eval(mi.BSDFContext(), si, mi.Vector3f(*wi))
    bs, weight = bsdf.sample(mi.BSDFContext(), si, *numbers(count, 2))
    if mi.is_polarized:
        value, weight = value[0, 0], weight[0, 0]
    channels = np.array(value).reshape(-1, count)
    assert np.all(np.isfinite(np.array(weight)))
    assert np.all(np.array(bs.pdf) >= 0)
    if mi.is_monochromatic:
        assert len(channels) == 1
        return
    assert len(channels) == 4
    for nanometres, found in zip((450.0, 550.0, 650.0, 800.0), channels, strict=True):
        depth = 2 * (nanometres - low) / (high - low)
        truth = Stack([Layer(1.5, 0.3, depth)], gonio.Lambert(rho=0.8)).eval(wi, wo, walks=100_000)
        # 400 walks scatter by about 4 %
        limit = 0.2 if count == 1 else 0.01
        assert found.mean() / wi[2] == pytest.approx(float(truth.value[0]), rel=limit)


def test_types_and_components_switch_parts_off() -> None:
    bsdf = mi.load_dict(node(STACKS["smooth"]))
    assert bsdf.component_count() == 2
    wo = polar(0.6)
    si, u = interactions(wo, 20_000), numbers(20_000, 1)
    mirror = mi.BSDFContext()
    mirror.component = 0
    bs, weight = bsdf.sample(mirror, si, *u)
    wi, active = np.array(bs.wo), np.array(weight)[0] > 0
    np.testing.assert_allclose(
        wi[:, active].T, np.tile(wo * (-1, -1, 1), (active.sum(), 1)), atol=SINGLE
    )
    # Three standard errors of a share of 20,000
    assert np.all(np.array(bs.pdf)[active] == pytest.approx(active.mean(), abs=0.01))
    assert np.all(np.array(bsdf.eval(mirror, si, mi.Vector3f(0, 0, 1))) == 0)
    matte = mi.BSDFContext()
    matte.component = 1
    _, other = bsdf.sample(matte, si, *u)
    assert not np.any((np.array(other)[0] > 0) & active)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"eta": 7.0}, "eta=7.0 is out of range"),
        ({"alhpa": 0.1}, "did you mean 'alpha'"),
        ({"distribution": "phong"}, "allowed are ggx, beckmann"),
        ({"walks": 0}, "walks=0"),
        ({"base": {"type": "diffuse"}}, "allowed are a BSDF of type gonio_"),
    ],
)
def test_mistakes_say_what_is_right(given: dict[str, Any], message: str) -> None:
    with pytest.raises((ModelError, RuntimeError), match=message):
        mi.load_dict({"type": "gonio_layered_reference", **given})


def test_parameters_are_listed_and_can_change() -> None:
    bsdf = mi.load_dict(node(STACKS["two"]))
    found = mi.traverse(bsdf)
    assert "eta.value" in found
    assert "base.thickness.value" in found
    si, ctx, wi = interactions(polar(0.6), 100), mi.BSDFContext(), mi.Vector3f(0.6, 0, 0.8)
    before = np.array(bsdf.eval(ctx, si, wi)).mean()
    found["base.thickness.value"] = 100.0
    found.update()
    assert np.array(bsdf.eval(ctx, si, wi)).mean() < 0.7 * before
    assert "gonio_layered_reference" in str(bsdf)
