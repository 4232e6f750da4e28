"""Derive tests/anchors_specular.csv: values of the specular and complete models, computed without
the package.

`python tests/derive_specular_anchors.py` rewrites the table (seconds). As in
derive_anchors.py, whose helpers it takes, each model is written down once, straight from its source
and with no thought for rounding, and the package under test is never imported. The functions take
the arithmetic as their first argument: `Exact` (mpmath, 40 digits) gives `eval` and `pdf`, `Doubles`
(NumPy) gives `albedo`, by two quadratures that must agree to 1e-9.

Conventions: wi towards the light, wo towards the viewer, both unit, N = +z, H the half vector, D the
density of microfacet normals, whose projected area is 1. `eval` is the BRDF in 1/sr without the
cosine, `pdf` the density of wi per solid angle. Colours are linear RGB.
"""

import csv
import functools
import itertools
import math
import pathlib

import numpy as np
from derive_anchors import (
    BY_FORMULA,
    GRAZING,
    NORMAL,
    RETRO,
    at,
    compare,
    dot,
    exact,
    gauss_legendre,
    row,
    source,
    unit,
)
from mpmath import mp, mpf  # 40 digits, set by derive_anchors

HERE = "tests/derive_specular_anchors.py"
AGREEMENT = 1e-9  # of two quadratures
BY_QUADRATURE = f"derived: two quadratures in double precision agree to {AGREEMENT}"
BY_ROUNDING = "rounded to {} decimals: " + BY_QUADRATURE
UNIT_TO = mpf("1e-12")  # directions are unit to 1e-16; grazing divides that by wo.H = 1e-3, twice


class Exact:
    """Functions of mpmath's numbers."""

    number, pi = mpf, mp.pi
    sqrt, exp, log, erfc, atan2 = mp.sqrt, mp.exp, mp.log, mp.erfc, mp.atan2
    maximum, minimum = max, min


class Doubles:
    """The same for NumPy's arrays."""

    number, pi = float, math.pi
    sqrt, exp, log, atan2 = np.sqrt, np.exp, np.log, np.arctan2
    erfc = np.vectorize(math.erfc, otypes=[float])
    maximum, minimum = np.maximum, np.minimum


def lerp(a, b, t):
    """a at t = 0, b at t = 1."""
    return a + (b - a) * t


def half_vector(m, wi, wo):
    """The microfacet normal that reflects one direction into the other."""
    h = [x + y for x, y in zip(wi, wo, strict=True)]
    length = m.sqrt(dot(h, h))
    return [x / length for x in h]


# Part 1: distributions of normals.


def alpha_xy(m, p):
    """Widths along x and y; Burley 2012, section 5.4, turns one anisotropy into an aspect."""
    aspect = m.sqrt(1 - m.number("0.9") * p.get("anisotropy", 0))
    return p["alpha"] / aspect, p["alpha"] * aspect


def d_ggx(m, p, h):
    """Walter et al. 2007, Eq. 33; Burley 2012, Eq. 13 (anisotropic)."""
    a_x, a_y = alpha_xy(m, p)
    return 1 / (m.pi * a_x * a_y * ((h[0] / a_x) ** 2 + (h[1] / a_y) ** 2 + h[2] ** 2) ** 2)


def d_beckmann(m, p, h):
    """Walter et al. 2007, Eq. 25, with one width per axis."""
    a_x, a_y = alpha_xy(m, p)
    slope = ((h[0] / a_x) ** 2 + (h[1] / a_y) ** 2) / h[2] ** 2
    return m.exp(-slope) / (m.pi * a_x * a_y * h[2] ** 4)


def blinn_phong_exponent(alpha):
    """The shininess n whose highlight is as wide as Beckmann's m = alpha."""
    return 2 / alpha**2 - 2


def d_blinn_phong(m, p, h):
    """Walter et al. 2007, Eq. 30."""
    n = blinn_phong_exponent(p["alpha"])
    return (n + 2) / (2 * m.pi) * h[2] ** n


@functools.cache
def gaussian_constant(width):
    """c with the integral of c exp(-(theta/width)^2) cos(theta) over the hemisphere 1.

    The integral is pi times that of exp(-(theta/width)^2) sin(2 theta) over 0..pi/2: the imaginary
    part of a Gaussian integral with exponent 2 i theta, which is an error function.
    """
    end = mp.erf(mp.pi / (2 * width) - 1j * width) - mp.erf(-1j * width)
    integral = mp.im(mp.sqrt(mp.pi) / 2 * width * mp.exp(-(width**2)) * end)
    return 1 / (mp.pi * integral)


def d_gaussian(m, p, h):
    """c exp(-(theta/m)^2), named in Cook & Torrance 1982, with the c that normalises it."""
    theta = m.atan2(m.sqrt(h[0] ** 2 + h[1] ** 2), h[2])
    return m.number(gaussian_constant(mpf(p["alpha"]))) * m.exp(-((theta / p["alpha"]) ** 2))


def d_gtr1(m, cos_h, a):
    """Burley 2012, Eq. 4: tail exponent 1, for the clearcoat."""
    return (a**2 - 1) / (m.pi * m.log(a**2) * (1 + (a**2 - 1) * cos_h**2))


DISTRIBUTIONS = {
    "ggx": d_ggx,
    "beckmann": d_beckmann,
    "blinn_phong": d_blinn_phong,
    "gaussian": d_gaussian,
}

# Part 2: masking and shadowing.


def lambda_ggx(m, t):
    """Heitz 2014, Eq. 72, with t = alpha tan(theta)."""
    return (m.sqrt(1 + t**2) - 1) / 2


def lambda_beckmann(m, t):
    """Heitz 2014, Eq. 66: the exact one, with the error function."""
    a = 1 / m.maximum(t, m.number("1e-30"))
    return (m.exp(-(a**2)) / (a * m.sqrt(m.pi)) - m.erfc(a)) / 2


def lambda_beckmann_fit(t):
    """Walter et al. 2007, below Eq. 27 (not used by the models; a fit of the above)."""
    if t * mpf("1.6") <= 1:
        return mpf(0)
    c = 1 / t
    g1 = (mpf("3.535") * c + mpf("2.181") * c**2) / (1 + mpf("2.276") * c + mpf("2.577") * c**2)
    return 1 / g1 - 1


