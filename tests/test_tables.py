"""Precomputed F and D against textbook formulas, and the error of a picture made with them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np
import pytest
from support.tolerances import SINGLE

from gonio.bake import tables
from gonio.parts.metals import metal

COPPER: Any = metal("Cu")


def complex_fresnel(c: Any, index: Any) -> Any:
    """Unpolarised reflectance from Snell's law in complex numbers."""
    index = np.asarray(index, complex)
    cos_t = np.sqrt(1 - (1 - np.asarray(c) ** 2) / index**2)
    r_s = (c - index * cos_t) / (c + index * cos_t)
    r_p = (index * c - cos_t) / (index * c + cos_t)
    return (abs(r_s) ** 2 + abs(r_p) ** 2) / 2


def beckmann(theta: Any, m: Any) -> Any:
    return np.exp(-((np.tan(theta) / m) ** 2)) / (np.pi * m**2 * np.cos(theta) ** 4)


# --- F ---------------------------------------------------------------------------------------------


def test_entries_are_the_exact_reflectance_at_even_cosines() -> None:
    table = tables.fresnel_table(**COPPER)
    assert table.shape == (128, 3)
    cosines = np.arange(1, 128) / 127
    index = np.array(COPPER["eta"]) + 1j * np.array(COPPER["k"])
    expected = complex_fresnel(cosines[:, None], index)
    np.testing.assert_allclose(table[1:], expected, atol=SINGLE)
    np.testing.assert_allclose(table[0], 1, atol=SINGLE)


@pytest.mark.parametrize(
    ("index", "bound"),
    [({"eta": 1.5}, 3e-4), ({"eta": 1.05}, 1.5e-3), (COPPER, 1e-4), (metal("Cr"), 1.5e-3)],
    ids=["glass", "water in oil", "copper", "chromium"],
)
def test_the_stated_error_is_the_largest_between_the_entries(index: Any, bound: float) -> None:
    table = tables.fresnel_table(**index)
    cosines = np.linspace(0.0005, 1, 20011)
    exact = complex_fresnel(
        cosines[:, None], np.atleast_1d(index["eta"]) + 1j * np.atleast_1d(index.get("k", 0))
    )
    found = np.abs(tables.look_up_fresnel(table, cosines) - exact).max()
    stated = tables.fresnel_error(table, **index)
    assert stated.largest == pytest.approx(found, rel=ANOTHER_GRID)
    assert stated.largest < bound


def test_half_as_many_entries_are_four_times_as_wrong() -> None:
    """As linear interpolation is; one that takes the nearest entry would be twice as wrong."""
    fine, coarse = (
        tables.fresnel_error(tables.fresnel_table(1.5, entries=n), 1.5).largest for n in (257, 129)
    )
    assert coarse / fine == pytest.approx(4, rel=SECOND_DERIVATIVE)


def test_a_table_of_another_material_has_a_large_error() -> None:
    assert tables.fresnel_error(tables.fresnel_table(1.5), 1.6).largest > 0.01


# The largest of an error, found on a grid that is finer by far than the table, but not the same one.
ANOTHER_GRID = 0.02

# Half the entries are four times as wrong as long as the second derivative does not change between them.
SECOND_DERIVATIVE = 0.1

# Linear interpolation between the 512 rows and columns, of the peak: docs/real_time.md states 1.4e-3.
BETWEEN_ENTRIES = 2e-3

# Of a highlight's peak, what the eye sees as a wrong shape.
VISIBLE = 0.02


# --- D ---------------------------------------------------------------------------------------------


def test_lookups_are_beckmann_at_every_width() -> None:
    table = tables.distribution_table()
    assert table.shape == (512, 512)
    assert table.max() < 65504  # the largest 16 bit float
    for alpha in (0.0041, 0.01, 0.037, 0.2, 0.77, 1.0):
        theta = np.linspace(0, 1.5, 5003)
        exact = beckmann(theta, alpha)
        found = tables.look_up_distribution(table, theta, alpha)
        assert np.abs(found - exact).max() < BETWEEN_ENTRIES * exact.max()


@pytest.mark.parametrize("name", tables.DISTRIBUTIONS)
def test_lookups_cover_the_surface_once(name: str) -> None:
    """The integral of D cos over the hemisphere is 1, at widths between the rows of the table."""
    table = tables.distribution_table(name)
    for alpha in (0.0052, 0.03, 0.3, 0.9):
        # Steps even in the logarithm of the angle, because sharp lobes are narrow
        theta = np.concatenate([[0], np.geomspace(1e-6, np.pi / 2, 100_001)])
        D = tables.look_up_distribution(table, theta, alpha)
        covered = np.trapezoid(D * 2 * np.pi * np.sin(theta) * np.cos(theta), theta)
        assert covered == pytest.approx(1, abs=0.5 * BETWEEN_ENTRIES)


def test_sharp_highlights_need_the_mapping() -> None:
    """Elek's Figure 4: at m = 0.01 a table that is linear in the angle is visibly wrong."""
    linear = tables.distribution_table(exponent=1)
    error = tables.distribution_error(linear, exponent=1, alpha=0.01)
    assert error.largest > VISIBLE
    mapped = tables.distribution_error(tables.distribution_table(), alpha=0.01)
    assert mapped.largest < 0.01 * VISIBLE
    # "this issue starts to be apparent just for very smooth surfaces (with m < 0.02)"
    assert tables.distribution_error(linear, exponent=1, alpha=0.1).largest < 0.05 * VISIBLE


def test_the_stated_error_of_d_is_what_is_between_the_entries() -> None:
    table = tables.distribution_table()
    theta = np.linspace(0, 0.06, 40_001)
    exact = beckmann(theta, 0.01)
    found = np.abs(tables.look_up_distribution(table, theta, 0.01) - exact).max() / exact.max()
    assert tables.distribution_error(table, alpha=0.01).largest == pytest.approx(
        found, rel=ANOTHER_GRID
    )


