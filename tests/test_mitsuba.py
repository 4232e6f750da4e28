"""Every registered model as a Mitsuba BSDF: values, parameters, wrappers, derivatives, chi², pictures."""

from __future__ import annotations

import contextlib
import csv
import gc
import json
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest
from support.directions import RANDOM, Array, adversarial_pairs, polar, random_directions

import gonio.mitsuba
from gonio import backend
from gonio.check.variants import options, value_at
from gonio.fields import Parameter
from gonio.lang import INV_PI, Color, Float, Sample, Vec2, Vec3, select, vec2, vec3
from gonio.model import Model, child
from gonio.parts.hemisphere import pdf_cosine, sample_cosine

MODELS = sorted(gonio.models().items())
EACH = pytest.mark.parametrize("cls", [cls for _, cls in MODELS], ids=[name for name, _ in MODELS])

PROMISED = ("scalar_rgb", "llvm_ad_rgb", "llvm_ad_spectral", "llvm_ad_mono")
CUDA_TWINS = ("cuda_ad_rgb", "cuda_ad_spectral", "cuda_ad_mono")
RUNNABLE = [v for v in mi.variants() if not v.startswith("cuda") or backend.available("cuda")]
IN_EACH_VARIANT = pytest.mark.parametrize("variant", RUNNABLE, indirect=True)
IN_EACH_PROMISED_VARIANT = pytest.mark.parametrize(
    "variant", [v for v in RUNNABLE if v in PROMISED + CUDA_TWINS], indirect=True
)

# Two float32 kernels of the same formulas, of which one has more fused multiplications.
FLOAT32 = 2e-5


@pytest.fixture(autouse=True)
def variant(request: pytest.FixtureRequest) -> str:
    """The variant a test runs in; llvm_ad_rgb where it does not say."""
    mi.set_variant(getattr(request, "param", "llvm_ad_rgb"))
    return str(mi.variant())


class Lambertian(Model, register=False):
    """The least that a model needs; the broken ones below derive from it."""

    rho: Color = gonio.param((0.5, 0.5, 0.5), 0, 1, "albedo")

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        return self.rho * INV_PI

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        wi = sample_cosine(u)
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        return pdf_cosine(wi)


def load(cls: type[Model], **properties: Any) -> Any:
    """A model as a BSDF of the current variant; classes outside the registry are registered first."""
    gonio.mitsuba.register(cls)
    return mi.load_dict({"type": f"gonio_{cls.name}", **properties})


def numbers(cls: type[Model]) -> list[Parameter]:
    return [p for p in cls.fields.values() if isinstance(p, Parameter)]


def between(cls: type[Model], t: float) -> dict[str, float]:
    """Every parameter at a place in its range, rounded to float32 as Mitsuba stores it."""
    return {p.name: float(np.float32(value_at(p, t))) for p in numbers(cls)}


def interaction(wo: Any, uv: Any = (0.5, 0.5)) -> Any:
    """Surface hits whose viewer is at wo (n, 3); in scalar variants one direction (3,)."""
    wo = np.asarray(wo, np.float64)
    si = dr.zeros(mi.SurfaceInteraction3f, *([] if wo.ndim == 1 else [len(wo)]))
    si.wi = vector(wo)
    si.uv = mi.Point2f(*uv)
    si.sh_frame = mi.Frame3f(mi.Normal3f(0, 0, 1))
    si.n = mi.Normal3f(0, 0, 1)
    si.dp_du, si.dp_dv = mi.Vector3f(1, 0, 0), mi.Vector3f(0, 1, 0)
    if mi.is_spectral:
        si.wavelengths += type(si.wavelengths)(450.0, 520.0, 590.0, 660.0)
    return si


def vector(w: Any) -> Any:
    w = np.asarray(w)
    scalar = mi.variant().startswith("scalar")
    return mi.Vector3f(*(float(c) if scalar or w.ndim == 1 else mi.Float(c) for c in w.T))


def channels(spectrum: Any) -> Array:
    """A spectrum as (n, channels); of a Mueller matrix the first entry, intensity to intensity."""
    if mi.is_polarized:
        spectrum = spectrum[0, 0]
    return np.array(spectrum).reshape(dr.size_v(mi.UnpolarizedSpectrum), -1).T


def wiring(bsdf: Any, wi: Array, wo: Array, u: Array) -> dict[str, Array]:
    """All that the plug-in answers, in gonio's words: (n, channels), (n,), (n, 3)."""
    if mi.variant().startswith("scalar"):
        rows = [_wiring(bsdf, *row) for row in zip(wi, wo, u, strict=True)]
        return {name: np.concatenate([row[name] for row in rows]) for name in rows[0]}
    return _wiring(bsdf, wi, wo, u)


def _wiring(bsdf: Any, wi: Array, wo: Array, u: Array) -> dict[str, Array]:
    ctx, si = mi.BSDFContext(), interaction(wo)
    scalar = mi.variant().startswith("scalar")
    first, second = (float(c) if scalar else mi.Float(c) for c in u.T)
    bs, weight = bsdf.sample(ctx, si, 0.5, mi.Point2f(first, second))
    value, pdf = bsdf.eval_pdf(ctx, si, vector(wi))
    dr.eval(value, pdf, bs, weight)
    return {
        "value": channels(value),
        "pdf": np.atleast_1d(pdf),
        "sample": np.array(bs.wo).reshape(3, -1).T,
        "sample_pdf": np.atleast_1d(bs.pdf),
        "weight": channels(weight),
    }


