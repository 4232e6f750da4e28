"""Single precision holds everywhere: values, densities, samples and derivatives at hard inputs."""

from __future__ import annotations

from typing import Any

import drjit as dr
import numpy as np
import pytest
from drjit.llvm.ad import Array2f, Array3f, Float
from mpmath import mp
from support import hard
from support.tolerances import SINGLE, SINGLE_PROMISED, single_promised

import gonio
from gonio import reference
from gonio.check.finite import FAR_TAIL
from gonio.claims import UNBOUNDED
from gonio.fields import ModelError
from gonio.parts import frame, fresnel, lobes, masking

COUNT = 1 << 14

# Options under which faults of this kind were found; every other model is taken as it is.
OPTIONS: dict[str, list[dict[str, str]]] = {
    "torrance_sparrow": [
        {},
        {"distribution": "beckmann", "masking": "cook_torrance", "fresnel": "lazanyi"},
        {"distribution": "blinn_phong", "fresnel": "schlick"},
        {"distribution": "gaussian", "masking": "kelemen", "fresnel": "dielectric"},
        {"compensation": "kulla_conty"},
    ],
    "weidlich_wilkie": [{"base": "metallic_roughness"}],
}
CASES = [(name, chosen) for name in gonio.models() for chosen in OPTIONS.get(name, [{}])]

# Weights of samples; EON's two samplers without a uniform part have rare ones of 1e7, and are options.
WEIGHT_MAX = 1e4

GOLD = {"eta": (0.01, 0.01003221, 0.08335331), "k": (11.997228, 8.271939e-4, 19.826624)}
PATINA = {
    "growth": 0.15316224098205566,
    "extent": 1.1158462762832642,
    "transition": 0.9628404974937439,
    "alpha": 0.8056924939155579,
    "bare_alpha": 0.8039717674255371,
    "grown_alpha": 1e-4,
    "sigma_a": (0.44, 0.0, 0.58),
    "thickness": 0.0035,
}
CAR = {"eta": 1.0, "alpha": 0.03, "metal_alpha": 0.8, "flake_x": 2.0, "flake_y": -2.0}
SHARP = {"rho": (0.586, 0.709, 1.0), "sigma_a": (3.85, 10.0, 7.83), "thickness": 0.0}


def unit(x: float, y: float, z: float) -> tuple[float, float, float]:
    """A direction with this small z, to the last digit of the others."""
    scale = np.sqrt((1 - z * z) / (x * x + y * y)) if x or y else 1.0
    return (x * scale, y * scale, z)


