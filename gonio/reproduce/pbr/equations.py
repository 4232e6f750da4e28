"""The equations, and the maskings that the text names."""

from __future__ import annotations

import functools
import math
from typing import Any

import numpy as np

import gonio
from gonio import conversions, plot
from gonio.arrays.elementwise import elementwise
from gonio.parts import fresnel, masking
from gonio.reproduce.measure import (
    Floats,
    directions,
    gray,
    hemisphere,
    largest_difference,
    random_pairs,
)
from gonio.reproduce.pbr import TEXT
from gonio.reproduce.sheet import Sheet

ROUNDING = 1e-10
ALPHA = 0.3


def D_blinn_phong(alpha: float, cos: Floats) -> Floats:
    """Section 4.2.1.1, with n = 2 / alpha^2 - 2."""
    n = 2 / alpha**2 - 2
    return np.asarray((n + 2) / (2 * math.pi) * cos**n)


def D_beckmann(alpha: float, cos: Floats) -> Floats:
    """Section 4.2.1.2."""
    return np.asarray(np.exp((cos**2 - 1) / (alpha * cos) ** 2) / (math.pi * alpha**2 * cos**4))


def D_ggx(alpha: float, cos: Floats) -> Floats:
    """Section 4.2.1.3."""
    return np.asarray(alpha**2 / (math.pi * (cos**2 * (alpha**2 - 1) + 1) ** 2))


PRINTED = {"blinn_phong": D_blinn_phong, "beckmann": D_beckmann, "ggx": D_ggx}


def half(wi: Floats, wo: Floats) -> tuple[Floats, Floats]:
    """n.h and h.v."""
    h = wi + wo
    h = h / np.linalg.norm(h, axis=-1, keepdims=True)
    return h[..., 2], np.sum(h * wo, -1)


def _distribution(sheet: Sheet, name: str) -> None:
    model = gonio.model("torrance_sparrow", distribution=name, alpha=ALPHA)
    theta = np.radians(np.linspace(0, 85, 40))
    m = directions(theta)
    ours = plot.facet_terms(model, m, m)["D"]
    apart = float(np.abs(ours - PRINTED[name](ALPHA, np.cos(theta))).max())
    sheet.claim(f"{name}, alpha {ALPHA:g}: largest difference", "<=", ROUNDING, apart)
    over = hemisphere(0.0)
    D = plot.facet_terms(model, over.wi, over.wi)["D"]
    sheet.claim("the integral of D cos, which must be 1", "=", 1, over.reflected(D), within=1e-5)


@TEXT.item(
    "eq-d-bp", "section 4.2.1.1", "D of Blinn-Phong, by the exponent and by alpha", "eq-d-bp2"
)
def d_blinn_phong(sheet: Sheet) -> None:
    _distribution(sheet, "blinn_phong")
    n = 2 / ALPHA**2 - 2
    second = np.cos(0.4) ** n / (math.pi * ALPHA**2)
    sheet.claim(
        "the second form at 0.4 rad",
        "=",
        second,
        float(D_blinn_phong(ALPHA, np.cos(0.4))),
        within=1e-12,
    )


@TEXT.item("eq-d-beckmann", "section 4.2.1.2", "D of Beckmann")
def d_beckmann(sheet: Sheet) -> None:
    _distribution(sheet, "beckmann")


@TEXT.item("eq-d-ggx", "section 4.2.1.3", "D of GGX")
def d_ggx(sheet: Sheet) -> None:
    _distribution(sheet, "ggx")


@TEXT.item("eq-alphap", "section 4.2.1.1", "n = 2 / alpha^2 - 2")
def exponent(sheet: Sheet) -> None:
    for alpha in (0.1, 0.5):
        ours = conversions.shininess_from_alpha(alpha)
        sheet.claim(f"n at alpha {alpha:g}", "=", 2 / alpha**2 - 2, ours, within=1e-9)


@TEXT.item("eq-alphap2", "section 4.2.1.2", "n = alpha^-2 - 2 for Beckmann")
def exponent_beckmann(sheet: Sheet) -> None:
    n = conversions.shininess_from_alpha(ALPHA)
    sheet.refute(
        "n of the Blinn-Phong lobe like Beckmann's, alpha 0.3",
        "=",
        ALPHA**-2 - 2,
        n,
        proof=2 * math.pi * float(D_beckmann(ALPHA, np.array(1.0))) - 2,
        within=1e-6,
        why="peaks are equal where (n + 2) / (2 pi) = 1 / (pi alpha^2); the text's own section "
        "before has it right",
    )


@TEXT.item("eq-alpha", "section 4.2.1.3", "alpha = r^2")
def alpha(sheet: Sheet) -> None:
    ours = conversions.alpha_from_perceptual(0.7)
    sheet.claim("alpha of roughness 0.7", "=", 0.49, ours, within=1e-12)


