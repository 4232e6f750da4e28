"""Derive tests/anchors.csv: values that the models must reproduce, computed without the package.

`python tests/derive_anchors.py` rewrites the table (about two minutes). Needs mpmath only, and must
never import the package under test. Each model is written down once, straight from its paper and
with no thought for rounding: mpmath carries 40 digits. Closed-form albedos are compared with a
direct quadrature of the BRDF before they are written; a model without one (the full Oren-Nayar)
gets the quadrature's value, compared with a second, different quadrature.

Conventions: wi towards the light, wo towards the viewer, both unit, N = +z. `eval` is the BRDF in
1/sr without the cosine, `pdf` the density of wi per solid angle, `albedo` the directional and
`mean_albedo` the hemispherical one. The directions in the table are doubles, and the values belong
to exactly those doubles.
"""

import csv
import functools
import itertools
import json
import math
import pathlib

from mpmath import acos, atan2, beta, cos, hypot, mp, mpf, nstr, pi, quad, sin, sqrt, tan

mp.dps = 40
HERE = "tests/derive_anchors.py"
AGREEMENT = "1e-10"  # closed form against quadrature
BY_FORMULA = "derived: mpmath, 40 digits"
BY_CLOSED_FORM = f"{BY_FORMULA}, closed form, quadrature agrees to {AGREEMENT}"
BY_QUADRATURE = f"{BY_FORMULA}, by quadrature"
BY_ROUNDING = "rounded to {} decimals: " + BY_QUADRATURE
HALF = mpf(1) / 2
UNIT_TO = mpf("1e-15")  # the directions are unit vectors only to double precision


def dot(a, b):
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def polynomial(x, *coefficients):
    """Sum of the coefficients, as the papers print them, times rising powers of x."""
    return sum(mpf(c) * x**k for k, c in enumerate(coefficients))


def projected_dot(wi, wo):
    """s = wi.wo - mu_i mu_o = cos(phi_i - phi_o) sin(theta_i) sin(theta_o)."""
    return dot(wi, wo) - wi[2] * wo[2]


# Part 1: BRDFs. Each takes the parameters p, wi and wo, and returns three numbers (linear RGB).


def lambert(p, wi, wo):
    """The constant rho / pi."""
    return [rho / pi for rho in p["rho"]]


def oren_nayar(p, wi, wo):
    """The full model, Oren & Nayar 1994, Eq. 27-29: single scattering L1 and interreflection L2."""
    v = p["sigma"] ** 2
    sin_i, sin_o = hypot(wi[0], wi[1]), hypot(wo[0], wo[1])
    theta_i, theta_o = atan2(sin_i, wi[2]), atan2(sin_o, wo[2])
    a, b = max(theta_i, theta_o), min(theta_i, theta_o)
    # With b = 0 the azimuth is undefined; every term that holds it is then zero.
    c = (wi[0] * wo[0] + wi[1] * wo[1]) / (sin_i * sin_o) if b > 0 else mpf(0)
    c1 = 1 - v / (v + mpf("0.33")) / 2
    c2 = mpf("0.45") * v / (v + mpf("0.09")) * (sin(a) - (0 if c >= 0 else (2 * b / pi) ** 3))
    c3 = mpf("0.125") * v / (v + mpf("0.09")) * (4 * a * b / pi**2) ** 2
    single = c1 + c * c2 * tan(b) + (1 - abs(c)) * c3 * tan((a + b) / 2)
    double = mpf("0.17") * v / (v + mpf("0.13")) * (1 - c * (2 * b / pi) ** 2)
    return [rho / pi * single + rho**2 / pi * double for rho in p["rho"]]


def one_over_t(kind, s, wi, wo):
    """1/t of the qualitative models: "qon" (EON paper, Eq. 4), "fujii" (Eq. 11) or "always"."""
    if s > 0 or kind == "always":
        return 1 / max(wi[2], wo[2])
    return {"qon": mpf(0), "fujii": mpf(1)}[kind]


def qualitative(p, wi, wo, a, b, kind):
    """rho / pi (A + B s / t), with one A per channel."""
    s = projected_dot(wi, wo)
    return [
        rho / pi * (a_k + b * s * one_over_t(kind, s, wi, wo))
        for rho, a_k in zip(p["rho"], a, strict=True)
    ]


def qon_coefficients(p, constant="0.33", interreflection="0"):
    """A (per channel) and B of Oren & Nayar 1994, Eq. 30, and of its variants."""
    v = p["sigma"] ** 2
    a = [
        1 - v / (v + mpf(constant)) / 2 + mpf(interreflection) * rho * v / (v + mpf("0.13"))
        for rho in p["rho"]
    ]
    return a, mpf("0.45") * v / (v + mpf("0.09"))


