"""Exports that look F and D up: what is in the tables, what they cost, and that texts read them."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from PIL import Image

import gonio
from gonio.arrays.elementwise import elementwise
from gonio.bake.tables import fresnel_table
from gonio.cli import main
from gonio.export import export
from gonio.export.coded import BITS, Request, Tables
from gonio.export.evaluate import UNKNOWN, Machine
from gonio.export.files import manifests
from gonio.export.manifest import manifest
from gonio.export.prove import prove
from gonio.export.prove.models import prove_models
from gonio.export.prove.tabled import tabled
from gonio.export.read import Reader
from gonio.export.targets import SHADER_LIBRARY
from gonio.export.tree import ExportError
from gonio.lang import vec3
from gonio.model import Model
from gonio.parts.distribution import Beckmann, RoundBeckmann
from gonio.parts.metals import metal

BOTH = ("fresnel", "distribution")

WI = np.array([[0.3, 0.2, 0.93], [-0.5, 0.1, 0.2], [0.1, -0.7, 0.5], [0, 0, 1]])
WI /= np.linalg.norm(WI, axis=1, keepdims=True)
WO = WI[::-1]


def coat() -> Model:
    """Elek's material: a coat over rough gold."""
    base = gonio.model("torrance_sparrow", distribution="beckmann", masking="cook_torrance")
    return gonio.model("weidlich_wilkie", base=base)


def tables_of(model: Model, kinds: tuple[str, ...] = BOTH, bits: int = 16) -> Tables:
    made = export({"m": model}, "cpp", only=["eval"], tables=Request(kinds, bits))[0].tables
    assert made is not None
    return made


def numbers(model: Model) -> dict[str, Any]:
    """A model's parameters as `Machine` takes them."""
    found: dict[str, Any] = {}
    for name in model.fields:
        value = getattr(model, name)
        if isinstance(value, Model):
            found[name] = numbers(value)
        elif not isinstance(value, str):
            found[name] = np.atleast_1d(np.asarray(value, float))
            if isinstance(value, tuple):
                found[name] = found[name][None]
    return found


# erf of shaders is good to 3e-10; everything else is the same formula in double precision.
SAME = 1e-8


@pytest.mark.parametrize("name", ["disney", "patina", "oren_nayar", "weidlich_wilkie"])
def test_the_tree_on_arrays_computes_what_the_model_does(name: str) -> None:
    model = gonio.model(name)
    reader = Reader("x", SHADER_LIBRARY, ["x"])
    function = reader.method(reader.model(model, "x", title="x"), "eval")
    found = Machine().call(function, [numbers(model), WI, WO])
    np.testing.assert_allclose(np.broadcast_to(found, WI.shape), model.eval(WI, WO), rtol=SAME)


def test_what_depends_on_the_unknown_is_unknown_and_the_rest_is_not() -> None:
    model = gonio.model("weidlich_wilkie", eta=1.4)
    reader = Reader("x", SHADER_LIBRARY, ["x"])
    root = reader.model(model, "x", title="x")
    assert Machine().call(reader.method(root, "eval"), [numbers(model), UNKNOWN, WO]) is UNKNOWN
    facets = next(
        f for f in [reader.method(root, "eval"), *reader.functions] if f.name == "x_facets"
    )
    np.testing.assert_allclose(Machine().call(facets, [numbers(model)])["alpha"], model.alpha)


@pytest.mark.parametrize("bits", BITS)
def test_a_row_of_F_is_the_exact_one_rounded(bits: int) -> None:
    gold = gonio.model("torrance_sparrow", **metal("Au"))
    table = tables_of(gold, ("fresnel",), bits).fresnel
    assert table is not None
    exact = fresnel_table(**metal("Au"))
    off = np.abs(table.codes[0] / table.most - exact).max()
    assert 0 < off <= 0.5 / table.most + 1e-6
    # Between the entries of gold F is off by 1e-4, to which rounding adds half a step.
    assert off < table.errors[0] + 1e-6 < 2e-4 + 0.5 / table.most


# Between entries at most: measured 2.3e-4 of the peak; 8 bits round the root by 1 / 510.
D_ERROR = {16: 4e-4, 8: 8e-3}


