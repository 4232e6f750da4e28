"""The translator: what it keeps, what it refuses, and that its texts are those in tests/golden."""

from __future__ import annotations

import ast
import inspect
import itertools
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st

import gonio
from gonio import lang
from gonio.cli import main
from gonio.export import ExportError, export
from gonio.export import targets as target_tables
from gonio.export.comments import WIDTH as COMMENT_WIDTH
from gonio.export.comments import comment
from gonio.export.files import texts
from gonio.export.print_expressions import number
from gonio.export.selection import choose
from gonio.export.source import source
from gonio.export.targets import TARGETS
from gonio.export.vocabulary import RULES
from gonio.fields import ModelError
from gonio.materials import library, load_material
from gonio.materials.model_file import load
from gonio.model import Model

GOLDEN = Path(__file__).parent / "golden"
LANGUAGES = list(TARGETS)


def text(model: str | Model, to: str, **settings: Any) -> str:
    made = gonio.model(model) if isinstance(model, str) else model
    return export({made.name: made}, to, **settings)[0].source


def written(tmp_path: Path, body: str, fields: str = "", head: str = "") -> Model:
    """A user's own model, from a file outside the package."""
    path = tmp_path / "mine.py"
    path.write_text(
        '"""Mine: a model of my own."""\n'
        "from gonio.lang import *\n"
        "from gonio.lang import Color, Float, Sample, Vec2, Vec3\n"
        "from gonio.model import Model, option, param\n"
        "from gonio.parts.hemisphere import pdf_cosine, sample_cosine\n"
        f"{head}\n\n\n"
        "class Mine(Model):\n"
        '    """Mine."""\n\n'
        '    rho: Color = param((0.8, 0.8, 0.8), 0, 1, "albedo")\n'
        '    width: Float = param(0.5, 0, 1, "a number")\n'
        f"{fields}\n"
        "    def eval(self, wi: Vec3, wo: Vec3) -> Color:\n"
        f"{body}\n"
        "    def sample(self, wo: Vec3, u: Vec2) -> Sample:\n"
        "        wi = sample_cosine(u)\n"
        "        return Sample(wi, pdf_cosine(wi))\n\n"
        "    def pdf(self, wi: Vec3, wo: Vec3) -> Float:\n"
        "        return pdf_cosine(wi)\n",
        encoding="utf-8",
    )
    return load(path)()


# --- what an export contains -----------------------------------------------------------------------


@pytest.mark.parametrize("name", gonio.models())
def test_golden_exports_are_what_the_command_makes(name: str) -> None:
    # cuda differs from cpp by its qualifiers only, which another test compares.
    made = texts({name: gonio.model(name)}, [t for t in LANGUAGES if t != "cuda"])
    for file, expected in made.items():
        found = (GOLDEN / file).read_text(encoding="utf-8")
        assert found == expected, f"tests/golden/{file} is not up to date; 'make golden' makes it"


def test_each_heading_of_a_text_stands_once() -> None:
    for path in sorted(GOLDEN.iterdir()):
        text = path.read_text(encoding="utf-8")
        headings = re.findall(r"^\s*// ---- (\w+) -", text, re.M)
        assert headings == sorted(set(headings), key=["evaluation", "sampling", "albedo"].index), (
            path
        )


@pytest.mark.parametrize("name", gonio.models())
def test_comments_name_only_what_stands_in_the_text(name: str) -> None:
    """By the names that it has there, or a model, a module, or an option of this model."""
    for target in TARGETS.values():
        if target.name == "cuda":
            continue
        assert unknown_names((GOLDEN / f"{name}.{target.extension}").read_text("utf-8")) == set()


def unknown_names(source: str) -> set[str]:
    """Names in quotes of the comments that are in the code of the text under no such name."""
    lines = [line.partition("//") for line in source.splitlines()]
    code = "\n".join(before for before, _, _ in lines)
    said = " ".join(comment for _, _, comment in lines)
    there = {*re.findall(r"\w+", code), *re.findall(r"'(\w+)'", said), *gonio.models()}
    names = re.findall(r"`([^`]+)`", said)
    return {n for n in names if n not in there and not n.startswith("gonio.")}


def test_a_struct_of_results_names_the_function_that_returns_it() -> None:
    found = 0
    for path in GOLDEN.glob("*.glsl"):
        source = path.read_text("utf-8")
        for name, struct in re.findall(r"// What (\w+) returns\.\nstruct (\w+) ", source):
            assert f"\n{struct} {name}(" in source
            found += 1
    assert found > 5


