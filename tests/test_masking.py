"""Masking and shadowing: the identities that define Smith's, and the published values of the others."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import drjit as dr
import numpy as np
import pytest
from mpmath import mp
from support.directions import polar, random_directions
from support.tolerances import DOUBLE, DOUBLE_DIVIDED, SINGLE

from gonio.lang import vec3
from gonio.parts import distribution, frame, masking

Float, Float64 = dr.llvm.ad.Float, dr.llvm.ad.Float64

FACETS: dict[str, Any] = {"ggx": distribution.GGX, "beckmann": distribution.Beckmann}
SMITH: dict[str, Any] = {
    "ggx": lambda ax, ay: distribution.GGX(Float64(ax), Float64(ay)),
    "beckmann": lambda ax, ay: distribution.Beckmann(Float64(ax), Float64(ay)),
}
ROUND: dict[str, Any] = {"ggx": distribution.RoundGGX, "beckmann": distribution.RoundBeckmann}
EACH = pytest.mark.parametrize("name", SMITH)
ANGLES = np.radians([0.0, 10.0, 40.0, 70.0, 85.0, 89.0])


def vector(w: Any, T: Any = Float64) -> Any:
    w = np.asarray(w, np.float64)
    return vec3(*(T(np.ascontiguousarray(w[..., i])) for i in range(3)))


def numbers(value: Any) -> Any:
    return np.array(value).astype(np.float64).T


def normals(alpha_x: float, alpha_y: float) -> tuple[Any, Any]:
    """Normals (n, 3) and weights of solid angle that resolve a lobe of these widths."""
    y, w = np.polynomial.legendre.leggauss(30)
    edges = np.linspace(0, math.asinh(1e9), 40)
    low, high = edges[:-1, None], edges[1:, None]
    place = ((high - low) / 2 * y + (low + high) / 2).ravel()
    t, dt = np.sinh(place), ((high - low) / 2 * w).ravel() * np.cosh(place)
    psi = 2 * np.pi * (np.arange(512) + 0.5) / 512
    sx, sy = alpha_x * np.cos(psi)[:, None] * t, alpha_y * np.sin(psi)[:, None] * t
    z = 1 / np.sqrt(1 + sx * sx + sy * sy)
    weights = alpha_x * alpha_y * t * dt * z**3 * (2 * np.pi / 512)
    return np.stack([sx * z, sy * z, z], -1).reshape(-1, 3), weights.ravel()


def masked(name: str) -> Any:
    """G1 of facets of a distribution, by their widths and a direction."""
    return lambda ax, ay, w: masking.G1(SMITH[name](ax, ay), w)


def walter(ax: float, ay: float, w: Any) -> Any:
    """Walter's fit of Beckmann's G1."""
    return masking.G1_walter(SMITH["beckmann"](ax, ay), w)


def projected_area_error(name: str, G1: Any, alpha_x: float, alpha_y: float) -> float:
    """Largest |∫ G1(wo) max(wo.m, 0) D(m) dm / mu_o - 1|: what is seen is as large as the surface."""
    m, weights = normals(alpha_x, alpha_y)
    d = numbers(SMITH[name](alpha_x, alpha_y).D(vector(m))) * weights
    worst = 0.0
    for theta in ANGLES:
        wo = polar(theta, 0.6)
        seen = numbers(G1(alpha_x, alpha_y, vector(wo[None])))[0]
        area = seen * float(np.sum(d * np.maximum(m @ wo, 0)))
        worst = max(worst, abs(area / math.cos(theta) - 1))
    return worst


# 512 azimuths across the edge where wo.m = 0
PROJECTED = 1e-4


@EACH
def test_visible_facets_project_to_the_area_of_the_surface(name: str) -> None:
    for alpha in (1e-3, 0.1, 0.5, 1.0):
        for aspect in (1.0, 0.3):
            error = projected_area_error(name, masked(name), alpha, alpha * aspect)
            assert error < PROJECTED, (alpha, aspect)


def test_masking_of_the_other_distribution_is_caught() -> None:
    assert projected_area_error("ggx", masked("beckmann"), 0.5, 0.5) > 0.01
    assert projected_area_error("beckmann", masked("ggx"), 0.5, 0.5) > 0.01
    # and so is Walter's fit, which is off by up to 0.35 %
    assert projected_area_error("beckmann", walter, 0.5, 0.5) > 10 * PROJECTED


def furnace(name: str, G1: Any, theta: float, alpha: float) -> float:
    """Weak white furnace: facets that mirror everything, masked but not shadowed, reflect all light.

    ∫ G1(wo) D / (4 mu_o) dwi over the whole sphere is 1 (Heitz 2014, Eq. 93).
    """
    m, weights = normals(alpha, alpha)
    wo = polar(theta, 0.6)
    cos_h = m @ wo
    d = numbers(SMITH[name](alpha, alpha).D(vector(m)))
    seen = numbers(G1(alpha, alpha, vector(wo[None])))[0]
    # dwi = 4 |wo.m| dm
    kernel = seen * d / (4 * math.cos(theta)) * 4 * np.maximum(cos_h, 0)
    return float(np.sum(kernel * weights))


@EACH
def test_weak_white_furnace(name: str) -> None:
    for alpha in (1e-3, 0.3, 1.0):
        for theta in ANGLES:
            assert furnace(name, masked(name), theta, alpha) == pytest.approx(1, abs=PROJECTED)
    assert abs(furnace(name, walter, 1.2, 0.3) - 1) > 5 * PROJECTED


@EACH
def test_pairs_are_made_of_single_directions(name: str) -> None:
    """4 mu_i mu_o V is G1 G1, or 1 / (1 + Lambda_i + Lambda_o) with Lambda = 1 / G1 - 1."""
    wi, wo = (vector(random_directions(1000, seed)) for seed in (1, 2))
    for ax, ay in ((0.3, 0.3), (1.0, 0.2)):
        facets = SMITH[name](ax, ay)
        g_i, g_o = numbers(masking.G1(facets, wi)), numbers(masking.G1(facets, wo))
        scale = 4 * numbers(wi.z) * numbers(wo.z)
        separable = scale * numbers(masking.V_smith(facets, wi, wo))
        np.testing.assert_allclose(separable, g_i * g_o, rtol=DOUBLE)
        expected = 1 / (1 / g_i + 1 / g_o - 1)
        correlated = scale * numbers(masking.V_smith_correlated(facets, wi, wo))
        np.testing.assert_allclose(correlated, expected, rtol=DOUBLE)
        # Facets that are low hide in both directions: correlation leaves more of them lit and seen
        assert (expected >= g_i * g_o - DOUBLE).all()


def test_beckmann_masking_is_the_published_formula() -> None:
    theta = np.linspace(0.05, 1.55, 60)
    for m in (0.05, 0.4, 1.0):
        a = 1 / (m * np.tan(theta))
        Lambda = (np.vectorize(math.erf)(a) - 1) / 2 + np.exp(-a * a) / (2 * a * np.sqrt(np.pi))
        found = numbers(masking.G1(SMITH["beckmann"](m, m), vector(polar(theta))))
        np.testing.assert_allclose(found, 1 / (1 + Lambda), rtol=DOUBLE)
        # Blinn-Phong's, with n = 2 / m^2 - 2 in place of m
        n = 2 / m**2 - 2
        np.testing.assert_allclose(a, np.sqrt(n / 2 + 1) / np.tan(theta), rtol=DOUBLE)


def test_walters_fit_is_as_good_as_published() -> None:
    theta = np.linspace(0, 1.57, 2000)
    worst = 0.0
    for m in (0.1, 0.5, 1.0):
        w, facets = vector(polar(theta)), SMITH["beckmann"](m, m)
        exact = numbers(masking.G1(facets, w))
        fitted = numbers(masking.G1_walter(facets, w))
        worst = max(worst, float(np.max(np.abs(fitted / exact - 1))))
        V = numbers(masking.V_smith_walter(facets, w, w))
        np.testing.assert_allclose(4 * np.cos(theta) ** 2 * V, fitted**2, rtol=DOUBLE_DIVIDED)
    # "relative error below 0.35 %" (Walter et al., section 5.2)
    assert 0.002 < worst < 0.0036


def test_ggx_masking_is_the_published_formula() -> None:
    theta = np.linspace(0, 1.55, 60)
    for alpha in (1e-3, 0.4, 1.0):
        Lambda = (-1 + np.sqrt(1 + alpha**2 * np.tan(theta) ** 2)) / 2
        found = numbers(masking.G1(SMITH["ggx"](alpha, alpha), vector(polar(theta))))
        np.testing.assert_allclose(found, 1 / (1 + Lambda), rtol=DOUBLE)


def textbook(name: str, wi: Any, wo: Any, alpha: float) -> Any:
    """G as published, in NumPy."""
    mu_i, mu_o = wi[:, 2], wo[:, 2]
    h = wi + wo
    h /= np.linalg.norm(h, axis=1, keepdims=True)
    nh, vh = h[:, 2], np.sum(wo * h, 1)

    def schlick(mu: Any, k: float) -> Any:
        return mu / (mu * (1 - k) + k)

    roughness = math.sqrt(alpha)
    return {
        "implicit": mu_i * mu_o,
        "neumann": mu_i * mu_o / np.maximum(mu_i, mu_o),
        "cook_torrance": np.minimum(1, np.minimum(2 * nh * mu_o / vh, 2 * nh * mu_i / vh)),
        "kelemen": mu_i * mu_o / vh**2,
        "schlick_beckmann": schlick(mu_i, alpha * math.sqrt(2 / math.pi))
        * schlick(mu_o, alpha * math.sqrt(2 / math.pi)),
        "schlick_ggx": schlick(mu_i, alpha / 2) * schlick(mu_o, alpha / 2),
        "schlick_ue4": schlick(mu_i, (roughness + 1) ** 2 / 8)
        * schlick(mu_o, (roughness + 1) ** 2 / 8),
    }[name]


NAMES = [
    "implicit",
    "neumann",
    "cook_torrance",
    "kelemen",
    "schlick_beckmann",
    "schlick_ggx",
    "schlick_ue4",
]


def visibility(name: str, wi: Any, wo: Any, alpha: Any) -> Any:
    cos_h = frame.cos_half(wi, wo)
    return {
        "implicit": lambda: masking.V_implicit() + 0 * wi.z,
        "neumann": lambda: masking.V_neumann(wi, wo),
        "cook_torrance": lambda: masking.V_cook_torrance(wi, wo),
        "kelemen": lambda: masking.V_kelemen(cos_h),
        "schlick_beckmann": lambda: masking.V_schlick(wi, wo, masking.schlick_k_beckmann(alpha)),
        "schlick_ggx": lambda: masking.V_schlick(wi, wo, masking.schlick_k_ggx(alpha)),
        "schlick_ue4": lambda: masking.V_schlick(wi, wo, masking.schlick_k_ue4(dr.sqrt(alpha))),
    }[name]()


@pytest.mark.parametrize("name", NAMES)
def test_the_others_are_the_textbook_formulas(name: str) -> None:
    wi, wo = (random_directions(2000, seed).astype(np.float64) for seed in (3, 4))
    wi, wo = (w / np.linalg.norm(w, axis=1, keepdims=True) for w in (wi, wo))
    found = numbers(visibility(name, vector(wi), vector(wo), Float64(0.4)))
    G = 4 * wi[:, 2] * wo[:, 2] * found
    np.testing.assert_allclose(G, textbook(name, wi, wo, 0.4), rtol=DOUBLE_DIVIDED)


def test_schlick_of_one_direction() -> None:
    mu = np.array([0.0, 0.3, 1.0])
    np.testing.assert_allclose(numbers(masking.G1_schlick(Float64(mu), 0.2)), mu / (mu * 0.8 + 0.2))


@pytest.mark.parametrize("name", [*NAMES, *SMITH])
def test_values_and_gradients_are_finite_in_the_horizon(name: str) -> None:
    z = np.array([1e-7, 1e-7, 1.0, 1e-4, 1e-7, 1.0])
    phi = np.array([0.0, math.pi, 0.0, 1.0, 2.0, 0.0])
    wi = np.stack([np.sqrt(1 - z * z) * np.cos(phi), np.sqrt(1 - z * z) * np.sin(phi), z], -1)
    wo = np.array([[1.0, 0, 1e-7]] * 5 + [[0, 0, 1]])
    for value in (1e-4, 1.0):
        a, b = vector(wi, Float), vector(wo, Float)
        alpha = Float(np.full(len(z), value, np.float32))
        dr.enable_grad(a, b, alpha)
        if name in SMITH:
            V = 0
            for facets in (FACETS[name](alpha, alpha), ROUND[name](alpha)):
                V += masking.V_smith(facets, a, b) + masking.V_smith_correlated(facets, a, b)
        else:
            V = visibility(name, a, b, alpha)
        dr.backward(dr.sum(V), flags=dr.ADFlag.Default | dr.ADFlag.AllowNoGrad)
        assert np.isfinite(numbers(V)).all()
        for gradient in (*dr.grad(a), *dr.grad(b), dr.grad(alpha)):
            assert np.isfinite(numbers(gradient)).all()


@EACH
def test_round_facets_are_those_of_equal_widths(name: str) -> None:
    w = random_directions(1000, 5).astype(np.float64)
    w = vector(w / np.linalg.norm(w, axis=1, keepdims=True))
    for alpha in (1e-3, 0.25, 1.0):
        facets, same = ROUND[name](Float64(alpha)), SMITH[name](alpha, alpha)
        np.testing.assert_allclose(numbers(facets.area(w)), numbers(same.area(w)), rtol=DOUBLE)
        # far down Beckmann's slope, exp(-tan^2 / alpha^2) has the digits of its exponent
        np.testing.assert_allclose(
            numbers(facets.D(w)), numbers(same.D(w)), rtol=DOUBLE_DIVIDED, atol=1e-30
        )


def at_the_edge_of_grooves(count: int) -> tuple[Any, Any]:
    """Opposite float32 pairs where V-grooves begin to hide: 1 - G is what a cosine's last bit makes it."""
    rng = np.random.default_rng(5)
    low = 10 ** rng.uniform(-17, -2, count)
    turn, way = 2 * np.pi * rng.random((2, count))
    # In the plane of x as well, where one tangential part is tiny and not 0
    turn = turn * rng.choice([0, 1], count) + 10 ** rng.uniform(-17, -1, count)
    side = 2 * low * np.sqrt(rng.random(count)) * rng.choice([1, 1e-3], count)
    wo = np.stack([np.cos(turn), np.sin(turn), low], 1).astype(np.float32)
    across = np.stack([side * np.cos(way), side * np.sin(way)], 1)
    wi = np.append(across - wo[:, :2], wo[:, 2:], 1).astype(np.float32)
    flat2 = ((wi.astype(np.float64) + wo)[:, :2] ** 2).sum(axis=1)
    low2 = wo[:, 2].astype(np.float64) ** 2
    # |h|^2 = 4 h.z mu_o
    wi[:, 2] = wo[:, 2] + np.sqrt(np.maximum(4 * low2 - flat2, 0))
    fits = flat2 < 4 * low2
    return wi[fits], wo[fits]


