"""Every registered model as a Mitsuba BSDF: pictures."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np
import pytest
from support.directions import polar
from support.plugins import EACH, IN_EACH_VARIANT, ball
from support.tolerances import SINGLE_LONG

import gonio.mitsuba
from gonio.lang import Color, Vec3
from gonio.model import Model


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
    # The loss that the docstring speaks of
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
        Path(__file__).parent.with_name("anchors.csv").read_text(encoding="utf-8").splitlines()
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
        # The estimate's own error, small enough to judge
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
    np.testing.assert_allclose(a, b, rtol=SINGLE_LONG)
    a, b = (
        mi.render(mi.load_dict(room(m, 8)), spp=1024, seed=seed).numpy()
        for m, seed in ((ours, 1), (theirs, 2))
    )
    # Two pictures of about 0.5, each with a standard error of 0.005 per pixel.
    assert np.sqrt(np.mean((a - b) ** 2)) < 0.01
    # The mean over all pixels is much better known than one
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
        np.testing.assert_allclose(picture[4, 4, -3:], expected, rtol=SINGLE_LONG)
