"""The figures, and Unity's code."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np

import gonio
from gonio import plot
from gonio.arrays.elementwise import elementwise
from gonio.parts import fresnel, metals
from gonio.reproduce.measure import Floats, directions, gray, largest_difference, random_pairs
from gonio.reproduce.pbr import TEXT
from gonio.reproduce.pbr.equations import PRINTED, D_ggx, half
from gonio.reproduce.rendered import Later, Layout, Rendered, single_bounce
from gonio.reproduce.sheet import Sheet
from gonio.reproduce.text import Picture


@TEXT.item(
    "ndf",
    "section 4.2.1.3",
    "D of Beckmann, Blinn-Phong and GGX: the first two hardly differ, GGX has a long tail",
    "g",
)
def distributions(sheet: Sheet) -> Picture:
    models = [
        gonio.model("torrance_sparrow", distribution=name, alpha=0.3)
        for name in ("beckmann", "blinn_phong", "ggx")
    ]
    theta = np.radians([10.0, 20, 30, 45])
    m = directions(theta)
    D = {str(getattr(one, "distribution")): plot.facet_terms(one, m, m)["D"] for one in models}  # noqa: B009
    for name, values in D.items():
        apart = float(np.abs(values - PRINTED[name](0.3, np.cos(theta))).max())
        sheet.claim(f"{name}: largest difference from its formula", "<=", 1e-10, apart)
    near = np.abs(D["blinn_phong"] / D["beckmann"] - 1)
    sheet.claim(
        "Blinn-Phong and Beckmann hardly differ: relative difference up to 20 degrees",
        "<=",
        "0.1",
        float(near[:2].max()),
    )
    sheet.claim(
        "GGX over Beckmann at 45 degrees: the long tail",
        ">=",
        "10",
        float(D["ggx"][3] / D["beckmann"][3]),
    )
    sheet.show(
        "Blinn-Phong over Beckmann at 45 degrees", float(D["blinn_phong"][3] / D["beckmann"][3])
    )
    return Layout(
        [plot.distribution(models), plot.distribution(models, log=True, title="the same, log axis")]
    )


@TEXT.item("h", "section 4.2.1.3", "highlight of measured chrome beside GGX and Beckmann")
def chrome(sheet: Sheet) -> Picture:
    sheet.remark(
        "the measured chrome is not public in a form that can be had here; the two models are"
    )
    chromium = metals.metal("Cr", neutral=True)
    models = [
        gonio.model("torrance_sparrow", distribution=name, alpha=0.15, **chromium)
        for name in ("ggx", "beckmann")
    ]
    far = directions(math.radians(35)), directions(0)
    tail = [float(gray(one)(*far)) for one in models]
    sheet.claim(
        "GGX over Beckmann, 35 degrees from the mirror direction", ">=", "1", tail[0] / tail[1]
    )
    return Rendered(models, ["GGX", "Beckmann"], [("", single_bounce("sun"))])


@TEXT.item("i", "section 4.2.1.3", "the highlight over the roughness")
def highlights(sheet: Sheet) -> Picture:
    roughnesses = (0.1, 0.3, 0.5, 0.7, 0.9)
    models = [gonio.MetallicRoughness(metallic=1, roughness=r) for r in roughnesses]
    up = directions(0)
    peak = [float(gray(one)(up, up)) for one in models]
    sheet.claim(
        "the peak falls from roughness to roughness: largest ratio of two",
        "<=",
        "1",
        max(b / a for a, b in itertools.pairwise(peak)),
    )
    sheet.claim(
        "peak at roughness 0.5 over D / 4, base colour 0.8",
        "=",
        0.8,
        peak[2] / float(D_ggx(0.25, np.array(1.0)) / 4),
        within=1e-9,
    )
    return Rendered(models, [f"{r:g}" for r in roughnesses], common={"size": (176, 176)})


@TEXT.item(
    "j", "section 4.2.2", "F0 of many materials: about 4 % for dielectrics, far more for metals"
)
def reflectances(sheet: Sheet) -> None:
    sheet.remark(
        "the table is a picture that is not in the text at hand; these are gonio's, linear sRGB"
    )
    for name, n in (("water", 1.333), ("glass", 1.5), ("diamond", 2.42)):
        sheet.show(f"{name}, index {n:g}", float(elementwise(fresnel.f0_from_eta, np.array(n))))
    lowest = 1.0
    for symbol in ("Au", "Ag", "Cu", "Al", "Cr"):
        index = metals.metal(symbol)
        found = [
            float(elementwise(fresnel.f0_from_conductor, index["eta"][i], index["k"][i]))
            for i in range(3)
        ]
        lowest = min(lowest, *found)
        for channel, value in zip(plot.RGB, found, strict=True):
            sheet.show(f"{symbol}, {channel}", value)
    sheet.claim("lowest F0 of these metals: far more than 4 %", ">=", "0.2", lowest)


# --- Unity ---------------------------------------------------------------------------------------------


def unity(c: float, m: float, r: float, wi: Floats, wo: Floats) -> Floats:
    """BRDF1 of Unity 2018.2 over pi, without its guards 1e-5 and 1e-7."""
    cos_n, cos_h = half(wi, wo)
    i, o = wi[:, 2], wo[:, 2]
    F90 = 0.5 + 2 * cos_h**2 * r
    burley = (1 + (F90 - 1) * (1 - i) ** 5) * (1 + (F90 - 1) * (1 - o) ** 5)
    diffuse = c * (1 - m) * (1 - 0.04) * burley
    a = max(r * r, 0.002)
    V = 0.5 / (i * (o * (1 - a) + a) + o * (i * (1 - a) + a))
    F0 = 0.04 + (c - 0.04) * m
    F = F0 + (1 - F0) * (1 - cos_h) ** 5
    return np.asarray(diffuse / math.pi + V * D_ggx(a, cos_n) * F)


@TEXT.item(
    "code1",
    "section 5",
    "Unity 2018.2: LightingStandard, BRDF1_Unity_PBS and what they call",
    *(f"code{n}" for n in range(2, 13)),
    "eq-unitykd",
    "eq-unityf0",
)
def unity_code(sheet: Sheet) -> None:
    for c, m, r in ((0.7, 0.0, 0.5), (0.7, 0.6, 0.3), (0.9, 1.0, 0.8)):
        ours = gray(gonio.UnityStandard(base_color=c, metallic=m, roughness=r))

        def printed(wi: Floats, wo: Floats, c: float = c, m: float = m, r: float = r) -> Any:
            return unity(c, m, r, wi, wo)

        difference = largest_difference(ours, printed, relative=True)
        sheet.claim(
            f"albedo {c:g}, metallic {m:g}, roughness {r:g}: largest relative difference",
            "<=",
            1e-9,
            difference,
        )
    sheet.remark(
        "the code is a picture that is not in the text at hand: compared with its formulas as published in "
        "UnityStandardBRDF.cginc. Unity returns pi f, and adds 1e-5 and 1e-7 against divisions by zero. "
        "BRDF2 is gonio's unity_brdf2; BRDF3 needs a table that is not public"
    )


@TEXT.item("three", "section 5", "three BRDFs in Unity")
def three(sheet: Sheet) -> None:
    names = [name for name in gonio.models() if name.startswith("unity_")]
    sheet.show("of them in gonio", len(names))
    sheet.lack(
        "BRDF3 reads its highlight from a texture that the engine generates, and that is not public"
    )


@TEXT.item("unitystronger", "section 5", "Unity's diffuse part is stronger, because F > F0")
def stronger(sheet: Sheet) -> Picture:
    wi, wo = random_pairs(2000)
    _, cos_h = half(wi, wo)
    k_d = 0.96 / (1 - (0.04 + 0.96 * (1 - cos_h) ** 5))
    sheet.claim(
        "k_d over that of section 4: the smallest", ">=", "1", float(k_d.min()), within=1e-9
    )
    for angle in (0, 80):
        w = directions(math.radians(angle))
        for r in (0.0, 0.5, 1.0):
            ours, plain = (
                float(model(base_color=0.5, roughness=r).albedo(w)[0])
                for model in (gonio.UnityStandard, gonio.MetallicRoughness)
            )
            sheet.show(
                f"whole albedo over metallic_roughness, roughness {r:g}, {angle} degrees",
                ours / plain,
            )
    sheet.remark(
        "the whole is darker for smooth surfaces, because Burley's diffuse part darkens them"
    )
    models = [gonio.UnityStandard(base_color=0.5), gonio.MetallicRoughness(base_color=0.5)]
    return Later(lambda: plot.albedo(models))


@TEXT.item("unityv", "section 5", "the origin of Unity's V is unknown")
def unity_v(sheet: Sheet) -> None:
    wi, wo = random_pairs(4000, lowest=0.01)
    i, o = wi[:, 2], wo[:, 2]

    def V(a: float) -> Floats:
        """Of gonio's model: white metal has F = 1."""
        model = gonio.UnityStandard(base_color=1, metallic=1, roughness=math.sqrt(a))
        return np.asarray(gray(model)(wi, wo) / D_ggx(a, half(wi, wo)[0]))

    def smith(a: float) -> Floats:
        roots = [x * np.sqrt(y**2 + a * a * (1 - y**2)) for x, y in ((i, o), (o, i))]
        return np.asarray(0.5 / (roots[0] + roots[1]))

    same = float(np.abs(V(1.0) / smith(1.0) - 1).max())
    sheet.claim(
        "from height-correlated Smith's, alpha 1: largest relative difference", "<=", 1e-9, same
    )
    sheet.show("alpha 0.01: smallest ratio to it", float((V(0.01) / smith(0.01)).min()))
    sheet.remark("sqrt(mu^2 + alpha^2 sin^2) of Smith's is replaced by mu (1 - alpha) + alpha")


