"""Distributions of facets: normalisation, precision and sampling, over the whole range of roughness."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import drjit as dr
import numpy as np
import pytest
from support.directions import from_cosine, polar
from support.tolerances import DOUBLE, DOUBLE_DIVIDED, SINGLE, SINGLE_PROMISED

from gonio.lang import MU_MIN, vec2, vec3
from gonio.parts import distribution, frame, masking, special

Float, Float64 = dr.llvm.ad.Float, dr.llvm.ad.Float64
# 400 azimuths, over which an anisotropic lobe's projected area is smooth and periodic.
TRAPEZES = 1e-7

# A polynomial and a division in double precision.
A_HUNDRED_ROUNDINGS = 1e-14

ALPHAS = np.concatenate([10 ** np.linspace(-4, 0, 17), [0.89, 0.9, 0.99, 0.9999999]])
PHI = 0.7  # an azimuth at which nothing is symmetric by chance

Density = Callable[[Any, Any], Any]


def both(Facets: Any) -> Density:
    """An anisotropic distribution with equal widths."""
    return lambda m, alpha: Facets(alpha, alpha).D(m)


def one(Facets: Any) -> Density:
    """A distribution with one width."""
    return lambda m, alpha: Facets(alpha).D(m)


DISTRIBUTIONS: dict[str, Density] = {
    "ggx": both(distribution.GGX),
    "round ggx": one(distribution.RoundGGX),
    "beckmann": both(distribution.Beckmann),
    "round beckmann": one(distribution.RoundBeckmann),
    "blinn_phong": one(distribution.BlinnPhong),
    "gaussian": one(distribution.Gaussian),
    "gtr1": one(distribution.GTR1),
}
EACH = pytest.mark.parametrize("name", DISTRIBUTIONS)


def vector(w: Any, T: Any = Float64) -> Any:
    """NumPy's (n, 3) as three Dr.Jit arrays, without going through float32."""
    return vec3(*(T(np.ascontiguousarray(w[..., i])) for i in range(3)))


def numbers(value: Any) -> Any:
    return np.array(value).astype(np.float64).T


def slopes(alpha: float, last: float = 1e9) -> tuple[Any, Any]:
    """Slopes t spaced like alpha sinh(y) up to `last`, and weights of dt."""
    y, w = np.polynomial.legendre.leggauss(30)
    edges = np.linspace(0, math.asinh(last / alpha), 60)
    low, high = edges[:-1, None], edges[1:, None]
    place = ((high - low) / 2 * y + (low + high) / 2).ravel()
    return alpha * np.sinh(place), ((high - low) / 2 * w).ravel() * alpha * np.cosh(place)


def normalisation_error(D: Density, T: Any) -> float:
    """Largest |∫ D(m) m.z dm - 1| over the range of alpha."""
    worst = 0.0
    for alpha in ALPHAS:
        t, dt = slopes(alpha)
        z = 1 / np.sqrt(1 + t * t)
        m = np.stack([t * z * math.cos(PHI), t * z * math.sin(PHI), z], -1)
        values = numbers(D(vector(m, T), T(alpha)))
        assert np.isfinite(values).all()
        # dm = t cos^3 dt dphi
        worst = max(worst, abs(float(np.sum(values * t * z**4 * dt)) * 2 * np.pi - 1))
    return worst


@EACH
def test_facets_cover_the_surface_exactly_once(name: str) -> None:
    assert normalisation_error(DISTRIBUTIONS[name], Float64) < DOUBLE
    assert normalisation_error(DISTRIBUTIONS[name], Float) < SINGLE


def test_a_gaussian_normalised_for_the_whole_plane_is_caught() -> None:
    """Without what lies beyond pi / 2, and with sin(theta) for theta: the usual 1 / (pi m^2)."""

    def plane(m: Any, alpha: Any) -> Any:
        return distribution.Gaussian(alpha).D(m) * distribution.Gaussian(alpha).norm()

    assert normalisation_error(plane, Float64) > 0.1


