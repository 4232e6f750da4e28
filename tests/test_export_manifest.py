"""The manifest that describes an export to its host, and the function that loads its parameters."""

from __future__ import annotations

import json
import re
import subprocess
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

import gonio
from gonio.cli import main
from gonio.export import ExportError, export, targets
from gonio.export.manifest import ARRAYS, loader, manifest, manifest_text, refusal, remedy, used
from gonio.export.prove import tools
from gonio.materials import load, load_material
from gonio.model import models


def row(rows: list[dict[str, Any]], path: str) -> dict[str, Any]:
    return next(r for r in rows if r["path"] == path)


@pytest.mark.parametrize("name", list(models()))
def test_a_manifest_has_every_parameter_with_default_and_range(name: str) -> None:
    model = gonio.model(name)
    about = manifest(model, refusals=False)
    json.loads(manifest_text(about))
    declared = {path: d for path, d, _ in model.parameters()}
    assert [p["path"] for p in about["parameters"]] == list(declared)
    for p in about["parameters"]:
        d = declared[p["path"]]
        assert len(p["value"]) == p["width"] == d.width
        assert p["low"] <= p["soft_low"] < p["soft_high"]
        assert p["high"] is None or p["soft_high"] <= p["high"]
        # A slider on a log scale cannot begin at 0
        assert p["scale"] == "linear" or p["soft_low"] > 0
        assert p["doc"] == d.doc


@pytest.mark.parametrize("language", list(targets.TARGETS))
def test_the_names_of_a_manifest_are_in_the_text_of_every_language(language: str) -> None:
    model = gonio.model("weidlich_wilkie", base="eon")
    about = manifest(model, "lacquer", refusals=False)
    text = export({"lacquer": model}, language)[0].source
    assert re.search(rf"struct {about['struct']}\b", text)
    assert re.search(rf"struct {about['sample_struct']}\b", text)
    methods = targets.TARGETS[language].methods
    for function, full in about["functions"].items():
        assert re.search(rf"\b{function if methods else full}\(", text)


# What the field's own terms mean, from the models' declarations.
KINDS = {
    ("eon", "rho"): "reflectance",
    ("eon", "roughness"): "factor",
    ("qon", "sigma"): "angle",
    ("torrance_sparrow", "alpha"): "slope",
    ("torrance_sparrow", "eta"): "index",
    ("torrance_sparrow", "k"): "extinction",
    ("torrance_sparrow", "f0"): "reflectance",
    ("weidlich_wilkie", "sigma_a"): "absorption",
    ("weidlich_wilkie", "thickness"): "length",
    ("weidlich_wilkie", "base.rho"): "reflectance",
    ("triace_layered", "top_shininess"): "exponent",
    ("triace_layered", "bottom_eta"): "index",
    ("ashikhmin_shirley", "shininess_x"): "exponent",
    ("car_paint", "metal_k"): "extinction",
    ("car_paint", "flake_x"): "slope",
    ("car_paint", "distance"): "length",
    ("patina", "extent"): "number",
}


@pytest.mark.parametrize(("model", "path"), list(KINDS))
def test_a_parameter_has_the_kind_that_its_term_means(model: str, path: str) -> None:
    parameters = manifest(gonio.model(model), refusals=False)["parameters"]
    assert row(parameters, path)["kind"] == KINDS[model, path]


def test_colours_of_metals_are_no_reflectances() -> None:
    for name in models():
        for p in manifest(gonio.model(name), refusals=False)["parameters"]:
            if p["kind"] == "reflectance":
                assert (p["low"], p["high"]) == (0, 1)


def test_a_declaration_can_say_what_its_number_is(tmp_path: Path) -> None:
    path = tmp_path / "glass.py"
    path.write_text(
        "from gonio.lang import INV_PI, Color, Float, Sample, Vec2, Vec3\n"
        "from gonio.model import Model, param\n"
        "from gonio.parts.hemisphere import pdf_cosine, sample_cosine\n\n\n"
        "class Glass(Model):\n"
        '    """Glass."""\n\n'
        '    n: Color = param((1.5, 1.5, 1.5), 1, 3, "the index", kind="index")\n\n'
        "    def eval(self, wi: Vec3, wo: Vec3) -> Color:\n"
        "        return INV_PI / self.n\n\n"
        "    def sample(self, wo: Vec3, u: Vec2) -> Sample:\n"
        "        wi = sample_cosine(u)\n"
        "        return Sample(wi, pdf_cosine(wi))\n\n"
        "    def pdf(self, wi: Vec3, wo: Vec3) -> Float:\n"
        "        return pdf_cosine(wi)\n"
    )
    assert manifest(load(str(path)))["parameters"][0]["kind"] == "index"


def test_a_conductor_reads_its_index_and_schlick_its_reflectance() -> None:
    # torrance_sparrow's own documentation: "only for schlick", "not for dielectric"
    read = {f: used(gonio.model("torrance_sparrow", fresnel=f)) for f in ("conductor", "schlick")}
    assert {"eta", "k"} <= read["conductor"]
    assert not {"f0", "f90"} & read["conductor"]
    assert {"f0", "f90"} <= read["schlick"]
    assert not {"eta", "k"} & read["schlick"]


