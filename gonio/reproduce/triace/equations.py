"""The equations."""

from __future__ import annotations

import functools
import math

import numpy as np

import gonio
from gonio import conversions
from gonio.arrays.elementwise import elementwise
from gonio.lights import image_light
from gonio.parts import fresnel
from gonio.reproduce.measure import gray, hemisphere, largest_difference, random_pairs
from gonio.reproduce.sheet import Sheet
from gonio.reproduce.triace import TEXT, formulas

ROUNDING = 1e-11
N1, N2 = 1.33333, 1.5


@TEXT.item("eq1", "Eq. 1", "physically based Blinn-Phong: 0.0397436 n + 0.0856832")
def equation_1(sheet: Sheet) -> None:
    for n in (1.0, 20.0, 300.0):
        ours = gray(gonio.TriAceBlinnPhong(rho=0.6, f0=0.05, shininess=n))
        difference = largest_difference(ours, functools.partial(formulas.blinn_phong, 0.6, 0.05, n))
        sheet.claim(f"n {n:g}: largest difference from Eq. 1", "<=", 1e-10 * max(n, 1), difference)
    for n in (1, 10, 100):
        exact = (n + 2) / (4 * math.pi * (2 - 2 ** (-n / 2)))
        sheet.show(
            f"factor over the one that normalises, n {n}", (0.0397436 * n + 0.0856832) / exact
        )


@TEXT.item("eq2", "Eq. 2", "exact absorption: exp(-alpha d (1 / cos + 1 / cos)), refracted angles")
def equation_2(sheet: Sheet) -> None:
    """The layer's absorption is the ratio of what is below with it to what is below without."""
    _absorption(
        sheet,
        "exact",
        lambda d, wi, wo: np.exp(-d * sum(1 / formulas.refracted(w[..., 2], N1) for w in (wi, wo))),
    )


@TEXT.item("eq3", "Eq. 3", "approximate absorption: max(0, 1 - alpha' (1 / N.L + 1 / N.E))")
def equation_3(sheet: Sheet) -> None:
    _absorption(
        sheet,
        "linear",
        lambda d, wi, wo: np.maximum(0, 1 - d * sum(1 / w[..., 2] for w in (wi, wo))),
    )


def _absorption(sheet: Sheet, form: str, printed: object) -> None:
    depth = 0.15
    clear = gonio.model("triace_layered", top_shininess=0, absorption=form)
    top = gonio.TriAceLayered(top_shininess=0, absorption="exact", sigma_a=10, thickness=1)
    wi, wo = random_pairs(lowest=0.15)
    tinted = gray(clear.replace(sigma_a=depth))(wi, wo)
    upper = formulas.schlick(formulas.f0(1, N1), formulas.half(wi, wo)[1]) * formulas.highlight(
        0, wi, wo
    )
    below = gray(clear)(wi, wo) - upper
    theirs = upper + below * printed(depth, wi, wo)  # type: ignore[operator]
    apart = float(np.abs(tinted - theirs).max())
    sheet.claim(f"{form}: largest difference from the equation", "<=", ROUNDING, apart)
    black = float(np.abs(gray(top)(wi, wo) - upper).max())
    sheet.claim("nothing comes from below a layer of depth 10", "<=", 1e-8, black)


@TEXT.item("eq4", "Eq. 4", "Fresnel of the bottom layer: (1 - F(n1)) F(n2 / n1) (1 - F(1 / n1))")
def equation_4(sheet: Sheet) -> None:
    _bottom(sheet, "exact")


@TEXT.item("eq5", "Eq. 5", "the same by two constants, F_trans = 1 - F(n1)")
def equation_5(sheet: Sheet) -> None:
    _bottom(sheet, "constant")


def _bottom(sheet: Sheet, form: str) -> None:
    """With a black diffuse part, what is below the upper highlight is the lower one times the factor."""
    model = gonio.model(
        "triace_layered", rho=0, bottom_fresnel=form, top_shininess=0, bottom_shininess=30
    )
    wi, wo = random_pairs(lowest=0.1)
    _, cos_h = formulas.half(wi, wo)
    top = formulas.schlick(formulas.f0(1, N1), cos_h)
    if form == "exact":
        factor = formulas.bottom_exact(N1, N2, cos_h)
    else:
        factor = (1 - top) * formulas.bottom_constant(N1, N2)
    theirs = top * formulas.highlight(0, wi, wo) + factor * formulas.highlight(30, wi, wo)
    apart = float(np.abs(gray(model)(wi, wo) - theirs).max())
    sheet.claim(f"{form}: largest difference from the equation", "<=", ROUNDING, apart)
    if form == "exact":
        cos = np.linspace(0.05, 1, 30)
        inside = formulas.refracted(cos, N1)
        ways = float(np.abs(formulas.fresnel(1, N1, cos) - formulas.fresnel(N1, 1, inside)).max())
        sheet.show("largest difference of F(n1) and F(1 / n1), which are the same number", ways)


