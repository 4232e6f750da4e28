"""The picture around the object: framing, ground, transparency, exposure and curves, and their options."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image
from support.tolerances import DOUBLE_DIVIDED, SINGLE_LONG

import gonio
from gonio.cli import main
from gonio.render import render
from gonio.render.picture import write_picture
from gonio.render.stage import (
    BALL_DISTANCE,
    FIELD_OF_VIEW,
    FILLED,
    FROM_ABOVE,
    VIEW,
    _fitted,
    shader_ball,
    usual_view,
)
from gonio.render.tone import TONES, to_srgb


@pytest.fixture(autouse=True)
def _variant() -> None:
    mi.set_variant("llvm_ad_rgb")


# ---------------------------------------------------------------------------------------- framing


@settings(max_examples=50, deadline=None)
@given(
    st.tuples(*[st.floats(0.02, 1.0)] * 3),
    st.floats(-180, 180),
    st.floats(-90, 90),
    st.sampled_from([(100, 100), (192, 108), (50, 200)]),
)
def test_a_mesh_of_any_proportions_fills_the_frame(
    half: tuple[float, float, float], azimuth: float, elevation: float, size: tuple[int, int]
) -> None:
    """A pinhole's projection of a box: inside of the frame, and at its inner edges across or up."""
    signs = np.array(np.meshgrid(*[(-1, 1)] * 3)).reshape(3, -1).T
    points = signs * half + [0, 1, 0]
    place = _fitted(points, (azimuth, elevation), size)
    a, e = np.radians([azimuth, elevation])
    back = np.array([np.cos(e) * np.sin(a), np.sin(e), np.cos(e) * np.cos(a)])
    right = np.array([np.cos(a), 0, -np.sin(a)])
    up = np.cross(back, right)
    seen = points - place
    depth = -seen @ back
    assert depth.min() > 0
    edge = FILLED * np.tan(np.radians(FIELD_OF_VIEW / 2)) * np.array(size) / min(size)
    low, high = (
        np.array([extreme((seen @ axis) / depth) for axis in (right, up)]) / edge
        for extreme in (np.min, np.max)
    )
    np.testing.assert_allclose(np.maximum(-low, high).max(), 1, rtol=DOUBLE_DIVIDED)
    touching = int(np.argmax(np.maximum(-low, high)))
    assert low[touching] == pytest.approx(-1)  # both sides of that direction, so it is centred
    assert high[touching] == pytest.approx(1)
    assert (np.maximum(-low, high) <= 1 + 1e-9).all()


# ------------------------------------------------------------------------------ ground and background


def sky(path: Path, level: float = 0.5) -> Path:
    mi.Bitmap(np.full((16, 32, 3), level, np.float32)).write(str(path))
    return path


def test_a_flat_thing_is_looked_at_from_higher_up() -> None:
    def box(height: float) -> np.ndarray:
        return np.array(list(itertools.product((-1, 1), (0, height), (-0.7, 0.7))), float)

    elevations = [usual_view(box(height))[1] for height in (2.0, 0.7, 0.4, 0.2, 0.1, 0.0)]
    assert elevations[:2] == [VIEW[1]] * 2, "a bust and a car are seen from the front"
    assert elevations == sorted(elevations)
    assert elevations[-1] == FROM_ABOVE


def test_the_ground_has_no_edge_and_catches_shadow(tmp_path: Path) -> None:
    """Uniform light: without shadow the ground would be as bright as what is behind it."""
    common: Any = {"environment": sky(tmp_path / "a.exr"), "size": (64, 64), "spp": 64}
    picture = render(gonio.Lambert(rho=0.5), **common).mean(axis=2)
    bare = render(gonio.Lambert(rho=0.5), ground=False, **common).mean(axis=2)
    # The picture of the sky has half floats
    np.testing.assert_allclose(bare[:, :4], 0.5, rtol=1e-3)
    assert picture[58, 32] < 0.9 * bare[58, 32]  # before the pedestal
    np.testing.assert_allclose(picture[:4], 0.5, rtol=0.01)
    column = picture[:, 2]
    # From the background down to the ground the brightness changes by noise (1 %) and shadow alone.
    assert np.abs(np.diff(column)).max() < 0.03


