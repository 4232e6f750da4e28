"""Comparisons of models with the truth and with each other: numbers known beforehand, and the page."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import make_layers_page as document
import numpy as np
import pytest
from click.testing import CliRunner
from support.directions import polar
from support.tolerances import SINGLE_LONG

import gonio
from gonio import compare as comparison
from gonio.cli import main
from gonio.compare import ANGLES_I, ANGLES_O, compare, drawing, measure
from gonio.fields import ModelError, Parameter
from gonio.materials import load
from gonio.materials.notation import model_text
from gonio.reference import Stack

WALSH_OUTSIDE, WALSH_INSIDE = 0.09178, 0.59635
"""Published diffuse reflectances of an index of 1.5."""

BOTH = {"transmission": "both_ways", "solid_angle": "compressed"}


def smooth_coat(**settings: Any) -> Any:
    white = gonio.model("lambert", rho=1)
    return gonio.model("weidlich_wilkie", interface="smooth", base=white, **settings)


# --- numbers ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", gonio.models())
def test_every_parameter_can_be_varied_over_its_range(name: str) -> None:
    for field in gonio.model(name).fields.values():
        if isinstance(field, Parameter) and field.width == 1:
            for value in comparison._steps(field):
                gonio.model(name, **{field.name: value})


def test_twice_the_albedo_is_a_hundred_percent() -> None:
    (found,) = compare([gonio.Lambert(rho=0.4), gonio.Lambert(rho=0.8)], pictures=False)
    e = found.errors
    assert (e.mean, e.worst, e.energy) == pytest.approx((1, 1, 1), rel=SINGLE_LONG)
    assert (e.albedo, e.truth) == pytest.approx((0.8, 0.4), rel=SINGLE_LONG)
    assert e.noise == 0
    np.testing.assert_allclose(found.in_plane, 1, rtol=SINGLE_LONG)
    np.testing.assert_allclose(found.across, 1, rtol=SINGLE_LONG)


def test_five_percent_too_dark_are_five_percent() -> None:
    (found,) = compare([gonio.Lambert(rho=0.8), gonio.Lambert(rho=0.76)], pictures=False)
    e = found.errors
    # Differences of 5 %, of values and sums in single precision
    assert (e.mean, e.worst, e.energy) == pytest.approx((0.05, -0.05, -0.05), rel=1e-4)


def test_a_coat_without_inner_bounces_loses_walshs_reflectance() -> None:
    # White below glass: (1 - R_out)^2 / n^2 against 1 - R_out, and (1 - R_out) / n^2 = 1 - R_in
    coat = smooth_coat(**BOTH)
    e = measure(coat, Stack.of(coat), walks=2048, maps=False).judge(coat)[0]
    # Means of 2048 walks from each of many directions
    assert e.truth == pytest.approx(1 - WALSH_OUTSIDE, abs=0.003)
    assert e.energy == pytest.approx(-WALSH_INSIDE, abs=0.004)
    assert e.mean == pytest.approx(WALSH_INSIDE, abs=0.004)


def test_the_exact_coat_is_as_good_as_the_truths_noise() -> None:
    coat = smooth_coat(**BOTH, bounces="diffuse")
    e, in_plane, _ = measure(coat, Stack.of(coat), walks=2048).judge(coat)
    # What 2048 walks for a pair leave
    assert e.noise < 0.015
    assert e.mean < 1.3 * e.noise
    # What 2048 walks for a pair leave of it
    assert abs(e.energy) < 0.005
    assert np.nanmean(np.abs(in_plane)) < 1.3 * e.noise


def test_a_one_percent_error_is_seen_above_the_noise() -> None:
    coat = smooth_coat(**BOTH, bounces="diffuse")
    darker = coat.replace(**{"base.rho": 0.99})
    e = measure(coat, Stack.of(coat), walks=2048, maps=False).judge(darker)[0]
    # d f / f = d rho / rho / (1 - rho R_in): 1 % of the base is 2.4 % of the coat's value
    assert e.energy == pytest.approx(-0.01 / (1 - 0.99 * WALSH_INSIDE), abs=0.003)


def test_the_worst_error_is_where_it_is_said_to_be() -> None:
    first, other = gonio.model("lambert", rho=0.3), gonio.model("torrance_sparrow", alpha=0.3)
    (found,) = compare([first, other], pictures=False)
    theta_i, theta_o, phi = np.radians(found.errors.worst_at)
    wi, wo = polar(theta_i, phi), polar(theta_o)
    f, truth = (np.asarray(m.eval(wi, wo)) @ comparison.LUMINANCE for m in (other, first))
    # Highlights in single precision: 1e-6 times some ten, for how fast they change with the angle
    assert found.errors.worst == pytest.approx(f / truth - 1, rel=1e-4)
    # A highlight is on the mirror's side, which is negative.
    row = int(np.flatnonzero(ANGLES_O == 45)[0])
    # Two steps of the angles: facets reflect most a little beyond the mirror
    assert ANGLES_I[np.argmax(found.in_plane[row])] == pytest.approx(-45, abs=10)
    assert phi == pytest.approx(np.pi)


def test_a_noisy_truth_does_not_judge() -> None:
    coat = gonio.model("weidlich_wilkie")
    few = measure(coat, Stack.of(coat), walks=2).judge(coat)[1]
    many = measure(coat, Stack.of(coat), walks=4096).judge(coat)[1]
    assert np.isnan(few).mean() > 0.5
    assert np.isnan(many).mean() < 0.05


def test_the_influence_of_a_parameter() -> None:
    (found,) = compare([smooth_coat(**BOTH)], truth=True, pictures=False, walks=512, vary="eta")
    assert found.varied == "eta"
    assert len(found.values) == len(found.influence) == comparison.STEPS
    energy = [e.energy for e in found.influence]
    # Index 1 is no coat at all, and the higher it is, the more light is reflected inside.
    assert energy[0] == pytest.approx(0, abs=0.01)
    assert np.all(np.diff(energy) < 0)


def test_models_that_cannot_be_compared_say_why() -> None:
    with pytest.raises(ModelError, match="at least two models"):
        compare([gonio.Lambert()])
    with pytest.raises(ModelError, match="models that do are weidlich_wilkie"):
        compare([gonio.EON()], truth=True)
    with pytest.raises(ModelError, match="no number 'sigma_a'; known are eta"):
        compare([gonio.model("weidlich_wilkie")], truth=True, vary="sigma_a", pictures=False)


# --- files and the command -------------------------------------------------------------------------


def run(*args: str) -> Any:
    return CliRunner().invoke(main, args, catch_exceptions=False)


def test_the_command_writes_a_picture(tmp_path: Path) -> None:
    target = tmp_path / "coat.png"
    args = ["compare", "weidlich_wilkie", "--truth", "--walks", "64", "--size", "32", "--spp", "4"]
    result = run(*args, "-o", str(target))
    assert result.exit_code == 0
    assert "energy" in result.stdout
    from PIL import Image

    with Image.open(target) as image:
        pixels = np.asarray(image.convert("RGB"), float)
    assert pixels.shape[0] > 200
    # The model is brighter than the truth nearly everywhere: red maps, and no blue but a curve's
    red, blue = pixels[..., 0] - pixels[..., 2], pixels[..., 2] - pixels[..., 0]
    assert (red > 60).sum() > 3 * (blue > 60).sum()
    assert list(tmp_path.iterdir()) == [target]


def test_json_has_the_numbers_and_writes_nothing(tmp_path: Path, monkeypatch: Any) -> None:
    monkeypatch.chdir(tmp_path)
    result = run("compare", "lambert:rho=0.4", "lambert:rho=0.8", "--json")
    (data,) = json.loads(result.stdout)
    assert data["energy"] == pytest.approx(1, rel=SINGLE_LONG)
    assert data["worst"] == pytest.approx(1, rel=SINGLE_LONG)
    assert data["against"] == "lambert rho=0.4"
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (["compare"], "give a MODEL"),
        (["compare", "lambert"], "at least two models"),
        (["compare", "eon", "--truth"], "stands for no layers"),
        (["compare", "weidlich_wilkie", "--truth", "-o", "x.jpg"], "the suffix must be .png"),
    ],
)
def test_mistakes_are_one_line(args: list[str], message: str) -> None:
    result = run(*args)
    assert result.exit_code in (1, 2)
    last = result.stderr.strip().splitlines()[-1]
    assert last.startswith("gonio: error: ")
    assert message in last


def test_pictures_have_no_one_value_to_compare_and_maps_are_left_out_with_a_word(
    tmp_path: Path,
) -> None:
    from PIL import Image

    Image.new("RGB", (2, 2)).save(tmp_path / "a.png")
    (tmp_path / "a.toml").write_text('model = "eon"\nrho = "a.png"\n')
    result = run("compare", str(tmp_path / "a.toml"), "lambert", "--json")
    assert result.exit_code == 1
    assert "rho comes from a.png, and here it needs one value" in result.stderr
    result = run("compare", "patina_3", "lambert", "--json")
    assert result.exit_code == 0
    assert "patina_3: growth comes from the mesh; here it is" in result.stderr


def test_nothing_half_written_stays_behind(tmp_path: Path) -> None:
    found = compare([gonio.Lambert(rho=0.4), gonio.Lambert(rho=0.8)], pictures=False)
    with pytest.raises(FileNotFoundError, match="create it first"):
        drawing.write(tmp_path / "no" / "x.png", found)
    assert not list(tmp_path.iterdir())
    drawing.write(tmp_path / "x.png", found)
    first = (tmp_path / "x.png").read_bytes()
    drawing.write(tmp_path / "x.png", found)
    assert (tmp_path / "x.png").read_bytes() == first


# --- the page --------------------------------------------------------------------------------------

PAGE = Path(__file__).parent.parent / "docs" / "layers.md"


def test_the_page_shows_all_situations_and_settings() -> None:
    text = PAGE.read_text(encoding="utf-8")
    every = document.situations()
    rows = [
        line for line in text.splitlines() if line.startswith("| ") and "mean error" not in line
    ]
    assert len(rows) == sum(len(s.rows) for s in every)
    for situation in every:
        assert f"## {situation.title}\n" in text
        for label, _ in situation.rows:
            assert f"| {label} |" in text
    for name, *_ in document.PICTURES:
        picture = PAGE.parent / "images" / f"layers_{name}.png"
        assert f"images/{picture.name}" in text
        assert picture.stat().st_size < 300_000


def test_commands_on_the_page_make_the_models_that_were_measured() -> None:
    for situation in document.situations():
        for _, settings in situation.rows:
            made = situation.make(settings)
            again = load(model_text(made), [])
            # Numbers are printed with 9 digits.
            numbers = [np.ravel(v) for m in (made, again) for _, _, v in m.parameters()]
            half = len(numbers) // 2
            for one, other in zip(numbers[:half], numbers[half:], strict=True):
                # The ninth digit
                np.testing.assert_allclose(one, other, rtol=1e-8)
            assert type(again) is type(made)


def test_numbers_on_the_page_are_still_true() -> None:
    """One row of each table, measured anew with fewer walks."""
    lines = PAGE.read_text(encoding="utf-8").splitlines()
    for situation in document.situations():
        label, settings = situation.rows[-1]
        start = lines.index(f"## {situation.title}")
        row = next(line for line in lines[start:] if line.startswith(f"| {label} |"))
        cells = [cell.strip() for cell in row.strip("|").split("|")]
        made = situation.make(settings)
        e = measure(made, Stack.of(made), walks=512, pairs=1000, maps=False, seed=1).judge(made)[0]
        # 1000 pairs know the mean of a highlight to a few percent; the truth's albedo is better known.
        assert float(cells[1].rstrip(" %")) / 100 == pytest.approx(e.mean, abs=0.05 + 0.1 * e.mean)
        # The page has two decimals, of other walks
        assert float(cells[-1]) == pytest.approx(e.truth, abs=0.01)
