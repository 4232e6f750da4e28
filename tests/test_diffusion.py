"""Diffusion on the screen: the published profile, its edge on a plane, and what it must not cross."""

from __future__ import annotations

from math import erf, hypot, sqrt
from typing import Any

import mitsuba as mi
import numpy as np
import pytest
from support.tolerances import DOUBLE, SINGLE, SINGLE_PROMISED

import gonio
import gonio.mitsuba
from gonio.cluster import pictures
from gonio.materials import load_material
from gonio.render import diffusion
from gonio.render.diffusion import diffuse_on_screen, reach_in_pixels, skin_profile

SPACING = 0.2  # millimetres from pixel to pixel


@pytest.fixture(autouse=True)
def _variant() -> None:
    mi.set_variant("llvm_ad_rgb")


def plane(height: int = 7, width: int = 81) -> tuple[Any, Any, Any]:
    """Positions in millimetres, areas, and surface numbers of a plane seen from above."""
    y, x = np.mgrid[0:height, 0:width] * SPACING
    return np.stack([x, y, 0 * x], -1), np.ones((height, width)), np.ones((height, width), int)


# 200,000 trapezes from a ten thousandth of a millimetre to 60.
TRAPEZES = 1e-4

# Light that would wander over the rim of what is seen.
OVER_THE_RIM = 0.02


def test_the_profile_lets_all_light_out() -> None:
    r = np.geomspace(1e-4, 60, 200_001)
    integrand = skin_profile(r) * (2 * np.pi * r)[:, None]
    np.testing.assert_allclose(np.trapezoid(integrand, r, axis=0), 1, atol=TRAPEZES)
    far = r > diffusion.REACH
    assert np.trapezoid(integrand[far], r[far], axis=0).max() < 0.006


def test_red_light_gets_farthest() -> None:
    at_two_millimetres = skin_profile(2.0)
    assert at_two_millimetres[0] > 50 * at_two_millimetres[1] > 50 * at_two_millimetres[2]


def test_uniform_light_stays_as_it_is() -> None:
    positions, areas, surface = plane()
    light = np.broadcast_to([0.3, 0.2, 0.1], (*surface.shape, 3))
    found = diffuse_on_screen(light, positions, areas, surface, 1.0)
    np.testing.assert_allclose(found, light, rtol=DOUBLE)


def edge(x: float, channel: int) -> float:
    """Light at a distance x beyond the edge of a bright half plane; a Gaussian gives an error function."""
    return sum(w[channel] * (1 - erf(x / sqrt(2 * v))) / 2 for v, w in diffusion.SKIN)


def test_a_shadows_edge_is_that_of_the_profile() -> None:
    positions, areas, surface = plane(height=71)
    light = np.zeros((*surface.shape, 3))
    light[:, :40] = 1
    row = diffuse_on_screen(light, positions, areas, surface, 1.0)[35]
    for column in (30, 36, 38, 42, 44, 50, 60):
        x = (column - 39.5) * SPACING
        # The narrowest Gaussian, 0.08 mm, is spread over a pixel, which takes 3 % of the light beside the
        # edge and 1 % of it farther away
        exact = 0.03 if abs(x) < 1 else 0.01
        assert row[column, 0] == pytest.approx(edge(x, 0), abs=exact)
        assert row[column, 1] == pytest.approx(edge(x, 1), abs=exact)
    assert row[50, 0] > 10 * row[50, 1]  # a red rim
    wrong = [edge(0.5 * (column - 39.5) * SPACING, 0) for column in (44, 50)]
    assert abs(row[44, 0] - wrong[0]) > 0.03 or abs(row[50, 0] - wrong[1]) > 0.03


def test_light_does_not_cross_to_another_surface_or_over_a_gap() -> None:
    positions, areas, surface = plane()
    light = np.zeros((*surface.shape, 3))
    light[:, :40] = 1
    other = surface.copy()
    other[:, 40:] = 2
    np.testing.assert_array_equal(diffuse_on_screen(light, positions, areas, other, 1.0)[:, 40:], 0)
    behind = positions.copy()
    behind[:, 40:, 2] -= 10
    np.testing.assert_array_equal(diffuse_on_screen(light, behind, areas, surface, 1.0)[:, 40:], 0)
    together = diffuse_on_screen(light, positions, areas, surface, 1.0)[:, 40]
    assert together.min() > 0.01


