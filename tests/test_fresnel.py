"""Fresnel reflectance against complex arithmetic, published values, and its own limits."""

from __future__ import annotations

import importlib
import inspect
import math
import pkgutil
from typing import Any

import drjit as dr
import numpy as np
import pytest
from support.tolerances import DOUBLE, SINGLE, SINGLE_PROMISED, decimals

import gonio.mitsuba  # noqa: F401  before Mitsuba, so that a usable LLVM is found
from gonio import lang, parts
from gonio.export.stand_ins import VALUE
from gonio.parts import fresnel, metals

Float, Float64 = dr.llvm.ad.Float, dr.llvm.ad.Float64
Array3f64 = dr.llvm.ad.Array3f64


def numbers(value: Any) -> Any:
    return np.array(value).astype(np.float64)


def complex_fresnel(c: Any, index: Any) -> Any:
    """Unpolarised reflectance from Snell's law in complex numbers, as textbooks have it."""
    index = np.asarray(index, complex)
    sine = np.sqrt(1 - np.asarray(c) ** 2 + 0j) / index
    cos_t = np.sqrt(1 - sine**2)
    # the root whose wave decays
    cos_t = np.where((index * cos_t).imag < 0, -cos_t, cos_t)
    r_s = (c - index * cos_t) / (c + index * cos_t)
    r_p = (index * c - cos_t) / (index * c + cos_t)
    return (abs(r_s) ** 2 + abs(r_p) ** 2) / 2


# The root of F0 and back; ROOT_MIN keeps F0 = 0 this far from it. At eta = 1.0001 F0 is 2.5e-9.
ROOT, ROOT_OF_LITTLE = 1e-9, 1e-6

# A polynomial in double precision.
A_HUNDRED_ROUNDINGS = 1e-14

# COSINES begin at 0.0005, where Schlick's curve has fallen by five times that from F90.
FIRST_COSINE = 2e-3

# Mitsuba converts spectra to colours in single precision, in sums over hundreds of wavelengths.
MITSUBA_COLOUR = 1e-4

# Artists' collections are rounded and made with other colours; chromium depends on who measured it.
BY_ARTISTS, CHROMIUM = 0.1, 0.17

# Not 0, where a matched index has no definite answer
COSINES = np.linspace(0.0005, 1, 501)


def conductor_error(F: Any) -> float:
    worst = 0.0
    for eta in (0.01, 0.05, 0.2, 0.999, 1.0, 1.5, 3.0, 20.0):
        for k in (0.0, 1e-3, 0.5, 3.9, 20.0):
            found = numbers(F(Float64(COSINES), Float64(eta), Float64(k)))
            worst = max(
                worst, float(np.max(np.abs(found - complex_fresnel(COSINES, eta + 1j * k))))
            )
    return worst


# 1e-16 under a square root, where total internal reflection begins
EXACT = 1e-7


def test_conductor_is_complex_fresnel() -> None:
    assert conductor_error(fresnel.F_conductor) < EXACT


def test_the_conductor_that_leaves_out_small_terms_is_caught() -> None:
    """The widespread approximation (eta^2 + k^2) c^2 - 2 eta c + 1 ... is off by percents."""

    def approximate(c: Any, eta: Any, k: Any) -> Any:
        e = eta * eta + k * k
        p = (e * c * c - 2 * eta * c + 1) / (e * c * c + 2 * eta * c + 1)
        s = (e - 2 * eta * c + c * c) / (e + 2 * eta * c + c * c)
        return 0.5 * (p + s)

    assert conductor_error(approximate) > 0.01


def test_dielectric_is_complex_fresnel_with_total_internal_reflection() -> None:
    for eta in (0.4, 1 / 1.5, 0.99, 1.0, 1.000001, 1.33, 1.5, 2.4, 20.0):
        found = numbers(fresnel.F_dielectric(Float64(COSINES), Float64(eta)))
        np.testing.assert_allclose(found, complex_fresnel(COSINES, eta), atol=EXACT)
        if eta < 1:
            critical = math.sqrt(1 - eta * eta)
            assert (found[critical > COSINES] == 1).all()
            assert (found[critical + 1e-3 < COSINES] < 1).all()


