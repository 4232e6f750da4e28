"""One function for several materials, whose parameter says which row of the table of F is read."""

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
from test_tabled import FILTERED, HOST, WI, WO, coat

import gonio
from gonio.cli import main
from gonio.export import Export, export
from gonio.export.by_row import at_row, together
from gonio.export.coded import Request
from gonio.export.prove import prove
from gonio.export.prove.models import prove_models
from gonio.export.prove.tabled import tabled
from gonio.model import Model
from gonio.parts.metals import metal

METALS = ("gold", "copper", "silver")


# What a table of F may cost these materials between its entries; measured 1e-3 in the worst place.
TABLED = 3e-3


def exported(materials: dict[str, Model], language: str, **asked: Any) -> tuple[Model, Export]:
    model = together(materials)
    request = Request(("fresnel",), materials=tuple(materials.items()))
    return model, export({"m": model}, language, only=["eval"], tables=request, **asked)[0]


def metals() -> dict[str, Model]:
    return {name: gonio.load(name).model for name in METALS}


def coats() -> dict[str, Model]:
    """Of both F and 1 - F of a coat, and F of the metal inside: three places that look a row up."""
    return {
        "gold": coat().replace(eta=1.4, base=coat().base.replace(**metal("Au"))),
        "chrome": coat().replace(eta=1.7, base=coat().base.replace(**metal("Cr"))),
        # The same index twice is two rows as well
        "grey": coat().replace(eta=1.4, base=coat().base.replace(eta=2.0, k=3.0)),
    }


@pytest.mark.parametrize("materials", [metals(), coats()], ids=["metals", "coats"])
def test_each_row_is_its_material(materials: dict[str, Model]) -> None:
    """Against the materials' own functions, without any table."""
    model, made = exported(materials, "cpp")
    found = []
    for row, material in enumerate(materials.values()):
        found.append(tabled(at_row(model, material, row), made).eval(WI, WO))
        np.testing.assert_allclose(found[-1], material.eval(WI, WO), rtol=TABLED)
        assert made.tables is not None
        assert made.tables.fresnel is not None
        assert len(made.tables.fresnel.rows) % len(materials) == 0
    assert min(np.abs(a / b - 1).max() for a in found for b in found if a is not b) > 0.02


def test_a_row_between_two_is_the_nearest_and_one_beyond_the_last() -> None:
    model, made = exported(metals(), "cpp")

    def at(row: float) -> Any:
        rows = np.full(len(WI), row)  # as an array: values in a texture know no range
        return tabled(model.replace(row=rows), made).eval(WI, WO)

    for row, whole in ((0.4, 0), (0.6, 1), (1.4999, 1), (7.0, 2), (-3.0, 0)):
        np.testing.assert_array_equal(at(row), at(whole))


def test_texts_choose_the_row_as_NumPy_does() -> None:
    """In a function of the model, of the model inside, and of lights."""
    materials = coats()
    request = Request(("fresnel",), materials=tuple(materials.items()))
    proven = prove_models(
        {"coats": together(materials)},
        ["cpp", "glsl"],
        200,
        ("eval",),
        lit=["directional", "coat"],
        tables=request,
    )
    assert not proven.failed, "\n".join(proven.lines)
    for name in materials:
        assert any(f"coats: {name}: tables change the exact" in line for line in proven.lines)


@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        (r"(float up = .*) \+ 0\.5f;", r"\1 + 1.0f;"),  # half a row further
        (r"(float up = .*) \+ 0\.5f;", r"\1 + 0.0f;"),
        (r"(m_fresnel_table\(\w+, row\))", r"m_fresnel_table(cos_h, row + 1.0f)"),
    ],
)
def test_a_row_that_is_off_is_noticed(right: str, wrong: str) -> None:
    model, made = exported(metals(), "cpp")
    assert prove([(model, made)], 200)[0].holds
    text, count = re.subn(right, wrong, made.source, count=1)
    assert count == 1
    assert not prove([(model, replace(made, source=text))], 200)[0].holds