def qon_footnote_coefficients(p):
    """0.57 in place of 0.33: Oren & Nayar's footnote, for the missing interreflection."""
    return qon_coefficients(p, constant="0.57")


def qon_fujii_coefficients(p):
    """Fujii's first formula: the interreflection of the full model, without its angles, in A."""
    return qon_coefficients(p, interreflection="0.17")


def qon(p, wi, wo):
    """The qualitative model, Oren & Nayar 1994, Eq. 30; EON paper, Eq. 1-4."""
    return qualitative(p, wi, wo, *qon_coefficients(p), "qon")


def qon_footnote(p, wi, wo):
    """The qualitative model with the constant of Oren & Nayar's footnote."""
    return qualitative(p, wi, wo, *qon_footnote_coefficients(p), "qon")


def qon_fujii(p, wi, wo):
    """Fujii's first formula, fitted to the full model."""
    return qualitative(p, wi, wo, *qon_fujii_coefficients(p), "fujii")


def fon_coefficients(p):
    """A_F (the same for each channel) and B_F, EON paper after Eq. 11."""
    a = 1 / (1 + (HALF - 2 / (3 * pi)) * p["roughness"])
    return [a] * 3, p["roughness"] * a


def fon(p, wi, wo):
    """Fujii's second formula, EON paper, Eq. 10-11."""
    return qualitative(p, wi, wo, *fon_coefficients(p), "fujii")


@functools.lru_cache(maxsize=4096)
def fon_white_albedo(mu, r, form):
    """E_F at rho = 1, EON paper, Eq. 12-13 ("exact") or Eq. 14 ("fitted")."""
    (a, _, _), b = fon_coefficients({"roughness": r})
    if form == "exact":
        return a + b / pi * g_fujii(acos(mu))
    fit = ("0.0571085289", "0.491881867", "-0.332181442", "0.0714429953")
    return a + b * polynomial(1 - mu, "0", *fit)


def eon_rho_ms(rho, mean):
    """Colour of the multiple-scattering lobe, EON paper, Eq. 19."""
    return rho**2 * mean / (1 - rho * (1 - mean))


def eon(p, wi, wo):
    """EON paper, Eq. 16-19. Lambert at r = 0, where Eq. 19 is 0/0 (r^2 over r)."""
    if p.get("color_shift") == "none":
        white = eon({**p, "rho": [mpf(1)] * 3, "color_shift": "physical"}, wi, wo)
        return [rho * f for rho, f in zip(p["rho"], white, strict=True)]
    r, form = p["roughness"], p.get("albedo_form", "exact")
    if r == 0:
        return lambert(p, wi, wo)
    mean = fon_mean_albedo({**p, "rho": [mpf(1)] * 3})[0]
    lobe = (
        (1 - fon_white_albedo(wi[2], r, form)) * (1 - fon_white_albedo(wo[2], r, form)) / (1 - mean)
    )
    return [
        f + eon_rho_ms(rho, mean) / pi * lobe
        for rho, f in zip(p["rho"], fon(p, wi, wo), strict=True)
    ]


# The factor in A' and the kind of t: 0.33 is QON's, with sigma^2 = 2 / shininess, 0.65 Gotanda's.
TRIACE = {"eq23": ("0.33", "qon"), "eq24": ("0.65", "always"), "eq25": ("0.65", "fujii")}


def triace_coefficients(p):
    """A' (the same for each channel), B and the kind of t, Gotanda 2012, Eq. 23-25."""
    factor, kind = TRIACE[p.get("variant", "eq25")]
    n = p["shininess"]
    return [1 - 1 / (2 + mpf(factor) * n)] * 3, 1 / (mpf("2.22222") + mpf("0.1") * n), kind


def triace_oren_nayar(p, wi, wo):
    """Gotanda 2012, Eq. 23-25, divided by N.L. Eq. 24 can be negative; nothing is clamped."""
    return qualitative(p, wi, wo, *triace_coefficients(p))


def burley_diffuse(p, wi, wo):
    """Burley 2012, the diffuse term of the Disney model, without Fresnel or metallic factors."""
    half = [x + y for x, y in zip(wi, wo, strict=True)]
    cos_d = dot(wi, half) / sqrt(dot(half, half))
    f90 = HALF + 2 * cos_d**2 * p["roughness"]
    factor = (1 + (f90 - 1) * (1 - wi[2]) ** 5) * (1 + (f90 - 1) * (1 - wo[2]) ** 5)
    return [rho / pi * factor for rho in p["rho"]]


# Part 2: closed-form albedos.


def g_qon(theta):
    """EON paper, Eq. 8: integral of s / t of QON over the projected hemisphere."""
    s = sin(theta)
    return s * (theta - s * cos(theta)) + tan(theta) * (1 - s**3) * 2 / 3


def g_fujii(theta):
    """EON paper, Eq. 13: as g_qon, for Fujii's t."""
    return g_qon(theta) - sin(theta) * 2 / 3


