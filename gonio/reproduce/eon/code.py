"""The listings."""

from __future__ import annotations

import math

import numpy as np

import gonio
from gonio.arrays.elementwise import elementwise
from gonio.parts import cltc
from gonio.reproduce.eon import TEXT
from gonio.reproduce.eon.formulas import (
    E_fit,
    E_fon,
    cltc_pdf,
    coefficients,
    f_fon,
    mean_E_fon,
    uniform_share,
    white_eon,
)
from gonio.reproduce.measure import (
    Floats,
    directions,
    gray,
    random_pairs,
)
from gonio.reproduce.sheet import Sheet


@TEXT.item("lst1", "Listing 1", "E_FON_exact, E_FON_approx, f_EON, E_EON")
def listing_1(sheet: Sheet) -> None:
    wi, wo = random_pairs(lowest=0.002)
    eps = 1e-7

    def listing(fit: bool) -> Floats:
        E = [(E_fit if fit else E_fon)(1.0, np.arccos(w[:, 2])) for w in (wi, wo)]
        mean, rho = mean_E_fon(1.0), 0.8
        rho_ms = rho**2 * mean / (1 - rho * (1 - mean))
        lost = [np.maximum(eps, 1 - e) for e in E]
        ms = rho_ms / math.pi * lost[0] * lost[1] / max(eps, 1 - mean)
        return np.asarray(rho * f_fon(1.0, wi, wo) + ms)

    for form in ("exact", "fitted"):
        ours = gray(gonio.EON(rho=0.8, roughness=1, albedo_form=form))(wi, wo)
        apart = float(np.abs(ours - listing(form == "fitted")).max())
        sheet.claim(f"f_EON, {form}: largest difference from the listing", "<=", 1e-9, apart)
    with np.errstate(all="ignore"):
        printed = float(np.float64(1.0) / np.float64(0.0) * (1 - 1.0))
    sheet.show("E_FON_exact as printed at mu = 0, 0 / 0", printed)
    sheet.claim(
        "gonio's there",
        "=",
        1,
        float(gonio.FON(rho=1, roughness=1).albedo(np.array([1.0, 0, 0]))[0]),
        within=1e-9,
    )


@TEXT.item("lst2", "Listing 2", "ltc_coeffs, of which the conversion of the text lost the body")
def listing_2(sheet: Sheet) -> None:
    spots = {
        (0.0, 1.0): ("1.027126", "0.705879689", "1.20013", "-0.503445965"),
        (0.5, 0.5): ("1.00883737", "0.208666393", "1.00619387", "-0.0961747603"),
    }
    for (mu, r), texts in spots.items():
        for k, text in enumerate(texts):
            ours = float(elementwise(lambda m, q, k=k: cltc.coefficients(m, 1 - m, q)[k], mu, r))
            sheet.claim(f"{'abcd'[k]} at mu {mu:g}, r {r:g}", "=", text, ours)
    sheet.remark("compared with numbers from the source code that the authors publish")


@TEXT.item("lst3", "Listing 3", "cltc_sample and cltc_pdf")
def listing_3(sheet: Sheet) -> None:
    up = np.array([0.0, 0.0, 1.0])
    u = np.random.default_rng(2).random((1_000_000, 2))
    d = coefficients(1.0, 1.0)[3]
    vz = 1 / math.sqrt(1 + d * d)
    below = (1 - vz) / (1 + vz)  # the lune on the wrong side, of the area that is sampled
    wi, _ = white_eon(roughness=1, sampler="cltc").sample(up, u)
    sheet.refute(
        "share of samples below the horizon at mu = 1, r = 1",
        ">=",
        below,
        float(np.mean(np.asarray(wi)[:, 2] <= 0)),
        proof=0.0,
        within=0.0,
        why="the printed code cuts the side x > 0, which is wrong where d > 0, for mu above 0.99986; "
        "no direction of a clipped lobe is below the horizon",
    )
    mu = 0.3
    wo = np.array([math.sqrt(1 - mu * mu), 0, mu])
    model = white_eon(roughness=1, sampler="cltc")
    wi, pdf = (np.asarray(v) for v in model.sample(wo, u[:20_000]))
    apart = float(np.abs(pdf - cltc_pdf(mu, 1.0, wi)).max())
    sheet.claim("densities of samples, largest difference from Eq. 28", "<=", 1e-8, apart)


@TEXT.item("lst4", "Listing 4", "sample_EON and pdf_EON, with the share of uniform samples")
def listing_4(sheet: Sheet) -> None:
    wi, _ = random_pairs(lowest=0.01)
    for mu, r in ((0.05, 1.0), (0.5, 0.3), (0.95, 0.01)):
        wo = np.array([math.sqrt(1 - mu * mu), 0, mu])
        P = uniform_share(mu, r)
        theirs = P / (2 * math.pi) + (1 - P) * cltc_pdf(mu, r, wi)
        ours = np.asarray(white_eon(roughness=r, sampler="cltc_uniform").pdf(wi, wo))
        apart = float(np.abs(ours - theirs).max())
        sheet.claim(f"density at mu {mu:g}, r {r:g}: largest difference", "<=", 1e-8, apart)
    first = white_eon(roughness=0, sampler="cltc_uniform").sample(
        directions(0.5), np.array([0.0, 0.3])
    )
    sheet.refute(
        "density of the sample for r = 0, u = (0, 0.3)",
        "=",
        "nan",
        float(first.pdf),
        proof=1 / math.pi,
        within=1e-6,
        why="P_u is 0, u1 <= P_u holds for u1 = 0, and the printed u1 / P_u is 0 / 0. The cosine lobe "
        "alone is left at r = 0, and has its sample of u1 = 0 along the normal, where its density is "
        "1 / pi",
    )
