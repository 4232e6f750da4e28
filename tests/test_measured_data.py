"""`gonio data` and `gonio check FILE`: what they say about measurements whose faults are known."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result
from PIL import Image
from support.measured_files import EXAMPLES
from support.tolerances import SINGLE, SINGLE_LONG

import gonio
from gonio import measured
from gonio.check.measured_data import DATA_CHECKS, check_file
from gonio.check.report import FAIL, NOTE, PASS
from gonio.cli import main
from gonio.measured.formats import csv as loose
from gonio.measured.formats import mbsdf
from gonio.measured.quality import quality

SAMPLES = Path(__file__).parents[2] / "shared" / "samples" / "measured"

EON = gonio.model("eon", rho=(0.7, 0.4, 0.2), roughness=0.6)


def run(*words: str) -> Result:
    return CliRunner().invoke(main, list(words))


def verdicts(path: Path) -> dict[str, str]:
    return {f.what: f.verdict for r in check_file(path) for f in r.findings}


class Changed:
    """A model with a fault: what writers take."""

    title, channels, wavelengths, isotropic = "changed", ("r", "g", "b"), None, True

    def __init__(self, change: Any) -> None:
        self.change = change

    def evaluate(self, wi: Any, wo: Any) -> Any:
        return self.change(EON.eval(wi, wo).astype(float), wi, wo)


def write(path: Path, change: Any, format: str = "mbsdf") -> Path:
    measured.save(path, Changed(change), format)
    return path


def small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Coarser tables, for speed."""
    monkeypatch.setattr(mbsdf, "N_THETA", 30)
    monkeypatch.setattr(mbsdf, "N_PHI", 60)
    monkeypatch.setattr(loose, "WRITTEN", (9, 20, 36))


# --- quality -------------------------------------------------------------------------------------