@TEXT.item("eq-schlick", "section 4.2.2", "F = F0 + (1 - F0)(1 - h.v)^5")
def schlick(sheet: Sheet) -> None:
    model = gonio.TorranceSparrow(fresnel="schlick", f0=0.04)
    cos = np.linspace(0, 1, 30)
    found = plot.reflectances(model, cos)["F"][:, 0]
    apart = float(np.abs(found - (0.04 + 0.96 * (1 - cos) ** 5)).max())
    sheet.claim("largest difference", "<=", 1e-12, apart)


@TEXT.item("eq-f0", "section 4.2.2", "F0 from two indices, or one in air", "eq-f0air")
def f0(sheet: Sheet) -> None:
    for n in (1.333, 1.5, 2.42):
        ours = float(elementwise(fresnel.f0_from_eta, np.array(n)))
        sheet.claim(f"F0 of index {n:g}", "=", ((n - 1) / (n + 1)) ** 2, ours, within=1e-12)
    between = float(elementwise(fresnel.f0_between, 1.33, 1.5))
    sheet.claim("between 1.33 and 1.5", "=", (0.17 / 2.83) ** 2, between, within=1e-12)


def _metallic_roughness(c: float, m: float, r: float, wi: Floats, wo: Floats) -> Floats:
    """Sections 4.1 and 4.2 with GGX and Smith's G, G0 = 1 / (1 + Lambda)."""
    a = r * r
    cos_n, cos_h = half(wi, wo)
    F0 = 0.04 + (c - 0.04) * m
    F = F0 + (1 - F0) * (1 - cos_h) ** 5
    G = np.ones(len(wi))
    for w in (wi, wo):
        tan2 = 1 / w[:, 2] ** 2 - 1
        G = G / (1 + (np.sqrt(1 + a * a * tan2) - 1) / 2)
    spec = D_ggx(a, cos_n) * F * G / (4 * wi[:, 2] * wo[:, 2])
    return np.asarray((1 - F) * c * (1 - m) / math.pi + spec)


@TEXT.item(
    "eq-sum",
    "section 4",
    "f = f_diff + f_spec, k_d = 1 - F, c_d = c (1 - m), D F G / (4 cos cos)",
    "eq-lambert",
    "eq-cd",
    "eq-kd",
    "eq-cooktorrance",
    "eq-g0",
)
def metallic_roughness(sheet: Sheet) -> None:
    for c, m, r in ((0.7, 0.0, 0.5), (0.7, 0.6, 0.3), (0.9, 1.0, 0.8)):
        ours = gray(gonio.MetallicRoughness(base_color=c, metallic=m, roughness=r, masking="smith"))
        theirs = functools.partial(_metallic_roughness, c, m, r)
        difference = largest_difference(ours, theirs, relative=True)
        sheet.claim(
            f"c {c:g}, m {m:g}, r {r:g}: largest relative difference", "<=", 1e-9, difference
        )


@TEXT.item("eq-disneydiffuse", "section 4.1", "Disney's diffuse model, with k_d and theta_h")
def disney_diffuse(sheet: Sheet) -> None:
    def burley(angle: str, wi: Floats, wo: Floats) -> Floats:
        cos_n, cos_h = half(wi, wo)
        F90 = 0.5 + 2 * (cos_h if angle == "d" else cos_n) ** 2 * 0.8
        terms = [1 + (F90 - 1) * (1 - w[:, 2]) ** 5 for w in (wi, wo)]
        return np.asarray(terms[0] * terms[1] / math.pi)

    ours = gray(gonio.BurleyDiffuse(rho=1, roughness=0.8))
    wi, wo = random_pairs(1000)
    apart = float(np.abs(ours(wi, wo) - burley("d", wi, wo)).max())
    sheet.claim(
        "with theta_d, the angle between light and half vector: largest difference",
        "<=",
        ROUNDING,
        apart,
    )
    i, o = directions(1.4)[None], directions(1.4, 0.0)[None]
    sheet.refute(
        "f at wi = wo, 80 degrees, with theta_h as printed (n.h = cos 80 degrees)",
        "=",
        float(burley("h", i, o)[0]),
        float(ours(i, o)[0]),
        proof=float(burley("d", i, o)[0]),
        within=1e-9,
        why="Burley's retro-reflection peaks where light and viewer meet, h.l = 1; with n.h it "
        "would vanish there",
    )


@TEXT.item("eq-g", "section 4.2.3", "G = G0(l) G0(v), called Smith-Joint")
def smith(sheet: Sheet) -> None:
    white = gonio.TorranceSparrow(alpha=0.5, fresnel="white", masking="smith")
    wi, wo = random_pairs(1000, lowest=0.05)
    G = plot.facet_terms(white, wi, wo)["G"]
    lambdas = [(np.sqrt(1 + 0.25 * (1 / w[:, 2] ** 2 - 1)) - 1) / 2 for w in (wi, wo)]
    product = 1 / (1 + lambdas[0]) / (1 + lambdas[1])
    apart = float(np.abs(G - product).max())
    sheet.claim("the product: largest difference", "<=", ROUNDING, apart)
    joint = plot.facet_terms(white.replace(masking="smith_correlated"), wi, wo)["G"]
    together = 1 / (1 + lambdas[0] + lambdas[1])
    sheet.refute(
        "joint masking over the product, largest: the name says that they are one",
        "<=",
        "1",
        float((joint / product).max()),
        proof=float((together / product).max()),
        within=1e-9,
        why="Smith-Joint is 1 / (1 + Lambda_l + Lambda_v), correlated by height, which is always larger",
    )