def smith_lambda(m, p, w):
    """Lambda of the distribution; Blinn-Phong and Gaussian take Beckmann's of the same alpha."""
    a_x, a_y = alpha_xy(m, p)
    if p["distribution"] not in ("ggx", "beckmann"):
        a_x = a_y = p["alpha"]
    t = m.sqrt((a_x * w[0]) ** 2 + (a_y * w[1]) ** 2) / w[2]
    return (lambda_ggx if p["distribution"] == "ggx" else lambda_beckmann)(m, t)


def schlick_g1(mu, k):
    """Schlick 1994."""
    return mu / (mu * (1 - k) + k)


def masking(m, p, wi, wo, h):
    """G; the names and forms of Karis, Specular BRDF Reference, 2013, and Heitz 2014, Eq. 99."""
    kind, mu_i, mu_o, cos_d = p["masking"], wi[2], wo[2], dot(wo, h)
    if kind == "smith_correlated":
        return 1 / (1 + smith_lambda(m, p, wi) + smith_lambda(m, p, wo))
    if kind == "smith":
        return 1 / ((1 + smith_lambda(m, p, wi)) * (1 + smith_lambda(m, p, wo)))
    if kind == "cook_torrance":
        return m.minimum(m.number(1), 2 * h[2] * m.minimum(mu_i, mu_o) / cos_d)
    if kind == "kelemen":
        return mu_i * mu_o / cos_d**2
    if kind == "neumann":
        return mu_i * mu_o / m.maximum(mu_i, mu_o)
    if kind == "implicit":
        return mu_i * mu_o
    k = p["alpha"] * {"schlick_ggx": m.number("0.5"), "schlick_beckmann": m.sqrt(2 / m.pi)}[kind]
    return schlick_g1(mu_i, k) * schlick_g1(mu_o, k)


MASKINGS = [
    "smith_correlated",
    "smith",
    "cook_torrance",
    "kelemen",
    "neumann",
    "implicit",
    "schlick_ggx",
    "schlick_beckmann",
]

# Part 3: Fresnel.


def fresnel_exact(m, cos_d, eta, k):
    """Unpolarised reflectance at a complex index eta + i k; total reflection included."""
    index = (eta + 1j * k) ** 2
    root = m.sqrt(index - (1 - cos_d**2))
    r_s = abs((cos_d - root) / (cos_d + root)) ** 2
    r_p = abs((index * cos_d - root) / (index * cos_d + root)) ** 2
    return (r_s + r_p) / 2


def schlick(cos_d, f0, f90=1):
    """Schlick 1994."""
    return f0 + (f90 - f0) * (1 - cos_d) ** 5


def lazanyi(cos_d, eta, k):
    """Lazanyi & Szirmay-Kalos 2005, without their error compensation."""
    return ((eta - 1) ** 2 + 4 * eta * (1 - cos_d) ** 5 + k**2) / ((eta + 1) ** 2 + k**2)


def fresnel(m, p, cos_d):
    """F per channel."""
    kind = p["fresnel"]
    if kind == "white":
        return [m.number(1) + 0 * cos_d] * 3
    if kind == "schlick":
        return [schlick(cos_d, *f) for f in zip(p["f0"], p["f90"], strict=True)]
    if kind == "dielectric":
        return [fresnel_exact(m, cos_d, eta, m.number(0)) for eta in p["eta"]]
    law = {"conductor": functools.partial(fresnel_exact, m), "lazanyi": lazanyi}[kind]
    return [law(cos_d, eta, k) for eta, k in zip(p["eta"], p["k"], strict=True)]


FRESNELS = ["conductor", "dielectric", "schlick", "lazanyi", "white"]

# Part 4: BRDFs. Each takes the arithmetic m, the parameters p, wi and wo, and returns linear RGB.


def torrance_sparrow(m, p, wi, wo):
    """F D G / (4 mu_i mu_o), Torrance & Sparrow 1967, Cook & Torrance 1982."""
    h = half_vector(m, wi, wo)
    factor = DISTRIBUTIONS[p["distribution"]](m, p, h) * masking(m, p, wi, wo, h)
    single = [f * factor / (4 * wi[2] * wo[2]) for f in fresnel(m, p, dot(wo, h))]
    if p.get("diffuse") != "lambert":
        return single
    # Elek 2010, Algorithm 1, line 23, whose light carries a factor pi
    matte = [r * (1 - f) / m.pi for r, f in zip(p["rho"], fresnel(m, p, dot(wo, h)), strict=True)]
    return [s + d for s, d in zip(single, matte, strict=True)]


def torrance_sparrow_pdf(p, wi, wo):
    """Density of wi: of visible normals or of all normals, over 4 wo.H.

    For GGX, and for Blinn-Phong with a masking that is no larger than Smith's: visible GGX normals, and
    what they mirror below the horizon is mirrored up again.
    """
    h = half_vector(Exact, wi, wo)
    if p["distribution"] == "beckmann":
        return visible_pdf(p, h, wo)
    if p["distribution"] == "ggx" or p["masking"] not in ("cook_torrance", "kelemen"):
        return cap_pdf(p, wi, wo) + cap_pdf(p, (wi[0], wi[1], -wi[2]), wo)
    return DISTRIBUTIONS[p["distribution"]](Exact, p, h) * h[2] / (4 * dot(wo, h))


def cap_pdf(p, wi, wo):
    """Density of wo mirrored at GGX normals that are drawn by a uniform direction in a cap.

    By the change of variables alone: where facets are stretched to a hemisphere, they mirror wo into a cap
    of directions around the normal, uniformly, down to what is opposite (Dupuy & Benyoub 2023).
    """
    ax, ay = alpha_xy(Exact, p)
    if wi[2] + wo[2] <= 0:  # no facet mirrors wo that far down
        return mpf(0)
    h = half_vector(Exact, wi, wo)
    squeezed = (h[0] / ax, h[1] / ay, h[2])
    size = mp.sqrt(dot(squeezed, squeezed))
    normal = tuple(x / size for x in squeezed)
    seen = (ax * wo[0], ay * wo[1], wo[2])
    seen = tuple(x / mp.sqrt(dot(seen, seen)) for x in seen)
    height = 2 * dot(seen, normal) * normal[2] - seen[2]
    assert height >= -seen[2]
    uniform = 1 / (2 * mp.pi * (1 + seen[2]))
    # To the stretched normal, to the normal (a linear map with the determinant 1 / (ax ay)), and to wi
    return uniform * 4 * dot(seen, normal) / (ax * ay * size**3) / (4 * dot(wo, h))