def test_a_comment_that_names_what_is_elsewhere_is_noticed() -> None:
    assert unknown_names("// As `b` and `a`\nfloat a;  // see `c`") == {"b", "c"}


def test_no_line_of_code_is_wider_than_the_page() -> None:
    # What stands in a struct is folded before it is indented
    wide = {
        (path.name, line)
        for path in sorted(GOLDEN.iterdir())
        if path.suffix != ".slang"
        for line in path.read_text("utf-8").splitlines()
        if len(line) > 100 and "//" not in line
    }
    assert {
        line for _, line in wide if "float3(condition.x" not in line and "Vec3{fminf" not in line
    } == set()


def test_golden_has_no_file_of_a_model_that_is_gone() -> None:
    made = {
        f"{name}.{target.extension}"
        for name in gonio.models()
        for target in TARGETS.values()
        if target.name != "cuda"
    }
    assert {p.name for p in GOLDEN.iterdir()} == made


def test_the_webgpu_example_has_the_golden_export() -> None:
    page = (GOLDEN.parents[1] / "examples" / "webgpu.html").read_text(encoding="utf-8")
    export_text = (GOLDEN / "eon.wgsl").read_text(encoding="utf-8")
    assert f"begin of the export\n{export_text}// ---- end" in page, "'make golden' makes it"


@pytest.mark.parametrize("name", gonio.models())
def test_cuda_is_the_c_plus_plus_text_with_qualifiers(name: str) -> None:
    cuda = text(name, "cuda").replace("__host__ __device__ inline", "inline")
    # Long lines are folded elsewhere, long comments as well
    words = cuda.replace("CUDA C++", "C++").replace("//", "").split()
    assert words == text(name, "cpp").replace("//", "").split()


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_function_and_type_of_an_export_begins_with_its_prefix(language: str) -> None:
    found = text("weidlich_wilkie", language)
    functions = re.findall(r"^(?:fn |inline |__\w+__ )*(?:\w+ )?(\w+)\(.*\{$", found, re.M)
    free = [f for f in functions if f not in ("if", "for", "Vec3")]
    if language not in ("cpp", "cuda"):  # those have a namespace for their vectors
        assert free
        assert all(f.startswith("weidlich_wilkie") for f in free if f != "inline")
    types = re.findall(r"^(?:struct|interface) (\w+)", found, re.M)
    assert {"WeidlichWilkie", "WeidlichWilkieBase", "WeidlichWilkieSample"} <= set(types)
    vectors = {"Vec2", "Vec3", "Bool3"}
    assert all("WeidlichWilkie" in t for t in set(types) - vectors)


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize("name", ["eon", "disney", "weidlich_wilkie"])
def test_an_export_has_no_globals_no_macros_and_ascii_only(name: str, language: str) -> None:
    found = text(name, language)
    assert found.isascii()
    allowed = (
        "#pragma once",
        "#include <math.h>",
        "#include <metal_stdlib>",
        "using namespace metal;",
    )
    for line in found.splitlines():
        assert not line.startswith("#") or line in allowed
        assert not re.match(r"(const|static|let|var|float|vec3|uniform)\b.*[=;]$", line), line


def test_names_comments_and_docstrings_survive() -> None:
    found = text("eon", "wgsl")
    for kept in (
        "arXiv:2410.18026",
        "// With 1 - s = mu^2 / (1 + s) every term of Eq. 13 that cancels against C1 can be collected",
        "let t = mu / (1.0 + s);  // tan(asin(mu) / 2)",
        "fn eon_loss_exact(mu: f32) -> f32 {",
        "const C1 = 0.2877934;  // A_F = 1 / (1 + C1 r)",
        "// (1 - E_i)(1 - E_o) / (1 - <E>) / pi, of which r^2 A_F^2 / (r A_F) remains",
        "roughness: f32,  // unitless r; not the Oren-Nayar angle sigma; 0 to 1, default 0.5",
        "made by gonio from gonio/models/eon.py",
    ):
        assert kept in found


