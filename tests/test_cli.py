"""The command line: what it prints, and how it says what was wrong."""

import inspect
import json
import math
import os
import shlex
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import click
import numpy as np
import pytest
from click.testing import CliRunner
from support.tolerances import DOUBLE_SHORT, NINE_DIGITS, SINGLE, decimals

import gonio
from gonio import cli, doctor
from gonio.cli.eval import directions, evaluate
from gonio.description.about import describe
from gonio.materials import load

# Text keeps all digits of a double; the formula has a rounding or two.
PRINTED = 1e-15


PROGRAM = Path(sys.executable).with_name("gonio")


def run(*arguments):
    return CliRunner().invoke(cli.main, [str(a) for a in arguments])


def run_json(*arguments):
    result = run(*arguments, "--json")
    assert result.exit_code == 0, result.stderr
    return json.loads(result.stdout)


# ------------------------------------------------------------------------------- list and show


def test_list_has_a_line_for_every_model():
    lines = run("list").stdout.splitlines()
    assert [line.split()[0] for line in lines] == list(gonio.models())
    assert all(len(line.split()) > 3 for line in lines)


def test_list_as_json_has_names_and_summaries():
    rows = run_json("list")
    assert [row["name"] for row in rows] == list(gonio.models())
    assert all(row["summary"] for row in rows)


@pytest.mark.parametrize("name", gonio.models())
def test_what_a_model_should_not_be_confused_with_is_another_model(name):
    for other, difference in gonio.models()[name].unlike:
        assert other in gonio.models()
        assert other != name
        assert len(difference.split()) > 3
        assert f"{other}: " in run("show", name).stdout


@pytest.mark.parametrize("name", gonio.models())
def test_show_tells_all_about_every_model(name):
    about = run_json("show", name)
    cls = gonio.models()[name]
    assert about["source"]
    assert about["mitsuba"] == f"gonio_{name}"
    shown = [f["name"] for f in about["parameters"] + about["options"] + about["models"]]
    assert sorted(shown) == sorted(cls.fields)
    text = run("show", name).stdout
    for word in (*cls.fields, "Source", f"gonio.{cls.__name__}(", f"gonio_{name}"):
        assert word in text
    for caveat in cls.caveats:
        assert " ".join(caveat.split()) in " ".join(text.split())


def test_show_says_which_albedos_are_closed_forms():
    assert describe(gonio.EON)["closed_form"] == {"albedo": True, "mean_albedo": True}
    assert describe(gonio.OrenNayar)["closed_form"] == {"albedo": False, "mean_albedo": True}
    assert "numeric quadrature" in run("show", "oren_nayar").stdout


def test_the_python_line_of_show_works():
    for name in gonio.models():
        line = next(x for x in run("show", name).stdout.splitlines() if "  Python " in x)
        call = line.split(maxsplit=1)[1]
        w = np.array([0, 0, 1.0])
        assert np.shape(eval(call, {"gonio": gonio, "wi": w, "wo": w})) == (3,)