def test_a_texture_is_read_in_the_middle_of_its_row(tmp_path: Path) -> None:
    """By a host of its own, with the files that the command writes; half a texel off is noticed."""
    arguments = ["export", *METALS, "--to", "glsl", "--table", "fresnel", "--bits", "8"]
    arguments += ["--by-row", "metals", "--manifest", "--embed", "-o", f"{tmp_path}/"]
    done = CliRunner().invoke(main, arguments)
    assert done.exit_code == 0, done.output
    about = json.loads((tmp_path / "metals.json").read_text(encoding="utf-8"))
    assert [(one["row"], one["name"]) for one in about["materials"]] == list(enumerate(METALS))
    (row,) = (p for p in about["parameters"] if p["path"] == "row")
    assert (row["low"], row["high"], row["used"]) == (0, 2, True)
    assert "1 copper" in row["doc"]
    (table,) = about["tables"]
    assert [r["holds"].partition(":")[0] for r in table["rows"]] == list(METALS)
    shader = (tmp_path / "metals.glsl").read_text(encoding="utf-8")
    (tmp_path / "host.py").write_text(HOST, encoding="utf-8")
    np.save(tmp_path / "rows.npy", np.concatenate([WI, WO], 1))

    def drawn(text: str, row: int) -> Any:
        given = "".join(
            f"    m.{path} = {value[0]};\n"
            for path, value in about["materials"][row]["parameters"].items()
            if path in ("alpha", "anisotropy")
        )
        text = (
            f"#version 450\n{text}\nlayout(local_size_x = 1) in;\n"
            "layout(std430, binding = 0) buffer A { float x[]; };\n"
            "layout(std430, binding = 1) buffer B { float y[]; };\n"
            "void main() {\n    int k = int(gl_GlobalInvocationID.x);\n    int i = 6 * k;\n"
            f"    Metals m = metals_material();\n{given}    m.row = {row}.0;\n"
            "    vec3 f = metals_eval(m, vec3(x[i], x[i + 1], x[i + 2]), "
            "vec3(x[i + 3], x[i + 4], x[i + 5]));\n"
            "    y[3 * k] = f.x;\n    y[3 * k + 1] = f.y;\n    y[3 * k + 2] = f.z;\n}\n"
        )
        (tmp_path / "host.glsl").write_text(text, encoding="utf-8")
        files = ["host.glsl", "rows.npy", "made.npy", table["file"]]
        command = [sys.executable, "-P", "host.py", *files]
        subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
        return np.load(tmp_path / "made.npy")

    materials = metals()
    model = together(materials)
    request = Request(("fresnel",), 8, materials=tuple(materials.items()))
    made = export({"metals": model}, "glsl", only=["eval"], tables=request)[0]
    half = f"* row + {1 / 6:.9g}"
    assert half in shader
    for row, material in enumerate(materials.values()):
        expected = tabled(at_row(model, material, row), made).eval(WI, WO)
        np.testing.assert_allclose(drawn(shader, row), expected, rtol=FILTERED)
        if row == 1:
            off = drawn(shader.replace(half, "* row"), row)
            assert np.abs(off / expected - 1).max() > 10 * FILTERED


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (["gold", "eon", "--table", "fresnel"], "gold and eon are not the same model"),
        (["a=ue4", "b=ue4:light=image", "--table", "fresnel"], "with the same options"),
        (["gold", "--table", "fresnel"], "name two or more"),
        (["gold", "copper"], "give --table fresnel"),
        (["gold", "copper", "--table", "distribution"], "give --table fresnel as well"),
        (["gold", "copper", "--table", "fresnel", "--only", "eval,pdf"], "pdf would compute F"),
        (["patina_2", "patina_3", "--table", "fresnel"], "the mesh"),
    ],
)
def test_what_no_row_could_choose_is_one_line(arguments: list[str], reason: str) -> None:
    done = CliRunner().invoke(main, ["export", *arguments, "--to", "cpp", "--by-row", "m"])
    assert done.exit_code != 0
    assert reason in done.output
    assert "Traceback" not in done.output
