"""The C++ baseline of `gonio bench` computes what the papers say; how fast is not tested."""

import numpy as np
import pytest
from support.integrate import half_vector_rule
from support.tolerances import SINGLE

from gonio.bench import native

RHO = (0.9, 0.5, 0.1)
WHITE = (1.0, 1.0, 1.0)

# The baseline is float32 and its directions keep away from the horizon (MU_MIN), where dividing by
# max(mu_i, mu_o) enlarges the 6e-8 rounding of s = wi.wo - mu_i mu_o by 1 / MU_MIN.
MU_MIN = 0.02
RTOL = 1e-5


@pytest.fixture(scope="module")
def baseline(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.mktemp("cache")))
        native.compile_baseline.cache_clear()
        yield native.compile_baseline()
        native.compile_baseline.cache_clear()


def directions(mu, phi):
    """x, y, z as float32 arrays."""
    mu, phi = np.broadcast_arrays(np.asarray(mu, float), phi)
    sine = np.sqrt(1 - mu * mu)
    parts = (sine * np.cos(phi), sine * np.sin(phi), mu)
    return tuple(np.ascontiguousarray(part.ravel(), np.float32) for part in parts)


def random_directions(n, seed):
    random = np.random.default_rng(seed)
    return directions(random.uniform(MU_MIN, 1, n), random.uniform(0, 2 * np.pi, n))


def diffuse(name, rho=(0.8, 0.8, 0.8), roughness=0.5):
    """Parameters of a diffuse row: the colour and, but for lambert, a number."""
    return rho if name == "lambert" else (*rho, roughness)


# ---- float64 references, from the formulas and not from the C++: s from x and y alone ----


def s_over_t(wi, wo, keep_negative):
    s = wi[0] * wo[0] + wi[1] * wo[1]
    return np.where(s > 0, s / np.maximum(wi[2], wo[2]), s if keep_negative else 0)


def qon_like(rho, sigma, wi, wo, constant=0.33):
    A = 1 - 0.5 * sigma**2 / (sigma**2 + constant)
    B = 0.45 * sigma**2 / (sigma**2 + 0.09)
    return rho / np.pi * (A + B * s_over_t(wi, wo, keep_negative=False))


def qon_fujii(rho, sigma, wi, wo):
    A = 1 - 0.5 * sigma**2 / (sigma**2 + 0.33) + 0.17 * rho * sigma**2 / (sigma**2 + 0.13)
    B = 0.45 * sigma**2 / (sigma**2 + 0.09)
    return rho / np.pi * (A + B * s_over_t(wi, wo, keep_negative=True))


def oren_nayar(rho, sigma, wi, wo):
    theta = np.arccos(wi[2]), np.arccos(wo[2])
    alpha, beta = np.maximum(*theta), np.minimum(*theta)
    c = np.cos(np.arctan2(wi[1], wi[0]) - np.arctan2(wo[1], wo[0]))
    C1 = 1 - 0.5 * sigma**2 / (sigma**2 + 0.33)
    C2 = np.sin(alpha) - np.where(c >= 0, 0, (2 * beta / np.pi) ** 3)
    C2 = C2 * 0.45 * sigma**2 / (sigma**2 + 0.09)
    C3 = 0.125 * sigma**2 / (sigma**2 + 0.09) * (4 * alpha * beta / np.pi**2) ** 2
    L1 = C1 + c * C2 * np.tan(beta) + (1 - abs(c)) * C3 * np.tan((alpha + beta) / 2)
    L2 = 0.17 * sigma**2 / (sigma**2 + 0.13) * (1 - c * (2 * beta / np.pi) ** 2)
    return rho / np.pi * L1 + rho**2 / np.pi * L2


def fon_scale(r):  # A_F
    return 1 / (1 + (1 / 2 - 2 / (3 * np.pi)) * r)


def fon(rho, r, wi, wo):
    return rho / np.pi * fon_scale(r) * (1 + r * s_over_t(wi, wo, keep_negative=True))


def g_exact(mu):
    s = np.sqrt(1 - mu**2)
    return s * (np.arccos(mu) - s * mu) + 2 / 3 * s * (mu * (1 + s + s * s) / (1 + s) - 1)


def g_fitted(mu):
    g = 0.0571085289, 0.491881867, -0.332181442, 0.0714429953
    return np.pi * sum(g_k * (1 - mu) ** k for k, g_k in enumerate(g, start=1))