def hidden_by_grooves(wi: Any, wo: Any) -> Any:
    """1 - G in fractions, which are exact."""
    truth = []
    for a, b in zip(wi.tolist(), wo.tolist(), strict=True):
        h = [Fraction(x) + Fraction(y) for x, y in zip(a, b, strict=True)]
        G = 4 * h[2] * min(Fraction(a[2]), Fraction(b[2])) / sum(c * c for c in h)
        truth.append(float(1 - min(G, Fraction(1))))
    return np.array(truth)


def test_what_grooves_hide_keeps_its_digits_where_it_is_little() -> None:
    """1 - G of V-grooves in float32 beside fractions of the same inputs, and 1 - G as a difference."""
    pairs = at_the_edge_of_grooves(3000)
    truth, (i, o) = hidden_by_grooves(*pairs), (vector(w, Float) for w in pairs)
    assert (truth[truth > 0] < 1e-9).sum() > 20
    found = np.abs(numbers(masking.lost_cook_torrance(i, o)) - truth)
    difference = np.abs(numbers(1 - masking.G_cook_torrance(i, o)) - truth)
    # A difference of ones is off by their rounding, 6e-8 each; sums with theirs by its square, some times
    assert difference.max() > 5e-8
    assert found.max() < 2**-46
    # A coat lets in about 3.6 |h| / 2 at an index of 1.5, and what it is off by counts beside that
    share = np.linalg.norm(pairs[0].astype(np.float64) + pairs[1], axis=1) + truth
    assert (found / share).max() < 1e-5
    assert (difference / share).max() > 1