@TEXT.item("eq-schlickbeckmann", "section 4.2.3", "Schlick's G0 with k = alpha sqrt(2 / pi)")
def schlick_beckmann(sheet: Sheet) -> None:
    k = float(elementwise(masking.schlick_k_beckmann, np.array(0.5)))
    sheet.claim("k at alpha 0.5", "=", 0.5 * math.sqrt(2 / math.pi), k, within=1e-12)
    mu = np.linspace(0.1, 1, 10)
    apart = float(np.abs(elementwise(masking.G1_schlick, mu, k) - mu / (mu * (1 - k) + k)).max())
    sheet.claim("G0: largest difference", "<=", 1e-12, apart)


@TEXT.item("eq-schlickggx", "section 4.2.3", "UE4 has k = alpha / 2")
def schlick_ggx(sheet: Sheet) -> None:
    k = float(elementwise(masking.schlick_k_ggx, np.array(0.5)))
    sheet.claim("k at alpha 0.5, for image-based light", "=", 0.25, k, within=1e-12)
    lamp = float(elementwise(masking.schlick_k_ue4, np.array(math.sqrt(0.5))))
    sheet.refute(
        "k of UE4 for lamps, alpha 0.5",
        "=",
        0.25,
        lamp,
        proof=(math.sqrt(0.5) + 1) ** 2 / 8,
        within=1e-12,
        why="Karis, SIGGRAPH 2013: k = (roughness + 1)^2 / 8 for analytic lights; alpha / 2 is for images",
    )


def _masking(sheet: Sheet, name: str, printed: Any, **options: str) -> None:
    model = gonio.model("torrance_sparrow", alpha=ALPHA, masking=name, **options)
    wi, wo = random_pairs(1000, lowest=0.1)
    apart = float(np.abs(plot.facet_terms(model, wi, wo)["G"] - printed(wi, wo)).max())
    sheet.claim(
        f"G of {name}: largest difference from its publication's formula", "<=", 1e-9, apart
    )


def _cos(wi: Floats, wo: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    return (wi[:, 2], wo[:, 2], *half(wi, wo))


def _cook_torrance(wi: Floats, wo: Floats) -> Floats:
    i, o, n, h = _cos(wi, wo)
    return np.asarray(np.minimum(1, 2 * n * np.minimum(i, o) / h))


def _separable(G1: Any) -> Any:
    def product(wi: Floats, wo: Floats) -> Floats:
        tans = [np.sqrt(1 / w[:, 2] ** 2 - 1) for w in (wi, wo)]
        return np.asarray(G1(tans[0]) * G1(tans[1]))

    return product


def _walter(tan: Floats) -> Floats:
    c = 1 / (ALPHA * np.maximum(tan, 1e-12))
    return np.where(c < 1.6, (3.535 * c + 2.181 * c**2) / (1 + 2.276 * c + 2.577 * c**2), 1.0)


def _beckmann(tan: Floats) -> Floats:
    c = 1 / (ALPHA * np.maximum(tan, 1e-12))
    erf = np.array([math.erf(x) for x in c])
    return np.asarray(1 / (1 + (erf - 1) / 2 + np.exp(-c * c) / (2 * c * math.sqrt(math.pi))))


NAMED = {
    "implicit": ("implicit", lambda wi, wo: wi[:, 2] * wo[:, 2], {}),
    "neumann": ("neumann", lambda wi, wo: np.minimum(wi[:, 2], wo[:, 2]), {}),
    "cooktorrance": ("cook_torrance", _cook_torrance, {}),
    "kelemen": ("kelemen", lambda wi, wo: wi[:, 2] * wo[:, 2] / half(wi, wo)[1] ** 2, {}),
    "smith-ggx": (
        "smith",
        _separable(lambda t: 1 / (1 + (np.sqrt(1 + ALPHA**2 * t * t) - 1) / 2)),
        {"distribution": "ggx"},
    ),
    "smith-beckmann": ("smith", _separable(_beckmann), {"distribution": "beckmann"}),
    "smith-blinnphong": ("smith_walter", _separable(_walter), {"distribution": "blinn_phong"}),
}

for _id, (_name, _printed, _options) in NAMED.items():
    TEXT.item(f"g-{_id}", "section 4.2.3", f"the masking function named {_id}")(
        functools.partial(_masking, name=_name, printed=_printed, **_options)  # type: ignore[arg-type]
    )