def eon(G):
    def value(rho, r, wi, wo):
        E_i, E_o = (fon_scale(r) * (1 + r / np.pi * G(w[2])) for w in (wi, wo))
        mean = fon_scale(r) * (1 + r * (2 / 3 - 28 / (15 * np.pi)))
        rho_ms = rho**2 * mean / (1 - rho * (1 - mean))
        return fon(rho, r, wi, wo) + rho_ms / np.pi * (1 - E_i) * (1 - E_o) / (1 - mean)

    return value


def triace_oren_nayar(rho, n, wi, wo):
    A, B = 1 - 1 / (2 + 0.65 * n), 1 / (2.22222 + 0.1 * n)
    return rho / np.pi * (A + B * s_over_t(wi, wo, keep_negative=True))


def burley_diffuse(rho, r, wi, wo):
    cosine_of_the_whole_angle = sum(a * b for a, b in zip(wi, wo, strict=True))
    F90_minus_1 = r * (1 + cosine_of_the_whole_angle) - 0.5  # 2 cos^2(theta_d) = 1 + cos(2 theta_d)
    return rho / np.pi * (1 + F90_minus_1 * (1 - wi[2]) ** 5) * (1 + F90_minus_1 * (1 - wo[2]) ** 5)


REFERENCES = {
    "lambert": lambda rho, r, wi, wo: rho / np.pi + 0 * wi[2],
    "oren_nayar": oren_nayar,
    "qon": qon_like,
    "qon_footnote": lambda *args: qon_like(*args, constant=0.57),
    "qon_fujii": qon_fujii,
    "fon": fon,
    "eon_exact": eon(g_exact),
    "eon_fitted": eon(g_fitted),
    "triace_oren_nayar": triace_oren_nayar,
    "burley_diffuse": burley_diffuse,
}


# ---- the same for the models of many terms; by angles, slopes and complex numbers ----


def half_vector(wi, wo):
    m = np.add(wi, wo)
    return m / np.linalg.norm(m, axis=0)


def ggx(m, ax, ay):
    """Density of the slopes, a bivariate Student distribution, over cos^4."""
    x, y = -m[0] / m[2], -m[1] / m[2]
    return 1 / (np.pi * ax * ay * (1 + (x / ax) ** 2 + (y / ay) ** 2) ** 2) / m[2] ** 4


def smith_lambda(w, ax, ay):
    phi, tan = np.arctan2(w[1], w[0]), np.tan(np.arccos(w[2]))
    alpha2 = (ax * np.cos(phi)) ** 2 + (ay * np.sin(phi)) ** 2
    return (np.sqrt(1 + alpha2 * tan**2) - 1) / 2


def conductor(cos_theta, eta, k):
    index = complex(eta, k)
    inside = np.sqrt(1 - (1 - cos_theta**2) / index**2)
    r_s = (cos_theta - index * inside) / (cos_theta + index * inside)
    r_p = (index * cos_theta - inside) / (index * cos_theta + inside)
    return (abs(r_s) ** 2 + abs(r_p) ** 2) / 2


def dielectric(cos_theta, eta):
    outside = np.arccos(cos_theta)
    inside = np.arcsin(np.sin(outside) / eta)
    s = np.sin(outside - inside) / np.sin(outside + inside)
    p = np.tan(outside - inside) / np.tan(outside + inside)
    normal = outside < 1e-6
    return np.where(normal, ((eta - 1) / (eta + 1)) ** 2, (s**2 + p**2) / 2)


TORRANCE_SPARROW = {
    "gold": (0.3, 0.0, 0.14, 0.38, 1.44, 4.1, 2.4, 1.6),
    "stretched": (0.1, 0.8, 1.3, 1.0, 0.6, 7.5, 6.4, 5.3),
    "rough": (1.0, 0.3, 3.2, 3.2, 2.2, 3.3, 3.3, 3.0),
}


def torrance_sparrow(parameters, wi, wo):
    alpha, anisotropy, *rest = parameters
    aspect = np.sqrt(1 - 0.9 * anisotropy)
    ax, ay = alpha / aspect, alpha * aspect
    m = half_vector(wi, wo)
    G = 1 / (1 + smith_lambda(wi, ax, ay) + smith_lambda(wo, ax, ay))
    facets = ggx(m, ax, ay) * G / (4 * wi[2] * wo[2])
    cosine = np.sum(m * wo, axis=0)
    return [conductor(cosine, rest[c], rest[3 + c]) * facets for c in range(3)]


