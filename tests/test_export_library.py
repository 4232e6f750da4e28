"""What exports bring along because shading languages lack it, against mpmath's 40 digits."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import drjit as dr
import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.tolerances import DOUBLE, SINGLE

import gonio
from gonio import lang
from gonio.export import library
from gonio.parts import special
from gonio.polynomials import terms_in_single

# What the fits of gonio.export.library are good to.
FITTED = 2e-8


mpmath.mp.dps = 40

INSIDE = np.concatenate([np.linspace(-1, 1, 401), [1e-9, -1e-9, 1 - 1e-9, 1e-9 - 1]])


def worst(ours: Callable[[float], Any], right: Callable[[Any], Any], places: Any) -> float:
    """Largest relative error."""
    return max(
        abs(float(ours(float(x)) - right(mpmath.mpf(float(x))))) / max(abs(float(right(x))), 1e-12)
        for x in places
    )


def test_arc_sine_and_arc_cosine_are_exact_to_2e_8() -> None:
    assert worst(library.safe_asin, mpmath.asin, INSIDE) < FITTED
    assert worst(library.safe_acos, mpmath.acos, INSIDE[INSIDE < 1]) < FITTED


@pytest.mark.parametrize("x", [-1.5, -1.0, 1.0, 1.5])
def test_arc_sine_and_arc_cosine_limit_their_argument(x: float) -> None:
    limited = min(max(x, -1), 1)
    assert library.safe_asin(x) == pytest.approx(math.asin(limited), rel=FITTED)
    assert library.safe_acos(x) == pytest.approx(math.acos(limited), rel=FITTED, abs=DOUBLE)


def twice_atan_over(v: Any) -> Any:
    return 2 * mpmath.atan(v) / v if v else mpmath.mpf(2)


@pytest.mark.parametrize(
    ("ours", "limit"),
    [
        (library.twice_atan_over, 2e-8),
        (lang.twice_atan_over, 1e-15),
        (lambda v: lang.twice_atan_over(dr.llvm.Float(v))[0], 3e-7),
        (lambda v: lang.twice_atan_over(dr.llvm.Float64(v))[0], 1e-15),
    ],
)
def test_the_angle_of_a_half_tangent_is_exact(ours: Callable[[float], Any], limit: float) -> None:
    # float32 rounds the argument, too: to itself where it is a multiple of 2^-12
    places = np.round(INSIDE[::4] * 4096) / 4096
    assert worst(ours, twice_atan_over, [*places, 0.0, 1.0, -1.0]) < limit


@pytest.mark.parametrize("Float", [dr.llvm.ad.Float, dr.llvm.ad.Float64])
def test_its_derivative_is_that_of_the_quotient(Float: Any) -> None:
    places = [-1.0, -0.5, -0.25, 0.0, 0.125, 0.5, 1.0]
    v = Float(places)
    dr.enable_grad(v)
    dr.set_grad(v, 1)
    value = lang.twice_atan_over(v)
    dr.forward_to(value)
    slopes = [float(mpmath.diff(twice_atan_over, x)) if x else 0.0 for x in places]
    # Of a polynomial that is fitted to the value
    np.testing.assert_allclose(dr.grad(value).numpy(), slopes, rtol=2e-5, atol=1e-7)


@given(
    st.floats(0.01, 1),
    st.lists(st.floats(-2, 2), min_size=1, max_size=14),
    st.floats(-1, 1),
)
def test_polynomials_leave_out_what_single_precision_does_not_tell(
    bound: float, further: list[float], part: float
) -> None:
    """Against the sum of all terms in many digits."""
    coefficients = [1.0, *(c * 0.4 ** (k + 1) for k, c in enumerate(further))]
    count = terms_in_single(bound, coefficients)
    x = mpmath.mpf(part * bound)
    wanted = mpmath.fsum(mpmath.mpf(c) * x**k for k, c in enumerate(coefficients))
    left_out = mpmath.fsum(mpmath.mpf(c) * x**k for k, c in enumerate(coefficients[count:], count))
    # A quarter of what single precision tells apart beside 1, and never more than of the value
    assert abs(left_out) <= 2.0**-26 * abs(wanted)
    found = lang.polynomial(dr.llvm.Float64(float(x)), bound, *coefficients)[0]
    # A rounding for each term
    assert found == pytest.approx(float(wanted), rel=1e-14)


def test_a_series_is_as_long_as_the_precision_needs() -> None:
    """Leibniz's series of atan at 1 / 7, whose terms are 7^-2k / (2k + 1)."""
    odd = [(-1.0) ** k / (2 * k + 1) for k in range(12)]
    # 49^-4 / 9 is 1.9e-8, 49^-5 / 11 is 3e-10; half a unit in the last place is 3e-8
    assert terms_in_single(1 / 49, odd) == 5
    # Where a value may be 0, every digit counts
    assert terms_in_single(1, [1.0, -1.0, 1e-12]) == 3
    assert terms_in_single(1e-9, [1.0, 1.0, 1.0]) == 2


