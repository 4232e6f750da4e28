"""Roughness scales: published formulas, round trips, and what is refused."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.tolerances import DOUBLE_DIVIDED

import gonio
from gonio import conversions as c

# Gotanda prints 2.22222 for 20/9 in B, which is 1e-6 of it.
TWENTY_NINTHS = 2e-6

# A quotient of two sums in double precision.
A_FEW_ROUNDINGS = 1e-14

# tan(theta) is theta to this at the 0.01 radians of the test's sigma, many times over.
SMALL_ANGLES = 1e-3


def test_perceptual_roughness_squares_to_alpha():
    assert c.alpha_from_perceptual(0.5) == 0.25
    assert c.perceptual_from_alpha(0.25) == 0.5


def test_shininess_of_beckmann_is_that_of_walter_2007():
    # alpha_p = 2 / alpha_b^2 - 2, section 5.2 of the paper
    assert c.shininess_from_alpha(0.1) == pytest.approx(198)
    assert c.shininess_from_alpha(1.0) == 0
    assert c.alpha_from_shininess(198) == pytest.approx(0.1)


def test_sigma_of_triace_is_gotandas():
    assert c.sigma_from_shininess(8) == 0.5
    assert c.shininess_from_sigma(0.5) == 8


def test_sigma_of_triace_gives_its_eq23_the_coefficients_of_qon():
    n, wi, wo = 30.0, np.array([0.6, 0, 0.8]), np.array([0.28, 0, 0.96])
    sigma = c.sigma_from_shininess(n)
    triace = gonio.TriAceOrenNayar(shininess=n, variant="eq23").eval(wi, wo)
    # Both are float64 here.
    np.testing.assert_allclose(gonio.QON(sigma=sigma).eval(wi, wo), triace, rtol=TWENTY_NINTHS)


def test_r_weighs_the_retro_reflection_like_qon():
    sigma = 0.7
    r = c.r_from_sigma(sigma)
    A = 1 - 0.5 * 0.49 / (0.49 + 0.33)
    B = 0.45 * 0.49 / (0.49 + 0.09)
    assert r == pytest.approx(B / A, rel=A_FEW_ROUNDINGS)
    # s/t is 0 at right angles and 0.5 / 0.5 = 1 here, so the ratio of the two values is 1 + B/A.
    flat, retro = np.array([0, 0, 1.0]), np.array([math.sqrt(0.5), 0, math.sqrt(0.5)])
    for model in (gonio.QON(sigma=sigma), gonio.FON(roughness=r)):
        ratio = model.eval(retro, retro)[0] / model.eval(flat, retro)[0]
        assert ratio == pytest.approx(1 + B / A / math.sqrt(2), rel=DOUBLE_DIVIDED)


def test_small_facet_angles_have_twice_the_variance_in_beckmanns_slope():
    # <tan^2> = m^2 for Beckmann and 2 sigma^2 for a narrow Gaussian of angles in two dimensions
    sigma = 0.01
    theta = np.linspace(0, 0.1, 200001)
    weight = np.exp(-(theta**2) / (2 * sigma**2)) * np.cos(theta) * np.sin(theta)
    slope = np.sum(weight * np.tan(theta) ** 2) / np.sum(weight)
    assert c.alpha_from_sigma(sigma) == pytest.approx(math.sqrt(slope), rel=SMALL_ANGLES)


# Floats above 1e-6, since squares and their differences lose the smaller ones.
PAIRS = [
    (c.alpha_from_perceptual, c.perceptual_from_alpha, 1e-6, 1),
    (c.shininess_from_alpha, c.alpha_from_shininess, 1e-6, 1),
    (c.shininess_from_sigma, c.sigma_from_shininess, 1e-6, c.HALF_PI),
    (c.alpha_from_sigma, c.sigma_from_alpha, 1e-6, c.SIGMA_SMALL),
    (c.r_from_sigma, c.sigma_from_r, 1e-6, c.HALF_PI),
]


@pytest.mark.parametrize(("there", "back", "low", "high"), PAIRS)
@given(data=st.data())
def test_there_and_back_is_the_same(there, back, low, high, data):
    x = data.draw(st.floats(low, high))
    assert back(there(x)) == pytest.approx(x, rel=DOUBLE_DIVIDED)


@pytest.mark.parametrize(("there", "back", "low", "high"), PAIRS)
def test_arrays_give_arrays_and_numbers_give_numbers(there, back, low, high):
    x = np.linspace(low, high, 6).reshape(2, 3)
    result = there(x)
    assert isinstance(result, np.ndarray)
    assert result.shape == (2, 3)
    assert result[1, 0] == there(float(x[1, 0]))
    assert type(there(float(x[1, 0]))) is float
    assert type(back(there(float(x[1, 0])))) is float


@pytest.mark.parametrize(
    ("function", "value", "message"),
    [
        (c.alpha_from_perceptual, 1.5, "perceptual 1.5 is out of range; allowed is 0 to 1."),
        (c.perceptual_from_alpha, -1, "alpha -1 is out of range; allowed is 0 to 1."),
        (c.shininess_from_alpha, 0, "alpha 0 is out of range; allowed is 0 to 1, without 0."),
        (c.alpha_from_shininess, -3, "shininess -3 is out of range; allowed is at least 0."),
        (c.sigma_from_shininess, 0, "shininess 0 is out of range; allowed is at least 0.810569."),
        (c.shininess_from_sigma, 2, "sigma 2 is out of range; allowed is 0 to pi/2, without 0."),
        (c.alpha_from_sigma, 0.6, "sigma 0.6 is out of range; allowed is 0 to 0.5."),
        (c.sigma_from_r, 0.9, "r 0.9 is out of range; allowed is 0 to 0.776702."),
        (c.r_from_sigma, math.nan, "sigma nan is out of range; allowed is 0 to pi/2."),
        (c.alpha_from_shininess, math.inf, "shininess inf is out of range; allowed is at least 0."),
        (c.r_from_sigma, np.array([0.1, 7]), "sigma 7 is out of range; allowed is 0 to pi/2."),
    ],
)
def test_values_off_the_scale_are_refused_in_one_line(function, value, message):
    with pytest.raises(ValueError, match=r"out of range") as caught:
        function(value)
    assert str(caught.value) == message


def test_convert_takes_the_shortest_way_and_tells_it():
    result = c.convert(0.5, "perceptual", "shininess")
    assert result.value == pytest.approx(2 / 0.25**2 - 2)
    assert result.steps == (c.alpha_from_perceptual, c.shininess_from_alpha)
    assert [m.partition(" =")[0] for m in result.meanings()] == ["alpha", "n"]


def test_every_scale_converts_to_every_other():
    for source in c.SCALES:
        for target in c.SCALES:
            value = c.convert(0.3, "r", source).value
            assert c.convert(value, source, target).value > 0


def test_convert_to_the_same_scale_changes_nothing():
    assert c.convert(0.3, "r", "r").value == 0.3


def test_an_unknown_scale_names_the_known_ones():
    with pytest.raises(ValueError, match="no roughness scale 'gloss'; known are perceptual, alpha"):
        c.convert(0.5, "gloss", "alpha")