DISNEY = {  # base colour, then the ten numbers in Burley's order
    "default": (0.8, 0.8, 0.8, 0, 0, 0.5, 0, 0.5, 0, 0, 0.5, 0, 1),
    "cloth": (0.6, 0.3, 0.1, 0.7, 0.2, 0.4, 0.5, 0.7, 0.1, 0.9, 0.6, 0.3, 0.2),
    "metal": (0.9, 0.7, 0.3, 0, 1, 0.5, 0, 0.4, 0.8, 0, 0.5, 1, 0.6),
}


def disney(parameters, wi, wo):
    colour, names = np.array(parameters[:3]), parameters[3:]
    subsurface, metallic, specular, specular_tint, roughness, anisotropic = names[:6]
    sheen, sheen_tint, clearcoat, gloss = names[6:]
    m = half_vector(wi, wo)
    cos_d = np.sum(m * wo, axis=0)
    rise_i, rise_o, rise_d = ((1 - c) ** 5 for c in (wi[2], wo[2], cos_d))

    def twice(at_grazing):  # from 1 at the normal
        return (1 - rise_i + rise_i * at_grazing) * (1 - rise_o + rise_o * at_grazing)

    rough_diffuse = twice(0.5 + 2 * roughness * cos_d**2)
    flat = 1.25 * (twice(roughness * cos_d**2) * (1 / (wi[2] + wo[2]) - 0.5) + 0.5)
    diffuse = ((1 - subsurface) * rough_diffuse + subsurface * flat) / np.pi

    def smith_over_cosines(width):  # G1 G1 / (4 mu mu)
        return (1 / (1 + smith_lambda(wi, width, width)) / (1 + smith_lambda(wo, width, width))) / (
            4 * wi[2] * wo[2]
        )

    aspect = np.sqrt(1 - 0.9 * anisotropic)
    highlight = ggx(m, roughness**2 / aspect, roughness**2 * aspect)
    highlight = highlight * smith_over_cosines((0.5 + roughness / 2) ** 2)
    a = 0.1 * (1 - gloss) + 0.001 * gloss
    gtr1 = (1 - a**2) / (-2 * np.pi * np.log(a)) / (1 - m[2] ** 2 + (a * m[2]) ** 2)
    coat = 0.25 * clearcoat * (0.04 + 0.96 * rise_d) * gtr1 * smith_over_cosines(0.25)
    tint = colour / (0.3 * colour[0] + 0.6 * colour[1] + 0.1 * colour[2])
    value = []
    for c in range(3):
        f0 = 0.08 * specular * (1 - specular_tint + specular_tint * tint[c])
        f0 = (1 - metallic) * f0 + metallic * colour[c]
        cloth = sheen * (1 - sheen_tint + sheen_tint * tint[c]) * rise_d
        matte = (1 - metallic) * (diffuse * colour[c] + cloth)
        value.append(matte + (f0 + (1 - f0) * rise_d) * highlight + coat)
    return value


COAT = {  # eta, alpha, sigma_a, thickness, rho
    "clear": (1.5, 0.1, 0, 0, 0, 1, 0.8, 0.8, 0.8),
    "tinted": (1.8, 0.4, 0.1, 0.6, 2.0, 0.7, 0.9, 0.5, 0.1),
}
TWO_COATS = {  # eta, alpha, sigma_a, thickness, twice, and rho
    "clear": (1.5, 0.1, 0, 0, 0, 1, 1.5, 0.1, 0, 0, 0, 1, 0.8, 0.8, 0.8),
    "sharper below": (1.4, 0.5, 0.3, 0.1, 0, 1, 1.2, 0.2, 0, 1, 2, 0.3, 0.9, 0.5, 0.1),
    "sharper above": (1.4, 0.2, 0.3, 0.1, 0, 1, 1.2, 0.5, 0, 1, 2, 0.3, 0.9, 0.5, 0.1),
}