def test_a_pixel_that_shows_more_surface_counts_more() -> None:
    positions, areas, surface = plane()
    light = np.zeros((*surface.shape, 3))
    light[:, :40] = 1
    areas[:, :40] = 2
    more = diffuse_on_screen(light, positions, areas, surface, 1.0)[3, 42, 0]
    plain = diffuse_on_screen(light, *plane(), 1.0)[3, 42, 0]
    assert more == pytest.approx(2 * plain / (1 + plain), rel=SINGLE)


def test_it_is_the_sum_over_all_pairs_of_pixels() -> None:
    # Two bent surfaces side by side, with gaps between them, uneven areas, and light that is all noise
    rng = np.random.default_rng(5)
    positions, areas, surface = plane(11, 13)
    positions[..., 2] = np.cumsum(rng.uniform(-0.3, 0.3, surface.shape), axis=1)
    areas = rng.uniform(0.2, 3, surface.shape)
    surface[:, 7:] = 2
    surface[rng.random(surface.shape) < 0.2] = 0
    surface[:2], surface[:, -1] = 0, 0
    light = rng.random((*surface.shape, 3))
    millimetre = 0.15
    found = diffuse_on_screen(light, positions, areas, surface, millimetre)
    radius = reach_in_pixels(positions, surface, millimetre)
    assert 3 <= radius <= 8
    steps = np.linalg.norm(np.diff(positions, axis=1), axis=-1)
    own = np.median(steps[(surface[:, 1:] == surface[:, :-1]) & (surface[:, 1:] > 0)]) / 2
    expected = light.copy()
    for here in zip(*np.nonzero(surface), strict=True):
        total, weights = np.zeros(3), np.zeros(3)
        for there in np.ndindex(surface.shape):
            apart = max(np.linalg.norm(positions[here] - positions[there]), own) / millimetre
            close = hypot(here[0] - there[0], here[1] - there[1]) <= radius
            if close and surface[here] == surface[there] and apart < diffusion.REACH:
                total += skin_profile(apart) * areas[there] * light[there]
                weights += skin_profile(apart) * areas[there]
        expected[here] = total / weights
    np.testing.assert_allclose(found, expected, rtol=DOUBLE)
    # One that took the other pixel's area for the neighbours above would be far off
    swapped = diffuse_on_screen(light, positions, areas[::-1, ::-1], surface, millimetre)
    assert np.abs(swapped - expected).max() > 0.05


def test_without_reach_nothing_changes() -> None:
    positions, areas, surface = plane()
    light = np.random.default_rng(0).random((*surface.shape, 3))
    found = diffuse_on_screen(light, positions, areas, surface, 0.01)
    np.testing.assert_allclose(found, light, rtol=DOUBLE)


def test_the_diffuse_part_alone_is_spread() -> None:
    settings: Any = {"size": (48, 48), "spp": 4, "environment": "side"}
    skin = load_material("skin")
    plain = gonio.render(skin, **settings)
    # A reach of a twentieth of a pixel leaves full - glossy + glossy
    np.testing.assert_allclose(
        gonio.render(skin, diffusion=1e-4, **settings), plain, atol=SINGLE_PROMISED
    )
    spread = gonio.render(skin, diffusion=0.04, **settings)
    assert np.abs(spread - plain).max() > 0.02
    assert spread.mean() == pytest.approx(plain.mean(), rel=OVER_THE_RIM)


def rendered(done: int, total: int) -> None:
    raise AssertionError("This is refused before anything is rendered.")


# What is asked of a picture that is shared out.
SHARED: Any = {"environment": "studio", "size": (96, 96), "spp": 1}


def test_what_cannot_be_spread_gets_one_clear_line() -> None:
    with pytest.raises(ValueError, match="gold has no diffuse colour rho"):
        gonio.render(load_material("gold"), diffusion=0.01, size=(8, 8), spp=1)
    with pytest.raises(ValueError, match="pixels, allowed are 40; make the millimetre or"):
        gonio.render("eon", diffusion=3, size=(96, 96), spp=1, progress=rendered)
    with pytest.raises(ValueError, match="pixels, allowed are 40; make the millimetre or"):
        pictures.tasks(gonio.model("eon"), {**SHARED, "diffusion": 3})
    positions, areas, surface = plane()
    light = np.zeros((*surface.shape, 3))
    with pytest.raises(ValueError, match="over 65 pixels, allowed are 40; make the millimetre or"):
        diffuse_on_screen(light, positions, areas, surface, 2.0)
    with pytest.raises(ValueError, match="millimetre=0 is out of range"):
        diffuse_on_screen(light, positions, areas, surface, 0)