# By kind of t: the directional integral, and its hemispherical mean divided by pi (EON paper, Eq. 9
# and 15). Where the sign of cos(phi) does not matter to t, the integral over phi vanishes.
G = {"qon": g_qon, "fujii": g_fujii, "always": lambda theta: mpf(0)}
G_MEAN = {
    "qon": mpf(2) / 3 - 64 / (45 * pi),
    "fujii": mpf(2) / 3 - 28 / (15 * pi),
    "always": mpf(0),
}


def qualitative_albedo(p, mu, a, b, kind):
    """rho (A + B / pi G(theta))."""
    return [rho * (a_k + b / pi * G[kind](acos(mu))) for rho, a_k in zip(p["rho"], a, strict=True)]


def qualitative_mean_albedo(p, a, b, kind):
    """Hemispherical mean of `qualitative_albedo`."""
    return [rho * (a_k + b * G_MEAN[kind]) for rho, a_k in zip(p["rho"], a, strict=True)]


def lambert_albedo(p, mu):
    """The colour itself."""
    return p["rho"]


def lambert_mean_albedo(p):
    """The colour itself."""
    return p["rho"]


def qon_albedo(p, mu):
    """EON paper, Eq. 5 and 8."""
    return qualitative_albedo(p, mu, *qon_coefficients(p), "qon")


def qon_mean_albedo(p):
    """EON paper, Eq. 9."""
    return qualitative_mean_albedo(p, *qon_coefficients(p), "qon")


def qon_footnote_albedo(p, mu):
    """EON paper, Eq. 5 and 8, with the footnote's A."""
    return qualitative_albedo(p, mu, *qon_footnote_coefficients(p), "qon")


def qon_footnote_mean_albedo(p):
    """EON paper, Eq. 9, with the footnote's A."""
    return qualitative_mean_albedo(p, *qon_footnote_coefficients(p), "qon")


def qon_fujii_albedo(p, mu):
    """EON paper, Eq. 12-13, with the coefficients of Fujii's first formula."""
    return qualitative_albedo(p, mu, *qon_fujii_coefficients(p), "fujii")


def qon_fujii_mean_albedo(p):
    """EON paper, Eq. 15, with the coefficients of Fujii's first formula."""
    return qualitative_mean_albedo(p, *qon_fujii_coefficients(p), "fujii")


def fon_albedo(p, mu):
    """EON paper, Eq. 12-13."""
    return qualitative_albedo(p, mu, *fon_coefficients(p), "fujii")


def fon_mean_albedo(p):
    """EON paper, Eq. 15."""
    return qualitative_mean_albedo(p, *fon_coefficients(p), "fujii")


def eon_albedo(p, mu):
    """EON paper, Eq. 12 and 20.

    For the exact form only: with the fit, this is not the albedo of the BRDF that uses it.
    """
    assert p.get("albedo_form", "exact") == "exact"
    if p.get("color_shift") == "none":
        return p["rho"]
    white = {**p, "rho": [mpf(1)] * 3}
    mean, directional = fon_mean_albedo(white)[0], fon_albedo(white, mu)[0]
    return [rho * directional + eon_rho_ms(rho, mean) * (1 - directional) for rho in p["rho"]]


def eon_mean_albedo(p):
    """Eq. 15 plus the factor F of Eq. 18."""
    if p.get("color_shift") == "none":
        return p["rho"]
    mean = fon_mean_albedo({**p, "rho": [mpf(1)] * 3})[0]
    return [rho * mean + eon_rho_ms(rho, mean) * (1 - mean) for rho in p["rho"]]


def triace_oren_nayar_albedo(p, mu):
    """Eq. 23 has QON's integral, Eq. 24 none at all (a constant albedo), Eq. 25 Fujii's."""
    return qualitative_albedo(p, mu, *triace_coefficients(p))


def triace_oren_nayar_mean_albedo(p):
    """Hemispherical mean of `triace_oren_nayar_albedo`."""
    return qualitative_mean_albedo(p, *triace_coefficients(p))


# Integrals of mu^m (1 - mu)^5 over 0..1.
BURLEY_MOMENTS = [beta(m + 1, 6) for m in range(4)]


def burley_diffuse_albedo(p, mu):
    """The BRDF integrated term by term.

    F90 - 1 = a + r (mu_i mu_o + s) with a = r - 1/2 makes it a polynomial in mu_i and s.
    """
    r, a, w = p["roughness"], p["roughness"] - HALF, (1 - mu) ** 5
    _, i1, i2, i3 = BURLEY_MOMENTS
    linear = 2 * a * i1 + 2 * r * mu * i2 + w * (a + r * mu * 2 / 3)
    square = (
        a**2 * i1 + 2 * a * r * mu * i2 + (r * mu) ** 2 * i3 + r**2 * (1 - mu**2) * (i1 - i3) / 2
    )
    return [rho * (1 + linear + 2 * w * square) for rho in p["rho"]]