def coated(parameters, wi, wo, at_least=0.0):
    if len(parameters) == 3:
        return [rho / np.pi + 0 * wi[2] for rho in parameters]
    eta, alpha, *sigma, thickness = parameters[:6]
    alpha = max(alpha, at_least)
    m = half_vector(wi, wo)
    cos_h = np.sum(m * wo, axis=0)
    F = dielectric(cos_h, eta)
    grooves = [2 * m[2] * w[2] / cos_h for w in (wi, wo)]
    G = np.minimum(1, np.minimum(*grooves))
    tan2 = (m[0] ** 2 + m[1] ** 2) / m[2] ** 2
    D = np.exp(-tan2 / alpha**2) / (np.pi * alpha**2 * m[2] ** 4)
    inside = []
    for w in (wi, wo):  # Snell's law in angles; the azimuth stays
        theta = np.arcsin(np.sin(np.arccos(w[2])) / eta)
        phi = np.arctan2(w[1], w[0])
        inside.append((np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)))
    path = thickness * (1 / inside[0][2] + 1 / inside[1][2])
    base = coated(parameters[6:], *inside, at_least=alpha)
    through = (1 - F) * ((1 - G) + (1 - F) * G)
    facets = F * D * G / (4 * wi[2] * wo[2])
    return [facets + b * through * np.exp(-s * path) for b, s in zip(base, sigma, strict=True)]


COMPLETE = [
    *(("torrance_sparrow", torrance_sparrow, p) for p in TORRANCE_SPARROW.values()),
    *(("disney", disney, p) for p in DISNEY.values()),
    *(("weidlich_wilkie", coated, p) for p in COAT.values()),
    *(("weidlich_wilkie_two_coats", coated, p) for p in TWO_COATS.values()),
]
IDS = [
    *(f"torrance_sparrow {name}" for name in TORRANCE_SPARROW),
    *(f"disney {name}" for name in DISNEY),
    *(f"coat {name}" for name in COAT),
    *(f"two coats {name}" for name in TWO_COATS),
]


def test_every_row_of_the_baseline_has_a_reference_here(baseline):
    complete = {name for name, _, _ in COMPLETE}
    assert set(baseline.eval_names) == set(REFERENCES) | complete
    assert set(baseline.sample_names) == {"lambert", "eon_exact", "eon_fitted"} | complete


# The printed formulas take 1 - cos^2 of the half vector, good to 1e-7, over the square of the width, which
# is 0.01 at least here: a few 1e-5 of D, and as much of the value. GTR1's 1 + (a^2 - 1) cos^2 at a width of
# 0.04 (disney's metal) is 0.0016 with an error of 1e-7.
COMPLETE_RTOL = 1e-4


def assert_values(baseline, name, parameters, expected, **how):
    """The baseline's values for random directions are those of the reference `expected`."""
    wi, wo = random_directions(20_000, seed=1), random_directions(20_000, seed=2)
    found = baseline.eval(name, wi, wo, parameters, repeat=1, threads=2, **how).value
    wi64, wo64 = (w / np.linalg.norm(w, axis=0) for w in np.array([wi, wo], np.float64))
    for channel, values in zip(found, expected(wi64, wo64), strict=True):
        # In the far tail of a Beckmann highlight the exponent is large, and so is its error.
        atol = COMPLETE_RTOL * 1e-2 * values.mean()
        np.testing.assert_allclose(channel, values, rtol=COMPLETE_RTOL, atol=atol)


@pytest.mark.parametrize("inlined", [False, True], ids=["calls", "inlined"])
@pytest.mark.parametrize(("name", "reference", "parameters"), COMPLETE, ids=IDS)
def test_values_of_many_terms_are_the_formulas(baseline, name, reference, parameters, inlined):
    def expected(wi, wo):
        return reference(parameters, wi, wo)

    assert_values(baseline, name, parameters, expected, inlined=inlined)


# Width, roughness, index, and index of the lower coat.
CHANGED = {"torrance_sparrow": 0, "disney": 7, "weidlich_wilkie": 0, "weidlich_wilkie_two_coats": 6}


@pytest.mark.parametrize(("name", "reference", "parameters"), COMPLETE, ids=IDS)
def test_a_parameter_that_is_a_percent_off_is_caught(baseline, name, reference, parameters):
    changed = list(parameters)
    changed[CHANGED[name]] *= 0.99

    def expected(wi, wo):
        return reference(tuple(changed), wi, wo)

    with pytest.raises(AssertionError, match="Mismatched"):
        assert_values(baseline, name, parameters, expected)


