"""The proof of exports proves: right shaders pass, broken ones of every kind do not.

The shaders here are written by hand (tests/export_fixtures), so that the proof is tested without the
printer. EON's equations in them come from the paper.
"""

from __future__ import annotations

import re
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.directions import RANDOM, adversarial_pairs
from support.tolerances import SINGLE

import gonio
from gonio.export import Entry, Export, Member, export
from gonio.export.prove import ProofError, describe, judge, prove, table, tools
from gonio.export.prove.harness import input_columns, split
from gonio.export.prove.rows import rows_for
from gonio.export.prove.runners import RUNNERS
from gonio.fields import Parameter

FIXTURES = Path(__file__).parent / "export_fixtures"
FILES = {
    "glsl": "eon.glsl",
    "spirv": "eon.glsl",
    "essl": "eon.glsl",
    "hlsl": "eon.hlsl",
    "wgsl": "eon.wgsl",
    "msl": "eon.metal",
    "slang": "eon.slang",
    "osl": "eon.osl",
    "cpp": "eon.h",
}
# Blender's Python package, which has the compiler of OSL, exists for one version of Python.
LANGUAGES = [name for name in FILES if name != "osl" or sys.version_info[:2] == (3, 11)]

MEMBERS = (Member("rho", 3), Member("roughness", 1))
ENTRY = Entry("eon", "Eon", "EonSample", "gonio_eon", MEMBERS, ("eval", "sample", "pdf", "albedo"))
MODEL = gonio.model("eon", albedo_form="fitted", sampler="cosine")
COUNT = 10_000


def by_hand(language):
    return Export(language, (FIXTURES / FILES[language]).read_text(encoding="utf-8"), ENTRY)


def changed(language, pattern, new):
    """The shader with one place changed; a pattern that is not there would make a test vacuous."""
    right = by_hand(language)
    source, count = re.subn(pattern, new, right.source, count=1)
    assert count == 1, f"{pattern} is not in {FILES[language]}"
    return replace(right, source=source)


def failures(shader, model=MODEL, count=COUNT):
    return {p.function: p for p in prove([(model, shader)], count) if not p.holds}


@pytest.mark.parametrize("language", LANGUAGES)
def test_shaders_written_by_hand_are_proven(language):
    proofs = prove([(MODEL, by_hand(language))], COUNT)
    assert [p.function for p in proofs] == ["eval", "sample", "pdf", "albedo"]
    assert all(p.holds for p in proofs), table(proofs)
    assert all(p.rows == COUNT for p in proofs)
    # The median row is right to the last digits of a float32
    assert max(p.median for p in proofs) < 2e-7
    assert all(p.device and p.reason and p.seconds > 0 for p in proofs)


def swapped(match):
    """The arms of a choice, the other way round: c ? a : b, or WGSL's select(b, a, c)."""
    return re.sub(r"(above|below)", lambda m: {"above": "below", "below": "above"}[m[1]], match[0])


# What goes wrong in printers, and the functions that are wrong then. One pattern for all languages:
# numbers end in f in C++, and components are w[2] in OSL.
MISTAKES = {
    "a wrong constant in the third digit": (r"0\.0724882", "0.0734882", {"eval", "albedo"}),
    "a wrong coefficient in the third digit": (r"0\.4918818", "0.4928818", {"eval", "albedo"}),
    "a lost bracket": (r"\((1\.0f? - mu)\) \*", r"\1 *", {"albedo"}),
    "a bracket in the wrong place": (r"\* \(x \* x \+", "* x * (x +", {"eval"}),
    "a swapped choice": (r"above : below|select\(below, above", swapped, {"eval"}),
    "a swapped condition": (r"(s|a|select.*) > 0\.0", r"\1 < 0.0", {"eval"}),
    "a wrong sign": (r"(\w+ phi =) 2", r"\1 -2", {"sample"}),
    "a lost divisor": (r"(wi(?:\.z|\[2\])) / EON_PI", r"\1", {"sample", "pdf"}),
    "sine for cosine": (r"cos\(phi\)", "sin(phi)", {"sample"}),
    "a lost parameter": (r"(\w+ r =) [\w.]+", r"\1 0.5", {"eval"}),
    "light below the horizon": (r"wi(\.z|\[2\]) <= 0", r"wi\1 <= -2", {"eval"}),
}