@pytest.mark.parametrize("name", gonio.models())
def test_no_comment_of_an_exported_function_is_lost(name: str) -> None:
    """Functions with conditions on options keep those of the chosen branch only; they are left out."""
    model = gonio.model(name)
    found = " ".join(re.sub(r"[^\x20-\x7e]|//", " ", text(model, "glsl")).split())
    file = source(str(inspect.getsourcefile(model.written)))
    for node in ast.walk(file.tree):
        if not isinstance(node, ast.FunctionDef) or f"_{node.name.strip('_')}(" not in found:
            continue
        if any(isinstance(n, ast.If) for n in ast.walk(node)):
            continue
        for line in range(node.lineno, (node.end_lineno or 0) + 1):
            if line in file.comments and file.comments[line].text.isascii():
                assert " ".join(file.comments[line].text.split()) in found


def test_comments_inside_expressions_and_branches_are_kept(tmp_path: Path) -> None:
    body = (
        "        # above\n"
        "        a = (\n"
        "            self.width  # inside one\n"
        "            # inside two\n"
        "            + 1\n"
        "        )\n"
        "        if self.form == 'round':  # at the condition\n"
        "            b = a * 2  # beside\n"
        "            # below, in the branch\n"
        "        else:\n"
        "            # not taken\n"
        "            b = a\n"
        "        return self.rho * b\n"
        "        # at the end\n"
    )
    model = written(tmp_path, body, fields='    form: str = option("round", "flat", doc="x")\n')
    found = text(model, "glsl")
    for kept in (
        "above",
        "inside one",
        "inside two",
        "at the condition",
        "beside",
        "below, in the branch",
        "at the end",
    ):
        assert f"// {kept}" in found, kept
    assert "not taken" not in found
    other = text(model.replace(form="flat"), "glsl")
    assert "// not taken" in other
    assert "below, in the branch" not in other
    assert "beside" not in other


def test_only_the_chosen_branch_of_an_option_is_exported() -> None:
    exact, fitted = text("eon", "glsl"), text(gonio.model("eon", albedo_form="fitted"), "glsl")
    assert "eon_loss_exact" in exact
    assert "eon_loss_fitted" not in exact
    assert "eon_loss_fitted" in fitted


def test_only_what_is_asked_for_is_exported() -> None:
    found = text("eon", "glsl", only=["eval"])
    assert "eon_eval" in found
    for absent in ("eon_sample", "eon_pdf", "eon_albedo", "EonSample", "EonCoefficients"):
        assert absent not in found


def test_several_models_share_their_parts_once() -> None:
    models = {name: gonio.model(name) for name in ("eon", "fon", "lambert")}
    exports = export(models, "glsl")
    assert len({e.source for e in exports}) == 1
    found = exports[0].source
    assert found.count("float gonio_tangential_dot(") == 1
    assert "struct GonioSample" in found
    assert "vec3 eon_eval(Eon params" in found
    assert "vec3 fon_eval(Fon params" in found


def test_a_file_that_has_changed_is_read_again(tmp_path: Path) -> None:
    before = text(written(tmp_path, "        return self.rho * 0.25\n"), "glsl")
    after = text(
        written(tmp_path, "        x = wi.z\n        return self.rho * (0.5 * x)\n"), "glsl"
    )
    assert "params.rho * 0.25" in before
    assert "params.rho * (0.5 * x)" in after


def test_two_models_may_have_private_functions_of_the_same_name() -> None:
    models = {name: gonio.model(name) for name in ("ue4", "unity_standard", "disney")}
    found = export(models, "wgsl")[0].source
    names = re.findall(r"^fn (\w+)\(", found, re.M)
    assert len(names) == len(set(names))


def test_a_function_for_numbers_and_colours_is_exported_for_both(tmp_path: Path) -> None:
    body = "        return twice(self.rho) * twice(self.width)\n"
    head = "\n\ndef twice(x: Float) -> Float:\n    return x + x\n"
    found = text(written(tmp_path, body, head=head), "wgsl")
    assert "fn mine_twice(x: vec3f) -> vec3f" in found
    assert "fn mine_twice_scalar(x: f32) -> f32" in found


def test_embedding_writes_the_parameters_of_a_material() -> None:
    chosen = choose(["orange_lacquer"])
    found = export(chosen.models, "hlsl", embed=True)[0].source
    assert "OrangeLacquer orange_lacquer_material() {" in found
    model = chosen.models["orange_lacquer"]
    for path, declared, value in model.parameters():
        if "mirror" in path:  # of coats that absorb, which this is not
            assert f"material.{path} = " not in found
            continue
        numbers = value if isinstance(value, tuple) else (value,) * declared.width
        printed = ", ".join(number(v, "") for v in numbers)
        shown = f"float3({printed})" if declared.width == 3 else printed
        assert f"material.{path} = {shown};" in found


