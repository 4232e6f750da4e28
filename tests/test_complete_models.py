"""The complete models against their formulas as one reads them, against each other, and against Mitsuba."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import drjit as dr
import numpy as np
import pytest
from support import integrate
from support.directions import polar, random_directions
from support.tolerances import DOUBLE, MISTAKE, SINGLE, decimals

import gonio
from gonio.albedos.quadrature import NumericAlbedo
from gonio.check.variants import options, random_parameters, sweep
from gonio.lang import Color, Float, Sample, Vec2, Vec3
from gonio.model import Model
from gonio.parts import lobes
from gonio.parts.distribution import RoundGGX, pdf_visible
from gonio.parts.frame import mirror
from gonio.parts.fresnel import schlick_complement

# Away from the horizon and in double precision the formulas as they are printed keep ten digits.
PRINTED = 1e-9

# A term that is off by this is to be noticed.
ONE_IN_A_MILLION = 1e-6

# The rule of gonio.albedos.quadrature around the mirror direction; in the horizon half a lobe is cut off.
MIRROR_RULE, MIRROR_RULE_IN_THE_HORIZON = 1e-6, 2e-5

# Where a lobe has faded to this, its relative error does not matter.
FADED = 1e-9

# 160,000 cells over the hemisphere, for densities without a jump.
GRID = 1e-4

# Albedos of lobes that nobody sees.
UNSEEN = 1e-9

TINTED = (0.9, 0.35, 0.04)


def directions(count: int = 400) -> tuple[Any, Any]:
    wi, wo = (random_directions(4 * count, seed).astype(np.float64) for seed in (31, 32))
    wi, wo = (w / np.linalg.norm(w, axis=1, keepdims=True) for w in (wi, wo))
    good = (wi[:, 2] > 0.05) & (wo[:, 2] > 0.05)
    return wi[good][:count], wo[good][:count]


def angles(wi: Any, wo: Any) -> tuple[Any, ...]:
    """mu_i, mu_o, N.H, wo.H, each (n, 1)."""
    h = wi + wo
    h = h / np.linalg.norm(h, axis=1, keepdims=True)
    return wi[:, 2:], wo[:, 2:], h[:, 2:], np.sum(wo * h, 1, keepdims=True)


def lerp(a: Any, b: Any, t: Any) -> Any:
    return a + (b - a) * t


def ggx(nh: Any, alpha: Any) -> Any:
    return alpha**2 / (np.pi * (nh**2 * (alpha**2 - 1) + 1) ** 2)


def white_albedo(name: str, degrees: float, **parameters: Any) -> Any:
    return gonio.model(name, **parameters).albedo(polar(math.radians(degrees)))


# --- the formulas as they are printed --------------------------------------------------------------


def printed_phong(wi: Any, wo: Any, p: Any) -> Any:
    r = wo * [-1, -1, 1]
    c = np.maximum(np.sum(wi * r, 1, keepdims=True), 0) ** p["shininess"]
    if p.get("form") == "classical":
        return p["rho"] / np.pi + p["specular"] * c / wi[:, 2:]
    return p["rho"] / np.pi + p["specular"] * (p["shininess"] + 2) / (2 * np.pi) * c


def printed_triace(wi: Any, wo: Any, p: Any) -> Any:
    i, o, nh, oh = angles(wi, wo)
    n, f0 = p["shininess"], p["f0"]
    F = f0 + (1 - f0) * (1 - oh) ** 5
    return p["rho"] / np.pi * (1 - f0) + (0.0397436 * n + 0.0856832) * F * nh**n / np.maximum(i, o)


def printed_metallic_roughness(wi: Any, wo: Any, p: Any) -> Any:
    i, o, nh, oh = angles(wi, wo)
    a = p["roughness"] ** 2
    f0 = lerp(0.04, p["base_color"], p["metallic"])
    F = f0 + (1 - f0) * (1 - oh) ** 5
    Li, Lo = ((np.sqrt(1 + a * a * (1 / mu**2 - 1)) - 1) / 2 for mu in (i, o))
    G = 1 / ((1 + Li) * (1 + Lo)) if p.get("masking") == "smith" else 1 / (1 + Li + Lo)
    diffuse = (1 - F) * p["base_color"] * (1 - p["metallic"]) / np.pi
    return diffuse + F * ggx(nh, a) * G / (4 * i * o)


def printed_ue4(wi: Any, wo: Any, p: Any) -> Any:
    i, o, nh, oh = angles(wi, wo)
    a = p["roughness"] ** 2
    k = a / 2 if p.get("light") == "image" else (p["roughness"] + 1) ** 2 / 8
    f0 = lerp(0.08 * p["specular"], p["base_color"], p["metallic"])
    F = f0 + (1 - f0) * (1 - oh) ** 5
    G = i / (i * (1 - k) + k) * o / (o * (1 - k) + k)
    return p["base_color"] * (1 - p["metallic"]) / np.pi + F * ggx(nh, a) * G / (4 * i * o)


def printed_unity_standard(wi: Any, wo: Any, p: Any) -> Any:
    """Unity's own value, divided by pi."""
    i, o, nh, oh = angles(wi, wo)
    r = p["roughness"]
    a = np.maximum(r * r, 0.002)
    spec = lerp(0.04, p["base_color"], p["metallic"])
    diff = p["base_color"] * (1 - p["metallic"]) * (1 - 0.04)
    fd90 = 0.5 + 2 * oh**2 * r
    burley = (1 + (fd90 - 1) * (1 - i) ** 5) * (1 + (fd90 - 1) * (1 - o) ** 5)
    V = 0.5 / (i * (o * (1 - a) + a) + o * (i * (1 - a) + a))
    F = spec + (1 - spec) * (1 - oh) ** 5
    return (diff * burley + np.pi * V * ggx(nh, a) * F) / np.pi


