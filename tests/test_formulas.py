"""docs/formulas.md: what it names exists, and the errata that no other test proves."""

from __future__ import annotations

import ast
import importlib
import math
import re
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support import integrate
from support.directions import Array, polar
from support.tolerances import (
    DOUBLE,
    DOUBLE_DIVIDED,
    MISTAKE,
    SINGLE,
    SINGLE_PROMISED,
    decimals,
)

import gonio
from gonio.arrays.elementwise import elementwise
from gonio.description import citations
from gonio.models.eon import loss_exact, loss_fitted
from gonio.parts import distribution, tilt
from gonio.parts.cltc import coefficients

ROOT = Path(__file__).parent.parent
PAGE = (ROOT / "docs" / "formulas.md").read_text(encoding="utf-8")

# The errata state two digits and a half.
TWO_DIGITS = 0.01

# The model's own arithmetic in single precision, near 1.
TWO_ROUNDINGS = 2e-7

# Half a width from the normal, two bells that agree to second order.
NEAR_THE_NORMAL = 0.01

# A flake that is lit from the other side changes by more than this.
HALF = 0.5

C1 = 0.5 - 2 / (3 * math.pi)  # 1 / A_F = 1 + C1 r


# --- the page --------------------------------------------------------------------------------------


@cache
def functions_of(file: str) -> set[str]:
    tree = ast.parse((ROOT / file).read_text(encoding="utf-8"))
    return {node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)}


def missing_proofs(page: str) -> list[str]:
    proofs = re.findall(r"(tests/\w+\.py)::(\w+)", page)
    return [f"{f}::{t}" for f, t in proofs if not (ROOT / f).is_file() or t not in functions_of(f)]


def missing_names(page: str) -> list[str]:
    """Names of gonio on the page that lead nowhere."""

    def exists(name: str) -> bool:
        module, _, attribute = name.rpartition(".")
        try:
            return hasattr(importlib.import_module(module), attribute)
        except ModuleNotFoundError:
            return False

    return [name for name in re.findall(r"\bgonio(?:\.\w+)+", page) if not exists(name)]


def test_every_proof_that_the_page_names_is_there() -> None:
    assert len(re.findall(r"tests/\w+\.py::", PAGE)) > 25
    assert missing_proofs(PAGE) == []
    assert missing_proofs("tests/test_formulas.py::test_that_was_renamed")
    assert missing_proofs("tests/test_gone.py::test_it")


def errata(page: str) -> dict[str, str]:
    """The text of each erratum by its number."""
    _, _, rest = page.partition("## Errata")
    pieces = re.split(r"^- \*\*([A-Z]\d+)\*\*", rest, flags=re.MULTILINE)
    return dict(zip(pieces[1::2], pieces[2::2], strict=True))


def test_every_erratum_has_a_number_and_a_proof() -> None:
    found = errata(PAGE)
    assert len(found) > 25
    assert len(found) == PAGE.count("*Printed:*") == PAGE.count("*Right:*")
    assert [number for number, text in found.items() if "::test_" not in text] == []
    numbers = {letter: [int(n[1:]) for n in found if n[0] == letter] for letter in "ETPK"}
    assert all(own == list(range(1, len(own) + 1)) for own in numbers.values())
    assert sum(map(len, numbers.values())) == len(found)


def test_every_name_and_file_on_the_page_exists() -> None:
    assert missing_names(PAGE) == []
    assert missing_names("`gonio.parts.fresnel.F_gone` and `gonio.Gone`") == [
        "gonio.parts.fresnel.F_gone",
        "gonio.Gone",
    ]
    for link in re.findall(r"\]\(([^)]+)\)", PAGE):
        assert (ROOT / "docs" / link).exists(), link
    for file in re.findall(r"`(tests/[\w.]+)`", PAGE):
        assert (ROOT / file).exists(), file


def test_every_publication_on_the_page_is_in_the_bibliography() -> None:
    keys = re.findall(r"\[([a-z]+\d{4}|brdfexplorer)\]", PAGE)
    assert len(keys) > 40
    assert set(keys) <= set(citations.bibliography())


def test_every_long_constant_on_the_page_stands_in_the_code() -> None:
    code = "".join(p.read_text(encoding="utf-8") for p in (ROOT / "gonio").rglob("*.py"))
    constants = re.findall(r"(?<![\w.])\d+\.\d{5,}", PAGE.partition("## Errata")[0])
    assert len(constants) > 20
    # the last coefficients of d are computed in 1 - mu, where others stand for them
    rewritten = {"0.540852", "1.01625"}
    assert {c for c in constants if c not in code} <= rewritten | {"0.09178", "0.59635", "1.00001"}


