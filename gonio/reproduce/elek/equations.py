"""The equations and the code."""

from __future__ import annotations

import functools
import math
from typing import Any

import numpy as np

import gonio
from gonio import plot
from gonio.arrays.elementwise import elementwise
from gonio.bake import environment
from gonio.parts import interface, metals, tilt
from gonio.reproduce.elek import TEXT, formulas
from gonio.reproduce.measure import Floats, directions, gray, hemisphere, random_pairs
from gonio.reproduce.sheet import Sheet

ROUNDING = 1e-9

TEXT.lacking(
    "appa",
    "Appendix A",
    "selected coefficients of materials",
    "the table is not in the text at hand; gonio takes the indices of metals from measurements",
)


@TEXT.item("1", "Figure 1", "the recursive scheme of evaluation")
def scheme(sheet: Sheet) -> None:
    """Two coats over a base: the whole is Eq. 2 with the inner coat as its base, and that again."""
    wi, wo = random_pairs(300, lowest=0.2)
    depths = []

    def base(depth: int) -> Any:
        def value(i: Floats, o: Floats) -> Floats:
            depths.append(depth)
            if depth == 0:
                return np.full(i.shape[:-1], 0.6 / math.pi)
            return formulas.layered(1.2, 0.3, 0.1, base(depth - 1), i, o, formulas.conductor)

        return value

    printed = base(2)(wi, wo)
    coats: Any = gonio.Lambert(rho=0.6)
    for _ in range(2):
        # sigma_a times thickness is the paper's sigma d
        coats = gonio.WeidlichWilkie(eta=1.2, alpha=0.3, sigma_a=0.1, thickness=1.0, base=coats)
    ours = gray(coats)(wi, wo)
    sheet.claim("levels that one value of two coats goes through", "=", "3", len(set(depths)))
    sheet.claim(
        "largest difference from Eq. 2 to 4, applied twice by hand, over the largest value",
        "<=",
        ROUNDING,
        float(np.abs(ours - printed).max() / printed.max()),
    )


def white_facets(m: float) -> Any:
    """Torrance-Sparrow with F = 1, Beckmann and V-cavities."""
    return gonio.TorranceSparrow(
        alpha=m, distribution="beckmann", masking="cook_torrance", fresnel="white"
    )


def _white_albedo(m: float, factor: float = 1.0) -> float:
    over = hemisphere(0.0, 96)
    up = np.broadcast_to(directions(0), over.wi.shape)
    return factor * over.reflected(formulas.torrance_sparrow(m, 1.0, over.wi, up))


@TEXT.item("eq1", "Eq. 1", "f = F D G / (pi (N.L)(N.V))")
def equation_1(sheet: Sheet) -> None:
    for m in (0.1, 0.3):
        ours = float(white_facets(m).albedo(directions(0))[0])
        printed = _white_albedo(m, 4.0)
        sheet.refute(
            f"white albedo at the normal, m {m:g}",
            "=",
            printed,
            ours,
            proof=_white_albedo(m),
            within=1e-3,
            why="F D G / (pi cos cos) with a D that lacks 1 / pi is 4 times F D G / (4 cos cos) "
            "with one that "
            "has it; it would reflect four times what arrives",
        )


@TEXT.item("eq-d", "section 2.1", "Beckmann's D = exp(-(tan / m)^2) / (m^2 cos^4)")
def equation_d(sheet: Sheet) -> None:
    over = hemisphere(0.0, 64)
    printed = over.reflected(formulas.D(0.3, over.wi[:, 2]))
    ours = over.reflected(plot.facet_terms(white_facets(0.3), over.wi, over.wi)["D"])
    sheet.refute(
        "the integral of D cos, m 0.3",
        "=",
        printed,
        ours,
        proof=1.0,
        within=1e-6,
        why="facets cover the surface once: the integral must be 1; the 1 / pi of Eq. 1 stands for it",
    )
    n = np.cos(np.linspace(0, 1.2, 20))
    m = directions(np.arccos(n))
    apart = float(
        np.abs(plot.facet_terms(white_facets(0.3), m, m)["D"] * math.pi - formulas.D(0.3, n)).max()
    )
    sheet.claim("pi D: largest difference from the printed formula", "<=", ROUNDING, apart)