@pytest.mark.parametrize("name", list(models()))
def test_what_is_used_is_what_the_exports_struct_has(name: str) -> None:
    model = gonio.model(name)
    members = export({name: model}, "wgsl")[0].entry.members
    assert used(model) == {m.path for m in members}


def test_what_is_unused_says_which_option_would_use_it() -> None:
    parameters = manifest(gonio.model("torrance_sparrow"))["parameters"]
    assert row(parameters, "f0")["unused_because"] == "only with fresnel=schlick"
    assert row(parameters, "k")["used"]
    assert "unused_because" not in row(parameters, "k")


def test_an_inner_model_is_read_below_a_coat() -> None:
    model = gonio.model("weidlich_wilkie", base=gonio.model("torrance_sparrow", fresnel="schlick"))
    assert "base.f0" in used(model)
    assert "base.k" not in used(model)


def test_a_refused_option_has_the_models_sentence_and_what_would_allow_it() -> None:
    model = gonio.model("torrance_sparrow", distribution="beckmann")
    choices = row(manifest(model)["options"], "compensation")["values"]
    refused = row([{"path": c["value"], **c} for c in choices], "kulla_conty")
    assert not refused["allowed"]
    with pytest.raises(gonio.ModelError) as error:
        model.replace(compensation="kulla_conty")
    assert refused["reason"] == str(error.value)
    assert refused["remedy"] == {"distribution": "ggx"}
    assert model.replace(compensation="kulla_conty", **refused["remedy"])


def test_two_changes_are_named_where_one_does_not_suffice() -> None:
    model = gonio.model("torrance_sparrow", distribution="beckmann", masking="cook_torrance")
    wanted = {"distribution": "ggx", "masking": "smith_correlated"}
    assert remedy(model, "compensation", "turquin") == wanted


def test_what_shading_code_cannot_do_is_refused_as_well() -> None:
    coat = gonio.model("weidlich_wilkie", base="phong")
    assert "mean albedo" in refusal(coat, {"bounces": "diffuse"})
    assert refusal(gonio.model("weidlich_wilkie"), {"bounces": "diffuse"}) == ""


def test_a_material_says_what_its_host_has_to_give_per_point() -> None:
    hooks = manifest(load_material("car_paint_red_strong"), refusals=False)["hooks"]
    assert [(h["path"], h["source"]) for h in hooks] == [
        ("flake_x", "flakes"),
        ("flake_y", "flakes"),
    ]
    assert hooks[0]["spread"] == 0.3  # as its file says
    grown = manifest(load_material("patina_3"), refusals=False)["hooks"]
    assert ("growth", "mesh") in [(h["path"], h["source"]) for h in grown]


def test_a_texture_is_a_hook_with_its_encoding(tmp_path: Path) -> None:
    from PIL import Image

    Image.new("RGB", (2, 2)).save(tmp_path / "wood.png")
    (tmp_path / "floor.toml").write_text(
        'model = "eon"\nrho = "wood.png"\nroughness = "wood.png"\n', encoding="utf-8"
    )
    hooks = manifest(load_material(tmp_path / "floor.toml"))["hooks"]
    assert [(h["path"], h["encoding"]) for h in hooks] == [("rho", "srgb"), ("roughness", "linear")]


# --- the loader ----------------------------------------------------------------------------------------

CALL = {
    "glsl": "void main() { vec4 v[COUNT]; STRUCT m = NAME_load(v); }",
    "essl": "out vec4 o; uniform vec4 v[COUNT];\n"
    "void main() { STRUCT m = NAME_load(v); o = vec4(m.base.rho, m.eta); }",
    "hlsl": "RWStructuredBuffer<float4> o; float4 v[COUNT];\n[numthreads(1, 1, 1)]\n"
    "void main() { STRUCT m = NAME_load(v); o[0] = float4(m.base.rho, m.eta); }",
    "slang": "RWStructuredBuffer<float4> o; uniform float4 v[COUNT];\n[numthreads(1, 1, 1)]\n"
    '[shader("compute")] void main() { STRUCT m = NAME_load(v); o[0] = float4(m.base.rho, m.eta); }',
}
HEADS = {
    "glsl": "#version 450\nlayout(local_size_x = 1) in;\n",
    "essl": "#version 300 es\nprecision highp float;\n",
}
SUFFIX = {"glsl": "comp", "essl": "frag", "hlsl": "comp", "slang": "slang"}


def compiler(language: str) -> list[str]:
    if language == "slang":
        slangc = tools.program("slangc", "compiles Slang")
        return [slangc, "x.slang", "-target", "cpp", "-o", "x.cpp"]
    validator = tools.program("glslangValidator", "compiles GLSL and HLSL")
    return {
        "glsl": [validator, "-V", "x.comp", "-o", "x.spv"],
        "essl": [validator, "x.frag"],
        "hlsl": [validator, "-D", "-V", "-e", "main", "x.comp", "-o", "x.spv"],
    }[language]


