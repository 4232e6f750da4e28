"""Materials between the metallic and the specular workflow: there, back, and what has no way back."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st
from support.tolerances import DOUBLE, DOUBLE_DIVIDED

from gonio import conversions
from gonio.conversions import (
    F0_DIELECTRIC,
    metallic_from_specular,
    specular_from_metallic,
)

UNIT = st.floats(0, 1)
COLOR = st.tuples(UNIT, UNIT, UNIT)

# Root and square of numbers near 1 in double precision; near a base colour of 0.04 the two roots meet, and
# the way back magnifies roundings by 1 / (base - 0.04).
EXACT = 1e-12
DARKEST = 0.05


def distance(a: Any, b: Any) -> float:
    return max(float(np.max(np.abs(x - y))) for x, y in zip(a, b, strict=True))


@given(COLOR, UNIT, UNIT)
@example((1.0, 1.0, 1.0), 1.0, 0.0)
@example((0.05, 0.0, 0.0), 0.5, 1.0)
@example((0.0, 0.0, 1.0), 1e-10, 0.0)
def test_a_material_brighter_than_glass_comes_back(base: Any, metallic: float, r: float) -> None:
    assume(max(base) >= DARKEST)
    there = specular_from_metallic(base, metallic, r)
    assert distance(metallic_from_specular(*there), (base, metallic, r)) < EXACT


@given(COLOR, UNIT)
@example((0.0, 0.0, 0.0), 0.5)
@example((0.04, 0.04, 0.04), 0.5)
@example((0.02, 0.01, 0.0), 0.5)
def test_every_dielectric_comes_back(base: Any, r: float) -> None:
    there = specular_from_metallic(base, 0, r)
    assert distance(metallic_from_specular(*there), (base, 0, r)) < DOUBLE_DIVIDED


@given(COLOR, UNIT, UNIT)
@example((0.04, 0.0, 0.0), 0.5, 0.5)
@example((0.01, 0.02, 0.0), 0.9, 0.5)
def test_back_and_there_is_the_same_specular_material(base: Any, metallic: float, r: float) -> None:
    """Also below 0.04, where another metallic material may come back: its two terms are the same."""
    there = specular_from_metallic(base, metallic, r)
    again = specular_from_metallic(*metallic_from_specular(*there))
    assert (
        distance(there, again) < 1e-7
    )  # the square root of double precision, where two roots meet


def test_the_dark_have_two_descriptions_and_the_least_metallic_one_comes_back() -> None:
    first = specular_from_metallic((0.01, 0.01, 0.01), 0.5, 0)
    second = specular_from_metallic((0.02, 0.02, 0.02), 0.75, 0)
    # Roundings of double precision
    assert distance(first, second) < 1e-15
    back = metallic_from_specular(*second)
    np.testing.assert_allclose(back.base_color, 0.01, rtol=DOUBLE)
    np.testing.assert_allclose(back.metallic, 0.5, rtol=DOUBLE)


def test_known_materials() -> None:
    plastic = specular_from_metallic((0.8, 0.1, 0.1), 0, 0.3)
    np.testing.assert_allclose(plastic.diffuse, [0.8, 0.1, 0.1])
    np.testing.assert_allclose(plastic.specular, 0.04)
    assert plastic.gloss == pytest.approx(0.7)
    gold = specular_from_metallic((1.0, 0.78, 0.34), 1, 0.2)
    np.testing.assert_array_equal(gold.diffuse, 0)
    np.testing.assert_allclose(gold.specular, [1.0, 0.78, 0.34])


@pytest.mark.parametrize(
    ("diffuse", "specular"),
    [
        ((0.5, 0.5, 0.5), (0.04, 0.3, 0.04)),  # a dielectric with a green highlight
        ((0.5, 0.5, 0.5), (0.01, 0.01, 0.01)),  # an index below that of glass
        ((0.9, 0.9, 0.9), (0.9, 0.9, 0.9)),  # more than all light
    ],
)
def test_what_has_no_metallic_description_is_refused(diffuse: Any, specular: Any) -> None:
    with pytest.raises(ValueError, match="no metallic material has diffuse"):
        metallic_from_specular(diffuse, specular, 0.5)


def test_arrays_broadcast_and_keep_their_shape() -> None:
    rng = np.random.default_rng(0)
    base, metallic = rng.uniform(0.1, 1, (4, 5, 3)), rng.random((4, 1))
    there = specular_from_metallic(base, metallic, 0.25)
    assert there.diffuse.shape == there.specular.shape == (4, 5, 3)
    back = metallic_from_specular(*there)
    np.testing.assert_allclose(back.base_color, base, atol=EXACT)
    np.testing.assert_allclose(back.metallic, np.broadcast_to(metallic, (4, 5)), atol=EXACT)


def test_numbers_out_of_range_are_refused() -> None:
    with pytest.raises(ValueError, match=r"metallic 1.5 is out of range; allowed is 0 to 1"):
        specular_from_metallic((1, 1, 1), 1.5, 0)
    with pytest.raises(ValueError, match="base_color must have 3 numbers"):
        specular_from_metallic(1.0, 0, 0)
    with pytest.raises(ValueError, match="gloss nan is out of range"):
        metallic_from_specular((1, 1, 1), (0.04, 0.04, 0.04), np.nan)


def test_a_way_back_with_the_wrong_f0_is_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    there = specular_from_metallic((0.6, 0.4, 0.2), 0.5, 0.5)
    monkeypatch.setattr(conversions, "F0_DIELECTRIC", F0_DIELECTRIC + 0.001)
    back = metallic_from_specular(*there)
    assert distance(back, ((0.6, 0.4, 0.2), 0.5, 0.5)) > 1e-4