def _lambert(wi: Floats, wo: Floats) -> Floats:
    return np.full(wi.shape[:-1], 1 / math.pi)


def _coat(**given: Any) -> gonio.Model:
    base = gonio.Lambert(rho=1)
    return gonio.WeidlichWilkie(eta=1.5, alpha=0.2, fresnel="lazanyi", base=base, **given)


@TEXT.item(
    "eq2", "Eq. 2 to 4", "the layers' recurrence, absorption, internal reflection", "eq3", "eq4"
)
def equation_2(sheet: Sheet) -> None:
    wi, wo = random_pairs(2000, lowest=0.05)
    for sigma in (0.0, 0.4):
        theirs = formulas.layered(1.5, 0.2, sigma, _lambert, wi, wo)
        ours = gray(_coat(sigma_a=sigma, thickness=1))(wi, wo)
        apart = float(np.abs(ours - theirs).max())
        sheet.claim(
            f"over white Lambert, sigma d {sigma:g}: largest difference", "<=", ROUNDING, apart
        )
    inner = functools.partial(formulas.layered, 1.2, 0.3, 0.1, _lambert)
    theirs = formulas.layered(1.5, 0.2, 0.4, inner, wi, wo)
    second = gonio.WeidlichWilkie(
        eta=1.2, alpha=0.3, fresnel="lazanyi", sigma_a=0.1, base=gonio.Lambert(rho=1)
    )
    ours = gray(_coat(sigma_a=0.4).replace(base=second))(wi, wo)
    sheet.claim("two coats: largest difference", "<=", ROUNDING, float(np.abs(ours - theirs).max()))


@TEXT.item("alg1", "Algorithm 1", "the layered shader, two layers and an environment")
def algorithm_1(sheet: Sheet) -> None:
    base = white_facets(0.3)
    model = _coat().replace(base=base)
    for angle in (60, 85, 89):
        wi, wo = directions(math.radians(angle)), directions(math.radians(-angle))
        inside = formulas.refracted(wi[None].copy(), 1.5)[0, 2]
        coat = formulas.torrance_sparrow(
            0.2, formulas.lazanyi(formulas.half(wi, wo)[1], 1.5), wi, wo
        )
        below = float(gray(model)(wi, wo) - coat)
        as_code = below * inside / wi[2]  # weighted by N.L' where the light's cosine is N.L
        theirs = float(
            formulas.layered(
                1.5,
                0.2,
                0.0,
                functools.partial(formulas.torrance_sparrow, 0.3, 1.0),
                wi[None],
                wo[None],
            )[0]
            - coat
        )
        sheet.refute(
            f"the lower highlight at mirror pairs of {angle} degrees",
            "=",
            as_code,
            below,
            proof=theirs,
            within=1e-6 * abs(theirs),
            why="the function of Appendix B returns f times its own cosine N.L', but light "
            "arrives with N.L; "
            "Eq. 2 has no such factor",
        )
    n1, k1 = (2.95, 1.4, 3.03), (0.1, 0.0, 0.67)
    coloured = model.replace(
        fresnel="lazanyi_conductor", mirror_eta=n1, mirror_k=k1, sigma_a=(0.1, 0.4, 2.0)
    )
    pairs = random_pairs(2000, lowest=0.05)
    ours = np.asarray(coloured.eval(*pairs))
    metal = functools.partial(formulas.torrance_sparrow, 0.3, 1.0)
    for i, (channel, sigma) in enumerate(
        zip(("red", "green", "blue"), (0.1, 0.4, 2.0), strict=True)
    ):

        def F1(cos: Floats, _: float, i: int = i) -> Floats:
            return formulas.lazanyi(cos, n1[i], k1[i])

        expected = formulas.layered(1.5, 0.2, sigma, metal, *pairs, F1)
        apart = float((np.abs(ours[:, i] - expected) / (1 + expected)).max())
        sheet.claim(
            f"n1 and kappa1 of each channel, refraction by 1.5, {channel}: largest difference",
            "<=",
            ROUNDING,
            apart,
            why="relative where f is above 1",
        )