@TEXT.item("unitydiv", "section 5", "Unity does not divide by 4 cos cos, but multiplies by pi cos")
def unity_division(sheet: Sheet) -> None:
    wi, wo = random_pairs(1000, lowest=0.1)
    i, o = wi[:, 2], wo[:, 2]
    rough = gonio.UnityStandard(base_color=1, metallic=1, roughness=1)
    cos_n, _ = half(wi, wo)
    V = gray(rough)(wi, wo) / D_ggx(1.0, cos_n)
    joint = 1 / (1 + sum((np.sqrt(1 + 1 / c**2 - 1) - 1) / 2 for c in (i, o)))
    sheet.refute(
        "V over G / (4 cos cos), alpha 1: V would be G",
        ">=",
        "2",
        float(np.mean(V / (joint / (4 * i * o)))),
        proof=1.0,
        within=1e-9,
        why="V holds the division: at alpha 1 it equals height-correlated Smith's G over 4 cos cos",
    )


@TEXT.item("pi", "section 5", "Unity's diffuse part is not divided by pi")
def unity_pi(sheet: Sheet) -> None:
    up = directions(0)
    ours = float(gonio.UnityStandard(base_color=1, roughness=0.25).eval(up, up)[0])
    highlight = float(gonio.UnityStandard(base_color=0, roughness=0.25).eval(up, up)[0])
    sheet.claim(
        "k_d c = 0.96 at the normal, over gonio's f of the diffuse part",
        "=",
        math.pi,
        0.96 / (ours - highlight),
        within=1e-6,
    )
    sheet.remark("gonio returns f, of which Unity's value is pi times as much")