def test_what_grooves_hide_is_that_of_fractions_anywhere() -> None:
    wi, wo = (random_directions(500, seed).astype(np.float32) for seed in (8, 9))
    found = numbers(masking.lost_cook_torrance(vector(wi, Float), vector(wo, Float)))
    # Of 1 - G near 0 the square of a float32's rounding is left, four times
    np.testing.assert_allclose(found, hidden_by_grooves(wi, wo), rtol=SINGLE, atol=2**-46)


@pytest.mark.parametrize("lost", ["lost_smith", "lost_smith_correlated"])
def test_what_beckmann_facets_hide_is_that_of_60_digits(lost: str) -> None:
    """1 - G from erfc, at slopes where a difference of ones has no digit left in float32."""
    mp.dps = 60
    alpha, mu = 1e-3, np.array([1e-5, 3e-4, 1e-3, 2e-3, 3.3e-3, 6e-3])
    wi = np.stack([np.sqrt(1 - mu * mu), 0 * mu, mu], 1)
    wo = np.stack([np.sqrt(1 - 4 * mu * mu), 0 * mu, 2 * mu], 1)

    def Lambda(z: float) -> Any:
        """Heitz 2014, Eq. 68."""
        a = z / (alpha * mp.sqrt(1 - mp.mpf(z) ** 2))
        return (mp.exp(-a * a) / (a * mp.sqrt(mp.pi)) - mp.erfc(a)) / 2

    for T, allowed in ((Float64, 1e-11), (Float, 1e-5)):
        facets = distribution.RoundBeckmann(T(alpha))
        found = numbers(getattr(masking, lost)(facets, vector(wi, T), vector(wo, T)))
        for value, a, b in zip(found, wi[:, 2], wo[:, 2], strict=True):
            i, o = Lambda(a), Lambda(b)
            G = 1 / (1 + i + o) if lost.endswith("correlated") else 1 / ((1 + i) * (1 + o))
            assert value == pytest.approx(float(1 - G), rel=allowed)
    plain = 1 - 4 * wi[:, 2] * wo[:, 2] * numbers(
        masking.V_smith(
            distribution.RoundBeckmann(Float(alpha)), vector(wi, Float), vector(wo, Float)
        )
    )
    assert abs(plain[4] / float(Lambda(mu[4])) - 1) > 0.01


