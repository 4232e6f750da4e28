"""Code that others wrote: read, run, judged, compared and named; mistakes that were planted are found."""

from __future__ import annotations

import importlib.util
import json
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from PIL import Image
from support import faulty
from support.tolerances import SINGLE, SINGLE_LONG

import gonio
from gonio import fit, foreign
from gonio.check.report import FAIL, UNSURE, Report
from gonio.cli.program import main
from gonio.export.prove import tools
from gonio.foreign import registry, roles, source, terms, textures
from gonio.foreign.expressions import parse
from gonio.foreign.function import parse_map, parse_ranges, parse_uniforms, probe
from gonio.foreign.source import ForeignError
from gonio.measured import is_data_file

# The rule by which foreign code gets its albedos has some thousand directions.
COARSE = 1e-3

# Fits whose derivatives are differences stop this near to what made the data.
FOUND = 1e-4


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


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ("vec3 eyeDir, vec3 lampDir, vec3 n", {"eyeDir": "wo", "lampDir": "wi", "n": "normal"}),
        ("vec3 V, vec3 emitterDir", {"V": "wo", "emitterDir": "wi"}),
        ("vec3 V, vec3 L, vec3 lightColor", {"V": "wo", "L": "wi", "lightColor": "(1, 1, 1)"}),
        ("vec3 I, vec3 L, vec3 N", {"I": "-wo", "L": "wi", "N": "normal"}),
        ("vec3 P, vec3 lightPos, vec3 camPos", {"P": "(0, 0, 0)", "lightPos": "wi", "camPos": "wo"}),
        ("vec3 l, vec3 n, vec3 kd", {"l": "wi", "n": "normal", "kd": "kd"}),
        ("vec3 L, vec3 V, float nu, float nv", {"L": "wi", "V": "wo", "nu": "nu", "nv": "nv"}),
        ("float nl, float nv, vec2 texCoord", {"nl": "cos_i", "nv": "cos_o", "texCoord": "(0.5, 0.5)"}),
    ],
)  # fmt: skip
def test_what_names_leave_open_is_told_by_the_other_arguments(
    tmp_path: Path, arguments: str, expected: dict[str, str]
) -> None:
    text = f"float f({arguments}) {{ return 1.0; }}"
    found = source.read(write(tmp_path, "a.glsl", text))
    matched = roles.match(found, found.find("f"), {}, {}, {})
    assert {leaf.place: e.text for leaf, e in matched.leaves} == expected
    guessed = {"emitterDir", "lightColor", "I", "P", "kd"} & set(expected)
    assert bool(guessed) == any(
        "otherwise" in n or "if not" in n or "no argument" in n for n in matched.notes
    )


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


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a=nan", "--uniform a=nan is no number; give a finite one"),
        ("a=-inf", "--uniform a=-inf is no number"),
        ("a=1/0", "--uniform a=1/0 is not a finite number"),
        ("a=1e999", "--uniform a=1e999 is not a finite number"),
        ("a=(1, 0, 1e999)", "not a finite number, or some as in"),
        ("a=true", '--map "a=true" sets it by a formula'),
        ("a", "--uniform 'a' is not NAME=NUMBER, such as"),
    ],
)
def test_a_uniform_is_a_finite_number(text: str, message: str) -> None:
    with pytest.raises(ForeignError, match=re.escape(message)):
        parse_uniforms([text])


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
        ("float f(vec3 L, vec3 p_dir, vec3 q_dir) { return 1.0; }", "f", "cannot tell what p_dir"),
        ("float f(vec3 L, vec3 other) { return 1.0; }", "f", "no argument for the viewer"),
        (
            "float f(vec3 L) { return L.z; } float f(vec3 L, vec3 V) { return L.z; }",
            "f",
            "say which, as",
        ),
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
    ("osl", "eon_eval", "g++"),
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


# Models that others are at some setting of their parameters or options: either name is right.
TWINS = {
    "qon_footnote": {"qon_footnote", "qon"},
    "lambert": {"lambert", "hapke", "minnaert"},
    "triace_oren_nayar": {"triace_oren_nayar", "qon", "oren_nayar"},
}


def exported(name: str, ending: str) -> str:
    """The function in a golden file that evaluates a model."""
    if ending == "slang":
        return "".join(word.capitalize() for word in name.split("_")) + ".eval"
    return f"gonio_{name}::{name}_eval" if ending == "h" else f"{name}_eval"


@pytest.mark.parametrize("name", sorted(gonio.models()))
def test_names_of_models_parameters_are_no_directions(name: str) -> None:
    # normalization of sgd, and p, which is a point elsewhere
    model = gonio.model(name)
    own = {registry.as_code(path) for path, _, _ in model.parameters()}
    for ending in ("glsl", "slang"):
        code = source.read(GOLDEN / f"{name}.{ending}")
        found = roles.match(code, code.find(exported(name, ending)), {}, {}, {})
        assert set(found.parameters) <= own
        taken = {leaf.place for leaf, e in found.leaves if e.alone not in found.parameters}
        assert all(place in ("wi", "wo") or "." not in place for place in taken), taken


@pytest.mark.parametrize("name", sorted(gonio.models()))
def test_every_export_read_back_is_named_with_its_parameters(
    name: str, request: pytest.FixtureRequest
) -> None:
    if not request.config.getoption("--long"):
        pytest.skip("every model in every language: --long")
    for ending, _, tool in CASES:
        if tools.locate(tool) is None:
            continue
        function = exported(name, ending)
        code = foreign.load(f"{GOLDEN}/{name}.{ending}", function=function, returns="f")
        found = foreign.identify(code)
        assert found.exact, (ending, found.lines())
        if found.models and found.models[0].exact:
            best = found.models[0]
            assert best.model.name in TWINS.get(name, {name}), (ending, found.lines())
            assert not any("a function of" in text for text in best.relations.values())


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
    leaves = write(
        tmp_path, "leaves.cpp", "#include <cstdlib>\n" + head + "float f(V wi, V wo) { exit(0); }"
    )
    with pytest.raises(ForeignError, match=r"ended its process by itself \(exit code 0\)"):
        foreign.load(leaves, function="f")
    throws = '#include <stdexcept>\nfloat f(V wi, V wo) { throw std::runtime_error("too bad"); }'
    with pytest.raises(ForeignError, match=r"an exception that nobody catches: too bad"):
        foreign.load(write(tmp_path, "throws.cpp", head + throws), function="f")
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