# --- EON -------------------------------------------------------------------------------------------


def printed_E(mu: Any, r: Any) -> Any:
    """E_FON_exact of Listing 1, in the precision of mu."""
    number = type(mu)
    s = np.sqrt(number(1) - mu * mu)
    with np.errstate(divide="ignore", invalid="ignore"):
        G = s * (np.arccos(mu) - s * mu)
        G += number(2 / 3) * (s / mu * (number(1) - s * s * s) - s)
    A = number(1) / (number(1) + number(C1) * r)
    return A + r * A / number(math.pi) * G


def test_the_listing_of_e_fon_loses_its_digits_at_grazing_angles() -> None:
    one = np.float32(1)
    assert np.isnan(printed_E(np.float32(0), one))
    mu = np.float32(1e-4)
    exact = float(printed_E(np.longdouble(mu), np.longdouble(1)))
    assert abs(float(printed_E(mu, one)) - exact) > 1.5 * SINGLE_PROMISED
    wo = np.array([math.sqrt(1 - float(mu) ** 2), 0, mu], np.float32)
    found = gonio.model("fon", rho=1, roughness=1).albedo(wo)
    assert found.dtype == np.float32
    assert float(found[0]) == pytest.approx(exact, abs=TWO_ROUNDINGS)


def test_the_fit_of_e_fon_exceeds_one_near_the_horizon() -> None:
    """1 - E_F = r A_F loss / pi; largest for r = 1."""
    mu = np.geomspace(1e-5, 1, 4000)
    exact, fitted = elementwise(loss_exact, mu), elementwise(loss_fitted, mu)
    A_F = 1 / (1 + C1)
    error = A_F * np.abs(fitted - exact) / np.pi
    assert error.max() < 1e-3  # "less than 0.1 %"
    assert error.max() > 0.2e-3  # and not far less
    assert mu[fitted < 0].max() == pytest.approx(0.0014, abs=decimals(4))


def test_the_listing_of_the_clipped_lobe_leaves_the_hemisphere_at_the_normal() -> None:
    """Listing 3 clips the side -x of the disk, which is right where d is negative."""

    def lowest(mu: float, sign: float) -> float:
        d = float(coefficients(mu, 1 - mu, 1.0)[3])
        R, phi = np.sqrt(1 - 2.0**-24), np.linspace(0, 2 * np.pi, 2001)
        y = R * np.sin(phi)
        keep = 0.5 * (1 + 1 / math.sqrt(1 + d * d))
        x = sign * ((1 - keep) * np.sqrt(1 - y * y) + keep * R * np.cos(phi))
        z = d * x + np.sqrt(np.maximum(1 - x * x - y * y, 0))
        return float(z.min())

    d = {mu: float(coefficients(mu, 1 - mu, 1.0)[3]) for mu in (0.9, 0.9999, 0.99992, 1.0)}
    assert d[0.9] < 0
    assert d[0.9999] < 0 < d[0.99992]
    assert lowest(0.9, -1) >= -DOUBLE
    assert lowest(1.0, -1) < -MISTAKE
    assert lowest(1.0, +1) >= -DOUBLE
    u = np.stack(np.meshgrid(np.linspace(0, 1 - 2**-24, 65), np.linspace(0, 1 - 2**-24, 65)), -1)
    up = np.broadcast_to([0.0, 0.0, 1.0], (65 * 65, 3))
    wi, pdf = gonio.model("eon", roughness=1, sampler="cltc").sample(up, u.reshape(-1, 2))
    assert (wi[:, 2] > 0).all()
    assert (pdf > 0).all()


def variance(sampler: str, roughness: float, theta: float) -> float:
    wo, model = polar(theta), gonio.model("eon", rho=1, roughness=roughness, sampler=sampler)
    wi, rule = integrate.hemisphere_rule(theta)
    return float(np.sum((model.eval(wi, wo)[:, 0] * wi[:, 2]) ** 2 / model.pdf(wi, wo) * rule)) - 1


def test_smooth_eon_is_sampled_better_by_cosines() -> None:
    theta = math.radians(89)
    for roughness, cosine_wins in ((0.03, True), (0.055, True), (0.065, False), (0.2, False)):
        difference = variance("cosine", roughness, theta) - variance(
            "cltc_uniform", roughness, theta
        )
        assert (difference < 0) == cosine_wins, roughness