def test_the_lines_of_show_know_where_a_file_of_ones_own_is(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "my lobe.py"
    path.write_text(inspect.getsource(inspect.getmodule(gonio.Lambert)), encoding="utf-8")
    uses = dict(
        line.split(maxsplit=1)
        for line in run("show", path.name).stdout.splitlines()
        if line.startswith(("  Python ", "  Shell ", "  Mitsuba "))
    )
    w = np.array([0, 0, 1.0])
    np.testing.assert_array_equal(
        eval(uses["Python"], {"gonio": gonio, "wi": w, "wo": w}), gonio.Lambert().eval(w, w)
    )
    assert shlex.split(uses["Shell"])[:3] == ["gonio", "eval", "my lobe.py"]
    assert 'gonio.load("my lobe.py").written' in uses["Mitsuba"]


def test_the_ranges_that_show_prints_are_accepted():
    for name in gonio.models():
        for line in run("show", name).stdout.splitlines():
            if " float " in line:
                field = line.split()[0]
                low, high = line.partition("[")[2].partition("]")[0].split(", ")
                for value in (low, high):
                    if value != "inf":
                        load(f"{name}:{field}={value}")


# --------------------------------------------------------------------------------------- eval


def test_lambert_is_rho_over_pi():
    result = run_json("eval", "lambert", "--wi", 0, 0, 1, "--wo", 0.6, 0, 0.8, "--double")
    assert result["eval"] == pytest.approx([0.8 / math.pi] * 3, rel=PRINTED)
    assert result["pdf"] == pytest.approx(1 / math.pi, rel=PRINTED)
    assert result["weight"] == pytest.approx([0.8] * 3, rel=PRINTED)
    assert result["albedo"] == result["mean_albedo"] == [0.8] * 3


def test_white_eon_reflects_everything():
    result = run_json("eval", "eon", "--theta-i", 10, "--theta-o", 85, "-p", "rho=1")
    assert result["albedo"] == pytest.approx([1] * 3, abs=SINGLE)
    assert result["mean_albedo"] == pytest.approx([1] * 3, abs=SINGLE)


def test_double_has_the_digits_of_double_everywhere():
    args = ("eval", "fon:roughness=1,rho=1", "--theta-i", 0, "--theta-o", 0)
    c1 = 0.5 - 2 / (3 * math.pi)
    expected = (1 + 2 / 3 - 28 / (15 * math.pi)) / (1 + c1)  # Eq. 15 of EON
    assert run_json(*args, "--double")["mean_albedo"] == pytest.approx(
        [expected] * 3, rel=DOUBLE_SHORT
    )
    assert run_json(*args)["mean_albedo"] == pytest.approx([expected] * 3, rel=SINGLE)


def test_angles_and_vectors_are_two_ways_to_say_the_same():
    vectors = run_json(
        "eval", "eon", "--wi", -0.6, 0, 0.8, "--wo", 1, 0, 1, "--normalize", "--double"
    )
    theta_i = math.degrees(math.asin(0.6))
    angles = run_json(
        "eval", "eon", "--theta-i", theta_i, "--theta-o", 45, "--phi", 180, "--double"
    )
    assert vectors["eval"] == pytest.approx(angles["eval"], rel=DOUBLE_SHORT)


def test_phi_is_the_azimuth_from_viewer_to_light():
    wi, wo = directions(None, None, 90, 90, 90, False)
    assert wi.tolist() == [0, 1, 0]
    assert wo.tolist() == [1, 0, 0]


def test_options_and_colours_are_parameters_too():
    result = run_json(
        "eval",
        "eon",
        "--theta-i",
        0,
        "--theta-o",
        0,
        "-p",
        "sampler=cosine",
        "-p",
        "rho=0.8,0.3,0.1",
    )
    assert result["pdf"] == pytest.approx(1 / math.pi, rel=SINGLE)
    assert result["eval"][0] > result["eval"][1] > result["eval"][2]


def test_the_text_of_eval_has_the_numbers_of_its_json():
    args = ("eval", "lambert:rho=0.8/0.3/0.1", "--theta-i", 30, "--theta-o", 60)
    text, numbers = run(*args).stdout, run_json(*args)
    assert f"{numbers['pdf']:.9g} 1/sr" in text
    assert ", ".join(f"{v:.9g}" for v in numbers["eval"]) in text
    assert "(theta 30°)" in text


def test_below_the_horizon_there_is_no_weight():
    args = ("eval", "eon", "--theta-i", 100, "--theta-o", 0)
    result = run_json(*args)
    assert result["eval"] == [0] * 3
    assert result["weight"] is None
    assert "wi not above the horizon" in run(*args).stdout


def test_a_pair_of_directions_is_compared_in_another_precision_exchanged_and_turned(tmp_path):
    """Of f = x_i / π: exchanged it is x_o / π, and a quarter turn makes it -y_i / π."""
    path = tmp_path / "slanted.py"
    path.write_text(
        "from gonio.lang import INV_PI, Color, Float, Sample, Vec2, Vec3\n"
        "from gonio.model import Model, param\n"
        "from gonio.parts.hemisphere import pdf_cosine, sample_cosine\n\n\n"
        "class Slanted(Model):\n"
        "    rho: Color = param(1, 0, 1, 'colour')\n"
        "    def eval(self, wi: Vec3, wo: Vec3) -> Color: return self.rho * (wi.x * INV_PI)\n"
        "    def pdf(self, wi: Vec3, wo: Vec3) -> Float: return pdf_cosine(wi)\n"
        "    def sample(self, wo: Vec3, u: Vec2) -> Sample:\n"
        "        wi = sample_cosine(u)\n"
        "        return Sample(wi, pdf_cosine(wi))\n"
    )
    pair = (path, "--wi", 0.48, 0.36, 0.8, "--wo", 0.6, 0, 0.8)
    for words, expected in (
        (("--compare", "double"), 0.48),
        (("--double", "--compare", "swapped"), 0.6),
        (("--double", "--compare", "turned:90"), -0.36),
    ):
        result = run_json("eval", *pair, *words)
        value, other = (math.pi * e["eval"][0] for e in (result, result["compared"]))
        assert (value, other) == pytest.approx((0.48, expected), rel=SINGLE)
    assert run_json("eval", *pair, "--compare", "double")["compared"]["precision"] == "float64"
    last = run("eval", *pair, "--double", "--compare", "swapped").stdout.splitlines()[-1]
    assert "eval 0.2, pdf 0," in last


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--theta-i", 9, "--compare", "halved"), "double, swapped, or turned:DEG"),
        (("--theta-i", 9, "--compare", "turned:x"), "such as turned:90"),
        (("--theta-i", 9, "--double", "--compare", "double"), "leave --double out"),
        (("--u", 0.1, 0.2, "--compare", "swapped"), "goes with --wi and --wo"),
    ],
)
def test_what_cannot_be_compared_is_one_line(words, message):
    result = run("eval", "lambert", "--theta-o", 60, *words)
    assert result.exit_code == 2
    assert message in result.stderr
    assert result.stderr.count("\n") == 1


