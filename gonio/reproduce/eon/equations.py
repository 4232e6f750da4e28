"""The equations."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np

import gonio
from gonio.arrays.elementwise import elementwise
from gonio.models import eon as eon_file
from gonio.parts import cltc, oren_nayar
from gonio.plot.cartesian import single_scattering
from gonio.reproduce.eon import TEXT
from gonio.reproduce.eon.formulas import (
    HALF_PI,
    A_fujii,
    E_fon,
    G_qualitative,
    cltc_pdf,
    coefficients,
    degrees,
    f_eon,
    f_fon,
    mean_E_fon,
    qon_angles,
    qon_coefficients,
    qon_vectors,
    white_eon,
)
from gonio.reproduce.eon.shared import fit_error, same
from gonio.reproduce.measure import (
    albedo_by_quadrature,
    directions,
    gray,
    random_pairs,
)
from gonio.reproduce.sheet import Sheet


@TEXT.item("eq1", "Eq. 1 to 4", "QON by angles, and by vectors", "eq2", "eq3", "eq4")
def equation_1(sheet: Sheet) -> None:
    for sigma in (0.3, 1.2):
        ours = gray(gonio.QON(rho=1, sigma=sigma))
        same(
            sheet, f"Eq. 1 and 2, sigma {sigma:g}", ours, lambda i, o, s=sigma: qon_angles(s, i, o)
        )
        same(
            sheet,
            f"Eq. 3 and 4, sigma {sigma:g}",
            ours,
            lambda i, o, s=sigma: qon_vectors(s, i, o),
        )


@TEXT.item(
    "eq5", "Eq. 5 to 8", "the directional albedo of QON, and its integral", "eq6", "eq7", "eq8"
)
def equation_5(sheet: Sheet) -> None:
    theta = np.radians([1, 20, 45, 70, 89])
    ours = elementwise(oren_nayar.G_qualitative, np.cos(theta))
    sheet.claim(
        "G_q: largest difference from Eq. 8 as printed",
        "<=",
        1e-11,
        float(np.abs(ours - G_qualitative(theta)).max()),
    )
    sheet.claim(
        "G_q in the horizon, where Eq. 8 is 0 / 0: the limit pi / 2",
        "=",
        HALF_PI,
        float(elementwise(oren_nayar.G_qualitative, np.array(0.0))),
        within=1e-9,
    )
    x, w = np.polynomial.legendre.leggauss(60)
    for t, G in zip(theta, ours, strict=True):
        total = 0.0
        for low, high in ((0.0, t), (t, HALF_PI)):
            a = low + (high - low) * (x + 1) / 2
            g = np.sin(np.maximum(a, t)) * np.tan(np.minimum(a, t))
            total += float(np.sum(np.sin(a) * np.cos(a) * g * w) * (high - low) / 2)
        sheet.claim(
            f"G_q at {math.degrees(t):.0f} degrees by Eq. 7, the integral over phi being 2",
            "=",
            2 * total,
            float(G),
            within=1e-9,
        )
    for angle, t in degrees(0, 50, 85):
        model = gonio.QON(rho=1, sigma=1.0)
        sheet.claim(
            f"E_q at {angle:g} degrees by quadrature of the BRDF (Eq. 5 and 6)",
            "=",
            albedo_by_quadrature(lambda i, o: qon_vectors(1.0, i, o), t),
            float(model.albedo(directions(t))[0]),
            within=1e-6,
        )


def _mean_by_quadrature(albedo: Any) -> float:
    x, w = np.polynomial.legendre.leggauss(60)
    theta = HALF_PI * (1 - ((1 - x) / 2) ** 2)  # crowded in the horizon
    step = HALF_PI * (1 - x) / 2
    return float(np.sum(w * step * 2 * np.sin(theta) * np.cos(theta) * albedo(theta)))


@TEXT.item("eq9", "Eq. 9", "the average albedo of QON: A + (2/3 - 64 / (45 pi)) B")
def equation_9(sheet: Sheet) -> None:
    for sigma in (0.2, 1.0, HALF_PI):
        A, B = qon_coefficients(sigma)
        mean = _mean_by_quadrature(lambda t, a=A, b=B: a + b / math.pi * G_qualitative(t))
        sheet.claim(
            f"mean albedo at sigma {sigma:.3g}, against the integral of Eq. 5",
            "=",
            mean,
            float(gonio.QON(rho=1, sigma=sigma).mean_albedo()[0]),
            within=1e-6,
        )
    sheet.claim(
        "the factor", "=", 2 / 3 - 64 / (45 * math.pi), oren_nayar.MEAN_G_QUALITATIVE, within=1e-15
    )


@TEXT.item("eq10", "Eq. 10 and 11", "FON, with A and B", "eq11", "eqaf")
def equation_10(sheet: Sheet) -> None:
    for r in (0.3, 1.0):
        ours = gray(gonio.FON(rho=1, roughness=r))
        same(sheet, f"f_F, r {r:g}", ours, lambda i, o, r=r: f_fon(r, i, o))
        horizon = float(gonio.FON(rho=1, roughness=r).albedo(np.array([1.0, 0, 0]))[0])
        sheet.claim(
            f"E(90 degrees) = 1, from which A and B were made, r {r:g}",
            "=",
            1,
            horizon,
            within=1e-12,
        )


@TEXT.item("eq12", "Eq. 12 and 13", "the directional albedo of FON", "eq13")
def equation_12(sheet: Sheet) -> None:
    theta = np.radians([0, 30, 50, 80, 89])
    fon = gonio.FON(rho=1, roughness=1)
    apart = np.abs(fon.albedo(directions(theta))[:, 0] - E_fon(1.0, theta)).max()
    sheet.claim("largest difference from Eq. 12 and 13 as printed", "<=", 1e-11, float(apart))
    for angle, t in degrees(0, 50, 89):
        found = albedo_by_quadrature(lambda i, o: f_fon(1.0, i, o), t)
        ours = float(fon.albedo(directions(t))[0])
        sheet.claim(f"E_F at {angle:g} degrees by quadrature", "=", found, ours, within=1e-6)


@TEXT.item("eq14", "Eq. 14", "a polynomial for G_F, and its four coefficients")
def equation_14(sheet: Sheet) -> None:
    printed = ("0.0571085289", "0.491881867", "-0.332181442", "0.0714429953")
    for k, (text, ours) in enumerate(
        zip(printed, (eon_file.G1, eon_file.G2, eon_file.G3, eon_file.G4), strict=True), 1
    ):
        sheet.claim(f"g_{k}", "=", text, ours)
    fit_error(sheet)
    low = elementwise(eon_file.loss_fitted, np.array(0.0))
    sheet.show(
        "1 - E of the fit in the horizon, r = 1, which Listing 1 clamps to 1e-7",
        float(low * A_fujii(1) / math.pi),
    )


@TEXT.item("eq15", "Eq. 15", "the average albedo of FON: A + (2/3 - 28 / (15 pi)) B")
def equation_15(sheet: Sheet) -> None:
    for r in (0.2, 1.0):
        sheet.claim(
            f"mean albedo at r {r:g}, against the integral of Eq. 12",
            "=",
            _mean_by_quadrature(lambda t, r=r: E_fon(r, t)),
            float(gonio.FON(rho=1, roughness=r).mean_albedo()[0]),
            within=1e-6,
        )
    sheet.claim(
        "the factor", "=", 2 / 3 - 28 / (15 * math.pi), oren_nayar.MEAN_G_FUJII, within=1e-15
    )


@TEXT.item("eq16", "Eq. 16, 17 and 19", "EON is FON and a multiple-scattering lobe", "eq17", "eq19")
def equation_16(sheet: Sheet) -> None:
    for rho, r in ((1.0, 1.0), (0.6, 0.4)):
        ours = gray(gonio.EON(rho=rho, roughness=r))
        same(sheet, f"f, rho {rho:g}, r {r:g}", ours, lambda i, o, p=rho, q=r: f_eon(p, q, i, o))


@TEXT.item("eq18", "Eq. 18", "the series of bounces for F, and its sum")
def equation_18(sheet: Sheet) -> None:
    rho, E = 0.7, mean_E_fon(1.0)
    closed = rho**2 * E * (1 - E) / (1 - rho * (1 - E))
    model = gonio.EON(rho=rho, roughness=1)
    ours = float((model.mean_albedo() - single_scattering(model).mean_albedo())[0])
    sheet.claim("F by the third line, rho 0.7, r 1", "=", closed, ours, within=1e-6)
    bounces = [rho ** (n + 1) * (1 - E) ** n * E for n in range(200)]
    sheet.refute(
        "F by the first line, which holds the 1-bounce term",
        "=",
        sum(bounces),
        ours,
        proof=sum(bounces[1:]),
        within=1e-6,
        why="the term rho <E> is FON's own; the sentence above says that it is omitted, and without it "
        "the lines are equal",
    )


@TEXT.item("eq20", "Eq. 20", "the albedo of multiple scattering; white EON reflects everything")
def equation_20(sheet: Sheet) -> None:
    for angle, t in degrees(0, 45, 89):
        found = albedo_by_quadrature(lambda i, o: f_eon(0.7, 1.0, i, o), t)
        ours = float(gonio.EON(rho=0.7, roughness=1).albedo(directions(t))[0])
        sheet.claim(
            f"E at {angle:g} degrees, rho 0.7, by quadrature", "=", found, ours, within=1e-6
        )
    theta = np.radians(np.linspace(0, 90, 50))
    white = np.abs(white_eon(roughness=1).albedo(directions(theta)) - 1).max()
    sheet.claim("furnace: largest |E - 1| for rho = 1", "<=", 1e-6, float(white))


@TEXT.item(
    "eq21",
    "Eq. 21 to 28",
    "LTC and CLTC: density, Jacobian, matrix, inverse, clipping plane",
    "eq22",
    "eq23",
    "eq24",
    "eq25",
    "eq26",
    "eq27",
    "eq28",
    "det",
)
def equation_21(sheet: Sheet) -> None:
    grid = list(itertools.product((0.0, 0.1, 0.5, 0.9, 0.99), (0.2, 0.6, 1.0)))
    worst = 0.0
    for mu, r in grid:
        ours = [
            float(elementwise(lambda m, q, k=k: cltc.coefficients(m, 1 - m, q)[k], mu, r))
            for k in range(4)
        ]
        worst = max(worst, float(np.abs(ours - coefficients(mu, r)).max()))
    sheet.claim("a, b, c, d: largest difference from Listing 2", "<=", 1e-9, worst)
    wi, _ = random_pairs(lowest=0.01)
    for sampler, factor in (("ltc", True), ("cltc", False)):
        apart = 0.0
        for mu, r in grid[3:]:
            wo = np.array([math.sqrt(1 - mu * mu), 0, mu])
            s = (1 + 1 / math.sqrt(1 + coefficients(mu, r)[3] ** 2)) / 2
            theirs = cltc_pdf(mu, r, wi) * (s if factor else 1)
            pdf = np.asarray(white_eon(roughness=r, sampler=sampler).pdf(wi, wo))
            apart = max(apart, float(np.abs(pdf - theirs).max()))
        sheet.claim(
            f"{sampler}: density, against Eq. 21 to 28 with NumPy's inverse", "<=", 1e-8, apart
        )
    mus, rs = np.meshgrid(np.linspace(0, 1, 101), np.linspace(0, 1, 101))
    a, b, c, d = (
        elementwise(lambda m, q, k=k: cltc.coefficients(m, 1 - m, q)[k], mus, rs) for k in range(4)
    )
    det = c * (a - b * d)
    sheet.claim("det(M) > 0 for all angles and r: the smallest", ">=", "0", float(det.min()))
    sheet.show("det(M): the largest", float(det.max()))