# Model, parameters, wi, wo; each was wrong by the number that stands beside it.
VALUES: list[tuple[str, dict[str, Any], Any, Any]] = [
    ("patina", PATINA, (0, 0, 1), (0, 0, 1)),  # 0.34, pdf 0.94: 1 - grown had no digits
    ("patina", PATINA | {"coat_eta": 1.5, "growth": 0.154}, (0, 0, 1), (0, 1e-5, 1)),
    ("torrance_sparrow", GOLD | {"alpha": 0.7}, unit(0.26, -0.89, 0.37281221), "wi"),  # 2.3e-5
    (
        "torrance_sparrow",
        {"fresnel": "dielectric", "eta": (0.143, 0.01, 0.010002), "alpha": 1.0},
        (0, 0, 1),
        (0, 0, 1),
    ),  # 3e-5: eta^2 - 1 + c^2 of a small index
    ("torrance_sparrow", {"masking": "kelemen", "alpha": 1e-4}, unit(-1, -0.015, 1.487e-16), "-"),
    ("torrance_sparrow", {"masking": "cook_torrance", "alpha": 1e-4}, unit(1, 0.1, 1.1e-18), "-"),
    ("torrance_sparrow", {"distribution": "gaussian", "alpha": 0.5}, (1e-21, 0, 1), (0, 0, 1)),
    (
        "triace_layered",
        {
            "top_eta": 1.0,
            "top_shininess": 1e5,
            "bottom_eta": 2.25,
            "bottom_shininess": 1e5,
            **SHARP,
        },
        unit(-0.45, -0.89, 1.7e-8),
        unit(0.45, 0.89, 4.8e-14),
    ),  # negative: 1 - F T
    (
        "triace_layered",
        {"top_eta": 2.998727, "top_shininess": 17187.0, "bottom_eta": 1.0, "bottom_shininess": 1.4},
        unit(0.5364, -0.844, 7.83e-4),
        unit(-0.5374, 0.8433, 7.9e-15),
    ),  # 5e-3: the critical angle of light that came in at grazing angles
    ("car_paint", CAR, (0, 0, 1), unit(-1, -1, 6.7e-13)),  # 1: which side of the flake is seen
    (
        "car_paint",
        {"eta": 1.157, "alpha": 1e-4, "metal_alpha": 1e-4, "flake_x": -2.0, "distance": 999455.0},
        unit(-0.91949, -0.39311, 2e-6),
        unit(0.91941, 0.39331, 2e-6),
    ),  # 5e-4: refracted directions were rounded before they were added
    (
        "car_paint",
        {
            "eta": 2.98950529,
            "metal_eta": (3.6, 0.03347242, 0.01),
            "metal_k": (0.0, 0.0, 3.0),
            "flake_x": 1.2,
            "flake_y": 1.95,
            "distance": 26789.0,
        },
        unit(0.06353406, -0.98808956, 0.14015129),
        unit(6.1e-9, -0.96841049, 0.24936132),
    ),  # 0.98: eta^2 - 1 + c^2 of a metal with a small index
    (
        "car_paint",
        {
            "eta": 1.0849413871765137,
            "alpha": 1e-4,
            "thickness": 0.0,
            "flake_x": 1.491382360458374,
            "flake_y": -0.011128462851047516,
        },
        (0.8303165435791016, 0.5416404604911804, 0.13114900887012482),
        (-0.830316424369812, -0.5416428446769714, 0.13113972544670105),
    ),  # pdf 3.8: the share of a flake that is seen edge-on jumped
    (
        "patina",
        {"coat_eta": (1.0000001192092896, 1.0, 1.0), "coat_k": (0.1, 3.0, 0.0), "thickness": 0.0},
        unit(0.65871799, 0.75238997, 1.2654796e-18),
        unit(1.0, 0.0, 1.2654796e-18),
    ),  # 1e12: the mean of the channels' indices rounded to 1
    (
        "torrance_sparrow",
        {"fresnel": "dielectric", "diffuse": "lambert", "distribution": "beckmann"}
        | {"eta": 0.01, "alpha": 0.98, "masking": "neumann"},
        unit(0.012141088, 0.0072163185, 0.99990028),
        (-0.012153477407991886, -0.00722387433052063, 0.9999000430107117),
    ),  # pdf 0.05: total reflection near the normal
    (
        "weidlich_wilkie",
        {"distribution": "gaussian", "masking": "smith", "fresnel": "lazanyi_conductor"}
        | {"alpha": 1.0002e-4, "mirror_eta": 1.0, "mirror_k": 10.0},
        unit(-1.0, 4.95e-6, 0.0002882170956581831),
        unit(1.0, 0.0, 0.0002786507538985461),
    ),  # 4e-3: 1 - G of Beckmann's facets
    ("ue4", {"base_color": 0.0, "metallic": 0.8, "specular": 0.0, "roughness": 0.0}, "N", "N"),
    ("unity_brdf2", {"base_color": 0.0, "roughness": 6.65e-7}, unit(-0.16, 0.987, 6e-17), "-"),
]


@pytest.mark.parametrize(("name", "given", "wi", "wo"), VALUES)
def test_float32_agrees_with_float64_where_it_once_did_not(
    name: str, given: dict[str, Any], wi: Any, wo: Any
) -> None:
    if wi == "N":
        wi, wo = (0.00106429, -0.01216045, 0.9999255), (-0.00193892, 0.01205197, 0.9999255)
    i = np.array(wi, np.float32)
    same = {"wi": i, "-": i * np.array((-1, -1, 1), np.float32)}
    o = same[wo] if isinstance(wo, str) else np.array(wo, np.float32)
    single = {p: np.float32(v).astype(float) for p, v in given.items() if not isinstance(v, str)}
    chosen = {p: v for p, v in given.items() if isinstance(v, str)}
    model = gonio.model(
        name, **chosen, **{p: tuple(v) if v.ndim else float(v) for p, v in single.items()}
    )
    limit = single_promised(model)
    for method in ("eval", "pdf"):
        low = getattr(model, method)(i, o)
        high = getattr(model, method)(i.astype(float), o.astype(float))
        assert np.isfinite(low).all()
        assert (low >= 0).all()
        np.testing.assert_allclose(low, high, rtol=limit)


