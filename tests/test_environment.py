"""Prefiltered light against closed forms, NumPy quadrature and Mitsuba."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np
import pytest
from support.directions import random_directions
from support.tolerances import DOUBLE, DOUBLE_DIVIDED, SINGLE_PROMISED, decimals

import gonio
import gonio.mitsuba
from gonio.arrays.elementwise import elementwise
from gonio.bake import environment
from gonio.bake.environment import Environment, coat_reflection, irradiance, reflected
from gonio.lights import image_light

RADIANCE = np.array([0.9, 0.5, 0.2])
UP = np.array([0.0, 1.0, 0.0])


@pytest.fixture(autouse=True)
def _variant() -> None:
    mi.set_variant("llvm_ad_rgb")


def sphere(count: int, seed: int) -> Any:
    w = np.random.default_rng(seed).normal(size=(count, 3))
    return w / np.linalg.norm(w, axis=1, keepdims=True)


def grid(rows: int) -> Any:
    """Directions of a picture's pixels, by Mitsuba's definition of `envmap`."""
    theta = np.pi * np.arange(rows)[:, None] / (rows - 1)
    phi = 2 * np.pi * (np.arange(2 * rows - 2)[None] + 0.5) / (2 * rows - 2)
    w = np.broadcast_arrays(
        np.sin(theta) * np.sin(phi), np.cos(theta), -np.sin(theta) * np.cos(phi)
    )
    return np.stack(w, -1)


def sky(function: Any, rows: int = 65) -> Environment:
    """Grey radiance as a function of direction."""
    return Environment(np.repeat(function(grid(rows))[..., None], 3, axis=-1))


def uniform() -> Environment:
    return Environment(RADIANCE + np.zeros((9, 16, 3)))


# --- pictures --------------------------------------------------------------------------------------


def test_radiance_is_that_of_mitsubas_envmap() -> None:
    pixels = np.random.default_rng(1).random((12, 24, 3)).astype(np.float32)
    emitter = mi.load_dict({"type": "envmap", "bitmap": mi.Bitmap(pixels)})
    w = sphere(5000, seed=2)
    si = mi.SurfaceInteraction3f()
    si.wi = mi.Vector3f((-w).T.astype(np.float32))
    expected = np.array(emitter.eval(si)).T
    np.testing.assert_allclose(Environment(pixels).radiance(w), expected, atol=MITSUBA_LOOKUP)


def test_a_picture_file_is_read_and_written(tmp_path: Path) -> None:
    pixels = np.random.default_rng(3).random((9, 16, 3)).astype(np.float32)
    Environment(pixels).write(tmp_path / "sky.exr")
    np.testing.assert_array_equal(environment.load(tmp_path / "sky.exr").pixels, pixels)


def test_own_environments_are_seen_from_where_the_object_stands() -> None:
    white = environment.load("white", width=16, spp=4)
    # Radiance 1 from everywhere, but for the grey ground
    np.testing.assert_allclose(white.pixels[:3], 1, rtol=SINGLE_PROMISED)
    assert white.pixels[-1].max() < 1
    side = environment.load("side", width=64, spp=4).harmonics()
    assert abs(side[3]).max() > 2 * abs(side[2]).max()  # x, not z


# Mitsuba interpolates its pictures with weights of single precision, far inside a pixel's width.
MITSUBA_LOOKUP = 2e-4

# Pictures are interpolated linearly between pixels 1.4 degrees apart.
BETWEEN_PIXELS = 5e-4

# Between 512 rows interpolation takes 1e-5 of 3 z^2 - 1's own size from it.
OTHER_BANDS = 2e-5

# A quarter of the rows: sixteen times the error of interpolation.
FEWER_ROWS = 2e-3

# The blur's own sampling of its lobe; and how it keeps the light of a sun between its samples.
BLURRED = 1e-3

# The sun is one pixel wide, 0.7 degrees, and the lobe is not flat over it.
A_SUN_OF_ONE_PIXEL = 0.05

# 512 stratified samples of all the light; and 256 of a sun that one pixel holds.
NOISE, NOISE_OF_A_SUN = 0.02, 0.1

# Blurred light times F leaves out what the lobe loses by masking, and its own shape.
SPLIT_SUM = 0.1

# 80 nodes on each side of a kink.
GAUSS = 1e-6

# What is left of Oren-Nayar at an exponent of 1e9.
SMOOTH = 1e-6


# --- harmonics -------------------------------------------------------------------------------------


def test_irradiance_of_polynomials_is_exact() -> None:
    """For 1 + a.w + b w_x w_y + c w_z^2 it is pi, 2 pi / 3 and pi / 4 times the bands."""
    a, b, c = np.array([0.2, -0.3, 0.1]), 0.25, 0.4
    found = sky(lambda w: 1 + w @ a + b * w[..., 0] * w[..., 1] + c * w[..., 2] ** 2, rows=129)
    n = sphere(200, seed=4)
    mixed = b * n[:, 0] * n[:, 1] + c * (n[:, 2] ** 2 - 1 / 3)
    expected = np.pi * (1 + c / 3) + 2 * np.pi / 3 * (n @ a) + np.pi / 4 * mixed
    np.testing.assert_allclose(
        irradiance(found.harmonics(), n)[:, 0], expected, rtol=BETWEEN_PIXELS
    )
    wrong = np.pi * (1 + c / 3) + np.pi * (n @ a) + np.pi / 4 * mixed
    assert np.abs(irradiance(found.harmonics(), n)[:, 0] - wrong).max() > 0.1


def test_harmonics_of_uniform_light_have_one_band() -> None:
    found = uniform().harmonics()
    np.testing.assert_allclose(found[0], RADIANCE * np.sqrt(4 * np.pi), rtol=DOUBLE_DIVIDED)
    np.testing.assert_allclose(found[1:], 0, atol=OTHER_BANDS)


def test_harmonics_of_a_large_picture_are_those_of_a_smaller_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    picture = sky(lambda w: np.exp(w @ np.array([1.0, 2.0, -0.5])), rows=257)
    fine = picture.harmonics()
    monkeypatch.setattr(environment, "HARMONIC_ROWS", 64)
    np.testing.assert_allclose(
        picture.harmonics(), fine, rtol=FEWER_ROWS, atol=FEWER_ROWS * fine[0, 0]
    )


def test_nine_harmonics_see_a_hemisphere_of_light_within_three_percent() -> None:
    """Ramamoorthi and Hanrahan: 3 % mean error; here a sky that is bright above the horizon."""
    bright = sky(lambda w: (w[..., 1] > 1e-6) + 0.5 * (abs(w[..., 1]) <= 1e-6), rows=257)
    n = sphere(500, seed=5)
    exact = np.pi * (1 + n[:, 1]) / 2  # the cosine-weighted share above the horizon
    found = irradiance(bright.harmonics(), n)[:, 0]
    assert np.abs(found - exact).mean() < 0.03 * np.pi
    assert np.abs(found - exact).max() < 0.1 * np.pi


# --- blur ------------------------------------------------------------------------------------------


def lobe_mean(alpha: float, band: Any, weighted: bool = True) -> float:
    """Mean of a function of the light's cosine over a GGX lobe seen along the normal: 1-D quadrature."""
    theta = np.linspace(0, np.pi / 4, 400_001)  # of the half vector; the light is twice as far
    # The solid angle of light, 4 cos(theta) sin(theta), times D / 4
    D = 1 / (np.cos(theta) ** 4 * (1 + (np.tan(theta) / alpha) ** 2) ** 2)
    weight = D * np.cos(theta) * np.sin(theta) * (np.cos(2 * theta) if weighted else 1)
    return float(np.sum(band(np.cos(2 * theta)) * weight) / np.sum(weight))


