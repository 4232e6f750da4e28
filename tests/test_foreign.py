"""Code that others wrote: read, run, judged, compared and named; mistakes that were planted are found."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import gonio
from gonio import foreign
from gonio.check.report import FAIL, UNSURE, Report
from gonio.cli.program import main
from gonio.export.prove import tools
from gonio.foreign import registry, roles, source, terms
from gonio.foreign.expressions import parse
from gonio.foreign.function import parse_map, parse_ranges, probe
from gonio.foreign.source import ForeignError

GOLDEN = Path(__file__).parent / "golden"

needs_gxx = pytest.mark.skipif(tools.locate("g++") is None, reason="needs g++")
needs_gl = pytest.mark.skipif(tools.locate("moderngl") is None, reason="needs moderngl")

# Karis's GGX as engines have it: Cook-Torrance with GGX (Walter et al. 2007, Eq. 33), Smith's height-
# correlated masking (Heitz 2014, Eq. 99) and Schlick's Fresnel term. ue4 of gonio is another.
MICROFACET = """
const float PI = 3.14159265358979;
vec3 toLinear(vec3 c) {{ return {colour}; }}
float D(float NoH, float a) {{
    float a2 = a * a;
    float f = NoH * NoH * (a2 - 1.0) + 1.0;
    return a2 / (PI * f * f);
}}
float smith(float x, float a) {{ return sqrt(x * x * (1.0 - a * a) + a * a); }}
vec3 ggx(vec3 L, vec3 V, vec3 N, vec3 f0, float roughness) {{
    vec3 H = {half};
    float NoL = clamp(dot(N, L), 0.0, 1.0);
    float NoV = clamp(dot(N, V), 0.0, 1.0);
    float NoH = clamp(dot(N, H), 0.0, 1.0);
    float VoH = clamp(dot(V, H), 0.0, 1.0);
    float a = {alpha};
    float G = {masking};
    vec3 c = toLinear(f0);
    vec3 F = c + (1.0 - c) * pow(1.0 - {fresnel}, 5.0);
    return D(NoH, a) * G * F{below};
}}
"""
RIGHT = {
    "colour": "c",
    "half": "normalize(L + V)",
    "alpha": "roughness * roughness",
    "masking": "2.0 * NoL * NoV / (NoV * smith(NoL, a) + NoL * smith(NoV, a))",
    "fresnel": "VoH",
    "below": " / max(4.0 * NoL * NoV, 1e-7)",
}

# What is changed, and a word of the sentence that has to name it.
PLANTED = {
    "alpha for alpha^2": ({"alpha": "roughness"}, "GGX, alpha = roughness;"),
    "roughness squared twice": ({"alpha": "pow(roughness, 4.0)"}, "alpha = roughness^4"),
    "4 for 4 cos cos": ({"below": " / 4.0"}, "times 1 / 4"),
    "pi twice": ({"below": " / max(4.0 * PI * NoL * NoV, 1e-7)"}, "times 1 / (4 pi)"),
    "a cosine is missing below": ({"below": " / max(4.0 * NoV, 1e-7)"}, "1 / (N.V)"),
    "Schlick with N.V": ({"fresnel": "NoV"}, "Fresnel of N.V instead of V.H"),
    "masking on one side": (
        {"masking": "2.0 * NoV / (NoV + smith(NoV, a))"},
        "on the viewer's side only",
    ),
    "half vector is not normalised": ({"half": "L + V"}, "half vector not normalised"),
    "sRGB taken as linear": ({"colour": "pow(c, vec3(2.2))"}, "f0^2.2"),
    "k is not halved": (
        {"masking": "NoL * NoV / ((NoL * (1.0 - a) + a) * (NoV * (1.0 - a) + a))"},
        "Schlick's masking, k = alpha,",
    ),
}


def write(folder: Path, name: str, text: str) -> str:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return str(path)


def microfacet(folder: Path, **changed: str) -> str:
    return write(folder, "ggx.glsl", MICROFACET.format(**(RIGHT | changed))) + "#ggx"


def verdicts(reports: list[Report]) -> dict[str, str]:
    return {f.what: f.verdict for r in reports for f in r.findings}


# --- reading -------------------------------------------------------------------------------------


def test_functions_are_read_in_every_language_with_their_scopes(tmp_path: Path) -> None:
    for ending in ("glsl", "essl", "hlsl", "wgsl", "metal", "h"):
        found = source.read(GOLDEN / f"eon.{ending}").find("eon_eval")
        assert [a.name for a in found.arguments] == ["params", "wi", "wo"], ending
    assert source.read(GOLDEN / "eon.slang").find("Eon.eval").owner == "Eon"
    assert source.read(GOLDEN / "eon.h").find("gonio_eon::eon_eval").scope == ("gonio_eon",)


def test_comments_strings_and_macros_hide_nothing_and_show_nothing(tmp_path: Path) -> None:
    text = (
        "/* float fake(vec3 L) { } */\n#define BODY(x) float hidden(float x) { return x; }\n"
        "// float other(float a) {\nfloat real_one(const in vec3 L, inout float x,\n"
        "  highp float rough) { return 1.0; }\nfloat declared(float a);\n"
    )
    code = source.read(write(tmp_path, "a.glsl", text))
    assert [(f.name, f.line) for f in code.functions] == [("real_one", 4)]
    assert [(a.name, a.type, a.written) for a in code.functions[0].arguments] == [
        ("L", "vec3", False),
        ("x", "float", True),
        ("rough", "float", False),
    ]


def test_arguments_are_known_by_many_names(tmp_path: Path) -> None:
    names = {
        "vec3 lightDir, vec3 viewDir, vec3 u_normal": ["wi", "wo", "normal"],
        "float NdotL, float n_dot_v, float NoH, float LdotH": ["cos_i", "cos_o", "cos_h", "cos_d"],
        "vec3 L, vec3 V, vec3 H, vec3 X, vec3 Y": ["wi", "wo", "half", "tangent", "bitangent"],
    }
    for arguments, expected in names.items():
        code = source.read(write(tmp_path, "a.glsl", f"float f({arguments}) {{ return 1.0; }}"))
        found = roles.match(code, code.functions[0], {}, {}, {})
        assert [e.text for _, e in found.leaves] == expected


def test_ranges_come_from_brdf_files_the_registry_and_the_user(tmp_path: Path) -> None:
    text = (
        "analytic\n::begin parameters\nfloat n 1 1000 100\nbool on 1\ncolor tint .8 .2 .1\n"
        "::end parameters\n::begin shader\nvec3 BRDF(vec3 L, vec3 V, vec3 N, vec3 X, vec3 Y)\n"
        "{ return on ? tint * n : vec3(0.0); }\n::end shader\n"
    )
    code = source.read(write(tmp_path, "a.brdf", text))
    found = roles.match(code, code.find(None), {}, {}, {}).parameters
    assert (found["n"].low, found["n"].high, found["n"].default) == (1, 1000, 100)
    assert found["tint"].default == (0.8, 0.2, 0.1)
    assert "on" not in found
    assert parse_ranges(["roughness=0.01..1"]) == {"roughness": (0.01, 1.0)}


def test_maps_hold_formulas() -> None:
    assert parse_map(["L=wi V=-wo a=roughness * 2, c=(0.1, 0.2, 0.3)"]) == {
        "L": "wi",
        "V": "-wo",
        "a": "roughness * 2",
        "c": "(0.1, 0.2, 0.3)",
    }
    wi = np.array([[0.0, 0.6, 0.8]])
    assert parse("2*dot(wi, wi)^2 + wi.z").value({"wi": wi})[0] == pytest.approx(2.8)


@pytest.mark.parametrize(
    "text", ["__import__('os')", "wi[0]", "a if b else c", "(lambda: 1)()", "1 +"]
)
def test_formulas_are_no_python(text: str) -> None:
    with pytest.raises(ForeignError, match="formula"):
        parse(text)


@pytest.mark.parametrize(
    ("text", "function", "words"),
    [
        ("float f(vec3 L, vec3 V) { return 1.0; }", "g", "defines no function 'g'"),
        ("float f(vec3 L, vec3 q_dir) { return 1.0; }", "f", "cannot tell what q_dir"),
        ("float f(vec3 L, vec3 albedo) { return 1.0; }", "f", "no argument for the viewer"),
        ("float f(vec3 L, vec3 V, mat3 m) { return 1.0; }", "f", "m is a mat3"),
        ("mat3 f(vec3 L, vec3 V) { return mat3(1.0); }", "f", "gives back mat3"),
    ],
)
def test_what_cannot_be_called_is_one_sentence(
    tmp_path: Path, text: str, function: str, words: str
) -> None:
    with pytest.raises(ForeignError, match=words) as error:
        foreign.load(write(tmp_path, "a.glsl", text), function=function)
    assert "\n" not in str(error.value)


# --- running -------------------------------------------------------------------------------------

CASES = [
    ("glsl", "eon_eval", "moderngl"),
    ("essl", "eon_eval", "moderngl"),
    ("wgsl", "eon_eval", "wgpu"),
    ("hlsl", "eon_eval", "slangc"),
    ("slang", "Eon.eval", "slangc"),
    ("metal", "eon_eval", "g++"),
    ("h", "gonio_eon::eon_eval", "g++"),
]


@pytest.mark.parametrize(("ending", "function", "tool"), CASES)
def test_gonios_exports_read_back_are_the_model(ending: str, function: str, tool: str) -> None:
    if tools.locate(tool) is None:
        pytest.skip(f"needs {tool}")
    code = foreign.load(str(GOLDEN / f"eon.{ending}"), function=function)
    assert str(code.returns) == "f"
    wi, wo = probe(200)
    rough = np.linspace(0, 1, 200)
    expected = gonio.model("eon", rho=(0.9, 0.5, 0.1), roughness=rough).eval(wi, wo)
    found = code.brdf(wi, wo, {"rho": (0.9, 0.5, 0.1), "roughness": rough})
    # Mesa's acos, which the exports do not use, would err by 1e-4
    np.testing.assert_allclose(found, expected, rtol=3e-6)


@needs_gxx
def test_crashes_endless_loops_and_errors_are_one_sentence_each(tmp_path: Path) -> None:
    head = "struct V { float x, y, z; };\n"
    endless = "float f(V wi, V wo) { volatile int k = 1; while (k) { } return 1; }"
    loop = write(tmp_path, "loop.cpp", head + endless)
    with pytest.raises(ForeignError, match=r"did not come back within 0.5 s .* endless loop"):
        foreign.load(loop, function="f", seconds=0.5)
    crash = write(
        tmp_path, "crash.cpp", head + "float f(V wi, V wo) { return *(volatile float*)8; }"
    )
    with pytest.raises(ForeignError, match=r"crashed \(a segmentation fault\)"):
        foreign.load(crash, function="f")
    wrong = write(tmp_path, "wrong.cpp", head + "float f(V wi, V wo) {\n\n  return wi.w;\n}")
    with pytest.raises(ForeignError, match=r"wrong\.cpp:4: .*no member named .w.*return wi\.w;"):
        foreign.load(wrong, function="f")
    greedy = (
        "#include <vector>\nfloat f(V wi, V wo) {\n"
        "  std::vector<char> x(8ull << 30, 1); return x[7]; }"
    )
    with pytest.raises(ForeignError, match=r"memory|crashed"):
        foreign.load(write(tmp_path, "greedy.cpp", head + greedy), function="f")
    nosy = (
        "#include <cstdio>\nfloat f(V wi, V wo) {\n"
        '  FILE* s = fopen("/etc/hostname", "r"); return s ? 1 : 2; }'
    )
    code = foreign.load(write(tmp_path, "nosy.cpp", head + nosy), function="f", returns="f")
    assert code.raw(*probe(4))[0, 0] == 2


@needs_gl
def test_glsl_errors_stand_at_the_users_line_in_included_files_too(tmp_path: Path) -> None:
    write(tmp_path, "inner.glsl", "float twice(float x) {\n  return 2.0 * y;\n}\n")
    text = '#version 330\n#include "inner.glsl"\nfloat f(vec3 L, vec3 V) { return twice(L.z); }\n'
    with pytest.raises(ForeignError, match=r"inner.glsl:2: .*y.* \|  return 2.0 \* y;"):
        foreign.load(write(tmp_path, "outer.glsl", text), function="f")


@needs_gl
def test_uniforms_macros_and_main_of_a_whole_shader(tmp_path: Path) -> None:
    text = (
        "#version 330\nuniform vec3 baseColor;\nuniform float unused;\nin vec3 vNormal;\n"
        "out vec4 fragColor;\n"
        "float diffuse(vec3 lightDir, vec3 viewDir) { return SCALE * baseColor.r / 3.14159265; }\n"
        "void main() { fragColor = texture(nothing, vNormal.xy); }\n"
    )
    path = write(tmp_path, "whole.frag", text)
    code = foreign.load(path, function="diffuse", defines=["SCALE=0.5"], returns="f")
    assert list(code.parameters) == ["baseColor"]
    wi, wo = probe(3)
    assert code.brdf(wi, wo, {"baseColor": (0.8, 0, 0)})[0, 0] == pytest.approx(0.4 / np.pi)
    fixed = foreign.load(
        path, function="diffuse", defines=["SCALE=1"], uniforms=["baseColor=(0.2,0,0)"], returns="f"
    )
    assert not fixed.parameters
    assert fixed.brdf(wi, wo)[0, 0] == pytest.approx(0.2 / np.pi)


@needs_gl
@pytest.mark.parametrize(
    ("value", "returns"),
    [
        ("rho / PI", "f"),
        ("rho / PI * L.z", "f cos(theta_i)"),
        ("rho", "pi f"),
        ("rho * L.z", "pi f cos(theta_i)"),
    ],
)
def test_what_is_returned_is_measured(tmp_path: Path, value: str, returns: str) -> None:
    text = f"const float PI = 3.14159265;\nvec3 f(vec3 L, vec3 V, vec3 rho) {{ return {value}; }}"
    code = foreign.load(write(tmp_path, "a.glsl", text), function="f")
    assert str(code.returns) == returns
    assert code.brdf(*probe(4), {"rho": (0.5, 0.5, 0.5)})[:, 0] == pytest.approx(0.5 / np.pi)


# --- verdicts ------------------------------------------------------------------------------------


@needs_gl
def test_a_right_microfacet_shader_has_nothing_to_complain_about(tmp_path: Path) -> None:
    code = foreign.load(microfacet(tmp_path), ranges=["roughness=0.1..1"])
    found = foreign.check(code, only=["reciprocity", "finite", "isotropy", "frame"])
    assert FAIL not in verdicts(found).values(), [str(f) for r in found for f in r.findings]


@needs_gl
def test_broken_laws_are_found(tmp_path: Path) -> None:
    def failing(
        body: str, *only: str, arguments: str = "vec3 L, vec3 V, vec3 N, vec3 rho"
    ) -> set[str]:
        text = f"vec3 f({arguments}) {{ {body} }}"
        code = foreign.load(write(tmp_path, "a.glsl", text), function="f", returns="f")
        return {w for w, v in verdicts(foreign.check(code, only=only)).items() if v == FAIL}

    assert failing("return rho * dot(N, V);", "reciprocity") == {"relative difference"}
    assert failing("return rho / max(dot(N, L) - 0.5, 0.0);", "finite") == {"not finite"}
    assert failing("return rho * (dot(N, L) - 0.2);", "finite") == {"below zero, times pi"}
    assert failing("return rho * (1.2 + L.x * V.x);", "isotropy") == {"change by a turn"}
    assert failing("return rho * L.z * V.z;", "frame") == {"change by another frame"}
    assert failing("return rho * 0.5;", "energy") == {"largest albedo"}
    assert failing("return rho * 0.3;", "energy", "reciprocity", "finite", "isotropy") == set()


@needs_gl
def test_black_is_not_judged(tmp_path: Path) -> None:
    path = write(tmp_path, "a.glsl", "float f(vec3 L, vec3 V) { return 0.0; }")
    found = foreign.check(foreign.load(path, function="f", returns="f"))
    assert [r.check for r in found] == ["scope"]
    assert UNSURE in verdicts(found).values()


# --- comparison and identity ---------------------------------------------------------------------


@needs_gl
@pytest.mark.parametrize("name", PLANTED)
def test_planted_mistakes_are_named(tmp_path: Path, name: str) -> None:
    changed, words = PLANTED[name]
    code = foreign.load(microfacet(tmp_path, **changed), returns="f", ranges=["roughness=0.1..1"])
    best = terms.identify(code)[0]
    assert best.exact, (str(best), best.misfit)
    assert words in str(best)


@needs_gl
def test_a_right_shader_is_named_without_anything_unusual(tmp_path: Path) -> None:
    code = foreign.load(microfacet(tmp_path), ranges=["roughness=0.1..1"])
    best = terms.identify(code)[0]
    assert best.exact
    assert best.odd == ()
    assert str(best) == (
        "GGX, alpha = roughness^2; Smith's masking of GGX, height-correlated; "
        "Schlick's Fresnel of V.H, F0 = f0; 1 / (N.L N.V); times 1 / 4"
    )


@needs_gl
def test_factors_and_cut_angles_are_found_by_comparison_alone(tmp_path: Path) -> None:
    path = str(GOLDEN / "eon.glsl")
    text = Path(path).read_text(encoding="utf-8")
    wrapped = "vec3 wrong(Eon params, vec3 wi, vec3 wo) { return 3.14159265 * eon_eval(params, wi, wo); }\n"
    eon = gonio.model("eon")
    right = foreign.compare(foreign.load(path, function="eon_eval"), eon)
    assert right.largest < 3e-6
    code = foreign.load(write(tmp_path, "a.glsl", text + wrapped), function="wrong", returns="f")
    found = foreign.compare(code, eon)
    assert found.largest == pytest.approx(1 - 1 / np.pi, rel=1e-3)
    assert "times pi everywhere" in found.hint
    grazing = (
        "vec3 wrong(Eon params, vec3 wi, vec3 wo) { return eon_eval(params, wi, wo) * "
        "(min(wi.z, wo.z) < 0.08 ? 2.0 : 1.0); }\n"
    )
    code = foreign.load(write(tmp_path, "b.glsl", text + grazing), function="wrong", returns="f")
    found = foreign.compare(code, eon)
    assert [b[2] < 1e-5 for b in found.bands] == [True, True, True, False, False]
    assert "up to 85 degrees" in found.lines()[0]


@needs_gl
def test_the_registry_finds_model_options_and_scales(tmp_path: Path) -> None:
    text = (GOLDEN / "eon.glsl").read_text(encoding="utf-8") + (
        "vec3 mine(vec3 L, vec3 V, vec3 colour, float gloss) {\n"
        "  Eon params; params.rho = colour; params.roughness = (1.0 - gloss);\n"
        "  return 3.14159265 * eon_eval(params, L, V) * L.z;\n}\n"
    )
    code = foreign.load(write(tmp_path, "a.glsl", text), function="mine", ranges=["gloss=0..1"])
    assert code.returns.cosine == 1
    found = registry.identify(code, ["lambert", "eon", "oren_nayar"])
    assert found[0].model.name == "eon"
    assert found[0].exact
    assert found[0].relations == {"rho": "colour", "roughness": "1 - gloss"}
    assert found[1].misfit > 0.01


# --- the command line ----------------------------------------------------------------------------


@needs_gl
def test_commands_judge_and_compare_code(tmp_path: Path) -> None:
    runner = CliRunner()
    path = microfacet(tmp_path, below=" / 4.0")
    arguments = [
        "check",
        path,
        "--range",
        "roughness=0.2..1",
        "--only",
        "reciprocity,frame",
        "--json",
    ]
    done = runner.invoke(main, arguments)
    assert done.exit_code == 0, done.output
    assert {r["check"] for r in json.loads(done.output)} == {"scope", "reciprocity", "frame"}
    done = runner.invoke(
        main, ["compare", f"{GOLDEN}/eon.glsl#eon_eval", "eon", "--tolerance", "1e-5"]
    )
    assert (done.exit_code, "is eon" in done.output) == (0, True), done.output
    done = runner.invoke(
        main, ["compare", f"{GOLDEN}/eon.glsl#eon_eval", "fon", "--tolerance", "1e-5"]
    )
    assert done.exit_code == 1
    assert "is not fon" in done.output


def test_options_of_code_are_not_ignored_in_silence() -> None:
    runner = CliRunner()
    for arguments in (["check", "eon", "--map", "L=wi"], ["compare", "eon", "fon", "--identify"]):
        done = runner.invoke(main, arguments)
        assert done.exit_code != 0
