"""The command `gonio check`: what it takes, prints, writes and refuses; and users' own model files."""

from __future__ import annotations

import json
import math
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from click.testing import CliRunner, Result
from PIL import Image
from support.no_numbers import PLANTED, written
from support.replays import NO_NUMBER, hidden, replays
from support.tolerances import SINGLE, SINGLE_LONG, decimals

import gonio
from gonio.check import check_subjects
from gonio.check.kernels import draw, evaluate
from gonio.check.named import subjects_of
from gonio.cli import main
from gonio.materials import model_file
from gonio.materials.model_file import ModelFileError

BROKEN = Path(__file__).parent / "broken"

# What plug-ins of models have to be given to show their fault.
FAULTY_AT = {"understated": {"rho": 1.0, "sigma": 0.2}}


def run(*words: str) -> Result:
    return CliRunner().invoke(main, ["check", *words])


def test_a_model_that_is_what_it_claims_ends_with_0() -> None:
    result = run("lambert", "--quick", "--only", "energy,albedo")
    assert result.exit_code == 0, result.output
    assert result.stdout.startswith("lambert: pass\n")
    assert "0 FAILED" not in result.stdout


def test_a_broken_file_ends_with_1_and_a_line_to_replay() -> None:
    path = str(BROKEN / "unnormalised_d.py")
    result = run(path, "--quick", "--only", "energy")
    assert result.exit_code == 1
    assert "unnormalised_d: FAIL" in result.stdout
    replay = next(line for line in result.stdout.splitlines() if "gonio eval" in line)
    words = replay.partition("gonio ")[2].split()
    shown = CliRunner().invoke(main, [*words, "--json"])
    assert shown.exit_code == 0, shown.output
    assert json.loads(shown.stdout)["albedo"][0] > 1.5


def test_json_holds_every_number() -> None:
    result = run("qon:sigma=0.2", "--quick", "--only", "energy,continuity", "--json")
    assert result.exit_code == 0, result.output
    reports = json.loads(result.stdout)
    assert [r["check"] for r in reports] == ["energy", "continuity"]
    (largest,) = reports[0]["findings"]
    assert largest["verdict"] == "known"
    assert largest["measured"] == pytest.approx(1.0152, abs=2 * decimals(4))
    assert "dark ring at s = 0" in [f["what"] for f in reports[1]["findings"]]


def test_junit_is_xml_with_a_suite_for_each_model(tmp_path: Path) -> None:
    target = tmp_path / "report.xml"
    result = run(
        "lambert",
        str(BROKEN / "toon.py"),
        "--quick",
        "--only",
        "continuity",
        "--junit",
        str(target),
    )
    assert result.exit_code == 1
    suites = ElementTree.parse(target).getroot().findall("testsuite")
    assert [(s.get("name"), s.get("failures")) for s in suites] == [("lambert", "0"), ("toon", "1")]


@pytest.mark.parametrize("suffix", ["png", "svg"])
def test_plot_draws_what_has_failed(tmp_path: Path, suffix: str) -> None:
    target = tmp_path / f"worst.{suffix}"
    result = run(
        str(BROKEN / "unnormalised_d.py"), "--quick", "--only", "energy", "--plot", str(target)
    )
    assert result.exit_code == 1
    if suffix == "png":
        pixels = np.asarray(Image.open(target).convert("L"))
        assert pixels.min() < 50 < 200 < pixels.max()
    else:
        assert "<svg" in target.read_text()