def printed_unity_brdf2(wi: Any, wo: Any, p: Any) -> Any:
    """Unity's own value, divided by pi."""
    _, _, nh, oh = angles(wi, wo)
    a = p["roughness"] ** 2
    spec = lerp(0.04, p["base_color"], p["metallic"])
    diff = p["base_color"] * (1 - p["metallic"]) * (1 - 0.04)
    d = nh**2 * (a**2 - 1) + 1.00001
    term = a**2 / (np.maximum(0.1, oh**2) * (a + 0.5) * d**2 * 4)
    return (diff + term * spec) / np.pi


def printed_disney(wi: Any, wo: Any, p: Any) -> Any:
    """The reference code of 2012, line by line, with linear colours."""
    i, o, nh, oh = angles(wi, wo)
    h = wi + wo
    h = h / np.linalg.norm(h, axis=1, keepdims=True)
    base, r = np.asarray(p["base_color"]), p["roughness"]
    lum = np.sum(base * [0.3, 0.6, 0.1], -1, keepdims=True)
    tint = np.where(lum > 0, base / np.where(lum > 0, lum, 1), 1)
    spec0 = lerp(p["specular"] * 0.08 * lerp(1, tint, p["specular_tint"]), base, p["metallic"])
    FL, FV, FH = (1 - i) ** 5, (1 - o) ** 5, (1 - oh) ** 5
    fd90 = 0.5 + 2 * oh**2 * r
    Fd = lerp(1, fd90, FL) * lerp(1, fd90, FV)
    fss90 = oh**2 * r
    Fss = lerp(1, fss90, FL) * lerp(1, fss90, FV)
    ss = 1.25 * (Fss * (1 / (i + o) - 0.5) + 0.5)
    aspect = np.sqrt(1 - p["anisotropic"] * 0.9)
    ax, ay = np.maximum(0.001, r**2 / aspect), np.maximum(0.001, r**2 * aspect)
    D = 1 / (np.pi * ax * ay * ((h[:, :1] / ax) ** 2 + (h[:, 1:2] / ay) ** 2 + nh**2) ** 2)
    if p.get("masking") == "anisotropic":
        G = 1.0
        for w, mu in ((wi, i), (wo, o)):
            G = G / (mu + np.sqrt((w[:, :1] * ax) ** 2 + (w[:, 1:2] * ay) ** 2 + mu**2))
    else:
        g = (0.5 + r / 2) ** 2
        G = 1 / (i + np.sqrt(g**2 + i**2 - g**2 * i**2)) / (o + np.sqrt(g**2 + o**2 - g**2 * o**2))
    sheen = FH * p["sheen"] * lerp(1, tint, p["sheen_tint"])
    c = lerp(0.1, 0.001, p["clearcoat_gloss"])
    Dr = (c**2 - 1) / (np.pi * np.log(c**2) * (1 + (c**2 - 1) * nh**2))
    g = 0.25
    Gr = 1 / (i + np.sqrt(g**2 + i**2 - g**2 * i**2)) / (o + np.sqrt(g**2 + o**2 - g**2 * o**2))
    coat = 0.25 * p["clearcoat"] * Gr * lerp(0.04, 1, FH) * Dr
    diffuse = lerp(Fd, ss, p["subsurface"]) * base / np.pi + sheen
    return diffuse * (1 - p["metallic"]) + G * lerp(spec0, 1, FH) * D + coat


AsPrinted = Callable[[Any, Any, Any], Any]
AS_PRINTED: dict[str, AsPrinted] = {
    "phong": printed_phong,
    "triace_blinn_phong": printed_triace,
    "metallic_roughness": printed_metallic_roughness,
    "ue4": printed_ue4,
    "unity_standard": printed_unity_standard,
    "unity_brdf2": printed_unity_brdf2,
    "disney": printed_disney,
}
EACH = pytest.mark.parametrize("name", AS_PRINTED)