@pytest.mark.parametrize("language", list(CALL))
def test_the_loader_compiles(language: str, tmp_path: Path) -> None:
    model = gonio.model("weidlich_wilkie", base="eon")
    made = export({"lacquer": model}, language)[0]
    call = CALL[language].replace("COUNT", str(len(made.entry.members)))
    call = call.replace("STRUCT", made.entry.struct).replace("NAME", "lacquer")
    text = "\n".join([HEADS.get(language, ""), made.source, loader(made), call])
    (tmp_path / f"x.{SUFFIX[language]}").write_text(text, encoding="utf-8")
    done = subprocess.run(compiler(language), cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


FLOAT4 = "struct float4 { float x, y, z, w; };\n"


@pytest.mark.parametrize("language", ["cpp", "cuda"])
def test_the_loader_puts_every_number_in_its_place(language: str, tmp_path: Path) -> None:
    made = export({"lacquer": gonio.model("weidlich_wilkie", base="eon")}, language)[0]
    count = len(made.entry.members)
    prints = [
        f'printf("%g ", m.{m.path}{part});'
        for m in made.entry.members
        for part in ([""] if m.width == 1 else [".x", ".y", ".z"])
    ]
    vector = "float v[][4]" if language == "cpp" else "float4 v[]"
    given = ", ".join(f"{{{i}.1f, {i}.2f, {i}.3f}}" for i in range(count))
    text = (
        (FLOAT4 if language == "cuda" else "")
        + made.source
        + loader(made)
        + f"#include <stdio.h>\nint main() {{ const {vector} = {{{given}}};\n"
        + f"auto m = lacquer_load(v); {' '.join(prints)} }}\n"
    )
    (tmp_path / "x.cpp").write_text(text, encoding="utf-8")
    command = ["g++", "-O0", "-w", "-D__host__=", "-D__device__=", "x.cpp", "-o", "x"]
    subprocess.run(command, cwd=tmp_path, check=True)
    done = subprocess.run(tmp_path / "x", capture_output=True, text=True, check=True)
    wanted = [f"{i}.{c}" for i, m in enumerate(made.entry.members) for c in range(1, m.width + 1)]
    assert done.stdout.split() == wanted


def test_offsets_are_those_of_the_loader() -> None:
    model = gonio.model("weidlich_wilkie", base="torrance_sparrow")
    made = export({model.name: model}, "wgsl")[0]
    parameters = manifest(model, refusals=False)["parameters"]
    for index, member in enumerate(made.entry.members):
        assert row(parameters, member.path)["offset"] == 16 * index


@pytest.mark.parametrize("language", ["osl"])
def test_a_language_without_a_loader_is_refused_in_one_line(language: str) -> None:
    made = export({"eon": gonio.model("eon")}, language)[0]
    with pytest.raises(ExportError, match=r"parameters as inputs.*glsl") as error:
        loader(made)
    assert "\n" not in str(error.value)


def test_every_other_language_has_one() -> None:
    assert set(targets.TARGETS) - set(ARRAYS) == {"osl"}
    for language in ARRAYS:
        assert "eon_load(" in loader(export({"eon": gonio.model("eon")}, language)[0])


# --- the command ---------------------------------------------------------------------------------------


def run(*arguments: str) -> Any:
    return CliRunner().invoke(main, ["export", *arguments])


def test_the_command_prints_a_manifest() -> None:
    done = run("gold", "--manifest")
    assert done.exit_code == 0, done.output
    assert json.loads(done.stdout) == manifest(load("gold"), "gold")


def test_the_command_writes_text_loader_and_manifest(tmp_path: Path) -> None:
    done = run("eon", "lambert", "--to", "glsl", "--load", "--manifest", "-o", f"{tmp_path}/")
    assert done.exit_code == 0, done.output
    assert sorted(p.name for p in tmp_path.iterdir()) == ["eon.json", "gonio.glsl", "lambert.json"]
    text = (tmp_path / "gonio.glsl").read_text(encoding="utf-8")
    assert "eon_load(" in text
    assert "lambert_load(" in text
    about = json.loads((tmp_path / "eon.json").read_text(encoding="utf-8"))
    assert f"struct {about['sample_struct']} {{" in text


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["eon", "--to", "osl", "--load"], "osl has its parameters as inputs"),
        (["eon", "--to", "mtlx", "--load"], "leave out"),
        (["eon", "--load", "--manifest"], "--to"),
        (["eon", "--to", "wgsl", "--prove", "--manifest"], "leave out"),
    ],
)
def test_what_does_not_go_together_is_said_in_one_line(arguments: list[str], says: str) -> None:
    done = run(*arguments)
    assert done.exit_code != 0
    assert says in done.stderr
    assert done.stderr.count("\n") == 1
    assert done.stdout == ""