@TEXT.item(
    "eq6", "Eq. 6 and 7", "absorption of a mirrored picture: max(0, 1 - 2 alpha' / N.E)", "eq7"
)
def equation_6(sheet: Sheet) -> None:
    for x in (1.0, 0.5, 0.2):
        printed = max(0.0, 1 - 0.1 * (1 / x + 1 / x))
        ours = float(elementwise(image_light.specular_image_absorption, 0.1, x))
        sheet.claim(f"what is left at N.E {x:g}, alpha' 0.1", "=", printed, ours, within=1e-12)


@TEXT.item(
    "eq8", "Eq. 8 and 9", "the hemispherical mean of 1 / cos + 1 / cos is 2 + 1 / cos", "eq9"
)
def equation_8(sheet: Sheet) -> None:
    for x in (1.0, 0.5, 0.2):
        over = hemisphere(math.acos(x))
        mean = over.reflected(1 / over.wi[:, 2] + 1 / x) / math.pi
        sheet.claim(f"mean at N.E {x:g}, by quadrature", "=", 2 + 1 / x, mean, within=1e-6)
        printed = max(0.0, 1 - 0.1 * (2 + 1 / x))
        ours = float(elementwise(image_light.diffuse_image_absorption, 0.1, x))
        sheet.claim(
            "what is left of diffuse light there, alpha' 0.1", "=", printed, ours, within=1e-12
        )


@TEXT.item(
    "eq10",
    "Eq. 10 to 20",
    "the qualitative Oren-Nayar model, rewritten until it has no angles",
    *(f"eq{n}" for n in range(11, 21)),
)
def equation_10(sheet: Sheet) -> None:
    wi, wo = random_pairs(lowest=0.02)
    sigma = 0.6
    ours = gray(gonio.QON(rho=1, sigma=sigma))(wi, wo)
    v = sigma**2
    A, B = 1 - 0.5 * v / (v + 0.33), 0.45 * v / (v + 0.09)
    theta_i, theta_o = np.arccos(wi[:, 2]), np.arccos(wo[:, 2])
    phi = np.arctan2(wi[:, 1], wi[:, 0]) - np.arctan2(wo[:, 1], wo[:, 0])
    low, high = np.minimum(theta_i, theta_o), np.maximum(theta_i, theta_o)
    roots = np.sqrt((1 - wi[:, 2] ** 2) * (1 - wo[:, 2] ** 2))
    tangents = [w[:, :2] / np.linalg.norm(w[:, :2], axis=1, keepdims=True) for w in (wi, wo)]
    cos_phi = np.sum(tangents[0] * tangents[1], axis=1)
    forms = {
        "Eq. 10, angles": A + B * np.maximum(0, np.cos(phi)) * np.sin(high) * np.tan(low),
        "Eq. 12, projected vectors": A
        + B * np.maximum(0, cos_phi) * roots / np.maximum(wi[:, 2], wo[:, 2]),
        "Eq. 15, with min(1, N.L / N.E)": A
        + B * np.maximum(0, cos_phi) * roots * np.minimum(1, wi[:, 2] / wo[:, 2]) / wi[:, 2],
        "Eq. 20": formulas.eq20(sigma, wi, wo) * math.pi,
    }
    for name, value in forms.items():
        apart = float(np.abs(ours - value / math.pi).max())
        sheet.claim(f"{name}: largest difference", "<=", ROUNDING, apart)
    identity = (formulas.tangential(wi, wo) / roots - cos_phi)[roots > 0.05]
    sheet.claim("Eq. 17 and 18: largest difference", "<=", ROUNDING, float(np.abs(identity).max()))


@TEXT.item("eq21", "Eq. 21", "sigma = sqrt(2 / shininess)")
def equation_21(sheet: Sheet) -> None:
    for n in (2.0, 10.0, 100.0):
        ours = conversions.sigma_from_shininess(n)
        sheet.claim(f"sigma of shininess {n:g}", "=", math.sqrt(2 / n), ours, within=1e-12)


@TEXT.item(
    "eq22", "Eq. 22 and 23", "the qualitative model by the shininess: 0.33, 2.22222, 0.1", "eq23"
)
def equation_22(sheet: Sheet) -> None:
    for n in (3.0, 40.0):
        ours = gray(gonio.TriAceOrenNayar(rho=1, shininess=n, variant="eq23"))
        exact = largest_difference(ours, functools.partial(formulas.eq23, n))
        sheet.claim(f"Eq. 23, shininess {n:g}: largest difference", "<=", ROUNDING, exact)
        before = largest_difference(ours, functools.partial(formulas.eq20, math.sqrt(2 / n)))
        sheet.claim(
            f"Eq. 22 with sigma^2 = 2 / n, shininess {n:g}: largest difference",
            "<=",
            1e-4,
            before,
            why="2.22222 is printed for 20 / 9; Eq. 22 divides by cosines down to 0.02",
        )


