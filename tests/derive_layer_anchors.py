"""Derive tests/anchors_layers.csv: values that the layered models must reproduce, computed without them.

`python tests/derive_layer_anchors.py` rewrites the table (seconds). Needs mpmath only, and must never
import the package under test. Each model is written down once, straight from Elek (CESCG 2010) and Gotanda
(SIGGRAPH 2012), with the refracted angles from Snell's law and Fresnel's equations in their textbook form,
and with no thought for rounding: mpmath carries 40 digits.

Conventions: wi towards the light, wo towards the viewer, both unit, N = +z. `eval` is the BRDF in 1/sr
without the cosine, `albedo` the directional one. The directions in the table are doubles, and the values
belong to exactly those doubles.
"""

import csv
import functools
import json
import math
import pathlib

from mpmath import acos, cos, erf, exp, log, mp, mpc, mpf, nstr, pi, quad, sin, sqrt

mp.dps = 40
HERE = "tests/derive_layer_anchors.py"
BY_FORMULA = "derived: mpmath, 40 digits"


def dot(a, b):
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def unit(a):
    """Scaled to length 1."""
    length = sqrt(dot(a, a))
    return tuple(x / length for x in a)


def half(wi, wo):
    """Half vector."""
    return unit(tuple(a + b for a, b in zip(wi, wo, strict=True)))


def fresnel(cos_i, n):
    """Unpolarised reflectance at a boundary with the (complex) relative index n: Fresnel's equations."""
    cos_t = sqrt(1 - (1 - cos_i**2) / n**2)
    r_s = (cos_i - n * cos_t) / (cos_i + n * cos_t)
    r_p = (n * cos_i - cos_t) / (n * cos_i + cos_t)
    return (abs(r_s) ** 2 + abs(r_p) ** 2) / 2


def schlick(f0, c):
    """Schlick's approximation."""
    return f0 + (1 - f0) * (1 - c) ** 5


def refract(w, n):
    """Snell's law; the tangential part keeps its direction."""
    sin2 = (w[0] ** 2 + w[1] ** 2) / n**2
    return (w[0] / n, w[1] / n, sqrt(1 - sin2))


def beckmann(cos_m, m):
    """exp(-tan^2 / m^2) / (pi m^2 cos^4)."""
    tan2 = (1 - cos_m**2) / cos_m**2
    return exp(-tan2 / m**2) / (pi * m**2 * cos_m**4)


def ggx(cos_m, a):
    """a^2 / (pi ((N.H)^2 (a^2 - 1) + 1)^2)."""
    return a**2 / (pi * (cos_m**2 * (a**2 - 1) + 1) ** 2)


def blinn_phong(cos_m, a):
    """(n + 2) / (2 pi) (N.H)^n with n = 2 / a^2 - 2."""
    n = 2 / a**2 - 2
    return (n + 2) / (2 * pi) * cos_m**n


@functools.cache
def gaussian_area(a):
    """Integral of exp(-(theta / a)^2) cos(theta) over the hemisphere, by quadrature."""
    ends = [0, *(k * a for k in (1, 2, 4, 7) if k * a < pi / 2), pi / 2]
    return quad(lambda t: 2 * pi * exp(-((t / a) ** 2)) * cos(t) * sin(t), ends)


def gaussian(cos_m, a):
    """c exp(-(theta / a)^2), with the c that normalises it."""
    return exp(-((acos(cos_m) / a) ** 2)) / gaussian_area(a)


DISTRIBUTIONS = {
    "beckmann": beckmann,
    "ggx": ggx,
    "blinn_phong": blinn_phong,
    "gaussian": gaussian,
}


def smith_correlated(mu_i, mu_o, a):
    """1 / (1 + Lambda_i + Lambda_o) of GGX."""

    def big_lambda(mu):
        return (sqrt(1 + a**2 * (1 - mu**2) / mu**2) - 1) / 2

    return 1 / (1 + big_lambda(mu_i) + big_lambda(mu_o))


def smith_correlated_beckmann(mu_i, mu_o, a):
    """The same with Lambda of Beckmann: (erf(x) - 1) / 2 + exp(-x^2) / (2 x sqrt(pi)), x = 1 / (a tan)."""

    def big_lambda(mu):
        x = mu / (a * sqrt(1 - mu**2))
        return (erf(x) - 1 + exp(-(x**2)) / (x * sqrt(pi))) / 2

    return 1 / (1 + big_lambda(mu_i) + big_lambda(mu_o))