def visible_pdf(p, h, wo):
    """Density of wo mirrored at visible normals."""
    d = DISTRIBUTIONS[p["distribution"]](Exact, p, h)
    visible = d * dot(wo, h) / ((1 + smith_lambda(Exact, p, wo)) * wo[2])
    return visible / (4 * dot(wo, h))


def phong(m, p, wi, wo):
    """Phong 1975: classical is his radiance over mu_i, normalized is Lafortune & Willems 1994."""
    n = p["shininess"]
    cos_a = m.maximum(wi[2] * wo[2] - wi[0] * wo[0] - wi[1] * wo[1], m.number(0))
    factor = {"normalized": (n + 2) / (2 * m.pi), "classical": 1 / wi[2]}[p["form"]]
    return [
        rho / m.pi + specular * factor * cos_a**n
        for rho, specular in zip(p["rho"], p["specular"], strict=True)
    ]


def blinn(m, p, wi, wo):
    """Blinn 1977: p_d (N.L) + p_s (N.H)^n, over N.L."""
    lobe = half_vector(m, wi, wo)[2] ** p["shininess"] / wi[2]
    return [
        rho / m.pi + specular * lobe for rho, specular in zip(p["rho"], p["specular"], strict=True)
    ]


def triace_blinn_phong(m, p, wi, wo):
    """Gotanda 2012, Eq. 1, and Eq. 25 for a rough diffuse part."""
    n, h = p["shininess"], half_vector(m, wi, wo)
    factor = m.number("0.0397436") * n + m.number("0.0856832")
    lobe = factor * h[2] ** n / m.maximum(wi[2], wo[2])
    shape = m.number(1)
    if p.get("diffuse") == "oren_nayar":  # Eq. 25: t = 1 where s is negative
        s = wi[0] * wo[0] + wi[1] * wo[1]
        s = s / m.maximum(wi[2], wo[2]) if s > 0 else s
        shape = 1 - 1 / (2 + m.number("0.65") * n) + s / (m.number("2.22222") + m.number("0.1") * n)
    return [
        rho / m.pi * (1 - f0) * shape + schlick(dot(wo, h), f0) * lobe
        for rho, f0 in zip(p["rho"], p["f0"], strict=True)
    ]


def ggx_isotropic(m, cos_h, alpha):
    """D as the engines write it."""
    return alpha**2 / (m.pi * (cos_h**2 * (alpha**2 - 1) + 1) ** 2)


def metallic_roughness(m, p, wi, wo):
    """F0 = lerp(0.04, base colour, metallic); what is not reflected reaches a Lambert base."""
    alpha, h = p["roughness"] ** 2, half_vector(m, wi, wo)
    lambda_i, lambda_o = (
        lambda_ggx(m, alpha * m.sqrt(w[0] ** 2 + w[1] ** 2) / w[2]) for w in (wi, wo)
    )
    g = {
        "smith_correlated": 1 / (1 + lambda_i + lambda_o),
        "smith": 1 / ((1 + lambda_i) * (1 + lambda_o)),
    }[p["masking"]]
    lobe = ggx_isotropic(m, h[2], alpha) * g / (4 * wi[2] * wo[2])
    result = []
    for c in p["base_color"]:
        f = schlick(dot(wo, h), lerp(m.number("0.04"), c, p["metallic"]))
        result.append((1 - f) * c * (1 - p["metallic"]) / m.pi + f * lobe)
    return result


def ue4(m, p, wi, wo):
    """Karis 2013, with Schlick's Fresnel term itself, not its spherical-Gaussian form."""
    r, alpha, h = p["roughness"], p["roughness"] ** 2, half_vector(m, wi, wo)
    k = {"punctual": (r + 1) ** 2 / 8, "image": alpha / 2}[p["light"]]
    lobe = ggx_isotropic(m, h[2], alpha) * schlick_g1(wi[2], k) * schlick_g1(wo[2], k)
    result = []
    for c in p["base_color"]:
        f = schlick(dot(wo, h), lerp(m.number("0.08") * p["specular"], c, p["metallic"]))
        result.append(c * (1 - p["metallic"]) / m.pi + f * lobe / (4 * wi[2] * wo[2]))
    return result


def disney_retro(cos_d, wi, wo, roughness):
    """Burley 2012, section 5.3: the diffuse factor."""
    f90 = 2 * cos_d**2 * roughness + cos_d**0 / 2
    return lerp(1, f90, (1 - wi[2]) ** 5) * lerp(1, f90, (1 - wo[2]) ** 5)


def unity_colours(m, p):
    """DiffuseAndSpecularFromMetallic of UnityStandardUtils.cginc, in linear space."""
    dielectric = m.number("0.04")
    return [
        (c * (1 - p["metallic"]) * (1 - dielectric), lerp(dielectric, c, p["metallic"]))
        for c in p["base_color"]
    ]


def unity_standard(m, p, wi, wo):
    """BRDF1 of UnityStandardBRDF.cginc over pi, without its guards 1e-5 (V) and 1e-7 (D)."""
    r, h = p["roughness"], half_vector(m, wi, wo)
    alpha = m.maximum(r**2, m.number("0.002"))
    lambda_v = wi[2] * (wo[2] * (1 - alpha) + alpha)
    lambda_l = wo[2] * (wi[2] * (1 - alpha) + alpha)
    lobe = ggx_isotropic(m, h[2], alpha) / (2 * (lambda_v + lambda_l))
    diffuse = disney_retro(dot(wi, h), wi, wo, r) / m.pi
    return [d * diffuse + schlick(dot(wi, h), s) * lobe for d, s in unity_colours(m, p)]


def unity_brdf2(m, p, wi, wo):
    """BRDF2 of UnityStandardBRDF.cginc (GGX, linear space) over pi."""
    a, h = p["roughness"] ** 2, half_vector(m, wi, wo)
    d = h[2] ** 2 * (a**2 - 1) + m.number("1.00001")
    guarded = m.maximum(m.number("0.1"), dot(wi, h) ** 2)
    lobe = a**2 / (guarded * (a + m.number("0.5")) * d**2 * 4)
    return [(diffuse + specular * lobe) / m.pi for diffuse, specular in unity_colours(m, p)]


