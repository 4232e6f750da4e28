"""Exported shaders beside hand-written ones: that the comparison is fair, and what it finds.

Accuracy is measured on whatever OpenGL runs on here, which without a GPU is Mesa's llvmpipe.
"""

from __future__ import annotations

from dataclasses import replace

import mpmath
import numpy as np
import pytest
from support.tolerances import SINGLE

from gonio.bench import command, shader_times, shaders
from gonio.bench.shaders import Arc, Length, accuracy, handwritten, length
from gonio.export.entry import Export
from gonio.export.prove import tools
from gonio.export.prove.opengl import run_glsl
from gonio.export.prove.tools import ProofError

NAMES = tuple(shaders.subjects())

# Relative error that is allowed where the rounding of the inputs changes the value by less than 1e-6: some
# fifty roundings of a float32, and llvmpipe's log, exp and pow, which are off by 1e-6 and more.
WELL_CONDITIONED = 1e-5

# Errors of two correct shaders differ by chance: this much of one may be more than the other.
CHANCE = 1.5


@pytest.fixture(scope="module")
def errors():
    """Of the exported and the hand-written shader of each model."""
    return {
        name: accuracy(model, [shaders.exported(name), handwritten(name)])[0]
        for name, model in shaders.subjects().items()
    }


def with_source(shader: Export, old: str, new: str) -> Export:
    assert shader.source.count(old) == 1
    return replace(shader, source=shader.source.replace(old, new))


# ------------------------------------------------------------------------------------------- accuracy


@pytest.mark.parametrize("name", NAMES)
def test_hand_written_shaders_compute_the_model(name, errors):
    by_hand = errors[name][1]
    assert by_hand.worst < WELL_CONDITIONED
    # Half of the values are within some roundings of a float32
    assert by_hand.median < 5e-7


@pytest.mark.parametrize("name", NAMES)
def test_exported_shaders_are_as_accurate_as_hand_written_ones(name, errors):
    exported, by_hand = errors[name]
    assert exported.worst < WELL_CONDITIONED
    assert exported.median < CHANCE * by_hand.median
    assert exported.high < CHANCE * by_hand.high


def reflected(cosine: float, eta: float, k: float) -> float:
    """Fresnel's equations for a conductor."""
    with mpmath.workdps(50):
        c, n = mpmath.mpf(cosine), mpmath.mpc(eta, k)
        g = mpmath.sqrt(n * n - 1 + c * c)
        s, p = (c - g) / (c + g), (n * n * c - g) / (n * n * c + g)
        return float((abs(s) ** 2 + abs(p) ** 2) / 2)


def test_a_metal_needs_its_trace_where_its_index_is_that_of_air_and_light_grazes():
    """What F of metals has and engines' does not: without, by hand, F is off by its own size."""
    by_hand = handwritten("torrance_sparrow")
    plain = shaders.plain("torrance_sparrow")
    assert plain is not None
    mu, k = (float(np.float32(v)) for v in (1e-9, 1e-18))
    row = np.array([[1, 0, mu, -1, 0, mu, 0.5, 0.5, 1, 0, 1, 1, 1, k, k, k]], np.float32)
    exported = shaders.exported("torrance_sparrow")
    ran = run_glsl([exported, by_hand, plain], [row] * 3)
    # alpha = 1, and h = z: f = F D V with D = 1 / pi and V = 1 / (4 mu)
    F = np.array([output[0, 0] for output in ran.outputs]) * 4 * np.pi * mu
    expected = reflected(mu, 1, k + 1e-17)  # with the trace of absorption that all metals have
    np.testing.assert_allclose(F[:2], expected, rtol=WELL_CONDITIONED)
    assert abs(F[2] / expected - 1) > 0.5


@pytest.mark.parametrize(
    ("name", "old", "new"),
    [
        ("eon", "0.2877934092", "0.2878934092"),  # C1, 0.03 % off
        ("torrance_sparrow", "(eta + 1.0) - k * k", "(eta + 1.0) + k * k"),
        ("disney", "2.0 * F_ss90 - 0.5", "2.0 * F_ss90 - 0.4999"),
        ("weidlich_wilkie", "T * (lost + G * T)", "T * lost"),  # light lost at the way up
        ("phong", "y2 * (1.0 / 5.0 +", "y2 * (1.0 / 4.0 +"),
        ("triace_blinn_phong", "y2 * (1.0 / 3.0 +", "y2 * (1.0 / 2.9 +"),
    ],
)
def test_a_wrong_hand_written_shader_is_noticed(name, old, new):
    wrong = with_source(handwritten(name), old, new)
    (found,), _ = accuracy(shaders.subjects()[name], [wrong], 4000)
    assert found.worst > WELL_CONDITIONED


def test_a_shader_that_makes_nan_is_noticed():
    wrong = with_source(handwritten("eon"), "max(1.0 - mu * mu, 0.0)", "(0.5 - mu * mu)")
    (found,), _ = accuracy(shaders.subjects()["eon"], [wrong], 1000)
    assert found.worst == np.inf


def test_a_shader_that_does_not_compile_is_an_error_with_its_line():
    wrong = with_source(handwritten("eon"), "float A = ", "vec3 A = ")
    with pytest.raises(ProofError, match=r"line \d+: vec3 A = "):
        length(wrong)


# --------------------------------------------------------------------------------------------- length


def test_an_export_with_one_more_guard_is_longer():
    shader = shaders.exported("eon")
    guarded = with_source(shader, "s / max(wi.z, wo.z)", "s / max(max(wi.z, wo.z), 1.0e-18)")
    assert length(guarded).instructions > length(shader).instructions