@pytest.mark.parametrize("language", LANGUAGES)
def test_a_broken_printer_is_caught_in_every_language(language):
    exports = [changed(language, pattern, new) for pattern, new, _ in MISTAKES.values()]
    proofs = prove([(MODEL, shader) for shader in exports], 3000)
    each = len(ENTRY.functions)
    assert len(proofs) == each * len(exports), table(proofs)
    for number, (mistake, (_, _, wrong)) in enumerate(MISTAKES.items()):
        found = proofs[each * number : each * (number + 1)]
        assert {p.function for p in found if not p.holds} == wrong, mistake


@pytest.mark.parametrize("language", LANGUAGES)
def test_values_that_are_not_finite_are_refused_in_every_language(language):
    """A square that leaves float32's range for r near 1; OSL makes roots and quotients finite itself."""
    larger = "std::max" if language == "cpp" else "max"
    big = f"({larger}(r - 0.999, 0.0) * 1e30)"
    shader = changed(language, r"(mean_E / \(.*\));", rf"\1 * float_(1.0 + {big} * {big});")
    source = shader.source.replace("float_", "f32" if language == "wgsl" else "float")
    if language == "cpp":
        source = re.sub(r"(0\.999|0\.0|1e30|1\.0)(?=[ ,)])", r"\1f", source)
    found = failures(replace(shader, source=source))
    assert set(found) == {"eval", "albedo"}
    assert "not finite" in found["eval"].failure
    assert found["eval"].where["roughness"] > 0.999


@pytest.mark.parametrize("language", LANGUAGES)
def test_a_compiler_that_refuses_is_quoted_with_the_line_of_the_export(language):
    broken = changed(language, r"(\w+) A_F = .*;", r"\1 A_F = undefined_name;")
    line = next(k for k, t in enumerate(broken.source.splitlines(), 1) if "undefined_name" in t)
    (proof,) = prove([(MODEL, broken)], 100)
    assert proof.function == "compile"
    assert not proof.holds
    # oslc has read on to the next line when it notices
    assert re.search(
        rf"line ({line}|{line + 1}):" if language == "osl" else f"line {line}:", proof.failure
    )
    assert "undefined_name" in proof.failure
    assert language in describe(proof)


def test_one_broken_export_does_not_hide_the_others():
    good, bad = by_hand("cpp"), changed("cpp", "inline float eon_asin", "inline float asin")
    proofs = prove([(MODEL, good), (MODEL, bad), (MODEL, good)], 500)
    assert [p.function for p in proofs if not p.holds] == ["compile"]
    assert len([p for p in proofs if p.holds]) == 8


# -------------------------------------------------------------------------- the harness and its order


def test_a_wrong_order_of_outputs_or_of_members_is_caught():
    rows = rows_for(MODEL, MEMBERS, 1000)
    (outputs,) = RUNNERS["cpp"]([by_hand("cpp")], [rows]).outputs
    for function, got in split(ENTRY, outputs).items():
        expected = judge.expect(MODEL, ENTRY, function, rows)
        verdict = judge.judge(MODEL, ENTRY, function, rows, got, judge.NATIVE, expected)
        assert not verdict.failure
        turned = np.roll(got, 1, -1) if got.shape[1] > 1 else got[::-1]
        verdict = judge.judge(MODEL, ENTRY, function, rows, turned, judge.NATIVE, expected)
        assert verdict.failure, function
    other = replace(by_hand("cpp"), entry=replace(ENTRY, members=MEMBERS[::-1]))
    (outputs,) = RUNNERS["cpp"]([other], [rows]).outputs
    for function in ("eval", "albedo"):
        expected = judge.expect(MODEL, ENTRY, function, rows)
        got = split(ENTRY, outputs)[function]
        assert judge.judge(MODEL, ENTRY, function, rows, got, judge.NATIVE, expected).failure