@pytest.mark.parametrize("bits", BITS)
def test_D_from_the_table_is_that_of_both_kinds_of_facets(bits: int) -> None:
    """Also of two widths, by the one along the azimuth; far in the highlight and far outside."""
    tables = tables_of(coat(), ("distribution",), bits)
    assert tables.distribution is not None
    assert tables.distribution.rows == ("Beckmann.D", "RoundBeckmann.D")
    assert max(tables.distribution.errors) < D_ERROR[bits]
    rng = np.random.default_rng(3)
    alpha, q = 0.2, 4 * rng.random(500)
    theta, phi = np.arctan(alpha * np.sqrt(q)), 6.28 * rng.random(500)
    x, y, z = np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)
    exact = elementwise(lambda x, y, z: RoundBeckmann(alpha).D(vec3(x, y, z)), x, y, z)
    u = q / (1 + q)
    root = tables.distribution.look_up(u, np.full(1, 512 + 511 * alpha))
    largest = 1 / tables.distribution.look_up(np.zeros(1), np.full(1, 512 + 511 * alpha)) ** 2
    np.testing.assert_allclose(
        largest * root**2 / (np.pi * alpha**2), exact, atol=D_ERROR[bits] / (np.pi * alpha**2)
    )
    two = elementwise(lambda x, y, z: Beckmann(0.1, 0.4).D(vec3(x, y, z)), x, y, z)
    x, y = x / z, y / z
    q = (x / 0.1) ** 2 + (y / 0.4) ** 2
    along = 511 * np.sqrt((x**2 + y**2) / q)
    root = tables.distribution.look_up(q / (1 + q), along)
    np.testing.assert_allclose(
        largest * root**2 / (np.pi * 0.04), two, atol=D_ERROR[bits] / (np.pi * 0.04)
    )


def test_a_dielectric_has_rows_for_what_it_reflects_and_lets_in() -> None:
    tables = tables_of(coat(), ("fresnel",))
    assert tables.fresnel is not None
    named = [row.partition("(")[0] for row in tables.fresnel.rows]
    F, T = (named.index(n) for n in ("F_dielectric_entering", "transmittance_entering"))
    codes = tables.fresnel.codes.astype(int)
    assert np.abs(codes[F] + codes[T] - tables.fresnel.most).max() <= 1
    assert tables.fixed == {"eta", "base.eta", "base.k"}


def test_texts_read_the_tables_as_NumPy_does_and_samplers_keep_the_functions() -> None:
    """As arrays, from a buffer, and as a whole material function."""
    proven = prove_models(
        {"coat": coat()}, ["cpp", "glsl"], 300, ("eval", "pdf"), lit=["coat"], tables=Request(BOTH)
    )
    assert not proven.failed, "\n".join(proven.lines)
    assert any("the exact value by" in line for line in proven.lines)
    text = export({"coat": coat()}, "glsl", only=["eval", "pdf"], tables=Request(BOTH))[0].source
    pdf = text[text.index("float coat_pdf(") :]
    assert "exp(" in text
    assert "coat_tabled_D(" not in pdf
    assert "eta" in [m.path for m in export({"c": coat()}, "glsl")[0].entry.members]


def test_digits_within_a_table_are_those_of_the_text() -> None:
    """A float32 tells places in 511 entries apart to 3e-5 of an entry, which far tails of D show."""
    model = gonio.model("torrance_sparrow", **metal("Au"))
    made = export({"m": model}, "cpp", only=["eval"], tables=Request(("distribution",)))[0]
    (proof,) = prove([(model, made)], 20_000)
    assert proof.holds, proof
    assert made.tables is not None
    assert made.tables.distribution is not None
    place, row = np.linspace(0.9, 1, 1000), np.full(1, 3.0)
    exact = made.tables.distribution.look_up(place, row)
    single = made.tables.distribution.look_up(place.astype(np.float32), row.astype(np.float32))
    assert single.dtype == np.float32
    assert 1e-8 < np.max(np.abs(single - exact)) < 1e-5


def test_a_wrong_entry_in_a_text_is_noticed() -> None:
    model = gonio.model("torrance_sparrow")
    made = export({"m": model}, "cpp", only=["eval"], tables=Request(("fresnel",)))[0]
    (right,) = prove([(model, made)], 200)
    assert right.holds
    assert made.tables is not None
    assert made.tables.fresnel is not None
    codes = str(made.tables.fresnel.codes.ravel()[200])
    wrong = replace(made, source=re.sub(rf"\b{codes}\b", "7", made.source))
    assert not prove([(model, wrong)], 200)[0].holds