def cook_torrance(mu_i, mu_o, cos_m, cos_h):
    """min(1, 2 (N.H) mu_o / (wo.H), 2 (N.H) mu_i / (wo.H))."""
    return min(mpf(1), 2 * cos_m * mu_o / cos_h, 2 * cos_m * mu_i / cos_h)


def kept(sigma, d, wi_t, wo_t):
    """exp(-sigma d (1 / mu_i' + 1 / mu_o'))."""
    return exp(-sigma * d * (1 / wi_t[2] + 1 / wo_t[2]))


def diffuse_fresnel(n):
    """Integral of 2 F(mu) mu over mu."""
    return quad(lambda mu: 2 * mu * fresnel(mu, n), [0, mpf("0.01"), mpf("0.1"), 1])


# Models. Each returns three numbers (linear RGB).


def base_value(p, wi, wo, alpha_min):
    """The base of a coat: Lambert, white GGX, or another coat."""
    kind = p.get("base", "lambert")
    inner = {k[5:]: v for k, v in p.items() if k.startswith("base.")}
    if kind == "lambert":
        return [rho / pi for rho in inner["rho"]]
    if kind == "torrance_sparrow":
        assert inner["fresnel"] == "white"
        a = max(inner["alpha"], alpha_min)
        g = smith_correlated(wi[2], wo[2], a)
        return [ggx(half(wi, wo)[2], a) * g / (4 * wi[2] * wo[2])] * 3
    inner["alpha"] = max(inner["alpha"], alpha_min)
    return weidlich_wilkie(inner, wi, wo)


def weidlich_wilkie(p, wi, wo):
    """Elek, Eq. 2 to 4, and the options that make it exact for a smooth coat over a diffuse base.

    Algorithm 1 takes F1 by an index and an extinction of each channel; rays are refracted by one index.
    """
    values = []
    for channel in range(3):
        n = p["eta"]
        law = p.get("fresnel", "exact")
        if law in ("conductor", "lazanyi_conductor"):
            n = mpc(p["mirror_eta"][channel], p["mirror_k"][channel])
        fit = {"fresnel": "lazanyi"} if law.startswith("lazanyi") else {}
        values.append(one_channel(p, wi, wo, channel, functools.partial(reflected, fit, n=n)))
    return values


def one_channel(p, wi, wo, channel, mirrored):
    """A channel of `weidlich_wilkie`; mirrored: F of its coat at a cosine."""
    n, alpha = p["eta"], p["alpha"]
    smooth = p.get("interface") == "smooth"
    h = half(wi, wo)
    c = dot(wo, h)
    F = mirrored(c)
    D = DISTRIBUTIONS[p.get("distribution", "beckmann")](h[2], alpha)
    if p.get("masking") != "smith_correlated":
        G = cook_torrance(wi[2], wo[2], h[2], c)
    elif p["distribution"] == "ggx":
        G = smith_correlated(wi[2], wo[2], alpha)
    else:
        G = smith_correlated_beckmann(wi[2], wo[2], alpha)
    coat = F * D * G / (4 * wi[2] * wo[2])
    if smooth:
        coat, G = 0, mpf(1)
    through = (1 - F) * ((1 - G) + (1 - F) * G)
    if p.get("transmission") == "both_ways":
        through = (1 - mirrored(wi[2])) * (1 - mirrored(wo[2]))
    if p.get("solid_angle") == "compressed":
        through /= n**2
    wi_t, wo_t = refract(wi, n), refract(wo, n)
    clamp = 0 if smooth or p.get("roughness_clamp") == "off" else alpha
    below = base_value(p, wi_t, wo_t, clamp)[channel]
    if p.get("bounces") == "diffuse":
        assert p.get("base", "lambert") == "lambert"
        assert not any(p["sigma_a"])
        inside = 1 - (1 - diffuse_fresnel(n)) / n**2
        below /= 1 - p["base.rho"][channel] * inside
    return coat + through * kept(p["sigma_a"][channel], p["thickness"], wi_t, wo_t) * below


def triace_lobe(wi, wo, n):
    """Gotanda, Eq. 1: the fraction without Fresnel."""
    fit = mpf("0.0397436") * n + mpf("0.0856832")
    return fit * half(wi, wo)[2] ** n / max(wi[2], wo[2])