def disney_g(m, mu, alpha):
    """G1 / (2 mu) of GGX, smithG_GGX of disney.brdf."""
    return 1 / (mu + m.sqrt(alpha**2 + mu**2 - alpha**2 * mu**2))


def disney(m, p, wi, wo):
    """Burley 2012 and its disney.brdf, base colour taken as linear, G with the 2012 remapping."""
    colour, metallic, r = p["base_color"], p["metallic"], p["roughness"]
    mu_i, mu_o, h = wi[2], wo[2], half_vector(m, wi, wo)
    cos_d = dot(wi, h)
    f_h = (1 - cos_d) ** 5
    luminance = sum(m.number(w) * c for w, c in zip(("0.3", "0.6", "0.1"), colour, strict=True))

    fss90 = cos_d**2 * r
    fss = lerp(1, fss90, (1 - mu_i) ** 5) * lerp(1, fss90, (1 - mu_o) ** 5)
    ss = (fss * (1 / (mu_i + mu_o) - m.number("0.5")) + m.number("0.5")) * 5 / 4
    base = lerp(disney_retro(cos_d, wi, wo, r), ss, p["subsurface"]) / m.pi

    aspect = m.sqrt(1 - m.number("0.9") * p["anisotropic"])
    a_x = m.maximum(m.number("0.001"), r**2 / aspect)
    a_y = m.maximum(m.number("0.001"), r**2 * aspect)
    d = 1 / (m.pi * a_x * a_y * ((h[0] / a_x) ** 2 + (h[1] / a_y) ** 2 + h[2] ** 2) ** 2)
    alpha_g = ((1 + r) / 2) ** 2
    lobe = d * disney_g(m, mu_i, alpha_g) * disney_g(m, mu_o, alpha_g)

    a = lerp(m.number("0.1"), m.number("0.001"), p["clearcoat_gloss"])
    quarter = m.number("0.25")
    coat = d_gtr1(m, h[2], a) * disney_g(m, mu_i, quarter) * disney_g(m, mu_o, quarter)
    coat = coat * lerp(m.number("0.04"), 1, f_h) * p["clearcoat"] / 4

    result = []
    for c in colour:
        tint = c / luminance if luminance > 0 else m.number(1)
        f0 = m.number("0.08") * p["specular"] * lerp(1, tint, p["specular_tint"])
        sheen = f_h * p["sheen"] * lerp(1, tint, p["sheen_tint"])
        diffuse = (base * c + sheen) * (1 - metallic)
        result.append(diffuse + lobe * lerp(lerp(f0, c, metallic), 1, f_h) + coat)
    return result


# Part 5: quadrature of the albedo.

# Where, at a given theta_i, the BRDF has a kink in phi (the angle between the two azimuths): its
# cosine times sin_i sin_o; and the theta_i at which that kink enters or leaves.
KINKS = {
    # the two arms of min(1, 2 (N.H) mu / (wo.H)), with |wi + wo|^2 = 4 (mu_i + mu_o) mu
    "cook_torrance": (
        [
            lambda mu_i, mu_o: 2 * mu_o**2 + mu_i * mu_o - 1,
            lambda mu_i, mu_o: 2 * mu_i**2 + mu_i * mu_o - 1,
        ],
        lambda t: [math.pi - 3 * t, 3 * t - math.pi, (math.pi - t) / 3, (math.pi + t) / 3],
    ),
    # wi perpendicular to the mirror direction
    "phong": ([lambda mu_i, mu_o: mu_i * mu_o], lambda t: [math.pi / 2 - t]),
    # (wi.H)^2 = (1 + wi.wo) / 2 = 0.1
    "unity_brdf2": ([lambda mu_i, mu_o: -0.8 - mu_i * mu_o], lambda t: [math.acos(-0.8) - t]),
}


def graded(centre, low, high, finest, ratio):
    """Breaks between low and high that close in on the centre from both sides."""
    breaks, step = {low, high, min(max(centre, low), high)}, finest
    while step < high - low:
        breaks |= {x for x in (centre - step, centre + step) if low < x < high}
        step *= ratio
    return breaks


def panels(breaks, n, smooth):
    """Gauss-Legendre on each panel; `smooth` bends it so that half powers at the ends vanish.

    breaks: (..., number of breaks), sorted. Nodes and weights: (..., nodes).
    """
    t, weight = np.array([[float(x) for x in node] for node in gauss_legendre(n)]).T
    if smooth:
        weight = weight * 6 * t * (1 - t)
        t = t**2 * (3 - 2 * t)
    low, width = breaks[..., :-1, None], np.diff(breaks)[..., None]
    shape = (*breaks.shape[:-1], -1)
    return (low + width * t).reshape(shape), (width * weight).reshape(shape)


def albedo_by_quadrature(model, p, wo, kinks, n, finest, ratio):
    """Integral of f mu_i over the hemisphere, in double precision."""
    p = doubles(p)
    sin_o = math.hypot(wo[0], wo[1])
    theta_o, phi_o = math.atan2(sin_o, wo[2]), math.atan2(wo[1], wo[0])
    cosines, entries = KINKS.get(kinks, ([], lambda t: []))
    breaks = graded(theta_o, 0.0, math.pi / 2, finest, ratio)
    breaks |= graded(math.pi / 2, 0.0, math.pi / 2, finest / 100, ratio)
    breaks |= {t for t in entries(theta_o) if 0 < t < math.pi / 2}
    theta, weight_theta = panels(np.array(sorted(breaks)), n, True)
    sin_i, mu_i = np.sin(theta), np.cos(theta)
    # lobes lie opposite (phi = pi), and their width shrinks towards the horizon; anisotropic ones
    # may lie elsewhere
    fixed = graded(math.pi, 0.0, math.pi, finest / 10, ratio)
    fixed |= {k * math.pi / 6 for k in range(7)}
    phi_breaks = [np.full_like(theta, x) for x in fixed]
    if sin_o > 0:
        for cosine in cosines:
            phi_breaks.append(np.arccos(np.clip(cosine(mu_i, wo[2]) / (sin_i * sin_o), -1.0, 1.0)))
    phi, weight_phi = panels(np.sort(np.stack(phi_breaks, -1), -1), n, False)
    weight = weight_theta[:, None] * weight_phi * (sin_i * mu_i)[:, None]
    total = np.zeros(3)
    for side in (1, -1):
        azimuth = phi_o + side * phi
        wi = (sin_i[:, None] * np.cos(azimuth), sin_i[:, None] * np.sin(azimuth), mu_i[:, None])
        total += [np.sum(weight * f) for f in model(Doubles, p, wi, wo)]
    return [float(x) for x in total]