LOOPS = """
float endless(vec3 L, vec3 V, float r) {
    float x = 0.0;
    while (true) { x += r; if (x < 0.0) break; }
    return x;
}
float body(vec3 L, vec3 V, float r) { float x = 0.0; do x += r; while (x >= 0.0); return x; }
float nested(vec3 L, vec3 V, float r) {
    float x = 0.0;
    for (int i = 0; i < 300; ++i) for (int k = 0; ; ) { x += r; if (++k == 300) break; }
    return x;
}
float fine(vec3 L, vec3 V, float r) {
    float x = 0.0;
    int k = 0;
    for (int i = 0, n = 1000; i < n; i += 2) { if (i == 500) continue; x += 1.0; }
    while (k < 100) k++;
    do { k--; x += 1.0; } while (k > 0);
    return x;
}
"""
WGSL_LOOPS = """
fn endless(L: vec3f, V: vec3f, r: f32) -> f32 {
    var x = 0.0;
    loop { x += r; if x < 0.0 { break; } continuing { x += 1.0; } }
    return x;
}
fn fine(L: vec3f, V: vec3f, r: f32) -> f32 {
    var x = 0.0;
    for (var i = 0; i < 499; i++) { x += 1.0; }
    while x < 500.0 { x += 1.0; }
    loop { x += 1.0; if x >= 599.0 { break; } }
    return x;
}
"""


@pytest.mark.parametrize(("ending", "tool"), [("glsl", "moderngl"), ("wgsl", "wgpu")])
def test_loops_that_a_driver_ends_in_silence_are_one_sentence(
    tmp_path: Path, ending: str, tool: str
) -> None:
    # Mesa's drivers on the processor go on after 65535 turns of all loops with what there was
    if tools.locate(tool) is None:
        pytest.skip(f"needs {tool}")
    path = write(tmp_path, f"a.{ending}", LOOPS if ending == "glsl" else WGSL_LOOPS)
    fine = foreign.load(path, function="fine", returns="f")
    assert fine.raw(*probe(4))[0, 0] == 599
    for name in ("endless", "body", "nested") if ending == "glsl" else ("endless",):
        with pytest.raises(ForeignError, match=r"turned more than|did not come back"):
            foreign.load(path, function=name, returns="f", seconds=5)


@needs_gl
def test_glsl_errors_stand_at_the_users_line_in_included_files_too(tmp_path: Path) -> None:
    write(tmp_path, "inner.glsl", "float twice(float x) {\n  return 2.0 * y;\n}\n")
    text = '#version 330\n#include "inner.glsl"\nfloat f(vec3 L, vec3 V) { return twice(L.z); }\n'
    with pytest.raises(ForeignError, match=r"inner.glsl:2: .*y.* \|  return 2.0 \* y;"):
        foreign.load(write(tmp_path, "outer.glsl", text), function="f")


@pytest.mark.parametrize("ending", ["hlsl", "wgsl", "metal", "osl", "cu", "brdf"])
def test_mistakes_stand_at_the_users_line_in_every_language(tmp_path: Path, ending: str) -> None:
    language = next(k for k in faulty.LANGUAGES if k.ending == ending)
    if tools.locate(language.tool) is None:
        pytest.skip(f"needs {language.tool}")
    text = faulty.shader(language, alpha="unheard_of")
    line = 1 + text.partition("unheard_of")[0].count("\n")
    path = write(tmp_path, f"a.{ending}", text)
    with pytest.raises(ForeignError, match=rf"a\.{ending}:{line}: .*unheard_of") as error:
        foreign.load(path, function=language.name)
    assert "\n" not in str(error.value)


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
def test_textures_are_pictures_or_values_and_conditions_decide_what_is_read(tmp_path: Path) -> None:
    text = (
        "#ifdef OTHER\nstruct S { mat3 nothing; };\nfloat f(S s) { return 0.0; }\n#else\n"
        "struct S { float rho; };\nuniform sampler2D lut;\nuniform sampler2D mask;\n"
        "uniform float gain = 0.25;\n"
        "vec3 f(vec3 L, vec3 V, S s) { return gain * s.rho * texture(lut, vec2(0.25, 0.75)).rgb\n"
        "    + texture(mask, vec2(0.5)).rgb; }\n#endif\n"
    )
    path = write(tmp_path, "a.glsl", text)
    picture = np.zeros((2, 2, 3), np.uint8)
    picture[0, 0] = (255, 51, 0)  # the top left texel, whose v is the larger
    Image.fromarray(picture).save(tmp_path / "lut.png")
    given = [f"lut={tmp_path}/lut.png", "mask=0.5/0.25/0.125"]
    code = foreign.load(path, function="f", textures=given, returns="f")
    found = code.brdf(*probe(3), {"s.rho": 0.5, "rho": 0.5})[0]
    assert code.parameters["gain"].default == 0.25
    assert found == pytest.approx([0.125 + 0.5, 0.125 * 0.2 + 0.25, 0.125], abs=SINGLE_LONG)
    white = foreign.load(path, function="f", returns="f")
    assert white.brdf(*probe(3), {"s.rho": 0.5, "gain": 0.5})[0] == pytest.approx([1.25] * 3)
    assert white.textures == {"lut": "white", "mask": "white"}
    kinds = (
        "_NormalMap",
        "u_EmissiveSampler",
        "prefilteredEnv",
        "_MetallicGlossMap",
        "baseColorTexture",
    )
    assert [textures.assumed(name)[0] for name in kinds] == ["0.5/0.5/1", "0", "0", "1", "1"]
    for wrong, words in ((["none=1"], "no texture 'none'"), (["lut=a/b"], "--texture a/b")):
        with pytest.raises(ForeignError, match=words):
            foreign.load(path, function="f", textures=wrong)


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