@pytest.mark.parametrize("alpha", [0.05, 0.2, 0.6, 1.0])
def test_blur_scales_each_band_as_the_lobe_does(alpha: float) -> None:
    """A convolution with a round lobe multiplies harmonics of degree l by its mean of P_l."""
    a = np.array([0.3, -0.5, 0.4])
    source = sky(lambda w: 1 + w @ a + 0.4 * w[..., 1] ** 2, rows=129)
    w = sphere(300, seed=6)
    first = lobe_mean(alpha, lambda mu: mu)
    second = lobe_mean(alpha, lambda mu: (3 * mu**2 - 1) / 2)
    expected = 1 + 0.4 / 3 + first * (w @ a) + second * 0.4 * (w[:, 1] ** 2 - 1 / 3)
    found = source.blurred(alpha, width=256).radiance(w)[:, 0]
    np.testing.assert_allclose(found, expected, rtol=BLURRED)
    if alpha == 1:
        other = 1 + 0.4 / 3 + lobe_mean(alpha, lambda mu: mu, weighted=False) * (w @ a)
        assert np.abs(found - other).max() > 0.01


@pytest.mark.parametrize("alpha", [0.03, 0.3])
def test_blur_keeps_the_light_of_a_small_sun(alpha: float) -> None:
    pixels = np.zeros((257, 512, 3))
    pixels[70, 100] = 1000
    before, after = Environment(pixels), Environment(pixels).blurred(alpha)
    kept = after.harmonics()[0, 0] / before.harmonics()[0, 0]
    assert kept == pytest.approx(1, abs=5 * BLURRED)
    # It is spread over as many directions as the lobe has
    peak = after.pixels.max() / (before.harmonics()[0, 0] * np.sqrt(4 * np.pi))
    theta = np.linspace(0, np.pi / 4, 400_001)
    tan2 = (np.tan(theta) / alpha) ** 2
    D = 1 / (np.pi * alpha**2 * np.cos(theta) ** 4 * (1 + tan2) ** 2)
    weight = 2 * np.pi * D * np.cos(theta) * np.sin(theta) * np.cos(2 * theta)
    density = 1 / (4 * np.pi * alpha**2) / np.trapezoid(weight, theta)  # D / 4 along the normal
    assert peak == pytest.approx(density, rel=A_SUN_OF_ONE_PIXEL)


