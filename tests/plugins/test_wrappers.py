"""Every registered model as a Mitsuba BSDF: Mitsuba's own wrappers around it."""

from __future__ import annotations

from typing import Any

import mitsuba as mi
import numpy as np
from support.directions import Array
from support.plugins import WI, WO, bitmap, reflectance, wiring
from support.tolerances import SINGLE, SINGLE_LONG

ROUGH = {"type": "gonio_eon", "roughness": 1.0, "rho": {"type": "rgb", "value": [0.9, 0.4, 0.1]}}
U = np.random.default_rng(1).random((64, 2), np.float32)


def results(bsdf: Any, wi: Array = WI, wo: Array = WO) -> dict[str, Array]:
    return wiring(bsdf if not isinstance(bsdf, dict) else mi.load_dict(bsdf), wi, wo, U)


def test_blendbsdf_is_the_weighted_mean() -> None:
    smooth = {"type": "gonio_burley_diffuse", "roughness": 0.2}
    wrapper = {"type": "blendbsdf", "weight": 0.3, "first": ROUGH, "second": smooth}
    blend, first, second = results(wrapper), results(ROUGH), results(smooth)
    for name in ("value", "pdf"):
        np.testing.assert_allclose(
            blend[name], 0.7 * first[name] + 0.3 * second[name], rtol=SINGLE_LONG
        )
    albedos = [reflectance(mi.load_dict(bsdf), WO) for bsdf in (wrapper, ROUGH, smooth)]
    np.testing.assert_allclose(albedos[0], 0.7 * albedos[1] + 0.3 * albedos[2], rtol=SINGLE_LONG)


def test_twosided_is_the_mirror_image_below() -> None:
    below = np.array([1, 1, -1])
    plain, wrapped = results(ROUGH), {"type": "twosided", "bsdf": ROUGH}
    upper, lower = results(wrapped), results(wrapped, WI * below, WO * below)
    for name in ("value", "pdf", "sample_pdf", "weight"):
        np.testing.assert_allclose(upper[name], plain[name], rtol=SINGLE)
        np.testing.assert_allclose(lower[name], plain[name], rtol=SINGLE)
    np.testing.assert_allclose(lower["sample"], plain["sample"] * below, rtol=SINGLE)
    seen = [reflectance(mi.load_dict(wrapped), wo) for wo in (WO, WO * below)]
    np.testing.assert_allclose(seen[1], seen[0], rtol=SINGLE)
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
            np.testing.assert_allclose(value, plain[name], rtol=SINGLE, atol=SINGLE, err_msg=name)


def test_a_tilted_normal_map_tilts_the_directions() -> None:
    a = 0.3
    tilt = np.array([[np.cos(a), 0, -np.sin(a)], [0, 1, 0], [np.sin(a), 0, np.cos(a)]])
    steep = (WI @ tilt.T)[:, 2] * (WO @ tilt.T)[:, 2] > 0
    tilted = results(normal_map([np.sin(a), 0, np.cos(a)]))
    plain = results(ROUGH, WI @ tilt.T, WO @ tilt.T)
    for name in ("value", "pdf"):
        np.testing.assert_allclose(
            tilted[name][steep], plain[name][steep], rtol=SINGLE_LONG, atol=SINGLE
        )
    assert np.abs(tilted["value"] - results(ROUGH)["value"]).max() > 0.01