RULES = [(20, 0.05, 2.6), (26, 0.08, 3.1)]  # nodes per panel, finest panel, their ratio


def albedo(model, p, wo, kinks):
    """The two rules' common value."""
    first, second = (albedo_by_quadrature(model, p, wo, kinks, *rule) for rule in RULES)
    compare(second, first, AGREEMENT, f"albedo of {model.__name__} {p} at {wo}")
    return first


def doubles(p):
    """Parameters as Python floats."""
    return {k: [float(x) for x in v] if isinstance(v, list) else v for k, v in p.items()}


# Part 6: the table.


def mirrored(w):
    """The direction into which a smooth surface reflects w."""
    return (-w[0], -w[1], w[2])


STEEP = at(80, 200)
PAIRS = [
    (NORMAL, NORMAL),
    (at(30, 20), at(55, 50)),  # same side
    (at(40, 200), at(65, 10)),  # roughly opposite
    ((0.6, 0.0, 0.8), (0.0, 0.8, 0.6)),
    (mirrored(RETRO), RETRO),  # exact mirror
    (at(56, 318), RETRO),  # near the mirror
    (RETRO, RETRO),
    (at(12, 300), NORMAL),
    (mirrored(STEEP), STEEP),
    (at(75, 26), STEEP),
    (mirrored(GRAZING), GRAZING),
    (at(50, 275), GRAZING),
    (unit(1e-3, 240), at(77, 55)),
    (unit(1e-3, 248), GRAZING),
    (GRAZING, GRAZING),
]
VIEWS = [NORMAL, at(35, 25), at(60, 115), at(80, 250), at(20, 170)]
VISIBLE = 1e-6  # smaller values would pass a test whatever they are

GOLD = {"eta": [0.143, 0.3749, 1.4424], "k": [3.983, 2.3857, 1.6032]}
CHROMIUM = {"eta": [3.18, 3.18, 2.02], "k": [3.31, 3.33, 2.75]}
INDICES = {"eta": [1.5, 1.33, 2.4]}
INSIDE = {"eta": [0.6666666666666666, 0.75, 0.9]}  # total internal reflection
SCHLICK = {"f0": [0.04, 0.56, 0.95], "f90": [1.0, 0.9, 0.35]}
FRESNEL_SETS = {
    "conductor": [GOLD, CHROMIUM],
    "dielectric": [INDICES, INSIDE],
    "schlick": [SCHLICK, {"f0": [0.0, 0.3, 1.0], "f90": [1.0, 1.0, 1.0]}],
    "lazanyi": [GOLD, CHROMIUM],
    "white": [{}],
}
ALPHAS = [0.3, 0.6, 0.15, 1.0, 0.45]

CLAY, LEAF, BLUE = [0.9, 0.35, 0.04], [0.18, 0.97, 0.62], [0.02, 0.1, 0.75]
WHITE, BLACK = [1.0, 1.0, 1.0], [0.0, 0.0, 0.0]


def torrance_sparrow_sets():
    """Every distribution with every masking and Fresnel, twice, and the anisotropic ones."""
    alphas = itertools.cycle(ALPHAS)
    for distribution, kind, law in itertools.product(DISTRIBUTIONS, MASKINGS, FRESNELS):
        options = {"distribution": distribution, "masking": kind, "fresnel": law}
        for numbers in (FRESNEL_SETS[law] * 2)[:2]:
            yield {"alpha": next(alphas), **numbers, **options}
    for distribution, kind, anisotropy in itertools.product(
        ("ggx", "beckmann"), MASKINGS[:4], (0.35, 0.8, 1.0)
    ):
        options = {"distribution": distribution, "masking": kind, "fresnel": "schlick"}
        yield {"alpha": next(alphas), "anisotropy": anisotropy, **SCHLICK, **options}


def product_sets(**choices):
    """All combinations, as dictionaries."""
    return [
        dict(zip(choices, values, strict=True)) for values in itertools.product(*choices.values())
    ]


PHONG_SETS = [
    {"rho": rho, "specular": specular, "shininess": n, "form": form}
    for form in ("normalized", "classical")
    for rho, specular, n in (
        (CLAY, [0.3, 0.2, 0.1], 20.0),
        (BLACK, WHITE, 2.0),
        (LEAF, [0.02, 0.5, 0.9], 7.5),
        ([0.5, 0.5, 0.5], BLUE, 150.0),
    )
]
BLINN_SETS = [
    {"rho": rho, "specular": specular, "shininess": n}
    for rho, specular, n in (
        (CLAY, [0.3, 0.2, 0.1], 50.0),
        (BLACK, WHITE, 0.0),
        (LEAF, [0.02, 0.5, 0.9], 7.5),
        ([0.5, 0.5, 0.5], BLUE, 400.0),
    )
]
TRIACE_SETS = [
    {"rho": CLAY, "f0": [0.04, 0.04, 0.04], "shininess": 50.0},
    {"rho": LEAF, "f0": [0.95, 0.64, 0.54], "shininess": 10.0},
    {"rho": BLACK, "f0": WHITE, "shininess": 1.0},
    {"rho": BLUE, "f0": [0.02, 0.2, 0.6], "shininess": 200.0},
]
SURFACES = [
    {"base_color": CLAY, "metallic": 0.0, "roughness": 0.5},
    {"base_color": LEAF, "metallic": 1.0, "roughness": 0.4},
    {"base_color": BLUE, "metallic": 0.3, "roughness": 0.75},
    {"base_color": WHITE, "metallic": 0.0, "roughness": 1.0},
    {"base_color": CLAY, "metallic": 0.6, "roughness": 0.33},
]
DISNEY_BASE = {
    "base_color": CLAY,
    "subsurface": 0.0,
    "metallic": 0.0,
    "specular": 0.5,
    "specular_tint": 0.0,
    "roughness": 0.5,
    "anisotropic": 0.0,
    "sheen": 0.0,
    "sheen_tint": 0.5,
    "clearcoat": 0.0,
    "clearcoat_gloss": 1.0,
}
DISNEY_CHANGES = [
    {},
    {"base_color": BLUE},
    {"base_color": BLACK, "sheen": 1.0, "specular_tint": 1.0},  # no hue: the tint is white
    {"subsurface": 1.0},
    {"subsurface": 0.4, "roughness": 0.9},
    {"metallic": 1.0},
    {"metallic": 0.35},
    {"specular": 0.0},
    {"specular": 1.0, "specular_tint": 0.7},
    {"roughness": 0.35},
    {"roughness": 1.0},
    {"anisotropic": 0.8, "metallic": 0.5},
    {"anisotropic": 1.0, "roughness": 0.6},
    {"sheen": 1.0, "sheen_tint": 0.0},
    {"sheen": 0.6, "sheen_tint": 1.0, "base_color": BLUE},
    {"clearcoat": 1.0, "clearcoat_gloss": 0.0},
    {"clearcoat": 0.5, "clearcoat_gloss": 0.6},
    {
        "base_color": LEAF,
        "subsurface": 0.3,
        "metallic": 0.4,
        "specular": 0.8,
        "specular_tint": 0.6,
        "roughness": 0.45,
        "anisotropic": 0.5,
        "sheen": 0.7,
        "sheen_tint": 0.25,
        "clearcoat": 0.9,
        "clearcoat_gloss": 0.2,
    },
]