def test_what_smith_hides_keeps_its_digits_where_it_is_little() -> None:
    """sqrt(mu^2 + alpha^2 sin^2) - mu with 60 digits: a difference in float32 has none near the normal."""
    rng = np.random.default_rng(7)
    grazing, steep = 10 ** rng.uniform(-18, 0, 100), 1 - 10 ** rng.uniform(-7, 0, 100)
    mu = np.concatenate([grazing, steep]).astype(np.float32)
    alpha = (10 ** rng.uniform(-4, 0, 200)).astype(np.float32)
    with mp.workdps(60):
        exact = [
            float(mp.sqrt(m**2 + a**2 * (1 - m**2)) - m)
            for m, a in (
                (mp.mpf(float(m)), mp.mpf(float(a))) for m, a in zip(mu, alpha, strict=True)
            )
        ]
    w = vec3(dr.sqrt(dr.maximum(1 - Float(mu) * Float(mu), 0)), 0, Float(mu))
    found = numbers(distribution.RoundGGX(Float(alpha)).hidden(w))
    np.testing.assert_allclose(found, exact, rtol=SINGLE)


def test_what_grooves_hide_has_its_derivatives_in_float32() -> None:
    """Beside those of the plain form in double precision, which has no digits to carry along."""
    wi, wo = (random_directions(500, seed).astype(np.float32) for seed in (8, 9))
    slopes = []
    for hidden, T in (
        (masking.lost_cook_torrance, Float),
        (masking.lost_cook_torrance_plain, Float64),
    ):
        i, o = vector(wi.astype(np.float64), T), vector(wo.astype(np.float64), T)
        dr.enable_grad(i, o)
        dr.backward(hidden(i, o))
        slopes.append([np.array(dr.grad(w), dtype=np.float64) for w in (i, o)])
    np.testing.assert_allclose(slopes[0], slopes[1], atol=SINGLE * np.abs(slopes[1]).max())


def test_grooves_have_their_derivatives_in_float32_down_to_the_horizon() -> None:
    """By the smaller cosine G / (4 mu_i mu_o) has only the half vector's: a quotient's has no digits."""
    rng = np.random.default_rng(10)
    wi, wo = random_directions(500, 8), random_directions(500, 9)
    wi[:, 2] = 10 ** rng.uniform(-7, -3, 500)
    wi, wo = wi.astype(np.float32), wo.astype(np.float32)
    slopes = []
    for T in (Float, Float64):
        i = vector(wi.astype(np.float64), T)
        dr.enable_grad(i)
        dr.backward(masking.V_cook_torrance(i, vector(wo.astype(np.float64), T)))
        slopes.append(np.array(dr.grad(i), dtype=np.float64))
    np.testing.assert_allclose(slopes[0], slopes[1], atol=SINGLE * np.abs(slopes[1]).max())