def printed_error(cls: type[Model], printed: AsPrinted, choice: dict[str, str]) -> float:
    """Largest difference from the printed formula, relative, at random parameters."""
    wi, wo = directions()
    values = random_parameters(cls, len(wi), seed=6)
    values = {k: v.astype(np.float64) for k, v in values.items()}
    # Printed as they are, 1 - x^2 (1 - alpha^2) and the like have no digits left for sharp highlights.
    # And max(0, c)^0 is 1 for c < 0 in print, where the limit of small exponents is 0.
    for key, low in (("roughness", 0.2), ("shininess", 1e-3)):
        if key in values:
            values[key] = np.clip(values[key], low, 200)
    columns = {k: v[:, None] if v.ndim == 1 else v for k, v in values.items()}
    expected = printed(wi, wo, columns | choice)
    found = cls(**values, **choice).eval(wi, wo)
    return float(np.max(np.abs(found - expected) / np.maximum(np.abs(expected), 1e-6)))


@EACH
def test_model_is_the_printed_formula(name: str) -> None:
    cls = gonio.models()[name]
    for choice in options(cls):
        if name == "triace_blinn_phong" and choice:
            continue  # its rough diffuse part has anchors of its own, tests/anchors_specular.csv
        assert printed_error(cls, AS_PRINTED[name], choice) < PRINTED, choice


@EACH
def test_a_model_with_a_term_one_in_a_million_off_is_caught(name: str) -> None:
    cls = gonio.models()[name]

    class Broken(cls, register=False):  # type: ignore[misc, valid-type]
        def eval(self, wi: Vec3, wo: Vec3) -> Color:
            return super().eval(wi, wo) * (1 + ONE_IN_A_MILLION * wi.z * wo.z)

    assert printed_error(Broken, AS_PRINTED[name], {}) > PRINTED


# --- one model in another --------------------------------------------------------------------------


def metals_differ(model: Model, **parameters: Any) -> float:
    """How far a metal is from Torrance-Sparrow with Schlick's Fresnel, relative."""
    wi, wo = directions()
    metal = gonio.model("torrance_sparrow", fresnel="schlick", **parameters)
    found, expected = model.eval(wi, wo), metal.eval(wi, wo)
    return float(np.max(np.abs(found - expected) / expected))


@pytest.mark.parametrize("roughness", [0.1, 0.5, 1.0])
def test_metals_are_torrance_sparrow(roughness: float) -> None:
    metal = {"metallic": 1, "base_color": TINTED, "roughness": roughness}
    same = {"f0": TINTED, "alpha": roughness**2}
    for masking in ("smith", "smith_correlated"):
        model = gonio.model("metallic_roughness", masking=masking, **metal)
        assert metals_differ(model, masking=masking, **same) < DOUBLE
    image = gonio.model("ue4", light="image", **metal)
    assert metals_differ(image, masking="schlick_ggx", **same) < DOUBLE
    for anisotropy in (0.0, 0.7, 1.0):
        model = gonio.model("disney", masking="anisotropic", anisotropic=anisotropy, **metal)
        # Where the reference code's lower limit of 0.001 does not act
        if roughness > 0.1 or anisotropy < 1:
            assert metals_differ(model, masking="smith", anisotropy=anisotropy, **same) < DOUBLE


def test_disney_of_2012_is_torrance_sparrow_but_for_the_width_of_its_masking() -> None:
    wi, wo = directions()
    for roughness in (0.1, 0.5, 1.0):
        metal = {"metallic": 1, "base_color": TINTED, "roughness": roughness}
        ratio = gonio.model("disney", **metal).eval(wi, wo) / gonio.model(
            "disney", masking="anisotropic", **metal
        ).eval(wi, wo)
        G = []
        for alpha in ((0.5 + roughness / 2) ** 2, roughness**2):
            root_i, root_o = (np.sqrt(alpha**2 + (1 - alpha**2) * w[:, 2] ** 2) for w in (wi, wo))
            G.append(1 / ((wi[:, 2] + root_i) * (wo[:, 2] + root_o)))
        np.testing.assert_allclose(ratio, np.repeat((G[0] / G[1])[:, None], 3, 1), rtol=DOUBLE)


def test_disney_diffuse_is_burley_diffuse() -> None:
    wi, wo = directions()
    for roughness in (0.0, 0.4, 1.0):
        black = gonio.model("disney", base_color=0, roughness=roughness)
        diffuse = black.replace(base_color=TINTED).eval(wi, wo) - black.eval(wi, wo)
        expected = gonio.model("burley_diffuse", rho=TINTED, roughness=roughness).eval(wi, wo)
        np.testing.assert_allclose(diffuse, expected, rtol=PRINTED)