@needs_gl
def test_what_half_precision_makes_of_a_formula_is_told_apart(tmp_path: Path) -> None:
    language = next(k for k in faulty.LANGUAGES if k.ending == "essl")
    text = faulty.shader(language).replace("precision highp", "precision mediump")
    path = write(tmp_path, "a.essl", text)
    code = foreign.load(path, function="ggx", returns="f", ranges=["roughness=0.1..1"])
    assert terms.identify(code)[0].exact
    found = {
        f.what: f for r in foreign.check(code, only=["isotropy", "precision"]) for f in r.findings
    }
    assert found["change by a turn"].verdict != FAIL
    half = found["half precision"]
    # alpha^2 = 1e-4 has a spacing of 6e-8 in half precision, but 1 - NoH^2 one of 5e-4: D is anything
    assert half.measured > 0.5 or "changes nothing here" in half.text


SHORT = {
    "hlsl": "fixed3 f(half3 L, min16float3 V, half rough) {\n"
    "  half3 k = half3(1.0h, 1, 1); return k * rough; }",
    "metal": "#include <metal_stdlib>\nusing namespace metal;\n"
    "half3 f(half3 L, half3 V, half rough) { return half3(1.0h) * rough * (M_PI_H / 3.14159265h); }",
    "wgsl": "enable f16;\n"
    "fn f(L: vec3h, V: vec3<f16>, rough: f16) -> vec3h { return vec3h(1.0h) * rough; }",
}


@pytest.mark.parametrize("ending", SHORT)
def test_half_precision_that_cannot_be_run_is_float32_and_said(tmp_path: Path, ending: str) -> None:
    if tools.locate(TEXTURING[ending]) is None:
        pytest.skip(f"needs {TEXTURING[ending]}")
    code = foreign.load(write(tmp_path, f"a.{ending}", SHORT[ending]), function="f", returns="f")
    np.testing.assert_allclose(code.raw(*probe(4), {"rough": 0.3})[0], 0.3, rtol=SINGLE)
    said = {f.what for r in foreign.check(code, only=["finite"]) for f in r.findings}
    assert "half precision" in said


@pytest.mark.skipif(tools.locate("slangc") is None, reason="needs slangc")
def test_half_precision_in_included_files_is_float32_as_well(tmp_path: Path) -> None:
    common = "float twice(half3 L, min16float a) { half x = a; return 2.0h * x + 0 * L.x; }\n"
    write(tmp_path, "common.ush", f"#pragma once\n{common}")
    text = (
        '#include "common.ush"\nhalf f(half3 L, half3 V, half a) { return twice(L, a) + 0 * V.x; }'
    )
    code = foreign.load(write(tmp_path, "a.hlsl", text), function="f", returns="f")
    # 11 bits would round 0.3 to 0.30005
    np.testing.assert_allclose(code.raw(*probe(4), {"a": 0.3})[0], 0.6, rtol=SINGLE)
    assert code.source.short


TEXTURED = {
    "hlsl": "Texture2D<float4> map : register(t0);\nSamplerState s : register(s0);\n"
    "float3 f(float3 L, float3 V, float2 uv) { return map.Sample(s, uv).rgb; }",
    "slang": "Texture2D<float> map; SamplerState s;\n"
    "float f(float3 L, float3 V, float2 uv) { return map.SampleLevel(s, uv, 0) + 0 * L.x; }",
    "wgsl": "@group(0) @binding(0) var map: texture_2d<f32>;\n@group(0) @binding(1) var s: sampler;\n"
    "fn f(L: vec3f, V: vec3f, uv: vec2f) -> vec3f { return textureSampleLevel(map, s, uv, 0.0).rgb; }",
    "metal": "#include <metal_stdlib>\nusing namespace metal;\n"
    "float3 f(float3 L, float3 V, float2 uv, texture2d<float> map [[texture(0)]], sampler s) {\n"
    "  return map.sample(s, uv).rgb; }",
    "cu": "#include <cuda_runtime.h>\n__device__ float3 f(float3 L, float3 V, cudaTextureObject_t map) {\n"
    "  float4 c = tex2D<float4>(map, 0.5f, 0.5f); return make_float3(c.x, c.y, c.z); }",
}
TEXTURING = {"hlsl": "slangc", "slang": "slangc", "wgsl": "wgpu", "metal": "g++", "cu": "g++"}


@pytest.mark.parametrize("ending", TEXTURED)
def test_textures_are_constants_where_no_picture_can_be_read(tmp_path: Path, ending: str) -> None:
    if tools.locate(TEXTURING[ending]) is None:
        pytest.skip(f"needs {TEXTURING[ending]}")
    path = write(tmp_path, f"a.{ending}", TEXTURED[ending])
    value = "0.25" if ending == "slang" else "0.75/0.5/0.25"
    code = foreign.load(path, function="f", returns="f", textures=[f"map={value}"])
    expected = [0.25] * 3 if ending == "slang" else [0.75, 0.5, 0.25]
    np.testing.assert_array_equal(code.raw(*probe(4))[0], expected)
    if ending == "hlsl":
        picture = tmp_path / "a.png"
        Image.new("RGB", (2, 2)).save(picture)
        with pytest.raises(
            ForeignError, match=r"pictures are read for GLSL alone; give --texture map=0\.5"
        ):
            foreign.load(path, function="f", textures=[f"map={picture}"])
        with pytest.raises(ForeignError, match=r"no texture 'mop'; did you mean 'map'"):
            foreign.load(path, function="f", textures=["mop=0.5"])