def mean_weight(baseline, name, parameters, degrees, density=1.0):
    """Mean of f cos / pdf over samples, for each channel; `density` makes the pdf wrong."""
    n = 512
    random = np.random.default_rng(5)
    u1, u2 = np.meshgrid(np.arange(n), np.arange(n))
    u1, u2 = (np.float32((u.ravel() + random.random(n * n)) / n) for u in (u1, u2))
    u1, u2 = (np.minimum(u, np.float32(1 - 2.0**-24)) for u in (u1, u2))
    wo = directions(np.full(u1.size, np.cos(np.radians(degrees))), 0.0)
    samples = baseline.sample_pdf_eval(name, wo, u1, u2, parameters, repeat=1, threads=2)
    used = samples.pdf > 0
    assert np.all(samples.wi[2][used] > 0)
    np.testing.assert_allclose(np.linalg.norm(samples.wi[:, used], axis=0), 1, atol=SINGLE)
    np.testing.assert_array_equal(samples.value[:, ~used], 0)
    weight = np.zeros(samples.value.shape)
    weight[:, used] = samples.value[:, used].astype(float) * samples.wi[2, used]
    weight[:, used] /= density * samples.pdf[used]
    return weight.mean(axis=1)


# Mean of 260,000 stratified weights, which stay below 10 for these parameters.
WEIGHT_RTOL = 4e-3


@pytest.mark.parametrize("degrees", [10, 75])
@pytest.mark.parametrize(("name", "reference", "parameters"), COMPLETE, ids=IDS)
def test_mean_weight_is_the_albedo(baseline, name, reference, parameters, degrees):
    theta = np.radians(degrees)
    wi, weights = half_vector_rule(theta, nodes=10, azimuths=20)
    up = wi[:, 2] > 0
    wi, weights = wi[up].T, weights[up]
    wo = np.array([[np.sin(theta)], [0], [np.cos(theta)]]) + 0 * wi
    expected = [np.sum(f * wi[2] * weights) for f in reference(parameters, wi, wo)]
    found = mean_weight(baseline, name, parameters, degrees)
    np.testing.assert_allclose(found, expected, rtol=WEIGHT_RTOL)
    wrong = mean_weight(baseline, name, parameters, degrees, density=1.01)
    assert np.all(abs(wrong / expected - 1) > WEIGHT_RTOL)


def test_a_row_with_too_few_parameters_is_an_error(baseline):
    wi, wo = random_directions(8, seed=6), random_directions(8, seed=7)
    with pytest.raises(ValueError, match="disney takes 13 parameters, given 4"):
        baseline.eval("disney", wi, wo, (0.8, 0.8, 0.8, 0.5))


@pytest.mark.parametrize("inlined", [False, True], ids=["calls", "inlined"])
@pytest.mark.parametrize("roughness", [0.05, 0.5, 1.0])
@pytest.mark.parametrize("name", REFERENCES)
def test_values_are_the_formulas(baseline, name, roughness, inlined):
    wi, wo = random_directions(20_000, seed=1), random_directions(20_000, seed=2)
    timed = baseline.eval(
        name, wi, wo, diffuse(name, RHO, roughness), repeat=1, threads=2, inlined=inlined
    )
    wi64, wo64 = (np.array(w, np.float64) for w in (wi, wo))
    for channel, rho in zip(timed.value, RHO, strict=True):
        expected = REFERENCES[name](rho, roughness, wi64, wo64)
        # Negative s brings values near 0 in the model of Eq. 25: rounding is relative to rho / pi.
        np.testing.assert_allclose(channel, expected, rtol=RTOL, atol=RTOL * rho / np.pi)
    assert timed.seconds > 0


def albedo(baseline, name, mu_o, roughness):
    """Directional albedo at rho = 1: Gauss-Legendre between the kinks, phi = pi/2, mu_i = mu_o."""
    x, weight = np.polynomial.legendre.leggauss(48)
    x, weight = (x + 1) / 2, weight / 2
    theta_o = np.arccos(mu_o)
    theta = np.concatenate([theta_o * x, theta_o + (np.pi / 2 - theta_o) * x])
    d_theta = np.concatenate([theta_o * weight, (np.pi / 2 - theta_o) * weight])
    phi = np.concatenate([x, 1 + x]) * np.pi / 2
    d_phi = np.concatenate([weight, weight]) * np.pi / 2
    wi = directions(np.cos(theta)[:, None], phi)
    wo = directions(np.full(wi[0].size, mu_o), 0.0)
    f = baseline.eval(name, wi, wo, diffuse(name, WHITE, roughness), repeat=1).value[0]
    cosines = (np.sin(theta) * np.cos(theta) * d_theta)[:, None] * (2 * d_phi)  # both signs of phi
    return np.sum(f.astype(np.float64) * cosines.ravel())