def test_a_transparent_background_has_alpha_and_straight_colours(tmp_path: Path) -> None:
    picture = render(gonio.Lambert(rho=0.5), transparent=True, size=(48, 48), spp=16)
    assert picture.shape == (48, 48, 4)
    np.testing.assert_array_equal(picture[0, 0], 0)
    assert picture[20, 30, 3] == pytest.approx(1, abs=SINGLE_LONG)
    write_picture(tmp_path / "a.png", picture)
    shown = np.asarray(Image.open(tmp_path / "a.png"))
    assert shown.shape == (48, 48, 4)
    np.testing.assert_array_equal(shown[20, 30, :3], to_srgb(picture[20:21, 30:31, :3])[0, 0])
    rim = np.array([[[0.1, 0.1, 0.1, 0.5]]], np.float32)  # half a pixel of 0.2
    whole = np.array([[[0.2, 0.2, 0.2]]], np.float32)
    np.testing.assert_array_equal(to_srgb(rim)[0, 0, :3], to_srgb(whole)[0, 0])
    assert to_srgb(rim)[0, 0, 3] == 128
    write_picture(tmp_path / "a.exr", picture)
    np.testing.assert_array_equal(np.array(mi.Bitmap(str(tmp_path / "a.exr"))), picture)


def test_zoom_is_a_longer_lens_and_camera_goes_around() -> None:
    dark: Any = {"size": (64, 64), "spp": 4, "furnace": True}
    once = (render(gonio.Lambert(rho=0), **dark)[..., 0] < 0.5).sum()
    twice = (render(gonio.Lambert(rho=0), zoom=1.5, **dark)[..., 0] < 0.5).sum()
    assert twice / once == pytest.approx(1.5**2, rel=0.05)  # 64 pixels have rims
    front = render(gonio.EON(), environment="front", size=(32, 32), spp=16)
    behind = render(gonio.EON(), environment="front", size=(32, 32), spp=16, camera=(180, 13))
    assert front[14:18, 18:24].mean() > 3 * behind[14:18, 18:24].mean()  # the lamp is at the front


def test_straight_down_is_turned_as_almost_straight_down_is() -> None:
    straight, almost = (
        np.array(shader_ball({"type": "diffuse"}, camera=(40, e))["sensor"]["to_world"].matrix)
        for e in (90, 89.99)
    )
    # A hundredth of a degree at the distance of the camera
    np.testing.assert_allclose(straight, almost, atol=1.1 * np.radians(0.01) * BALL_DISTANCE)