def test_a_metal_with_the_wrong_width_is_caught() -> None:
    model = gonio.model("metallic_roughness", metallic=1, base_color=TINTED, roughness=0.5)
    wrong = {"f0": TINTED, "alpha": 0.25 + 1e-9, "masking": "smith_correlated"}
    assert metals_differ(model, **wrong) > DOUBLE


# --- phong -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("shininess", [0.0, 0.5, 1, 20, 1e3, 1e5])
def test_phong_albedo_has_closed_forms(shininess: float) -> None:
    """Normal: the lobe's axis is N, so it is (n+2) times the integral of mu^(n+1). Horizon: Wallis'."""
    E = white_albedo("phong", 0, rho=0.25, specular=0.5, shininess=shininess)
    np.testing.assert_allclose(E, 0.75, rtol=MIRROR_RULE)
    E = white_albedo("phong", 0, rho=0.25, specular=0.5, shininess=shininess, form="classical")
    np.testing.assert_allclose(E, 0.25 + 0.5 * 2 * np.pi / (shininess + 1), rtol=MIRROR_RULE)
    wallis = math.lgamma((shininess + 1) / 2) - math.lgamma(shininess / 2 + 1)
    E = white_albedo("phong", 90, rho=0, specular=1, shininess=shininess)
    np.testing.assert_allclose(
        E, math.exp(wallis) / (2 * math.sqrt(math.pi)), rtol=MIRROR_RULE_IN_THE_HORIZON
    )


def test_phong_with_the_norm_of_its_sampling_is_caught() -> None:
    Phong = gonio.models()["phong"]

    class Broken(Phong, register=False):  # type: ignore[misc, valid-type]
        def eval(self, wi: Vec3, wo: Vec3) -> Color:
            return super().eval(wi, wo) * ((self.shininess + 1) / (self.shininess + 2))

    E = Broken(rho=0, specular=1, shininess=1000).albedo(polar(0.0))
    assert abs(E[0] - 1) > 500 * MIRROR_RULE


def edge_error(cls: type[Model]) -> float:
    """Relative error of float32 where the mirror direction is nearly at a right angle to wi."""
    rng = np.random.default_rng(8)
    wo = random_directions(20000, 41).astype(np.float64)
    side = np.cross(wo * [-1, -1, 1], rng.normal(size=wo.shape))
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    wi = side + 10.0 ** rng.uniform(-6, -2, (len(wo), 1)) * (wo * [-1, -1, 1])
    wi /= np.linalg.norm(wi, axis=1, keepdims=True)
    keep = wi[:, 2] > 0.01
    wi, wo = wi[keep].astype(np.float32), wo[keep].astype(np.float32)
    model = cls(rho=0, specular=1, shininess=1)
    low, high = model.eval(wi, wo), model.eval(wi.astype(np.float64), wo.astype(np.float64))
    lit = high[:, 0] > FADED
    return float(np.max(np.abs(low[lit] - high[lit]) / high[lit]))


def test_phong_keeps_its_digits_where_the_lobe_fades_out() -> None:
    Phong = gonio.models()["phong"]
    assert edge_error(Phong) < 2 * SINGLE

    class Plain(Phong, register=False):  # type: ignore[misc, valid-type]
        def eval(self, wi: Vec3, wo: Vec3) -> Color:
            c = wi.z * wo.z - wi.x * wo.x - wi.y * wo.y
            return self.specular * (3 / (2 * np.pi)) * dr.maximum(c, 0)

    assert edge_error(Plain) > MISTAKE


# --- tri-Ace ---------------------------------------------------------------------------------------


def test_triace_has_the_published_albedos() -> None:
    """At wo = N with F = 1, and the linear fit against the norm that it fits."""
    for n, published in ((1, 0.36), (10, 0.73), (50, 0.93), (100, 0.96)):
        E = white_albedo("triace_blinn_phong", 0, rho=0, f0=1, shininess=n)
        np.testing.assert_allclose(E, published, atol=decimals(2))


def test_triace_norm_fits_as_well_as_is_known() -> None:
    """0.0397436 n + 0.0856832 against (n+2) / (4 pi (2 - 2^(-n/2))): 0.6 % from 10 on, -32 % at 1."""
    n = np.geomspace(1, 1e5, 400)
    normal = polar(0.0)
    linear = gonio.model("triace_blinn_phong", rho=0, f0=1, shininess=n).eval(normal, normal)[:, 0]
    ratio = linear / ((n + 2) / (4 * np.pi * (2 - 2 ** (-n / 2))))
    assert ratio[0] == pytest.approx(1 - 0.32, abs=decimals(2))
    assert ratio[n >= 10].max() == pytest.approx(1.0057, abs=2 * decimals(4))  # at 18
    assert ratio[n >= 10].min() == pytest.approx(0.996, abs=decimals(3))  # at 10