def burley_diffuse_mean_albedo(p):
    """Hemispherical mean of `burley_diffuse_albedo`, again term by term."""
    r, a = p["roughness"], p["roughness"] - HALF
    _, i1, i2, i3 = BURLEY_MOMENTS
    square = a**2 * i1**2 + 2 * a * r * i2**2 + r**2 * i3**2 + r**2 * (i1 - i3) ** 2 / 2
    return [rho * (1 + 4 * a * i1 + r * i2 * 8 / 3 + 4 * square) for rho in p["rho"]]


def oren_nayar_albedo_one_dimensional(p, mu):
    """Albedo of the full model integrated over phi by hand; only checks the quadrature."""
    v, theta_o = p["sigma"] ** 2, acos(mu)
    k = v / (v + mpf("0.09"))

    def single(theta):
        a, b = max(theta, theta_o), min(theta, theta_o)
        third = mpf("0.125") * (4 * a * b / pi**2) ** 2 * tan((a + b) / 2)
        sum_phi = 2 * mpf("0.45") * (2 * b / pi) ** 3 * tan(b) + (2 * pi - 4) * third
        return k * sum_phi * sin(theta) * cos(theta)

    breaks = [mpf(0), *graded(theta_o), pi / 2]
    l1 = 1 - v / (v + mpf("0.33")) / 2 + quad(single, breaks) / pi
    return [rho * l1 + rho**2 * mpf("0.17") * v / (v + mpf("0.13")) for rho in p["rho"]]


# Part 3: quadrature.


@functools.cache
def gauss_legendre(n):
    """Nodes and weights on 0..1, by Newton's method on the Legendre polynomial."""
    rule = []
    for k in range(n):
        x = cos(pi * (k + mpf("0.75")) / (n + HALF))
        for _ in range(8):
            previous, current = mpf(1), x
            for j in range(2, n + 1):
                previous, current = current, ((2 * j - 1) * x * current - (j - 1) * previous) / j
            slope = n * (x * current - previous) / (x * x - 1)
            x -= current / slope
        rule.append(((1 + x) / 2, 1 / ((1 - x * x) * slope**2)))
    return rule


def composite(breaks, n):
    """Gauss-Legendre nodes and weights on each interval between neighbouring breaks."""
    for low, high in itertools.pairwise(breaks):
        for x, weight in gauss_legendre(n):
            yield low + (high - low) * x, (high - low) * weight


def direction(theta, phi):
    """Unit vector."""
    return (sin(theta) * cos(phi), sin(theta) * sin(phi), cos(theta))


def graded(theta_o):
    """Breaks that close in on theta_o: the full Oren-Nayar has a pole at pi - theta_o."""
    if theta_o == 0:
        return []
    breaks, step = [theta_o], 2 * (pi / 2 - theta_o)
    while step < theta_o:
        breaks.append(theta_o - step)
        step *= 3
    return breaks[::-1]


PHI_BREAKS = [mpf(0), pi / 2, pi]  # kinks where cos(phi) changes sign; 0..pi stands for the circle


def albedo_by_quadrature(model, p, mu, n_theta=24, n_phi=14):
    """Integral of f mu_i over the hemisphere, split at theta_i = theta_o and phi = pi/2."""
    theta_o = acos(mu)
    wo = direction(theta_o, 0)
    total = [mpf(0)] * 3
    for theta, weight_theta in composite([mpf(0), *graded(theta_o), pi / 2], n_theta):
        for phi, weight_phi in composite(PHI_BREAKS, n_phi):
            weight = 2 * weight_theta * weight_phi * sin(theta) * cos(theta)
            total = [
                t + weight * f
                for t, f in zip(total, model(p, direction(theta, phi), wo), strict=True)
            ]
    return total


def mean_albedo_by_quadrature(model, p, n_theta=20, n_phi=12):
    """(1/pi) times the integral of f mu_i mu_o over both hemispheres.

    f is reciprocal, so twice the half theta_i < theta_o will do. With theta_i = pi/2 - x and
    theta_o = pi/2 - x y, 0 < y < 1, the integrand is analytic in x and y up to the corner where
    both directions graze.
    """
    total = [mpf(0)] * 3
    for x, weight_x in composite([mpf(0), pi / 2], n_theta):
        for y, weight_y in composite([mpf(0), mpf(1)], n_theta):
            theta_i, theta_o = pi / 2 - x, pi / 2 - x * y
            wo = direction(theta_o, 0)
            projected = x * sin(theta_i) * cos(theta_i) * sin(theta_o) * cos(theta_o)
            for phi, weight_phi in composite(PHI_BREAKS, n_phi):
                weight = 8 * weight_x * weight_y * weight_phi * projected
                total = [
                    t + weight * f
                    for t, f in zip(total, model(p, direction(theta_i, phi), wo), strict=True)
                ]
    return total