def test_slang_has_methods_behind_an_interface() -> None:
    found = text("eon", "slang")
    assert "interface IEonBrdf : IDifferentiable {" in found
    assert "struct Eon : IEonBrdf {" in found
    assert "float3 eval(float3 wi, float3 wo) {" in found


def test_wgsl_selects_and_glsl_asks() -> None:
    assert "select(1.0, wo.x * inv, tilted)" in text("eon", "wgsl")
    assert "tilted ? wo.x * inv : 1.0" in text("eon", "glsl")
    assert "tilted ? wo.x * inv : 1.0" in text("eon", "hlsl")
    assert " ? " not in re.sub(r"//.*", "", text("disney", "wgsl"))


@pytest.mark.parametrize("language", LANGUAGES)
def test_words_of_the_language_are_not_used_as_names(tmp_path: Path, language: str) -> None:
    target = TARGETS[language]
    word = "half" if "half" in target.reserved else "double"
    assert word in target.reserved
    found = text(
        written(tmp_path, f"        {word} = 2 * self.width\n        return self.rho * {word}\n"),
        language,
    )
    assert not re.search(rf"\b{word}\b(?!_)", re.sub(r"//.*", "", found))
    assert f"{word}_" in found


def test_methods_of_the_class_above_stand_beside_those_that_replace_them(tmp_path: Path) -> None:
    path = tmp_path / "dimmed.py"
    path.write_text(
        '"""EON, dimmed twice."""\n'
        "from gonio.lang import Color, Vec3\n"
        "from gonio.models.eon import EON\n\n\n"
        "class Dimmed(EON, register=False):\n"
        '    """Dimmed."""\n\n'
        "    def eval(self, wi: Vec3, wo: Vec3) -> Color:\n"
        "        return 0.5 * super().eval(wi, wo) + 0.25 * EON.eval(self, wi, wo)\n\n"
        "    def _loss(self, mu):\n"
        "        return 2 * super()._loss(mu)\n",
        encoding="utf-8",
    )
    model = choose([str(path)]).models["dimmed"]
    for language, call in (
        ("glsl", "dimmed_eon_eval(params, wi, wo)"),
        ("slang", "this.eon_eval(wi, wo)"),
    ):
        found = text(model, language)
        assert f"return 0.5 * {call} + 0.25 * {call};" in found
        assert "2.0 * " in found
    again = text(model, "glsl")
    assert "float dimmed_loss(float mu) {" in again
    assert "return 2.0 * dimmed_loss_exact(mu);" in again  # what EON's own passes on to


def test_names_that_the_text_needs_itself_are_changed(tmp_path: Path) -> None:
    body = (
        "        result = 2 * self.width\n"
        "        max = maximum(result, wi.z)\n"
        "        i_step = max\n"
        "        for i in range(2):\n"
        "            i_step = i_step + i\n"
        "        return self.rho * i_step\n"
    )
    found = text(written(tmp_path, body), "glsl")
    assert "float max_ = max(result, wi.z);" in found
    assert "for (int i_step_ = 0;" in found
    body = "        return self.rho * several(wi.z)\n"
    head = (
        "\n\ndef pair(x: Float):\n    result = x * 2\n    return result, x\n"
        "\n\ndef several(x: Float) -> Float:\n    a, b = pair(x)\n    return a + b\n"
    )
    found = text(written(tmp_path, body, head=head), "hlsl")
    assert "MinePair result_;" in found
    assert "result_.result = result;" in found


# --- the vocabulary --------------------------------------------------------------------------------


def test_every_function_of_the_vocabulary_has_a_rule_and_a_spelling() -> None:
    functions = {
        name
        for name, value in vars(lang).items()
        if inspect.isfunction(value)
        and value.__module__ == lang.__name__
        and not name.startswith("_")
    }
    assert functions == set(RULES)
    special = {
        "select",
        "vec2",
        "vec3",
        "safe_sqrt",
        "smooth_sqrt",
        "polynomial",
    }  # the exporter knows these by name
    for target in TARGETS.values():
        missing = functions - special - set(target.spellings) - target.library
        assert missing <= {"fma"}  # which is a product and a sum where it is missing
        assert not set(target.spellings) - functions


def test_the_page_on_the_language_names_all_of_the_vocabulary() -> None:
    page = (Path(__file__).parents[1] / "docs" / "language.md").read_text(encoding="utf-8")
    for name in [*RULES, *(n for n in vars(lang) if n.isupper() and len(n) > 1)]:
        assert f"`{name}" in page, name


