"""What the sentences say."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

import gonio
from gonio.reproduce.eon import TEXT
from gonio.reproduce.eon.formulas import (
    CLAY,
    HALF_PI,
    ROUNDING,
    cltc_pdf,
    coefficients,
    degrees,
    f_eon,
    qon_coefficients,
    qon_vectors,
    uniform_share,
    white_eon,
)
from gonio.reproduce.eon.shared import same
from gonio.reproduce.measure import (
    Floats,
    albedo_by_quadrature,
    directions,
    gray,
    random_pairs,
    weights,
)
from gonio.reproduce.sheet import Sheet


@TEXT.item("fn1", "footnote 1", "0.57 in place of 0.33")
def footnote_1(sheet: Sheet) -> None:
    ours = gray(gonio.model("qon_footnote", rho=1, sigma=0.8))
    same(sheet, "f, sigma 0.8", ours, lambda i, o: qon_vectors(0.8, i, o, 0.57))


def _highest_albedo(model: Any, sigmas: Floats) -> tuple[float, float]:
    """The largest albedo near the horizon, and its sigma."""
    found = [
        float(model(rho=1, sigma=s).albedo(directions(math.radians(89.99)))[0]) for s in sigmas
    ]
    k = int(np.argmax(found))
    return found[k], float(sigmas[k])


@TEXT.item(
    "energy-qon", "section 2.1", 'QON\'s albedo exceeds 1 "for grazing angles and high sigma"'
)
def energy_qon(sheet: Sheet) -> None:
    horizon = directions(HALF_PI)
    rough = float(gonio.QON(rho=1, sigma=HALF_PI).albedo(horizon)[0])
    A, B = qon_coefficients(HALF_PI)
    sheet.refute(
        "albedo in the horizon at sigma = pi / 2",
        ">=",
        "1",
        rough,
        proof=A + B / 2,
        within=1e-6,
        why="the limit of Eq. 5 and 8 is A + B / 2; it is above 1 for small sigma only",
    )
    sigmas = np.linspace(0.01, HALF_PI, 400)
    highest, at = _highest_albedo(gonio.QON, sigmas)
    sheet.show("largest albedo", highest)
    sheet.show("at sigma", at)
    above = [s for s in sigmas if float(gonio.QON(rho=1, sigma=s).albedo(horizon)[0]) > 1]
    sheet.show("largest sigma with an albedo above 1", max(above))


@TEXT.item(
    "fn3",
    "footnote 3",
    "the full model violates conservation near grazing, except at high roughness",
)
def footnote_3(sheet: Sheet) -> None:
    grazing = math.radians(89)
    low = albedo_by_quadrature(gray(gonio.OrenNayar(rho=1, sigma=0.3)), grazing)
    high = albedo_by_quadrature(gray(gonio.OrenNayar(rho=1, sigma=1.2)), grazing)
    sheet.claim("albedo at 89 degrees, sigma 0.3", ">=", "1", low)
    sheet.claim("albedo at 89 degrees, sigma 1.2", "<=", "1", high)


@TEXT.item(
    "continuity", "section 2.1", 'the dark ring is due to "lack of continuity of the BRDF" at s = 0'
)
def continuity(sheet: Sheet) -> None:
    qon, step = gray(gonio.QON(rho=1, sigma=HALF_PI)), 1e-6
    wo = directions(math.radians(69))
    around = [directions(math.radians(69), HALF_PI + k * step) for k in (-2, -1, 1, 2)]
    f = [float(qon(wi, wo)) for wi in around]
    A, _ = qon_coefficients(HALF_PI)
    sheet.refute(
        "jump of f across s = 0, over f",
        ">=",
        1e-3,
        abs(f[2] - f[1]) / (A / math.pi),
        proof=0.0,
        within=1e-5,
        why="B s / t goes to 0 from one side and is 0 on the other (Eq. 3 and 4): "
        "f is continuous, its slope is not",
    )
    sheet.show("slope of f before the ring", (f[1] - f[0]) / step)
    sheet.show("slope of f behind it", (f[3] - f[2]) / step)


@TEXT.item("fon-brighter", "section 1", "FON is brighter than the full model in most cases")
def fon_brighter(sheet: Sheet) -> None:
    wi, wo = random_pairs(20_000, lowest=1e-3)
    fon, full = (
        gray(m)(wi, wo) for m in (gonio.FON(roughness=0.5), gonio.OrenNayar(sigma=math.pi / 4))
    )
    sheet.claim(
        "share of pairs of directions, Figure 3's parameters",
        ">=",
        "0.5",
        float(np.mean(fon > full)),
    )


@TEXT.item("fon-conserve", "section 2.2", "FON conserves energy, and preserves it only at grazing")
def fon_conserve(sheet: Sheet) -> None:
    theta = np.radians(np.linspace(0, 89, 90))
    albedos = np.stack(
        [gonio.FON(rho=1, roughness=r).albedo(directions(theta))[:, 0] for r in (0.3, 1)]
    )
    sheet.claim("largest albedo up to 89 degrees", "<=", "1", float(albedos.max()))


@TEXT.item(
    "cos100", "section 3.1", "the variance of cosine sampling grows by over 100 towards grazing"
)
def cosine_100(sheet: Sheet) -> None:
    model = white_eon(roughness=1, sampler="cosine")
    normal = weights(model, 1e-6).variance
    for angle, t in degrees(80, 89, 89.9):
        ratio = weights(model, t).variance / normal
        sheet.claim(f"variance at {angle:g} degrees over that at the normal", ">=", "100", ratio)


@TEXT.item(
    "uniform",
    "section 3.1",
    "uniform sampling: less variance than cosine at grazing, more elsewhere",
)
def uniform(sheet: Sheet) -> None:
    for angle, relation in ((30, ">="), (60, ">="), (85, "<="), (89, "<=")):
        t = math.radians(angle)
        ratio = (
            weights(white_eon(roughness=1, sampler="uniform"), t).variance
            / weights(white_eon(roughness=1, sampler="cosine"), t).variance
        )
        sheet.claim(f"variance at {angle} degrees, over cosine's", relation, "1", ratio)


@TEXT.item("ltcnn", "section 3.1", "LTC with d = 0 improves on cosine and uniform sampling")
def ltc_nonnegative(sheet: Sheet) -> None:
    def variance(sampler: str, theta: float) -> float:
        return weights(white_eon(roughness=1, sampler=sampler), theta).variance

    for angle, t in degrees(30, 80):
        for other in ("cosine", "uniform"):
            ratio = variance("ltc_nonnegative", t) / variance(other, t)
            sheet.claim(f"variance at {angle:g} degrees, over that of {other}", "<=", "1", ratio)
    t = math.radians(89)
    ours = variance("ltc_nonnegative", t) / variance("uniform", t)
    sheet.refute(
        "variance at 89 degrees, over that of uniform",
        "<=",
        "1",
        ours,
        proof=_variance_by_text(t, 1.0) / (_second_moment_uniform(t, 1.0) - 1),
        within=1e-4,
        why="the integrals of Eq. 16 over the density of Eq. 23 with d = 0, and over 1 / (2 pi)",
    )


def _variance_by_text(theta: float, r: float) -> float:
    from gonio.reproduce.measure import hemisphere

    over, wo = hemisphere(theta), directions(theta)
    f_cos = f_eon(1.0, r, over.wi, wo + 0 * over.wi) * over.wi[:, 2]
    a, b, c, _ = coefficients(math.cos(theta), r)
    h = over.wi @ np.linalg.inv(np.array([[a, 0, b], [0, c, 0], [0, 0, 1]])).T
    length = np.linalg.norm(h, axis=1)
    p = np.maximum(h[:, 2] / length, 0) / math.pi / (a * c) / length**3
    return over.integral(np.where(p > 0, f_cos**2 / np.where(p > 0, p, 1), 0)) - 1


def _second_moment_uniform(theta: float, r: float) -> float:
    from gonio.reproduce.measure import hemisphere

    over, wo = hemisphere(theta), directions(theta)
    f_cos = f_eon(1.0, r, over.wi, wo + 0 * over.wi) * over.wi[:, 2]
    return over.integral(f_cos**2 * 2 * math.pi)


@TEXT.item("bias", "section 3.1", "LTC and CLTC alone are slightly biased")
def bias(sheet: Sheet) -> None:
    for sampler in ("ltc", "cltc"):
        for angle, t in degrees(60, 89):
            mean = weights(white_eon(roughness=1, sampler=sampler), t).mean
            sheet.claim(f"{sampler}: mean weight at {angle:g} degrees", "<=", "0.999", mean)
            sheet.claim(f"{sampler}: the same", ">=", "0.9", mean, why="slight: less than 10 %")


def _factor(theta: float, r: float = 1.0) -> float:
    cosine, paper = (
        weights(white_eon(roughness=r, sampler=s), theta) for s in ("cosine", "cltc_uniform")
    )
    return cosine.variance / paper.variance


def _factor_by_text(theta: float) -> float:
    """The same from the text's formulas alone, on another grid."""
    from gonio.reproduce.measure import hemisphere

    over, wo = hemisphere(theta, 40), directions(theta)
    f_cos = f_eon(1.0, 1.0, over.wi, wo + 0 * over.wi) * over.wi[:, 2]
    P = uniform_share(math.cos(theta), 1.0)
    p = P / (2 * math.pi) + (1 - P) * cltc_pdf(math.cos(theta), 1.0, over.wi)
    cosine = over.integral((f_cos - over.wi[:, 2] / math.pi) ** 2 / (over.wi[:, 2] / math.pi))
    return cosine / over.integral((f_cos - p) ** 2 / p)