def test_nothing_to_draw_writes_no_picture(tmp_path: Path) -> None:
    target = tmp_path / "worst.png"
    result = run("lambert", "--quick", "--only", "energy", "--plot", str(target))
    assert result.exit_code == 0
    assert not target.exists()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ([], "give a MODEL"),
        (["--all", "eon"], "it goes with no MODEL"),
        (["eno"], "did you mean the model 'eon'"),
        (["eon", "--only", "enrgy"], "no check 'enrgy'"),
        (["eon:roughness=2"], "out of range"),
        (["eon", "--plot", "x.gif"], ".png, .svg or .pdf"),
        (["eon", "--junit", "no/such/folder/x.xml"], "there is no folder"),
        (["missing.py"], "there is no file missing.py"),
        (["--mitsuba", "roughplasticc"], "Mitsuba cannot load 'roughplasticc'"),
        (["--mitsuba", '{"type": "roughplastic"'], "Mitsuba cannot load"),
        (["--mitsuba", "conductor"], "reflects nothing that is a function"),
        (["--mitsuba", "sphere"], "is no BSDF"),
        (
            [
                "--mitsuba",
                '{"type": "bumpmap", "a": {"type": "checkerboard"}, "b": {"type": "diffuse"}}',
            ],
            "Mitsuba cannot evaluate 'bumpmap': ",
        ),
    ],
)
def test_errors_say_what_to_do(words: list[str], message: str) -> None:
    result = run(*words)
    assert result.exit_code != 0
    assert message in result.stderr
    assert len(result.stderr.strip().splitlines()) == 1


def test_help_teaches_with_examples() -> None:
    text = run("--help").stdout
    for words in ("gonio check eon", "my_model.py", "--mitsuba roughplastic", "--junit"):
        assert words in text


def test_parameters_that_are_given_stay_fixed() -> None:
    (subject,) = subjects_of("qon:sigma=0.2", ["rho=0.5"])
    assert subject.parameters == ()
    assert not subject.whole
    (subject,) = subjects_of("eon:sampler=cosine")
    assert [f.path for f in subject.parameters] == ["rho", "rho", "rho", "roughness"]
    assert subject.chosen["sampler"] == "cosine"


def test_a_model_alone_is_checked_with_every_option() -> None:
    tags = [s.tag() for s in subjects_of("phong")]
    assert tags == ["", "form=classical"]


def test_a_material_is_checked_as_it_is() -> None:
    (subject,) = subjects_of("gold")
    assert subject.parameters == ()
    assert subject.name == "gold"


def test_a_material_whose_flakes_a_map_drives_keeps_their_range() -> None:
    from gonio.materials import library, load_material

    name = next(n for n in library() if load_material(n).flakes)
    (subject,) = subjects_of(name)
    assert [f.path for f in subject.parameters] == ["flake_x", "flake_y"]


# --- Mitsuba -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "text",
    [
        "diffuse",
        '{"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.25, 0.5, 0.75]}}',
        '<bsdf type="diffuse"><rgb name="reflectance" value="0.25, 0.5, 0.75"/></bsdf>',
    ],
)
def test_mitsubas_diffuse_is_lambert_in_every_notation(text: str) -> None:
    result = run("--mitsuba", text, "--quick", "--only", "energy,reciprocity", "--json")
    assert result.exit_code == 0, result.output
    energy, reciprocity = json.loads(result.stdout)
    assert energy["model"] == "diffuse"
    assert energy["findings"][0]["measured"] == pytest.approx(
        0.5 if text == "diffuse" else 0.75, abs=SINGLE_LONG
    )
    # Rounding alone, of values in single precision
    assert reciprocity["findings"][0]["measured"] < 1e-4


def test_a_mitsuba_bsdf_that_gains_energy_is_caught() -> None:
    text = '{"type": "diffuse", "reflectance": {"type": "rgb", "value": [1.5, 0.5, 0.5]}}'
    text = text.replace('"rgb"', '"rgb"')
    model = '{"type": "gonio_qon", "rho": 1.0, "sigma": 0.2}'
    result = run("--mitsuba", model, "--quick", "--only", "energy", "--json")
    assert result.exit_code == 1
    (energy,) = json.loads(result.stdout)
    # The published maximum, searched for with --quick
    assert energy["findings"][0]["measured"] == pytest.approx(1.0152, abs=1e-3)