def test_uniform_light_stays_as_it_is() -> None:
    np.testing.assert_allclose(uniform().blurred(0.4).pixels[0, 0], RADIANCE, rtol=DOUBLE_DIVIDED)


# --- any model, sampled ----------------------------------------------------------------------------


def normals_and_viewers(count: int) -> tuple[Any, Any]:
    n = sphere(count, seed=7)
    v = random_directions(count, seed=8).astype(float)
    x = np.cross(np.roll(n, 1, axis=1), n)
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    y = np.cross(n, x)
    return n, v[:, :1] * x + v[:, 1:2] * y + v[:, 2:] * n


def test_lambert_reflects_the_irradiance() -> None:
    a = np.array([0.3, -0.2, 0.5])
    light = sky(lambda w: 1 + w @ a)
    n, v = normals_and_viewers(300)
    found = reflected(light, gonio.Lambert(rho=0.6), n, v, samples=512)
    expected = 0.6 * (1 + 2 / 3 * (n @ a))
    np.testing.assert_allclose(found[:, 0], expected, rtol=NOISE)


def test_a_sun_of_one_pixel_is_not_missed() -> None:
    pixels = np.zeros((129, 256, 3))
    pixels[40, 30] = 1e4
    light = Environment(pixels)
    w = grid(129)[40, 30]
    solid_angle = light.harmonics()[0, 0] * np.sqrt(4 * np.pi) / 1e4
    n = sphere(200, seed=9)
    n = n[n @ w > 0.1]
    found = reflected(light, gonio.Lambert(rho=1.0), n, n, samples=256)
    expected = 1e4 * solid_angle * (n @ w) / np.pi
    np.testing.assert_allclose(found[:, 0], expected, rtol=NOISE_OF_A_SUN)
    assert found[:, 0].mean() == pytest.approx(expected.mean(), rel=0.1 * NOISE_OF_A_SUN)


def test_white_eon_disappears_in_uniform_light() -> None:
    n, v = normals_and_viewers(200)
    found = reflected(uniform(), gonio.EON(rho=1.0, roughness=1.0), n, v, samples=512)
    np.testing.assert_allclose(found, RADIANCE + np.zeros((200, 3)), rtol=NOISE)


# --- coats -----------------------------------------------------------------------------------------


def test_a_coat_reflects_its_fresnel_of_uniform_light() -> None:
    n, v = normals_and_viewers(500)
    mu = np.sum(n * v, axis=1)
    t = np.sqrt(1 - (1 - mu**2) / 1.5**2)
    s, p = (mu - 1.5 * t) / (mu + 1.5 * t), (1.5 * mu - t) / (1.5 * mu + t)
    expected = ((s**2 + p**2) / 2)[:, None] * RADIANCE
    found = coat_reflection(uniform(), n, v, 1.5)
    np.testing.assert_allclose(found, expected, atol=DOUBLE_DIVIDED)
    assert np.all(coat_reflection(uniform(), n, -v, 1.5) == 0)


def test_a_coats_reflection_is_near_that_of_the_layered_model_where_it_is_seen_from_above() -> None:
    light = sky(lambda w: 1 + np.exp(8 * (w @ np.array([0.6, 0.64, 0.48])) - 8) * 5, rows=129)
    n = sphere(60, seed=10)
    tilt = n + 0.2 * sphere(60, seed=11)
    v = tilt / np.linalg.norm(tilt, axis=1, keepdims=True)
    coat = gonio.model(
        "weidlich_wilkie",
        alpha=0.1,
        distribution="ggx",
        masking="smith_correlated",
        **{"base.rho": 0},
    )
    found = coat_reflection(light.blurred(0.1), n, v, 1.5)[:, 0]
    exact = reflected(light, coat, n, v, samples=512)[:, 0]
    np.testing.assert_allclose(found, exact, rtol=SPLIT_SUM)
    assert found.mean() == pytest.approx(exact.mean(), rel=NOISE)
    not_blurred = coat_reflection(light.blurred(0.5), n, v, 1.5)[:, 0]
    assert np.abs(not_blurred / exact - 1).max() > 0.3