# Part 4: sampling.


def ltc_coefficients(mu, r):
    """EON paper, Listing 2: a, b, c, d of the matrix M."""
    a = 1 + r * polynomial(mu, "0.303392", "-0.518982", "0.111709")
    a += r**2 * polynomial(mu, "-0.276266", "0.335918")
    b = r * polynomial(mu, "-1.16407", "1.15859") + r**2 * polynomial(mu, "0.150815", "-0.150105")
    b /= polynomial(mu, "-1.43545", "0", "0", "1")
    c = 1 + r * polynomial(mu, "0.20013", "-0.506373", "0.261777")
    d = r * polynomial(mu, "0.540852", "-1.01625", "0.475392")
    d /= polynomial(mu, "-1.0743", "0.0725628", "1")
    return a, b, c, d


def ltc_density(coefficients, wi):
    """EON paper, Eq. 21-26: density of M w / |M w|, w cosine-distributed, x along wo's azimuth."""
    a, b, c, d = coefficients
    det = c * (a - b * d)
    # M^-1 wi with the inverse written out, and the Jacobian |M^-1| / |M^-1 wi|^3
    w = (
        (c * wi[0] - b * c * wi[2]) / det,
        (a - b * d) * wi[1] / det,
        (-c * d * wi[0] + a * c * wi[2]) / det,
    )
    length = sqrt(dot(w, w))
    return max(w[2] / length, mpf(0)) / pi * (1 / det) / length**3


def azimuth_frame(wo, wi):
    """wi with the x axis turned to wo's azimuth; unturned when wo = N (EON paper, Listing 3)."""
    length = hypot(wo[0], wo[1])
    if length == 0:
        return wi
    x, y = wo[0] / length, wo[1] / length
    return (wi[0] * x + wi[1] * y, wi[1] * x - wi[0] * y, wi[2])


def eon_pdf(p, wi, wo):
    """Densities of the EON paper's Figure 11, Eq. 21-28 and Listing 4, for wi above the horizon."""
    sampler, r, mu = p.get("sampler", SAMPLERS[0]), p["roughness"], wo[2]
    if sampler == "cltc_matched":
        # Not the paper's: cosine sampling up to 1e-4, and another share of uniform samples
        r = max(r - mpf("1e-4"), mpf(0))
    a, b, c, d = ltc_coefficients(mu, r)
    local = azimuth_frame(wo, wi)
    if sampler == "cosine":
        return wi[2] / pi
    if sampler == "uniform":
        return 1 / (2 * pi)
    if sampler == "ltc_nonnegative":
        return ltc_density((a, b, c, mpf(0)), local)
    if sampler == "ltc":
        return ltc_density((a, b, c, d), local)
    # Eq. 28: the cosine lobe, clipped to the area pi/2 (1 + cos(theta_P)) with tan(theta_P) = d
    cltc = 2 * ltc_density((a, b, c, d), local) / (1 + 1 / sqrt(1 + d**2))
    if sampler == "cltc":
        return cltc
    if sampler == "cltc_matched":
        k = 1 - mu
        p_u = r * polynomial(k, "0.0169", "0.2136", "-0.2345", "0.445")
        p_u *= 1 + r * (polynomial(k, "-0.602", "-0.5736") + mpf("0.315") * r)
        return p_u / (2 * pi) + (1 - p_u) * cltc
    p_u = polynomial(mu, "0.162925", "-0.372058", "0.538233", "-0.290822")
    p_u *= r ** mpf("0.1") if r > 0 else 0
    return p_u / (2 * pi) + (1 - p_u) * cltc


def lambert_pdf(p, wi, wo):
    """Cosine-weighted hemisphere."""
    return wi[2] / pi


def pdf_integral(p, wo):
    """Integral of eon_pdf over the hemisphere, split where the LTC lobe ends: (M^-1 wi).z = 0."""
    a, _, _, d = ltc_coefficients(wo[2], p["roughness"])
    if p.get("sampler") == "ltc_nonnegative":
        d = mpf(0)
    total = mpf(0)
    for phi, weight_phi in composite([mpf(0), pi / 4, pi / 2, 3 * pi / 4, pi], 20):
        edge = atan2(a, d * cos(phi)) if d * cos(phi) > 0 else pi / 2
        breaks = [mpf(0), edge / 2, edge] + ([pi / 2] if edge < pi / 2 else [])
        for theta, weight_theta in composite(breaks, 20):
            total += (
                2 * weight_phi * weight_theta * sin(theta) * eon_pdf(p, direction(theta, phi), wo)
            )
    return total


# Part 5: the table.


