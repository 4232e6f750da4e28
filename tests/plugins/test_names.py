"""Metals and materials by name in Mitsuba's scenes, and what is said about slow variants."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest
from support.tolerances import SINGLE, SINGLE_LONG

import gonio
import gonio.mitsuba
from gonio.materials import load
from gonio.mitsuba import node
from gonio.parts.metals import metal


@pytest.fixture(autouse=True)
def _variant() -> None:
    mi.set_variant("llvm_ad_rgb")


def value(bsdf: Any) -> Any:
    si = dr.zeros(mi.SurfaceInteraction3f, 1)
    si.wi, si.uv = mi.Vector3f(-0.4, 0.2, 0.8944), mi.Point2f(0.5, 0.5)
    si.n, si.sh_frame = mi.Normal3f(0, 0, 1), mi.Frame3f(mi.Normal3f(0, 0, 1))
    return np.array(bsdf.eval(mi.BSDFContext(), si, mi.Vector3f(0.3, -0.1, 0.9487))).ravel()


def xml(kind: str, inside: str) -> Any:
    return mi.load_string(f'<bsdf version="3.0.0" type="{kind}">{inside}</bsdf>')


METAL = '<string name="metal" value="{}"/>'


@pytest.mark.parametrize("symbol", ["Cu", "Au", "Cr"])
def test_a_metal_is_its_index_and_extinction(symbol: str) -> None:
    named = xml("gonio_torrance_sparrow", METAL.format(symbol))
    indices = {k: {"type": "rgb", "value": list(v)} for k, v in metal(symbol).items()}
    given = mi.load_dict({"type": "gonio_torrance_sparrow", **indices})
    np.testing.assert_allclose(value(named), value(given), rtol=SINGLE_LONG)
    neutral = xml(
        "gonio_torrance_sparrow", METAL.format(symbol) + '<boolean name="neutral" value="true"/>'
    )
    indices = {k: {"type": "rgb", "value": list(v)} for k, v in metal(symbol, neutral=True).items()}
    given = mi.load_dict({"type": "gonio_torrance_sparrow", **indices})
    np.testing.assert_allclose(value(neutral), value(given), rtol=SINGLE_LONG)


def test_a_dielectric_is_its_index() -> None:
    named = mi.load_dict({"type": "gonio_weidlich_wilkie", "eta": "water"})
    assert str(named) == str(mi.load_dict({"type": "gonio_weidlich_wilkie", "eta": 1.333}))
    named = mi.load_dict({"type": "gonio_torrance_sparrow", "eta": "water"})
    plain = mi.load_dict({"type": "gonio_torrance_sparrow", "eta": 1.333, "k": 0.0})
    np.testing.assert_array_equal(value(named), value(plain))
    for given in ({"eta": "watter"}, {"alpha": "water"}):
        with pytest.raises(RuntimeError, match=r"did you mean 'water'|alpha is a str"):
            mi.load_dict({"type": "gonio_weidlich_wilkie", **given})


def test_a_models_file_may_have_a_name_that_is_no_utf8(tmp_path: Path) -> None:
    text = Path(gonio.models()["lambert"].__module__.replace(".", "/") + ".py")
    source = (Path(gonio.__file__).parents[1] / text).read_bytes()
    file = Path(os.fsdecode(os.fsencode(tmp_path) + b"/lambert\xff.py"))
    file.write_bytes(source)
    loaded = gonio.load(file)
    np.testing.assert_array_equal(
        value(mi.load_dict(node(loaded))), value(mi.load_dict(node(gonio.model("lambert"))))
    )


def test_a_metal_stands_below_a_coat_and_in_a_paint() -> None:
    coated = xml(
        "gonio_weidlich_wilkie",
        f'<bsdf type="gonio_torrance_sparrow" name="base">{METAL.format("Cu")}</bsdf>',
    )
    plain = gonio.model("weidlich_wilkie", base=gonio.model("torrance_sparrow", **metal("Cu")))
    np.testing.assert_allclose(value(coated), value(mi.load_dict(node(plain))), rtol=SINGLE_LONG)
    paint = xml("gonio_car_paint", METAL.format("Al"))
    values = {f"metal_{name}": v for name, v in metal("Al").items()}
    plain = gonio.model("car_paint", **values)
    np.testing.assert_allclose(value(paint), value(mi.load_dict(node(plain))), rtol=SINGLE_LONG)


@pytest.mark.parametrize(
    ("kind", "inside", "message"),
    [
        ("gonio_torrance_sparrow", METAL.format("Xx"), "Xx"),
        ("gonio_eon", METAL.format("Cu"), "eon has no eta and k"),
        (
            "gonio_torrance_sparrow",
            METAL.format("Cu") + '<rgb name="k" value="1, 1, 1"/>',
            "metal already says what k is",
        ),
        (
            "gonio_torrance_sparrow",
            '<boolean name="neutral" value="true"/>',
            "no property 'neutral'",
        ),
        ("gonio_material", "", "either a name or a file"),
        ("gonio_material", '<string name="name" value="goldd"/>', "goldd"),
        ("gonio_material", '<string name="file" value="none.toml"/>', "none.toml"),
        ("gonio_material", '<float name="name" value="3"/>', "takes a string"),
    ],
)
def test_a_wrong_name_is_an_error_that_says_so(kind: str, inside: str, message: str) -> None:
    with pytest.raises(RuntimeError, match=message):
        xml(kind, inside)


def test_a_ready_material_is_a_plug_in_by_its_name() -> None:
    for text in ("lacquered_walnut", "gold:alpha=0.3", "eon:roughness=1"):
        named = xml("gonio_material", f'<string name="name" value="{text}"/>')
        np.testing.assert_allclose(value(named), value(mi.load_dict(node(load(text)))), rtol=SINGLE)


def test_a_material_file_lies_beside_the_scene(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from gonio.render.user_scene import render_scene

    (tmp_path / "scene").mkdir()
    (tmp_path / "scene" / "m.toml").write_text('model = "lambert"\nrho = [0.25, 0.5, 0.75]\n')
    text = """<scene version="3.0.0"><integrator type="path"/><emitter type="constant"/>
      <sensor type="orthographic">
        <transform name="to_world"><lookat origin="0,0,4" target="0,0,0" up="0,1,0"/></transform>
        <film type="hdrfilm"><integer name="width" value="8"/><integer name="height" value="8"/></film>
      </sensor>
      <shape type="rectangle"><transform name="to_world"><scale value="3"/></transform>
        <bsdf type="gonio_material"><string name="file" value="m.toml"/></bsdf></shape></scene>"""
    path = tmp_path / "scene" / "scene.xml"
    path.write_text(text)
    monkeypatch.chdir(tmp_path)
    found = render_scene(path, {}, spp=64).mean(axis=(0, 1))
    np.testing.assert_allclose(found, [0.25, 0.5, 0.75], rtol=0.02)  # noise


def test_scalar_variants_are_said_to_be_slow_once(capfd: pytest.CaptureFixture[str]) -> None:
    from gonio.mitsuba import properties

    properties._slow.clear()
    mi.set_variant("scalar_rgb")
    for _ in range(2):
        mi.load_dict({"type": "gonio_eon"})
    said = capfd.readouterr()
    text = said.out + said.err
    assert text.count("hundreds of times as long") == 1
    assert "llvm_ad_rgb" in text
    mi.set_variant("llvm_ad_rgb")
    mi.load_dict({"type": "gonio_eon"})
    said = capfd.readouterr()
    assert "hundreds" not in said.out + said.err