PARTS = """
import numpy as np

def ggx(L, V, roughness, f0):
    H = (L + V) / np.linalg.norm(L + V, axis=1, keepdims=True)
    nl, nv, nh, vh = L[:, 2], V[:, 2], H[:, 2], (V * H).sum(1)
    a2 = roughness**4
    D = a2 / (np.pi * (nh * nh * (a2 - 1) + 1) ** 2)
    V_ = 0.5 / (nl * np.sqrt(nv * nv * (1 - a2) + a2) + nv * np.sqrt(nl * nl * (1 - a2) + a2))
    return D * V_ * (f0 + (1 - f0) * (1 - vh) ** 5)

def engine(L, V, base=(0.5, 0.5, 0.5), metallic=0.0, roughness=0.5):
    f0 = 0.04 * (1 - metallic[:, None]) + base * metallic[:, None]
    lobe = np.stack([ggx(L, V, roughness, f0[:, c]) for c in range(3)], 1)
    return (base * (1 - metallic[:, None]) / np.pi + lobe) * L[:, 2:]

def pi_twice(L, V, base=(0.5, 0.5, 0.5), roughness=0.5):
    return base / np.pi**2 + ggx(L, V, roughness, 0.04)[:, None]

def grazing(L, V, gain=0.5):
    return (1 + gain) / np.pi * np.where((L[:, 2] < 1e-6) | (V[:, 2] < 1e-6), np.nan, 1)

def narrow(L, V, m=0.5):
    return 0.1 / m**2 * (L[:, 2] * V[:, 2] + m) * m**2
"""


def test_a_sum_is_taken_apart_and_each_part_named(tmp_path: Path) -> None:
    path = write(tmp_path, "a.py", PARTS)
    code = foreign.load(f"{path}#engine", ranges=["roughness=0.2..1"])
    assert str(code.returns) == "f cos(theta_i)"
    found = foreign.identify(code)
    assert found.sum is not None
    assert found.sum.pinned == {"metallic": 0}
    (by, matte), (_, gloss) = found.sum.parts
    assert by == "base"
    assert str(matte) == "Lambert; times base; times N.L; times 1 / pi"
    assert str(gloss).startswith(
        "GGX, alpha = roughness^2; Smith's masking of GGX, height-correlated"
    )
    assert matte.odd == gloss.odd == ()
    wrong = foreign.identify(foreign.load(f"{path}#pi_twice", returns="f"))
    assert wrong.sum is not None
    assert [p.odd for _, p in wrong.sum.parts] == [("pi twice",), ()]


def test_ends_without_values_are_left_out_and_said(tmp_path: Path) -> None:
    path = write(tmp_path, "a.py", PARTS)
    reports = foreign.check(foreign.load(f"{path}#narrow", returns="f"), only=["energy", "finite"])
    found = {f.what: f for r in reports for f in r.findings}
    assert "no number at m = 0; all checks but 'finite' begin at 0.05" in found["left out"].text
    assert found["not finite"].verdict == FAIL
    # 0.1 (mu_i mu_o + m) over the hemisphere: 0.1 pi (2/3 + 1) at m = 1, straight from above
    assert found["largest albedo"].measured == pytest.approx(0.1 * np.pi * 5 / 3, rel=1e-3)


def test_energy_is_judged_beside_values_that_are_not_finite(tmp_path: Path) -> None:
    path = write(tmp_path, "a.py", PARTS)
    reports = foreign.check(foreign.load(f"{path}#grazing", returns="f"), only=["energy", "finite"])
    found = {f.what: f for r in reports for f in r.findings}
    assert found["largest albedo"].measured == pytest.approx(2, rel=COARSE)
    assert found["largest albedo"].verdict == FAIL
    assert found["not finite at the horizon"].measured > 0


def test_the_only_colour_of_code_is_that_of_the_model(tmp_path: Path) -> None:
    text = "import numpy as np\ndef f(L, V, tone=(0.5, 0.5, 0.5), gloss=0.5):\n    return tone / np.pi\n"
    code = foreign.load(write(tmp_path, "a.py", text) + "#f", returns="f")
    found = foreign.compare(code, gonio.model("lambert"))
    assert found.largest < 1e-6
    assert found.taken == {"tone": "rho"}
    lines = "\n".join(found.lines())
    assert "taken as the same: tone and rho" in lines
    assert "parameters of the code alone: gloss = 0.5" in lines


# --- comparison and identity ---------------------------------------------------------------------


def cases(number: int) -> list[tuple[faulty.Language, str]]:
    """Every fault, each in another language; all of them after as many rounds as there are languages."""
    count = len(faulty.LANGUAGES)
    return [(faulty.LANGUAGES[(k + number) % count], name) for k, name in enumerate(faulty.PLANTED)]


@pytest.mark.parametrize("language", faulty.LANGUAGES, ids=lambda language: language.ending)
def test_right_shaders_in_every_language_have_nothing_unusual(
    tmp_path: Path, language: faulty.Language, request: pytest.FixtureRequest
) -> None:
    if language.ending != "cpp" and not request.config.getoption("--long"):
        pytest.skip("every language: --long")
    if tools.locate(language.tool) is None:
        pytest.skip(f"needs {language.tool}")
    for base, numbers in (
        (faulty.SPECULAR, ["roughness"]),
        (faulty.STRETCHED, ["ax", "ay"]),
        (faulty.DIFFUSE, ["roughness"]),
    ):
        path = write(tmp_path, f"a.{language.ending}", faulty.shader(language, base))
        ranges = [] if language.ending == "brdf" else [f"{number}=0.1..1" for number in numbers]
        code = foreign.load(path, function=language.name, ranges=ranges)
        best = terms.identify(code)[0]
        assert best.exact
        assert best.odd == ()


@pytest.mark.parametrize(
    "number", range(len(faulty.LANGUAGES)), ids=lambda k: f"round {k}" if k else "first round"
)
def test_planted_mistakes_are_named_in_every_language(
    tmp_path: Path, number: int, request: pytest.FixtureRequest
) -> None:
    if number and not request.config.getoption("--long"):
        pytest.skip("every fault in every language: --long")
    for language, name in cases(number):
        if tools.locate(language.tool) is None:
            continue
        fault = faulty.PLANTED[name]
        text = faulty.shader(language, fault.base, **fault.changed)
        path = write(tmp_path, f"a.{language.ending}", text)
        numbers = ["ax", "ay"] if fault.base is faulty.STRETCHED else ["roughness"]
        ranges = [] if language.ending == "brdf" else [f"{number}=0.1..1" for number in numbers]
        code = foreign.load(path, function=language.name, returns="f", ranges=ranges)
        best = terms.identify(code)[0]
        assert best.exact, (language.ending, name, str(best), best.misfit)
        said = "; ".join([str(best), *best.odd])
        assert fault.words in said, (language.ending, name, said)
        assert best.odd or best.remarks, (language.ending, name, said)


