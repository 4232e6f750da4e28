"""Every registered model as a Mitsuba BSDF: parameters, textures and inner models."""

from __future__ import annotations

from typing import Any

import mitsuba as mi
import numpy as np
import pytest
from support.directions import Array, polar
from support.plugins import (
    EACH,
    FLOAT32,
    IN_EACH_PROMISED_VARIANT,
    IN_EACH_VARIANT,
    Lambertian,
    bitmap,
    disagreement,
    grey_value,
    load,
    numbers,
)
from support.tolerances import DOUBLE_DIVIDED, SINGLE

import gonio.mitsuba
from gonio.lang import Color, Float, Sample, Vec2, Vec3
from gonio.model import Model, child


def expected_value(model: Model) -> Array:
    return np.asarray(model.eval(polar(1.0, 2), polar(0.4)) * np.cos(1.0))


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
        np.testing.assert_allclose(found, 4 * np.cos(1.0), rtol=SINGLE)
    if mi.is_spectral:
        hue = load(Bright, index={"type": "rgb", "value": [4, 2, 1]})
        plain = load(Bright, index={"type": "rgb", "value": [1, 0.5, 0.25]})
        np.testing.assert_allclose(grey_value(hue), 4 * grey_value(plain), rtol=SINGLE)


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
            np.testing.assert_allclose(
                grey_value(bsdf, uv), expected, rtol=FLOAT32, atol=DOUBLE_DIVIDED
            )


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
    (
        {"reflectance": 0.5},
        "known are rho, roughness, albedo_form, color_shift, sampler, sampling.",
    ),
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
    assert f"known are {', '.join([*cls.fields, 'sampling'])}." in str(raised.value)


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
