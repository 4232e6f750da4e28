"""What the sentences say."""

from __future__ import annotations

import math

import numpy as np

import gonio
from gonio import conversions
from gonio.arrays.elementwise import elementwise
from gonio.parts import fresnel, metals
from gonio.reproduce.measure import directions, gray, hemisphere, random_pairs
from gonio.reproduce.pbr import TEXT
from gonio.reproduce.pbr.equations import D_ggx
from gonio.reproduce.sheet import Sheet


@TEXT.item("4", "section 1.1", "dielectrics reflect about 4 % at normal incidence")
def four_percent(sheet: Sheet) -> None:
    glass = float(elementwise(fresnel.f0_from_eta, np.array(1.5)))
    sheet.claim("glass, index 1.5", "=", "0.04", glass)
    for name, n in (("water", 1.333), ("diamond", 2.42)):
        sheet.show(f"{name}, index {n:g}", float(elementwise(fresnel.f0_from_eta, np.array(n))))


@TEXT.item("metal", "section 1.1", "metals reflect far more than 4 %, and have no diffuse part")
def metal(sheet: Sheet) -> None:
    for symbol in ("Au", "Cr"):
        index = metals.metal(symbol)
        lowest = min(
            float(elementwise(fresnel.f0_from_conductor, index["eta"][i], index["k"][i]))
            for i in range(3)
        )
        sheet.claim(f"{symbol}: the lowest channel", ">=", "0.2", lowest)
    wi, wo = directions(1.2), directions(0.2, math.pi)
    steel = gonio.MetallicRoughness(metallic=1, roughness=0.05)
    sheet.claim(
        "f of a smooth metal away from its mirror direction", "<=", 1e-2, float(gray(steel)(wi, wo))
    )


@TEXT.item("sr", "section 2", "a sphere has 4 pi steradians, a hemisphere 2 pi")
def steradians(sheet: Sheet) -> None:
    over = hemisphere(0.4)
    sheet.claim(
        "solid angle of the hemisphere",
        "=",
        2 * math.pi,
        over.integral(np.ones(len(over.wi))),
        within=1e-9,
    )


@TEXT.item("rough1", "section 4", "at roughness 1 the reflection is the same in all directions")
def roughness_1(sheet: Sheet) -> None:
    model = gonio.TorranceSparrow(alpha=1, fresnel="white")
    f = {
        a: float(gray(model)(directions(math.radians(a)), directions(-math.radians(a))))
        for a in (0, 60)
    }
    mu = 0.5
    sheet.refute(
        "f at mirror pairs of 60 degrees over that at the normal",
        "=",
        "1.00",
        f[60] / f[0],
        proof=(1 / (2 * math.pi * 2 * mu)) / (1 / (2 * math.pi * 2)),
        within=1e-6,
        why="D is constant, 1 / pi, but f = D / (4 G-terms) is 1 / (2 pi (mu_i + mu_o)) with joint Smith",
    )


@TEXT.item("tail", "section 4.2.1.3", 'GGX falls more slowly "when n.h grows"')
def tail(sheet: Sheet) -> None:
    slope = [float(D_ggx(0.3, np.array(c))) for c in (0.6, 0.9)]
    up = np.array([[0.0, 0, 1]])
    model = gonio.TorranceSparrow(alpha=0.3, fresnel="white", masking="implicit")
    ours = float(gray(model)(directions(2 * math.acos(0.9))[None], up)[0]) * 4
    sheet.claim("D at n.h 0.9", "=", slope[1], ours, within=1e-9)
    sheet.refute(
        "D at n.h 0.9 over that at 0.6: it would fall when n.h grows",
        "<=",
        "1",
        ours / slope[0],
        proof=slope[1] / slope[0],
        within=1e-9,
        why="D grows with n.h; what falls slowly is its tail, where n.h is small",
    )


@TEXT.item(
    "workflows", "section 4", "the metallic and the specular description can be converted both ways"
)
def workflows(sheet: Sheet) -> None:
    given = (np.array([0.6, 0.3, 0.1]), 0.7, 0.4)
    there = conversions.specular_from_metallic(*given)
    back = conversions.metallic_from_specular(*there)
    worst = max(
        float(np.abs(np.asarray(a) - np.asarray(b)).max()) for a, b in zip(given, back, strict=True)
    )
    sheet.claim("round trip: largest difference", "<=", 1e-9, worst)


@TEXT.item("classic", "section 4", "the classical Blinn-Phong: diffuse, specular and gloss")
def classic(sheet: Sheet) -> None:
    gloss = 40.0
    model = gonio.Blinn(rho=0.0, specular=1.0, shininess=gloss)
    wi, wo = random_pairs(500, lowest=0.05)
    n = (wi + wo)[:, 2] / np.linalg.norm(wi + wo, axis=1)
    apart = np.abs(gray(model)(wi, wo) * wi[:, 2] - n**gloss)
    sheet.claim(
        "f N.L of the highlight: largest difference from (N.H)^n", "<=", 1e-9, float(apart.max())
    )
    wide, narrow = (model.replace(shininess=s).albedo(directions(0.0))[0] for s in (10.0, 1000.0))
    sheet.claim(
        "albedo of a sharp highlight over that of a broad one, of one weight",
        "<=",
        "0.1",
        float(narrow / wide),
        why="the gloss alone changes how much is reflected: it is not normalised",
    )
    sheet.remark("named without a formula; the original paper's is taken")


@TEXT.item(
    "11", "section 4", "Disney's parameters: specular, tints, subsurface, anisotropic and others"
)
def disney(sheet: Sheet) -> None:
    named = ("specular", "specular_tint", "subsurface", "anisotropic", "metallic", "roughness")
    for name in named:
        sheet.claim(f"{name} is a parameter", "=", "1", float(name in gonio.Disney.fields))
    sheet.show("parameters in all", len(gonio.Disney.fields))


@TEXT.item("schlick", "section 4.2.2", "Schlick's original paper has n.v in place of h.v")
def schlick(sheet: Sheet) -> None:
    sheet.lack("a statement about another paper, which is not at hand")
    light, viewer = 60.0, 10.0
    ratio = [1 - (1 - 0.04) * (1 - (1 - math.cos(math.radians(a))) ** 5) for a in (light, viewer)]
    sheet.show(
        "F of n.v at 60 degrees over F at 10 degrees: by how much a lobe with it is not reciprocal",
        ratio[0] / ratio[1],
    )