def test_a_clean_measurement_passes_and_its_albedo_is_the_models(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    small(monkeypatch)
    path = write(tmp_path / "clean.mbsdf", lambda f, wi, wo: f)
    assert set(verdicts(path).values()) <= {PASS, NOTE}
    q = quality(measured.load(path))
    wo = np.array([math.sin(math.radians(30)), 0, math.cos(math.radians(30))])
    albedo = next(a for a in q.albedos if a.theta == 30)
    # Averages over cells of a few degrees, of what is smooth
    assert albedo.all == pytest.approx(float(EON.albedo(wo)[0]), rel=1e-3)
    assert q.covered == 1
    assert q.negative == 0


FAULTS = {
    "values below 0": lambda f, wi, wo: f - 0.08,
    "largest albedo": lambda f, wi, wo: f * 1.7,
    "directions swapped": lambda f, wi, wo: f * (0.6 + 0.5 * wi[:, 2:]),
    "noise": lambda f, wi, wo: f * np.random.default_rng(4).uniform(0.2, 1.8, (len(f), 1)),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_every_fault_is_caught_by_its_check_alone(
    fault: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    small(monkeypatch)
    found = verdicts(write(tmp_path / "bad.mbsdf", FAULTS[fault]))
    assert {what for what, verdict in found.items() if verdict == FAIL} == {fault}


def test_noise_is_measured_as_large_as_it_was_made(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    small(monkeypatch)
    noise = np.random.default_rng(8)
    for sigma in (0.01, 0.05):

        def noisy(f: Any, wi: Any, wo: Any, sigma: float = sigma) -> Any:
            return f * (1 + sigma * noise.normal(size=(len(f), 1)))

        path = write(tmp_path / "noisy.csv", noisy, "csv")
        found = quality(measured.load(path)).noise
        # The median of |normal| is 0.674; the plane through nine noisy neighbours adds to it
        assert 0.6 < found.median / (0.674 * sigma) < 1.6


def test_holes_are_counted_and_extrapolated_values_are_kept_apart(tmp_path: Path) -> None:
    path = tmp_path / "m.dat"
    path.write_bytes(EXAMPLES["merl"])
    found = measured.load(path)
    q = quality(found)
    assert q.holes == 1
    assert found.extrapolated is not None
    beyond = found.extrapolated & found.valid
    assert q.extrapolated == beyond.sum()
    # Twice what is possible, but only where the authors have continued their measurements
    values = found.values.copy()
    values[~found.extrapolated] *= 0.01
    values[found.extrapolated] = -1
    worse = measured.measurement(
        "MERL",
        "m",
        found.wi,
        found.wo,
        values,
        channels=found.channels,
        extrapolated=found.extrapolated,
    )
    q = quality(worse)
    assert (q.negative, q.negative_extrapolated) == (0, q.extrapolated)


def test_every_judge_has_words_for_every_format(tmp_path: Path) -> None:
    for name, content in EXAMPLES.items():
        path = tmp_path / f"{name}.dat"
        path.write_bytes(content)
        reports = check_file(path)
        assert [r.check for r in reports] == list(DATA_CHECKS)
        assert all(f.text for r in reports for f in r.findings)


# --- the commands --------------------------------------------------------------------------------


@pytest.fixture
def paint(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    small(monkeypatch)
    return write(tmp_path / "paint.mbsdf", lambda f, wi, wo: f)


def test_data_says_what_a_file_is(paint: Path) -> None:
    result = run("data", str(paint))
    assert result.exit_code == 0, result.output
    assert result.stdout.startswith("paint: MDL mbsdf, isotropic reflection\n")
    for word in (
        "values",
        "spectrum",
        "covers",
        "holes",
        "range",
        "noise",
        "reciprocity",
        "albedo",
    ):
        assert f"\n  {word} " in result.stdout
    found = json.loads(run("data", str(paint), "--json").stdout)
    assert found["format"] == "MDL mbsdf"
    assert found["quality"]["negative"] == 0


def test_data_converts_and_draws(paint: Path, tmp_path: Path) -> None:
    output, picture = tmp_path / "paint.csv", tmp_path / "paint.png"
    result = run("data", str(paint), "--convert", str(output), "--picture", str(picture))
    assert result.exit_code == 0, result.output
    back = measured.load(output)
    at = back.wi[:50], back.wo[:50]
    assert np.allclose(
        back.values[:50], measured.load(paint).evaluate(*at), rtol=SINGLE_LONG, atol=SINGLE
    )
    image = np.asarray(Image.open(picture).convert("L"))
    assert image.std() > 20  # not blank
    assert run("data", str(paint), "--picture", str(tmp_path / "x.csv")).exit_code == 0
    head = (tmp_path / "x.csv").read_text().splitlines()[0]
    assert head == "theta_i_deg,theta_o_deg,f_per_sr,near_a_measured_value"


def test_data_writes_a_model(tmp_path: Path) -> None:
    output = tmp_path / "eon.csv"
    result = run("data", "eon:roughness=1", "--convert", str(output))
    assert result.exit_code == 0, result.output
    assert measured.load(output).channels == ("r", "g", "b")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("data", "none.binary"), "does not exist"),
        (
            ("data", "FILE", "--part", "transmission"),
            "no part 'transmission'; there are reflection",
        ),
        (("data", "FILE", "--convert", "x.xyz"), "give one of the formats"),
        (("data", "FILE", "--picture", "x.jpg"), "must end in"),
        (("data", "FILE", "--format", "merl"), "--format belongs to --convert"),
        (("data", "eon"), "--convert OUT writes it"),
        (("check", "FILE", "--param", "roughness=1"), "has no parameters"),
        (("check", "FILE", "--only", "nothing"), "no check 'nothing'"),
        (("check", "FILE", "--plot", "x.png"), "gonio data"),
    ],
)
def test_what_cannot_be_is_one_line(words: tuple[str, ...], message: str, paint: Path) -> None:
    result = run(*(str(paint) if word == "FILE" else word for word in words))
    assert result.exit_code != 0
    assert message in result.stderr
    assert result.stderr.count("\n") == 1


def test_check_judges_a_file(paint: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    result = run("check", str(paint))
    assert result.exit_code == 0, result.output
    assert result.stdout.startswith("paint: pass\n")
    bad = write(tmp_path / "bad.mbsdf", FAULTS["largest albedo"])
    result = run("check", str(bad), "--only", "energy", "--junit", str(tmp_path / "j.xml"))
    assert result.exit_code == 1
    assert "largest albedo" in result.stdout
    assert "reciprocity" not in result.stdout
    assert b"largest albedo" in (tmp_path / "j.xml").read_bytes()


@pytest.mark.skipif(not SAMPLES.is_dir(), reason="the real files are not here")
def test_the_red_car_paint_is_found_out() -> None:
    found = verdicts(SAMPLES / "carpaint_red.mbsdf")
    assert found["values below 0"] == FAIL
    assert found["directions swapped"] == FAIL
    assert found["noise"] == PASS