@pytest.mark.parametrize(
    ("stage", "message"),
    [
        ({"camera": (0, -10)}, "below the ground"),
        ({"camera": (0, 91)}, "elevation from -90 to 90"),
        ({"camera": (np.nan, 0)}, "elevation from -90 to 90"),
        ({"environment_turn": np.nan}, "environment_turn=nan is not a finite number"),
        ({"noise": np.inf}, "noise=inf is out of range; allowed is a finite number above 0"),
        ({"seconds": np.nan}, "seconds=nan is out of range"),
        ({"zoom": 0}, "zoom=0 is out of range"),
        ({"uv": "box"}, "uv is for a mesh"),
        ({"environment_turn": 30}, "'studio' is not a picture that could be turned"),
        ({"furnace": True, "transparent": True}, "the furnace is radiance 1"),
    ],
)
def test_a_view_that_shows_nothing_is_refused(stage: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        render(gonio.EON(), size=(8, 8), spp=1, **stage)


# ------------------------------------------------------------------------------------------- curves


def shown(light: float, tone: str) -> float:
    return float(TONES[tone](np.full((1, 1, 3), light, np.float32))[0, 0, 0])


def test_curves_keep_middle_grey_and_never_turn_back() -> None:
    for tone in TONES:
        # AgX's pivot is 0.18 at the middle of the codes, which its polynomial meets within a hundredth.
        grey, error = (0.5**2.2, 0.01) if tone == "agx" else (0.18, 1e-4)
        assert shown(0.18, tone) == pytest.approx(grey, abs=error)
        ramp = np.logspace(-4, 3, 400, dtype=np.float32)[None, :, None].repeat(3, axis=2)
        curve = TONES[tone](ramp)
        assert (np.diff(curve[0, :, 0]) >= -1e-3).all()
        np.testing.assert_allclose(curve[..., 0], curve[..., 2], atol=2e-3)  # grey stays grey
        assert curve.min() >= 0
        assert 0.95 < shown(100.0, tone) <= 1
    # Narkowicz's formula at 1, by hand: 2.54 / 3.16
    assert shown(1 / 0.7232, "filmic") == pytest.approx(2.54 / 3.16, rel=SINGLE_LONG)


def test_agx_turns_bright_saturated_light_towards_white() -> None:
    red = np.array([[[50.0, 0.0, 0.0]]], np.float32)
    assert TONES["linear"](red)[0, 0, 1] == 0
    assert TONES["agx"](red)[0, 0, 1] > 0.3


def test_an_unknown_curve_or_exposure_is_one_line() -> None:
    grey = np.full((1, 1, 3), 0.5, np.float32)
    with pytest.raises(ValueError, match="no tone curve 'aces'; known are linear, filmic, agx"):
        to_srgb(grey, tone="aces")
    with pytest.raises(ValueError, match="exposure=nan is not a finite number"):
        to_srgb(grey, exposure=float("nan"))


# ------------------------------------------------------------------------------------ command line


def test_a_file_of_light_is_exposed_and_said(tmp_path: Path) -> None:
    """Uniform light of 200: white needs log2(0.9 / 200) = -7.8 stops, and then is 0.9."""
    path = sky(tmp_path / "bright.exr", 200.0)
    small = ["--size", "24", "--spp", "4"]
    target = str(tmp_path / "a.png")
    result = CliRunner().invoke(
        main, ["render", "lambert:rho=1", "--env", str(path), "--no-ground", *small, "-o", target]
    )
    assert result.exit_code == 0, result.output
    assert "gonio: note: exposure -7.8 stops" in result.stderr
    corner = np.asarray(Image.open(target))[0, 0]
    np.testing.assert_array_equal(corner, to_srgb(np.full((1, 1, 3), 0.9, np.float32))[0, 0])
    result = CliRunner().invoke(
        main, ["render", "lambert", "--env", str(path), "--exposure", "0", *small, "-o", target]
    )
    assert "exposure" not in result.stderr
    assert np.asarray(Image.open(target))[0, 0, 0] == 255


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--turn", "3"], "--turn is for your own mesh"),
        (
            ["--furnace", "--env", "sun"],
            "--furnace is radiance 1 from everywhere; drop it, or --env",
        ),
        (["--furnace", "--env", "studio"], "--furnace is radiance 1 from everywhere"),
        (["--furnace", "--exposure", "auto"], "--furnace has nothing to find an exposure for"),
        (["-o", ""], "the output has no name"),
        (["--uv", "box"], "--uv is for your own mesh"),
        (["--exposure", "nan"], "'nan' is not a finite number of stops or auto"),
        (["--exposure", "1", "-o", "a.exr"], "--exposure is for a .png"),
        (["--tone", "agx", "-o", "a.exr"], "--tone is for a .png"),
        (["--camera", "3"], "is not AZIMUTH,ELEVATION"),
        (["--transparent", "--no-ground"], "leaves the ground out already"),
        (["--env-turn", "9"], "'studio' is not a picture"),
    ],
)
def test_an_option_without_effect_says_so(arguments: list[str], message: str) -> None:
    result = CliRunner().invoke(main, ["render", "eon", "--size", "8", "--spp", "1", *arguments])
    assert result.exit_code != 0
    assert message in result.stderr