@pytest.mark.parametrize("anisotropy", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("Facets", [distribution.GGX, distribution.Beckmann])
def test_anisotropic_facets_cover_the_surface_exactly_once(Facets: Any, anisotropy: float) -> None:
    for alpha in (1e-4, 0.03, 0.5, 1.0):
        a = distribution.anisotropic_alpha(alpha, anisotropy)
        assert float(a.x * a.y) == pytest.approx(alpha**2)
        psi = np.pi * (np.arange(400) + 0.5) / 200
        t, dt = slopes(1.0)
        x, y = a.x * np.cos(psi)[:, None] * t, a.y * np.sin(psi)[:, None] * t
        z = 1 / np.sqrt(1 + x * x + y * y)
        m = np.stack([x * z, y * z, z], -1).reshape(-1, 3)
        values = numbers(Facets(Float64(a.x), Float64(a.y)).D(vector(m))).reshape(z.shape)
        # dm = cos^3 dx dy, and dx dy = ax ay t dt dpsi
        total = np.sum(values * z**4 * a.x * a.y * t * dt) * np.pi / 200
        assert total == pytest.approx(1, abs=TRAPEZES)


@EACH
def test_values_are_the_textbook_formulas(name: str) -> None:
    """With N.H alone, as the publications print them; accurate enough at alpha of 0.1 and more."""
    theta = np.linspace(0, 1.4, 50)
    m = polar(theta, PHI)
    z = np.cos(theta)
    for alpha in (0.1, 0.3, 0.7):
        n = 2 / alpha**2 - 2
        a2 = alpha**2
        textbook = {
            "ggx": a2 / (np.pi * (z * z * (a2 - 1) + 1) ** 2),
            "beckmann": np.exp(-(np.tan(theta) ** 2) / a2) / (np.pi * a2 * z**4),
            "blinn_phong": (n + 2) / (2 * np.pi) * z**n,
            "gaussian": np.exp(-((theta / alpha) ** 2)),
            "gtr1": (a2 - 1) / (np.pi * np.log(a2) * (1 + (a2 - 1) * z * z)),
        }[name.removeprefix("round ")]
        found = numbers(DISTRIBUTIONS[name](vector(m), Float64(alpha)))
        if name == "gaussian":  # its constant is tested by the normalisation
            found = found / found[0]
        np.testing.assert_allclose(found, textbook, rtol=DOUBLE)


@EACH
def test_sharpest_lobes_keep_their_digits_in_float32(name: str) -> None:
    """Published forms in N.H lose all of them: at alpha = 1e-4, cos(theta_h) rounds to 1."""
    t = np.concatenate([[0], 10.0 ** np.linspace(-7, -3.3, 50)])
    z = 1 / np.sqrt(1 + t * t)
    m = np.stack([t * z, 0 * t, z], -1).astype(np.float32)
    D = DISTRIBUTIONS[name]
    single = numbers(D(vector(m, Float), Float(1e-4)))
    double = numbers(D(vector(m.astype(np.float64)), Float64(float(np.float32(1e-4)))))
    np.testing.assert_allclose(single, double, rtol=SINGLE_PROMISED)
    published = 1e-8 / (np.pi * (m[:, 2] ** 2 * np.float32(1e-8 - 1) + np.float32(1)) ** 2 + 1e-30)
    if name == "ggx":
        assert np.max(np.abs(published / double - 1)) > 0.5


@EACH
def test_gradients_of_sharp_lobes_are_finite(name: str) -> None:
    m = np.concatenate([from_cosine(10.0 ** np.linspace(-9, 0, 60)), [[0, 0, 1]]]).astype(
        np.float32
    )
    for value in (1e-4, 1e-2, 1.0):
        w, alpha = vector(m, Float), Float(np.full(len(m), value, np.float32))
        dr.enable_grad(w, alpha)
        D = DISTRIBUTIONS[name](w, alpha)
        dr.backward(dr.sum(D))
        assert np.isfinite(numbers(D)).all()
        for gradient in (*dr.grad(w), dr.grad(alpha)):
            assert np.isfinite(numbers(gradient)).all()


# --- sampling --------------------------------------------------------------------------------------


def stratified(count: int) -> Any:
    rng = np.random.default_rng(7)
    x, y = np.meshgrid(np.arange(count), np.arange(count), indexing="ij")
    u = (np.stack([x.ravel(), y.ravel()], -1) + rng.random((count * count, 2))) / count
    return vec2(Float64(np.ascontiguousarray(u[:, 0])), Float64(np.ascontiguousarray(u[:, 1])))


Sampler = tuple[Callable[[Any, Any], Any], Callable[[Any, Any], Any]]


def drawn(facets: Callable[[Any], Any]) -> Sampler:
    """How facets of a width sample normals, and with which density."""
    return lambda a, u: facets(a).sample(u), lambda m, a: facets(a).density(m)


SAMPLERS: dict[str, Sampler] = {
    "ggx": drawn(distribution.RoundGGX),
    "ggx_anisotropic": drawn(lambda a: distribution.GGX(a, 0.4 * a)),
    "beckmann": drawn(distribution.RoundBeckmann),
    "blinn_phong": drawn(distribution.BlinnPhong),
    "gaussian": drawn(distribution.Gaussian),
    "gtr1": (
        lambda a, u: distribution.GTR1(a).sample(u),
        lambda m, a: distribution.GTR1(a).D(m) * m.z,
    ),
}


def probes(m: Any, alpha: float) -> Any:
    """Bounded functions of a normal that see the lobe at its own scale, shape (5, n)."""
    x, y, z = (m[:, i] for i in range(3))
    t2 = (x * x + y * y) / (alpha * alpha)
    c = x / np.maximum(np.hypot(x, y), 1e-300)
    return np.stack([1 / (1 + t2), 1 / (1 + 9 * t2), z, c * c / (1 + t2), c / (1 + t2)])


def sampling_error(sampler: Sampler, alpha: float) -> float:
    """Largest difference between means over samples and integrals of the density."""
    sample, density = sampler
    m = numbers(sample(Float64(alpha), stratified(400)))
    found = probes(m, alpha).mean(axis=1)
    t, dt = slopes(alpha, 1e7)
    psi = np.pi * (np.arange(128) + 0.5) / 64
    z = 1 / np.sqrt(1 + t * t)
    grid = np.stack(
        [
            np.cos(psi)[:, None] * t * z,
            np.sin(psi)[:, None] * t * z,
            np.broadcast_to(z, (len(psi), len(z))),
        ],
        -1,
    ).reshape(-1, 3)
    p = numbers(density(vector(grid), Float64(alpha)))
    weight = np.tile(t * z**3 * dt, len(psi)) * np.pi / 64
    expected = np.sum(probes(grid, alpha) * p * weight, axis=1)
    return float(np.max(np.abs(found - expected)))


# 160,000 stratified samples of functions between -1 and 1 are good to about this.
SAMPLING = 2e-4


@pytest.mark.parametrize("name", SAMPLERS)
def test_samples_have_the_density(name: str) -> None:
    for alpha in (1e-4, 1e-2, 0.3, 0.9, 1.0):
        assert sampling_error(SAMPLERS[name], alpha) < SAMPLING, alpha


def test_a_sampler_of_a_slightly_wider_lobe_is_caught() -> None:
    sample, density = SAMPLERS["ggx"]
    wrong = (lambda a, u: sample(1.005 * a, u), density)
    assert sampling_error(wrong, 0.3) > SAMPLING


VISIBLE = {"ggx": distribution.GGX, "beckmann": distribution.Beckmann}


def visible_error(name: str, theta: float, alpha: float, aspect: float, widen: float = 1) -> float:
    """Largest difference between means over visible normals and integrals of G1 max(wo.m, 0) D / mu_o."""
    ax, ay = Float64(alpha), Float64(alpha * aspect)
    facets, wider = VISIBLE[name](ax, ay), VISIBLE[name](widen * ax, widen * ay)
    wo = vector(polar(theta, 0.5)[None])
    m = numbers(wider.sample_visible(wo, stratified(400)))
    found = probes(m, alpha).mean(axis=1)
    t, dt = slopes(1.0, 1e7)
    psi = 2 * np.pi * (np.arange(256) + 0.5) / 256
    x, y = alpha * t * np.cos(psi)[:, None], alpha * aspect * t * np.sin(psi)[:, None]
    z = 1 / np.sqrt(1 + x * x + y * y)
    grid = np.stack([x * z, y * z, z], -1).reshape(-1, 3)
    facing = np.maximum(grid @ polar(theta, 0.5), 0)
    p = numbers(facets.D(vector(grid))) * facing * numbers(masking.G1(facets, wo)) / math.cos(theta)
    weight = (alpha * alpha * aspect * t * dt * z**3).ravel() * 2 * np.pi / 256
    expected = np.sum(probes(grid, alpha) * p * weight, axis=1)
    # p integrates to 1 only if G1 is what makes the visible area right
    assert np.sum(p * weight) == pytest.approx(1, abs=SAMPLING)
    return float(np.max(np.abs(found - expected)))


@pytest.mark.parametrize("name", VISIBLE)
@pytest.mark.parametrize("degrees", [0.0, 20.0, 60.0, 85.0, 89.0])
def test_visible_normals_have_the_density(name: str, degrees: float) -> None:
    for alpha in (1e-4, 0.05, 0.5, 1.0):
        for aspect in (1.0, 0.3):
            assert visible_error(name, math.radians(degrees), alpha, aspect) < 2 * SAMPLING


def test_visible_normals_of_a_slightly_wider_lobe_are_caught() -> None:
    for name in VISIBLE:
        assert visible_error(name, 1.0, 0.5, 1.0, widen=1.02) > 2 * SAMPLING


@pytest.mark.parametrize("name", VISIBLE)
def test_density_of_the_mirrored_direction_follows_from_that_of_the_normal(name: str) -> None:
    facets = VISIBLE[name](Float64(0.4), Float64(0.2))
    wo = vector(polar(np.linspace(0, 1.55, 40), 0.3))
    m = vector(polar(np.full(40, 0.2), 2.0))
    cos_h = dr.dot(wo, m)
    # pdf(wi) = G1 max(wo.m, 0) D / mu_o / (4 wo.m): the cosine cancels
    expected = numbers(masking.G1(facets, wo) * facets.D(m) / (4 * wo.z))
    assert (numbers(cos_h) > 0).any()
    np.testing.assert_allclose(
        numbers(distribution.pdf_visible(facets, wo, m)), expected, rtol=DOUBLE_DIVIDED
    )


# --- visible normals that mirror upwards ----------------------------------------------------------------


def mirrored(facets: Any, wo: Any, bound: Any) -> Any:
    """Directions that visible normals mirror wo (3,) into, (n, 3)."""
    view = vector(wo[None])
    return numbers(frame.mirror(view, facets.sample_bounded(view, stratified(200), bound)))


def lost(alpha: float, aspect: float, wo: Any, scale: float = 1) -> float:
    """Share of what is mirrored upwards that the bound leaves out; scale: of the bound.

    By the stretched hemisphere itself: h is the facet's normal there, w turns to wo, and 2 (w . h) h - w is
    what h mirrors it into, which the cap holds down to -bound w.z.
    """
    facets = distribution.GGX(Float64(alpha), Float64(alpha * aspect))
    bound = scale * float(distribution.ggx_bound(alpha * aspect, vec3(*wo)))
    wi = mirrored(facets, wo, 1)
    wi = wi[wi[:, 2] > 0]
    h, w = (wi + wo) / [alpha, alpha * aspect, 1], wo * [alpha, alpha * aspect, 1]
    h, w = h / np.linalg.norm(h, axis=1, keepdims=True), w / np.linalg.norm(w)
    height = 2 * (h @ w) * h[:, 2] - w[2]
    return float(np.mean(height < -bound * w[2]))


VIEWS = [polar(theta, phi) for theta, phi in ((0.0, 0.0), (0.3, 1.5), (0.9, 0.4), (1.5, 1.0))]


def test_the_bound_leaves_out_no_normal_that_mirrors_upwards() -> None:
    for alpha, aspect in ((0.02, 1.0), (0.3, 1.0), (0.6, 1.0), (1.0, 1.0), (2.0, 0.2)):
        assert all(lost(alpha, aspect, wo) == 0 for wo in VIEWS), (alpha, aspect)
    # It is as tight as that: a few percent less would lose some
    assert max(lost(0.6, 1.0, wo, scale=0.9) for wo in VIEWS) > 1e-3


def test_few_bounded_normals_of_round_facets_mirror_below_the_horizon() -> None:
    below = {}
    for alpha in (0.3, 0.5, 0.7, 1.0):
        facets = distribution.RoundGGX(Float64(alpha))
        for wo in VIEWS:
            for bound in (float(distribution.ggx_bound(alpha, vec3(*wo))), 1.0):
                wi = mirrored(facets, wo, bound)
                share = float(np.mean(wi[:, 2] <= 0))
                below[bound == 1] = max(share, below.get(bound == 1, 0.0))
    # 5 % at most of the others are left, says ggx_bound
    assert below[False] < 0.06
    assert below[True] > 0.45


def test_half_vectors_are_exact_for_a_mirror_and_finite_for_opposite_directions() -> None:
    wo = vector(polar([0.3, 1.2]).astype(np.float32), Float)
    wi = vec3(-wo.x, -wo.y, wo.z)
    m = numbers(frame.half_vector(wi, wo))
    np.testing.assert_array_equal(m[:, :2], 0)
    # The lowest directions that models see
    low = np.nextafter(np.float32(MU_MIN), np.float32(1))
    wi, wo = (vector(np.array([[x, 0, low]]), Float) for x in (1.0, -1.0))
    np.testing.assert_allclose(numbers(frame.half_vector(wi, wo)), [[0, 0, 1]], rtol=SINGLE)
    np.testing.assert_allclose(numbers(frame.cos_half(wi, wo)), low, rtol=SINGLE)


# D, and what exports take in its place at a half vector.
ALONG: dict[str, tuple[Density, Density]] = {
    "ggx": (
        lambda m, a: distribution.GGX(a, 4 * a).D(m),
        lambda h, a: distribution.GGX(a, 4 * a).D_along(h),
    ),
    "round ggx": (
        lambda m, a: distribution.RoundGGX(a).D(m),
        lambda h, a: distribution.RoundGGX(a).D_along(h),
    ),
    "round beckmann": (
        lambda m, a: distribution.RoundBeckmann(a).D(m),
        lambda h, a: distribution.RoundBeckmann(a).D_along(h),
    ),
    "gtr1": (
        lambda m, a: distribution.GTR1(a).D_narrow(m),
        lambda h, a: distribution.GTR1(a).D_narrow_along(h),
    ),
}


@pytest.mark.parametrize("name", ALONG)
@pytest.mark.parametrize("alpha", [1e-4, 0.03, 0.25])
def test_a_normals_length_does_not_matter_to_what_is_along_it(name: str, alpha: float) -> None:
    """In both precisions; and at the half vector of the lowest opposite directions."""
    of_unit, along = ALONG[name]
    lobe = polar(np.concatenate([alpha * np.linspace(0, 4, 9), [0.5, 1.2]]), PHI)
    for size, m in ((2 * MU_MIN, polar([0.0], PHI)), (1e-6, lobe), (1.0, lobe), (1.9, lobe)):
        h = (size * m).astype(np.float32)
        unit = h / np.linalg.norm(h.astype(float), axis=-1)[:, None]
        exact = numbers(of_unit(vector(unit), Float64(alpha)))
        double = numbers(along(vector(h), Float64(alpha)))
        np.testing.assert_allclose(double, exact, rtol=DOUBLE_DIVIDED)
        single = numbers(along(vector(h, Float), Float(alpha)))
        tail = np.maximum(exact, 1e-6 * exact.max())
        assert np.max(np.abs(single - exact) / tail) < SINGLE_PROMISED


def test_exponent_and_width_of_blinn_phong_convert_both_ways() -> None:
    for alpha in (1e-3, 0.2, 1.0):
        n = distribution.blinn_phong_exponent(alpha)
        assert float(distribution.blinn_phong_alpha(n)) == pytest.approx(alpha)


def test_logarithm_and_exponential_near_zero_keep_their_digits() -> None:
    x = np.concatenate([-(10.0 ** np.linspace(-12, -0.01, 500)), 10.0 ** np.linspace(-12, 6, 500)])
    for T, dtype, rtol in ((Float, np.float32, SINGLE), (Float64, np.float64, A_HUNDRED_ROUNDINGS)):
        xs = x.astype(dtype)
        np.testing.assert_allclose(
            numbers(special.log1p(T(xs))), np.log1p(xs.astype(float)), rtol=rtol
        )
        xs = xs[np.abs(xs) < 50]
        np.testing.assert_allclose(
            numbers(special.expm1(T(xs))), np.expm1(xs.astype(float)), rtol=rtol
        )


@pytest.mark.parametrize("alpha", [1e-3, 0.02, 0.1, 0.5])
def test_narrow_gtr1_is_burleys_equation_and_keeps_its_digits(alpha: float) -> None:
    """Eq. 4 as it is printed, whose own cancellation near the normal is 1e-16 / alpha^2."""
    angle = np.concatenate([alpha * np.linspace(0, 5, 40), np.linspace(0, 1.57, 40)])
    m = polar(angle, PHI)
    a2, z2 = alpha * alpha, m[:, 2] ** 2
    printed = (a2 - 1) / (math.pi * math.log(a2) * (1 + (a2 - 1) * z2))
    found = numbers(distribution.GTR1(Float64(alpha)).D_narrow(vector(m)))
    np.testing.assert_allclose(found, printed, rtol=DOUBLE_DIVIDED)
    single = m.astype(np.float32).astype(np.float64)
    width = float(np.float32(alpha))
    np.testing.assert_allclose(
        numbers(distribution.GTR1(Float(width)).D_narrow(vector(single, Float))),
        numbers(distribution.GTR1(Float64(width)).D_narrow(vector(single))),
        rtol=SINGLE,
    )