# Facets and layers that are black where wi meets wo: all of F is Schlick's (1 - c)^5.
LAZANYI = {"fresnel": "lazanyi", "alpha": 0.9}
BLACK_COAT = LAZANYI | {"distribution": "ggx", "eta": 1.0, "base.rho": 0.0}
BLACK: list[tuple[str, dict[str, Any]]] = [
    ("torrance_sparrow", LAZANYI | {"eta": 1.0, "k": 0.0}),
    ("torrance_sparrow", {"fresnel": "schlick", "f0": 0.0, "f90": 0.5}),
    (
        "torrance_sparrow",
        {"fresnel": "schlick", "f0": 1.0, "f90": 0.5, "diffuse": "lambert"}
        | {"distribution": "gaussian", "alpha": 1e-3},
    ),
    ("car_paint", LAZANYI | {"eta": 1.0, "metal_eta": 1.0, "metal_k": 0.0}),
    (
        "patina",
        LAZANYI
        | {"coat_eta": 1.0, "coat_k": 0.0, "sigma_a": 1.0, "extent": 2.0, "growth": 0.0}
        | {"metal_eta": 1.0, "metal_k": 0.0},
    ),
    ("weidlich_wilkie", BLACK_COAT),
    ("weidlich_wilkie", BLACK_COAT | {"fresnel": "lazanyi_conductor", "mirror_eta": 1.0}),
]


def error_near_wo(name: str, given: dict[str, Any]) -> float:
    """Of values in float32 where light comes nearly from the viewer."""
    rng = np.random.default_rng(3)
    wo = rng.normal(size=(200, 3)) * (1, 1, 0.1)
    wi = wo + 10 ** rng.uniform(-2, -1, (200, 1)) * rng.normal(size=(200, 3))
    i, o = (np.abs(w) / np.linalg.norm(w, axis=1, keepdims=True) for w in (wi, wo))
    i, o = i.astype(np.float32), o.astype(np.float32)
    model = gonio.model(name, **given)
    low, high = model.eval(i, o), model.eval(i.astype(float), o.astype(float))
    assert (high > 0).all()
    return float((np.abs(low - high) / high).max())


@pytest.mark.parametrize(("name", "given"), BLACK)
def test_what_is_black_but_at_grazing_angles_keeps_its_digits(
    name: str, given: dict[str, Any]
) -> None:
    assert error_near_wo(name, given) < SINGLE_PROMISED


def test_a_weight_of_the_rounded_cosine_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fresnel, "_weight", lambda c, _: fresnel.schlick_weight(c))
    assert error_near_wo(*BLACK[0]) > 100 * SINGLE_PROMISED


def lanes(model: Any, rng: np.random.Generator) -> tuple[Any, dict[str, Any]]:
    """The model at COUNT hard sets of parameters, whose derivatives are followed."""
    given = hard.values(rng, model, COUNT)
    bound: dict[str, Any] = {}

    def convert(path: str, declared: Any, value: Any) -> Any:
        columns = [Float(np.ascontiguousarray(c)) for c in given[path].T]
        bound[path] = Array3f(*columns) if declared.width == 3 else columns[0]
        dr.enable_grad(bound[path])
        return bound[path]

    return model.bind(Float, convert), bound


def upload(vector: Any, rows: Any) -> Any:
    found = vector(*(Float(np.ascontiguousarray(c)) for c in rows.T))
    dr.enable_grad(found)
    return found