def unit(mu, azimuth):
    """A double-precision unit vector with cosine `mu` and `azimuth` in degrees."""
    s = math.sqrt((1 - mu) * (1 + mu))
    x, y = s * math.cos(math.radians(azimuth)), s * math.sin(math.radians(azimuth))
    length = math.sqrt(x * x + y * y + mu * mu)
    return (x / length + 0.0, y / length + 0.0, mu / length)


def at(angle, azimuth):
    """A double-precision unit vector from two angles in degrees."""
    return unit(math.cos(math.radians(angle)), azimuth)


NORMAL = (0.0, 0.0, 1.0)
RETRO, GRAZING, EDGE = at(60, 135), unit(1e-3, 70), unit(1e-6, 310)
MIRROR_OF = {w: (-w[0], -w[1], w[2]) for w in (RETRO, GRAZING)}
PAIRS = [
    (NORMAL, NORMAL),
    (at(30, 20), at(55, 50)),  # s > 0
    (at(40, 200), at(65, 10)),  # s < 0
    ((0.6, 0.0, 0.8), (0.0, 0.8, 0.6)),  # s = 0
    (RETRO, RETRO),
    (RETRO, MIRROR_OF[RETRO]),
    (at(81, 12), at(76, 41)),  # steep, s > 0
    (GRAZING, GRAZING),
    (GRAZING, MIRROR_OF[GRAZING]),
    (GRAZING, at(50, 95)),  # s > 0
    (at(35, 140), EDGE),  # s < 0
    (EDGE, EDGE),
    (EDGE, NORMAL),
    (unit(1e-3, 290), EDGE),  # both grazing, s > 0
    (at(72, 33), unit(1e-2, 255)),  # s < 0
]
VIEWS = [NORMAL, at(30, 0), at(60, 115), at(80, 250), GRAZING, EDGE]

WHITE, GRAY = [1.0, 1.0, 1.0], [0.8, 0.8, 0.8]
CLAY, LEAF, EXTREME = [0.9, 0.35, 0.04], [0.18, 0.97, 0.62], [0.0, 0.5, 1.0]


def sets(name, numbers, colours=(WHITE, CLAY, GRAY, LEAF, EXTREME), **options):
    """Parameter sets that pair each number with a colour."""
    return [
        {"rho": rho, name: x, **options}
        for x, rho in zip(numbers, itertools.cycle(colours), strict=False)
    ]


SIGMAS = [0.6, math.pi / 2, 0.2, math.pi / 4, 0.0, 1.1, 0.05]
ROUGHNESSES = [0.5, 1.0, 0.0, 0.25, 0.85, 0.02, 0.65]
SHININESSES = [10.0, 2.0, 37.5, 200.0, 1.0, 5.0, 22.0]

# model: (eval, closed albedo, closed mean albedo, list of parameter sets per variant, publications)
MODELS = {
    "lambert": (
        lambert,
        lambert_albedo,
        lambert_mean_albedo,
        [[{"rho": c} for c in (CLAY, WHITE, LEAF)]],
        ["lambert1760 as rho / pi"],
    ),
    "oren_nayar": (oren_nayar, None, None, [sets("sigma", SIGMAS)], ["oren1994 Eq. 27 to 29"]),
    "qon": (
        qon,
        qon_albedo,
        qon_mean_albedo,
        [sets("sigma", SIGMAS)],
        ["oren1994 Eq. 30", "portsmouth2025 Eq. 1 to 9"],
    ),
    "qon_footnote": (
        qon_footnote,
        qon_footnote_albedo,
        qon_footnote_mean_albedo,
        [sets("sigma", SIGMAS)],
        ["oren1994 Eq. 30 with the footnote's 0.57"],
    ),
    "qon_fujii": (
        qon_fujii,
        qon_fujii_albedo,
        qon_fujii_mean_albedo,
        [sets("sigma", SIGMAS)],
        ["fujii2013 first formula"],
    ),
    "fon": (
        fon,
        fon_albedo,
        fon_mean_albedo,
        [sets("roughness", ROUGHNESSES)],
        ["portsmouth2025 Eq. 10 to 15"],
    ),
    "eon": (
        eon,
        eon_albedo,
        eon_mean_albedo,
        [
            sets("roughness", ROUGHNESSES),
            sets("roughness", ROUGHNESSES, color_shift="none"),
            sets("roughness", ROUGHNESSES, albedo_form="fitted"),
        ],
        ["portsmouth2025 Eq. 10 to 20"],
    ),
    "triace_oren_nayar": (
        triace_oren_nayar,
        triace_oren_nayar_albedo,
        triace_oren_nayar_mean_albedo,
        [
            sets("shininess", SHININESSES),
            sets("shininess", SHININESSES, variant="eq24"),
            sets("shininess", SHININESSES, variant="eq23"),
        ],
        ["gotanda2012 Eq. 20 to 25"],
    ),
    "burley_diffuse": (
        burley_diffuse,
        burley_diffuse_albedo,
        burley_diffuse_mean_albedo,
        [sets("roughness", ROUGHNESSES)],
        ["burley2012 section 5.3"],
    ),
}