def test_a_polynomial_has_the_terms_that_single_precision_needs(tmp_path: Path) -> None:
    """Of exp(x) - 1 over x, up to 1e-2: x^2 / 6 is 2e-5 at most, x^3 / 24 4e-8, x^4 / 120 8e-11."""
    body = "        return self.rho * polynomial(wi.z, 0.01, 1, *LATER)\n"
    head = "LATER = (1 / 2, 1 / 6, 1 / 24, 1 / 120, 1 / 720)"
    found = text(written(tmp_path, body, head=head), "glsl")
    wanted = "1.0 + wi.z * (0.5 + wi.z * (0.16666667 + wi.z * 0.041666668))"
    assert wanted in found


@pytest.mark.parametrize(
    ("value", "printed"),
    [
        (1, "1.0"),
        (0.1, "0.1"),
        (1e-18, "1.0e-18"),
        (-2.5, "-2.5"),
        (1 / 3, "0.33333334"),
        (16777216, "1.6777216e7"),
    ],
)
def test_numbers_are_the_shortest_that_a_float32_keeps(value: float, printed: str) -> None:
    assert number(value, "") == printed
    assert np.float32(printed) == np.float32(value)


@pytest.mark.parametrize("value", [1e39, 1e-60, float("nan"), float("inf")])
def test_numbers_that_float32_has_not_are_refused(value: float) -> None:
    with pytest.raises(ExportError, match="float32"):
        number(value, "")


# --- what is refused -------------------------------------------------------------------------------

REFUSED = [
    (
        "        return self.rho * np.sin(wi.z)",
        "not in the vocabulary",
        "np.sin",
        "import numpy as np",
    ),
    ("        return self.rho * abs(wi.z)", "write absolute(x)", "abs", ""),
    (
        "        if wi.z > 0.5:\n            return self.rho\n        return self.rho",
        "select",
        "wi.z > 0.5",
        "",
    ),
    ("        return self.rho if wi.z > 0.5 else 0 * self.rho", "select", "self.rho if", ""),
    ("        return self.rho * wi[2]", "v.x, v.y", "wi[2]", ""),
    ("        return self.rho * wi.w", "has no 'w'", "wi.w", ""),
    ("        return self.rho * self.wdith", "has no 'wdith'", "self.wdith", ""),
    ("        x = [1, 2]\n        return self.rho", "variables, vec2 and vec3", "[1, 2]", ""),
    (
        "        return self.rho * wi.z ** self.width",
        "power(x, exponent)",
        "wi.z ** self.width",
        "",
    ),
    ("        return self.rho * (wi.z // 1)", "// is for numbers", "wi.z // 1", ""),
    ("        while True:\n            return self.rho", "for i in range", "while True", ""),
    (
        "        x = 1\n        x = vec3(1, 2, 3)\n        return self.rho",
        "a vec3 where a number",
        "x = vec3",
        "",
    ),
    ("        wi = wo\n        return self.rho", "argument wi", "wi = wo", ""),
    ("        return self.rho * select(self.width, 1, 0)", "select's condition", "select(", ""),
    ("        return self.rho * dot(wi, 1, 2)", "2 arguments are expected", "dot(", ""),
    ("        return vec3(1, 2)", "'z' missing", "vec3(1, 2)", ""),
    ("        return self.rho * (not wi.z)", "~", "not wi.z", ""),
    ("        return self.rho * (wi.z > 0 and wo.z > 0)", "&", "wi.z > 0 and wo.z > 0", ""),
    (
        "        return self.rho * again(wi.z)",
        "calls itself",
        "",
        "\n\ndef again(x: Float) -> Float:\n    return again(x)\n",
    ),
    ("        return self.rho * f(wi.z)", "write it with 'def'", "", "f = lambda x: x"),
    ("        pass", "without a result", "def eval", ""),
    ("        return wi, wo", "where a vec3 is expected", "return wi, wo", ""),
    ("        self.width = 2\n        return self.rho", "only a name", "self.width", ""),
    ("        return self.rho * f'{wi.z}'", "a shader has no text", "f'{wi.z}'", ""),
    (
        "        x = 0\n        for i in (1, 2):\n            x = x + i\n        return self.rho",
        "range",
        "for i",
        "",
    ),
    (
        "        for i in range(self.width):\n            x = i\n        return self.rho",
        "known when",
        "self.width",
        "",
    ),
    ("        a, b = wi, wo, wo\n        return self.rho", "2 names for 3", "a, b =", ""),
    ("        return self.rho + wi.z > 0", "where a vec3 is expected", "return", ""),
    ("        'text'\n        'more'\n        return self.rho", "comment", "'more'", ""),
    ("        params = 2\n        return self.rho * params", "use another name", "params = 2", ""),
    ("        \u03b1 = 2\n        return self.rho * \u03b1", "English alphabet", "\u03b1 = 2", ""),
    ("        a__b = 2\n        return self.rho * a__b", "English alphabet", "a__b = 2", ""),
    ("        return self.rho * vec2(1, 2)", "a pair of numbers", "self.rho * vec2", ""),
    (
        "        return self.rho * polynomial(wi.z * wo.z, 1, 1, 2)",
        "a name first",
        "wi.z * wo.z",
        "",
    ),
    ("        return self.rho * polynomial(wi.z, 1, 1)", "polynomial(x, bound", "polynomial(", ""),
    ("        return self.rho * polynomial(wi.z, 1, wo.z, 2)", "not variables", "polynomial(", ""),
    ("        return self.rho * polynomial(wi, 1, 1, 2)", "cannot take a vec3", "polynomial(", ""),
    ("        return self.rho * polynomial(wi.z, 1, *wo, 2)", "a star is for", "*wo", ""),
    ("        return self.rho * dot(vec2(1, 2), vec2(1, 2))", "cannot take a vec2", "dot(", ""),
]