def test_a_mitsuba_bsdf_from_a_file(tmp_path: Path) -> None:
    path = tmp_path / "grey.xml"
    path.write_text('<?xml version="1.0"?>\n<bsdf version="3.0.0" type="diffuse"/>')
    result = run("--mitsuba", str(path), "--quick", "--only", "energy")
    assert result.exit_code == 0, result.output
    assert result.stdout.startswith("grey: pass")


def test_textures_of_every_kind_are_looked_at_all_over() -> None:
    """A checkerboard sets no flag; its darker squares are in the middle of the first period."""
    squares = {f"color{k}": {"type": "rgb", "value": [v] * 3} for k, v in ((0, 0.1), (1, 0.9))}
    model = {"type": "diffuse", "reflectance": {"type": "checkerboard", **squares}}
    result = run("--mitsuba", json.dumps(model), "--quick", "--only", "energy", "--json")
    (energy,) = json.loads(result.stdout)
    # Searched for with --quick
    assert energy["findings"][0]["measured"] == pytest.approx(0.9, abs=1e-3)


def found(model: dict[str, Any], only: str) -> tuple[int, dict[tuple[str, str], dict[str, Any]]]:
    """The exit code, and findings of a Mitsuba BSDF by side and by what they are about."""
    result = run("--mitsuba", json.dumps(model), "--quick", "--only", only, "--json")
    reports = json.loads(result.stdout)
    return result.exit_code, {(f["options"], f["what"]): f for r in reports for f in r["findings"]}


@pytest.mark.parametrize(
    "model",
    [
        {"type": "mask", "opacity": 0.5, "nested": {"type": "diffuse"}},
        {"type": "principled", "spec_trans": 0.7, "roughness": 0.3},
        {"type": "principledthin", "spec_trans": 0.5, "roughness": 0.4, "diff_trans": 0.8},
        {"type": "roughdielectric", "alpha": 0.3},
    ],
    ids=lambda model: str(model["type"]),
)
def test_reflection_of_plug_ins_that_also_transmit_follows_its_density(
    model: dict[str, Any],
) -> None:
    """Mitsuba tests these samplers itself; delta and transmitted samples count as lost here."""
    _, by_side = found(model, "sampling")
    assert by_side["", "left out"]["text"].startswith("not checked: ")
    wasted = [f["measured"] for (_, what), f in by_side.items() if what == "wasted samples"]
    assert min(wasted) > 0.4
    # Inside rough glass 0.1 % fewer samples are reflected than the density says, as 4 million samples with
    # Mitsuba's own random numbers show: where total reflection begins
    known = {"side=back"} if model["type"] == "roughdielectric" else set()
    assert {side for (side, _), f in by_side.items() if f["verdict"] == "fail"} <= known


def test_both_sides_of_a_surface_are_looked_at() -> None:
    sides = {
        "a": {"type": "diffuse", "reflectance": 0.5},
        "b": {"type": "diffuse", "reflectance": 1.5},
    }
    code, by_side = found({"type": "twosided", **sides}, "energy")
    front, back = (by_side[f"side={side}", "largest albedo"] for side in ("front", "back"))
    assert (front["verdict"], back["verdict"], code) == ("pass", "fail", 1)
    assert back["measured"] == pytest.approx(1.5, abs=SINGLE_LONG)
    # Below the surface, as Mitsuba has it
    assert re.search(r"--wo \S+ \S+ -0\.\d+ ", back["replay"])
    assert shown_by(back["replay"])["albedo"][0] == pytest.approx(1.5, abs=SINGLE_LONG)


def shown_by(line: str) -> Any:
    """What a `gonio eval` line gives."""
    result = CliRunner().invoke(main, [*shlex.split(line)[1:], "--json"])
    assert result.exit_code == 0, result.output
    return json.loads(result.stdout)