def test_dielectric_is_a_conductor_without_extinction() -> None:
    for eta in (0.5, 1.0, 1.5):
        c = Float64(COSINES)
        np.testing.assert_allclose(
            numbers(fresnel.F_conductor(c, Float64(eta), Float64(0))),
            numbers(fresnel.F_dielectric(c, Float64(eta))),
            atol=EXACT,
        )


def test_published_values() -> None:
    glass = 1.5
    assert float(fresnel.F_dielectric(1.0, glass)) == pytest.approx(0.04)
    assert float(fresnel.F_dielectric(0.0, glass)) == pytest.approx(1)
    assert float(fresnel.f0_from_eta(1.33)) == pytest.approx(0.02, abs=2 * decimals(4))
    assert float(fresnel.f0_from_eta(2.42)) == pytest.approx(0.172, abs=2 * decimals(3))  # diamond
    # At Brewster's angle nothing of the parallel part is left, and F is half of the other
    c = 1 / math.sqrt(1 + glass**2)
    r_s = (glass**2 - 1) / (glass**2 + 1)
    assert float(fresnel.F_dielectric(c, glass)) == pytest.approx(r_s**2 / 2, rel=DOUBLE)
    # Diffuse reflectance of glass, 0.0918 from outside and 0.5963 from inside
    mu, w = np.polynomial.legendre.leggauss(4000)
    mu, w = (mu + 1) / 2, w / 2
    outside = np.sum(2 * mu * w * numbers(fresnel.F_dielectric(Float64(mu), Float64(1.5))))
    inside = np.sum(2 * mu * w * numbers(fresnel.F_dielectric(Float64(mu), Float64(1 / 1.5))))
    assert outside == pytest.approx(0.09178, abs=2 * decimals(5))
    assert inside == pytest.approx(0.59635, abs=4 * decimals(5))


def test_index_and_reflectance_convert_both_ways() -> None:
    f0 = np.array([0.0, 1e-6, 0.04, 0.5, 0.99])
    np.testing.assert_allclose(
        fresnel.f0_from_eta(numbers(fresnel.eta_from_f0(Float64(f0)))), f0, atol=ROOT
    )
    eta = np.array([1.0001, 1.5, 4.0])
    np.testing.assert_allclose(
        numbers(fresnel.eta_from_f0(Float64(fresnel.f0_from_eta(eta)))), eta, rtol=ROOT_OF_LITTLE
    )
    assert fresnel.f0_from_conductor(1.5, 0.0) == pytest.approx(0.04)


def test_schlick_goes_from_f0_to_f90() -> None:
    c = Float64(COSINES)
    found = numbers(fresnel.F_schlick(c, Float64(0.2), Float64(0.7)))
    np.testing.assert_allclose(found, 0.2 + 0.5 * (1 - COSINES) ** 5, rtol=A_HUNDRED_ROUNDINGS)
    assert found[0] == pytest.approx(0.7, abs=FIRST_COSINE)
    assert found[-1] == pytest.approx(0.2)


def test_lazanyi_is_good_for_coloured_metals_only() -> None:
    """Elek quotes an error of 5 %; it is measured here, at normal and over all incidences."""
    for symbol, known in {"Ag": 0.02, "Au": 0.03, "Cu": 0.03, "Al": 0.13, "Cr": 0.27}.items():
        index = metals.metal(symbol)
        worst = 0.0
        for eta, k in zip(index["eta"], index["k"], strict=True):
            found = numbers(fresnel.F_lazanyi(Float64(COSINES), Float64(eta), Float64(k)))
            assert found[-1] == pytest.approx(fresnel.f0_from_conductor(eta, k), rel=DOUBLE)
            worst = max(
                worst, float(np.max(np.abs(found - complex_fresnel(COSINES, eta + 1j * k))))
            )
        assert worst == pytest.approx(known, abs=1.2 * decimals(2))