@pytest.mark.parametrize(("body", "message", "marked", "head"), REFUSED)
def test_what_cannot_be_exported_is_refused_with_its_place(
    tmp_path: Path, body: str, message: str, marked: str, head: str
) -> None:
    model = written(tmp_path, body + "\n", head=head)
    with pytest.raises(ExportError) as caught:
        text(model, "glsl")
    told = str(caught.value)
    assert message in told
    path, line = re.match(r"(.+?\.py):(\d+)", told).groups()  # type: ignore[union-attr]
    assert Path(path).parent == tmp_path
    shown = Path(path).read_text(encoding="utf-8").splitlines()[int(line) - 1]
    if marked:
        lines = told.splitlines()
        assert lines[-2] == shown.rstrip()
        start = len(lines[-1]) - len(lines[-1].lstrip())
        assert set(lines[-1].strip()) == {"^"}
        assert shown[start:].startswith(marked.split("\n")[0].rstrip()) or marked in shown


def test_a_struct_that_is_made_of_its_own_members_is_the_struct_itself(tmp_path: Path) -> None:
    """And what only passes on, or only makes a struct, is not called."""
    head = (
        "from typing import NamedTuple\n\n\n"
        "class Facets(NamedTuple):\n"
        '    """Facets."""\n\n'
        "    x: Float\n    y: Float\n\n"
        "    def at(self, w: Vec3) -> Float:\n"
        '        """`slope` less its bias."""\n'
        "        return self.slope(w) * self.y\n\n"
        "    def slope(self, w: Vec3) -> Float:\n"
        '        """A slope."""\n'
        "        return self.x * w.z + self.y\n\n\n"
        "def made(x: Float, y: Float) -> Facets:\n"
        '    """`Facets` of widths."""\n'
        "    return Facets(x, y)\n\n\n"
        "def again(facets: Facets, w: Vec3) -> Float:\n"
        '    """Passes on."""\n'
        "    return Facets(facets.x, facets.y).at(w)\n\n\n"
        "def turned(facets: Facets, w: Vec3) -> Float:\n"
        '    """Not the same."""\n'
        "    return Facets(facets.y, facets.x).at(w)\n"
    )
    body = (
        "        facets = made(wi.z, wo.z)\n"
        "        return self.rho * (again(facets, wi) + turned(facets, wo))\n"
    )
    found = text(written(tmp_path, body, head=head), "wgsl", only=["eval"])
    assert "mine_made" not in found
    assert "mine_again" not in found
    assert "let facets = MineFacets(wi.z, wo.z);" in found
    assert "MineFacets(facets.y, facets.x)" in found
    # Comments name what the text has
    assert "// mine_facets_slope less its bias." in found