def written(body: str) -> Export:
    """EON's names with another body."""
    shader = shaders.exported("eon")
    return replace(
        shader,
        source="struct Eon {\n    vec3 rho;\n    float roughness;\n};\n"
        f"vec3 eon_eval(Eon params, vec3 wi, vec3 wo) {{\n{body}\n}}\n",
    )


@pytest.mark.parametrize(
    ("body", "instructions", "operations"),
    [
        ("return vec3(0.0);", 0, 0),
        ("return params.rho;", 0, 0),  # reading and writing belong to the harness
        ("return params.rho.zyx;", 0, 0),
        ("return wi + wo;", 1, 3),
        ("return params.rho * wi.x;", 1, 3),
        ("return vec3(wi.x * wo.x);", 1, 1),
        ("return vec3(dot(wi, wo));", 1, 5),
        ("return vec3(length(wi));", 1, 6),
        ("return normalize(wi);", 1, 9),
        ("return vec3(sqrt(wi.x) + exp(wo.x));", 3, 3),
        ("if (wi.z > 0.0) { return wi + wo; }\nreturn vec3(0.0);", 3, 5),  # compare, branch, add
        # What a loop repeats counts once: compare, branch, next i, multiply and add
        ("vec3 w = wi;\nfor (int i = 0; i < 3; ++i) { w = w * wo + params.rho; }\nreturn w;", 4, 6),
    ],
)
def test_instructions_of_short_shaders_are_counted_as_by_hand(body, instructions, operations):
    assert length(written(body)) == Length(instructions, operations)


def test_a_shader_that_computes_more_is_longer():
    shader = handwritten("eon")
    twice = with_source(
        shader, "float eon_lost(float mu) {", "float eon_lost(float mu) {\n    mu = exp(log(mu));"
    )
    # In each of two calls
    assert length(twice).instructions == length(shader).instructions + 4


def test_what_the_harness_computes_is_not_counted(monkeypatch):
    shader = handwritten("eon")
    honest = length(shader)
    plain = shaders._harness

    def busy(shader):
        text = plain(shader)
        return text.replace("made[row] =", "made[row] = sqrt(float(row)) +")

    monkeypatch.setattr(shaders, "_harness", busy)
    # The sum of two vectors is one more; root and conversion are in the constant shader as well
    assert length(shader).instructions - honest.instructions <= 1


def test_a_harness_that_is_not_subtracted_is_noticed(monkeypatch):
    monkeypatch.setattr(shaders, "_constant", lambda shader: shader)
    assert length(written("return wi + wo;")) != Length(1, 3)


# ----------------------------------------------------------------------------------------------- time


def test_a_slower_shader_takes_longer():
    shader = handwritten("eon")
    slow = with_source(
        shader,
        "float eon_lost(float mu) {",
        "float eon_lost(float mu) {\n    for (int i = 0; i < 100; ++i) { mu = cos(acos(mu)); }",
    )
    (quick, slower), device = shader_times.eval_times(shaders.subjects()["eon"], [shader, slow], 3)
    assert device
    assert 0 < 2 * quick < slower


def test_arc_functions_of_exported_code_keep_the_digits_of_a_float32():
    ways = [arc for arc in shaders.arcs() if arc.way == "polynomial"]
    assert [arc.name for arc in ways] == ["acos", "asin"]
    wrong = replace(ways[0], body=f"{ways[0].body} + 2e-6")
    x = shaders.arguments(4096)
    found, _ = shader_times.arc_values_and_times([*ways, wrong], x, 1)
    (cosine, _), (sine, _), (off, _) = found
    exact = np.arccos(x.astype(np.float64))
    # Four roundings of values up to pi
    assert np.abs(cosine - exact).max() < 1e-6
    assert np.abs(off - exact).max() > 1e-6
    np.testing.assert_allclose(sine, np.arcsin(x.astype(np.float64)), rtol=SINGLE)


def test_the_time_of_an_arc_function_is_that_of_one_call():
    """Ten times the work takes more than twice the time: the function is measured, not the memory."""
    light = Arc("acos", "light", "x * x", "")
    heavy = Arc("acos", "heavy", " + ".join(f"acos(x * {0.1 * k:.1f})" for k in range(1, 10)), "")
    found, _ = shader_times.arc_values_and_times([light, heavy], shaders.arguments(1 << 15), 3)
    assert found[1][1] > 2 * found[0][1]


# -------------------------------------------------------------------------------------------- section


def test_the_sections_have_a_row_for_each_model_and_each_way(monkeypatch):
    monkeypatch.setattr(shaders, "ACCURACY_ROWS", 256)
    monkeypatch.setattr(shader_times, "PAIRS", 1 << 12)
    section, arcs = shaders.shader_sections(1, lambda text: None)
    assert [row["row"] for row in section.rows] == list(NAMES)
    assert [(row["row"], row["way"]) for row in arcs.rows] == [
        ("acos", "builtin"),
        ("acos", "polynomial"),
        ("asin", "builtin"),
        ("asin", "polynomial"),
    ]
    for found in (section, arcs):
        keys = {column.key for column in found.columns}
        assert all(keys <= set(row) for row in found.rows)
        assert found.markdown().count("\n|") == len(found.rows) + 2


@pytest.mark.parametrize("tool", ["glslangValidator", "spirv-opt", "moderngl"])
def test_a_missing_tool_is_named_in_one_line(tool, monkeypatch):
    locate = tools.locate
    monkeypatch.setattr(tools, "locate", lambda name: None if name == tool else locate(name))
    with pytest.raises(ProofError) as raised:
        shaders.shader_sections(1, lambda text: None)
    assert str(raised.value).startswith(f"{tool} is not installed")
    assert "\n" not in str(raised.value)


def test_the_bench_knows_the_shaders():
    assert "shaders" in command.SECTIONS