def test_a_smooth_surface_is_sampled_for_every_random_number() -> None:
    """Listing 4 divides u1 = 0 by P_u = 0 at r = 0."""
    model = gonio.model("eon", roughness=0)
    wi, pdf = model.sample(polar(0.5), np.array([[0.0, 0.3], [0.0, 0.0], [0.5, 0.5]]))
    assert np.isfinite(wi).all()
    np.testing.assert_allclose(pdf, wi[:, 2] / np.pi, rtol=DOUBLE)


# --- tri-Ace ---------------------------------------------------------------------------------------


def test_equation_24_is_negative_without_bound() -> None:
    model = gonio.model("triace_oren_nayar", rho=1, shininess=10, variant="eq24")
    for mu, known in ((1e-3, -98), (1e-4, -984)):
        theta = math.acos(mu)
        f = model.eval(polar(theta), polar(theta, math.pi))
        assert f[0] == pytest.approx(known, rel=TWO_DIGITS)


def test_equation_25_gains_energy_for_smooth_surfaces_only() -> None:
    """Footnote 1 has it the other way round: it reads the integral in the plane of the viewer."""
    sigma = np.linspace(0.02, 1, 981)
    model = gonio.model("triace_oren_nayar", rho=1, shininess=2 / sigma**2)
    grazing = model.albedo(np.array([1.0, 0.0, 0.0]))[:, 0]
    assert grazing.max() == pytest.approx(1.0109, abs=decimals(4))
    assert sigma[grazing > 1].max() == pytest.approx(0.325, abs=2 * decimals(3))
    n = 2 / sigma**2
    in_plane = 1 - 1 / (2 + 0.65 * n) + 1 / (2.22222 + 0.1 * n)
    assert in_plane[-1] == pytest.approx(
        1.11, abs=decimals(2)
    )  # what the footnote sees at sigma = 1
    assert (in_plane > 1).all()


# --- PBR theory ------------------------------------------------------------------------------------


def test_blinn_phong_matches_beckmann_with_twice_the_exponent_printed() -> None:
    alpha, theta = 0.1, 0.05
    beckmann = math.exp(-((math.tan(theta) / alpha) ** 2)) / math.cos(theta) ** 4
    right = math.cos(theta) ** (2 / alpha**2 - 2)
    printed = math.cos(theta) ** (1 / alpha**2 - 2)
    assert right == pytest.approx(beckmann, rel=NEAR_THE_NORMAL)
    assert printed > 1.1 * beckmann
    assert float(distribution.blinn_phong_exponent(alpha)) == pytest.approx(198)


def test_the_tail_of_ggx_is_away_from_the_normal() -> None:
    theta = np.radians([20.0, 40.0, 60.0])
    sine, cosine = np.sin(theta), np.cos(theta)

    def values(D: Any) -> Array:
        return elementwise(
            lambda x, z: D(type("Vec", (), {"x": x, "y": 0 * x, "z": z})(), 0.3), sine, cosine
        )

    ggx = 0.09 / (np.pi * (cosine**2 * (0.09 - 1) + 1) ** 2)
    ratio = ggx / values(lambda m, alpha: distribution.RoundBeckmann(alpha).D(m))
    assert (np.diff(ratio) > 0).all()  # grows as N.H falls
    assert ratio[0] < 1 < ratio[-1]


def test_the_product_of_two_maskings_is_not_the_joint_one() -> None:
    wi, wo = polar(np.radians([10.0, 50.0, 80.0])), polar(np.radians([30.0, 60.0, 75.0]), 2.0)
    white = {"alpha": 0.6, "fresnel": "white"}
    product = gonio.model("torrance_sparrow", masking="smith", **white).eval(wi, wo)
    joint = gonio.model("torrance_sparrow", **white).eval(wi, wo)
    assert (joint > product).all()
    assert joint[2, 0] > 1.3 * product[2, 0]  # both at grazing angles


# --- Elek ------------------------------------------------------------------------------------------


def appendix_b(wi: Array, wo: Array, n: float, k: float, m: float) -> tuple[Array, Array]:
    """What the shader of Appendix B returns, and Eq. 1 with the same F, D and G."""
    h = (wi + wo) / np.linalg.norm(wi + wo, axis=-1, keepdims=True)
    l, v, nh, vh = wi[:, 2], wo[:, 2], h[:, 2], np.sum(wo * h, -1)  # noqa: E741
    tan = np.sqrt(1 - nh * nh) / nh
    D = np.exp(-((tan / m) ** 2)) / (m * m * nh**4)
    F = ((n - 1) ** 2 + 4 * n * (1 - vh) ** 5 + k * k) / ((n + 1) ** 2 + k * k)
    G = np.minimum(1, np.minimum(2 * nh * v / vh, 2 * nh * l / vh))
    return F * D * G / (4 * v), F * D * G / (np.pi * l * v)


