"""The C++ baseline of `gonio bench` computes what the papers say; how fast is not tested."""

import numpy as np
import pytest

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


def test_every_row_of_the_baseline_has_a_reference_here(baseline):
    assert set(baseline.eval_names) == set(REFERENCES)
    assert set(baseline.sample_names) == {"lambert", "eon_exact", "eon_fitted"}


@pytest.mark.parametrize("inlined", [False, True], ids=["calls", "inlined"])
@pytest.mark.parametrize("roughness", [0.05, 0.5, 1.0])
@pytest.mark.parametrize("name", REFERENCES)
def test_values_are_the_formulas(baseline, name, roughness, inlined):
    wi, wo = random_directions(20_000, seed=1), random_directions(20_000, seed=2)
    timed = baseline.eval(
        name, wi, wo, rho=RHO, roughness=roughness, repeat=1, threads=2, inlined=inlined
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
    f = baseline.eval(name, wi, wo, rho=WHITE, roughness=roughness, repeat=1).value[0]
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
    samples = baseline.sample_pdf_eval("eon_exact", wo, u1, u2, roughness=r, repeat=1)
    # Density of M w_H at wi: |M^-1 wi|^-3 |det M^-1| cos / (pi s), M^-1 taken by NumPy.
    turned = np.exp(-1j * azimuth) * (samples.wi[0] + 1j * samples.wi[1])
    if mu_o == 1:  # wo has no azimuth: its frame is the local one
        turned = samples.wi[0] + 1j * samples.wi[1]
    inverse = np.linalg.inv([[a, 0, b], [0, c, 0], [d, 0, 1]])
    w = inverse @ np.array([turned.real, turned.imag, samples.wi[2]])
    length = np.linalg.norm(w, axis=0)
    s = (1 + 1 / np.sqrt(1 + d * d)) / 2
    cltc = np.maximum(w[2], 0) / length**4 * np.linalg.det(inverse) / (np.pi * s)
    P_u = r**0.1 * (0.162925 - 0.372058 * mu_o + 0.538233 * mu_o**2 - 0.290822 * mu_o**3)
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
        name, wo, u1, u2, rho=WHITE, roughness=roughness, repeat=1, threads=2
    )
    assert np.all(samples.wi[2] >= 0)
    np.testing.assert_allclose(np.linalg.norm(samples.wi, axis=0), 1, atol=5e-7)
    weight = samples.value[0].astype(np.float64) * samples.wi[2] / samples.pdf
    # Midpoints over a weight that jumps where u1 passes P_u: the error is one cell's share, 1 / n,
    # of a jump that stays below 1.
    assert weight.mean() == pytest.approx(1, abs=1 / n)


@pytest.mark.parametrize("name", ["lambert", "eon_exact", "eon_fitted"])
def test_sampled_values_are_those_of_eval(baseline, name):
    u1, u2 = midpoints(64)
    wo = random_directions(u1.size, seed=3)
    samples = baseline.sample_pdf_eval(name, wo, u1, u2, rho=RHO, repeat=1)
    value = baseline.eval(name, tuple(samples.wi), wo, rho=RHO, repeat=1).value
    np.testing.assert_array_equal(samples.value, value)


@pytest.mark.parametrize("n", [0, 1, 2, 1001])
def test_chunks_cover_every_pair_once(baseline, n):
    wi, wo = random_directions(n, seed=4), random_directions(n, seed=5)
    one = baseline.eval("oren_nayar", wi, wo, threads=1, repeat=1).value
    three = baseline.eval("oren_nayar", wi, wo, threads=3, repeat=1).value
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
        baseline.eval("phong", wi, wo)
    with pytest.raises(ValueError, match="given float64"):
        baseline.eval("fon", tuple(np.float64(x) for x in wi), wo)
    with pytest.raises(ValueError, match=r"of one length, here \(8,\)"):
        baseline.eval("fon", wi, tuple(x[:4] for x in wo))
    with pytest.raises(ValueError, match="threads=0"):
        baseline.eval("fon", wi, wo, threads=0)