# The fit of E_F exceeds 1 below mu = 0.0014, where the paper's listing clamps 1 - E_F to 1e-7 and
# its Eq. 14 does not: nothing to anchor there.
FITTED_MU_MIN = 0.002

SAMPLERS = ["cltc_matched", "cltc_uniform", "cltc", "ltc", "ltc_nonnegative", "uniform", "cosine"]
PDF_CASES = [
    (1.0, at(60, 115), at(40, 100)),
    (0.5, at(60, 115), at(70, 290)),
    (1.0, EDGE, at(84, 300)),
    (0.25, GRAZING, GRAZING),
    (1.0, GRAZING, MIRROR_OF[GRAZING]),  # behind the edge of the unclipped lobe's flat side
    (0.0, at(30, 20), at(55, 50)),
    (1.0, NORMAL, at(65, 10)),  # the matrix of wo = N is not isotropic: x axis as in Listing 3
    (0.7, at(0.5, 200), EDGE),  # d > 0
]

# Directional albedo of the full Oren-Nayar at rho = 1, at these angles in degrees, and of QON at
# the worst sigma, rounded. None: .95747 and .72047, too near to the middle of two roundings.
ROUNDED_VIEWS = [0, 60, 85, 89]
ROUNDED_OREN_NAYAR = {
    math.pi / 8: ["0.933", "0.959", "1.017", "1.036"],
    math.pi / 4: ["0.815", "0.851", "0.931", None],
    math.pi / 2: [None, "0.761", "0.849", "0.878"],
}
ROUNDED_QON_MAXIMUM = (0.1986, EDGE, "1.0152")
HALF_OF_LAST_DIGIT = {3: mpf("5e-4"), 4: mpf("5e-5")}
PUBLISHED_LTC = {
    (0.0, 1.0): ("1.027126", "0.705879689", "1.20013", "-0.503445965"),
    (0.5, 0.5): ("1.00883737", "0.208666393", "1.00619387", "-0.0961747603"),
    (1.0, 1.0): ("0.955771", "0.0109541853", "0.955534", "0.00345383376"),
}


