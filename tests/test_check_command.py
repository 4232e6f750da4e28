"""The command `gonio check`: what it takes, prints, writes and refuses; and users' own model files."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from click.testing import CliRunner, Result
from PIL import Image
from support.tolerances import SINGLE, SINGLE_LONG, decimals

import gonio
from gonio.check.named import subjects_of
from gonio.cli import main
from gonio.materials import model_file
from gonio.materials.model_file import ModelFileError

BROKEN = Path(__file__).parent / "broken"


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
    result = run("--mitsuba", json.dumps(model), "--quick", "--only", "sampling", "--json")
    assert result.exit_code == 0, result.output
    scope, sampling = json.loads(result.stdout)
    assert scope["findings"][0]["text"].startswith("not checked: ")
    wasted = next(f for f in sampling["findings"] if f["what"] == "wasted samples")
    assert wasted["measured"] > 0.4


def test_what_is_left_out_of_a_mitsuba_bsdf_is_named() -> None:
    result = run("--mitsuba", "plastic", "--quick", "--only", "reciprocity")
    # In the verdict too, which is what is read first, and not in the table alone
    verdict = result.stdout.splitlines()[0]
    assert verdict.endswith("; not checked: delta lobes")
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