def triace_layered(p, wi, wo):
    """Gotanda, Eq. 2 to 5 over Eq. 1 and Eq. 25."""
    n1, n2 = p["top_eta"], p["bottom_eta"]
    c = dot(wo, half(wi, wo))
    f0_top = ((n1 - 1) / (n1 + 1)) ** 2
    top = schlick(f0_top, c) * triace_lobe(wi, wo, p["top_shininess"])
    if p.get("bottom_fresnel") == "constant":
        T = 1 - schlick(f0_top, c)
        reflected = ((n2 / n1 - 1) / (n2 / n1 + 1)) ** 2 * (1 - f0_top)
        glossy = reflected * (T if p.get("top_transmission") != "off" else 1)
    else:
        T = 1 - fresnel(c, n1)
        cos_t = sqrt(1 - (1 - c**2) / n1**2)
        reflected = fresnel(cos_t, n2 / n1) * (1 - fresnel(cos_t, 1 / n1))
        glossy = T * reflected
    matte = T * (1 - reflected) if p.get("top_transmission") != "off" else 1 - glossy
    shape = mpf(1)
    if p.get("diffuse") == "oren_nayar":
        n = p["bottom_shininess"]
        s = dot(wi, wo) - wi[2] * wo[2]
        t = max(wi[2], wo[2]) if s > 0 else mpf(1)
        shape = 1 - 1 / (2 + mpf("0.65") * n) + s / t / (mpf("2.22222") + mpf("0.1") * n)
    lobe = triace_lobe(wi, wo, p["bottom_shininess"])
    values = []
    for rho, sigma in zip(p["rho"], p["sigma_a"], strict=True):
        if p.get("absorption") == "linear":
            a = max(mpf(0), 1 - sigma * p["thickness"] * (1 / wi[2] + 1 / wo[2]))
        else:
            a = kept(sigma, p["thickness"], refract(wi, n1), refract(wo, n1))
        values.append(top + a * (glossy * lobe + matte * rho / pi * shape))
    return values


def chosen(p, mu_i, mu_o, cos_m, cos_h, alpha):
    """D and G by the options."""
    D = beckmann if p.get("distribution") == "beckmann" else ggx
    if p.get("masking") == "cook_torrance":
        return D(cos_m, alpha), cook_torrance(mu_i, mu_o, cos_m, cos_h)
    if p.get("distribution") == "beckmann":
        return D(cos_m, alpha), smith_correlated_beckmann(mu_i, mu_o, alpha)
    return D(cos_m, alpha), smith_correlated(mu_i, mu_o, alpha)


def reflected(p, cos_i, n):
    """F by the options; n may be complex."""
    if p.get("fresnel") == "lazanyi":
        n = mpc(n)
        top = (n.real - 1) ** 2 + 4 * n.real * (1 - cos_i) ** 5 + n.imag**2
        return top / ((n.real + 1) ** 2 + n.imag**2)
    return fresnel(cos_i, n)


def car_paint(p, wi, wo):
    """Elek, section 4.1: only the metal's normal is tilted; its BRDF needs cosines alone."""
    n, alpha = p["eta"], p["alpha"]
    h = half(wi, wo)
    c = dot(wo, h)
    F = reflected(p, c, n)
    D, G = chosen(p, wi[2], wo[2], h[2], c, alpha)
    coat = F * D * G / (4 * wi[2] * wo[2])
    through = (1 - reflected(p, wi[2], n)) * (1 - reflected(p, wo[2], n))
    if p.get("transmission") == "half_vector":
        through = (1 - F) * ((1 - G) + (1 - F) * G)
    if p.get("solid_angle") != "none":
        through /= n**2
    wi_t, wo_t = refract(wi, n), refract(wo, n)
    flake = unit((p["flake_x"], p["flake_y"], mpf(1)))
    before = 1 if p.get("tilt") == "added" else 0
    normal = unit((flake[0], flake[1], flake[2] + max(p["distance"], mpf(1)) + before))
    tilted_i, tilted_o = dot(wi_t, normal), dot(wo_t, normal)
    if tilted_i <= 0 or tilted_o <= 0:
        return [coat] * 3
    h_t = half(wi_t, wo_t)
    a = max(p["metal_alpha"], alpha)
    D, G = chosen(p, tilted_i, tilted_o, dot(h_t, normal), dot(wo_t, h_t), a)
    facets = D * G / (4 * tilted_i * tilted_o)
    paths = (0, 0, tilted_i), (0, 0, tilted_o)
    if p.get("absorption") != "flake":
        paths = wi_t, wo_t
    if p.get("flake_cosine") == "light":
        facets *= tilted_i / wi_t[2]
    else:
        facets *= min(mpf(1), tilted_i / wi_t[2]) * min(mpf(1), tilted_o / wo_t[2])
    return [
        coat
        + through
        * kept(s, p["thickness"], *paths)
        * facets
        * reflected(p, dot(wo_t, h_t), mpc(eta, k) / n)
        for s, eta, k in zip(p["sigma_a"], p["metal_eta"], p["metal_k"], strict=True)
    ]