def exact(value):
    """Numbers, and lists of them, as mpf without rounding; other values unchanged."""
    if isinstance(value, dict):
        return {k: exact(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [exact(v) for v in value]
    return mpf(value) if isinstance(value, float) else value


def source(how, publications, file, function):
    """How a value was found, the publications by their keys in the bibliography, and what derives it."""
    return "; ".join((how, *publications, f"{file} {function}"))


def number(x):
    """17 significant digits, as JSON."""
    return format(x, ".17g") if isinstance(x, float) else nstr(x, 17)


def row(model, p, wi, wo, quantity, value, source):
    """One line of the table."""

    def array(numbers):
        return "[" + ", ".join(map(number, numbers)) + "]"

    if not isinstance(value, str):
        value = array(value) if isinstance(value, list) else number(value)
    json.loads(value)
    wi, wo = (array(w) if w else "" for w in (wi, wo))
    return [model, json.dumps(p), wi, wo, quantity, value, source]


def compare(found, expected, tolerance, what):
    """Stop when two ways to one number disagree."""
    for f, e in zip(found, expected, strict=True):
        assert abs(f - e) <= tolerance * max(1, abs(e)), (
            f"{what}: {nstr(f, 20)}, expected {nstr(e, 20)}"
        )


def eval_rows(name):
    """Each pair of directions with two parameter sets of each variant."""
    model, _, _, variants, publications = MODELS[name]
    found_by = source(BY_FORMULA, publications, HERE, name)
    for parameter_sets in variants:
        for k, (wi, wo) in enumerate(PAIRS):
            for p in (
                parameter_sets[k % len(parameter_sets)],
                parameter_sets[(2 * k + 3) % len(parameter_sets)],
            ):
                if p.get("albedo_form") == "fitted" and min(wi[2], wo[2]) < FITTED_MU_MIN:
                    continue
                value = model(exact(p), exact(wi), exact(wo))
                compare(
                    model(exact(p), exact(wo), exact(wi)),
                    value,
                    UNIT_TO,
                    f"reciprocity of {name}",
                )
                yield row(name, p, wi, wo, "eval", value, found_by)


def albedo_rows(name):
    """Closed forms, checked by quadrature; without one, a quadrature checked by another."""
    model, closed, closed_mean, variants, publications = MODELS[name]
    found_by = source(BY_CLOSED_FORM if closed else BY_QUADRATURE, publications, HERE, name)
    for parameter_sets in variants:
        if parameter_sets[0].get("albedo_form") == "fitted":
            continue
        for k, wo in enumerate(VIEWS):
            p = parameter_sets[k % len(parameter_sets)]
            integral = albedo_by_quadrature(model, exact(p), mpf(wo[2]))
            check = (closed or oren_nayar_albedo_one_dimensional)(exact(p), mpf(wo[2]))
            compare(
                integral, check, mpf(AGREEMENT) if closed else mpf("1e-18"), f"albedo of {name}"
            )
            yield row(name, p, None, wo, "albedo", check if closed else integral, found_by)
        for p in parameter_sets[:2]:
            integral = mean_albedo_by_quadrature(model, exact(p))
            if closed_mean:
                check = closed_mean(exact(p))
                compare(integral, check, mpf(AGREEMENT), f"mean albedo of {name}")
            else:
                check = mean_albedo_by_quadrature(model, exact(p), 16, 14)
                compare(integral, check, mpf("1e-18"), f"mean albedo of {name}")
            yield row(
                name,
                p,
                None,
                None,
                "mean_albedo",
                check if closed_mean else integral,
                found_by,
            )


def pdf_rows():
    """Densities of Lambert's sampler and of EON's seven."""
    for wi, wo in PAIRS[:3] + PAIRS[-3:]:
        p = {"rho": GRAY}
        yield row(
            "lambert",
            p,
            wi,
            wo,
            "pdf",
            lambert_pdf(exact(p), exact(wi), exact(wo)),
            source(BY_FORMULA, [], HERE, "lambert_pdf"),
        )
    for sampler in SAMPLERS:
        for r, wo, wi in PDF_CASES:
            p = {"rho": GRAY, "roughness": r}
            if sampler != SAMPLERS[0]:
                p["sampler"] = sampler
            value = eon_pdf(exact(p), exact(wi), exact(wo))
            publications = ["portsmouth2025 Eq. 21 to 28 and Listings 2 to 4"]
            found_by = source(BY_FORMULA, publications, HERE, "eon_pdf")
            yield row("eon", p, wi, wo, "pdf", value, found_by)


def rounded_rows():
    """Numbers as docs/formulas.md prints them, each compared with this derivation."""
    views = [at(angle, 0) for angle in ROUNDED_VIEWS]
    publications = MODELS["oren_nayar"][-1]
    for sigma, values in ROUNDED_OREN_NAYAR.items():
        for wo, printed in zip(views, values, strict=True):
            p = {"rho": WHITE, "sigma": sigma}
            derived = albedo_by_quadrature(oren_nayar, exact(p), mpf(wo[2]))
            if printed is None:
                found_by = source(BY_QUADRATURE, publications, HERE, "oren_nayar")
                yield row("oren_nayar", p, None, wo, "albedo", derived, found_by)
                continue
            compare(derived, [mpf(printed)] * 3, HALF_OF_LAST_DIGIT[3], f"albedo at {sigma}")
            value = f"[{printed}, {printed}, {printed}]"
            found_by = source(BY_ROUNDING.format(3), publications, HERE, "oren_nayar")
            yield row("oren_nayar", p, None, wo, "albedo", value, found_by)
    sigma, wo, printed = ROUNDED_QON_MAXIMUM
    p = {"rho": WHITE, "sigma": sigma}
    derived = qon_albedo(exact(p), mpf(wo[2]))
    compare(derived, [mpf(printed)] * 3, HALF_OF_LAST_DIGIT[4], "highest albedo of QON")
    found_by = source(BY_ROUNDING.format(4), MODELS["qon"][-1], HERE, "qon")
    yield row("qon", p, None, wo, "albedo", f"[{printed}, {printed}, {printed}]", found_by)


def check_sampling():
    """Published matrix coefficients; integral of each density is 1 (less for the unclipped LTC)."""
    for (mu, r), printed in PUBLISHED_LTC.items():
        found = ltc_coefficients(mpf(mu), mpf(r))
        compare(
            found, [mpf(x) for x in printed], mpf("6e-9"), f"LTC coefficients at mu={mu}, r={r}"
        )
    for sampler, mu in itertools.product(SAMPLERS, ("0.01", "0.5", "1")):
        total = pdf_integral({"roughness": mpf(1), "sampler": sampler}, direction(acos(mpf(mu)), 0))
        if sampler == "ltc":
            assert total < 1
        else:
            compare([total], [mpf(1)], mpf("1e-9"), f"integral of {sampler} at mu={mu}")


def main():
    """Rewrite anchors.csv next to this file."""
    check_sampling()
    rows = list(rounded_rows())
    for name in MODELS:
        rows += [*eval_rows(name), *albedo_rows(name)]
    rows += pdf_rows()
    with pathlib.Path(__file__).with_name("anchors.csv").open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["model", "parameters", "wi", "wo", "quantity", "value", "source"])
        writer.writerows(rows)


if __name__ == "__main__":
    main()