def test_pictures_of_normals_and_one_viewer_give_pictures() -> None:
    n = sphere(20, seed=12).reshape(4, 5, 3)
    light, metal = uniform(), {"eta": (0.2, 0.9, 1.1), "k": (3.9, 2.5, 2.4)}
    layered = gonio.model("triace_layered")
    pictures = [
        coat_reflection(light, n, UP, 1.5),
        coat_reflection(light, n, UP, **metal),
        environment.oren_nayar_light(light.harmonics(), n, UP, rho=(0.1, 0.2, 0.3), shininess=5),
        environment.layered_light(light, layered, n, UP),
        reflected(light, gonio.Lambert(), n, UP, samples=4),
    ]
    for picture in pictures:
        assert picture.shape == (4, 5, 3)
        assert np.all(picture[n[..., 1] < 0] == 0)  # seen from behind
        assert np.all(picture[n[..., 1] > 0] > 0)


# --- tri-Ace ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("top_transmission", ["on", "off"])
def test_layers_in_uniform_light_are_equations_5_to_9(top_transmission: str) -> None:
    model = gonio.model(
        "triace_layered",
        sigma_a=(0.1, 0.3, 0.9),
        thickness=0.4,
        rho=(0.6, 0.4, 0.2),
        top_transmission=top_transmission,
    )
    mu = np.array([1.0, 0.8, 0.5, 0.2, 0.05])
    n = np.repeat(UP[None], 5, axis=0)
    v = np.stack([np.sqrt(1 - mu**2), mu, 0 * mu], -1)
    found = environment.layered_light(uniform(), model, n, v)

    n1, n2 = 1.33333, 1.5
    f0 = ((n1 - 1) / (n1 + 1)) ** 2
    F_top = (f0 + (1 - f0) * (1 - mu) ** 5)[:, None]
    F_bottom = ((n2 - n1) / (n2 + n1)) ** 2 * (1 - f0)
    depth = 0.4 * np.array([0.1, 0.3, 0.9])
    glossy = F_bottom * np.maximum(0, 1 - 2 * depth / mu[:, None])
    matte = (1 - F_bottom) * np.maximum(0, 1 - depth * (2 + 1 / mu[:, None]))
    below = glossy + matte * np.array([0.6, 0.4, 0.2])
    T = 1 - F_top if top_transmission == "on" else 1
    np.testing.assert_allclose(found, (F_top + T * below) * RADIANCE, rtol=OTHER_BANDS)


def test_layered_light_takes_no_other_model() -> None:
    with pytest.raises(ValueError, match="takes a TriAceLayered, not EON"):
        environment.layered_light(uniform(), gonio.EON(), UP, UP)


def test_diffuse_absorption_is_the_mean_of_the_linear_one() -> None:
    """Eq. 8: (1 / pi) times the integral of (1 / mu_r + 1 / mu_i) mu_i is 2 + 1 / mu_r."""
    x, w = np.polynomial.legendre.leggauss(64)
    mu_i, w = (x + 1) / 2, w / 2
    for mu_r in (0.3, 0.7, 1.0):
        mean = np.sum(2 * w * mu_i * (1 - 0.1 * (1 / mu_r + 1 / mu_i)))
        found = elementwise(image_light.diffuse_image_absorption, 0.1, mu_r)
        assert float(found) == pytest.approx(mean, abs=DOUBLE)
    assert float(elementwise(image_light.diffuse_image_absorption, 0.1, 0.05)) == 0
    assert float(elementwise(image_light.specular_image_absorption, 0.1, 0.5)) == pytest.approx(0.6)


NODES, WEIGHTS = np.polynomial.legendre.leggauss(80)


def in_plane(mu: float, n: float) -> float:
    """The integral of Eq. 25 (the reflected radiance, with the cosine) over the viewer's half plane."""
    theta_r = np.arccos(mu)
    total = 0.0
    for low, high in ((0.0, theta_r), (theta_r, np.pi / 2)):
        theta = low + (high - low) * (NODES + 1) / 2
        s = np.sin(theta) * np.sin(theta_r)
        t = np.maximum(np.cos(theta), mu)
        value = (1 - 1 / (2 + 0.65 * n) + s / t / (2.22222 + 0.1 * n)) * np.cos(theta)
        total += np.sum(value * WEIGHTS) * (high - low) / 2
    return float(total)


