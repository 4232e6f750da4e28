"""Every registered model as a Mitsuba BSDF: values and densities."""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest
from support.directions import polar, random_directions
from support.plugins import (
    CUDA_TWINS,
    EACH,
    FLOAT32,
    IN_EACH_PROMISED_VARIANT,
    IN_EACH_VARIANT,
    PROMISED,
    RUNNABLE,
    WI,
    WO,
    Lambertian,
    between,
    disagreement,
    interaction,
    load,
    numbers,
    reflectance,
    vector,
    wiring,
)
from support.tolerances import SINGLE, SINGLE_LONG

import gonio.mitsuba
from gonio import backend
from gonio.check.variants import options
from gonio.lang import Color, Float, Sample, Vec2, Vec3, vec3
from gonio.model import Child, Model


def test_every_promised_variant_is_tested() -> None:
    assert set(PROMISED) <= set(RUNNABLE)
    assert set(CUDA_TWINS) <= set(mi.variants())
    assert backend.available("cuda") == (set(CUDA_TWINS) <= set(RUNNABLE))


@IN_EACH_PROMISED_VARIANT
@EACH
def test_plugin_agrees_with_arrays(cls: type[Model], variant: str) -> None:
    """In colour where there are three channels, grey elsewhere, and with every option."""
    given: dict[str, Any] = between(cls, 0.37)
    if not variant.endswith("rgb"):  # models inside have no colour of their own either
        inner = [name for name, declared in cls.fields.items() if isinstance(declared, Child)]
        given |= dict.fromkeys(inner, "lambert")
    cases = [cls(**given)]
    if variant.endswith("rgb"):
        tint = {p.name: tuple(given[p.name] * c for c in (1, 0.75, 0.5)) for p in numbers(cls)}
        cases += [
            cls(),
            cls(**given | {p.name: tint[p.name] for p in numbers(cls) if p.width == 3}),
        ]
    if variant == "llvm_ad_rgb":
        cases += [cls(**given, **choice) for choice in options(cls)[1:]]
    for model in cases:
        error = disagreement(
            mi.load_dict(gonio.mitsuba.node(model)),
            model,
            24 if variant.startswith("llvm") else 6,
        )
        assert error < FLOAT32, model


@EACH
def test_diffuse_reflectance_is_the_albedo(cls: type[Model]) -> None:
    check_diffuse_reflectance(cls(**between(cls, 0.37)))


@IN_EACH_VARIANT
def test_diffuse_reflectance_in_each_variant(variant: str) -> None:
    check_diffuse_reflectance(gonio.EON(rho=0.75, roughness=0.5))


def check_diffuse_reflectance(model: Model) -> None:
    wo = polar([0.5, 2.0]).astype(np.float32)
    found = reflectance(mi.load_dict(gonio.mitsuba.node(model)), wo)
    expected = model.albedo(wo)
    if found.shape != expected.shape:
        expected = expected[:, :1]  # other channels than RGB: the model is grey
    np.testing.assert_allclose(found, np.broadcast_to(expected, found.shape), rtol=1e-4)
    assert (found[1] == 0).all()


class OneWay(Lambertian, register=False):
    """Neither reciprocal nor isotropic: every mix-up of the two directions shows."""

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        return self.rho * (wi.z * wi.z * (2 + wo.x))

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        wi = vec3(-wo.y, wo.x, wo.z)
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        return 5 + wi.x + 3 * wo.y


@IN_EACH_VARIANT
def test_directions_are_swapped_exactly_once(variant: str) -> None:
    """By hand: light (0.6, 0, 0.8), viewer (0, 0.28, 0.96)."""
    light, viewer = np.array([[0.6, 0, 0.8]]), np.array([[0, 0.28, 0.96]])
    found = wiring(load(OneWay, rho=0.5), light, viewer, np.array([[0.5, 0.5]]))
    np.testing.assert_allclose(found["value"], 0.5 * 0.8**2 * 2 * 0.8, rtol=SINGLE)
    np.testing.assert_allclose(found["pdf"], 5 + 0.6 + 3 * 0.28, rtol=SINGLE)
    np.testing.assert_allclose(found["sample"], [[-0.28, 0, 0.96]], rtol=SINGLE)
    np.testing.assert_allclose(found["sample_pdf"], 5 - 0.28 + 3 * 0.28, rtol=SINGLE)
    expected = 0.5 * 0.96**2 * 2 * 0.96 / (5 - 0.28 + 3 * 0.28)
    np.testing.assert_allclose(found["weight"], expected, rtol=SINGLE)


class Swapped(OneWay, register=False):
    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        return super().eval(wo, wi)


class CosineTwice(Lambertian, register=False):
    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        return super().eval(wi, wo) * wi.z


class CosineMissing(Lambertian, register=False):
    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        return super().eval(wi, wo) / wi.z


class NearlyRight(Lambertian, register=False):
    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        return super().eval(wi, wo) * 1.00005