# --- UE4 -------------------------------------------------------------------------------------------


def k_of(model: Model, roughness: float) -> Any:
    """Schlick's k, solved from the value at wi = wo, where f = D / (4 (mu (1 - k) + k)^2) for F = 1."""
    w = polar(np.radians([20.0, 50.0, 70.0]))
    f = model.eval(w, w)[:, 0]
    mu = w[:, 2]
    x = np.sqrt(ggx(mu, roughness**2) / (4 * f))
    return (x - mu) / (1 - mu)


@pytest.mark.parametrize("roughness", [0.2, 0.5, 1.0])
def test_ue4_has_both_k(roughness: float) -> None:
    white = {"base_color": 1, "metallic": 1, "roughness": roughness}
    punctual, image = gonio.model("ue4", **white), gonio.model("ue4", light="image", **white)
    np.testing.assert_allclose(k_of(punctual, roughness), (roughness + 1) ** 2 / 8, rtol=PRINTED)
    np.testing.assert_allclose(k_of(image, roughness), roughness**2 / 2, rtol=PRINTED)
    smith = gonio.model("metallic_roughness", **white)
    assert np.abs(k_of(smith, roughness) - (roughness + 1) ** 2 / 8).max() > MISTAKE


# --- Unity -----------------------------------------------------------------------------------------


def test_unity_has_less_fresnel_and_a_brighter_diffuse() -> None:
    """The article's reading: k_d = 0.96 in place of 1 - F, which F makes at most 0.96."""
    wi, wo = directions(4000)
    _, _, _, oh = angles(wi, wo)
    k_d = 1 - (0.04 + 0.96 * (1 - oh) ** 5)
    ratio = (0.96 / k_d)[:, 0]
    assert ratio.min() >= 1
    # Roughness 0.5 leaves Burley's factors at 1 where F90 = 0.5 + cos^2 (theta_d) is 1.
    color, unity, physical = {}, {}, {}
    for white in (0, 1):
        color = {"base_color": white, "roughness": 0.5}
        unity[white] = gonio.model("unity_standard", **color).eval(wi, wo)[:, 0]
        physical[white] = gonio.model("metallic_roughness", **color).eval(wi, wo)[:, 0]
    found = (unity[1] - unity[0]) / (physical[1] - physical[0])
    f90 = 0.5 + oh[:, 0] ** 2
    factor = np.prod([1 + (f90 - 1) * (1 - w[:, 2]) ** 5 for w in (wi, wo)], axis=0)
    np.testing.assert_allclose(found / factor, ratio, rtol=PRINTED)


def test_unity_deviates_from_metallic_roughness_as_its_caveats_say() -> None:
    for roughness, at_normal, at_80 in ((0, 0.978, 0.889), (1, 1.035, 1.274)):
        for degrees, stated in ((0, at_normal), (80, at_80)):
            same = {"base_color": 0.5, "roughness": roughness}
            E = white_albedo("unity_standard", degrees, **same)
            physical = white_albedo("metallic_roughness", degrees, **same)
            assert E[0] / physical[0] == pytest.approx(stated, abs=1.2 * decimals(3))


def test_unity_masks_up_to_29_percent_more_than_smith() -> None:
    mu = np.geomspace(1e-3, 1, 200)
    i, o = (m.ravel() for m in np.meshgrid(mu, mu))
    wi, wo = polar(np.arccos(i)), polar(np.arccos(o), 1.0)
    worst = {}
    for alpha in (0.01, 1.0):
        white = {"base_color": 1, "metallic": 1, "roughness": math.sqrt(alpha)}
        unity = gonio.model("unity_standard", **white).eval(wi, wo)
        smith = gonio.model("metallic_roughness", **white).eval(wi, wo)
        worst[alpha] = float((unity / smith).min())
        assert (unity / smith).max() < 1 + 1e-9
    assert worst[0.01] == pytest.approx(0.71, abs=decimals(2))
    assert worst[1.0] == pytest.approx(1)


# --- energy: what the caveats say ------------------------------------------------------------------