def reflectance(bsdf: Any, wo: Array) -> Array:
    """What denoisers see of it: (n, channels)."""
    if mi.variant().startswith("scalar"):
        return np.concatenate([channels(bsdf.eval_diffuse_reflectance(interaction(w))) for w in wo])
    found = channels(bsdf.eval_diffuse_reflectance(interaction(wo)))
    return np.broadcast_to(found, (len(wo), found.shape[1]))


def contract(model: Model, wi: Array, wo: Array, u: Array) -> dict[str, Array]:
    """The same from the array API, with the cosine that Mitsuba wants."""
    found, pdf = model.sample(wo, u)
    good = pdf > 0
    weight = model.eval(found, wo) * (found[:, 2] / np.where(good, pdf, 1))[:, None]
    return {
        "value": model.eval(wi, wo) * np.maximum(wi[:, 2:], 0),
        "pdf": model.pdf(wi, wo),
        "sample": found,
        "sample_pdf": pdf,
        "weight": np.where(good[:, None], weight, 0),
    }


def disagreement(bsdf: Any, model: Model, count: int = 24) -> float:
    """Largest error of a plug-in against the arrays, relative to the value or to 0.01.

    The arrays have Mitsuba's precision: what rounding does to a steep lobe is not the plug-in's business.
    """
    wi, wo = random_directions(count, 1), random_directions(count, 2)
    wi[0], wo[0] = wo[1], wo[1]
    wi[-2:] *= -1  # light and viewer below the horizon
    wo[-3:-1] *= -1
    u = np.random.default_rng(3).random((count, 2), np.float32)
    found = wiring(bsdf, wi, wo, u)
    precision = np.float64 if mi.variant().startswith("scalar") else np.float32
    expected = contract(model, *(x.astype(precision) for x in (wi, wo, u)))
    assert (found["value"][-3:] == 0).all()
    assert (found["pdf"][-3:] == 0).all()
    assert (found["weight"][-3:-1] == 0).all()
    sampled = expected["sample_pdf"] > 0
    worst = 0.0
    for name, b in expected.items():
        a = found[name]
        if name == "sample":
            a, b = a[sampled], b[sampled]
        elif b.ndim == 2 and a.shape != b.shape:  # other channels than RGB: the models are grey
            b = b[:, :1]
        assert a.shape[0] == b.shape[0]
        worst = max(worst, float(np.max(np.abs(a - b) / np.maximum(np.abs(b), 1e-2), initial=0)))
    return worst


# --- values --------------------------------------------------------------------------------------


def test_every_promised_variant_is_tested() -> None:
    assert set(PROMISED) <= set(RUNNABLE)
    assert set(CUDA_TWINS) <= set(mi.variants())
    assert backend.available("cuda") == (set(CUDA_TWINS) <= set(RUNNABLE))


@IN_EACH_PROMISED_VARIANT
@EACH
def test_plugin_agrees_with_arrays(cls: type[Model], variant: str) -> None:
    """In colour where there are three channels, grey elsewhere, and with every option."""
    given: dict[str, Any] = between(cls, 0.37)
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
    np.testing.assert_allclose(found["value"], 0.5 * 0.8**2 * 2 * 0.8, rtol=1e-6)
    np.testing.assert_allclose(found["pdf"], 5 + 0.6 + 3 * 0.28, rtol=1e-6)
    np.testing.assert_allclose(found["sample"], [[-0.28, 0, 0.96]], rtol=1e-6)
    np.testing.assert_allclose(found["sample_pdf"], 5 - 0.28 + 3 * 0.28, rtol=1e-6)
    expected = 0.5 * 0.96**2 * 2 * 0.96 / (5 - 0.28 + 3 * 0.28)
    np.testing.assert_allclose(found["weight"], expected, rtol=1e-6)


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
        np.testing.assert_allclose(found[name], expected[name], rtol=1e-5, atol=1e-7)
    above = wo[wo[:, 2] > 0]  # theirs has the same albedo on its black side
    np.testing.assert_allclose(reflectance(ours, above), reflectance(theirs, above), rtol=1e-5)


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


# --- parameters ----------------------------------------------------------------------------------


def grey_value(bsdf: Any, uv: Any = (0.5, 0.5)) -> Array:
    """One value of a BSDF, per channel."""
    return channels(
        bsdf.eval(mi.BSDFContext(), interaction(polar(0.4), uv), vector(polar(1.0, 2)))
    )[0]


def expected_value(model: Model) -> Array:
    return np.asarray(model.eval(polar(1.0, 2), polar(0.4)) * np.cos(1.0))


def bitmap(*texels: Any) -> dict[str, Any]:
    """A row of texels, one number or three each, as a texture of raw data without interpolation."""
    data = np.array([texels], np.float32)
    image = mi.Bitmap(data.reshape(1, len(texels), -1))
    return {"type": "bitmap", "bitmap": image, "raw": True, "filter_type": "nearest"}


# What users write, and what it means to gonio.EON. Textures are read at uv = (0.25, 0.25).
WAYS: list[tuple[str, dict[str, Any], dict[str, Any]]] = [
    ("", {}, {}),
    (
        '<float name="roughness" value="0.3"/><integer name="rho" value="1"/>',
        {"roughness": 0.3, "rho": 1},
        {"roughness": 0.3, "rho": 1},
    ),
    (
        '<rgb name="rho" value="0.9, 0.4, 0.1"/>',
        {"rho": {"type": "rgb", "value": [0.9, 0.4, 0.1]}},
        {"rho": (0.9, 0.4, 0.1)},
    ),
    (
        '<spectrum name="rho" value="0.3"/><spectrum name="roughness" value="0.2"/>',
        {"rho": {"type": "spectrum", "value": 0.3}, "roughness": {"type": "uniform", "value": 0.2}},
        {"rho": 0.3, "roughness": 0.2},
    ),
    (
        '<rgb name="roughness" value="0.1, 0.2, 0.6"/>',
        {"roughness": {"type": "rgb", "value": [0.1, 0.2, 0.6]}, "rho": [0.8, 0.8, 0.8]},
        {"roughness": 0.3},
    ),
    (
        '<texture name="rho" type="checkerboard"><rgb name="color0" value="0.2, 0.5, 0.7"/>'
        '<rgb name="color1" value="0.9"/></texture>',
        {"rho": {"type": "checkerboard", "color0": {"type": "rgb", "value": [0.2, 0.5, 0.7]}}},
        {"rho": (0.2, 0.5, 0.7)},
    ),
    (
        '<string name="sampler" value="cosine"/><string name="albedo_form" value="fitted"/>',
        {"sampler": "cosine", "albedo_form": "fitted"},
        {"sampler": "cosine", "albedo_form": "fitted"},
    ),
]