def test_evaluate_is_a_python_function():
    assert evaluate(gonio.Lambert(), [0, 0, 1], [0, 0, 1]).pdf == pytest.approx(1 / math.pi)


# -------------------------------------------------------------------------------- models as text


def test_text_is_read_as_numbers_colours_and_options():
    model = load("eon:roughness=1,rho=0.8/0.3/0.1", ["sampler=cosine", "roughness=0"])
    assert repr(model) == "EON(rho=(0.8, 0.3, 0.1), roughness=1.0, sampler='cosine')"


@pytest.mark.parametrize(
    ("text", "params", "message"),
    [
        ("bdpt", (), "no model, material or file 'bdpt'; 'gonio list' and"),
        ("eonn", (), "file 'eonn'; did you mean the model 'eon'? 'gonio list' and"),
        ("eon:", (), "'eon:' ends in a colon; write eon:name=value or eon."),
        ("eon:rough", (), "eon: 'rough' is not name=value; its names are rho, roughness,"),
        ("eon", ("=1",), "eon: '=1' is not name=value; its names are rho, roughness,"),
        ("eon:roughness=abc", (), "eon: roughness=abc is not a number; allowed is 0 to 1."),
        ("eon", ("roughness=",), "eon: roughness= is not a number; allowed is 0 to 1."),
        (
            "eon",
            ("roughness=0.5,1",),
            "eon: roughness takes one number, got (0.5, 1.0); allowed is 0 to 1.",
        ),
        ("eon", ("roughness=2",), "eon: roughness=2.0 is out of range; allowed is 0 to 1."),
        ("eon", ("roughness=nan",), "eon: roughness=nan is out of range; allowed is 0 to 1."),
        (
            "eon",
            ("rho=red",),
            "eon: rho=red is not one or three numbers, such as 0.8/0.3/0.1, or #c08040;",
        ),
        ("eon", ("rho=1,2",), "eon: rho takes one or three numbers, got (1.0, 2.0);"),
        ("eon:rho=0.8,0.3,0.1", (), "in a model's text a colour has slashes, such as rho=0.8/0.3"),
        ("eon", ("roughness=1", "roughness=0"), "eon: roughness is given twice."),
        ("eon", ("sampler=best",), "eon: sampler='best' is not known; allowed are cltc_matched,"),
        ("eon", ("rougness=1",), "eon has no 'rougness'; did you mean 'roughness'? known are rho,"),
    ],
)
def test_a_model_that_makes_no_sense_is_explained(text, params, message):
    with pytest.raises(gonio.ModelError) as caught:
        load(text, params)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


