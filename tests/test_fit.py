"""Fits: known parameters come back, what cannot be known is named, nothing is left to chance."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result

import gonio
from gonio import fit, measured
from gonio.cli import main
from gonio.fields import ModelError
from gonio.fit.problem import columns, from_measurement
from gonio.measured.formats.csv import directions

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
        assert np.allclose(getattr(found.model, path), value, atol=1e-5), path
    assert found.relative < 1e-6
    assert found.starts[-1] < 1e-6
    assert not found.undetermined
    assert not found.at_bounds


def test_the_parameters_of_inner_models_come_back() -> None:
    true = gonio.model(
        "weidlich_wilkie", alpha=0.2, eta=1.5, sigma_a=0.3, **{"base.rho": (0.5, 0.2, 0.1)}
    )
    begin = gonio.model("weidlich_wilkie", eta=1.5, sigma_a=0.3)
    found = fit.fit(begin, true, fixed=("eta", "sigma_a", "thickness"), points=1000, starts=1)
    assert found.model.alpha == pytest.approx(0.2, abs=1e-4)
    assert np.allclose(found.model.base.rho, (0.5, 0.2, 0.1), atol=1e-4)
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


def test_an_end_of_a_range_is_named() -> None:
    found = fit.fit(gonio.model("eon"), gonio.model("lambert", rho=0.5), points=500, starts=1)
    assert found.at_bounds == ("roughness",)
    assert np.allclose(found.model.rho, 0.5, atol=1e-6)


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
    assert found.model.roughness == pytest.approx(0.3, abs=1e-4)
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
    assert result.stdout.startswith("eon:rho=0.6")
    assert result.stdout.index("\nlambert:") > 0
    assert "starts" in result.stdout
    written = gonio.load(str(output))
    assert written.model.roughness == pytest.approx(0.8, abs=1e-3)
    found = json.loads(run("oren_nayar:sigma=0.5", "eon", *words, "--json").stdout)
    assert set(found[0]["misfit"]) == set(fit.METRICS)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("none.binary", "eon"), "does not exist"),
        (("lambert", "eno"), "did you mean"),
        (("lambert", "eon", "-o", "x.json"), "ends in .toml"),
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