# Diffuse formulas, each with the sentence that names it. Sources: Oren and Nayar 1994, Eq. 30; Fujii 2012.
OREN_NAYAR = """
vec3 f(vec3 L, vec3 V, vec3 N, vec3 rho, float roughness) {{
    float sigma = {sigma};
    float NoL = dot(N, L);
    float NoV = dot(N, V);
    float s = {cosine} - NoL * NoV;
    float s2 = sigma * sigma;
    float A = 1.0 - 0.5 * s2 / (s2 + 0.33);
    float B = 0.45 * s2 / (s2 + 0.09);
    return rho / 3.14159265 * (A + B * {part} / max(NoL, NoV));
}}
"""
FORMULA = {"sigma": "roughness", "cosine": "dot(L, V)", "part": "max(s, 0.0)"}
PLANTED_DIFFUSE = {
    "nothing": ({}, "Oren-Nayar, sigma = roughness;"),
    "sigma in degrees": ({"sigma": "radians(roughness)"}, "sigma = roughness in degrees"),
    "sigma squared": ({"sigma": "roughness * roughness"}, "sigma = roughness^2"),
    "s is not cut": ({"part": "s"}, "whose s / t is not cut at 0"),
}


@needs_gl
@pytest.mark.parametrize("name", PLANTED_DIFFUSE)
def test_mistakes_in_diffuse_shaders_are_named(tmp_path: Path, name: str) -> None:
    changed, words = PLANTED_DIFFUSE[name]
    text = OREN_NAYAR.format(**(FORMULA | changed))
    ranges = ["roughness=0..90"] if "degrees" in name else []
    code = foreign.load(write(tmp_path, "a.glsl", text), function="f", returns="f", ranges=ranges)
    best = terms.identify(code)[0]
    assert best.exact, (str(best), best.misfit)
    assert words in str(best)
    assert bool(best.odd) == (name != "nothing")


@needs_gl
def test_a_cut_angle_between_light_and_viewer_is_named(tmp_path: Path) -> None:
    # Fujii 2012; the plain model of Oren and Nayar is 0 there already, so that nothing is wrong with it
    text = """
vec3 fujii(vec3 L, vec3 V, vec3 N, vec3 rho, float roughness) {
    float A = 1.0 / (3.14159265 + (3.14159265 / 2.0 - 2.0 / 3.0) * roughness);
    float s = max(dot(L, V), 0.0) - dot(N, L) * dot(N, V);
    float t = s > 0.0 ? max(dot(N, L), dot(N, V)) : 1.0;
    return rho * A * (1.0 + roughness * s / t);
}
"""
    code = foreign.load(write(tmp_path, "a.glsl", text), function="fujii", returns="f")
    best = terms.identify(code)[0]
    assert best.exact
    assert "Fujii's Oren-Nayar with L.V cut at 0" in str(best)
    found = foreign.compare(code, gonio.model("qon_fujii"), fit_parameters=False)
    assert found.largest > 0.1


@needs_gl
def test_swapped_tangents_are_found_against_the_model_or_the_code_itself(tmp_path: Path) -> None:
    # Ward's exponent with the widths of both axes; only their order is wrong in the second
    text = """
float ward(vec3 L, vec3 V, vec3 N, vec3 X, vec3 Y, float ax, float ay) {{
    vec3 H = normalize(L + V);
    float hx = dot(H, {x}) / ax;
    float hy = dot(H, {y}) / ay;
    float NoH = dot(N, H);
    return exp(-(hx * hx + hy * hy) / (NoH * NoH)) / (4.0 * 3.14159265 * ax * ay);
}}
"""
    ranges = ["ax=0.2..0.8", "ay=0.2..0.8"]
    right, swapped = (
        foreign.load(
            write(tmp_path, f"{x}.glsl", text.format(x=x, y=y)),
            function="ward",
            returns="f",
            ranges=ranges,
        )
        for x, y in ("XY", "YX")
    )
    assert foreign.compare(right, right).largest == 0
    assert foreign.compare(right, swapped).largest > 0.5
    reports = foreign.check(right, only=["isotropy", "frame", "reciprocity"])
    assert FAIL not in verdicts(reports).values()
    assert any("anisotropic" in f.text for r in reports for f in r.findings)


@needs_gl
def test_rounding_is_no_error_but_cancellation_in_ggx_is_named(tmp_path: Path) -> None:
    # Filament's listing: 1 - NoH^2 by a cross product against (NoH^2 (a^2 - 1) + 1), at alpha = 0.01
    text = """
float right(vec3 L, vec3 V, vec3 N, float a) {
    vec3 H = normalize(L + V);
    vec3 c = cross(N, H);
    float k = a / (dot(c, c) + dot(N, H) * dot(N, H) * a * a);
    return k * k / 3.14159265;
}
float cancelling(vec3 L, vec3 V, vec3 N, float a) {
    float NoH = dot(N, normalize(L + V));
    float f = NoH * NoH * (a * a - 1.0) + 1.0;
    return a * a / (3.14159265 * f * f);
}
"""
    path = write(tmp_path, "a.glsl", text)
    given = {"returns": "f", "ranges": ["a=0.005..0.02"]}
    both = [foreign.load(path, function=name, **given) for name in ("right", "cancelling")]
    for code in both:
        found = foreign.check(code, only=["reciprocity", "isotropy"])
        assert FAIL not in verdicts(found).values(), [str(f) for r in found for f in r.findings]
    # The slope of log D is at most 4 / alpha or so: 4 / 0.005 times 6e-8 is 5e-5
    lost = [foreign.check(code, only=["precision"])[-1].findings[0] for code in both]
    # Ten times that
    assert lost[0].measured < 5e-4
    assert lost[1].measured > 5e-3
    assert "digits are lost" in lost[1].text


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
    # Single precision on both sides
    assert right.largest < 3e-6
    code = foreign.load(write(tmp_path, "a.glsl", text + wrapped), function="wrong", returns="f")
    found = foreign.compare(code, eon)
    # The wrapper has nine digits of pi; the largest difference is that of the nearest place
    assert found.largest == pytest.approx(1 - 1 / np.pi, rel=1e-3)
    assert "times pi everywhere" in found.hint
    grazing = (
        "vec3 wrong(Eon params, vec3 wi, vec3 wo) { return eon_eval(params, wi, wo) * "
        "(min(wi.z, wo.z) < 0.08 ? 2.0 : 1.0); }\n"
    )
    code = foreign.load(write(tmp_path, "b.glsl", text + grazing), function="wrong", returns="f")
    found = foreign.compare(code, eon)
    assert [b[2] < SINGLE_LONG for b in found.bands] == [True, True, True, False, False]
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