@pytest.mark.parametrize("Float", [dr.llvm.Float, dr.llvm.Float64])
def test_small_logarithms_and_exponentials_keep_their_digits(Float: Any) -> None:
    single = Float is dr.llvm.Float
    places = [float(np.float32(x)) for x in np.linspace(-0.2499, 0.2499, 41) if x]
    for ours, exact in (
        (special.log1p_small, mpmath.log1p),
        (special.log1p, mpmath.log1p),
        (special.expm1, mpmath.expm1),
    ):
        for x, found in zip(places, ours(Float(places)).numpy(), strict=True):
            # A few roundings of each precision
            assert found == pytest.approx(float(exact(x)), rel=4e-7 if single else 2e-15)


def test_the_smooth_root_of_a_negative_number_is_nan_as_in_shaders() -> None:
    places = dr.llvm.ad.Float([-1.0, 0.0, 4.0])
    dr.enable_grad(places)
    dr.set_grad(places, 1)
    root = lang.smooth_sqrt(places)
    dr.forward_to(root)
    np.testing.assert_array_equal(root.numpy(), [np.nan, 0, 2])
    assert np.isfinite(dr.grad(root).numpy()[1:]).all()
    assert math.isnan(lang.smooth_sqrt(-1.0))
    assert lang.smooth_sqrt(4.0) == 2


def test_a_choice_of_two_whole_numbers_is_a_real_number() -> None:
    mask = dr.llvm.Float([0.0, 1.0]) > 0.5
    np.testing.assert_allclose(
        lang.sin(lang.select(mask, 1, 0)).numpy(), [0, math.sin(1)], rtol=SINGLE
    )
    assert lang.select(True, 1, 0) / 2 == 0.5
    # Integers among the arrays stay what they are
    assert type(lang.select(mask, dr.llvm.UInt(3), 0)) is dr.llvm.UInt


def test_the_error_function_is_exact_to_3e_8() -> None:
    # As the name says
    assert worst(library.erf, mpmath.erf, np.linspace(-6, 6, 241)) < 3e-8
    assert library.erf(1e30) == pytest.approx(1)


def test_the_inverse_error_function_is_exact_to_single_precision() -> None:
    # Giles gives 7 units in the last place of a float32, at which 1 - x has few digits left.
    assert worst(library.erfinv, mpmath.erfinv, np.linspace(-0.999, 0.999, 201)) < 2e-6


def test_a_coarser_polynomial_is_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(library, "ATAN_3", library.ATAN_3 * 1.00001)
    assert worst(library.safe_asin, mpmath.asin, INSIDE) > 2e-8


class _Lattice:
    """A model as `sampled_albedo` sees one: its own methods, on one direction at a time."""

    def __init__(self, model: gonio.Model) -> None:
        self.model = model

    def sample(self, wo: Any, u: Any) -> Any:
        drawn = self.model.sample(np.array(wo, np.float64), np.array(u, np.float64))
        return gonio.Sample(_vector(drawn.wi), float(drawn.pdf))

    def eval(self, wi: Any, wo: Any) -> Any:
        return _vector(self.model.eval(np.array(wi, np.float64), np.array(wo, np.float64)))


def _vector(values: Any) -> Any:
    from gonio.lang import vec3

    return vec3(*(float(v) for v in values))


@pytest.mark.parametrize("theta", [0.0, 60.0, 85.0])
def test_the_sampled_albedo_is_near_the_closed_form(
    theta: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(library, "ALBEDO_SAMPLES", 233)  # each is a call from Python
    eon = gonio.model("eon", roughness=0.7)
    wo = [math.sin(math.radians(theta)), 0.0, math.cos(math.radians(theta))]
    found = library.sampled_albedo(_Lattice(eon), _vector(wo))  # type: ignore[arg-type]
    # The rule has 233 nodes here
    assert np.allclose(np.array(found), eon.albedo(np.array(wo)), atol=0.01)