def faults(name: str, chosen: dict[str, str], seed: int = 0) -> dict[str, int]:
    """What is not as it has to be, and at how many of COUNT hard inputs."""
    rng = np.random.default_rng(seed)
    model = gonio.model(name, **chosen)
    wi, wo = hard.pairs(rng, COUNT)
    bound, given = lanes(model, rng)
    i, o, u = upload(Array3f, wi), upload(Array3f, wo), upload(Array2f, hard.numbers(rng, COUNT))
    f, pdf, drawn = Array3f(bound.eval(i, o)), bound.pdf(i, o), bound.sample(o, u)
    weight = dr.max(bound.eval(drawn.wi, o)) * drawn.wi.z / dr.maximum(drawn.pdf, 1e-37)
    found = {
        "eval": ~np.isfinite(np.array(f)).all(0),
        "pdf": ~np.isfinite(np.array(pdf)) | (np.array(pdf) < 0),
        "sample": ~(np.abs(np.linalg.norm(np.array(drawn.wi), axis=0) - 1) < 1e-5),
        "density": ~(np.isfinite(np.array(drawn.pdf)) & (np.array(drawn.pdf) >= 0)),
        "weight": ~(np.array(weight)[np.array(drawn.pdf) > 0] < WEIGHT_MAX),
    }
    options = {
        p: getattr(model, p) for p, field in model.fields.items() if hasattr(field, "values")
    }
    if model.claims.size("energy", options) == UNBOUNDED:  # and so are weights
        del found["weight"]
    if model.claims.size("negative", options) is None:
        found["negative"] = (np.array(f) < 0).any(0)
    for what, value in (("eval", f), ("pdf", pdf), ("sample", drawn.wi), ("density", drawn.pdf)):
        dr.clear_grad({"wi": i, "wo": o, **given})
        flags = dr.ADFlag.Default | dr.ADFlag.AllowNoGrad
        dr.backward(dr.sum(value, axis=0) if dr.depth_v(value) == 2 else value, flags=flags)
        for path, source in {"wi": i, "wo": o, **given}.items():
            slope = np.array(dr.grad(source))
            found[f"d {what} / d {path}"] = ~np.isfinite(slope)
    return {what: int(bad.sum()) for what, bad in found.items() if bad.any()}


@pytest.mark.parametrize(("name", "chosen"), CASES)
def test_hard_inputs_leave_everything_finite(name: str, chosen: dict[str, str]) -> None:
    assert faults(name, chosen) == {}


def facets(wi: Any, wo: Any, alpha: Any) -> Any:
    """White GGX with height-correlated Smith: Walter et al. 2007, Eq. 33, and Heitz 2014, Eq. 99."""
    h = [a + b for a, b in zip(wi, wo, strict=True)]
    cos2 = h[2] ** 2 / sum(x * x for x in h)
    D = alpha**2 / (mp.pi * (cos2 * (alpha**2 - 1) + 1) ** 2)

    def Lambda(mu: Any) -> Any:
        return (mp.sqrt(1 + alpha**2 * (1 / mu**2 - 1)) - 1) / 2

    return D / (1 + Lambda(wi[2]) + Lambda(wo[2])) / (4 * wi[2] * wo[2])


@pytest.mark.parametrize("alpha", [0.3, 1e-3])
@pytest.mark.parametrize("mu", [1e-5, 9e-7, 1.1e-7])
def test_derivatives_near_the_horizon_are_those_of_40_digits(mu: float, alpha: float) -> None:
    """By the width, and by turning wi about the normal, which tilts the half vector by 1 / (4 mu)."""
    mp.dps = 60
    wi = [float(np.float32(v)) for v in (1.0, 0.0, 3 * mu)]
    wo = [float(np.float32(v)) for v in (-1.0, mu, mu)]
    width = float(np.float32(alpha))
    given = {"wi": Array3f(*wi), "alpha": Float(width)}
    dr.enable_grad(given)
    model = gonio.model("torrance_sparrow", fresnel="white", alpha=width)
    bound = model.bind(
        Float,
        lambda p, declared, v: (
            given["alpha"] if p == "alpha" else Array3f(v) if declared.width == 3 else Float(v)
        ),
    )
    dr.backward(Array3f(bound.eval(given["wi"], Array3f(*wo))).x)

    def turned(angle: Any) -> Any:
        w = (mp.cos(angle), mp.sin(angle), mp.mpf(wi[2]))
        return facets(w, [mp.mpf(v) for v in wo], mp.mpf(width))

    def wider(a: Any) -> Any:
        return facets([mp.mpf(v) for v in wi], [mp.mpf(v) for v in wo], a)

    step = mp.mpf(mu) * mp.mpf("1e-12")
    by_angle = (turned(step) - turned(-step)) / (2 * step)
    by_width = mp.diff(wider, mp.mpf(width))
    assert float(dr.grad(given["wi"]).y[0]) == pytest.approx(float(by_angle), rel=SINGLE_PROMISED)
    assert float(dr.grad(given["alpha"])[0]) == pytest.approx(float(by_width), rel=SINGLE_PROMISED)