@TEXT.item("alg1-refract", "Algorithm 1, lines 8 and 9", "L' = -refract(L, N, 1 / n1)")
def refraction(sheet: Sheet) -> None:
    w = directions(0.7, 0.3)
    L = -w
    cos = w[2]
    t = -w / 1.5 + np.array([0, 0, cos / 1.5 - math.sqrt(1 - (1 - cos**2) / 1.5**2)])
    printed = -(L / 1.5 * -1 + np.array([0, 0, -cos / 1.5 - math.sqrt(1 - (1 - cos**2) / 1.5**2)]))
    ours = elementwise(lambda x, y, z: interface.refract(gonio.lang.vec3(x, y, z), 0.5).x, *w)
    sheet.refute(
        "x of the refracted direction towards the light, over x outside",
        "=",
        float(printed[0] / w[0]),
        float(ours / w[0]),
        proof=1 / 1.5,
        within=1e-9,
        why="Snell's law keeps the tangential part over n; refract() takes the incoming ray, "
        "and its negative "
        "points to the other side, which turns an anisotropic base by 180 degrees",
    )
    sheet.show("length of the refracted ray by Snell's law", float(np.linalg.norm(t)))


@TEXT.item(
    "alg1-diffuse", "Algorithm 1, line 23", "(1 - F2) max(N.L, 0) diffuseMap: a matte part below"
)
def diffuse(sheet: Sheet) -> None:
    facets: dict[str, Any] = {
        "distribution": "beckmann",
        "masking": "cook_torrance",
        "fresnel": "lazanyi",
    }
    metal = gonio.TorranceSparrow(alpha=0.3, eta=1.8, k=0.9, diffuse="lambert", rho=0.6, **facets)

    def printed(wi: Floats, wo: Floats) -> Floats:
        F2 = formulas.lazanyi(formulas.half(wi, wo)[1], 1.8, 0.9)
        return formulas.torrance_sparrow(0.3, F2, wi, wo) + (1 - F2) * 0.6 / math.pi

    wi, wo = random_pairs(2000, lowest=0.05)
    theirs = formulas.layered(1.5, 0.2, 0.4, printed, wi, wo)
    ours = gray(_coat(sigma_a=0.4).replace(base=metal))(wi, wo)
    sheet.claim(
        "a coat over facets over a matte part: largest difference",
        "<=",
        ROUNDING,
        float(np.abs(ours - theirs).max()),
    )
    sheet.remark("a BRDF: the light's factor pi, and its cosine, are not in it")


@TEXT.item("alg1-env", "Algorithm 1, lines 28, 29, 31", "F1(N.V) times the blurred environment")
def environment_line(sheet: Sheet) -> None:
    constant = environment.Environment(np.ones((9, 18, 3)))
    normals = directions(np.array([0.0, 0.6, 1.2]))
    viewer = np.array([0.0, 0.0, 1.0])
    ours = environment.coat_reflection(constant, normals, viewer, 1.5)[:, 0]
    for n, value in zip(normals, ours, strict=True):
        printed = float(formulas.conductor(np.array(n[2]), 1.5))
        sheet.claim(
            f"in a white environment at N.V {n[2]:.3g}", "=", printed, float(value), within=1e-5
        )


@TEXT.item("appb", "Appendix B", "TorranceSparrow(): returns F D G / (4 N.V)")
def appendix_b(sheet: Sheet) -> None:
    wi, wo = random_pairs(2000, lowest=0.05)
    model = gonio.TorranceSparrow(
        alpha=0.25,
        eta=2.0,
        k=3.0,
        distribution="beckmann",
        masking="cook_torrance",
        fresnel="lazanyi",
    )
    n, h = formulas.half(wi, wo)
    code = formulas.lazanyi(h, 2.0, 3.0) * formulas.D(0.25, n) * formulas.G(wi, wo) / (4 * wo[:, 2])
    apart = np.abs(math.pi * gray(model)(wi, wo) * wi[:, 2] - code) / np.maximum(code, 1e-6)
    sheet.claim("pi f N.L: largest relative difference", "<=", 1e-8, float(apart.max()))