@pytest.mark.parametrize(
    ("name", "only"),
    [
        ("understated", "energy"),
        ("non_reciprocal", "reciprocity"),
        ("pdf_tilted", "sampling"),
        ("reported_infinite", "sampling"),
        ("eval_nan", "energy"),
        ("eval_nan", "reciprocity"),
        ("eval_nan", "isotropy"),
        ("pdf_nan", "finite"),
    ],
)
def test_a_fault_of_a_mitsuba_bsdf_has_a_line_that_shows_it(
    name: str, only: str, tmp_path: Path
) -> None:
    """Broken models as plug-ins: an integral, two orders, many samples, one sample, and no numbers."""
    import gonio.mitsuba
    from gonio.check.mitsuba_bsdf import sides_of

    path = written(tmp_path, name) if name in PLANTED else BROKEN / f"{name}.py"
    sides_of("diffuse")  # sets a variant, which plug-ins are registered in
    gonio.mitsuba.register(model_file.load(path))
    sides = sides_of(json.dumps({"type": f"gonio_{name}"} | FAULTY_AT.get(name, {})))
    reports = check_subjects(sides, "quick", [only])
    lines = replays(reports, again=True)
    assert lines
    for report, finding in lines:
        assert (NO_NUMBER.search(finding.text) is not None) == (name in PLANTED)
        assert not hidden(report, finding)


def test_a_line_keeps_the_place_in_a_texture() -> None:
    squares = {"color0": 0.1, "color1": 1.5}
    model = {"type": "diffuse", "reflectance": {"type": "checkerboard", **squares}}
    _, by_side = found(model, "energy")
    line = by_side["", "largest albedo"]["replay"]
    assert shown_by(line)["albedo"][0] == pytest.approx(1.5, abs=SINGLE_LONG)
    place = re.findall(r"--param (?:u|v)=\S+", line)
    result = run("--mitsuba", json.dumps(model), *" ".join(place).split(), "--only", "energy")
    assert result.exit_code == 1
    assert "over 16 places" not in result.output


def test_what_mirrors_shows_the_energy_of_all_parts() -> None:
    model = {"type": "mask", "opacity": 0.5, "nested": {"type": "diffuse", "reflectance": 1.5}}
    _, by_side = found(model, "energy")
    whole = by_side["", "all parts together"]
    # The same samples
    assert shown_by(whole["replay"])["all_parts"] == pytest.approx(whole["measured"], abs=SINGLE)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ([], "give a MODEL, or --mitsuba NAME"),
        (["eon", "--mitsuba", "diffuse"], "give a MODEL, or --mitsuba NAME"),
        (["--mitsuba", "diffuse", "--double"], "leave --double and the like out"),
        (["--mitsuba", "diffuse", "-p", "w=1"], "write u=0.3 and v=0.7"),
        (["--mitsuba", "diffuse", "--wo", "0", "0", "-1"], "diffuse reflects nothing on its back"),
        (["--mitsuba", "diffuse", "-p", "u=0.3"], "diffuse has no texture"),
        (["--mitsuba", "diffuse", "--function", "f"], "belong to a FILE of code"),
        (["--mitsuba", "eon"], "eon is a model of gonio's, and goes without --mitsuba"),
        (["--mitsuba", "roughplastic:alpha=0.2"], '\'{"type": "roughplastic", ...}\''),
    ],
)
def test_what_a_plug_in_cannot_be_asked_is_said_in_one_line(words: list[str], message: str) -> None:
    given = [] if "--wo" in words else ["--wo", "0", "0", "1"]
    result = CliRunner().invoke(main, ["eval", *words, *given, "--u", "0.5", "0.5"])
    assert result.exit_code in (1, 2)
    assert message in result.stderr
    assert result.stderr.count("\n") == 1


