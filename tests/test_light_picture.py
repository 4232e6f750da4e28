"""Pictures of light: no light is lost, bad pixels are said, exposure and ground follow from it."""

from __future__ import annotations

from pathlib import Path

import mitsuba as mi
import numpy as np
import pytest
from support.tolerances import SINGLE

from gonio.bake import environment
from gonio.images import write_linear
from gonio.messages import Notice
from gonio.render import light
from gonio.render.light_picture import (
    exposure,
    ground_colour,
    irradiance_on,
    read_light,
    repaired,
)


@pytest.fixture(autouse=True)
def _variant() -> None:
    mi.set_variant("llvm_ad_rgb")


def write(path: Path, pixels: np.ndarray) -> Path:
    mi.Bitmap(np.ascontiguousarray(pixels, np.float32)).write(str(path))
    return path


SUN = (2e6, 1.8e6, 1.5e6)


@pytest.mark.parametrize("suffix", [".exr", ".hdr"])
def test_a_sun_of_any_brightness_keeps_all_its_light(tmp_path: Path, suffix: str) -> None:
    """The constant harmonic is the mean light: Y00 = integral of L / sqrt(4 pi)."""
    pixels = np.full((32, 64, 3), 0.1, np.float32)
    pixels[8, 20] = SUN
    path = write(tmp_path / f"sun{suffix}", pixels)
    assert read_light(path).max() == pytest.approx(2e6, rel=2e-3)  # .hdr has 8 bits
    first = environment.load(path).harmonics()[0]
    # The pixel's weight: a tent over rows of pi / 31 around sin(theta), times one column.
    h = np.pi / 31
    solid = np.sin(8 * h) * 2 * (1 - np.cos(h)) / h * 2 * np.pi / 64
    wanted = (0.1 * 4 * np.pi + np.array(SUN) * solid) / np.sqrt(4 * np.pi)
    np.testing.assert_allclose(first, wanted, rtol=5e-3)  # 8 bits of .hdr


def test_a_rendered_surface_gets_all_the_light_of_the_sun(tmp_path: Path) -> None:
    pixels = np.full((64, 128, 3), 0.0, np.float32)
    pixels[16, 64] = SUN
    nodes = light.environment_nodes(write(tmp_path / "sun.exr", pixels))
    scene = {
        "type": "scene",
        "sky": nodes["sky"],
        "integrator": {"type": "direct"},
        "floor": {
            "type": "rectangle",
            "to_world": mi.ScalarTransform4f().rotate([1, 0, 0], -90),
            "bsdf": {"type": "diffuse", "reflectance": light.rgb(1.0)},
        },
        "sensor": {
            "type": "orthographic",
            "to_world": mi.ScalarTransform4f().look_at([0, 4, 0], [0, 0, 0], [0, 0, 1])
            @ mi.ScalarTransform4f().scale(0.5),
            "film": {"type": "hdrfilm", "width": 8, "height": 8, "pixel_format": "rgb"},
        },
    }
    seen = np.array(mi.render(mi.load_dict(scene), spp=256)).mean(axis=(0, 1))
    step = np.pi / 63
    solid = np.sin(16 * step) * 2 * (1 - np.cos(step)) / step * 2 * np.pi / 128
    wanted = np.array(SUN) * solid * np.cos(16 * step) / np.pi
    # 3 %: noise of 16,000 samples of a tent, and its curvature
    np.testing.assert_allclose(seen, wanted, rtol=0.03)


def test_bad_values_are_counted_said_and_replaced_and_good_ones_stay() -> None:
    rng = np.random.default_rng(0)
    good = rng.random((8, 16, 3)).astype(np.float32) + 1
    bad = good.copy()
    bad[2, 3, 0] = np.nan
    bad[4, 0, 1] = -0.5
    bad[5, 5, 2] = np.inf
    bad[6, 6] = 1e7
    with pytest.warns(
        Notice, match=r"lamp has bad pixels: 1 not a number .* 1 negative .* 1 infinite"
    ):
        fixed = repaired(bad, "lamp")
    around = good[1:4, 2:5, 0].astype(np.float64)
    assert fixed[2, 3, 0] == pytest.approx((around.sum() - around[1, 1]) / 8, rel=SINGLE)
    assert fixed[4, 0, 1] == 0
    assert fixed[5, 5, 2] == np.float32(1e7)  # the largest finite value of the picture
    changed = ~(np.isfinite(bad) & (bad >= 0))
    np.testing.assert_array_equal(fixed[~changed], bad[~changed])
    with pytest.warns(Notice, match="65504"):
        assert repaired(np.where(changed, np.inf, good), "lamp").max() == 65504


def test_a_patch_of_unknown_pixels_is_filled_across_the_seam() -> None:
    pixels = np.full((80, 160, 3), 3.0, np.float32)
    pixels[10:14, :3] = np.nan
    pixels[10:14, -3:] = np.nan
    with pytest.warns(Notice, match="24 not a number"):
        np.testing.assert_allclose(repaired(pixels, "sky"), 3.0)
    pixels[:] = np.nan
    pixels[0, 0] = 2.0
    with pytest.warns(Notice):
        assert np.isfinite(repaired(pixels, "sky")).all()