# Where D, G and F stand, by the options that choose them. Exact Fresnel reflectance is in every textbook.
D_SOURCES = {
    "ggx": "walter2007 Eq. 33",
    "beckmann": "walter2007 Eq. 25",
    "blinn_phong": "walter2007 Eq. 30",
    "gaussian": "cook1982 as exp(-(theta / m)^2) normalised",
}
G_SOURCES = {
    "smith_correlated": "heitz2014 Eq. 99",
    "smith": "walter2007 Eq. 23",
    "smith_walter": "walter2007 fit below Eq. 27",
    "cook_torrance": "cook1982 as G of V-grooves",
    "kelemen": "kelemen2001 as G / (mu_i mu_o) = 1 / (wo.m)^2",
    "neumann": "neumann1999 as 1 / max(mu_i, mu_o)",
    "implicit": "pbrtheory2019 section 4.2.3",
    "schlick_ggx": "karis2013 section Specular G for image-based light",
    "schlick_beckmann": "schlick1994 as G with k = alpha sqrt(2 / pi)",
}
F_SOURCES = {"schlick": ["schlick1994 Eq. 15"], "lazanyi": ["lazanyi2005 Eq. 4"]}


def facet_sources(p):
    """The publications of one choice of D, G and F."""
    stretched = ["burley2012 Eq. 13 for anisotropic D"] if p.get("anisotropy") else []
    return [
        "walter2007 Eq. 20",
        D_SOURCES[p["distribution"]],
        *stretched,
        G_SOURCES[p["masking"]],
        *F_SOURCES.get(p["fresnel"], []),
    ]


# model: (function, parameter sets, pairs of directions per set, publications or a function that tells them)
MODELS = {
    "torrance_sparrow": (
        torrance_sparrow,
        list(torrance_sparrow_sets()),
        1,
        facet_sources,
    ),
    "phong": (
        phong,
        PHONG_SETS,
        5,
        [
            "phong1975 as cos^n of the angle to the mirror direction",
            "lafortune1994 as (n + 2) / (2 pi) cos^n",
        ],
    ),
    "triace_blinn_phong": (triace_blinn_phong, TRIACE_SETS, 6, ["gotanda2012 Eq. 1"]),
    "metallic_roughness": (
        metallic_roughness,
        [
            {**s, **o}
            for o, s in itertools.product(
                product_sets(masking=("smith_correlated", "smith")), SURFACES
            )
        ],
        4,
        ["pbrtheory2019 section 4 as k_d = 1 - F and F0 = lerp(0.04, base colour, metallic)"],
    ),
    "ue4": (
        ue4,
        [
            {**s, **o}
            for o, s in zip(
                product_sets(light=("punctual", "image"), specular=(0.5, 1.0, 0.1, 0.0, 0.35)),
                SURFACES * 2,
                strict=True,
            )
        ],
        4,
        ["karis2013 sections Diffuse BRDF and Specular D, G, F", "schlick1994 Eq. 15"],
    ),
    "unity_standard": (
        unity_standard,
        SURFACES,
        6,
        ["unity2018 BRDF1_Unity_PBS in linear space with GGX, over pi"],
    ),
    "unity_brdf2": (
        unity_brdf2,
        SURFACES,
        6,
        ["unity2018 BRDF2_Unity_PBS in linear space with GGX, over pi"],
    ),
    "disney": (
        disney,
        [{**DISNEY_BASE, **change} for change in DISNEY_CHANGES],
        4,
        [
            "burley2012 section 5 and appendix B with alpha_g = (0.5 + roughness / 2)^2",
            "brdfexplorer disney.brdf with a linear base colour",
        ],
    ),
    "blinn": (blinn, BLINN_SETS, 5, ["blinn1977 as (N.H)^c in place of Phong's cosine"]),
}
# Roughnesses below the models' own lower limits (alpha 0.002 and 0.001; BRDF2 has none, and loses its
# highlight), seen along the normal, where no rounding is amplified.
CLAMPED = {
    "unity_standard": [{"base_color": CLAY, "metallic": 0.5, "roughness": r} for r in (0.02, 0.0)],
    "unity_brdf2": [{"base_color": CLAY, "metallic": 0.5, "roughness": r} for r in (0.03, 0.0)],
    "disney": [{**DISNEY_BASE, "metallic": 0.5, "roughness": r} for r in (0.02, 0.0)],
}


def is_reciprocal(name, p):
    """Phong's and Blinn's radiance has no cosine to divide out."""
    return name != "blinn" and p.get("form") != "classical"