@pytest.mark.parametrize(("white", "verdict"), [(1.0, "pass"), (1.5, "fail")])
def test_the_energy_of_all_parts_counts_and_not_of_one_alone(white: float, verdict: str) -> None:
    """A mask of one half lets one half through, beside what half of a surface reflects."""
    nested = {"type": "diffuse", "reflectance": white}
    _, by_side = found({"type": "mask", "opacity": 0.5, "nested": nested}, "energy")
    part, whole = by_side["", "largest albedo"], by_side["", "all parts together"]
    assert part["verdict"] == "note"
    assert whole["verdict"] == verdict
    # Means of samples, to three digits
    assert (part["measured"], whole["measured"]) == pytest.approx(
        (white / 2, white / 2 + 0.5), abs=1e-3
    )


def test_a_bump_map_tilts_the_surface_below_it(tmp_path: Path) -> None:
    """A slope of 1 tilts the normal by 45°, and along the old one Lambert's cosine is that of 45°."""
    import mitsuba as mi

    from gonio.check.mitsuba_bsdf import sides_of

    size = 64
    ramp = np.tile((np.arange(size, dtype=np.float32) / size)[None, :, None], (size, 1, 1))
    slope = {"type": "bitmap", "filename": str(tmp_path / "ramp.exr"), "raw": True}
    model = {"type": "bumpmap", "a": slope, "b": {"type": "diffuse"}}
    sides_of("diffuse")  # sets a variant, which Bitmap needs
    mi.Bitmap(ramp).write(slope["filename"])
    (subject,) = sides_of(json.dumps(model))
    rows, up = np.zeros(8, np.uint32), np.tile([0.0, 0.0, 1.0], (8, 1))
    place = np.array([[0.3, 0.4]])
    f, _ = evaluate(subject, place, rows, up, up)
    np.testing.assert_allclose(f, 0.5 / math.pi * math.cos(math.pi / 4), rtol=SINGLE)
    u = np.random.default_rng(3).random((8, 2))
    wi, _ = draw(subject, place, rows, up, u)
    np.testing.assert_allclose(np.linalg.norm(wi, axis=1), 1, rtol=SINGLE)


def test_a_furnace_is_looked_at_in_many_places() -> None:
    squares = {"color0": 0.2, "color1": 0.8}
    model = {"type": "diffuse", "reflectance": {"type": "checkerboard", **squares}}
    _, by_side = found(model, "energy")
    assert "(0.2000 to 0.8000) at 30°" in by_side["", "in a white furnace"]["text"]


def test_what_is_left_out_of_a_mitsuba_bsdf_is_named() -> None:
    result = run("--mitsuba", "plastic", "--quick", "--only", "reciprocity")
    # In the verdict too, which is what is read first, and not in the table alone
    verdict = result.stdout.splitlines()[0]
    assert verdict.endswith("; not checked: delta lobes, but for their energy")
    assert "not checked: delta lobes" in result.stdout


# --- model files ---------------------------------------------------------------------------------

MINE = """
from gonio.lang import INV_PI, Color, Float, Sample, Vec2, Vec3
from gonio.model import Model, param
from gonio.parts.hemisphere import pdf_cosine, sample_cosine


class Mine(Model):
    '''Lambert again.'''

    rho: Color = param((0.5, 0.5, 0.5), 0, 0.9, "colour")

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        return self.rho * INV_PI

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        wi = sample_cosine(u)
        return Sample(wi, pdf_cosine(wi))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        return pdf_cosine(wi)
"""


def test_a_users_file_is_a_model_named_like_the_file(tmp_path: Path) -> None:
    path = tmp_path / "mine.py"
    path.write_text(MINE)
    cls = model_file.load(path)
    assert cls.name == "mine"
    assert cls(rho=0.3).eval([0, 0, 1], [0, 0, 1])[0] == pytest.approx(0.3 / np.pi)
    assert model_file.load(path) is cls
    path.write_text(MINE.replace("INV_PI\n", "INV_PI * 0.5\n", 2))
    assert model_file.load(path) is not cls