def patina(p, wi, wo):
    """Elek, section 4.2: bare and coated metal, mixed; the index of the metal is not."""
    x = (p["growth"] - (p["extent"] - p["transition"])) / (2 * p["transition"])
    x = min(max(x, mpf(0)), mpf(1))
    grown = 1 - (3 * x**2 - 2 * x**3)
    alpha = (1 - grown) * p["bare_alpha"] + grown * p["grown_alpha"]
    index = sum(p["coat_eta"]) / 3
    h, wi_t, wo_t = half(wi, wo), refract(wi, index), refract(wo, index)
    h_t, c = half(wi_t, wo_t), dot(wo, h)
    below_alpha = max(alpha, p["alpha"])
    D, G = chosen(p, wi[2], wo[2], h[2], c, p["alpha"])
    D_bare, G_bare = chosen(p, wi[2], wo[2], h[2], c, alpha)
    D_t, G_t = chosen(p, wi_t[2], wo_t[2], h_t[2], dot(wo_t, h_t), below_alpha)
    values = []
    for k in range(3):
        eta = mpc(p["metal_eta"][k], p["metal_k"][k])
        tint = 1 - p["tarnish"] + p["tarnish"] * p["tarnish_tint"][k]
        bare = tint * reflected(p, c, eta) * D_bare * G_bare / (4 * wi[2] * wo[2])
        below = tint * reflected(p, dot(wo_t, h_t), eta) * D_t * G_t / (4 * wi_t[2] * wo_t[2])
        F = reflected(p, c, mpc(p["coat_eta"][k], p["coat_k"][k]))
        coat = F * D * G / (4 * wi[2] * wo[2])
        coat += (1 - p["sigma_a"][k]) * (1 - F) / pi
        through = (1 - F) * ((1 - G) + (1 - F) * G)
        if p.get("solid_angle") != "none":
            through /= index**2
        coat += through * kept(p["sigma_a"][k], p["thickness"], wi_t, wo_t) * below
        values.append((1 - grown) * bare + grown * coat)
    return values


# The table.


def at(theta, phi=0.0):
    """A direction from angles in degrees."""
    t, f = math.radians(theta), math.radians(phi)
    return (math.sin(t) * math.cos(f), math.sin(t) * math.sin(f), math.cos(t))


PAIRS = [(at(20, 10), at(35, 200)), (at(60, 75), at(50, 240)), (at(75, 170), at(40, 20))]

COAT = {"eta": 1.5, "alpha": 0.25, "sigma_a": [0.0, 0.0, 0.0], "thickness": 1.0}
LAMBERT = {"base.rho": [0.9, 0.35, 0.04]}
TINTED = {"sigma_a": [0.1, 0.7, 2.5], "thickness": 0.6}
EXACT = {
    "interface": "smooth",
    "transmission": "both_ways",
    "solid_angle": "compressed",
    "bounces": "diffuse",
}
GGX = {"distribution": "ggx", "masking": "smith_correlated"}
COLOURED = {"mirror_eta": [2.95, 1.4, 3.03], "mirror_k": [0.1, 0.0, 0.67]}
SHINY_BASE = {"base": "torrance_sparrow", "base.fresnel": "white", "base.alpha": 0.1}
THREE = {
    "base": "weidlich_wilkie",
    "base.eta": 1.2,
    "base.alpha": 0.1,
    "base.sigma_a": [1.0, 0.2, 0.0],
    "base.thickness": 0.5,
    "base.base": "weidlich_wilkie",
    "base.base.eta": 1.1,
    "base.base.alpha": 0.4,
    "base.base.sigma_a": [0.0, 0.3, 0.3],
    "base.base.thickness": 1.0,
    "base.base.base.rho": [0.9, 0.35, 0.04],
}
WEIDLICH_WILKIE = [
    COAT | LAMBERT,
    COAT | LAMBERT | TINTED | {"fresnel": "lazanyi"},
    COAT | LAMBERT | TINTED | GGX | {"transmission": "both_ways"},
    COAT | LAMBERT | EXACT,
    COAT | LAMBERT | EXACT | {"eta": 2.2},
    COAT | SHINY_BASE | TINTED,
    COAT | SHINY_BASE | GGX | {"roughness_clamp": "off", "solid_angle": "compressed"},
    COAT | THREE,
    COAT | LAMBERT | TINTED | COLOURED | {"fresnel": "conductor"},
    COAT | LAMBERT | TINTED | COLOURED | {"fresnel": "lazanyi_conductor"},
    COAT | LAMBERT | COLOURED | GGX | {"fresnel": "conductor", "transmission": "both_ways"},
    COAT | LAMBERT | {"distribution": "blinn_phong"},
    COAT | LAMBERT | TINTED | {"distribution": "gaussian", "fresnel": "lazanyi"},
    COAT | LAMBERT | {"distribution": "blinn_phong", "masking": "smith_correlated"},
    COAT | LAMBERT | {"distribution": "gaussian", "masking": "smith_correlated", "alpha": 0.6},
]