def sources_of(name, p):
    """The publications of a model with certain parameters."""
    publications = MODELS[name][3]
    return publications(p) if callable(publications) else publications


def eval_rows(name):
    """Each parameter set with a few pairs of directions, taken in turn."""
    model, parameter_sets, count, _ = MODELS[name]
    pairs = itertools.cycle(PAIRS)
    for p in parameter_sets:
        chosen = []
        while len(chosen) < count:
            wi, wo = next(pairs)
            value = model(Exact, exact(p), exact(wi), exact(wo))
            if max(value) > VISIBLE:
                chosen.append((wi, wo, value))
        for wi, wo, value in chosen:
            if is_reciprocal(name, p):
                swapped = model(Exact, exact(p), exact(wo), exact(wi))
                ratio = [s / v if v else mpf(1) for s, v in zip(swapped, value, strict=True)]
                compare(ratio, [mpf(1)] * 3, UNIT_TO, f"reciprocity of {name} {p}")
            arrays = model(Doubles, doubles(p), [np.array([x]) for x in wi], wo)
            ratio = [float(a[0] / v) if v else 1.0 for a, v in zip(arrays, value, strict=True)]
            compare(ratio, [1.0] * 3, 1e-10, f"double precision of {name} {p}")
            found_by = source(BY_FORMULA, sources_of(name, p), HERE, name)
            yield row(name, p, wi, wo, "eval", value, found_by)
    for p in CLAMPED.get(name, []):
        value = model(Exact, exact(p), exact(NORMAL), exact(NORMAL))
        found_by = source(BY_FORMULA, sources_of(name, p), HERE, name)
        yield row(name, p, NORMAL, NORMAL, "eval", value, found_by)


def kinks_of(name, p):
    """The entry of KINKS that the model needs."""
    return p["masking"] if p.get("masking") == "cook_torrance" else name


def albedo_sets(name):
    """Parameter sets and views: all maskings of the one model, all sets of the others."""
    views = itertools.cycle(VIEWS)
    if name != "torrance_sparrow":
        for p in MODELS[name][1]:
            if p.get("clearcoat", 0) == 0 or p["clearcoat_gloss"] < 0.5:  # wide enough lobes
                yield p, next(views)
        return
    laws, alphas = itertools.cycle(FRESNELS), itertools.cycle([0.3, 0.5, 0.2, 0.8, 0.12, 1.0])
    for distribution, kind, _ in itertools.product(DISTRIBUTIONS, MASKINGS, range(2)):
        law = next(laws)
        options = {"distribution": distribution, "masking": kind, "fresnel": law}
        yield {"alpha": next(alphas), **FRESNEL_SETS[law][0], **options}, next(views)
    for distribution, view in itertools.product(("ggx", "beckmann"), VIEWS[1:4]):
        options = {"distribution": distribution, "masking": "smith_correlated", "fresnel": "white"}
        yield {"alpha": 0.35, "anisotropy": 0.7, **options}, view
    for distribution in DISTRIBUTIONS:
        options = {"distribution": distribution, "masking": "smith", "fresnel": "white"}
        yield {"alpha": 0.4, **options}, GRAZING


def albedo_rows(name):
    """Quadratures."""
    model = MODELS[name][0]
    for p, wo in albedo_sets(name):
        value = albedo(model, p, wo, kinks_of(name, p))
        found_by = source(BY_QUADRATURE, sources_of(name, p), HERE, name)
        yield row(name, p, None, wo, "albedo", value, found_by)


def pdf_rows():
    """Visible normals for GGX and Beckmann, all normals for Blinn-Phong; Gaussian's has no inverse."""
    sources = {
        "ggx": ("visible normals, folded", "dupuy2023 Listing 3"),
        "beckmann": ("visible normals, G1(wo) D / (4 mu_o)", "heitz2014 Eq. 16 and 66"),
        "blinn_phong": ("normals by D, D (m.z) / (4 wo.m)", "walter2007 Eq. 14"),
    }
    maskings = {
        "ggx": ("smith", "smith_correlated", "smith"),
        "beckmann": ("smith", "smith_correlated", "smith"),
        "blinn_phong": ("cook_torrance", "kelemen", "cook_torrance"),
    }
    pairs = itertools.cycle(PAIRS)
    cases = [
        {"alpha": alpha, "distribution": d, "masking": kind, "fresnel": "white"}
        for d in sources
        for alpha, kind in zip((0.3, 0.6, 0.15), maskings[d], strict=True)
    ]
    cases += [
        {"alpha": 0.4, "anisotropy": a, "distribution": d, "masking": "smith", "fresnel": "white"}
        for d, a in itertools.product(("ggx", "beckmann"), (0.5, 1.0))
    ]
    folded = {"distribution": "blinn_phong", "masking": "smith_correlated", "fresnel": "white"}
    cases += [{"alpha": alpha, **folded} for alpha in (0.3, 1.0)]
    for p in cases:
        count = 0
        while count < 4:
            wi, wo = next(pairs)
            value = torrance_sparrow_pdf(exact(p), exact(wi), exact(wo))
            if value > VISIBLE:
                count += 1
                d = p["distribution"]
                drawn, publication = sources[d]
                if d == "blinn_phong" and p["masking"] not in maskings[d]:
                    drawn, publication = sources["ggx"]
                publications = [publication, D_SOURCES[d]]
                found_by = source(
                    f"{BY_FORMULA}, {drawn}", publications, HERE, "torrance_sparrow_pdf"
                )
                yield row("torrance_sparrow", p, wi, wo, "pdf", value, found_by)


def rough_rows():
    """tri-Ace's single layer over a rough diffuse part."""
    for p in TRIACE_SETS[:2]:
        p = {**p, "diffuse": "oren_nayar"}
        for wi, wo in PAIRS[:6]:
            value = triace_blinn_phong(Exact, exact(p), exact(wi), exact(wo))
            found_by = source(
                BY_FORMULA, ["gotanda2012 Eq. 1", "gotanda2012 Eq. 25"], HERE, "triace_blinn_phong"
            )
            yield row("triace_blinn_phong", p, wi, wo, "eval", value, found_by)


