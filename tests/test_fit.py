"""Fits: known parameters come back, what cannot be known is named, nothing is left to chance."""

from __future__ import annotations

import json
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result
from support.tolerances import SINGLE

import gonio
from gonio import fit, measured
from gonio.cli import main
from gonio.fields import ModelError
from gonio.fit.columns import columns
from gonio.fit.intervals import blocks
from gonio.fit.problem import from_measurement
from gonio.fit.structure import structure
from gonio.measured.formats.csv import directions
from gonio.reference import Layer, Stack

# Fits of values without noise, relative to their size: single precision; and the parameters that make them.
RESIDUE = 1e-6
EXACT = 1e-5

# The same for parameters that can nearly stand in for each other.
NEAR = 1e-4


QUIET = ("subsurface", "specular_tint", "anisotropic", "sheen_tint", "clearcoat", "clearcoat_gloss")


def measure(model: Any, noise: float = 0.0, seed: int = 1) -> measured.Measurement:
    """A model as data, with relative noise."""
    wi, wo = directions(True)
    random = np.random.default_rng(seed)
    values = model.eval(wi, wo) * (1 + noise * random.normal(size=(len(wi), 1)))
    return measured.measurement("test", "test", wi, wo, values, channels=("r", "g", "b"))


def test_known_parameters_come_back_from_every_start() -> None:
    true = gonio.model(
        "disney", base_color=(0.6, 0.3, 0.1), roughness=0.35, metallic=0.3, specular=0.6, sheen=0.2
    )
    found = fit.fit(gonio.model("disney"), true, fixed=QUIET, points=1500, starts=3)
    for path, _, value in true.parameters():
        assert np.allclose(getattr(found.model, path), value, atol=EXACT), path
    assert found.relative < RESIDUE
    assert found.starts[-1] < RESIDUE
    assert not found.undetermined
    assert not found.at_bounds


def test_the_parameters_of_inner_models_come_back() -> None:
    true = gonio.model(
        "weidlich_wilkie", alpha=0.2, eta=1.5, sigma_a=0.3, **{"base.rho": (0.5, 0.2, 0.1)}
    )
    begin = gonio.model("weidlich_wilkie", eta=1.5, sigma_a=0.3)
    found = fit.fit(begin, true, fixed=("eta", "sigma_a", "thickness"), points=1000, starts=1)
    assert found.model.alpha == pytest.approx(0.2, abs=NEAR)
    assert np.allclose(found.model.base.rho, (0.5, 0.2, 0.1), atol=NEAR)
    assert (found.model.eta, found.model.sigma_a) == (1.5, 0.3)


def test_noise_moves_parameters_by_no_more_than_it_should() -> None:
    true = gonio.model("eon", rho=(0.6, 0.4, 0.2), roughness=0.5)
    found = fit.fit(gonio.model("eon"), measure(true, 0.05), points=4000, starts=1)
    # 12,000 values with 5 % of noise: rho to about 0.05 / sqrt(4000)
    assert np.allclose(found.model.rho, (0.6, 0.4, 0.2), rtol=0.01)
    assert found.model.roughness == pytest.approx(0.5, abs=0.03)
    assert 0.03 < found.relative < 0.06


def test_derivatives_are_those_of_differences_and_a_wrong_one_would_show() -> None:
    model = gonio.model(
        "disney", base_color=(0.7, 0.4, 0.2), roughness=0.4, metallic=0.4, sheen=0.3, clearcoat=0.5
    )
    free = columns(model)
    problem = from_measurement(model, free, measure(gonio.model("eon")), 300, 0)
    x = np.clip(problem.start(), 0.05, 0.95)
    for metric in fit.METRICS.values():
        exact = problem.jacobian(x, metric)
        for place in range(len(x)):
            step = np.zeros(len(x))
            step[place] = 1e-5
            slope = (
                problem.residuals(x + step, metric) - problem.residuals(x - step, metric)
            ) / 2e-5
            assert np.abs(exact[:, place] - slope).max() < 1e-5 * max(1.0, np.abs(slope).max())
            assert np.abs(1.01 * exact[:, place] - slope).max() > 1e-5 * np.abs(slope).max()