@pytest.mark.skipif(tools.locate("g++") is None, reason="needs g++")
def test_options_that_are_not_the_defaults_are_found(tmp_path: Path) -> None:
    from gonio.export import export

    made = export({"ue4": gonio.model("ue4", light="image")}, "cpp")[0]
    code = foreign.load(write(tmp_path, "a.h", made.source), function="ue4_eval")
    found = registry.identify(code, ["lambert", "ue4"])[0]
    assert found.exact
    assert "ue4 with light=image: base_color = base_color" in str(found)


# --- MaterialX ---------------------------------------------------------------------------------

needs_materialx = pytest.mark.skipif(
    importlib.util.find_spec("MaterialX") is None or tools.locate("moderngl") is None,
    reason="needs MaterialX and moderngl",
)

# Fujii's model in MaterialX's words, inside of a node graph's layer, and as a surface
DOCUMENT = """<?xml version="1.0"?>
<materialx version="1.39">
  <oren_nayar_diffuse_bsdf name="clay" type="BSDF">
    <input name="color" type="color3" value="0.5, 0.25, 0.125" />
    <input name="roughness" type="float" value="0.6" />
  </oren_nayar_diffuse_bsdf>
  <multiply name="half" type="BSDF">
    <input name="in1" type="BSDF" nodename="clay" /><input name="in2" type="float" value="0.5" />
  </multiply>
  <surface name="shader" type="surfaceshader"><input name="bsdf" type="BSDF" nodename="half" /></surface>
  <surfacematerial name="wall" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="shader" />
  </surfacematerial>
  <constant name="grey" type="color3"><input name="value" type="color3" value="0.1, 0.1, 0.1" /></constant>
</materialx>
"""


@needs_materialx
def test_nodes_and_materials_of_materialx_are_code_in_each_target(tmp_path: Path) -> None:
    path = write(tmp_path, "clay.mtlx", DOCUMENT)
    wi, wo = probe(50)
    wo[:, :2] = np.abs(wo[:, :2])
    wi[:, :2] = np.abs(wi[:, :2])  # L.V is positive: MaterialX's node cuts it at 0
    rho = (0.5, 0.25, 0.125)
    code = foreign.load(path + "#clay", ranges=["roughness=0..1"])
    assert list(code.parameters) == ["roughness"]
    assert code.parameters["roughness"].default == pytest.approx(0.6)
    smooth = code.brdf(wi, wo, {"roughness": 0.0})
    np.testing.assert_allclose(
        smooth, np.tile(np.array(rho) / np.pi, (len(wi), 1)), rtol=SINGLE_LONG
    )
    material = foreign.load(path)  # the only one
    np.testing.assert_allclose(material.brdf(wi, wo), 0.5 * code.brdf(wi, wo), rtol=SINGLE_LONG)
    for target, tool in {"essl": "moderngl", "slang": "slangc", "msl": "g++"}.items():
        if tools.locate(tool) is None:
            continue
        other = foreign.load(f"{path}#clay@{target}")
        np.testing.assert_allclose(other.brdf(wi, wo), code.brdf(wi, wo), rtol=SINGLE_LONG)


def test_a_shader_that_is_all_main_is_told_what_to_do(tmp_path: Path) -> None:
    text = "in vec3 n; out vec4 o; uniform vec3 l;\nvoid main() { o = vec4(dot(n, l)); }\n"
    code = source.read(write(tmp_path, "a.glsl", text))
    with pytest.raises(
        ForeignError, match="move its shading into a function that gives a colour back"
    ):
        code.find("main")


@needs_materialx
@needs_gl
@pytest.mark.parametrize("name", ["float", "Matériau#2", "2 sided"])
def test_nodes_of_materialx_may_be_called_anything(tmp_path: Path, name: str) -> None:
    path = tmp_path / "a.mtlx"
    text = DOCUMENT.replace('"clay"', f'"{name}"')
    assert text != DOCUMENT
    path.write_text(text, encoding="utf-8")
    code = foreign.load(f"{path}#{name}", uniforms=["roughness=0"])
    np.testing.assert_allclose(code.brdf(*probe(4))[:, 0], 0.5 / np.pi, rtol=SINGLE_LONG)
    assert not is_data_file(str(path))  # XML, which files of measurements are as well


@needs_materialx
def test_materialx_whose_angle_between_light_and_viewer_is_cut_is_named() -> None:
    # The library's node cuts L.V at 0, so that what scatters forward is far too bright
    code = foreign.load(
        "materialx#oren_nayar_diffuse_bsdf",
        mapping=["color=rho"],
        uniforms=["energy_compensation=1"],
    )
    found = foreign.compare(code, gonio.model("eon"))
    assert "L.V cut at 0" in found.hint
    a = np.radians(80)
    wi = np.array([[-np.sin(a), 0, np.cos(a)]])
    wo = wi * [-1, 1, 1]
    values = {"rho": (0.8, 0.8, 0.8), "roughness": 1.0}
    wrong, right = code.brdf(wi, wo, values), gonio.model("eon", **values).eval(wi, wo)
    assert wrong[0, 0] / np.asarray(right)[0, 0] > 15


@needs_materialx
@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("#nothing", "no node 'nothing' that reflects.*has clay"),
        ("#grey", "grey is a color3"),
        ("#clay@mdl", "no target 'mdl'"),
    ],
)
def test_what_materialx_cannot_give_is_one_sentence(tmp_path: Path, name: str, words: str) -> None:
    path = write(tmp_path, "clay.mtlx", DOCUMENT)
    with pytest.raises(ForeignError, match=words):
        foreign.load(path + name)


# --- Python and compiled libraries -------------------------------------------------------------