def test_functions_that_were_not_exported_are_not_called():
    only = replace(ENTRY, functions=("eval",))
    source = by_hand("cpp").source
    source = source[: source.index("inline float eon_pdf")] + "}\n"
    (proof,) = prove([(MODEL, Export("cpp", source, only))], 500)
    assert (proof.function, proof.holds) == ("eval", True)


def test_fixed_parameters_keep_the_models_values():
    """An export without the member `roughness` has the model's own number in it."""
    source = re.sub(r"float roughness;.*", "", by_hand("cpp").source)
    source = source.replace("params.roughness", "0.25f")
    entry = replace(ENTRY, members=MEMBERS[:1])
    assert not failures(Export("cpp", source, entry), MODEL.replace(roughness=0.25))
    assert failures(Export("cpp", source, entry), MODEL.replace(roughness=0.26))


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize("count", [1, 65, 600])
def test_any_number_of_rows_can_be_run(language, count):
    rows = rows_for(MODEL, MEMBERS, 2000)[:count]
    (outputs,) = RUNNERS[language]([by_hand(language)], [rows]).outputs
    assert outputs.shape == (count, 11)
    (native,) = RUNNERS["cpp"]([by_hand("cpp")], [rows]).outputs
    # Two compilers, whose sines and powers are good to a few 1e-6 of numbers near 10
    np.testing.assert_allclose(outputs, native, rtol=1e-4, atol=SINGLE)


# ------------------------------------------------------------------------------------------- the rows


def every_model():
    return [gonio.model(name) for name in gonio.models()]


def members_of(model):
    return tuple(Member(path, p.width) for path, p, _ in model.parameters())


@pytest.mark.parametrize("model", every_model(), ids=lambda m: m.name)
def test_rows_meet_the_hard_places_of_every_model(model):
    members = members_of(model)
    rows = rows_for(model, members, COUNT)
    wi, wo, u = rows[:, :3], rows[:, 3:6], rows[:, 6:8]
    assert rows.dtype == np.float32
    assert np.isfinite(rows).all()
    assert abs(np.linalg.norm(rows[:, :3].astype(float), axis=1) - 1).max() < SINGLE
    above = (wi[:, 2] > 0) & (wo[:, 2] > 0)
    assert 0.85 < above.mean() < 0.97
    for there in (
        (wi[:, 2] == 0) & (wo[:, 2] > 0),
        (wo[:, 2] == 0) & (wi[:, 2] > 0),
        (wi[:, 2] < 0) & (wo[:, 2] < 0),
        (wi[:, 2] > 0) & (wi[:, 2] < 1e-6),
        (wi == wo).all(1),
        (wi == wo * np.float32([-1, -1, 1])).all(1),
        wo[:, 2] == 1,
        u[:, 0] == 0,
        u[:, 1] == np.float32(1 - 2**-24),
    ):
        assert there.sum() >= 10
    assert (u < 1).all()
    column = 8
    for path, declared, _ in model.parameters():
        value = rows[:, column : column + declared.width]
        assert isinstance(declared, Parameter)
        assert value.min() == np.float32(declared.low), path
        assert value.max() == np.float32(declared.high), path
        assert len(np.unique(value)) > COUNT / 2
        column += declared.width
    assert column == rows.shape[1]
    assert (rows == rows_for(model, members, COUNT)).all()
    assert (rows != rows_for(model, members, COUNT, seed=1)).any()


# ------------------------------------------------------------------------------------------ the judge


# Relative tolerance in the median row, of rows made to be hard.
TIGHT = {judge.NATIVE: 2e-5, judge.LLVMPIPE: 1e-4, judge.CYCLES: 2e-4}