@pytest.mark.parametrize(("xml", "dictionary", "meant"), WAYS)
def test_parameters_as_users_write_them(xml: str, dictionary: Any, meant: Any) -> None:
    from_xml = mi.load_string(f'<bsdf version="3.0.0" type="gonio_eon">{xml}</bsdf>')
    from_dict = mi.load_dict({"type": "gonio_eon", **dictionary})
    expected = expected_value(gonio.model("eon", **meant))
    for bsdf in (from_xml, from_dict):
        np.testing.assert_allclose(grey_value(bsdf, (0.25, 0.25)), expected, rtol=FLOAT32)
        for name in ("sampler", "albedo_form"):
            assert f"{name} = {getattr(gonio.model('eon', **meant), name)}" in str(bsdf)


def test_a_sampled_spectrum_has_its_value_at_each_wavelength() -> None:
    mi.set_variant("llvm_ad_spectral")
    bsdf = mi.load_dict(
        {"type": "gonio_eon", "rho": {"type": "spectrum", "value": [(400, 0.1), (700, 0.7)]}}
    )
    rho = 0.1 + 0.6 * (np.array([450.0, 520, 590, 660]) - 400) / 300
    expected = [expected_value(gonio.model("eon", rho=r))[0] for r in rho]
    np.testing.assert_allclose(grey_value(bsdf), expected, rtol=FLOAT32)


class Bright(Lambertian, register=False):
    index: Color = gonio.param((1, 1, 1), 0, 10, "as metals have it")

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        return self.index


@IN_EACH_VARIANT
def test_colours_above_one_keep_their_size(variant: str) -> None:
    """Mitsuba's upsampling ends at 1; a metal's k goes beyond."""
    for number in ({"type": "rgb", "value": [4, 4, 4]}, 4.0, {"type": "spectrum", "value": 4}):
        found = grey_value(load(Bright, index=number))
        np.testing.assert_allclose(found, 4 * np.cos(1.0), rtol=1e-3)
    if mi.is_spectral:
        hue = load(Bright, index={"type": "rgb", "value": [4, 2, 1]})
        plain = load(Bright, index={"type": "rgb", "value": [1, 0.5, 0.25]})
        np.testing.assert_allclose(grey_value(hue), 4 * grey_value(plain), rtol=1e-3)


def test_textures_by_reference_and_by_bitmap() -> None:
    texture = mi.load_dict(bitmap((0.2, 0.5, 0.7), (1, 0, 0)))
    for rho in (texture, bitmap((0.2, 0.5, 0.7), (1, 0, 0))):
        bsdf = mi.load_dict({"type": "gonio_eon", "rho": rho, "roughness": bitmap(0.25, 0.75)})
        left = gonio.model("eon", rho=(0.2, 0.5, 0.7), roughness=0.25)
        right = gonio.model("eon", rho=(1, 0, 0), roughness=0.75)
        np.testing.assert_allclose(grey_value(bsdf, (0.2, 0.5)), expected_value(left), rtol=FLOAT32)
        np.testing.assert_allclose(
            grey_value(bsdf, (0.8, 0.5)), expected_value(right), rtol=FLOAT32
        )
    scene = mi.load_string(
        """<scene version="3.0.0">
             <texture type="checkerboard" id="squares"><float name="color0" value="0.3"/></texture>
             <shape type="rectangle">
               <bsdf type="gonio_eon"><ref name="rho" id="squares"/></bsdf>
             </shape>
           </scene>"""
    )
    found = grey_value(scene.shapes()[0].bsdf(), (0.25, 0.25))
    np.testing.assert_allclose(found, expected_value(gonio.model("eon", rho=0.3)), rtol=FLOAT32)


@EACH
def test_textures_out_of_range_are_limited(cls: type[Model]) -> None:
    for p in numbers(cls):
        bsdf = load(cls, **{p.name: bitmap(p.low - 1, p.high * 3)})
        for uv, limit in (((0.2, 0.5), p.low), ((0.8, 0.5), p.high)):
            expected = expected_value(cls(**{p.name: limit}))
            np.testing.assert_allclose(grey_value(bsdf, uv), expected, rtol=FLOAT32, atol=1e-9)


@EACH
def test_numbers_out_of_range_are_refused(cls: type[Model]) -> None:
    for p in numbers(cls):
        for value in (p.low - 0.5, p.high * 1.5 + 0.5, float("nan")):
            with pytest.raises(RuntimeError) as raised:
                load(cls, **{p.name: value})
            assert f"{cls.name}: {p.name}={value!r} is out of range" in str(raised.value)
            assert f"allowed is {p.range_text()}" in str(raised.value)