# --------------------------------------------------------------------- plot, convert, doctor


def test_plot_writes_the_numbers_of_lambert(tmp_path):
    path = tmp_path / "x.csv"
    result = run("plot", "lambert", "-p", "rho=0.5", "--theta-o", "0,45", "-o", path)
    assert result.exit_code == 0, result.stderr
    assert result.stdout == f"{path}\n"
    header, *rows = path.read_text().splitlines()
    assert header.split(",")[:3] == ["model", "theta_o [deg]", "theta_i [deg]"]
    assert len(rows) == 2 * 361
    middle = rows[180].split(",")
    assert [float(v) for v in middle[1:]] == pytest.approx(
        [0, 0, *[0.5 / math.pi] * 3], rel=NINE_DIGITS
    )


def test_plot_has_a_name_for_its_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert run("plot", "lambert", "--kind", "albedo", "--dpi", 40).exit_code == 0
    assert (tmp_path / "albedo.png").read_bytes().startswith(b"\x89PNG")


def test_vary_plots_every_value_of_every_model(tmp_path):
    path = tmp_path / "x.csv"
    args = ("--vary", "roughness=0,1", "--theta-o", 0, "--no-cosine", "-o", path)
    assert run("plot", "eon", "fon:rho=0.5", *args).exit_code == 0
    models = {row.partition('",')[0] for row in path.read_text().splitlines()[1:]}
    assert len(models) == 4


def test_named_substances_are_listed_with_what_they_reflect():
    rows = {row["name"]: row for row in run_json("list", "--f0")}
    # ((n - 1) / (n + 1))^2
    assert rows["water"]["f0"] == pytest.approx([(0.333 / 2.333) ** 2] * 3)
    assert rows["diamond"]["f0"][0] == pytest.approx(0.172, abs=decimals(3))
    assert rows["vacuum"]["f0"] == [0, 0, 0]
    r, g, b = rows["Au"]["f0"]  # yellow
    assert r > 0.9 > g > 0.7 > 0.5 > b
    assert run("list", "--f0", "--parts").exit_code == 2


def test_an_index_may_be_a_word():
    assert "eta = 1.333" in run("show", "torrance_sparrow:fresnel=dielectric,eta=water").stdout
    for given, k in (("eta=water", 0), ("k=2,eta=water", 2)):  # not the extinction of copper
        assert gonio.load(f"torrance_sparrow:{given}").k == k  # type: ignore[union-attr]
    wrong = run("show", "torrance_sparrow:fresnel=dielectric,eta=watr")
    assert wrong.exit_code == 1
    assert "did you mean 'water'" in wrong.stderr
    # A colour or a roughness is no index
    assert run("show", "lambert:rho=water").exit_code == 1


def test_convert_takes_angles_as_people_write_them():
    assert run("convert", "pi/4", "--from", "sigma", "--to", "r").stdout == (
        run("convert", math.pi / 4, "--from", "sigma", "--to", "r").stdout
    )
    assert "'x' is not a number" in run("convert", "x", "--from", "sigma", "--to", "r").stderr