PYTHON = """
import math
import numpy as np

def phong(wi, wo, rho=(0.5, 0.4, 0.3), n=20.0):
    cosine = np.maximum(2 * wi[:, 2] * wo[:, 2] - (wi * wo).sum(1), 0)
    return rho * ((n + 2) / (2 * np.pi) * cosine**n)[:, None]

def alone(NdotL, NdotV, roughness):
    return math.exp(-roughness * NdotL) if NdotL > 0.5 else 0.3 * NdotV

def lambert(wi, wo, rho):
    return rho / np.pi

def lambert_sample(wo, u):
    r, phi = np.sqrt(u[:, 0]), 2 * np.pi * u[:, 1]
    return np.stack([r * np.cos(phi), r * np.sin(phi), np.sqrt(1 - r * r)], -1)

def uniform_pdf(wi, wo):
    return np.full(len(wi), 0.5 / np.pi)

def wrong(wi, wo, rho):
    x = np.zeros(3)

    return x[len(wi)]

def nosy(wi, wo):
    open("/etc/hostname").read()
    return 1.0

def online(wi, wo):
    import socket
    socket.create_connection(("127.0.0.1", 9))
    return 1.0
"""


def test_functions_of_python_take_arrays_or_single_numbers(tmp_path: Path) -> None:
    path = write(tmp_path, "brdf.py", PYTHON)
    wi, wo = probe(20)
    code = foreign.load(path + "#phong", ranges=["n=1..100"], returns="f")
    assert code.parameters["rho"].default == (0.5, 0.4, 0.3)
    cosine = np.maximum(2 * wi[:, 2] * wo[:, 2] - (wi * wo).sum(1), 0)
    expected = 0.5 * 12 / (2 * np.pi) * cosine**10
    # Ten times the error of a cosine of directions in single precision
    np.testing.assert_allclose(code.brdf(wi, wo, {"n": 10.0})[:, 0], expected, rtol=1e-4, atol=1e-6)
    alone = foreign.load(path + "#alone", returns="f").brdf(wi, wo, {"roughness": 0.5})
    expected = np.where(wi[:, 2] > 0.5, np.exp(-0.5 * wi[:, 2]), 0.3 * wo[:, 2])
    np.testing.assert_allclose(alone[:, 0], expected, rtol=SINGLE_LONG)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("wrong", r"brdf\.py:\d+: IndexError.* \|  return x\[len\(wi\)\]"),
        ("nosy", "may not open /etc/hostname"),
        ("online", "may not use socket"),
        ("missing", "defines no function 'missing'; .*phong"),
    ],
)
def test_mistakes_and_curiosity_of_python_are_one_sentence(
    tmp_path: Path, name: str, words: str
) -> None:
    path = write(tmp_path, "brdf.py", PYTHON)
    with pytest.raises(ForeignError, match=words):
        foreign.load(f"{path}#{name}").raw(*probe(4))


def test_a_sampler_that_does_not_follow_its_density_is_found(tmp_path: Path) -> None:
    path = write(tmp_path, "brdf.py", PYTHON)
    code = foreign.load(
        path + "#lambert", sample="lambert_sample", pdf="uniform_pdf", albedo="lambert", returns="f"
    )
    found = verdicts(foreign.check(code, only=["sampling", "albedo"]))
    assert found["chi-square"] == FAIL  # a cosine is drawn, an even density claimed
    assert found["error of albedo"] == FAIL  # rho / pi is no albedo
    with pytest.raises(ForeignError, match="--sample and --pdf go together"):
        foreign.load(path + "#lambert", sample="lambert_sample")


@needs_gxx
def test_functions_of_compiled_libraries_are_called_by_their_signature(tmp_path: Path) -> None:
    text = """
typedef struct { float x, y, z; } vec3;
float eval(const float wi[3], const float wo[3], float rho) { return rho * wi[2]; }
vec3 by_value(vec3 L, vec3 V, double rho) { vec3 r = {rho, L.x, V.z}; return r; }
void written(const float* L, const float* V, float* out) { out[0] = L[0]; out[1] = 2; out[2] = V[2]; }
"""
    write(tmp_path, "lib.c", text)
    subprocess.run(
        ["g++", "-x", "c", "-shared", "-fPIC", "lib.c", "-o", "libbrdf.so"],
        cwd=tmp_path,
        check=True,
    )
    wi, wo = probe(3)
    path = f"{tmp_path}/libbrdf.so"
    cases = {
        "float eval(const float wi[3], const float wo[3], float rho)": [0.5 * wi[:, 2]] * 3,
        "vec3 by_value(vec3 L, vec3 V, double rho)": [0.5 + 0 * wi[:, 0], wi[:, 0], wo[:, 2]],
        "void written(const float* L, const float* V, float* out)": [
            wi[:, 0],
            2 + 0 * wi[:, 0],
            wo[:, 2],
        ],
    }
    for signature, expected in cases.items():
        code = foreign.load(path, signature=signature, returns="f")
        found = code.raw(wi, wo, {"rho": 0.5} if code.parameters else {})
        np.testing.assert_allclose(found, np.stack(expected, -1), rtol=SINGLE, err_msg=signature)
    for given, words in (
        ({}, "say how its function is called"),
        (
            {"signature": "float none(const float wi[3], const float wo[3])"},
            "has no function 'none'",
        ),
        ({"signature": "gibberish"}, "is no declaration in C"),
    ):
        with pytest.raises(ForeignError, match=words):
            foreign.load(path, **given)


# --- as a model -----------------------------------------------------------------------------------


@needs_gxx
def test_code_is_a_model_wherever_values_are_enough() -> None:
    code = foreign.load(f"{GOLDEN}/eon.h#gonio_eon::eon_eval")
    model, eon = foreign.as_model(code), gonio.model("eon", rho=(0.2, 0.5, 0.7), roughness=0.3)
    same = model.replace(rho=(0.2, 0.5, 0.7), roughness=0.3)
    wi, wo = probe(30)
    np.testing.assert_allclose(same.eval(wi, wo), eon.eval(wi, wo), rtol=SINGLE_LONG)
    # Its rule of directions is good to 1e-3
    np.testing.assert_allclose(same.albedo(wo), eon.albedo(wo), atol=COARSE)
    np.testing.assert_allclose(same.mean_albedo(), eon.mean_albedo(), atol=COARSE)
    assert model.isotropic
    # Derivatives are differences of the code's values; the fit finds what made the data
    found = fit.fit(model, eon, starts=1, points=300).model
    assert found.roughness == pytest.approx(0.3, abs=FOUND)
    assert found.rho == pytest.approx((0.2, 0.5, 0.7), abs=FOUND)