def test_what_the_data_do_not_say_is_named() -> None:
    # A metal has no dielectric reflection: neither its strength nor its tint matter
    metal = gonio.model("disney", metallic=1.0, roughness=0.4)
    fixed = [n for n in QUIET if n != "specular_tint"] + ["sheen", "metallic"]
    found = fit.fit(metal, measure(metal), fixed=fixed, points=800, starts=1)
    assert set(found.undetermined) == {"specular", "specular_tint"}
    assert not {"specular", "specular_tint"} & set(found.intervals)
    assert (found.model.specular, found.model.specular_tint) == (
        metal.specular,
        metal.specular_tint,
    )


def test_linear_numbers_are_found_by_trying_and_a_product_is_not_linear_in_both() -> None:
    data = measure(gonio.model("eon"))

    def linear(model: Any) -> set[str]:
        problem = from_measurement(model, columns(model), data, 200, 0)
        found = structure(problem)
        return {problem.free[j].name for j in found.columns(True)}

    # 2012's course notes: strengths are factors, hues are not
    assert {"sheen", "clearcoat", "specular"} <= linear(gonio.model("disney"))
    assert not {"roughness", "clearcoat_gloss", "base_color.r"} & linear(gonio.model("disney"))
    # Ashikhmin and Shirley, Eq. 5: rho (1 - f0)
    assert linear(gonio.model("ashikhmin_shirley")) == {"rho.r", "rho.g", "rho.b"}
    # EON's colour is in a quotient, but not where the colour is taken out of it
    assert not linear(gonio.model("eon"))
    assert linear(gonio.model("eon", color_shift="none")) == {"rho.r", "rho.g", "rho.b"}


def test_tied_numbers_are_one_and_fixed_ones_stay() -> None:
    true = gonio.model("ward", rho=0.3, specular=(0.1, 0.05, 0.02), alpha_x=0.2, alpha_y=0.2)
    begin = gonio.model("ward", rho=(0.3, 0.1, 0.3))
    found = fit.fit(
        begin,
        true,
        fixed=("rho.r", "rho.b"),
        tied=[("alpha_x", "alpha_y")],
        points=1000,
        starts=1,
    )
    assert set(found.values) == {
        "rho.g",
        "specular.r",
        "specular.g",
        "specular.b",
        "alpha_x=alpha_y",
    }
    assert found.model.alpha_x == found.model.alpha_y == pytest.approx(0.2, abs=NEAR)
    assert np.allclose(found.model.rho, 0.3, atol=EXACT)
    assert (found.model.rho[0], found.model.rho[2]) == (0.3, 0.3)


def test_a_sum_of_lobes_is_found_and_its_weights_stay_where_colours_do_the_same() -> None:
    text = "lambert+torrance_sparrow:fresnel=schlick"
    true = gonio.load(f"lambert:rho=0.4/0.2/0.1+{text.partition('+')[2]},alpha=0.15,f0=0.05")
    found = fit.fit(gonio.load(text), true, points=1500, starts=3)
    assert {"first_weight.r", "second_weight.g"} <= set(found.spare)
    assert np.allclose(found.model.first.rho, (0.4, 0.2, 0.1), atol=NEAR)
    assert found.model.second.alpha == pytest.approx(0.15, abs=NEAR)
    assert np.allclose(found.model.second.f0, 0.05, atol=NEAR)


def test_intervals_cover_the_truth_as_often_as_they_say() -> None:
    true = gonio.model("lambert", rho=(0.6, 0.4, 0.2))
    inside = halved = 0
    for seed in range(30):
        data = measure(true, 0.3, 100 + seed)
        found = fit.fit(gonio.model("lambert"), data, metric="cosine", points=400, starts=1)
        low, high = found.intervals["rho.g"]
        inside += low <= 0.4 <= high
        halved += abs(0.4 - found.values["rho.g"]) <= 0.25 * (high - low)
    # 95 % of 30 within three standard deviations of a binomial; intervals of half the width hold 67 %
    assert inside >= 25
    assert halved < 27