MISTAKES = [
    ({"roughnes": 0.5}, "gonio_eon has no property 'roughnes'; did you mean 'roughness'?"),
    ({"reflectance": 0.5}, "known are rho, roughness, albedo_form, color_shift, sampler."),
    (
        {"sampler": "cosin"},
        "sampler='cosin' is not known; allowed are cltc_matched, cltc_uniform, cltc, ltc,",
    ),
    ({"sampler": 1.0}, "sampler=1.0 is not known; allowed are cltc_matched"),
    (
        {"rho": True},
        "rho is a bool; allowed are a number, an RGB colour, a spectrum and a texture.",
    ),
    ({"roughness": "high"}, "roughness is a str; allowed are a number and a texture."),
    ({"rho": {"type": "rgb", "value": [0.5, 1.5, 0]}}, "rho=(0.5, 1.5, 0.0) is out of range"),
    ({"rho": {"type": "spectrum", "value": 2}}, "rho=2.0 is out of range; allowed is 0 to 1."),
    (
        {"rho": {"type": "spectrum", "value": [(400, 0.1), (700, 1.7)]}},
        "rho=1.7 is out of range; allowed is 0 to 1.",
    ),
    (
        {"roughness": {"type": "spectrum", "value": [(400, 0.1), (700, 0.7)]}},
        "roughness is a Spectrum; allowed are a number and a texture.",
    ),
    ({"bsdf": {"type": "diffuse"}}, "gonio_eon has no property 'bsdf'"),
]


@pytest.mark.parametrize(("given", "message"), MISTAKES)
def test_mistakes_say_what_is_right(given: dict[str, Any], message: str) -> None:
    with pytest.raises(RuntimeError) as raised:
        mi.load_dict({"type": "gonio_eon", **given})
    assert message in str(raised.value)


@EACH
def test_every_model_refuses_unknown_properties(cls: type[Model]) -> None:
    with pytest.raises(RuntimeError) as raised:
        load(cls, nonsense=1.0)
    assert f"known are {', '.join(cls.fields)}." in str(raised.value)


@EACH
def test_traverse_shows_every_parameter(cls: type[Model]) -> None:
    parameters = mi.traverse(load(cls))
    keys = list(parameters.keys())
    assert set(keys) == {f"{path}.value" for path, _, _ in cls().parameters()}
    assert all(parameters.flags(key) == mi.ParamFlags.Differentiable for key in keys)


def test_text_shows_every_field() -> None:
    assert str(mi.load_dict({"type": "gonio_eon", "roughness": 1, "sampler": "cltc"})) == (
        "gonio_eon[\n"
        "  rho = SRGBReflectanceSpectrum[\n"
        "    value = [[0.8, 0.8, 0.8]]\n"
        "  ],\n"
        "  roughness = UniformSpectrum[value=[1]],\n"
        "  albedo_form = exact,\n"
        "  color_shift = physical,\n"
        "  sampler = cltc\n"
        "]"
    )


class Tinted(Model, register=False):
    """Holds another model."""

    tint: Color = gonio.param((1, 1, 1), 0, 1, "factor")
    base: Model = child("eon", "what is tinted")

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        return self.tint * self.base.eval(wi, wo)

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        return self.base.sample(wo, u)

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        return self.base.pdf(wi, wo)


@IN_EACH_PROMISED_VARIANT
def test_inner_models_are_inner_bsdfs(variant: str) -> None:
    """By default, by name, as a BSDF of their own, and twice nested."""
    load(Tinted)
    qon = gonio.QON(rho=0.75, sigma=0.5)
    inner = {"type": "gonio_qon", "rho": 0.75, "sigma": 0.5}
    nested = {"type": f"gonio_{Tinted.name}", "tint": 0.5, "base": inner}
    for given, model in [
        ({}, Tinted()),
        ({"base": "qon"}, Tinted(base="qon")),
        ({"base": inner, "tint": 0.5}, Tinted(base=qon, tint=0.5)),
        ({"base": nested}, Tinted(base=Tinted(base=qon, tint=0.5))),
    ]:
        assert disagreement(load(Tinted, **given), model, 6) < FLOAT32, given
        assert disagreement(mi.load_dict(gonio.mitsuba.node(model)), model, 6) < FLOAT32
    keys = mi.traverse(load(Tinted, base=nested)).keys()
    assert set(keys) == {
        "tint.value",
        "base.tint.value",
        "base.base.rho.value",
        "base.base.sigma.value",
    }


def test_inner_models_must_be_gonios() -> None:
    with pytest.raises(RuntimeError, match="allowed are a BSDF of type gonio_"):
        load(Tinted, base={"type": "diffuse"})
    with pytest.raises(RuntimeError, match="gonio_eeon"):
        load(Tinted, base="eeon")


# --- kernels -------------------------------------------------------------------------------------


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


@EACH
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
    np.testing.assert_allclose(updated, fresh, rtol=1e-6)


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
        np.testing.assert_allclose(frozen(scene).numpy(), expected, rtol=1e-6)


# --- derivatives ---------------------------------------------------------------------------------

SUN = {"type": "directional", "direction": [-1, -0.5, -0.7], "irradiance": 3.0}
SKY = {"type": "constant"}


def ball(bsdf: Any, integrator: Any = "path", emitter: Any = SKY, size: int = 8) -> dict[str, Any]:
    """A sphere that fills a small picture, seen from +z."""
    if isinstance(integrator, str):
        integrator = {"type": integrator, "max_depth": 2}
    to_world = mi.ScalarTransform4f().look_at([0, 0, 6], [0, 0, 0], [0, 1, 0])
    film = {"type": "hdrfilm", "width": size, "height": size, "rfilter": {"type": "box"}}
    film |= {"pixel_format": "luminance" if mi.is_monochromatic else "rgb"}
    return {
        "type": "scene",
        "integrator": integrator,
        "sensor": {"type": "perspective", "fov": 20, "to_world": to_world, "film": film},
        "emitter": emitter,
        "ball": {"type": "sphere", "radius": 2.0, "bsdf": bsdf},
    }


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