@needs_gxx
def test_plots_fits_and_values_of_code_on_the_command_line(tmp_path: Path) -> None:
    runner = CliRunner()
    code = f"{GOLDEN}/eon.h#gonio_eon::eon_eval"
    target = str(tmp_path / "a.csv")
    done = runner.invoke(main, ["plot", code, "--vary", "roughness=0.2,0.5", "-o", target])
    assert done.exit_code == 0, done.output
    assert Path(target).stat().st_size > 0
    done = runner.invoke(
        main, ["eval", f"{code}:roughness=0,rho=0.5", "--theta-o", "30", "--theta-i", "0", "--json"]
    )
    assert json.loads(done.output)["eval"] == pytest.approx([0.5 / np.pi] * 3)
    for arguments, said in (
        (["plot", "eon", "--map", "a=b"], "code"),
        (["view", code], "no browser compiles"),
        (["fit", "eon", code, "-o", "a.toml"], "code"),
    ):
        done = runner.invoke(main, arguments)
        assert done.exit_code != 0
        assert said in done.output


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


@needs_gxx
def test_a_baseline_lets_old_faults_pass_and_tells_new_ones(tmp_path: Path) -> None:
    text = "struct V {{ float x, y, z; }};\nfloat f(V wi, V wo, float rho) {{ return {}; }}"
    runner, picture = CliRunner(), str(tmp_path / "map.png")
    base = str(tmp_path / "base.json")
    path = write(tmp_path, "a.cpp", text.format("1.01f * rho * 0.318309886f"))
    check = ["check", path + "#f", "--only", "reciprocity", "--returns", "f"]
    compare = ["compare", path + "#f", "lambert", "--returns", "f"]
    for command in (check, compare):
        write(tmp_path, "a.cpp", text.format("1.01f * rho * 0.318309886f"))
        Path(base).write_text(runner.invoke(main, [*command, "--json"]).stdout, encoding="utf-8")
        assert runner.invoke(main, [*command, "--baseline", base]).exit_code == 0
        write(tmp_path, "a.cpp", text.format("rho * wi.z"))
        done = runner.invoke(main, [*command, "--baseline", base])
        assert (done.exit_code, "worse: " in done.output) == (1, True), done.output
    done = runner.invoke(main, [*compare, "-o", picture])
    assert done.exit_code == 0, done.output
    assert Path(picture).stat().st_size > 10_000
    done = runner.invoke(main, [*check, "--baseline", str(tmp_path / "none.json")])
    assert "--json >" in done.output


def test_a_baseline_tells_better_black_and_unknown_code(tmp_path: Path) -> None:
    runner, base = CliRunner(), tmp_path / "base.json"
    text = "def f(wi, wo):\n    return {} + 0 * wi[:, 0]\n\ndef g(wi, wo):\n    return 0.3 + 0 * wi[:, 0]\n"
    path = write(tmp_path, "a.py", text.format("-0.1 + wo[:, 2]"))
    judge = [path + "#f", "--only", "reciprocity", "--returns", "f"]
    assert runner.invoke(main, ["check", *judge, "--junit", str(tmp_path / "a.xml")]).exit_code == 1
    base.write_text(runner.invoke(main, ["check", *judge, "--json"]).stdout, encoding="utf-8")
    since = ["--baseline", str(base)]
    write(tmp_path, "a.py", text.format("0.3"))
    done = runner.invoke(main, ["check", *judge, *since])
    assert (done.exit_code, "better: a.py#f, reciprocity" in done.output) == (0, True), done.output
    done = runner.invoke(main, ["check", path + "#g", *judge[1:], *since])
    assert (done.exit_code, "has nothing of a.py#g" in done.output) == (0, True), done.output
    write(tmp_path, "a.py", text.format("0.0"))
    done = runner.invoke(main, ["check", *judge, *since])
    assert (done.exit_code, "cannot be judged any more" in done.output) == (1, True), done.output
    junit = str(tmp_path / "b.xml")
    assert runner.invoke(main, ["check", *judge, "--junit", junit]).exit_code == 1
    assert 'skipped="1"' in Path(junit).read_text(encoding="utf-8")


@pytest.mark.parametrize("text", ["[1, 2]", '[{"model": "a"}]', "{}", '{"comparisons": [3]}', "["])
def test_damaged_baselines_are_one_sentence(tmp_path: Path, text: str) -> None:
    path = write(tmp_path, "a.py", "def f(wi, wo):\n    return 0.3 + 0 * wi[:, 0]\n") + "#f"
    base = write(tmp_path, "base.json", text)
    for command in (["check", path, "--only", "frame"], ["compare", path, "lambert:rho=1"]):
        done = CliRunner().invoke(main, [*command, "--returns", "f", "--baseline", base])
        assert done.exit_code == 1
        assert "is not what the same command with --json writes" in done.output


def test_methods_and_files_of_one_name_keep_their_own_reports(tmp_path: Path) -> None:
    text = "def f(wi, wo):\n    return 0.3 + 0 * wi[:, 0]\n"
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "x.py").write_text(text, encoding="utf-8")
    paths = [f"{tmp_path}/{folder}/x.py#f" for folder in ("a", "b")]
    done = CliRunner().invoke(main, ["check", *paths, "--only", "reciprocity", "--returns", "f"])
    assert all(f"{path}: pass" in done.output for path in paths), done.output


def test_options_of_code_are_not_ignored_in_silence() -> None:
    runner = CliRunner()
    for arguments in (["check", "eon", "--map", "L=wi"], ["compare", "eon", "fon", "--identify"]):
        done = runner.invoke(main, arguments)
        assert done.exit_code != 0