def test_misfit_is_told_apart_from_noise() -> None:
    true = gonio.model("eon", rho=0.5, roughness=0.8)
    noisy = fit.fit(gonio.model("eon"), measure(true, 0.1), starts=1, points=3000)
    wrong = fit.fit(gonio.model("lambert"), measure(true, 0.02), starts=1, points=3000)
    assert noisy.noise is not None
    assert wrong.noise is not None
    # All that the right model misses is noise, 10 % of f; most of what Lambert misses is not
    assert noisy.noise.size == pytest.approx(noisy.misfit["log"], rel=0.1)
    assert noisy.noise.model < 0.5 * noisy.noise.size
    assert wrong.noise.model > 3 * wrong.noise.size
    # So that the right one fails nowhere, though bright places have more noise than others
    assert not noisy.regions
    assert wrong.regions
    repeated = measure(true, 0.1)
    twice = measure(true, 0.1, 2)
    both = measured.measurement(
        "test",
        "test",
        *(
            np.concatenate([getattr(m, n) for m in (repeated, twice)])
            for n in ("wi", "wo", "values")
        ),
        channels=("r", "g", "b"),
    )
    told = fit.fit(gonio.model("lambert"), both, starts=1, points=3000).noise
    assert told is not None
    assert told.by == "repeats"
    # Two estimates of one noise, from some thousand values each: a few percent
    assert told.size == pytest.approx(noisy.noise.size, rel=0.1)


def test_where_a_model_fails_is_said_in_words() -> None:
    whole = measure(gonio.load("lambert:rho=0.3+torrance_sparrow:fresnel=schlick,alpha=0.1,f0=0.5"))
    steep = (whole.wi[:, 2] > 0.5) & (whole.wo[:, 2] > 0.5)  # grazing light would miss more
    data = measured.measurement(
        "test",
        "test",
        whole.wi[steep],
        whole.wo[steep],
        whole.values[steep],
        channels=("r", "g", "b"),
    )
    found = fit.fit(gonio.model("lambert"), data, points=3000, starts=1)
    assert found.regions[0].name.startswith("the highlight")
    assert "too dark" in found.regions[0].sentence()
    assert found.regions[0].share == max(region.share for region in found.regions)
    assert np.nanmax(found.map.rms[:3]) > 5 * np.nanmax(found.map.rms[7:])


def test_blocks_hold_equally_many_directions_that_are_near() -> None:
    data = measure(gonio.model("lambert"))
    where = blocks(data.wi.astype(float), data.wo.astype(float), True)
    sizes = np.bincount(where)
    assert len(sizes) == 64
    assert sizes.max() - sizes.min() <= 1
    spread = [data.wo[where == b, 2].std() for b in range(64)]
    assert np.mean(spread) < 0.6 * data.wo[:, 2].std()


def test_the_nearest_parameters_to_layers_are_those_of_their_truth() -> None:
    # A stack of one layer that is air is its base
    stack = Stack([Layer(eta=1.0)], gonio.model("eon", rho=(0.5, 0.3, 0.2), roughness=0.6))
    found = fit.fit(gonio.model("eon"), stack, points=400, starts=1)
    assert found.model.roughness == pytest.approx(0.6, abs=EXACT)
    assert np.allclose(found.model.rho, (0.5, 0.3, 0.2), atol=EXACT)


def test_a_fit_can_be_sent_to_another_process() -> None:
    found = fit.fit(gonio.model("eon"), gonio.model("lambert"), points=200, starts=1)
    again = pickle.loads(pickle.dumps(found))
    assert again.model == found.model
    assert again.intervals == found.intervals


# Ngan, Durand, Matusik, "Experimental analysis of BRDF models", EGSR 2005, supplemental tables of fits of
# Ward's model with Dür's denominator to MERL: diffuse albedo, specular albedo, roughness.
NGAN_WARD = {
    "blue-acrylic": ((0.0138, 0.0326, 0.0636), (0.00774, 0.00547, 0.00339), 0.0162),
    "alum-bronze": ((0.0851, 0.0586, 0.0294), (0.0484, 0.0274, 0.0135), 0.0357),
}


@pytest.mark.parametrize("material", NGAN_WARD)
def test_parameters_of_published_fits_come_back_from_data_made_of_them(material: str) -> None:
    rho, specular, alpha = NGAN_WARD[material]
    true = gonio.model("ward", rho=rho, specular=specular, alpha_x=alpha, alpha_y=alpha)
    found = fit.fit(
        gonio.model("ward"),
        measure(true, 0.02),
        tied=[("alpha_x", "alpha_y")],
        starts=2,
        points=4000,
    )
    # 12,000 values with 2 % of noise; a dark rho is what is left of them beside a highlight
    assert found.model.alpha_x == pytest.approx(alpha, rel=0.01)
    assert np.allclose(found.model.rho, rho, rtol=0.02)
    assert np.allclose(found.model.specular, specular, rtol=0.02)


