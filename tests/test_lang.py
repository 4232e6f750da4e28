"""The vocabulary of models, where its Python meaning is more than a function of Dr.Jit's."""

from __future__ import annotations

import drjit as dr
import numpy as np
import pytest
from support.tolerances import DOUBLE

from gonio import backend
from gonio.lang import power, select, vec3


@pytest.mark.parametrize("exponent", [0, 1, 2, 3, 5.0, 17, 64, 101, -1, -3])
def test_a_whole_power_of_a_negative_number_is_a_product_with_its_sign(exponent: float) -> None:
    Float64 = backend.array_module().Float64
    base = np.array([-1.5, -0.5, -0.25, 0.75])
    np.testing.assert_allclose(power(Float64(base), exponent), base**exponent, rtol=DOUBLE)
    assert power(-0.5, exponent) == pytest.approx((-0.5) ** exponent, rel=DOUBLE)


@pytest.mark.parametrize("base", [0.5, 0.3, 1e-20])
def test_a_power_too_small_for_its_precision_is_nearly_nothing_and_not_minus_infinity(
    base: float,
) -> None:
    Float64 = backend.array_module().Float64
    # Results around 2^-1022, the smallest normal number
    exponent = np.linspace(1000, 1080, 20001) / -np.log2(base)
    found = np.array(power(Float64(base), Float64(exponent)))
    assert (found >= 0).all()
    # Results below the smallest normal number, 2e-308, may be 0
    np.testing.assert_allclose(found, np.power(base, exponent), rtol=DOUBLE, atol=1e-307)
    # What it mends; if this fails, Dr.Jit is right by itself.
    assert np.isneginf(np.array(dr.power(Float64(base), Float64(exponent)))).any()


@pytest.mark.parametrize("rows", [1, 2, 3, 4])
def test_components_of_plain_numbers_are_no_rows_of_a_number_beside_them(rows: int) -> None:
    """Three of them once passed for three rows."""
    Float64 = backend.array_module().Float64
    x = Float64(np.arange(rows) - 0.5)
    at = np.arange(rows)[:, None] > 0
    for swapped in (False, True):
        pair = (x, vec3(5, 6, 7)) if swapped else (vec3(5, 6, 7), x)
        found = np.array(select(x > 0, *pair)).T
        alone, vector = np.arange(rows)[:, None] - np.full(3, 0.5), np.full((rows, 3), (5, 6, 7))
        np.testing.assert_array_equal(found, np.where(at != swapped, vector, alone))