def test_below_where_derivatives_end_values_go_on() -> None:
    """The sharpest V-cavities have a slope of 4e10 / mu^3, which leaves a float32 below 5e-10."""
    model = gonio.model("torrance_sparrow", masking="cook_torrance", alpha=1e-4, fresnel="white")
    bound = model.bind(Float, lambda p, d, v: Array3f(v) if d.width == 3 else Float(v))
    for mu, ends in ((1.1e-7, False), (0.9e-7, True), (1e-9, True)):
        wi, wo = Array3f(1, 0, mu), Array3f(-1, 1e-4 * mu, mu)
        dr.enable_grad(wi)
        value = Array3f(bound.eval(wi, wo)).x
        dr.backward(value, flags=dr.ADFlag.Default | dr.ADFlag.AllowNoGrad)
        assert (dr.grad(wi).y[0] == 0) is ends
        # D = 1 / (pi alpha^2 (1 + tan^2 / alpha^2)^2), whose slope is half the width here; G = 1
        peak = 1 / (np.pi * 1e-8) / 1.25**2 * 0.25
        assert value[0] * mu * mu == pytest.approx(peak, rel=SINGLE)


def matched_slopes() -> tuple[float, float]:
    """By cosine and absorption: a highlight of 1e21 times F, for an index of 1 that hardly absorbs."""
    c, k = Float(1.2e-7), Array3f(1e-12)
    dr.enable_grad(c, k)
    dr.backward(1e21 * Array3f(fresnel.F_conductor(c, Array3f(1), k)).x)
    return float(dr.grad(c)[0]), float(dr.grad(k).x[0])