@TEXT.item("eq24", "Eq. 24", "without the max, with 0.65")
def equation_24(sheet: Sheet) -> None:
    ours = gray(gonio.TriAceOrenNayar(rho=1, shininess=8, variant="eq24"))
    difference = largest_difference(ours, lambda i, o: formulas.eq24(8, i, o))
    sheet.claim("largest difference", "<=", ROUNDING, difference)


@TEXT.item("eq25", "Eq. 25", "N.L in place of the min where light comes from behind")
def equation_25(sheet: Sheet) -> None:
    ours = gray(gonio.TriAceOrenNayar(rho=1, shininess=8))
    difference = largest_difference(ours, lambda i, o: formulas.eq25(8, i, o))
    sheet.claim("largest difference", "<=", ROUNDING, difference)


@TEXT.item("eq26", "Eq. 26", "the integral of the shading model over the direction of the light")
def equation_26(sheet: Sheet) -> None:
    for n, x in ((8.0, 0.9), (8.0, 0.3), (2.0, 0.05)):
        ours = float(elementwise(image_light.in_plane_integral, x, n))
        sheet.claim(
            f"shininess {n:g}, N.E {x:g}: in the plane of the viewer, by Gauss's rule",
            "=",
            formulas.in_plane(n, x),
            ours,
            within=1e-9,
        )
    albedo = float(gonio.TriAceOrenNayar(rho=1, shininess=2).albedo(np.array([1.0, 0, 0]))[0])
    sheet.show(
        "the same at N.E 0, shininess 2",
        float(elementwise(image_light.in_plane_integral, 0.0, 2.0)),
    )
    sheet.show("the hemispherical integral there, which is the albedo", albedo)
    sheet.remark(
        "the text does not say over what the integral goes; its figures show the one in the plane"
    )


def _fits(sheet: Sheet, ours: object, printed: object, what: str) -> None:
    x = np.linspace(0, 1, 101)
    for sigma in (0.5, 1.0):
        n = formulas.shininess(sigma)
        found = elementwise(ours, x, n)  # type: ignore[arg-type]
        apart = float(np.abs(found - printed(n, x)).max())  # type: ignore[operator]
        sheet.claim(
            f"{what}, sigma {sigma:g}: largest difference from the equation", "<=", 1e-9, apart
        )


def rms(sigma: float, scale: object) -> float:
    """Of a scale of the constant harmonic from the integral that it fits."""
    x, n = np.linspace(0, 1, 41), formulas.shininess(sigma)
    exact = np.array([formulas.in_plane(n, float(c)) for c in x])
    return float(np.sqrt(np.mean((elementwise(scale, x, n) - exact) ** 2)))  # type: ignore[arg-type]


@TEXT.item("eq27", "Eq. 27", "scale of the constant harmonic, with an arc cosine")
def equation_27(sheet: Sheet) -> None:
    _fits(sheet, image_light.harmonic_dc_scale, formulas.dc_scale, "Eq. 27")
    for sigma in (0.5, 1.0):
        found = rms(sigma, image_light.harmonic_dc_scale)
        sheet.claim(f"rms from Eq. 26, sigma {sigma:g}", "<=", "0.03", found, why='"good enough"')
    sheet.remark("the signs are lost in the text at hand; of all eight choices these fit best")


@TEXT.item("eq28", "Eq. 28", "the compromise f + g (1 - N.E)")
def equation_28(sheet: Sheet) -> None:
    _fits(sheet, image_light.harmonic_dc_scale_cheap, formulas.dc_scale_cheap, "Eq. 28")
    for sigma in (0.5, 1.0):
        ratio = rms(sigma, image_light.harmonic_dc_scale_cheap) / rms(
            sigma, image_light.harmonic_dc_scale
        )
        sheet.claim(
            f"rms over that of Eq. 27, sigma {sigma:g}", ">=", "1", ratio, why="not as good"
        )


@TEXT.item("eq29", "Eq. 29", "scale of the linear harmonics: S = f + (f - 1)(1 - N.E)")
def equation_29(sheet: Sheet) -> None:
    _fits(sheet, image_light.harmonic_linear_scale, formulas.linear_scale, "Eq. 29")
    smooth = float(elementwise(image_light.harmonic_linear_scale, 0.0, 1e12))
    sheet.claim("S at sigma 0, N.E 0", "=", "1.0", smooth)


@TEXT.item("f0", "section 2", "F0(n): reflectance at the normal")
def normal_reflectance(sheet: Sheet) -> None:
    for n in (N1, N2):
        ours = float(elementwise(fresnel.f0_from_eta, np.array(n)))
        sheet.claim(f"F0({n:g})", "=", formulas.f0(1, n), ours, within=1e-12)