@pytest.mark.parametrize("T", [Float, Float64])
def test_gradients_are_finite_everywhere(T: Any) -> None:
    """Grazing, normal, matched indices, and exactly where total internal reflection sets in."""
    dtype = np.float32 if T is Float else np.float64
    cosines = np.array([0.0, 1e-9, 1e-4, 0.5, 0.6, 0.8, 1 - 1e-7, 1.0])
    c, eta, k = (
        a.ravel().astype(dtype)
        for a in np.meshgrid(cosines, [0.01, 0.6, 0.8, 1.0, 1.5, 20.0], [0.0, 1e-6, 1.0, 20.0])
    )
    for name, arguments in {
        "F_dielectric": (c, eta),
        "F_conductor": (c, eta, k),
        "F_lazanyi": (c, eta, k),
        "F_schlick": (c, np.minimum(eta, 1), np.minimum(k, 1)),
        "f0_from_eta": (eta,),
        "f0_from_conductor": (eta, k),
        "eta_from_f0": (np.minimum(k, 1),),
    }.items():
        leaves = [T(np.ascontiguousarray(a)) for a in arguments]
        dr.enable_grad(*leaves)
        value = getattr(fresnel, name)(*leaves)
        dr.backward(dr.sum(value), flags=dr.ADFlag.Default | dr.ADFlag.AllowNoGrad)
        if name != "eta_from_f0":
            assert (numbers(value) >= 0).all()
            assert (numbers(value) <= 1 + 1e-6).all()
        for leaf in leaves:
            assert np.isfinite(numbers(dr.grad(leaf))).all(), name


def test_float32_keeps_its_digits() -> None:
    """At a matched index, in the horizon and near the normal, where differences of ones appear."""
    rng = np.random.default_rng(1)
    c = np.concatenate(
        [rng.random(5000), 10 ** -rng.uniform(0, 7, 5000), 1 - 10 ** -rng.uniform(0, 7, 5000)]
    )
    eta = np.concatenate([1 + 10 ** -rng.uniform(0, 6, 7500), rng.uniform(1, 20, 7500)])
    k = np.where(rng.random(15000) < 0.3, 0, rng.uniform(0, 20, 15000))
    c, eta, k = (a.astype(np.float32) for a in (c, eta, k))
    d = [Float64(a.astype(np.float64)) for a in (c, eta, k)]
    s = [Float(a) for a in (c, eta, k)]
    for single, double in (
        (fresnel.F_dielectric(*s[:2]), fresnel.F_dielectric(*d[:2])),
        (fresnel.F_conductor(*s), fresnel.F_conductor(*d)),
        (fresnel.F_lazanyi(*s), fresnel.F_lazanyi(*d)),
    ):
        np.testing.assert_allclose(numbers(single), numbers(double), rtol=SINGLE_PROMISED)


def test_a_small_index_keeps_its_digits_at_a_facet_near_its_critical_angle() -> None:
    """Metals inside a coat: of eta^2 - 1 + c^2 nothing is left there, of eta^2 - sin^2 all."""
    rng = np.random.default_rng(2)
    eta = rng.uniform(0.003, 0.1, 4000)
    sin2 = eta**2 * (1 - 10 ** -rng.uniform(0.5, 3, 4000))  # below the critical angle
    k = np.where(rng.random(4000) < 0.5, 0, rng.uniform(0, 1e-3, 4000))
    c, s, eta, k = (a.astype(np.float32) for a in (np.sqrt(1 - sin2), sin2, eta, k))
    expected = complex_fresnel(np.sqrt(1 - s.astype(float)), eta + 1j * k.astype(float))
    single = [Float(a) for a in (c, s, eta, k)]
    # A float32 eta near the critical angle, which leaves a thousandth of eta^2
    sharp = 1e3 * SINGLE
    found = numbers(fresnel.F_conductor_half(*single))
    np.testing.assert_allclose(found, expected, rtol=sharp)
    assert np.max(np.abs(numbers(fresnel.F_conductor(Float(c), *single[2:])) - expected)) > 0.01
    found = numbers(fresnel.F_dielectric_half(*single[:3]))
    np.testing.assert_allclose(
        found, complex_fresnel(np.sqrt(1 - s.astype(float)), eta), rtol=sharp
    )