# Model, parameters, angle of wo in degrees, albedo (of the third channel) that its caveats state.
STATED: list[tuple[str, dict[str, Any], float, float]] = [
    ("metallic_roughness", {"base_color": 1, "roughness": 0}, 90, 1.93),
    ("metallic_roughness", {"base_color": 1, "metallic": 1, "roughness": 1}, 0, 0.31),
    ("ue4", {"base_color": 1, "roughness": 0}, 0, 1.040),
    ("ue4", {"base_color": 1, "specular": 1, "roughness": 0}, 80, 1.171),
    ("ue4", {"base_color": 1, "specular": 1, "roughness": 0, "light": "image"}, 89.5, 1.950),
    ("unity_standard", {"base_color": 1, "roughness": 1}, 90, 1.581),
    ("unity_standard", {"base_color": 1, "roughness": 1}, 0, 1.007),
    ("unity_brdf2", {"base_color": 1, "metallic": 1, "roughness": 0.15}, 0, 1.869),
    ("unity_brdf2", {"base_color": 1, "roughness": 0.15}, 0, 1.035),
    ("unity_brdf2", {"base_color": 1, "metallic": 1, "roughness": 0.03}, 0, 0.15),
    ("unity_brdf2", {"base_color": 1, "metallic": 1, "roughness": 0}, 0, 0.0),
    ("triace_blinn_phong", {"rho": 1, "f0": 0.04, "shininess": 1e5}, 80, 1.030),
    ("triace_blinn_phong", {"rho": 1, "f0": 0, "shininess": 1e5}, 80, 1.066),
    ("phong", {"rho": 0, "specular": 1, "shininess": 20}, 90, 0.088),
    ("phong", {"rho": 0, "specular": 1, "shininess": 5.28, "form": "classical"}, 0, 1.0),
    ("blinn", {"rho": 0, "specular": 1, "shininess": 23.1}, 0, 1.0),
    ("disney", {"base_color": 1, "roughness": 1}, 90, 1.601),
    ("disney", {"base_color": 1, "roughness": 1, "sheen": 1}, 90, 1.689),
    (
        "disney",
        {"base_color": 1, "roughness": 1, "sheen": 1, "clearcoat": 1, "specular": 1},
        90,
        1.734,
    ),
    ("disney", {"base_color": 1, "metallic": 1, "roughness": 0.85, "anisotropic": 1}, 90, 1.681),
    (
        "disney",
        {
            "base_color": (0, 0, 1),
            "roughness": 1,
            "sheen": 1,
            "sheen_tint": 1,
            "specular": 1,
            "specular_tint": 1,
        },
        90,
        2.9,
    ),
]


@pytest.mark.parametrize(("name", "parameters", "degrees", "stated"), STATED)
def test_caveats_state_the_measured_albedo(
    name: str, parameters: dict[str, Any], degrees: float, stated: float
) -> None:
    E = white_albedo(name, degrees, **parameters)[2]
    decimals = len(f"{stated}".partition(".")[2])
    assert pytest.approx(stated, abs=max(0.55 * 10**-decimals, 5e-4)) == E


# The most that a model reflects of white light, whatever its parameters (colours at most white).
MOST = {
    "metallic_roughness": 1.93,
    "ue4": 1.950,
    "unity_standard": 1.581,
    "unity_brdf2": 1.870,
    "triace_blinn_phong": 1.067,
}


@pytest.mark.parametrize("name", MOST)
def test_no_parameters_gain_more_energy_than_the_caveats_say(name: str) -> None:
    cls = gonio.models()[name]
    wo = polar(np.radians([0.0, 30, 60, 75, 80, 85, 88, 89, 89.5, 90]))
    worst = 0.0
    for choice in options(cls):
        for seed in range(40):
            values = {k: v[-1] for k, v in random_parameters(cls, 5, seed).items()}
            white = {k: float(v) if v.ndim == 0 else 1.0 for k, v in values.items()}
            if "f0" in white:
                white["f0"] = float(values["f0"][0])
            worst = max(worst, float(cls(**white, **choice).albedo(wo).max()))
    assert 1 < worst < MOST[name] + 1e-3


# --- sampling --------------------------------------------------------------------------------------


def weights(model: Model, theta: float, count: int = 128) -> Any:
    """Mean over channels of f cos / pdf, for stratified random numbers."""
    rng = np.random.default_rng(5)
    x, y = np.meshgrid(np.arange(count), np.arange(count), indexing="ij")
    u = (np.stack([x.ravel(), y.ravel()], -1) + rng.random((count * count, 2))) / count
    wo = polar(theta).astype(np.float32)
    wi, pdf = model.sample(wo, np.minimum(u.astype(np.float32), np.float32(1 - 2.0**-24)))
    f = model.eval(wi, wo).astype(np.float64).mean(-1)
    return np.where(pdf > 0, f * wi[:, 2] / np.where(pdf > 0, pdf, 1), 0)


def largest_weight(cls: type[Model]) -> float:
    worst = 0.0
    for choice in options(cls):
        for parameters in sweep(cls)[::3]:
            for theta in (0.0, 0.8, 1.3, 1.5, 1.5707):
                worst = max(worst, float(weights(cls(**parameters, **choice), theta).max()))
    return worst


# Measured over sweeps and random parameters, rounded up. Where a model gains energy, its albedo alone
# accounts for most of it: classical Phong at shininess 0 reflects 6.28 times the light.
BOUND = {
    "phong": 6.5,
    "triace_blinn_phong": 2.0,
    "metallic_roughness": 2.0,
    "ue4": 2.0,
    "unity_standard": 2.0,
    "unity_brdf2": 2.5,
    "disney": 3.5,
}