def test_a_loop_over_a_fixed_number_of_steps_is_exported(tmp_path: Path) -> None:
    body = (
        "        total = vec3(0, 0, 0)\n"
        "        for i in range(4):\n"
        "            # each step\n"
        "            total = total + self.rho * i\n"
        "        return total\n"
    )
    found = text(written(tmp_path, body), "wgsl")
    assert "var total = vec3f(0.0);" in found
    assert "for (var i_step = 0; i_step < 4; i_step++) {" in found
    assert "// each step" in found


def test_a_loop_ends_at_its_number_by_name(tmp_path: Path) -> None:
    """Who changes the number in the text changes the loop as well."""
    body = (
        "        total = vec3(0, 0, 0)\n"
        "        for i in range(STEPS):\n"
        "            total = total + self.rho * i / STEPS\n"
        "        return total\n"
    )
    model = written(tmp_path, body, head="STEPS = 7")
    assert "i_step < i32(STEPS);" in text(model, "wgsl")
    assert "i_step < int(STEPS);" in text(model, "glsl")
    assert "i_step < 7; ++i_step) {  // STEPS" in text(model, "slang")
    # A loop alone declares it too
    alone = written(tmp_path, body.replace(" / STEPS", ""), head="STEPS = 7")
    assert "const STEPS = 7.0;" in text(alone, "wgsl")


@given(st.lists(st.text("ab", min_size=1, max_size=12), min_size=2, max_size=60))
def test_no_word_of_a_comment_stands_alone_in_its_last_line(words: list[str]) -> None:
    paragraph = " ".join(words)
    lines = [line.removeprefix("// ") for line in comment((paragraph,))]
    assert " ".join(lines) == paragraph
    assert max(map(len, lines)) <= COMMENT_WIDTH
    assert len(lines) == 1 or len(lines[-1].split()) > 1


@pytest.mark.parametrize("name", ["vec3", "Vec2", "Buffer", "texture2D", "i", "half"])
def test_a_type_is_called_what_no_language_has_a_type_for(name: str) -> None:
    """The same in all of them, as the manifest has one name for it."""
    model = {name: gonio.model("lambert")}
    made = {t: export(model, t, only=["eval"])[0] for t in ("cpp", "hlsl", "slang", "wgsl")}
    (struct,) = {e.entry.struct for e in made.values()}
    assert struct not in {"Vec3", "Vec2", "Buffer", "Texture2D", "I"}
    for found in made.values():
        declared = re.findall(r"(?m)^ *struct (\w+)", found.source)
        assert declared.count(struct) == 1
        assert len(declared) == len(set(declared))


def test_a_half_vector_is_not_made_unit_for_what_is_along_it() -> None:
    """But for languages that take derivatives, which short vectors have none of."""
    model = gonio.model("torrance_sparrow")
    found = export({"m": model}, "hlsl", only=["eval"])[0].source
    assert "D_along(m_facets(params), wi + wo)" in found
    assert "m_half_vector" not in found
    slang = export({"m": model}, "slang", only=["eval"])[0].source
    assert "D(this.facets(), m_half_vector(wi, wo))" in slang
    assert "D_along" not in slang


def test_a_model_without_a_mean_albedo_is_refused_where_it_is_needed() -> None:
    base = gonio.model("torrance_sparrow")
    coated = gonio.model("weidlich_wilkie", base=base, bounces="diffuse")
    with pytest.raises(ExportError, match="closed form of its mean albedo"):
        text(coated, "glsl")


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"to": "glls"}, "did you mean 'glsl'"),
        ({"to": "glsl", "only": ["value"]}, "eval, sample, pdf, albedo"),
        ({"to": "glsl", "prefix": "2d"}, "cannot begin a name"),
        ({"to": "glsl", "prefix": "a__b"}, "cannot begin a name"),
    ],
)
def test_wrong_settings_are_refused(settings: dict[str, Any], message: str) -> None:
    with pytest.raises(ExportError, match=re.escape(message)):
        export({"eon": gonio.model("eon")}, **settings)


def test_osl_holds_one_shader() -> None:
    with pytest.raises(ExportError, match="one shader"):
        export({n: gonio.model(n) for n in ("eon", "fon")}, "osl")


# --- the command -----------------------------------------------------------------------------------


def run(*arguments: str) -> Any:
    return CliRunner().invoke(main, ["export", *arguments])


def test_the_command_prints_one_text() -> None:
    result = run("eon", "--to", "wgsl", "--option", "albedo_form=fitted", "--only", "eval")
    assert result.exit_code == 0
    assert result.stdout == text(gonio.model("eon", albedo_form="fitted"), "wgsl", only=["eval"])