@EACH
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


# --- wrappers ------------------------------------------------------------------------------------

ROUGH = {"type": "gonio_eon", "roughness": 1.0, "rho": {"type": "rgb", "value": [0.9, 0.4, 0.1]}}
WI, WO = random_directions(64, 8), random_directions(64, 9)
U = np.random.default_rng(1).random((64, 2), np.float32)


def results(bsdf: Any, wi: Array = WI, wo: Array = WO) -> dict[str, Array]:
    return wiring(bsdf if not isinstance(bsdf, dict) else mi.load_dict(bsdf), wi, wo, U)


def test_blendbsdf_is_the_weighted_mean() -> None:
    smooth = {"type": "gonio_burley_diffuse", "roughness": 0.2}
    wrapper = {"type": "blendbsdf", "weight": 0.3, "first": ROUGH, "second": smooth}
    blend, first, second = results(wrapper), results(ROUGH), results(smooth)
    for name in ("value", "pdf"):
        np.testing.assert_allclose(blend[name], 0.7 * first[name] + 0.3 * second[name], rtol=1e-5)
    albedos = [reflectance(mi.load_dict(bsdf), WO) for bsdf in (wrapper, ROUGH, smooth)]
    np.testing.assert_allclose(albedos[0], 0.7 * albedos[1] + 0.3 * albedos[2], rtol=1e-5)


def test_twosided_is_the_mirror_image_below() -> None:
    below = np.array([1, 1, -1])
    plain, wrapped = results(ROUGH), {"type": "twosided", "bsdf": ROUGH}
    upper, lower = results(wrapped), results(wrapped, WI * below, WO * below)
    for name in ("value", "pdf", "sample_pdf", "weight"):
        np.testing.assert_allclose(upper[name], plain[name], rtol=1e-6)
        np.testing.assert_allclose(lower[name], plain[name], rtol=1e-6)
    np.testing.assert_allclose(lower["sample"], plain["sample"] * below, rtol=1e-6)
    seen = [reflectance(mi.load_dict(wrapped), wo) for wo in (WO, WO * below)]
    np.testing.assert_allclose(seen[1], seen[0], rtol=1e-6)
    for value in ("value", "pdf"):  # light does not pass through
        assert (results(wrapped, WI * below, WO)[value] == 0).all()


def normal_map(normal: Any) -> dict[str, Any]:
    texture = bitmap(tuple(0.5 + 0.5 * np.asarray(normal)))
    return {"type": "normalmap", "normalmap": texture, "bsdf": ROUGH} | {
        "use_shadowing_function": False,
        "flip_invalid_normals": False,
    }


def test_a_flat_normal_map_and_a_flat_bump_map_change_nothing() -> None:
    plain = results(ROUGH)
    bump = {"type": "bumpmap", "arbitrary": bitmap(0.5), "bsdf": ROUGH}
    for wrapped in (normal_map([0, 0, 1]), bump):
        for name, value in results(wrapped).items():
            np.testing.assert_allclose(value, plain[name], rtol=2e-5, atol=1e-6, err_msg=name)


def test_a_tilted_normal_map_tilts_the_directions() -> None:
    a = 0.3
    tilt = np.array([[np.cos(a), 0, -np.sin(a)], [0, 1, 0], [np.sin(a), 0, np.cos(a)]])
    steep = (WI @ tilt.T)[:, 2] * (WO @ tilt.T)[:, 2] > 0
    tilted = results(normal_map([np.sin(a), 0, np.cos(a)]))
    plain = results(ROUGH, WI @ tilt.T, WO @ tilt.T)
    for name in ("value", "pdf"):
        np.testing.assert_allclose(tilted[name][steep], plain[name][steep], rtol=2e-4, atol=1e-5)
    assert np.abs(tilted["value"] - results(ROUGH)["value"]).max() > 0.01


# --- chi² ----------------------------------------------------------------------------------------

# At 4, Mitsuba's default, the trapezoid rule is 1e-4 off at Lambert: more than 1e7 samples forgive.
# Lobes as narrow as 0.05 need this many.
STEPS_PER_CELL = 96
ANGLES = (1.0, 60.0, 85.0)
AZIMUTH = 0.7

# Each of about two hundred tests may fail by chance; all together on one of a hundred machines.
CHI2_TESTS = 200


def chi2(cls: type[Model], degrees: float, **properties: Any) -> tuple[bool, str]:
    """Whether 1e7 samples at a resolution of 31 follow the pdf, and Mitsuba's remarks."""
    gonio.mitsuba.register(cls)
    bsdf, ctx = mi.load_dict({"type": f"gonio_{cls.name}", **properties}), mi.BSDFContext()
    si = interaction(polar(np.radians(degrees), AZIMUTH))
    dr.make_opaque(si.wi)  # one kernel for all angles

    def sample(u: Any) -> tuple[Any, Any]:
        bs, _ = bsdf.sample(ctx, si, u[0], mi.Point2f(u[1], u[2]))
        # mi.chi2.BSDFAdapter tells wasted samples by their weight, but black ones are not wasted.
        return bs.wo, dr.select(bs.pdf > 0, mi.Float(1), 0)

    def pdf(wi: Any) -> Any:
        return bsdf.pdf(ctx, si, wi)

    test = mi.chi2.ChiSquareTest(
        domain=mi.chi2.SphericalDomain(),
        sample_func=sample,
        pdf_func=pdf,
        sample_dim=3,
        sample_count=10_000_000,
        res=31,
        ires=STEPS_PER_CELL,
    )
    return test.run(significance_level=0.01, test_count=CHI2_TESTS, quiet=True), test.messages