# --- the picture -----------------------------------------------------------------------------------


def layered_sphere(m: float, F: Callable[[Any, int], Any], D: Callable[[Any, float], Any]) -> Any:
    """Elek's Algorithm 1 on a sphere under one light: a clear coat over copper, by his equations.

    F(cosine, layer) and D(angle, m) are exact or looked up.
    """
    y, x = np.mgrid[-0.95:0.95:301j, -0.95:0.95:301j]
    inside = x * x + y * y < 0.9
    normal = np.stack([x, y, np.sqrt(np.maximum(1 - x * x - y * y, 0))], -1)[inside]
    light, viewer = np.array([0.4, 0.5, 0.77]), np.array([0.0, 0.0, 1.0])
    light /= np.linalg.norm(light)
    normal = normal[normal @ light > 0.05]

    def facets(L: Any, V: Any, width: float, layer: int) -> tuple[Any, Any, Any]:
        half = L + V
        half = half / np.linalg.norm(half, axis=-1, keepdims=True)
        n_l, n_v, n_h, v_h = (
            np.sum(a * b, axis=-1) for a, b in ((normal, L), (normal, V), (normal, half), (V, half))
        )
        G = np.minimum(1, 2 * n_h / v_h * np.minimum(n_l, n_v))
        # The sine by the cross product: near the highlight the cosine has no digits left
        theta = np.arctan2(np.linalg.norm(np.cross(normal, half), axis=-1), n_h)
        reflectance = F(v_h, layer)
        return reflectance * (D(theta, width) * G / (4 * n_l * n_v))[:, None], reflectance, G

    def inside_the_coat(w: Any) -> Any:
        cosine = np.sum(normal * w, axis=-1, keepdims=True)
        tangential = (w - cosine * normal) / 1.5
        return tangential + np.sqrt(1 - np.sum(tangential**2, -1, keepdims=True)) * normal

    L, V = light + 0 * normal, viewer + 0 * normal
    f1, F1, G1 = facets(L, V, m, 0)
    f2, _, _ = facets(inside_the_coat(L), inside_the_coat(V), max(m, 0.1), 1)
    T = 1 - F1
    return (f1 + T * f2 * ((1 - G1[:, None]) + T * G1[:, None])) * (normal @ light)[:, None]


INDEX = [
    np.array([1.5 + 0j]),
    (np.array(COPPER["eta"]) + 1j * np.array(COPPER["k"])) / 1.5,
]


def exact_F(cosine: Any, layer: int) -> Any:
    return complex_fresnel(cosine[:, None], INDEX[layer]) + np.zeros(3)


def picture_error(m: float, exponent: float) -> float:
    """Largest difference to the full evaluation, as a share of the brightest pixel."""
    fresnel = [tables.fresnel_table(index.real, index.imag) for index in INDEX]
    table = tables.distribution_table(exponent=exponent)

    def F(cosine: Any, layer: int) -> Any:
        return tables.look_up_fresnel(fresnel[layer], cosine) + np.zeros(3)

    def D(theta: Any, width: float) -> Any:
        return tables.look_up_distribution(table, theta, width, exponent)

    full, looked_up = layered_sphere(m, exact_F, beckmann), layered_sphere(m, F, D)
    return float(np.abs(full - looked_up).max() / full.max())


@pytest.mark.parametrize("m", [0.01, 0.1, 0.4])
def test_a_picture_with_tables_is_well_within_six_percent(m: float) -> None:
    """Elek's Figure 5: "the largest error is less than 6%" (with 8 and 16 bit tables)."""
    assert picture_error(m, tables.EXPONENT) < BETWEEN_ENTRIES


def test_a_picture_with_a_linear_table_shows_it() -> None:
    assert picture_error(0.01, 1) > 2.5 * BETWEEN_ENTRIES


# --- files and errors ------------------------------------------------------------------------------


@pytest.mark.parametrize("table", [tables.fresnel_table(1.5), tables.fresnel_table(**COPPER)])
def test_written_tables_come_back(tmp_path: Path, table: Any) -> None:
    tables.write_table(tmp_path / "t.npy", table)
    np.testing.assert_array_equal(np.load(tmp_path / "t.npy"), table)
    tables.write_table(tmp_path / "t.exr", table)
    picture = np.array(mi.Bitmap(str(tmp_path / "t.exr")))
    assert picture.shape[:2] == (1, 128)
    np.testing.assert_allclose(picture.reshape(table.shape), table, rtol=SINGLE)


def test_written_distributions_are_pictures_of_one_channel(tmp_path: Path) -> None:
    table = tables.distribution_table("ggx", 16)
    tables.write_table(tmp_path / "d.exr", table)
    picture = np.array(mi.Bitmap(str(tmp_path / "d.exr"))).reshape(16, 16)
    np.testing.assert_array_equal(picture, table)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: tables.fresnel_table(1.5, entries=1), "entries=1 is out of range"),
        (lambda: tables.fresnel_table(0.0), "eta must be above 0"),
        (lambda: tables.fresnel_table([1.5, 1.6], [0, 0, 0]), "broadcast"),
        (lambda: tables.distribution_table("gxg"), "no distribution 'gxg'; known are beckmann"),
        (lambda: tables.distribution_table(size=1), "size=1 is out of range"),
        (lambda: tables.write_table("t.png", tables.fresnel_table(1.5)), "must be .npy or .exr"),
    ],
)
def test_bad_arguments_get_one_clear_line(call: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message) as error:
        call()
    assert "\n" not in str(error.value)