@pytest.mark.parametrize(
    ("broken", "right"),
    [
        (Swapped, OneWay),
        (CosineTwice, Lambertian),
        (CosineMissing, Lambertian),
        (NearlyRight, Lambertian),
    ],
)
def test_agreement_catches_broken_plugins(broken: type[Model], right: type[Model]) -> None:
    assert disagreement(load(right), right()) < FLOAT32
    assert disagreement(load(broken), right()) > FLOAT32


@IN_EACH_VARIANT
def test_eval_and_pdf_are_the_halves_of_eval_pdf(variant: str) -> None:
    bsdf, ctx, si = mi.load_dict({"type": "gonio_eon"}), mi.BSDFContext(), interaction(WO[0])
    value, pdf = bsdf.eval_pdf(ctx, si, vector(WI[0]))
    assert dr.all(bsdf.eval(ctx, si, vector(WI[0])) == value, axis=None)
    assert dr.all(bsdf.pdf(ctx, si, vector(WI[0])) == pdf)
    assert dr.all(pdf > 0)


@IN_EACH_VARIANT
def test_samples_say_what_they_are(variant: str) -> None:
    bsdf, ctx, si = mi.load_dict({"type": "gonio_eon"}), mi.BSDFContext(), interaction(WO[0])
    bs, _ = bsdf.sample(ctx, si, 0.5, mi.Point2f(0.25, 0.25))
    assert bsdf.flags() == bsdf.flags(0)
    assert bsdf.component_count() == 1
    assert dr.all(bs.sampled_type + int(+mi.BSDFFlags.FrontSide) == bsdf.flags())
    assert dr.all(bs.sampled_component == 0)
    assert dr.all(bs.eta == 1)


@pytest.mark.parametrize("variant", [v for v in RUNNABLE if "spectral" not in v], indirect=True)
def test_lambert_is_mitsubas_diffuse(variant: str) -> None:
    """Luminance and depolarisation included; spectral variants are in test_upsampling.py."""
    colour = {"type": "rgb", "value": [0.9, 0.4, 0.1]}
    ours = mi.load_dict({"type": "gonio_lambert", "rho": colour})
    theirs = mi.load_dict({"type": "diffuse", "reflectance": colour})
    wi, wo = random_directions(8, 5), random_directions(8, 6)
    wi[0] *= -1
    wo[1] *= -1
    u = np.full((8, 2), 0.25)
    found, expected = wiring(ours, wi, wo, u), wiring(theirs, wi, wo, u)
    for name in ("value", "pdf", "weight"):
        # Numbers of about 1, each rounded once or twice to single precision
        np.testing.assert_allclose(found[name], expected[name], rtol=SINGLE_LONG, atol=1e-7)
    above = wo[wo[:, 2] > 0]  # theirs has the same albedo on its black side
    np.testing.assert_allclose(
        reflectance(ours, above), reflectance(theirs, above), rtol=SINGLE_LONG
    )


@pytest.mark.parametrize("variant", [v for v in RUNNABLE if "polarized" in v], indirect=True)
def test_reflection_depolarises(variant: str) -> None:
    """As Mitsuba's diffuse does: of the Mueller matrix only the first entry is left."""
    for kind in ("gonio_eon", "diffuse"):
        bsdf, ctx, si = mi.load_dict({"type": kind}), mi.BSDFContext(), interaction(WO[0])
        value, weight = bsdf.eval(ctx, si, vector(WI[0])), bsdf.sample(ctx, si, 0.5, si.uv)[1]
        for matrix in (np.array(value), np.array(weight)):
            flat = matrix.reshape(16, -1)
            assert (flat[0] > 0).all()
            assert (flat[1:] == 0).all()


def test_a_mask_a_type_and_a_component_switch_the_model_off() -> None:
    bsdf = mi.load_dict({"type": "gonio_eon"})
    wo, wi = random_directions(2, 1), random_directions(2, 2)
    si, everything = interaction(wo), mi.BSDFContext()
    mask = mi.Bool([True, False])
    value, pdf = bsdf.eval_pdf(everything, si, vector(wi), mask)
    bs, weight = bsdf.sample(everything, si, 0.5, mi.Point2f(0.3, 0.6), mask)
    for result in (pdf, value.x, bs.pdf, weight.x, bsdf.eval_diffuse_reflectance(si, mask).x):
        on, off = np.array(result)
        assert on > 0
        assert off == 0
    other_type = mi.BSDFContext(mi.TransportMode.Radiance, mi.BSDFFlags.Delta)
    other_component = mi.BSDFContext()
    other_component.component = 1
    for ctx in (other_type, other_component):
        value, pdf = bsdf.eval_pdf(ctx, si, vector(wi))
        bs, weight = bsdf.sample(ctx, si, 0.5, mi.Point2f(0.3, 0.6))
        assert dr.all((pdf == 0) & (bs.pdf == 0))
        assert dr.all((value == 0) & (weight == 0), axis=None)