def test_the_code_of_appendix_b_is_pi_f_cos_and_equation_1_is_four_times_f() -> None:
    wi = polar(np.radians([10.0, 40.0, 70.0]), 0.3)
    wo = polar(np.radians([20.0, 30.0, 60.0]), 2.8)
    model = gonio.model(
        "torrance_sparrow", alpha=0.4, eta=1.5, k=2.0, distribution="beckmann",
        masking="cook_torrance", fresnel="lazanyi",
    )  # fmt: skip
    f = model.eval(wi, wo)[:, 0]
    code, equation = appendix_b(wi, wo, 1.5, 2.0, 0.4)
    np.testing.assert_allclose(code, np.pi * f * wi[:, 2], rtol=DOUBLE_DIVIDED)
    np.testing.assert_allclose(equation, 4 * f, rtol=DOUBLE_DIVIDED)


def hlsl_refract(i: Array, n: Array, eta: float) -> Array:
    """The shading languages' built-in: i travels towards the surface."""
    cos = float(np.dot(n, i))
    return eta * i - (eta * cos + math.sqrt(1 - eta * eta * (1 - cos * cos))) * n


def test_a_coat_as_printed_mirrors_what_is_below() -> None:
    up, n = np.array([0.0, 0.0, 1.0]), 1.5
    wi, wo = polar(0.6, 0.4), polar(0.3, 1.0)
    # Algorithm 1 gives refract() directions that leave the surface, on the side of the normal
    printed = [-hlsl_refract(w, up, 1 / n) for w in (wi, wo)]
    right = [
        np.array([w[0] / n, w[1] / n, math.sqrt(1 - (w[0] ** 2 + w[1] ** 2) / n**2)])
        for w in (wi, wo)
    ]
    for p, r in zip(printed, right, strict=True):
        np.testing.assert_allclose(p * [-1, -1, 1], r, rtol=DOUBLE)
    metal = gonio.model("torrance_sparrow", alpha=0.2, anisotropy=0.8)
    np.testing.assert_allclose(metal.eval(*printed), metal.eval(*right), rtol=DOUBLE_DIVIDED)
    flake = gonio.model("car_paint", flake_x=0.5, eta=1.0, metal_alpha=0.2)
    mirrored = [w * [-1, -1, 1] for w in (wi, wo)]
    assert flake.eval(*mirrored)[0] != pytest.approx(flake.eval(wi, wo)[0], rel=HALF)


def test_the_refracted_cosine_brightens_the_lower_highlight() -> None:
    for degrees, known in ((60, 1.63), (89, 42.7)):
        mu = math.cos(math.radians(degrees))
        inside = math.sqrt(1 - (1 - mu * mu) / 1.5**2)
        assert inside / mu == pytest.approx(known, rel=TWO_DIGITS)


def test_what_a_coat_as_printed_reflects_of_white_light() -> None:
    """With the mirror reflection of 4 % that a smooth coat has."""
    white = {"interface": "smooth", "eta": 1.5, "base": "lambert", "base.rho": 1}
    both = {"transmission": "both_ways"}
    compressed = both | {"solid_angle": "compressed"}
    for options, known in (
        ({}, 0.959),
        (both, 0.912),
        (compressed, 0.4275),
        (compressed | {"bounces": "diffuse"}, 1),
    ):
        coat = gonio.model("weidlich_wilkie", **white, **options)
        assert 0.04 + integrate.albedo(coat.eval, 0.0)[0] == pytest.approx(known, abs=decimals(3))


def test_the_printed_flake_tilts_less_than_the_described_one() -> None:
    flake = np.array([0.5, 0, math.sqrt(0.75)])  # 30 degrees
    up = np.array([0, 0, 1.0])
    printed, described = up + (up + flake), up + flake
    for normal, known in ((printed, 9.9), (described, 15.0)):
        assert math.degrees(math.atan2(normal[0], normal[2])) == pytest.approx(
            known, abs=decimals(1)
        )
    slope = math.tan(math.radians(30))
    found = [
        float(elementwise(lambda s, a=a: getattr(tilt.flake_normal(s, 0 * s, 1 + 0 * s), a), slope))
        for a in "xz"
    ]  # type: ignore[misc]
    assert math.degrees(math.atan2(*found)) == pytest.approx(15, abs=SINGLE)