@pytest.mark.parametrize("model", every_model(), ids=lambda m: m.name)
def test_the_judge_lets_rounding_pass_and_little_more(model):
    """gonio's own float32 stands for an export; then it is off by one part in 3000."""
    entry = Entry(model.name, "", "", "", members_of(model), ("eval", "sample", "pdf"))
    rows = rows_for(model, entry.members, 4000, seed=5)

    def verdict(function, got):
        return judge.judge(model, entry, function, rows, got, judge.NATIVE, expected)

    for function in ("eval", "pdf"):
        expected = judge.expect(model, entry, function, rows)
        got = judge.evaluate(model, entry, function, rows, np.float32)
        assert not verdict(function, got).failure
        assert verdict(function, got * (1 + 3e-4)).failure
        # Every second of these hard rows is held to four digits, on the least exact device too
        lit = expected.value.min(-1) > 0
        for device in set(judge.DEVICES.values()):
            allowed = device.factor * expected.rounding + device.relative * expected.value
            relative = np.median((allowed[lit] / expected.value[lit]).max(-1))
            assert relative < TIGHT[device]
    expected = judge.expect(model, entry, "sample", rows)
    got = judge.evaluate(model, entry, "sample", rows, np.float32)
    assert not verdict("sample", got).failure
    assert verdict("sample", got * [1, 1, 1, 1 + 3e-4]).failure
    angle = 3e-4
    turn = np.array([[1, -angle, 0, 0], [angle, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
    assert verdict("sample", got @ turn).failure
    assert verdict("sample", got * [1.001, 1.001, 1.001, 1]).failure


def test_samples_may_choose_another_lobe_if_they_have_its_density():
    """Where random numbers are within rounding of a threshold; said in the table, and only so many."""
    model = gonio.model("disney")
    entry = Entry("disney", "", "", "", members_of(model), ("sample",))
    rows = rows_for(model, entry.members, 4000)
    expected = judge.expect(model, entry, "sample", rows)
    got = judge.evaluate(model, entry, "sample", rows, np.float64)
    # The last rows are sampled with other random numbers, as if they had taken another lobe
    other = rows.copy()
    other[:, 6] = np.mod(other[:, 6] + 0.5, 1)
    elsewhere = judge.evaluate(model, entry, "sample", other, np.float64)
    for flips, holds in ((3, True), (40, False)):
        lit = np.nonzero((got[:, 3] > 0) & (elsewhere[:, 3] > 0))[0][:flips]
        mixed = got.copy()
        mixed[lit] = elsewhere[lit]
        verdict = judge.judge(model, entry, "sample", rows, mixed, judge.NATIVE, expected)
        assert (not verdict.failure) == holds
        assert "another lobe" in verdict.note
    mixed = got.copy()
    mixed[lit[:3], :3] = elsewhere[lit[:3], :3]  # the direction alone: its density is another one
    verdict = judge.judge(model, entry, "sample", rows, mixed, judge.NATIVE, expected)
    assert "density" in verdict.failure


# ---------------------------------------------------------------------------------- devices and tools

PROBE = """
struct Probe { float x; float y; };
struct ProbeSample { vec3 wi; float pdf; };
vec3 probe_eval(Probe params, vec3 wi, vec3 wo) {
    return vec3(exp(params.y), log(params.x), pow(params.x, params.y));
}
ProbeSample probe_sample(Probe params, vec3 wo, vec2 u) {
    ProbeSample s;
    s.wi = vec3(sin(params.y), cos(params.y), sqrt(params.x));
    s.pdf = 1.0 / params.x;
    return s;
}
"""
PROBE_WGSL = """
struct Probe { x: f32, y: f32 }
struct ProbeSample { wi: vec3f, pdf: f32 }
fn probe_eval(params: Probe, wi: vec3f, wo: vec3f) -> vec3f {
    return vec3f(exp(params.y), log(params.x), pow(params.x, params.y));
}
fn probe_sample(params: Probe, wo: vec3f, u: vec2f) -> ProbeSample {
    return ProbeSample(vec3f(sin(params.y), cos(params.y), sqrt(params.x)), 1.0 / params.x);
}
"""
PROBE_OSL = """
shader probe(float x = 1, float y = 1, vector wi = 0, vector wo = 0, float u1 = 0, float u2 = 0,
    output color f = 0, output vector sampled_wi = 0, output float sampled_pdf = 0)
{
    f = color(exp(y), log(x), pow(x, y));
    sampled_wi = vector(sin(y), cos(y), sqrt(x));
    sampled_pdf = 1 / x;
}
"""


def probe(language):
    source = {"wgsl": PROBE_WGSL, "osl": PROBE_OSL}.get(language, PROBE)
    if language in {"hlsl", "msl"}:
        source = source.replace("vec", "float")
    if language == "msl":
        source = f"#include <metal_stdlib>\nusing namespace metal;\n{source}"
    entry = Entry(
        "probe", "Probe", "ProbeSample", "", (Member("x", 1), Member("y", 1)), ("eval", "sample")
    )
    return Export(language, source, entry)


@pytest.mark.parametrize("language", [n for n in LANGUAGES if n not in {"cpp", "slang"}])
def test_devices_are_as_exact_as_their_tolerances_say(language):
    """exp, log, pow, sin, cos, sqrt and division, each against float64, over the range shaders need."""
    rng = np.random.default_rng(1)
    rows = np.zeros((20_000, input_columns(probe(language).entry)), np.float32)
    rows[:, 8] = np.exp(rng.uniform(-12, 12, len(rows)))
    rows[::2, 8] = rng.uniform(0.5, 2, len(rows[::2]))
    rows[:, 9] = rng.uniform(-7, 7, len(rows))
    x, y = rows[:, 8].astype(float), rows[:, 9].astype(float)
    results = RUNNERS[language]([probe(language)], [rows])
    (outputs,) = results.outputs
    exp, log, power, sin, cos, root, reciprocal = outputs.astype(float).T
    device = judge.DEVICES[language]
    assert (abs(exp / np.exp(y) - 1) <= device.relative).all()
    near = abs(x - 1) < 0.5
    assert (abs(log - np.log(x))[near] <= max(device.logarithm, 2 * judge.ULP)).all()
    # A power loses digits with its exponent, as rounding of x does
    grown = 1 + abs(y * np.log(x))
    assert (abs(power / x**y - 1) <= device.relative * grown).all()
    for got, exact in ((sin, np.sin(y)), (cos, np.cos(y))):
        assert (abs(got - exact) <= device.relative).all()
    for got, exact in ((root, np.sqrt(x)), (reciprocal, 1 / x)):
        assert (abs(got / exact - 1) <= 2 * judge.ULP).all()


@pytest.mark.parametrize(
    ("language", "tool"),
    [
        ("glsl", "glslangValidator"),
        ("hlsl", "slangc"),
        ("slang", "slangc"),
        ("msl", "g++"),
        ("cpp", "g++"),
        ("wgsl", "wgpu"),
        ("essl", "glslangValidator"),
        ("osl", "bpy"),
    ],
)
def test_a_missing_tool_is_named_with_what_to_install(monkeypatch, language, tool):
    monkeypatch.setenv("PATH", "/nowhere")
    monkeypatch.setattr(sys, "path", [])
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(ProofError) as raised:
        prove([(MODEL, by_hand(language))], 100)
    assert str(raised.value).startswith(f"{tool} is not installed")
    assert "install" in str(raised.value).partition(";")[2]
    assert "\n" not in str(raised.value)


def test_a_driver_that_does_not_work_is_named_with_what_to_install(monkeypatch):
    monkeypatch.setenv("__EGL_VENDOR_LIBRARY_FILENAMES", "/nowhere")
    with pytest.raises(
        ProofError, match=r"^moderngl does not work here \(.*\); .*libegl1"
    ) as raised:
        prove([(MODEL, by_hand("glsl"))], 100)
    assert "\n" not in str(raised.value)


def as_cuda(name, source=lambda text: text):
    (made,) = export({name: gonio.model(name)}, "cuda")
    return replace(made, source=source(made.source))


def test_the_cuda_compiler_refuses_what_cannot_run_on_a_gpu():
    """g++ knows nothing of __device__ and sees no mistake in either."""
    host = as_cuda("eon", lambda text: text.replace("__host__ __device__ ", "", 1))
    library = as_cuda(
        "lambert", lambda text: text.replace("<math.h>", "<cmath>\n#include <vector>")
    )
    right = as_cuda("fon")
    results = RUNNERS["cuda"](
        [host, library, right],
        [rows_for(MODEL, e.entry.members, 64) for e in (host, library, right)],
    )
    for output, export_, words in zip(
        results.outputs, (host, library), ("line .*: ", "could not open source"), strict=False
    ):
        assert isinstance(output, ProofError)
        assert re.search(
            rf"^{export_.entry.prefix} in cuda: NVRTC says: .*{words}", str(output), re.S
        )
    assert isinstance(results.outputs[2], np.ndarray)
    assert "NVRTC" in results.device


def test_a_missing_cuda_compiler_is_named_with_what_to_install(monkeypatch):
    locate = tools.locate
    monkeypatch.setattr(tools, "locate", lambda name: None if name == "nvrtc" else locate(name))
    with pytest.raises(
        ProofError, match=r"^nvrtc is not installed, .*; pip install nvidia-cuda-nvrtc"
    ):
        prove([(gonio.model("lambert"), as_cuda("lambert"))], 100)


def test_a_cuda_compiler_that_does_not_work_is_named(monkeypatch, tmp_path):
    (tmp_path / "libnvrtc.so").write_bytes(b"no library")
    locate = tools.locate
    broken = str(tmp_path / "libnvrtc.so")
    monkeypatch.setattr(tools, "locate", lambda name: broken if name == "nvrtc" else locate(name))
    with pytest.raises(
        ProofError, match=r"^nvrtc does not work here \(.*\); pip install"
    ) as raised:
        prove([(gonio.model("lambert"), as_cuda("lambert"))], 100)
    assert "\n" not in str(raised.value)


def test_an_unknown_language_is_refused():
    with pytest.raises(ProofError, match="nothing can run 'cobol'; there are glsl, "):
        prove([(MODEL, replace(by_hand("cpp"), language="cobol"))], 100)


def test_the_table_shows_every_language_the_devices_and_what_failed():
    broken = changed("msl", r"0\.0724882", "0.0734882")
    steps = []
    proofs = prove([(MODEL, by_hand("cpp")), (MODEL, broken)], 500, progress=steps.append)
    text = table(proofs)
    head, *lines = text.splitlines()
    assert head.split() == ["model", "cpp", "msl"]
    assert re.match(r"eon +eval +\d\.\de-0\d +\d\.\de-0\d!$", lines[0])
    assert "cpp: processor, g++" in text
    assert "msl: processor, g++ with a stand-in for Metal" in text
    assert "Tolerance for cpp, msl: the processor's arithmetic" in text
    assert "FAILED eon in msl: eval is off in" in text
    assert "roughness=" in text
    assert "FAILED eon in cpp" not in text
    assert any("cpp: compiling" in step for step in steps)


def test_random_numbers_of_the_rows_reach_both_ends():
    """Independent of the rows' own constants: those that other tests use."""
    u = rows_for(MODEL, MEMBERS, COUNT)[:, 6:8]
    for value in (RANDOM[0], RANDOM[-1]):
        assert (u == np.float32(value)).any()


def test_hand_written_eon_agrees_where_published_listings_break():
    """The directions of tests/support, which know nothing of the proof's rows."""
    wi, wo = adversarial_pairs()
    count = len(wi)
    rows = np.concatenate([wi, wo, np.full((count, 2), 0.5), np.full((count, 4), 0.7)], 1)
    rows = rows.astype(np.float32)
    (outputs,) = RUNNERS["cpp"]([by_hand("cpp")], [rows]).outputs
    for function in ("eval", "pdf", "albedo"):
        got = split(ENTRY, outputs)[function]
        expected = judge.expect(MODEL, ENTRY, function, rows)
        verdict = judge.judge(MODEL, ENTRY, function, rows, got, judge.NATIVE, expected)
        assert not verdict.failure, verdict


def test_a_device_that_was_not_measured_is_said_to_be_so():
    measured = judge.device_for("wgsl", "llvmpipe (LLVM 15.0.6, 256 bits)")
    assert measured == judge.LLVMPIPE
    other = judge.device_for("wgsl", "Radeon")
    assert other.factor == measured.factor
    assert other.reason.endswith("; not measured on Radeon")
    assert judge.device_for("cpp", "processor, g++") == judge.NATIVE