def test_tables_change_little_and_say_how_little() -> None:
    model = gonio.model("torrance_sparrow", **metal("Cu"))
    made = export({"m": model}, "cpp", only=["eval"], tables=Request(BOTH))[0]
    exact, found = model.eval(WI, WO), tabled(model, made).eval(WI, WO)
    # Entries of D and F, which have a parabola between them in place of the functions
    np.testing.assert_allclose(found, exact, rtol=2e-3)
    assert np.abs(found / exact - 1).max() > 1e-7


def test_several_materials_share_an_atlas() -> None:
    models = {"gold": gonio.load("gold").model, "copper": gonio.load("copper").model}
    made = export(models, "glsl", only=["eval"], tables=Request(("fresnel",)))
    tables = made[0].tables
    assert tables is not None
    assert tables.fresnel is not None
    assert len(tables.fresnel.rows) == 2
    assert made[0].entry.binds == ("gonio_fresnel_map",)
    assert made[0].source.count("sampler2D") == 1
    about = manifests(models, only=["eval"], tables=Request(("fresnel",)))
    rows = [json.loads(about[f"{name}.json"])["tables"][0]["rows"] for name in models]
    assert rows[0] == rows[1]
    assert [row["row"] for row in rows[1]] == [0, 1]


HOST = """
import sys, json, numpy as np, moderngl
from PIL import Image
text, places, made, *pictures = sys.argv[1:]
context = moderngl.create_context(standalone=True, backend="egl", require=430)
for binding, name in zip((2, 3), pictures):
    codes = np.asarray(Image.open(name)).astype("f4")
    values = codes / (255 if codes.max() <= 255 else 65535)
    values = values[..., None] if values.ndim == 2 else values
    picture = context.texture(
        values.shape[1::-1], values.shape[2], np.ascontiguousarray(values).tobytes(), dtype="f4"
    )
    picture.filter = moderngl.LINEAR, moderngl.LINEAR
    picture.repeat_x = picture.repeat_y = False
    picture.use(binding)
rows = np.load(places).astype("f4")
shader = context.compute_shader(open(text).read())
given, out = context.buffer(rows.tobytes()), context.buffer(reserve=4 * 3 * len(rows))
given.bind_to_storage_buffer(0)
out.bind_to_storage_buffer(1)
shader.run(len(rows))
np.save(made, np.frombuffer(out.read(), "f4").reshape(-1, 3))
"""

# A texture's unit of interpolation is 1/256 of a texel.
FILTERED = 3e-3


@pytest.mark.parametrize("bits", BITS)
def test_textures_are_the_files_that_the_command_writes(bits: int, tmp_path: Path) -> None:
    """A host of its own, with real textures; its pictures are made for the hardware's filter."""
    arguments = ["export", "gold", "--to", "glsl", "--table", "fresnel,distribution", "--embed"]
    done = CliRunner().invoke(
        main, [*arguments, "--bits", str(bits), "--manifest", "-o", f"{tmp_path}/"]
    )
    assert done.exit_code == 0, done.output
    assert "off by at most" in done.output
    about = json.loads((tmp_path / "gold.json").read_text(encoding="utf-8"))
    assert [p["path"] for p in about["parameters"] if p.get("tabled")] == ["eta", "k"]
    files = []
    for table in about["tables"]:
        with Image.open(tmp_path / table["file"]) as picture:
            assert picture.size == (table["width"], table["height"])
        assert f"sampler2D {table['texture']};" in (tmp_path / "gold.glsl").read_text("utf-8")
        files.append(tmp_path / table["file"])
    if bits == 16:  # Pillow keeps eight bits of RGB
        return
    text = (tmp_path / "gold.glsl").read_text(encoding="utf-8")
    text = (
        f"#version 450\n{text}\nlayout(local_size_x = 1) in;\n"
        "layout(std430, binding = 0) buffer A { float x[]; };\n"
        "layout(std430, binding = 1) buffer B { float y[]; };\n"
        "void main() {\n    int k = int(gl_GlobalInvocationID.x);\n    int i = 6 * k;\n"
        "    vec3 f = gold_eval(gold_material(), vec3(x[i], x[i + 1], x[i + 2]), "
        "vec3(x[i + 3], x[i + 4], x[i + 5]));\n"
        "    y[3 * k] = f.x;\n    y[3 * k + 1] = f.y;\n    y[3 * k + 2] = f.z;\n}\n"
    )
    (tmp_path / "host.glsl").write_text(text, encoding="utf-8")
    (tmp_path / "host.py").write_text(HOST, encoding="utf-8")
    np.save(tmp_path / "rows.npy", np.concatenate([WI, WO], 1))
    command = [sys.executable, "-P", "host.py", "host.glsl", "rows.npy", "made.npy", *files]
    subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
    model = gonio.load("gold").model
    made = export({"gold": model}, "glsl", only=["eval"], tables=Request(BOTH, bits))[0]
    expected = tabled(model, made).eval(WI, WO)
    np.testing.assert_allclose(np.load(tmp_path / "made.npy"), expected, rtol=FILTERED)