def test_a_matched_conductor_in_the_horizon_keeps_its_derivatives(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Against Fresnel's equations in 60 digits; squares and their root would leave a float32."""
    mp.dps = 60
    cosine, absorption = mp.mpf(float(np.float32(1.2e-7))), mp.mpf(float(np.float32(1e-12)))

    def F(c: Any, k: Any) -> Any:
        eps = (1 + 1j * k) ** 2
        g = mp.sqrt(eps - 1 + c * c)
        r_s, r_p = (c - g) / (c + g), (eps * c - g) / (eps * c + g)
        return 1e21 * (abs(r_s) ** 2 + abs(r_p) ** 2) / 2

    by_cosine = mp.diff(lambda c: F(c, absorption), cosine, h=mp.mpf("1e-20"))
    by_absorption = mp.diff(lambda k: F(cosine, k), absorption, h=mp.mpf("1e-25"))
    # Both are sums of terms that cancel to a tenth
    expected = pytest.approx((float(by_cosine), float(by_absorption)), rel=10 * SINGLE_PROMISED)
    assert matched_slopes() == expected
    monkeypatch.setattr(fresnel, "_size", lambda re, im: dr.sqrt(re * re + im * im))
    assert not np.isfinite(matched_slopes()).all()


def test_two_black_lobes_without_a_slope_are_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    """1 / (a + b + 1e-20) has a derivative of 1e40."""
    monkeypatch.setattr(lobes, "BLACK", 1e-20)
    assert any(what.startswith("d pdf") for what in faults("metallic_roughness", {}))


def black_unity(**given: float) -> float:
    """How far off a density is to which a lobe adds whose weight is 0 for threads that flush."""
    model = gonio.model("unity_brdf2", base_color=0.0, **given)
    wi = np.tile([0.0, 1.0, 1.26e-18], (1 << 18, 1))
    wo = wi * (1, -1, 1)
    single = model.pdf(wi.astype(np.float32), wo.astype(np.float32))
    return float(np.max(np.abs(np.asarray(single) / np.asarray(model.pdf(wi, wo)) - 1)))


# alpha^2 is flushed, or its product with F0
FAINT = [{"roughness": 3.29e-10}, {"roughness": 1e-9, "metallic": 1 - 2.0**-23}]


@pytest.mark.parametrize("given", FAINT)
def test_a_weight_that_is_flushed_ends_where_float32_does(
    monkeypatch: pytest.MonkeyPatch, given: dict[str, float]
) -> None:
    assert black_unity(**given) < SINGLE_PROMISED
    flushed = np.asarray(Float(np.full(1 << 18, 1e-19)) ** 2).max() == 0
    monkeypatch.setattr(lobes, "WEIGHT_MIN", 0.0)
    assert black_unity(**FAINT[1]) > 0.1 or not flushed


def opposite_pairs(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Pairs hardly above the horizon, opposite in nearly all digits, as high but for a few floats."""
    rng = np.random.default_rng(5)
    heights = (10 ** rng.uniform(-17.9, -6, count)).astype(np.float32)
    higher = heights + rng.integers(0, 40, count) * np.spacing(heights)
    x = 10 ** rng.uniform(-20, -8, count) * rng.choice([-1, 1], count)
    ones = np.ones(count)
    wi, wo = np.stack([x, ones, heights], -1), np.stack([0 * ones, -ones, higher], -1)
    return wi.astype(np.float32), wo.astype(np.float32)


def error_of_opposite_pairs(name: str, method: str) -> float:
    # As many as several threads share, of which each takes numbers below 1.2e-38 for 0
    model, (wi, wo) = gonio.model(name), opposite_pairs(1 << 17)
    single = np.asarray(getattr(model, method)(wi, wo))
    double = np.asarray(getattr(model, method)(wi.astype(float), wo.astype(float)))
    return float((np.abs(single - double) / (np.abs(double) + FAR_TAIL)).max())


@pytest.mark.parametrize("method", ["eval", "pdf"])
@pytest.mark.parametrize(
    "name", ["ue4", "unity_standard", "torrance_sparrow", "disney", "car_paint"]
)
def test_opposite_directions_in_the_horizon_keep_their_digits(name: str, method: str) -> None:
    assert error_of_opposite_pairs(name, method) < SINGLE_PROMISED


def test_half_vectors_whose_squares_are_flushed_are_noticed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    flushed = np.asarray(Float(np.full(1 << 17, 1e-19)) ** 2).max() == 0
    monkeypatch.setattr(frame, "LENGTHENED", 1.0)
    assert error_of_opposite_pairs("torrance_sparrow", "eval") > 1e-3 or not flushed


def test_a_flake_seen_from_behind_has_no_density_below_zero() -> None:
    """Its half vector lies behind it too, and D m.z of grooves was -8e-27 at a viewer in the horizon."""
    flake = {"flake_x": 0.54, "flake_y": -1.63, "distance": 3.2, "eta": 1.0, "alpha": 1e-4}
    model = gonio.model("car_paint", masking="cook_torrance", metal_alpha=0.76, **flake)
    angle = np.linspace(0, 2 * np.pi, 64)
    wi = np.stack([np.cos(angle), np.sin(angle), np.full(64, 5.6e-18)], 1).astype(np.float32)
    densities = model.pdf(wi, (0.0, 1.0, 5.6e-18))
    assert densities.min() >= 0
    assert densities.max() > 0


def test_a_masking_that_leaves_a_float32_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(masking, "V_MAX", 1e38)
    assert "eval" in faults("torrance_sparrow", {"masking": "kelemen"})


@pytest.mark.parametrize("sigma", [[0.1, 0.2], (0.1,), (), [1, 2, 3, 4]])
def test_an_absorption_of_two_numbers_is_refused(sigma: Any) -> None:
    with pytest.raises(ModelError, match="sigma_a takes one or three numbers, got"):
        reference.Layer(sigma_a=sigma)


def test_an_absorption_may_be_a_list() -> None:
    assert reference.Layer(sigma_a=[0.1, 0.2, 0.3]).depth == (0.1, 0.2, 0.3)


def test_the_reference_in_the_horizon_is_its_limit() -> None:
    """At grazing angles a smooth coat mirrors everything; below the horizon is nothing."""
    stack = reference.Stack([reference.Layer(1.5)])
    wo = np.array([[1, 0, 0], [1, 0, 1e-8], [1, 0, -1e-8]], np.float32)
    value = stack.albedo(wo, walks=64).value
    np.testing.assert_allclose(value[0], 1, atol=SINGLE)
    np.testing.assert_array_equal(value[0], value[1])
    np.testing.assert_array_equal(value[2], 0)