@EACH
def test_samples_follow_the_density(cls: type[Model]) -> None:
    """At three angles; at the middle one with every option as well."""
    cases = [(degrees, {}) for degrees in ANGLES] + [(60.0, c) for c in options(cls)[1:]]
    for degrees, choice in cases:
        passed, messages = chi2(cls, degrees, **between(cls, 0.4), **choice)
        assert passed, (degrees, choice, messages)


@pytest.mark.parametrize("sampler", gonio.EON.fields["sampler"].values)
def test_samples_of_eon_follow_the_density(sampler: str) -> None:
    for degrees in ANGLES:
        for roughness in (0.3, 1.0):
            passed, messages = chi2(gonio.EON, degrees, roughness=roughness, sampler=sampler)
            assert passed, (degrees, roughness, messages)


class HalfAPercentOff(gonio.EON, register=False):
    """The lobe's share is 0.5 % too large; the density still sums to 1."""

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        return super().pdf(wi, wo) + 0.005 * (2 * wi.z - 1) * INV_PI


class HalfAPercentTooMuch(Lambertian, register=False):
    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        return super().pdf(wi, wo) * 1.005


class Turned(gonio.EON, register=False):
    """Samples turned by half a degree about the normal."""

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        wi, _ = super().sample(wo, u)
        wi = vec3(wi.x - 0.01 * wi.y, wi.y + 0.01 * wi.x, wi.z)
        return Sample(wi, self.pdf(wi, wo))


class Tilted(Lambertian, register=False):
    """Samples tilted by half a degree."""

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        wi = sample_cosine(u)
        return Sample(vec3(wi.x + 0.01 * wi.z, wi.y, wi.z - 0.01 * wi.x), pdf_cosine(wi))


class CosineForgotten(Lambertian, register=False):
    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        return 0 * wi.z + 0.5 * INV_PI


class RandomNumbersSwapped(gonio.EON, register=False):
    """Right alone, wrong in company: the second number decides on both lobe and azimuth."""

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        return super().sample(wo, vec2(u.y, u.y))


class Unturned(gonio.EON, register=False):
    """Forgets that the viewer has an azimuth."""

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        return super().sample(vec3((1 - wo.z * wo.z) ** 0.5, 0 * wo.z, wo.z), u)


BROKEN = [
    HalfAPercentOff,
    HalfAPercentTooMuch,
    Turned,
    Tilted,
    CosineForgotten,
    RandomNumbersSwapped,
    Unturned,
]


@pytest.mark.parametrize("cls", BROKEN)
def test_chi2_rejects_broken_samplers(cls: type[Model]) -> None:
    given = {"roughness": 1.0} if "roughness" in cls.fields else {}
    passed, messages = chi2(cls, 60, **given)
    assert not passed, messages


def test_chi2_accepts_what_the_broken_samplers_derive_from() -> None:
    assert chi2(Lambertian, 60)[0]
    assert chi2(gonio.EON, 60, roughness=1.0)[0]


# --- pictures ------------------------------------------------------------------------------------


def room(bsdf: Any, depth: int) -> dict[str, Any]:
    """A ball on a ground of the same material under a constant sky: light goes back and forth."""
    scene = ball(bsdf, {"type": "path", "max_depth": depth, "rr_depth": depth}, size=16)
    ground = mi.ScalarTransform4f().translate([0, -2, 0]).rotate([1, 0, 0], -90).scale(20)
    scene["ground"] = {"type": "rectangle", "to_world": ground, "bsdf": bsdf}
    scene["ball"]["center"] = [0, 0, 0]
    to_world = mi.ScalarTransform4f().look_at([0, 8, 8], [0, -1, 0], [0, 1, 0])
    scene["sensor"] |= {"to_world": to_world, "fov": 40}
    return scene


WHITE = {"type": "rgb", "value": [1, 1, 1]}


def test_white_eon_vanishes_in_a_furnace() -> None:
    """Light bounces until it finds a way out; a loss of 0.1 % on the way would show."""
    bsdf = {"type": "gonio_eon", "rho": WHITE, "roughness": 1.0}
    picture = mi.render(mi.load_dict(room(bsdf, 100)), spp=1024, seed=1).numpy()
    assert picture.mean() == pytest.approx(1, abs=1e-3)
    np.testing.assert_allclose(picture, 1, atol=0.06)  # five standard errors of a pixel


def test_qon_does_not() -> None:
    bsdf = {"type": "gonio_qon", "rho": WHITE, "sigma": 1.57}
    picture = mi.render(mi.load_dict(room(bsdf, 100)), spp=256, seed=1).numpy()
    assert picture.max() < 0.9
    assert picture.min() < 0.55


ANCHORS = [
    row
    for row in csv.DictReader(
        Path(__file__).with_name("anchors.csv").read_text(encoding="utf-8").splitlines()
    )
    if row["quantity"] == "albedo" and json.loads(row["wo"])[2] > 0.05
]


def plate(bsdf: Any, wo: Any) -> tuple[float, float]:
    """Mean and standard error of the 32² pixels of a plate that fills a picture taken from wo."""
    scene = ball(bsdf, {"type": "direct", "emitter_samples": 0, "bsdf_samples": 1}, size=32)
    scene["ball"] = {"type": "rectangle", "to_world": mi.ScalarTransform4f().scale(1000)}
    scene["ball"]["bsdf"] = bsdf
    to_world = mi.ScalarTransform4f().look_at([float(1000 * c) for c in wo], [0, 0, 0], [0, 1, 0])
    scene["sensor"] |= {"type": "orthographic", "to_world": to_world}
    del scene["sensor"]["fov"]
    pixels = mi.render(mi.load_dict(scene), spp=1024, seed=4).numpy().mean(axis=2)
    return float(pixels.mean()), float(pixels.std() / 32)


