"""What the sentences say."""

from __future__ import annotations

import functools

import numpy as np

import gonio
from gonio.arrays.elementwise import elementwise
from gonio.bake import split_sum
from gonio.lights import image_light
from gonio.materials import load
from gonio.model import Model
from gonio.parts import distribution
from gonio.reproduce.measure import albedo_by_quadrature, directions, gray
from gonio.reproduce.sheet import Sheet
from gonio.reproduce.triace import TEXT, formulas


@TEXT.item(
    "fn1",
    "footnote 1",
    "the integral shows that energy is not conserved for a narrow range of sigma",
)
def footnote_1(sheet: Sheet) -> None:
    horizon = directions(np.pi / 2 - 1e-4)
    for sigma, relation in ((0.2, ">="), (1.0, "<=")):
        n = formulas.shininess(sigma)
        albedo = float(gonio.TriAceOrenNayar(rho=1, shininess=n).albedo(horizon)[0])
        sheet.claim(f"true albedo at grazing, sigma {sigma:g}", relation, "1", albedo)
    n = formulas.shininess(1.0)
    x = 0.05
    plotted = float(elementwise(image_light.in_plane_integral, x, n))
    sheet.refute(
        "the plotted integral at sigma 1, N.E 0.05, where the model conserves energy",
        "<=",
        "1",
        plotted,
        proof=formulas.in_plane(n, x),
        within=1e-9,
        why="it goes over the plane of incidence, and exceeds 1, Lambert's value, at every sigma; what "
        " the footnote says is true of the hemisphere, and cannot be read from Figure 7",
    )
    found = albedo_by_quadrature(functools.partial(formulas.eq25, n), np.arccos(x))
    ours = float(gonio.TriAceOrenNayar(rho=1, shininess=n).albedo(directions(np.arccos(x)))[0])
    sheet.claim("true albedo there, by quadrature of Eq. 25", "=", found, ours, within=1e-6)


@TEXT.item("s", "section 3", "S is 0.7 at sigma 1, N.E 0, and 0.4 at N.E 1")
def swapped(sheet: Sheet) -> None:
    n = formulas.shininess(1.0)
    for x, text in ((0.0, "0.7"), (1.0, "0.4")):
        sheet.refute(
            f"S at N.E {x:g}",
            "=",
            text,
            float(elementwise(image_light.harmonic_linear_scale, x, n)),
            proof=float(formulas.linear_scale(n, np.array(x))),
            within=0.01,
            why="Eq. 29 gives f at N.E 1, 2 f - 1 at N.E 0: the sentence swaps them, Figure 10 does not",
        )


@TEXT.item("halve", "Figure 10", "for the average case halve the effect of Eq. 29")
def halve(sheet: Sheet) -> None:
    n = formulas.shininess(1.0)
    S = elementwise(image_light.harmonic_linear_scale, np.array([0.0, 1.0]), n)
    for x, value in zip((0, 1), S, strict=True):
        sheet.show(f"(1 + S) / 2 at N.E {x}, sigma 1", float((1 + value) / 2))
    sheet.remark(
        "advice without a number: gonio's S, and the mean of it and 1 that the advice gives"
    )


@TEXT.item(
    "30", "section 3", "for shininess below 30 a matte diffuse part matters more than the highlight"
)
def shininess_30(sheet: Sheet) -> None:
    wo = directions(0.6)
    highlight = float(gonio.TriAceBlinnPhong(rho=0, f0=0.04, shininess=30).albedo(wo)[0])
    matte = float(gonio.TriAceOrenNayar(rho=0.5, shininess=30).albedo(wo)[0])
    sheet.claim(
        "albedo of the highlight over that of the matte part, shininess 30",
        "<=",
        "1",
        highlight / matte,
    )


@TEXT.item("modified", "section 2", "the approximated absorption has a modified coefficient")
def modified(sheet: Sheet) -> None:
    near = {}
    for form in ("exact", "linear"):
        model = gonio.model("triace_layered", top_shininess=0, sigma_a=0.01, absorption=form)
        clear = model.replace(sigma_a=0)
        up = directions(0)
        near[form] = float(clear.eval(up, up)[0] - model.eval(up, up)[0])
    sheet.claim(
        "thin layers at the normal: absorbed light of the linear form over the exact one's",
        "=",
        "1",
        near["linear"] / near["exact"],
        within=0.02,
        why="exp(-x) is 1 - x for thin layers; so one number sigma_a times thickness serves both",
    )


@TEXT.item("mul", "Eq. 23", "all squares and two multiplications are removed from Eq. 20")
def multiplications(sheet: Sheet) -> None:
    n = 10.0
    printed = formulas.eq23(n, directions(0.5), directions(0.9))
    before = formulas.eq20((2 / n) ** 0.5, directions(0.5), directions(0.9))
    sheet.claim("the two equations at one pair", "=", float(before), float(printed), within=1e-6)


@TEXT.item(
    "skin", "section 4", "skin: a top layer of oil or sweat over a matte base with Oren-Nayar"
)
def skin(sheet: Sheet) -> None:
    material = load("skin")
    model = material if isinstance(material, Model) else material.model
    top, bottom = (float(getattr(model, name)) for name in ("top_shininess", "bottom_shininess"))
    sheet.claim("shininess of the oil over that of the base", ">=", "1", top / bottom)
    sheet.claim(
        "the base is Oren-Nayar", "=", "1", float(getattr(model, "diffuse", "") == "oren_nayar")
    )


@TEXT.item("two", "section 2", "only dual-layered models")
def two(sheet: Sheet) -> None:
    names = [name for name in gonio.TriAceLayered.fields if name.endswith("_shininess")]
    sheet.claim("highlights of the layered model", "=", "2", len(names))


TEXT.lacking(
    "bent",
    "section 3",
    "bend the normal for retro-reflection with high-order harmonics",
    "an idea that the text gives no formula for",
)


@TEXT.item("ambient", "section 2", "AmbientBRDF of Gotanda 2010 for the image-based highlight")
def ambient(sheet: Sheet) -> None:
    model = gonio.TriAceBlinnPhong(rho=0, f0=0.04, shininess=50)
    alpha = float(elementwise(distribution.blinn_phong_alpha, np.array(50.0)))
    for angle in (0, 60, 80):
        theta = np.radians(angle)
        A, B = split_sum.split_sum(model, np.cos(theta), alpha)
        exact = albedo_by_quadrature(lambda wi, wo: gray(model)(wi, wo), theta)
        sheet.claim(
            f"f0 A + B of the table over the highlight's albedo, shininess 50, {angle} degrees",
            "=",
            "1",
            float(0.04 * A + B) / exact,
            within=0.01,
            why="a lattice of 2,048 samples; the table itself is not in this text, what it holds is",
        )