def test_text_manifest_and_folder_agree_on_the_names_of_pictures(tmp_path: Path) -> None:
    arguments = ["--to", "wgsl", "--table", "fresnel", "--manifest", "-o", f"{tmp_path}/"]
    done = CliRunner().invoke(main, ["export", "gold", "--prefix", "shared", *arguments])
    assert done.exit_code == 0, done.output
    (table,) = json.loads((tmp_path / "gold.json").read_text(encoding="utf-8"))["tables"]
    text = (tmp_path / "gold.wgsl").read_text(encoding="utf-8")
    assert f"tables in {table['file']}." in text
    assert f"var {table['texture']}:" in text
    before = (tmp_path / table["file"]).read_bytes()
    done = CliRunner().invoke(main, ["export", "copper", "--prefix", "shared", *arguments])
    assert done.exit_code == 1
    assert "reads shared_fresnel.png" in done.output
    assert (tmp_path / table["file"]).read_bytes() == before


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (["eon", "--table", "fresnel", "--to", "cpp"], "eon has no Fresnel term"),
        (["phong", "--table", "distribution", "--to", "cpp"], "phong has no distribution"),
        (["gold", "--table", "fresnl", "--to", "cpp"], "did you mean 'fresnel'"),
        (["gold", "--table", "fresnel", "--to", "osl"], "no lookups here"),
        (["gold", "--table", "fresnel", "--to", "mtlx"], "no tables"),
        (["gold", "--table", "fresnel", "--to", "glsl"], "give a folder"),
        (["gold", "--bits", "8", "--to", "glsl"], "--bits is for tables"),
        (["gold", "--lookups", "array", "--to", "glsl"], "give --lit or --table"),
        (["ue4", "--lit", "--lookups", "array", "--to", "glsl"], "give --table"),
        (["gold", "--table", "fresnel", "--lookups", "array", "--to", "wgsl"], "no arrays"),
        (["gold", "--table", "distribution", "--lookups", "array", "--to", "glsl"], "too many"),
        (["gold", "--table", "fresnel", "--only", "pdf", "--to", "cpp"], "that eval calls"),
        (["gold", "--table", "fresnel", "--lookups", "textures", "--to", "cpp"], "as arrays"),
    ],
)
def test_what_cannot_be_looked_up_is_refused_in_a_sentence(
    arguments: list[str], reason: str
) -> None:
    done = CliRunner().invoke(main, ["export", *arguments])
    assert done.exit_code != 0
    assert reason in done.output
    assert "Traceback" not in done.output


def test_an_index_that_a_texture_gives_stays_a_function() -> None:
    gold = gonio.model("torrance_sparrow")
    with pytest.raises(ExportError, match="F_conductor_half takes one that changes"):
        export(
            {"m": gold},
            "cpp",
            only=["eval"],
            tables=Request(("fresnel",), varying=frozenset({"eta"})),
        )


def test_a_lit_manifest_names_the_textures_of_tables() -> None:
    about = manifest(coat(), "coat", only=["eval"], lit=["directional"], tables=Request(BOTH))
    bound = [one["name"] for one in about["lit"]["binds"]]
    assert {t["texture"] for t in about["tables"]} < set(bound)