LAYERS = {
    "top_eta": 1.33333,
    "top_shininess": 200.0,
    "bottom_eta": 1.5,
    "bottom_shininess": 20.0,
    "rho": [0.9, 0.35, 0.04],
    "sigma_a": [0.05, 0.2, 0.6],
    "thickness": 0.7,
}
TRIACE_LAYERED = [
    LAYERS,
    LAYERS | {"absorption": "linear"},
    LAYERS | {"bottom_fresnel": "constant", "top_shininess": 10.0},
    LAYERS | {"bottom_fresnel": "constant", "top_transmission": "off", "diffuse": "oren_nayar"},
    LAYERS | {"top_eta": 1.6, "bottom_eta": 1.4, "diffuse": "oren_nayar"},
    LAYERS | {"top_eta": 1.8, "bottom_eta": 2.5, "top_transmission": "off"},
]

PAINT = {
    "eta": 1.5,
    "alpha": 0.2,
    "sigma_a": [0.15, 1.2, 1.4],
    "thickness": 0.8,
    "metal_eta": [3.6, 3.1, 1.8],
    "metal_k": [4.3, 4.4, 4.1],
    "metal_alpha": 0.3,
    "flake_x": 0.0,
    "flake_y": 0.0,
    "distance": 1.0,
}
PRINTED = {"distribution": "beckmann", "masking": "cook_torrance", "fresnel": "lazanyi"}
PRINTED_PAINT = PRINTED | {
    "absorption": "flake",
    "tilt": "added",
    "flake_cosine": "light",
    "transmission": "half_vector",
    "solid_angle": "none",
}
CAR_PAINT = [
    PAINT,
    PAINT | {"flake_x": 0.5, "flake_y": -0.7},
    PAINT | {"flake_x": -1.5, "flake_y": 0.4, "solid_angle": "none", "transmission": "half_vector"},
    PAINT | {"flake_x": 0.8, "flake_y": 0.8, "flake_cosine": "light"},
    PAINT | {"flake_x": 1.0, "flake_y": -0.2, "distance": 7.5, "metal_alpha": 0.05},
    PAINT | {"flake_x": 0.5, "flake_y": -0.7} | PRINTED_PAINT,
    PAINT | {"flake_x": 0.3, "flake_y": 0.1, "distribution": "beckmann", "tilt": "added"},
    PAINT | {"flake_x": -0.6, "masking": "cook_torrance", "absorption": "flake"},
]

COPPER = {
    "growth": 0.5,
    "extent": 0.45,
    "transition": 0.65,
    "thickness": 1.0,
    "sigma_a": [0.66, 0.3, 0.42],
    "alpha": 0.5,
    "bare_alpha": 0.15,
    "grown_alpha": 0.5,
    "metal_eta": [0.2, 0.92, 1.1],
    "metal_k": [3.9, 2.45, 2.14],
    "coat_eta": [2.95, 3.11, 3.03],
    "coat_k": [0.1, 0.2, 0.67],
    "tarnish": 0.5,
    "tarnish_tint": [0.45, 0.2, 0.08],
}
PATINA = [
    COPPER,
    COPPER | {"extent": -0.65, "growth": 0.3},
    COPPER | {"extent": 1.65, "growth": 0.9, "thickness": 0.3},
    COPPER | {"extent": 0.15, "growth": 0.4, "tarnish": 1.0, "alpha": 0.3},
    COPPER | {"extent": 0.75, "transition": 0.2, "growth": 0.8, "solid_angle": "none"},
    COPPER | {"extent": 0.75} | PRINTED | {"solid_angle": "none"},
    COPPER | {"distribution": "beckmann"},
    COPPER | {"masking": "cook_torrance", "fresnel": "lazanyi"},
]


