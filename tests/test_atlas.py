"""F of many materials in one picture of few bits."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from gonio.bake.atlas import fresnel_atlas
from gonio.bake.tables import distribution_table, fresnel_error, fresnel_table
from gonio.cli import main
from gonio.images import read_image
from gonio.parts.metals import metal

MATERIALS = {"copper": metal("Cu"), "chromium": metal("Cr"), "glass": {"eta": 1.5}}


@pytest.mark.parametrize(("bits", "rounding"), [(8, 0.5 / 255), (16, 0.5 / 65535)])
def test_rounding_costs_half_a_step_and_is_stated(bits: int, rounding: float) -> None:
    made = fresnel_atlas(MATERIALS, bits=bits)
    assert made.values.shape == (3, 128, 3)
    # Glass at the normal and in the horizon: 0.04 and 1
    np.testing.assert_allclose(made.values[2, [-1, 0]].T, [[0.04, 1]] * 3, atol=rounding + 1e-7)
    # Chromium's F turns so fast near the horizon that interpolation costs 1.2e-3 of its own.
    assert made.errors["chromium"].largest < rounding + 1.5e-3
    assert made.errors["glass"].largest < rounding + 3e-4
    if bits == 8:
        assert made.errors["copper"].largest > 0.8 * rounding
    else:
        # With 16 bits interpolation is all that is lost
        assert made.errors["copper"].largest < 1.2e-4


@pytest.mark.parametrize("bits", ["8", "16"])
def test_the_command_writes_a_picture_that_holds_the_rows(bits: str, tmp_path: Path) -> None:
    target = tmp_path / "atlas.png"
    done = CliRunner().invoke(
        main, ["bake", "atlas", "Cu", "1.5", "--bits", bits, "-o", str(target)]
    )
    assert done.exit_code == 0, done.output
    assert "row 1, 1.5: largest error" in done.output
    import mitsuba as mi

    stored = np.array(mi.Bitmap(str(target)))
    assert stored.dtype == (np.uint8 if bits == "8" else np.uint16)
    expected = fresnel_atlas({"Cu": metal("Cu"), "1.5": {"eta": 1.5}}, bits=int(bits))
    np.testing.assert_array_equal(stored, expected.codes)
    assert read_image(target).pixels.shape[:2] == (2, 128)


def test_what_is_no_material_is_one_line(tmp_path: Path) -> None:
    target = tmp_path / "atlas.png"
    for names in (["Xx"], ["Cu", "Cu"], ["-0"], ["1.5x"]):
        done = CliRunner().invoke(main, ["bake", "atlas", "-o", str(target), "--", *names])
        assert done.exit_code != 0
        assert done.output.count("\n") == 1
        assert not target.exists()
    done = CliRunner().invoke(main, ["bake", "atlas", "water", "1.333", "-o", str(target)])
    water, number = (line.split(": ")[1] for line in done.output.splitlines()[:2])
    assert water == number
    with pytest.raises(ValueError, match="allowed are 8 and 16"):
        fresnel_atlas(MATERIALS, bits=10)
    with pytest.raises(ValueError, match="no material"):
        fresnel_atlas({})


@pytest.mark.parametrize(
    "arguments", [["atlas", "Cu", "0.5"], ["atlas", ".999"], ["fresnel", "--eta", "1.5,0.5,2"]]
)
def test_light_from_inside_a_dielectric_is_refused(arguments: list[str], tmp_path: Path) -> None:
    """Total reflection begins between two entries: sin(30 degrees) = 0.5."""
    target = tmp_path / ("atlas.png" if arguments[0] == "atlas" else "f.npy")
    done = CliRunner().invoke(main, ["bake", *arguments, "-o", str(target)])
    assert done.exit_code != 0
    assert "is below 1: light from inside" in done.output
    assert done.output.count("\n") == 1
    assert not target.exists()
    # What is refused is what a table cannot hold: a metal's index may be below 1
    assert fresnel_error(fresnel_table(0.5), 0.5).largest > 0.1
    assert fresnel_atlas({"Ag": metal("Ag")}).errors["Ag"].largest < 3e-3


def test_a_row_that_turns_within_an_entry_says_what_helps(tmp_path: Path) -> None:
    """F of air falls from 1 to a quarter between the first two of 128 cosines."""
    said = []
    for entries in ("128", "2048"):
        command = ["bake", "atlas", "air", "1.5", "--entries", entries, "--bits", "16"]
        done = CliRunner().invoke(main, [*command, "-o", str(tmp_path / "atlas.png")])
        assert done.exit_code == 0, done.output
        said.append(done.output.splitlines())
    assert "more --entries" in said[0][0]
    assert not any("more --entries" in line for line in (said[0][1], *said[1]))


def test_a_distribution_of_16_bits_is_off_by_half_a_step_and_says_so(tmp_path: Path) -> None:
    target = tmp_path / "ggx.exr"
    command = ["bake", "distribution", "ggx", "--size", "64", "-o", str(target)]
    said = []
    for bits in ("32", "16"):
        done = CliRunner().invoke(main, [*command, "--bits", bits])
        assert done.exit_code == 0, done.output
        said.append(float(done.output.split("largest error ")[1].split()[0]))
    assert abs(said[1] - said[0]) <= 2**-11 + 1e-3 * said[0]
    import mitsuba as mi

    picture = mi.Bitmap(str(target))
    assert picture.component_format() == mi.Struct.Type.Float16
    exact = distribution_table("ggx", 64)
    stored = np.array(picture, np.float32).reshape(64, 64)
    # A half has 11 digits; below 6e-5 its steps are 6e-8 wide
    np.testing.assert_allclose(stored, exact, rtol=2**-11, atol=6e-8)
    assert (stored != exact).any()