@TEXT.item(
    "100", "section 3.1", 'variance "improved by a factor of about 100 at grazing incidence"'
)
def factor_100(sheet: Sheet) -> None:
    for angle, t in degrees(80, 85, 89, 89.9):
        sheet.refute(
            f"factor at {angle:g} degrees",
            ">=",
            "100",
            _factor(t),
            proof=_factor_by_text(t),
            within=0.3,
            why="the text names no angle: the factor grows without bound, and is above 100 only from "
            "89.9994 degrees on (a cosine below 1e-5)",
        )
    sheet.claim("factor at a cosine of 1e-5", "=", "100", _factor(math.acos(1e-5)), within=2)
    t = math.radians(89)
    ours = weights(white_eon(roughness=1, sampler="cosine"), t).variance
    default = weights(white_eon(roughness=1, sampler="cltc_matched"), t).variance
    sheet.show("factor of gonio's default sampler at 89 degrees", ours / default)


@TEXT.item("normal", "section 3.1", "variance is similar at normal incidence")
def normal(sheet: Sheet) -> None:
    sheet.claim(
        "variance of cosine sampling over that of CLTC + uniform",
        "=",
        "1",
        _factor(1e-6),
        within=0.5,
    )


@TEXT.item(
    "r0", "section 3.1", "as r goes to 0 both methods have zero variance and throughput weight"
)
def smooth(sheet: Sheet) -> None:
    for sampler in ("cosine", "cltc_uniform"):
        still = weights(white_eon(roughness=0, sampler=sampler), math.radians(60))
        sheet.claim(f"{sampler}: variance at r = 0", "=", "0.000", still.variance)
        sheet.refute(
            f"{sampler}: weight at r = 0",
            "=",
            "0",
            still.highest,
            proof=1.0,
            within=1e-6,
            why="f cos / pdf = (1 / pi) cos / (cos / pi); Figure 13's caption has it right",
        )
    sheet.show(
        "r = 0.001, 89 degrees: variance of CLTC + uniform over that of cosine sampling",
        1 / _factor(math.radians(89), 0.001),
        why="its share of uniform samples goes like r^0.1; gonio's default sampler is without this",
    )


@TEXT.item("colour", "section 3", "to keep the colour: evaluate white and multiply")
def colour(sheet: Sheet) -> None:
    wi, wo = random_pairs()
    kept = np.asarray(gonio.EON(rho=CLAY, roughness=1, color_shift="none").eval(wi, wo))
    white = np.asarray(white_eon(roughness=1).eval(wi, wo)) * np.array(CLAY)
    sheet.claim(
        "color_shift='none': largest difference", "<=", ROUNDING, float(np.abs(kept - white).max())
    )


@TEXT.item("sigma", "section 2.1", "sigma from 0 to pi / 2")
def sigma_range(sheet: Sheet) -> None:
    declared = gonio.QON.fields["sigma"]
    sheet.claim("lowest sigma", "=", "0", getattr(declared, "low", math.nan), within=0)
    sheet.claim("highest sigma", "=", HALF_PI, getattr(declared, "high", math.nan), within=1e-12)