def anchored_parameters(row: dict[str, str]) -> dict[str, Any]:
    return {
        k: tuple(v) if isinstance(v, list) else v for k, v in json.loads(row["parameters"]).items()
    }


@EACH
def test_a_plate_under_a_white_sky_shows_the_albedo(cls: type[Model]) -> None:
    """The numbers come from outside: up to three of each model's in anchors.csv."""
    rows = [row for row in ANCHORS if row["model"] == cls.name]
    for row in rows[:: max(len(rows) // 3, 1)][:3]:
        bsdf = gonio.mitsuba.node(cls(**anchored_parameters(row)))
        found, error = plate(bsdf, json.loads(row["wo"]))
        expected = float(np.mean(json.loads(row["value"])))
        digits = 6e-4 if row["source"].startswith("published") else 1e-5
        assert error < 1e-3
        assert found == pytest.approx(expected, abs=4 * error + digits), row


def test_plates_have_been_seen() -> None:
    models = {row["model"] for row in ANCHORS}
    assert {"lambert", "eon", "fon", "qon", "oren_nayar", "burley_diffuse"} <= models


def test_a_plate_shows_an_error_of_half_a_percent() -> None:
    class Brighter(gonio.QON, register=False):
        def eval(self, wi: Vec3, wo: Vec3) -> Color:
            return super().eval(wi, wo) * 1.005

    gonio.mitsuba.register(Brighter)
    wo = polar(np.radians(60))
    right = gonio.QON(rho=1, sigma=1)
    expected = float(right.albedo(wo)[0])
    found, error = plate(gonio.mitsuba.node(right), wo)
    assert found == pytest.approx(expected, abs=4 * error)
    found, error = plate(gonio.mitsuba.node(Brighter(rho=1, sigma=1)), wo)
    assert found > expected + 5 * error


def rgb(value: Any) -> dict[str, Any]:
    return {"type": "rgb", "value": [float(v) for v in value]}


def test_lambert_renders_like_mitsubas_diffuse() -> None:
    """The same light samples give the same picture; BSDF samples are drawn in another order."""
    colour = {
        "type": "checkerboard",
        "color0": rgb([0.9, 0.4, 0.1]),
        "color1": rgb([0.1, 0.5, 0.9]),
    }
    ours = {"type": "gonio_lambert", "rho": colour}
    theirs = {"type": "diffuse", "reflectance": colour}
    lights = {"type": "direct", "emitter_samples": 4, "bsdf_samples": 0}
    a, b = (
        mi.render(mi.load_dict(ball(m, lights, size=32)), spp=4, seed=1).numpy()
        for m in (ours, theirs)
    )
    np.testing.assert_allclose(a, b, rtol=1e-5)
    a, b = (
        mi.render(mi.load_dict(room(m, 8)), spp=1024, seed=seed).numpy()
        for m, seed in ((ours, 1), (theirs, 2))
    )
    # Two pictures of about 0.5, each with a standard error of 0.005 per pixel.
    assert np.sqrt(np.mean((a - b) ** 2)) < 0.01
    assert a.mean() == pytest.approx(b.mean(), abs=1e-3)


@IN_EACH_VARIANT
def test_every_variant_renders(variant: str) -> None:
    """A rough ball in a furnace, integrator and all; the polarised ones lose nothing either."""
    integrator = {"type": "path", "max_depth": 3}
    if mi.is_polarized:
        integrator = {"type": "stokes", "nested": integrator}
    bsdf = {"type": "gonio_eon", "rho": 1.0, "roughness": 1.0}
    picture = np.array(mi.render(mi.load_dict(ball(bsdf, integrator)), spp=16, seed=2))
    # Luminance, or the first of colour and Stokes vector.
    assert picture[..., 0].mean() == pytest.approx(1, abs=0.05)


def test_the_albedo_picture_holds_the_albedo() -> None:
    """What denoisers ask for."""
    for name in ("eon", "oren_nayar"):  # closed form and quadrature
        scene = ball({"type": f"gonio_{name}", "rho": 0.6}, {"type": "aov", "aovs": "a:albedo"})
        scene["ball"] = {"type": "rectangle", "to_world": mi.ScalarTransform4f().scale(9)}
        scene["ball"]["bsdf"] = {"type": f"gonio_{name}", "rho": 0.6}
        picture = mi.render(mi.load_dict(scene), spp=4).numpy()
        expected = gonio.model(name, rho=0.6).albedo([0, 0, 1])
        np.testing.assert_allclose(picture[4, 4, -3:], expected, rtol=2e-3)


# --- life ----------------------------------------------------------------------------------------


def test_objects_outlive_a_change_of_variant() -> None:
    before = mi.load_dict({"type": "gonio_eon"})
    ctx, si, wi = mi.BSDFContext(), interaction(WO), vector(WI)
    expected = before.eval(ctx, si, wi).numpy()
    for other in RUNNABLE:
        mi.set_variant(other)
        mi.load_dict({"type": "gonio_eon"})
        value, _ = before.eval_pdf(ctx, si, wi)
        np.testing.assert_allclose(value.numpy(), expected, rtol=1e-6)
        before.sample(ctx, si, 0.5, si.uv)
        assert before.eval_diffuse_reflectance(si).x[0] > 0
    mi.set_variant("llvm_ad_rgb")
    again = mi.load_dict({"type": "gonio_eon"})
    assert type(again) is type(before)
    assert (again.eval(mi.BSDFContext(), si, wi).numpy() == expected).all()


def test_a_dictionary_loads_twice() -> None:
    scene = ball({"type": "gonio_eon", "roughness": bitmap(0.25, 0.75)})
    first, second = (mi.render(mi.load_dict(scene), spp=1, seed=1).numpy() for _ in range(2))
    assert (first == second).all()


def test_objects_are_freed() -> None:
    def alive() -> int:
        gc.collect()
        return sum(type(o).__name__ == "Plugin" for o in gc.get_objects())

    before = alive()
    scenes = [mi.load_dict(ball({"type": "gonio_eon"})) for _ in range(5)]
    mi.render(scenes[0], spp=1)
    assert alive() == before + 5
    del scenes
    assert alive() == before


def test_threads_do_not_disturb_each_other() -> None:
    def work(number: int) -> Array:
        return grey_value(mi.load_dict({"type": "gonio_eon", "roughness": number / 32}))

    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(work, range(32)))
    assert (np.array(together) == np.array([work(number) for number in range(32)])).all()


def test_a_redefined_model_replaces_the_old_one() -> None:
    """As it happens in notebooks."""

    def define(factor: float) -> type[Model]:
        class Notebook(Lambertian, register=False):
            def eval(self, wi: Vec3, wo: Vec3) -> Color:
                return super().eval(wi, wo) * factor

        return Notebook

    first, second = grey_value(load(define(1.0))), grey_value(load(define(0.5)))
    np.testing.assert_allclose(second, 0.5 * first, rtol=1e-6)


def run(code: str, *flags: str, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, *flags, "-c", code],
        env={k: v for k, v in os.environ.items() if k != "DRJIT_LIBLLVM_PATH"} | environment,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


def test_a_users_own_model_is_a_plugin_after_register() -> None:
    code = """
import gonio.mitsuba, gonio, mitsuba as mi
mi.set_variant("llvm_ad_rgb")
class FlatGrey(gonio.Model):
    value: gonio.lang.Float = gonio.param(0.25, 0, 1, "value")
    def eval(self, wi, wo): return 0 * wi + self.value
    def sample(self, wo, u): return gonio.Sample(wo, 1 + 0 * u.x)
    def pdf(self, wi, wo): return 0 * wi.z + 1
gonio.mitsuba.register()
print(mi.load_dict({"type": "gonio_flat_grey", "value": 0.75}))
mi.set_variant("llvm_ad_mono")
print(mi.load_dict({"type": "gonio_flat_grey", "value": 0.75}))
"""
    done = run(code, "-W", "error")
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("gonio_flat_grey[") == 2


MITSUBA_FIRST = """
import drjit as dr, mitsuba as mi
{disguise}
import gonio, gonio.mitsuba
mi.set_variant("scalar_rgb")
print(mi.load_dict({{"type": "gonio_eon"}}))
try:
    mi.set_variant("llvm_ad_rgb")
    bsdf = mi.load_dict({{"type": "gonio_eon"}})
    si = dr.zeros(mi.SurfaceInteraction3f)
    si.wi = [0, 0, 1]
    print("value", bsdf.eval(mi.BSDFContext(), si, mi.Vector3f([0, 0.6], 0, [1, 0.8])))
except (gonio.BackendError, ImportError) as error:
    print("error", error)
"""
REMEDY = "import gonio.mitsuba before mitsuba and drjit, or set DRJIT_LIBLLVM_PATH="


def test_importing_mitsuba_first_works_or_says_what_to_do() -> None:
    """Whatever LLVM the system has: the process must not be ended by it."""
    done = run(MITSUBA_FIRST.format(disguise=""))
    assert done.returncode == 0, done.stderr
    assert "gonio_eon[" in done.stdout
    assert "value [[" in done.stdout or ("error" in done.stdout and REMEDY in done.stderr)


OLD_LLVM = "dr.detail.llvm_version = lambda: (15, 0, 6)"
NO_LLVM = "dr.detail.llvm_version = lambda: (-1, -1, -1)"


@pytest.mark.parametrize(("disguise", "named"), [(OLD_LLVM, "LLVM 15"), (NO_LLVM, "no LLVM")])
def test_an_llvm_that_was_loaded_too_early_is_refused(disguise: str, named: str) -> None:
    """The process would end with "Cannot select: fmaximum" at the first kernel."""
    done = run(MITSUBA_FIRST.format(disguise=disguise))
    assert done.returncode == 0, done.stderr
    assert "gonio_eon[" in done.stdout  # scalar variants need no LLVM
    assert f"UserWarning: Dr.Jit has loaded {named}" in done.stderr
    assert REMEDY in done.stderr
    if named == "LLVM 15":
        assert "error Dr.Jit has loaded LLVM 15, and Mitsuba's llvm variants need 16" in done.stdout
        assert REMEDY in done.stdout


def test_an_old_llvm_is_refused_on_import_too() -> None:
    done = run(
        "import drjit as dr, mitsuba as mi\nmi.set_variant('llvm_ad_rgb')\n"
        f"{OLD_LLVM}\nimport gonio.mitsuba",
        DRJIT_LIBLLVM_PATH=os.environ["DRJIT_LIBLLVM_PATH"],
    )
    assert done.returncode == 1
    assert REMEDY in done.stderr.splitlines()[-1]


def test_a_bare_import_chooses_no_variant_and_warns_of_nothing() -> None:
    done = run("import gonio.mitsuba, mitsuba as mi; print(mi.variant())", "-W", "error")
    assert (done.returncode, done.stdout.strip()) == (0, "None"), done.stderr