def test_convert_prints_the_value_and_how():
    result = run("convert", 0.5, "--from", "perceptual", "--to", "alpha")
    value, step = result.stdout.splitlines()
    assert value == "0.25"
    assert "alpha = perceptual²" in step
    assert run_json("convert", 10, "--from", "shininess", "--to", "sigma") == {
        "value": pytest.approx(math.sqrt(0.2)),
        "from": "shininess",
        "to": "sigma",
        "steps": ["sigma_from_shininess"],
    }


def test_the_help_of_convert_lists_the_scales_that_there_are():
    from gonio.conversions import SCALES

    text = " ".join(run("convert", "--help").stdout.split())
    for scale in SCALES.values():
        assert f"{scale.name} {scale.meaning}" in text


def test_doctor_ends_with_1_when_nothing_computes(monkeypatch):
    found = [doctor.Finding("backend", "ok", "llvm")]
    monkeypatch.setattr(doctor, "diagnose", lambda: found)
    assert run("doctor").exit_code == 0
    assert run_json("doctor") == [
        {"name": "backend", "status": "ok", "value": "llvm", "advice": ""}
    ]
    found[0] = doctor.Finding("backend", "broken", "scalar", "install LLVM")
    result = run("doctor")
    assert result.exit_code == 1
    assert "→ install LLVM" in result.stdout