def numbers(value):
    """Doubles as mpmath numbers, so that nothing is rounded twice."""
    if isinstance(value, str):
        return value
    return [mpf(v) for v in value] if isinstance(value, list) else mpf(value)


def row(model, parameters, wi, wo, quantity, value, source):
    """One line of the table."""
    return [
        model,
        json.dumps(parameters),
        json.dumps(list(wi)) if wi else "",
        json.dumps(list(wo)),
        quantity,
        "[" + ", ".join(nstr(v, 17) for v in value) + "]",
        source,
    ]


def evaluations(name, brdf, sets, publication):
    """Values of a BRDF for every set of parameters and every pair of directions."""
    found_by = f"{BY_FORMULA}; {publication}; {HERE} {name}"
    for parameters in sets:
        p = {k: numbers(v) for k, v in parameters.items()}
        for wi, wo in PAIRS:
            value = brdf(p, tuple(map(mpf, wi)), tuple(map(mpf, wo)))
            yield row(name, parameters, wi, wo, "eval", value, found_by)


def albedos():
    """A smooth coat over white: closed forms from the diffuse reflectance alone."""
    white = COAT | {"base.rho": [1.0, 1.0, 1.0], "interface": "smooth"}
    both = white | {"transmission": "both_ways"}
    for n in (1.5, 1.2):
        external = diffuse_fresnel(mpf(n))
        for theta in (0, 60):
            wo = at(theta)
            T = 1 - fresnel(mpf(wo[2]), mpf(n))
            cases = [
                (both, T * (1 - external), "T(wo) (1 - Fdr_ext)"),
                (
                    both | {"solid_angle": "compressed"},
                    T * (1 - external) / mpf(n) ** 2,
                    "over eta^2",
                ),
                (white | EXACT, T, "1 - F(wo): all that enters leaves again"),
            ]
            for parameters, value, formula in cases:
                yield row(
                    "weidlich_wilkie",
                    parameters | {"eta": n},
                    None,
                    wo,
                    "albedo",
                    [value] * 3,
                    f"{BY_FORMULA}, {formula}; walsh1926 for Fdr_ext; {HERE} albedos",
                )


def check_walsh():
    """The diffuse reflectance by quadrature against Walsh's closed form and the published 0.09178."""
    n = mpf("1.5")
    closed = mpf(1) / 2 + (n - 1) * (3 * n + 1) / (6 * (n + 1) ** 2)
    closed += n**2 * (n**2 - 1) ** 2 / (n**2 + 1) ** 3 * log((n - 1) / (n + 1))
    closed -= 2 * n**3 * (n**2 + 2 * n - 1) / ((n**2 + 1) * (n**4 - 1))
    closed += 8 * n**4 * (n**4 + 1) / ((n**2 + 1) * (n**4 - 1) ** 2) * log(n)
    assert abs(diffuse_fresnel(n) - closed) < mpf("1e-12")
    assert abs(closed - mpf("0.09178")) < mpf("5e-6")
    assert abs(1 - (1 - closed) / n**2 - mpf("0.59635")) < mpf("5e-6")


def main():
    """Write the table."""
    check_walsh()
    elek = "elek2010 "
    rows = [
        *evaluations("weidlich_wilkie", weidlich_wilkie, WEIDLICH_WILKIE, elek + "Eq. 2 to 4"),
        *albedos(),
        *evaluations("triace_layered", triace_layered, TRIACE_LAYERED, "gotanda2012 Eq. 1 to 5"),
        *evaluations("car_paint", car_paint, CAR_PAINT, elek + "section 4.1"),
        *evaluations("patina", patina, PATINA, elek + "section 4.2"),
    ]
    path = pathlib.Path(__file__).with_name("anchors_layers.csv")
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["model", "parameters", "wi", "wo", "quantity", "value", "source"])
        writer.writerows(rows)
    print(f"{len(rows)} rows in {path.name}")


if __name__ == "__main__":
    main()