# --- metals ----------------------------------------------------------------------------------------


def test_metals_are_what_mitsuba_uses() -> None:
    import mitsuba as mi

    before = mi.variant()
    mi.set_variant("scalar_rgb")
    try:
        for symbol, (_, file) in metals.MITSUBA.items():
            bsdf = mi.load_dict({"type": "roughconductor", "material": file})
            parameters = mi.traverse(bsdf)
            for part, value in metals.metal(symbol).items():
                np.testing.assert_allclose(
                    np.array(parameters[f"{part}.value"]), value, rtol=MITSUBA_COLOUR, atol=SINGLE
                )
    finally:
        mi.set_variant(before or "scalar_rgb")


def test_well_known_reflectances() -> None:
    """F0 of metals in linear RGB as collected for artists (Hoffman, Filament), within 0.1."""
    known = {
        "Ag": (0.97, 0.96, 0.91),
        "Al": (0.91, 0.92, 0.92),
        "Au": (1.00, 0.77, 0.34),
        "Cu": (0.95, 0.64, 0.54),
        "Cr": (0.55, 0.56, 0.55),
        "Fe": (0.56, 0.57, 0.58),
        "Ni": (0.66, 0.61, 0.53),
        "Ti": (0.54, 0.50, 0.45),
        "W": (0.50, 0.50, 0.48),
    }
    for symbol, expected in known.items():
        index = metals.metal(symbol, neutral=True)
        F0 = [
            fresnel.f0_from_conductor(e, k) for e, k in zip(index["eta"], index["k"], strict=True)
        ]
        # Chromium and iron depend on who measured them
        np.testing.assert_allclose(F0, expected, atol=CHROMIUM if symbol == "Cr" else BY_ARTISTS)


def test_every_metal_has_spectra_that_mitsuba_loads() -> None:
    import mitsuba as mi

    assert {"Al", "Ag", "Au", "Cu", "Cr", "Fe", "Ni", "Ti", "W", "Cu2O"} <= set(metals.metals())
    before = mi.variant()
    mi.set_variant("scalar_spectral")
    try:
        for symbol in metals.metals():
            mi.load_dict({"type": "roughconductor", **metals.spectra(symbol)})
    finally:
        mi.set_variant(before or "scalar_rgb")


def test_an_unknown_metal_names_the_nearest() -> None:
    with pytest.raises(ValueError, match="did you mean 'Au'"):
        metals.metal("au")
    with pytest.raises(ValueError, match="did you mean 'Au'"):
        metals.metal("Gold")
    with pytest.raises(ValueError, match="known are Ag, Al"):
        metals.metal("xyz123")


def twins() -> list[tuple[Any, Any]]:
    """Functions of gonio.parts, and those that exports call in their place."""
    found = []
    for module in pkgutil.iter_modules(parts.__path__, f"{parts.__name__}."):
        names = vars(importlib.import_module(module.name))
        found += [
            (names[name.removesuffix(VALUE)], function)
            for name, function in names.items()
            if name.endswith(VALUE) and inspect.isfunction(function)
        ]
    return found


def test_what_exports_call_has_the_value_of_what_they_call_it_for() -> None:
    rng = np.random.default_rng(3)
    assert twins()
    for function, twin in twins():
        assert inspect.signature(function) == inspect.signature(twin)
        kinds = [p.annotation for p in inspect.signature(twin).parameters.values()]
        # Both are made for numbers of at least a trace of absorption, and up to 1e7; or for directions
        sizes = [(3, 1000) if kind in (lang.Vec3, "Vec3") else 1000 for kind in kinds]
        drawn = [10.0 ** rng.uniform(-16, 7, size) for size in sizes]
        given = [Array3f64(x) if x.ndim == 2 else Float64(x) for x in drawn]
        np.testing.assert_allclose(numbers(twin(*given)), numbers(function(*given)), rtol=DOUBLE)