@EACH
def test_weights_are_bounded(name: str) -> None:
    assert largest_weight(gonio.models()[name]) < BOUND[name]


def test_a_lobe_that_is_chosen_by_its_fresnel_at_wo_is_caught(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """1 - F(mu_o) leaves the diffuse term no samples at grazing angles, though it is still bright."""
    Metallic = gonio.models()["metallic_roughness"]

    class Broken(Metallic, register=False):  # type: ignore[misc, valid-type]
        def _shares(self, wo: Vec3) -> Vec2:
            diffuse = (1 - self._f0()) * schlick_complement(wo.z)
            return lobes.shares(lobes.average(diffuse), 1)

    model = Broken(base_color=0.5, metallic=0.5, roughness=0)
    assert weights(model, 1.5707).max() > 4 * BOUND["metallic_roughness"]


@EACH
def test_no_sample_is_wasted_but_the_clearcoats(name: str) -> None:
    cls = gonio.models()[name]
    wasted = {}
    for theta in (0.0, 1.0, 1.5, 1.57):
        u = np.random.default_rng(3).random((4096, 2)).astype(np.float32) * 0.9999999
        rough = {k: 1.0 for k in ("roughness", "metallic", "clearcoat") if k in cls.fields}
        pdf = cls(**rough).sample(polar(theta).astype(np.float32), u).pdf
        wasted[theta] = float(np.mean(pdf <= 0))
    assert max(wasted.values()) < (0.1 if name == "disney" else 1e-12)


# What is mirrored up again ends at a jump, which the grid blurs by a step.
FOLD_EDGE = 1e-3


class FoldedGGX(Model, register=False):
    """The GGX lobe of the mixtures by itself."""

    numeric = NumericAlbedo("half_vectors")
    alpha: Float = gonio.param(0.5, 1e-4, 1, "width")

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        return 0 * wi.z

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        wi = lobes.sample_ggx_lobe(RoundGGX(self.alpha), wo, u)
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        return lobes.pdf_ggx_lobe(RoundGGX(self.alpha), wi, wo)


class PlainGGX(FoldedGGX, register=False):
    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        wi = mirror(wo, RoundGGX(self.alpha).sample_visible(wo, u))
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        return pdf_visible(RoundGGX(self.alpha), wo, lobes.half_vector(wi, wo))


def missing_density(model: Model, theta: float) -> float:
    wi, w = integrate.rule_for(model, theta)
    return 1 - float(np.sum(model.pdf(wi, polar(theta)) * w))


@pytest.mark.parametrize("alpha", [1e-4, 0.01, 0.3, 1.0])
def test_the_folded_lobe_wastes_nothing(alpha: float) -> None:
    for theta in (0.0, 0.7, 1.4, 1.57):
        assert abs(missing_density(FoldedGGX(alpha=alpha), theta)) < FOLD_EDGE
    # Without the fold a third of a rough lobe lies below the horizon.
    if alpha == 1:
        assert missing_density(PlainGGX(alpha=alpha), 0.7) > 0.3


def test_shares_add_up_and_never_starve_a_lobe() -> None:
    albedos = [0.0, 1e-30, 1e-9, 1e-4, 0.01, 0.3, 1.0, 5.0]
    for a in albedos:
        for b in albedos:
            p = lobes.shares(a, b)
            x, y = float(p.x), float(p.y)
            assert x + y == pytest.approx(1, abs=SINGLE)
            assert min(x, y) >= 0
            if min(a, b) > UNSEEN:
                estimate = min(a, b) / (a + b)
                assert min(x, y) > 0.999 * min(lobes.SHARE_LEAST, 50 * estimate)
    assert lobes.share(0.0, 0.0) == 1


@EACH
def test_grey_colours_are_colours(name: str) -> None:
    """Arrays of shape (n, 1), which have no channels of their own, in models that average over them."""
    cls = gonio.models()[name]
    wi, wo = (w[:50].astype(np.float32) for w in directions())
    grey = np.linspace(0, 1, 50, dtype=np.float32)[:, None]
    colors = [k for k, p in cls.fields.items() if getattr(p, "width", 1) == 3]
    narrow = cls(**dict.fromkeys(colors, grey))
    wide = cls(**dict.fromkeys(colors, np.repeat(grey, 3, 1)))
    np.testing.assert_array_equal(narrow.eval(wi, wo), wide.eval(wi, wo))
    np.testing.assert_array_equal(narrow.pdf(wi, wo), wide.pdf(wi, wo))


# --- Mitsuba ---------------------------------------------------------------------------------------

# principled computes in float32, and its anisotropic highlight of roughness 0.1 has a width of 0.006.
PRINCIPLED = 5e-5
DIFFERENCE = 2e-6  # of two materials of about 1, in its single precision
SCHLICK_IN_SINGLE = 1e-3  # its exact Fresnel term near normal incidence, where two ones cancel


def principled(wi: Any, wo: Any, **parameters: Any) -> Any:
    """Mitsuba's BSDF as a BRDF, shape (n, 3)."""
    import gonio.mitsuba  # noqa: F401  before mitsuba, so that a usable LLVM is found

    import mitsuba as mi  # isort: skip

    mi.set_variant("llvm_ad_rgb")
    rgb = parameters.pop("base_color")
    bsdf = mi.load_dict(
        {"type": "principled", "base_color": {"type": "rgb", "value": list(rgb)}, **parameters}
    )
    si = dr.zeros(mi.SurfaceInteraction3f)
    si.wi = mi.Vector3f(wo.T.astype(np.float32))
    si.sh_frame = mi.Frame3f([0, 0, 1])
    value = bsdf.eval(mi.BSDFContext(), si, mi.Vector3f(wi.T.astype(np.float32)))
    return np.array(value).T / wi[:, 2:]


@pytest.mark.parametrize("roughness", [0.1, 0.4, 1.0])
@pytest.mark.parametrize("anisotropic", [0.0, 0.6])
def test_disney_metals_are_mitsubas_principled(roughness: float, anisotropic: float) -> None:
    """With masking='anisotropic': principled has Burley's later G, not that of 2012."""
    wi, wo = directions(2000)
    given = {"metallic": 1.0, "roughness": roughness, "anisotropic": anisotropic}
    found = gonio.model("disney", base_color=TINTED, masking="anisotropic", **given).eval(wi, wo)
    expected = principled(wi, wo, base_color=TINTED, **given)
    np.testing.assert_allclose(found, expected, rtol=PRINCIPLED)
    of_2012 = gonio.model("disney", base_color=TINTED, **given).eval(wi, wo)
    if roughness < 1:
        assert np.max(np.abs(of_2012 / expected - 1)) > 0.1


@pytest.mark.parametrize("roughness", [0.1, 0.4, 1.0])
def test_disney_diffuse_and_sheen_are_mitsubas_principled(roughness: float) -> None:
    """Differences of two materials, so that the highlight, which is defined otherwise, drops out.

    principled writes Burley's diffuse term in the form of 2015, (1 - F_i/2)(1 - F_o/2) + R (...), which
    multiplied out is that of 2012.
    """
    wi, wo = directions(2000)
    black = (0.0, 0.0, 0.0)
    model = gonio.model("disney", base_color=black, roughness=roughness, sheen_tint=0)
    other = principled(wi, wo, base_color=black, roughness=roughness)
    diffuse = model.replace(base_color=TINTED).eval(wi, wo) - model.eval(wi, wo)
    expected = principled(wi, wo, base_color=TINTED, roughness=roughness) - other
    np.testing.assert_allclose(diffuse, expected, rtol=PRINCIPLED, atol=DIFFERENCE)
    sheen = model.replace(sheen=1).eval(wi, wo) - model.eval(wi, wo)
    expected = principled(wi, wo, base_color=black, roughness=roughness, sheen=1.0) - other
    np.testing.assert_allclose(sheen, expected, rtol=PRINCIPLED, atol=DIFFERENCE)


def test_disney_differs_from_mitsubas_principled_as_is_known() -> None:
    """Clearcoat: principled leaves out the division by 4 mu_i mu_o that Burley's smithG_GGX contains.

    Highlight of dielectrics: exact Fresnel of the index that belongs to F0, in place of Schlick's curve.
    """
    wi, wo = directions(2000)
    i, o, _, oh = angles(wi, wo)
    black = (0.0, 0.0, 0.0)
    model = gonio.model("disney", base_color=black, masking="anisotropic")
    plain = principled(wi, wo, base_color=black)
    coat = model.replace(clearcoat=1, clearcoat_gloss=0.5).eval(wi, wo) - model.eval(wi, wo)
    other = principled(wi, wo, base_color=black, clearcoat=1.0, clearcoat_gloss=0.5) - plain
    bright = coat[:, 0] > 0.01
    np.testing.assert_allclose(
        (other / coat)[bright], (4 * i * o * [1, 1, 1])[bright], rtol=4 * PRINCIPLED
    )
    eta = (1 + 0.2) / (1 - 0.2)
    g = np.sqrt(eta**2 - 1 + oh**2)
    exact = 0.5 * ((g - oh) / (g + oh)) ** 2
    exact = exact * (1 + ((oh * (g + oh) - 1) / (oh * (g - oh) + 1)) ** 2)
    schlick = 0.04 + 0.96 * (1 - oh) ** 5
    ratio = plain / model.eval(wi, wo)
    np.testing.assert_allclose(ratio, exact / schlick * [1, 1, 1], rtol=SCHLICK_IN_SINGLE)
