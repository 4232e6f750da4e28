"""Parts on NumPy arrays: shapes, precision, and the backend without a compiler."""

from __future__ import annotations

import numpy as np
import pytest

import gonio
from gonio import backend
from gonio.arrays.elementwise import elementwise
from gonio.parts.fresnel import F_schlick, schlick_weight

# A polynomial in double precision; compiled, its products are fused with its sums.
A_FEW_ROUNDINGS = 1e-15


def test_arguments_broadcast_as_numpys_do() -> None:
    mu = np.linspace(0, 1, 5)[:, None]
    f0 = np.array([0.04, 0.5, 0.9])
    found = elementwise(F_schlick, mu, f0, 1)
    assert found.shape == (5, 3)
    assert found.dtype == np.float64
    np.testing.assert_allclose(found, f0 + (1 - f0) * (1 - mu) ** 5, rtol=A_FEW_ROUNDINGS)
    assert elementwise(schlick_weight, 0.5).shape == ()


def test_a_function_of_nothing_gives_one_value_everywhere() -> None:
    np.testing.assert_array_equal(elementwise(lambda x: 2.0, [1.0, 2.0, 3.0]), [2, 2, 2])


def test_the_scalar_backend_computes_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    mu = np.random.default_rng(0).random((7, 3))
    compiled = elementwise(F_schlick, mu, 0.3, 0.8)
    monkeypatch.setattr(backend, "_chosen", "scalar")
    np.testing.assert_allclose(
        elementwise(F_schlick, mu, 0.3, 0.8), compiled, rtol=10 * A_FEW_ROUNDINGS
    )
    assert gonio.backend.current() == "scalar"