def test_sound_light_is_said_nothing_about(tmp_path: Path) -> None:
    pixels = np.full((8, 16, 3), 0.5, np.float32)
    np.testing.assert_array_equal(read_light(write(tmp_path / "a.exr", pixels)), pixels)


@pytest.mark.parametrize(
    ("size", "looks"),
    [
        ((64, 64), "mirror ball"),
        ((48, 64), "vertical cross"),
        ((64, 48), "horizontal cross"),
        ((96, 16), "strip of six"),
        ((64, 20), "needed is a picture in longitude"),
    ],
)
def test_pictures_of_another_shape_are_refused_with_the_reason(
    tmp_path: Path, size: tuple[int, int], looks: str
) -> None:
    path = write(tmp_path / "a.exr", np.ones((size[1], size[0], 3)))
    with pytest.raises(ValueError, match=looks) as error:
        read_light(path)
    assert f"{size[0]} x {size[1]} pixels" in str(error.value)


def test_own_baked_pictures_with_both_poles_are_read_back(tmp_path: Path) -> None:
    for width in (8, 64):
        path = write(tmp_path / "a.exr", np.ones((width // 2 + 1, width, 3)))
        assert read_light(path).shape == (width // 2 + 1, width, 3)


def test_irradiance_of_a_half_lit_sphere_is_that_of_a_closed_form() -> None:
    """Radiance 1 from above: (1 + cos) / 2 of pi, on a surface turned by that angle from upwards."""
    pixels = np.zeros((128, 256, 3), np.float32)
    pixels[:64] = 1
    angle = np.radians([0, 60, 90, 120, 180])
    normals = np.stack([np.sin(angle), np.cos(angle), 0 * angle], axis=-1)
    wanted = np.pi * (1 + np.cos(angle)) / 2
    # 64 rows: a cosine's midpoint rule errs by (pi / 64)^2 / 24
    np.testing.assert_allclose(irradiance_on(pixels, normals)[:, 0], wanted, atol=2e-3)


@pytest.mark.parametrize("level", [1e-4, 1.0, 300.0])
def test_exposure_brings_uniform_light_to_white(level: float) -> None:
    pixels = np.full((32, 64, 3), level, np.float32)
    # 32 rows, and 256 normals of which none looks straight up
    assert 2 ** exposure(pixels) * level == pytest.approx(0.9, rel=2e-3)


def test_ground_looks_like_what_is_behind_it() -> None:
    """Under a sky of 1 the ground's radiance is its albedo: that of the picture below the horizon."""
    pixels = np.ones((180, 360, 3), np.float32)
    pixels[90:] = 0.0
    pixels[90:, 150:210] = (0.4, 0.3, 0.2)  # behind the object
    pixels[90:, 240:300] = (0.1, 0.6, 0.1)  # a quarter turn further
    # The picture's rows are a degree each: the sum over the sky errs by 2e-4
    np.testing.assert_allclose(ground_colour(pixels, 0.0), (0.4, 0.3, 0.2), rtol=1e-3)
    np.testing.assert_allclose(ground_colour(pixels, 90.0), (0.1, 0.6, 0.1), rtol=1e-3)


@pytest.mark.parametrize("azimuth", [0.0, 50.0])
@pytest.mark.parametrize("turn", [0.0, 90.0])
def test_ground_takes_the_colour_that_the_camera_sees(
    tmp_path: Path, turn: float, azimuth: float
) -> None:
    """Without the ground, the lower corner of the frame shows what the ground should look like."""
    from gonio.render.stage import shader_ball

    column = np.arange(360)
    pixels = np.ones((180, 360, 3), np.float32)
    pixels[90:] = np.stack([0.3 + 0.2 * np.cos(np.radians(column + 90 * k)) for k in range(3)], -1)
    path = write(tmp_path / "a.exr", pixels)
    stage = shader_ball(
        {"type": "diffuse"}, environment=path, environment_turn=turn, camera=(azimuth, 13.0),
        ground=False, size=(32, 32),
    )  # fmt: skip
    picture = np.array(mi.render(mi.load_dict(stage), spp=16))
    behind = picture[2, 14:18].mean(axis=0)
    # The band that is averaged is 40 degrees wide, over which the cosine bends; a pixel sees one of them
    np.testing.assert_allclose(ground_colour(pixels, turn - azimuth), behind, atol=0.02)


@pytest.mark.parametrize(
    ("shape", "value", "message"),
    [
        ((1, 2), 1.0, "has 2 x 1 pixels; 4 x 2 are the least"),
        ((8, 16), 1e-40, "has no light in it"),
        ((8, 16), 0.0, "has no light in it"),
    ],
)
def test_a_picture_too_small_or_dark_to_light_anything_is_refused(
    tmp_path: Path, shape: tuple[int, int], value: float, message: str
) -> None:
    write_linear(tmp_path / "a.exr", np.full((*shape, 3), value, np.float32))
    with pytest.raises(ValueError, match=message):
        read_light(tmp_path / "a.exr")