@TEXT.item("code-extent", "section 4.2", "extentFactor = 1 - smoothstep(extent - transition, ...)")
def extent(sheet: Sheet) -> None:
    """The share of the coated metal, told by two models that differ in it alone."""
    wi, wo = directions(0.5), directions(0.4, 2.5)
    bare, grown = (_patina(extent=e).eval(wi, wo)[0] for e in (-1.0, 2.0))
    for value in (0.1, 0.5, 0.8):
        mixed = _patina(growth=value).eval(wi, wo)[0]
        ours = float((mixed - bare) / (grown - bare))
        printed = 1 - formulas.smoothstep(0.45 - 0.65, 0.45 + 0.65, value)
        sheet.claim(
            f"at a map of {value:g}, extent 0.45, transition 0.65", "=", printed, ours, within=1e-6
        )


def _patina(**given: Any) -> gonio.Model:
    """One whose metal does not change as the patina grows."""
    cuprite = {"metal_eta": 2.7, "metal_k": 0.2, "coat_eta": 2.7, "coat_k": 0.2}
    widths = {"alpha": 0.3, "bare_alpha": 0.3, "grown_alpha": 0.3}
    return gonio.Patina(**({"extent": 0.45, "transition": 0.65} | cuprite | widths | given))


@TEXT.item("code-patina", "section 4.2", "patinaDiffuse = (1 - sigma)(1 - F1) max(N.L, 0)")
def patina_diffuse(sheet: Sheet) -> None:
    wi, wo = directions(0.9), directions(0.2, 1.5)
    f = [float(_patina(extent=2.0, sigma_a=s, thickness=5).eval(wi, wo)[0]) for s in (0.6, 1.0)]
    F = float(formulas.conductor(formulas.half(wi, wo)[1], 2.7, 0.2))
    # What passes a depth of 3 or more, twice, from below is less than 0.0025 of it
    sheet.claim(
        "diffuse part for sigma 0.6",
        "=",
        0.4 * (1 - F) / math.pi,
        f[0] - f[1],
        within=2e-3,
        why="what else comes through so thick a patina",
    )


@TEXT.item("code-paint", "section 4.1", "N += max(distance, 1) z + flake: the normal of a flake")
def flake_normal(sheet: Sheet) -> None:
    slope = math.tan(math.radians(30))
    x, z = (float(elementwise(lambda s, d, i=i: _component(s, d, i), slope, 1.0)) for i in (0, 2))
    printed = math.degrees(
        math.atan2(math.sin(math.radians(30)), 1 + 1 + math.cos(math.radians(30)))
    )
    sheet.claim(
        "tilt of a flake of 30 degrees at distance 1",
        "=",
        printed,
        math.degrees(math.atan2(x, z)),
        within=1e-6,
        why="the normal so far, its multiple by the distance, and the flake's are added",
    )


def _component(slope: Any, distance: Any, i: int) -> Any:
    return tilt.flake_normal_added(slope, 0 * slope, distance)[i]


@TEXT.item(
    "ior",
    "section 4.2",
    "the patina mixes m2, and the index of the environment reflection (line 28)",
)
def patina_index(sheet: Sheet) -> None:
    """Under a grown patina that absorbs nothing there still is copper, whose red outshines its blue."""
    wi, wo = directions(0.3), directions(0.3, math.pi)
    clear = gonio.Patina(extent=2.0, sigma_a=1.0, thickness=0.0, tarnish=0.0, alpha=0.3)
    cuprite = metals.metal("Cu2O", neutral=True)
    surface = clear.replace(thickness=5.0).eval(wi, wo)
    below = clear.eval(wi, wo) - surface
    copper = metals.metal("Cu")
    F = [float(formulas.conductor(np.array(1.0), copper["eta"][i], copper["k"][i])) for i in (0, 2)]
    sheet.show(
        "F0 of cuprite, red",
        float(formulas.conductor(np.array(1.0), cuprite["eta"][0], cuprite["k"][0])),
    )
    sheet.claim(
        "red over blue of what comes from below, which is copper's at the least",
        ">=",
        0.8 * F[0] / F[1],
        float(below[0] / below[2]),
    )