@pytest.mark.parametrize("sigma", [0.25, 0.5, 1.0])
def test_harmonic_scales_fit_the_integral_in_the_plane(sigma: float) -> None:
    """The course's Figures 8 and 9: a good fit by Eq. 27, a worse one by Eq. 28."""
    n = 2 / sigma**2
    mu = np.linspace(0.001, 1, 41)
    expected = [in_plane(m, n) for m in mu]
    np.testing.assert_allclose(
        elementwise(image_light.in_plane_integral, mu, n), expected, rtol=GAUSS
    )
    dc = elementwise(image_light.harmonic_dc_scale, mu, n)
    cheap = elementwise(image_light.harmonic_dc_scale_cheap, mu, n)
    good, worse = (np.abs(fit / expected - 1).max() for fit in (dc, cheap))
    assert good < 0.05
    assert good < worse < 0.12


def test_harmonic_scales_do_not_fit_the_hemisphere() -> None:
    """There the model reflects f + 0.288 g at grazing angles; the scales have f + g."""
    n = 2.0
    f, g = 1 - 1 / (2 + 0.65 * n), 1 / (2.22222 + 0.1 * n)
    model = gonio.model("triace_oren_nayar", rho=1, shininess=n)
    grazing = float(model.albedo(np.array([1.0, 0.0, 0.0]))[0])
    assert grazing == pytest.approx(f + 0.288 * g, abs=2 * decimals(3) * g)
    for scale in (image_light.harmonic_dc_scale, image_light.harmonic_dc_scale_cheap):
        assert float(elementwise(scale, 0, n)) == pytest.approx(f + g)
        assert float(elementwise(scale, 1, n)) == pytest.approx(f)


def test_the_linear_scale_is_that_of_figure_10() -> None:
    """0.7 of Lambert at sigma = 1 seen from above, 0.39 at grazing angles, 1 for smooth surfaces."""
    scale = image_light.harmonic_linear_scale
    assert float(elementwise(scale, 1, 2)) == pytest.approx(0.70, abs=decimals(2))
    assert float(elementwise(scale, 0, 2)) == pytest.approx(0.39, abs=decimals(2))
    assert float(elementwise(scale, 0.5, 1e9)) == pytest.approx(1, abs=SMOOTH)


def test_oren_nayar_light_scales_the_bands() -> None:
    a, n = np.array([0.3, -0.2, 0.5]), 8.0
    harmonics = sky(lambda w: 1 + w @ a, rows=129).harmonics()
    normals, v = normals_and_viewers(300)
    mu = np.sum(normals * v, axis=1)
    f, g = 1 - 1 / (2 + 0.65 * n), 1 / (2.22222 + 0.1 * n)
    S = f + (f - 1) * (1 - mu)
    linear = 2 / 3 * S * (normals @ a)
    for form, dc in (
        ("arccos", f + g / 2 * (1 + 2 / np.pi * np.arccos(mu) - mu)),
        ("cheap", f + g * (1 - mu)),
    ):
        found = environment.oren_nayar_light(harmonics, normals, v, rho=0.7, shininess=n, form=form)
        np.testing.assert_allclose(found[:, 0], 0.7 * (dc + linear), rtol=2 * BETWEEN_PIXELS)
    plain = environment.oren_nayar_light(
        harmonics, normals, v, rho=0.7, shininess=n, form="lambert"
    )
    np.testing.assert_allclose(
        plain[:, 0], 0.7 * (1 + 2 / 3 * (normals @ a)), rtol=2 * BETWEEN_PIXELS
    )
    assert np.abs(found - plain).max() > 0.02


# --- errors ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: Environment(np.zeros((1, 4, 3))), r"has shape \(1, 4, 3\); needed is"),
        (lambda: Environment(np.full((4, 8, 3), np.nan)), "negative or not finite"),
        (lambda: uniform().blurred(0), "alpha=0 is out of range"),
        (lambda: uniform().blurred(0.1, width=5), "width=5 is out of range"),
        (lambda: uniform().write("sky.png"), "must be .exr or .hdr"),
        (lambda: reflected(uniform(), gonio.EON(), UP, UP, samples=1), "samples=1 is out of"),
        (lambda: environment.load("studoi"), "did you mean 'studio'"),
        (
            lambda: environment.oren_nayar_light(
                np.zeros((9, 3)), UP, UP, rho=1, shininess=1, form="sin"
            ),
            "form='sin' is not known; allowed are arccos, cheap, lambert",
        ),
    ],
)
def test_bad_arguments_get_one_clear_line(call: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message) as error:
        call()
    assert "\n" not in str(error.value)