def test_a_published_cook_torrance_is_a_sum_whose_weight_is_four_times_as_large() -> None:
    """Ngan, Durand, Matusik 2005, alum-bronze: k_d / pi + k_s / pi F D G / (mu_i mu_o), D without pi."""
    kd, ks, f0, m = (0.0886, 0.0602, 0.0299), (0.118, 0.0698, 0.0371), 0.203, 0.0367
    wi, wo = directions(True)
    h = (wi + wo) / np.linalg.norm(wi + wo, axis=-1, keepdims=True)
    c = (wi * h).sum(-1)
    cos2 = h[:, 2] ** 2
    D = np.exp(-(1 / cos2 - 1) / m**2) / (m**2 * cos2**2)
    G = np.minimum(1, 2 * h[:, 2] / c * np.minimum(wi[:, 2], wo[:, 2]))
    lobe = (f0 + (1 - f0) * (1 - c) ** 5) * D * G / (np.pi * wi[:, 2] * wo[:, 2])
    values = np.array(kd) / np.pi + lobe[:, None] * np.array(ks)
    data = measured.measurement("test", "test", wi, wo, values, channels=("r", "g", "b"))
    model = gonio.load(
        "lambert+torrance_sparrow:distribution=beckmann,masking=cook_torrance,fresnel=schlick"
    )
    found = fit.fit(
        model,
        data,
        fixed=("second.f90", "second.anisotropy"),
        tied=[("second.f0.r", "second.f0.g", "second.f0.b")],
        points=4000,
        starts=2,
    )
    assert found.model.second.alpha == pytest.approx(m, rel=EXACT)
    assert found.model.second.f0[0] == pytest.approx(f0, rel=EXACT)
    assert np.allclose(found.model.second_weight, 4 * np.array(ks), rtol=EXACT)
    assert np.allclose(found.model.first.rho, kd, rtol=EXACT)


def test_an_end_of_a_range_is_named() -> None:
    found = fit.fit(gonio.model("eon"), gonio.model("lambert", rho=0.5), points=500, starts=1)
    assert found.at_bounds == ("roughness",)
    assert np.allclose(found.model.rho, 0.5, atol=SINGLE)


def test_holes_and_extrapolated_values_are_left_out() -> None:
    true = gonio.model("eon", rho=0.5, roughness=0.3)
    clean = measure(true)
    values = clean.values.copy()
    bad = np.arange(len(values)) % 3 == 0
    values[bad] = 9.0
    spoilt = measured.measurement(
        "test",
        "test",
        clean.wi,
        clean.wo,
        values,
        channels=clean.channels,
        hole=bad & (clean.wi[:, 2] > 0.5),
        extrapolated=bad & (clean.wi[:, 2] <= 0.5),
    )
    found = fit.fit(gonio.model("eon"), spoilt, points=None, starts=1)
    assert found.model.roughness == pytest.approx(0.3, abs=NEAR)
    assert found.directions == (~bad).sum()


def test_metrics_disagree_where_no_model_fits_and_each_is_best_in_its_own() -> None:
    data = gonio.model("oren_nayar", sigma=0.6)
    found = {
        m: fit.fit(gonio.model("eon"), data, metric=m, points=800, starts=1) for m in fit.METRICS
    }
    for metric, own in found.items():
        assert all(
            own.misfit[metric] <= other.misfit[metric] * (1 + 1e-6) for other in found.values()
        )


def test_the_same_seed_gives_the_same_result_to_the_last_bit() -> None:
    data = measure(gonio.model("eon", roughness=0.7), 0.1)
    first, second = (
        fit.fit(gonio.model("eon"), data, points=500, starts=2, seed=3) for _ in range(2)
    )
    assert repr(first.model) == repr(second.model)
    assert first.starts == second.starts


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ({"metric": "l1"}, "no metric 'l1'; there are log, cbrt, cosine"),
        ({"fixed": ("alpha",)}, "has no parameter 'alpha' to fix"),
        ({"fixed": ("rho", "roughness")}, "no free parameter"),
        ({"starts": 0}, "a fit needs a start"),
        ({"tied": [("rho", "roughness")]}, "a colour and a number cannot be tied"),
        ({"tied": [("rho.r",)]}, "a tie needs two names"),
        ({"tied": [("rho.r", "alpha")]}, "no parameter 'alpha' to tie"),
        ({"tied": [("rho.r", "rho.g")], "fixed": ("rho",)}, "cannot be tied as well"),
    ],
)
def test_what_cannot_be_fitted_is_said(more: dict[str, Any], message: str) -> None:
    with pytest.raises(ModelError, match=message):
        fit.fit(gonio.model("eon"), gonio.model("lambert"), **more)