def test_a_file_saved_twice_in_one_second_is_read_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Python takes its bytecode for a file's when the second and the size are the same
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    path = tmp_path / "mine.py"
    values = []
    for rho in ("0.5", "0.6"):
        path.write_text(MINE.replace("(0.5, 0.5, 0.5)", f"({rho}, {rho}, {rho})"))
        os.utime(path, (1e9, 1e9))
        values.append(model_file.load(path)().eval([0, 0, 1], [0, 0, 1])[0] * np.pi)
    assert values == pytest.approx([0.5, 0.6])


def test_a_users_file_may_be_called_like_a_model_and_leaves_the_registry_alone(
    tmp_path: Path,
) -> None:
    before = dict(gonio.models())
    path = tmp_path / "eon.py"
    path.write_text(MINE.replace("Mine", "EON"))
    assert model_file.load(path) is not before["eon"]
    assert gonio.models() == before
    bad = tmp_path / "qon.py"
    bad.write_text(MINE.replace("Mine", "QON") + "\n1 / 0\n")
    with pytest.raises(ModelFileError, match="ZeroDivisionError"):
        model_file.load(bad)
    assert gonio.models() == before


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("x = 1", "defines no model"),
        ("def f(:\n", r"broken.py, line 1: "),
        ("import gonio\n\nraise KeyError('a')\n", r"broken.py, line 3: KeyError"),
        (MINE + MINE.replace("Mine", "Other"), r"several models \(Mine, Other\)"),
        (MINE.replace("def pdf", "def density"), "has no method pdf"),
        (MINE.replace("0.9", "0.1"), r"out of range"),
    ],
)
def test_a_file_without_a_usable_model_says_why(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "broken.py"
    path.write_text(text)
    with pytest.raises(ModelFileError, match=message):
        model_file.load(path)


def test_of_several_models_the_one_named_like_the_file_counts(tmp_path: Path) -> None:
    path = tmp_path / "other_one.py"
    path.write_text(MINE + MINE.replace("class Mine", "class OtherOne"))
    assert model_file.load(path).__name__ == "OtherOne"


def test_a_file_is_evaluated_by_its_path(tmp_path: Path) -> None:
    path = tmp_path / "mine.py"
    path.write_text(MINE)
    words = ["eval", f"{path}:rho=0.3", "--wi", "0", "0", "1", "--wo", "0", "0", "1", "--json"]
    result = CliRunner().invoke(main, words)
    assert result.exit_code == 0, result.output
    assert json.loads(result.stdout)["albedo"][0] == pytest.approx(0.3, abs=SINGLE)


def test_a_search_writes_what_is_asked_for_and_refuses_what_it_does_not_search(
    tmp_path: Path,
) -> None:
    xml, code = tmp_path / "found.xml", tmp_path / "matte.glsl"
    words = ["check", "lambert", "--fuzz", "1e3"]
    found = CliRunner().invoke(main, [*words, "--json", "--junit", str(xml)])
    assert found.exit_code == 0, found.output
    assert [(r["model"], r["check"]) for r in json.loads(found.stdout)] == [("lambert", "fuzz")]
    assert 'classname="gonio.check.lambert" name="fuzz"' in xml.read_text(encoding="utf-8")
    code.write_text("vec3 brdf(vec3 L, vec3 V, vec3 N) { return vec3(0.1); }\n", encoding="utf-8")
    refused = CliRunner().invoke(main, ["check", f"{code}#brdf", "--fuzz", "1e3"])
    assert refused.exit_code == 2
    assert "check matte.glsl#brdf without it" in refused.stderr


def test_the_command_starts_without_what_it_does_not_need() -> None:
    """Whether a name is one of code is asked of all; what runs code loads with the first code."""
    code = (
        "import sys, gonio.cli.eval, gonio.cli.plot, gonio.cli.view, gonio.cli.compare\n"
        "print({'mitsuba', 'gonio.check', 'gonio.foreign.compiling'} & set(sys.modules))\n"
        "import gonio.cli.check\n"
        "print({'gonio.fit', 'gonio.export', 'gonio.foreign.identity'} & set(sys.modules))\n"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.split() == ["set()", "set()"]