@pytest.mark.parametrize("roughness", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("mu_o", [0.01, 0.5, 0.9])
def test_white_eon_reflects_everything(baseline, mu_o, roughness):
    # The paper's E_F loses digits towards the horizon; the mean over the hemisphere keeps 2e-6.
    assert albedo(baseline, "eon_exact", mu_o, roughness) == pytest.approx(1, abs=2e-6)


@pytest.mark.parametrize(
    ("sigma", "published"),
    [
        (np.pi / 8, (0.933, 0.959, 1.017, 1.036)),
        (np.pi / 4, (0.815, 0.851, 0.931, 0.958)),
        (np.pi / 2, (0.721, 0.761, 0.849, 0.878)),
    ],
)
def test_full_oren_nayar_has_its_known_albedo(baseline, sigma, published):
    for degrees, value in zip((0.01, 60, 85, 89), published, strict=True):
        mu_o = np.cos(np.radians(degrees))
        # The known numbers have three decimals.
        assert albedo(baseline, "oren_nayar", mu_o, sigma) == pytest.approx(value, abs=6e-4)


# mu_o, r, then a, b, c, d of the matrix M, as formulas.md lists them.
CLTC_SPOTS = [
    (0.0, 1.0, 1.027126, 0.705879689, 1.20013, -0.503445965),
    (0.5, 0.5, 1.00883737, 0.208666393, 1.00619387, -0.0961747603),
    (1.0, 1.0, 0.955771, 0.0109541853, 0.955534, 0.00345383376),
]


def midpoints(n):
    u1, u2 = np.meshgrid((np.arange(n) + 0.5) / n, (np.arange(n) + 0.5) / n)
    return np.float32(u1.ravel()), np.float32(u2.ravel())


@pytest.mark.parametrize(("mu_o", "r", "a", "b", "c", "d"), CLTC_SPOTS)
def test_eon_density_is_that_of_the_published_matrix(baseline, mu_o, r, a, b, c, d):
    u1, u2 = midpoints(64)
    azimuth = 0.7
    wo = directions(np.full(u1.size, mu_o), azimuth)
    # The lobe is that of a roughness smaller by 1e-4, at which the default sampler begins.
    given = (1, 1, 1, r + 1e-4)
    samples = baseline.sample_pdf_eval("eon_exact", wo, u1, u2, given, repeat=1)
    # Density of M w_H at wi: |M^-1 wi|^-3 |det M^-1| cos / (pi s), M^-1 taken by NumPy.
    turned = np.exp(-1j * azimuth) * (samples.wi[0] + 1j * samples.wi[1])
    if mu_o == 1:  # wo has no azimuth: its frame is the local one
        turned = samples.wi[0] + 1j * samples.wi[1]
    inverse = np.linalg.inv([[a, 0, b], [0, c, 0], [d, 0, 1]])
    w = inverse @ np.array([turned.real, turned.imag, samples.wi[2]])
    length = np.linalg.norm(w, axis=0)
    s = (1 + 1 / np.sqrt(1 + d * d)) / 2
    cltc = np.maximum(w[2], 0) / length**4 * np.linalg.det(inverse) / (np.pi * s)
    k = 1 - mu_o
    P_u = r * (0.0169 + 0.2136 * k - 0.2345 * k**2 + 0.445 * k**3)
    P_u *= 1 - 0.602 * r - 0.5736 * k * r + 0.315 * r**2
    expected = P_u / (2 * np.pi) + (1 - P_u) * cltc
    # wi is rounded to float32: at the rim of the lobe, where w[2] = 0, 2e-6 in absolute terms. At
    # mu = 1 the fit for d is -6e-6 / -1.7e-3, a cancellation that leaves it 3e-5 exact in float32.
    atol = 2e-5 if mu_o == 1 else 2e-6
    np.testing.assert_allclose(samples.pdf, expected, rtol=RTOL, atol=atol)


@pytest.mark.parametrize("mu_o", [0.001, 0.1, 0.5, 0.9, 1.0])
@pytest.mark.parametrize("roughness", [0.0, 0.3, 1.0])
@pytest.mark.parametrize("name", ["lambert", "eon_exact"])
def test_samples_of_a_white_surface_have_mean_weight_one(baseline, name, roughness, mu_o):
    n = 512
    u1, u2 = midpoints(n)
    wo = directions(np.full(u1.size, mu_o), 2.0)
    samples = baseline.sample_pdf_eval(
        name, wo, u1, u2, diffuse(name, WHITE, roughness), repeat=1, threads=2
    )
    assert np.all(samples.wi[2] >= 0)
    # A normalisation in single precision
    np.testing.assert_allclose(np.linalg.norm(samples.wi, axis=0), 1, atol=5e-7)
    weight = samples.value[0].astype(np.float64) * samples.wi[2] / samples.pdf
    # Midpoints over a weight that jumps where u1 passes P_u: the error is one cell's share, 1 / n,
    # of a jump that stays below 2.5.
    assert weight.mean() == pytest.approx(1, abs=2.5 / n)


@pytest.mark.parametrize("name", ["lambert", "eon_exact", "eon_fitted"])
def test_sampled_values_are_those_of_eval(baseline, name):
    u1, u2 = midpoints(64)
    wo = random_directions(u1.size, seed=3)
    parameters = diffuse(name, RHO)
    samples = baseline.sample_pdf_eval(name, wo, u1, u2, parameters, repeat=1)
    value = baseline.eval(name, tuple(samples.wi), wo, parameters, repeat=1).value
    np.testing.assert_array_equal(samples.value, value)


@pytest.mark.parametrize("n", [0, 1, 2, 1001])
def test_chunks_cover_every_pair_once(baseline, n):
    wi, wo = random_directions(n, seed=4), random_directions(n, seed=5)
    one = baseline.eval("oren_nayar", wi, wo, diffuse(""), threads=1, repeat=1).value
    three = baseline.eval("oren_nayar", wi, wo, diffuse(""), threads=3, repeat=1).value
    np.testing.assert_array_equal(one, three)


def test_bandwidth_is_a_number_of_bytes_per_second(baseline, monkeypatch):
    monkeypatch.setattr(native, "TRIAD_FLOATS", 1 << 16)
    assert 0 < baseline.bandwidth(threads=2, repeat=2) < float("inf")


def test_a_second_compilation_is_the_first_one(baseline):
    first, written = baseline.library, baseline.library.stat().st_mtime_ns
    native.compile_baseline.cache_clear()
    again = native.compile_baseline()
    assert (again.library, again.library.stat().st_mtime_ns) == (first, written)
    assert list(first.parent.iterdir()) == [first]


def test_a_missing_compiler_is_one_line_that_says_what_to_install(monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("CXX", raising=False)
    with pytest.raises(RuntimeError, match=r"^no C\+\+ compiler .*apt-get install g\+\+[^\n]*$"):
        native.compile_baseline.__wrapped__()
    monkeypatch.setenv("CXX", "no-such-compiler -O3")
    with pytest.raises(RuntimeError, match="'no-such-compiler', which CXX names"):
        native.compile_baseline.__wrapped__()


def test_a_source_that_does_not_compile_is_an_error_and_leaves_nothing(
    baseline, monkeypatch, tmp_path
):
    broken = tmp_path / "broken.cpp"
    broken.write_text("int main() { return nonsense; }")
    monkeypatch.setattr(native, "SOURCE", broken)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    with pytest.raises(RuntimeError, match=r"error: .*nonsense"):
        native.compile_baseline.__wrapped__()
    assert list((tmp_path / "cache" / "gonio").iterdir()) == []


def test_wrong_arguments_are_errors_that_say_what_is_right(baseline):
    wi, wo = random_directions(8, seed=6), random_directions(8, seed=7)
    with pytest.raises(ValueError, match="no row 'phong' in the baseline; it has lambert"):
        baseline.eval("phong", wi, wo, diffuse("phong"))
    with pytest.raises(ValueError, match="given float64"):
        baseline.eval("fon", tuple(np.float64(x) for x in wi), wo, diffuse("fon"))
    with pytest.raises(ValueError, match=r"of one length, here \(8,\)"):
        baseline.eval("fon", wi, tuple(x[:4] for x in wo), diffuse("fon"))
    with pytest.raises(ValueError, match="threads=0"):
        baseline.eval("fon", wi, wo, diffuse("fon"), threads=0)