# --- the command ---------------------------------------------------------------------------------


def run(*words: str) -> Result:
    return CliRunner().invoke(main, ["fit", *words])


def test_command_puts_the_best_model_first_and_writes_it(tmp_path: Path) -> None:
    data = tmp_path / "data.alta"
    measured.save(data, gonio.model("eon", rho=(0.6, 0.4, 0.2), roughness=0.8))
    output = tmp_path / "best.toml"
    words = ("--points", "600", "--starts", "1")
    result = run(str(data), "lambert", "eon", *words, "-o", str(output))
    assert result.exit_code == 0, result.output
    assert result.stdout.index("\neon:rho=0.6") < result.stdout.index("\nlambert:")
    assert result.stdout.startswith("model ")
    assert "starts" in result.stdout
    written = gonio.load(str(output))
    assert written.model.roughness == pytest.approx(0.8, abs=EXACT)
    found = json.loads(run("oren_nayar:sigma=0.5", "eon", *words, "--json").stdout)
    assert set(found[0]["misfit"]) == set(fit.METRICS)


def test_what_a_model_is_given_stays_unless_it_is_freed() -> None:
    words = (
        "oren_nayar:sigma=0.5",
        "eon:roughness=0.3",
        "--points",
        "300",
        "--starts",
        "1",
        "--json",
    )
    kept = json.loads(run(*words).stdout)[0]
    assert kept["parameters"]["roughness"] == 0.3
    freed = json.loads(run(*words, "--free", "roughness").stdout)[0]
    assert freed["values"]["roughness"] != 0.3
    given = json.loads(run(*words, "--free", "roughness", "--fix", "rho.r=0.7").stdout)[0]
    assert given["parameters"]["rho"][0] == 0.7
    assert "rho.r" not in given["values"]


def test_a_picture_shows_data_fit_and_difference(tmp_path: Path) -> None:
    picture = tmp_path / "fit.csv"
    data = tmp_path / "data.alta"
    measured.save(data, gonio.model("eon", rho=0.5, roughness=0.8))
    words = (
        "--points",
        "300",
        "--starts",
        "1",
        "-o",
        str(picture),
        "-o",
        str(tmp_path / "fit.png"),
    )
    assert run(str(data), "lambert", *words).exit_code == 0
    rows = np.genfromtxt(picture, delimiter=",", names=True)
    assert set(rows.dtype.names) >= {"theta_i_deg", "theta_o_deg", "data_per_sr", "fit_per_sr"}
    assert np.ptp(rows["fit_per_sr"]) < 1e-6 < np.nanstd(rows["data_per_sr"])
    assert (tmp_path / "fit.png").stat().st_size > 20_000


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("none.binary", "eon"), "does not exist"),
        (("lambert", "eno"), "did you mean"),
        (("lambert", "eon", "-o", "x.json"), "ends in .toml"),
        (("lambert", "eon", "-o", "x.toml", "-o", "y.toml"), "two files for one thing"),
        (("lambert", "eon", "--tie", "rho.r=alpha"), "to tie"),
        (("lambert", "eon", "--free", "alpha"), "has no parameter"),
        (("eon", "eon", "--truth"), "stands for no layers"),
        (("lambert", "eon", "-o", "no/such/x.toml"), "there is no folder"),
        (("lambert", "eon", "--fix", "alpha"), "to fix"),
        (("lambert",), "MODEL..."),
    ],
)
def test_command_refuses_in_one_line(words: tuple[str, ...], message: str) -> None:
    result = run(*words)
    assert result.exit_code != 0
    assert message in result.stderr
    assert result.stderr.count("\n") == 1


def test_starts_in_two_parts_find_what_all_of_them_find() -> None:
    true = gonio.model("student_t", alpha=0.2, gamma=4)
    begin = gonio.model("student_t", alpha=0.7)
    whole, *parts = (
        fit.fit(begin, true, points=300, starts=count, first=first)
        for count, first in ((4, 0), (2, 0), (2, 2))
    )
    best = min(parts, key=lambda f: f.misfit[f.metric])
    assert best.values == whole.values  # to the last bit
    assert best.model == whole.model
    assert sorted(s for f in parts for s in f.starts) == sorted(whole.starts)
    other = fit.fit(begin, true, points=300, starts=2, first=4)
    assert other.starts != parts[1].starts