def test_the_command_writes_files_and_says_which(tmp_path: Path) -> None:
    folder = tmp_path / "new"  # which the slash behind it asks for
    result = run("eon", "fon", "--to", "glsl", "--to", "cpp", "-o", f"{folder}/")
    assert result.exit_code == 0
    assert sorted(p.name for p in folder.iterdir()) == ["gonio.glsl", "gonio.h"]
    assert str(folder / "gonio.h") in result.stdout


def test_the_name_of_the_file_says_the_language(tmp_path: Path) -> None:
    result = run("eon", "-o", str(tmp_path / "eon.wgsl"))
    assert result.exit_code == 0
    assert (tmp_path / "eon.wgsl").read_text(encoding="utf-8") == text("eon", "wgsl")
    result = run("eon", "--to", "glsl", "-o", str(tmp_path / "eon.hlsl"))
    assert result.exit_code == 1
    assert "do not agree; leave out --to, or name the file NAME.glsl" in result.stderr
    assert run("eon", "--to", "glsl", "-o", str(tmp_path / "eon.frag")).exit_code == 0


def test_another_name_lets_a_model_be_exported_twice() -> None:
    result = run("eon", "fast=eon:albedo_form=fitted", "--to", "glsl")
    assert result.exit_code == 0
    assert "vec3 fast_eval(Fast params" in result.stdout
    assert "vec3 eon_eval(Eon params" in result.stdout


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["eon"], "add --to"),
        (["--to", "glsl"], "name a model"),
        (["eno", "--to", "glsl"], "did you mean the model 'eon'"),
        (["eon", "eon", "--to", "glsl"], "two exports are called 'eon'"),
        (["eon", "--to", "glsl", "--to", "wgsl", "-o", "one.txt"], "give a folder"),
        (["eon", "--to", "glsl", "-o", "no/such/folder/eon.glsl"], "create it first"),
        (["eon", "--to", "glsl", "-p", "roughness=2"], "out of range"),
        (["--all", "eon", "--to", "glsl"], "take no models"),
        (["eon", "--to", "mtlx"], "give a folder"),
        (["eon", "--to", "mtlx", "--only", "eval", "-o", "./"], "leave out --only"),
        (["eon", "--to", "mtlx", "--prove"], "prove essl"),
    ],
)
def test_wrong_commands_are_answered_with_one_line(
    arguments: list[str], message: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    result = run(*arguments)
    assert result.exit_code == 1
    assert message in result.stderr
    assert len(result.stderr.strip().splitlines()) == 1
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["eon", "--to", "cpp", "--prove", "--embed", "-o", "x.h"], "--embed and --output"),
        (["eon", "--to", "cpp", "--prove", "--prefix", "shared"], "leave out --prefix"),
        (["eon", "--to", "cpp", "--rows", "500"], "--rows is for --prove"),
        (["--lit", "ue4", "--to", "cpp"], "name the model before it"),
    ],
)
def test_no_option_is_ignored_in_silence(arguments: list[str], message: str) -> None:
    result = run(*arguments)
    assert result.exit_code == 2
    assert message in result.stderr


def test_a_material_tells_what_the_host_has_to_feed() -> None:
    flaked = next(name for name in library() if load_material(name).flakes)
    result = run(flaked, "--to", "glsl")
    assert result.exit_code == 0
    assert "flake_x and flake_y come from a map of flakes" in result.stderr


def test_every_material_can_be_exported() -> None:
    # Each in one language: all languages have the models themselves above
    for name, language in zip(library(), itertools.cycle(LANGUAGES), strict=False):
        exported = export(choose([name]).models, language)[0]
        paths = [path for path, _, _ in load_material(name).model.parameters()]
        given = [member.path for member in exported.entry.members]
        assert given == [path for path in paths if path in given]
        assert all(
            member.path.split(".")[-1] in exported.source for member in exported.entry.members
        )


def test_unknown_models_are_refused() -> None:
    with pytest.raises(ModelError):
        choose(["no_such_model"])


def test_helpers_are_printed_only_where_they_are_used() -> None:
    assert "operator<" not in text("lambert", "cpp")
    dielectric = gonio.model("torrance_sparrow", fresnel="dielectric")
    assert "Bool3 operator>(" in text(dielectric, "cpp")
    assert target_tables.CPP.helpers["vec3"] in text("lambert", "cpp")