def matte_rows():
    """Facets over a matte part: values for every F, and an albedo for each."""
    pairs, views = itertools.cycle(PAIRS), itertools.cycle(VIEWS)
    for law, (distribution, kind) in zip(
        FRESNELS,
        [
            ("beckmann", "cook_torrance"),
            ("ggx", "smith_correlated"),
            ("blinn_phong", "smith"),
            ("gaussian", "cook_torrance"),
            ("ggx", "smith"),
        ],
        strict=True,
    ):
        options = {"distribution": distribution, "masking": kind, "fresnel": law}
        p = {"alpha": 0.3, **FRESNEL_SETS[law][0], **options, "diffuse": "lambert", "rho": CLAY}
        publications = ["elek2010 Algorithm 1 line 23", *facet_sources(p)]
        for _ in range(4):
            wi, wo = next(pairs)
            value = torrance_sparrow(Exact, exact(p), exact(wi), exact(wo))
            found_by = source(BY_FORMULA, publications, HERE, "matte_rows")
            yield row("torrance_sparrow", p, wi, wo, "eval", value, found_by)
        wo = next(views)
        value = albedo(torrance_sparrow, p, wo, kinks_of("torrance_sparrow", p))
        found_by = source(BY_QUADRATURE, publications, HERE, "matte_rows")
        yield row("torrance_sparrow", p, None, wo, "albedo", value, found_by)


ROUNDED_TRIACE = {1.0: "0.36", 10.0: "0.73", 50.0: "0.93", 100.0: "0.96"}
ROUNDED_BECKMANN = "0.996"


def rounded_rows():
    """Numbers as docs/formulas.md prints them, each compared with this derivation."""
    options = {"distribution": "beckmann", "masking": "cook_torrance", "fresnel": "white"}
    p = {"alpha": 0.3, **options}
    found = albedo(torrance_sparrow, p, NORMAL, "cook_torrance")
    compare(found, [float(ROUNDED_BECKMANN)] * 3, 5e-4, "rounded albedo of Beckmann")
    found_by = source(BY_ROUNDING.format(3), facet_sources(p), HERE, "torrance_sparrow")
    value = "[" + ", ".join([ROUNDED_BECKMANN] * 3) + "]"
    yield row("torrance_sparrow", p, None, NORMAL, "albedo", value, found_by)
    publications = MODELS["triace_blinn_phong"][3]
    found_by = source(BY_ROUNDING.format(2), publications, HERE, "triace_blinn_phong")
    for n, printed in ROUNDED_TRIACE.items():
        p = {"rho": BLACK, "f0": WHITE, "shininess": n}
        found = albedo(triace_blinn_phong, p, NORMAL, None)
        compare(found, [float(printed)] * 3, 5e-3, f"rounded albedo at n = {n}")
        value = "[" + ", ".join([printed] * 3) + "]"
        yield row("triace_blinn_phong", p, None, NORMAL, "albedo", value, found_by)


def blinn_rows():
    """The highlight alone from the normal, where H halves the angle: 8 pi / (n + 2) (1 - 2^(-n/2 - 1))."""
    for n in (0.0, 5.0, 23.0, 1000.0):
        p = {"rho": BLACK, "specular": WHITE, "shininess": n}
        value = 8 * mp.pi / (mpf(n) + 2) * (1 - mpf(2) ** (-mpf(n) / 2 - 1))
        found_by = source(f"{BY_FORMULA}, closed form", MODELS["blinn"][3], HERE, "blinn_rows")
        yield row("blinn", p, None, NORMAL, "albedo", [value] * 3, found_by)


def check_parts():
    """Every D has projected area 1; Lambda makes the projected area of what is visible mu_o."""
    for name, d in DISTRIBUTIONS.items():
        for alpha in (mpf("0.1"), mpf("0.5"), mpf(1)):
            p = {"alpha": alpha, "distribution": name}

            def facet_area(theta, d=d, p=p):
                h = (mp.sin(theta), mpf(0), mp.cos(theta))
                return d(Exact, p, h) * mp.sin(2 * theta) * mp.pi

            with mp.workdps(20):
                total = mp.quad(facet_area, [0, alpha / 4, alpha / 2, alpha, mp.pi / 2])
            compare([total], [mpf(1)], mpf("1e-15"), f"area of {name} at {alpha}")
    for name, alpha, anisotropy, degrees in itertools.product(
        ("ggx", "beckmann"), (0.2, 0.7), (0.0, 0.8), (40, 80)
    ):
        p = {"alpha": alpha, "anisotropy": anisotropy, "distribution": name}
        wo = at(degrees, 35)
        hidden_from = math.pi / 2 - math.radians(degrees)
        breaks = graded(hidden_from, 0.0, math.pi / 2, 0.01, 2)
        breaks |= graded(0.0, 0.0, math.pi / 2, 0.02, 2)
        theta, weight_theta = panels(np.array(sorted(breaks)), 16, True)
        # facets face the viewer for cos(phi) > -1/(tan(theta_o) tan(theta))
        edge = np.arccos(np.clip(-wo[2] / math.hypot(*wo[:2]) / np.tan(theta), -1, 1))
        phi, weight_phi = panels(np.linspace(np.zeros_like(edge), edge, 7, axis=-1), 24, False)
        visible = 0.0
        for side in (1, -1):
            azimuth = math.radians(35) + side * phi
            sin_h = np.sin(theta)[:, None]
            h = (sin_h * np.cos(azimuth), sin_h * np.sin(azimuth), np.cos(theta)[:, None])
            density = DISTRIBUTIONS[name](Doubles, p, h) * np.maximum(dot(wo, h), 0.0)
            visible += np.sum(weight_theta[:, None] * weight_phi * sin_h * density)
        g1 = 1 / (1 + smith_lambda(Doubles, p, np.array(wo)))
        compare([float(g1 * visible)], [wo[2]], AGREEMENT, f"visible area of {p} at {degrees}")


def main():
    """Rewrite anchors_specular.csv next to this file."""
    check_parts()
    rows = list(rounded_rows())
    for name in MODELS:
        rows += [*eval_rows(name), *albedo_rows(name)]
    rows += pdf_rows()
    rows += rough_rows()
    rows += blinn_rows()
    rows += matte_rows()
    path = pathlib.Path(__file__).with_name("anchors_specular.csv")
    with path.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["model", "parameters", "wi", "wo", "quantity", "value", "source"])
        writer.writerows(rows)


if __name__ == "__main__":
    main()