# ------------------------------------------------------------------------------------- errors


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (("show", "eonn"), 1, "file 'eonn'; did you mean the model 'eon'?"),
        (("lst",), 2, "no command 'lst'; did you mean 'list'? 'gonio --help' shows all."),
        (("eval", "eon", "--roughness", "1"), 2, "given as --param roughness=VALUE."),
        (("eval", "eon", "--theta-o", "4", "--u", "0.3", "1.2"), 2, "numbers lie from 0 to 1"),
        (("eval", "eon", "--u", "0.3", "--theta-o", "4"), 2, "too few numbers stand before it"),
        (
            ("eval", "eon", "--theta-i", "3", "--theta-o", "4", "--normalize"),
            2,
            "--normalize scales --wi and --wo; leave it out beside angles",
        ),
        (("eval", "eon"), 1, "give both directions, either as vectors, --wi X Y Z --wo X Y Z"),
        (("eval", "eon", "--wi", "0", "0", "1"), 1, "give both directions"),
        (("eval", "eon", "--theta-i", "1", "--wo", "0", "0", "1"), 1, "give both directions"),
        (("eval", "eon", "--wi", "0", "0", "1", "--theta-o", "1"), 1, "give both directions"),
        (("eval", "eon", "--wi", "0", "1"), 2, "Option '--wi' requires 3 arguments"),
        (
            ("eval", "eon", "--wi", "0", "0", "2", "--wo", "0", "0", "1"),
            1,
            "wi = [0.0, 0.0, 2.0] has length 2; give unit vectors, or add --normalize.",
        ),
        (
            ("eval", "eon", "--wi", "0", "0", "0", "--wo", "0", "0", "1", "--normalize"),
            1,
            "wi = [0.0, 0.0, 0.0] has no direction; give finite numbers, not all 0.",
        ),
        (("plot",), 2, "Missing argument 'MODEL...'"),
        (("plot", "eon", "-o", ""), 2, "the output has no name; is a variable of the shell"),
        (("bake", "split-sum", "gold", "--output="), 2, "the output has no name; is a variable"),
        (("view", "eon", "--save", ""), 2, "the output has no name; is a variable of the shell"),
        (("plot", "eon", "-o", "x.gif"), 1, "'x.gif': its name must end in .png, .svg, .pdf or"),
        (("plot", "eon", "-o", "no/x.png"), 1, "cannot write 'no/x.png': no folder 'no'."),
        (("plot", "eon", "--theta-o", "30;60"), 2, "'--theta-o': '30;60' is not a list of degrees"),
        (("plot", "eon", "--theta-o", "90"), 2, "degrees from 0 to less than 90, such as 0,30,60"),
        (("render", "eon", "--camera", "0,91"), 2, "'0,91' is not AZIMUTH,ELEVATION in degrees"),
        (("render", "eon", "--noise", "inf"), 2, "inf is not a finite number above 0; see 'gonio"),
        (("bake", "blur", "studio", "--alpha", "1", "--width", "0"), 1, "width=0 is out of range"),
        (("bake", "cube", "studio", "--size", "0"), 1, "size=0 is out of range; allowed are 64,"),
        (("reproduce", "-o", "reproduced"), 2, "nothing to make; name items, or give --text or"),
        (("compare", "eon", "fon", "--no-pictures", "--spp", "9"), 2, "--spp is for pictures, and"),
        (("check", "eon", "--time-limit", "20"), 1, "--map and the like belong to a FILE of code"),
        (("plot", "eon", "--phi", "0,90"), 1, "the polar plot takes one plane phi; the cartesian"),
        (("plot", "eon", "--log"), 1, "the polar plot has no log; it takes theta_o, phi, cosine"),
        (("plot", "eon", "-k", "fresnel"), 1, "eon has no Fresnel terms of its own to plot;"),
        (("plot", "eon", "-k", "error"), 1, "the error plot needs at least two models"),
        (("plot", "qon:sigma=pi/5e9x"), 1, "qon: sigma=pi/5e9x is not a number; allowed is 0 to"),
        (("plot", "eon", "--vary", "roughness"), 1, "--vary roughness is not NAME=A,B,..., such"),
        (("plot", "eon:roughness=1", "--vary", "roughness=0"), 1, "roughness is given twice."),
        (("plot", "eon", "-k", "pie"), 2, "no plot 'pie'; known are polar, cartesian, surface"),
        (("plot", "eon", "-k", "albdo"), 2, "no plot 'albdo'; did you mean 'albedo'? Known are"),
        (("plot", "eon", "-k", "D"), 2, "no plot 'D'; did you mean 'distribution'? Known are"),
        (("convert", "2", "--from", "alpha", "--to", "r"), 1, "alpha 2 is out of range; allowed"),
        (("convert", "2", "--from", "gloss", "--to", "r"), 1, "known are perceptual, alpha,"),
    ],
)
def test_errors_are_one_line_and_say_what_is_allowed(
    arguments, code, message, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    result = run(*arguments)
    assert result.exit_code == code
    assert result.stdout == ""
    assert result.stderr.startswith("gonio: error: ")
    assert result.stderr.count("\n") == 1
    assert message in result.stderr
    assert list(tmp_path.iterdir()) == []


def commands(group: click.Group) -> Iterator[click.Command]:
    """All commands, also those of groups."""
    for name in group.list_commands(click.Context(group)):
        command = group.get_command(click.Context(group), name)
        if isinstance(command, click.Group):
            yield from commands(command)
        elif command is not None:
            yield command


def test_no_option_takes_a_number_that_is_not_finite():
    taken = 0
    for command in commands(cli.main):
        for option in command.params:
            for given in ("0.5", "1", "0.5,1", "1,0.5"):
                try:
                    value = option.type.convert(given, option, None)
                except click.BadParameter:
                    continue
                numbers = value if isinstance(value, tuple) else (value,)
                if not any(isinstance(number, float) for number in numbers):
                    continue
                taken += 1
                for word in ("nan", "inf", "-inf", "1e999"):
                    with pytest.raises(click.BadParameter):
                        option.type.convert(given.replace(given[0], word, 1), option, None)
    assert taken > 20


@pytest.mark.parametrize(
    ("said", "meant"),
    [
        ("metal", "msl"),
        ("cuda c++", "cuda"),
        ("WebGL 2", "essl"),
        ("webgpu", "wgsl"),
        ("c++17", "cpp"),
        ("SPIR-V", "glsl"),
        ("DX12", "hlsl"),
        ("Direct3D 11", "hlsl"),
        ("OpenGL", "glsl"),
        ("MaterialX", "mtlx"),
        ("Open Shading Language", "osl"),
        ("slnag", "slang"),
    ],
)
def test_what_people_call_a_language_is_told_its_name_here(said, meant):
    result = run("export", "eon", "--to", said)
    assert f"no language {said!r}; did you mean {meant!r}? there are glsl, essl" in result.stderr


@pytest.mark.parametrize("place", [0, 2])
def test_debug_shows_the_traceback_wherever_it_stands(place):
    arguments = ["show", "eonn"]
    arguments.insert(place, "--debug")
    assert isinstance(run(*arguments).exception, gonio.ModelError)


def test_an_unforeseen_error_is_one_line_too(monkeypatch):
    monkeypatch.setattr(doctor, "diagnose", lambda: {}["missing"])
    result = run("doctor")
    assert result.exit_code == 1
    assert result.stderr == "gonio: error: KeyError: 'missing' ('gonio --debug ...' shows where)\n"


def test_an_interrupt_ends_with_130(monkeypatch):
    def interrupt():
        raise KeyboardInterrupt

    monkeypatch.setattr(doctor, "diagnose", interrupt)
    result = run("doctor")
    assert result.exit_code == 130
    assert result.stderr.strip() == "gonio: interrupted"


def test_every_command_teaches_by_example():
    assert "gonio plot" in run().stdout
    for name, command in cli.main.commands.items():
        text = run(name, "--help").stdout
        assert "Example" in text
        assert f"  gonio {name} " in text or name in {"list", "doctor"}
        assert command.help


def test_the_version_is_printed():
    assert run("--version").stdout == f"gonio {gonio.__version__}\n"


# --------------------------------------------------------------------------- as a real process


def test_the_installed_program_lists_without_loading_anything_heavy():
    code = (
        "import sys; from gonio.cli import main\n"
        "try: main(['list'])\n"
        "except SystemExit as end: assert end.code == 0\n"
        "heavy = {'matplotlib', 'mitsuba', 'torch', 'jax', 'trimesh', 'PIL'} & set(sys.modules)\n"
        "assert not heavy, heavy"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "lambert" in done.stdout


def test_a_closed_pipe_is_quiet():
    reader, writer = os.pipe()
    os.close(reader)
    done = subprocess.run(
        [PROGRAM, "list"], stdout=writer, stderr=subprocess.PIPE, text=True, check=False
    )
    os.close(writer)
    assert done.returncode == 1
    assert done.stderr == ""


def test_a_terminal_without_unicode_gets_question_marks():
    env = {**os.environ, "PYTHONIOENCODING": "latin-1", "PYTHONUTF8": "0"}
    done = subprocess.run(
        [PROGRAM, "show", "eon"], env=env, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0
    assert "Oren?Nayar" in done.stdout


def test_errors_of_the_installed_program_go_to_stderr():
    done = subprocess.run([PROGRAM, "show", "eonn"], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr == (
        "gonio: error: no model, material or file 'eonn'; did you mean the model 'eon'? "
        "'gonio list' and 'gonio list --materials' show all.\n"
    )


@pytest.mark.parametrize(
    ("text", "sigma"),
    [
        ("pi/2", math.pi / 2),
        ("1.5708", math.pi / 2),
        ("1.571", math.pi / 2),
        ("pi/4", math.pi / 4),
        ("3pi/8", 3 * math.pi / 8),
        ("0.25*pi", math.pi / 4),
        ("0.785", 0.785),
        ("1.57", 1.57),
    ],
)
def test_angles_may_be_written_as_people_write_them(text, sigma):
    assert load(f"qon:sigma={text}").sigma == sigma


@pytest.mark.parametrize(
    "text", ["qon:sigma=1.6", "qon:sigma=pi", "eon:roughness=1.0001", "qon:sigma=pi/0"]
)
def test_what_is_no_rounding_of_a_range_s_end_is_refused(text):
    with pytest.raises(gonio.ModelError, match="allowed is 0 to"):
        load(text)


def test_the_module_runs_as_the_command() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "gonio", "--version"], capture_output=True, text=True, check=False
    )
    assert done.stdout == f"gonio {gonio.__version__}\n", done.stderr
