"""`gonio bake` and `gonio series` on the command line."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np
import pytest
from click.testing import CliRunner
from support.tolerances import SINGLE

from gonio.bake import tables
from gonio.bake.environment import Environment
from gonio.cli import main
from gonio.parts.metals import metal


def run(*arguments: str) -> Any:
    return CliRunner().invoke(main, list(arguments))


@pytest.fixture(autouse=True)
def _in_a_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    mi.set_variant("llvm_ad_rgb")


def test_fresnel_is_the_table_of_the_material() -> None:
    result = run("bake", "fresnel", "--metal", "Cu", "-o", "copper.npy")
    assert result.stdout == "copper.npy: largest error 8.7e-05, at 89.8 degrees\n"
    np.testing.assert_array_equal(np.load("copper.npy"), tables.fresnel_table(**metal("Cu")))
    assert run("bake", "fresnel", "--eta", "1.4,1.5,1.6", "--entries", "9").exit_code == 0
    assert np.load("fresnel.npy").shape == (9, 3)


def test_a_distribution_over_even_angles_loses_sharp_highlights() -> None:
    # Elek, CESCG 2010, Figure 4: the linear mapping against u^8
    errors = {}
    for exponent in ("1", "8"):
        result = run(
            "bake",
            "distribution",
            "beckmann",
            "--exponent",
            exponent,
            "--size",
            "128",
            "-o",
            "d.npy",
        )
        table = tables.distribution_table("beckmann", 128, float(exponent))
        error = tables.distribution_error(table, "beckmann", float(exponent))
        assert f"largest error {error.largest:.2g} of the peak" in result.stdout
        errors[exponent] = error.largest
    assert errors["1"] > 10 * errors["8"]


def test_distribution_says_how_wrong_it_is() -> None:
    result = run("bake", "distribution", "ggx", "--size", "64", "-o", "d.exr")
    assert "d.exr: largest error" in result.stdout
    error = tables.distribution_error(tables.distribution_table("ggx", 64), "ggx")
    assert f"{error.largest:.2g} of the peak" in result.stdout


def test_environments_are_blurred_and_projected() -> None:
    pixels = np.random.default_rng(1).random((17, 32, 3))
    Environment(pixels).write("sky.exr")
    assert run("bake", "blur", "sky.exr", "--alpha", "0.7", "--width", "16").exit_code == 0
    blurred = np.array(mi.Bitmap("blurred.exr"))
    assert blurred.shape == (9, 16, 3)
    assert blurred.std() < 0.3 * pixels.std()
    rows = json.loads(run("bake", "harmonics", "sky.exr", "--json").stdout)
    expected = Environment(pixels.astype(np.float32)).harmonics()
    np.testing.assert_allclose([row["rgb"] for row in rows], expected, rtol=SINGLE)
    text = run("bake", "harmonics", "sky.exr").stdout.splitlines()
    assert [line.split()[0] for line in text] == [row["harmonic"] for row in rows]


def test_a_series_is_one_strip_of_all_steps() -> None:
    result = run("series", "patina", "--size", "24", "--spp", "1")
    assert result.stdout == "patina.png\n"
    from PIL import Image

    with Image.open("patina.png") as picture:
        assert picture.width == 6 * 24


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("bake", "fresnel"), "give either --eta, such as 1.5, or --metal, such as Cu"),
        (("bake", "fresnel", "--eta", "x"), "no dielectric 'x'; known are vacuum"),
        (("bake", "fresnel", "--eta", "1.5,1.4"), "is not a finite number, or three as in"),
        (("bake", "fresnel", "--eta", "watr"), "did you mean 'water'"),
        (("bake", "fresnel", "--metal", "Cu", "--k", "3"), "leave out --k"),
        (("bake", "distribution", "--exponent", "nan"), "nan is not a number from 1 to 16"),
        (("bake", "split-sum", "weidlich_wilkie"), "lambert has no highlight"),
        (("bake", "cube", "studio", "-o", "none/sky"), "create it first"),
        (("render", "gold", "--time", "nan"), "nan is not a finite number above 0"),
        (("bake", "fresnel", "--eta", "0"), "eta must be above 0"),
        (("bake", "fresnel", "--metal", "Xx"), "'Xx'"),
        (("bake", "fresnel", "--eta", "1.5", "-o", "f.png"), "must be .npy or .exr"),
        (("bake", "distribution", "gxg"), "no distribution 'gxg'; known are beckmann"),
        (("bake", "blur", "studio", "--alpha", "2"), "2 is not a number above 0, up to 1"),
        (("bake", "blur", "studio", "--alpha", "1", "-o", "x.png"), "must be .exr or .hdr"),
        (("bake", "harmonics", "none.hdr"), "none.hdr"),
        (("bake", "shadows"), "No such command 'shadows'"),
        (("series", "patena"), "no series of materials 'patena'; known are patina"),
        (("series",), "Missing argument 'NAME'"),
        (("sheet", "patina"), "unexpected extra argument (patina)"),
        (("scene", "x.xml", "--diffusion", "0.1"), "--diffusion"),
        (("render", "gold", "--diffusion", "0.1"), "gold has no diffuse colour rho"),
    ],
)
def test_errors_are_one_line_and_leave_nothing(
    arguments: tuple[str, ...], message: str, tmp_path: Path
) -> None:
    result = run(*arguments)
    assert result.exit_code in (1, 2)
    assert message in result.stderr
    error = result.stderr[result.stderr.index("gonio: error: ") :]  # after the progress' label
    assert error.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_bake_and_its_commands_teach_by_example() -> None:
    assert "Examples:" in run("bake").stdout
    for command in ("fresnel", "distribution", "blur", "harmonics"):
        assert f"gonio bake {command}" in run("bake", command, "--help").stdout
