"""Models, materials and files named by text: the same texts in every command, and in Python."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np
import pytest
from click.testing import CliRunner, Result
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image
from support.tolerances import decimals

import gonio
from gonio.cli import main
from gonio.cli.program import plain_models
from gonio.fields import ModelError
from gonio.materials import Material, MaterialError, library, load, load_model
from gonio.materials.notation import hex_colour, model_text
from gonio.materials.toml_file import FLAKE_SETTINGS, to_toml
from gonio.parts.metals import metal

CLAY = """\
from gonio.lang import INV_PI, Color, Float, Sample, Vec2, Vec3
from gonio.model import Model, param
from gonio.parts.hemisphere import pdf_cosine, sample_cosine


class MyClay(Model):
    \"\"\"A matte surface.\"\"\"

    rho: Color = param(0.5, 0, 1, "albedo")

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        return self.rho * INV_PI

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        wi = sample_cosine(u)
        return Sample(wi, pdf_cosine(wi))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        return pdf_cosine(wi)

    def albedo(self, wo: Vec3) -> Color:
        return self.rho
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder to be in, with files of every kind."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "my_clay.py").write_text(CLAY, encoding="utf-8")
    (tmp_path / "plain.toml").write_text('model = "eon"\nroughness = 0.25\n', encoding="utf-8")
    mi.Bitmap(np.full((2, 2, 3), 0.25, np.float32)).write("grey.exr")
    (tmp_path / "painted.toml").write_text('model = "eon"\nrho = "grey.exr"\n', encoding="utf-8")
    return tmp_path


def run(*args: str) -> Result:
    return CliRunner().invoke(main, list(args))


# What a user may write, and the colour or number that it makes.
TEXTS = {
    "eon:roughness=1": ("roughness", 1),
    "gold:alpha=0.3": ("alpha", 0.3),
    "plain.toml": ("roughness", 0.25),
    "plain.toml:roughness=0.5": ("roughness", 0.5),
    "my_clay.py:rho=0.75": ("rho", 0.75),
    "weidlich_wilkie:base=plain.toml": ("base.roughness", 0.25),
    "weidlich_wilkie:base=my_clay.py,base.rho=0.125": ("base.rho", 0.125),
    "weidlich_wilkie:base=gold,base.alpha=0.5": ("base.alpha", 0.5),
    "lambert:rho=0.25+plain.toml:roughness=1e+0+gold:alpha=0.5": ("second.second.alpha", 0.5),
    "weidlich_wilkie:base=weidlich_wilkie,base.base=eon,base.base.roughness=1": (
        "base.base.roughness",
        1,
    ),
}


@pytest.mark.parametrize("text", TEXTS)
def test_a_text_makes_the_model_that_it_says(folder: Path, text: str) -> None:
    path, expected = TEXTS[text]
    model, notes = load_model(text)
    assert {p: v for p, _, v in model.parameters()}[path] == expected
    assert notes == []


@pytest.mark.parametrize("text", TEXTS)
@pytest.mark.parametrize(
    "command",
    [
        ("show", "--json"),
        ("eval", "--theta-i", "30", "--theta-o", "40"),
        ("plot", "-o", "lobe.csv", "--theta-o", "30"),
        ("export", "--to", "cpp", "-o", "brdf.h"),
    ],
)
def test_commands_take_every_text(folder: Path, text: str, command: tuple[str, ...]) -> None:
    result = run(command[0], text, *command[1:])
    assert result.exit_code == 0, result.output


@pytest.mark.parametrize("text", ["gold:alpha=0.3", "weidlich_wilkie:base=plain.toml"])
def test_pictures_checks_and_comparisons_take_texts(folder: Path, text: str) -> None:
    small = ("--size", "8", "--spp", "1")
    for command in (
        ("render", text, *small, "-o", "a.png"),
        ("render", "eon", "--compare", text, *small, "-o", "b.png"),
        ("check", text, "--quick", "--only", "finite"),
        ("compare", text, "my_clay.py", "--no-pictures", "-o", "c.png"),
    ):
        result = run(*command)
        assert result.exit_code == 0, result.output


def test_python_takes_the_same_texts(folder: Path) -> None:
    picture = gonio.render("plain.toml:rho=0", size=(8, 8), spp=1, environment="white")
    assert picture.shape == (8, 8, 3)
    material = gonio.load("iron:alpha=0.3")
    assert isinstance(material, Material)
    assert material.model.eta == metal("Fe", neutral=True)["eta"]


def test_a_number_takes_the_place_of_a_picture(folder: Path) -> None:
    assert list(load("painted.toml").textures) == ["rho"]
    with pytest.raises(ModelError, match=r"rho comes from grey.exr.* write painted:rho=VALUE"):
        load_model("painted.toml")
    assert load_model("painted.toml:rho=0.5")[0].rho == 0.5
    nested = load("weidlich_wilkie:base=painted.toml")
    assert list(nested.textures) == ["base.rho"]
    assert load_model("weidlich_wilkie:base=painted.toml,base.rho=0.5")[0].base.rho == 0.5


def test_maps_follow_a_material_into_a_coat_and_are_named_where_there_is_no_surface() -> None:
    paint = next(name for name in library() if load(name).flakes)
    nested = load(f"weidlich_wilkie:base={paint}")
    assert nested.driven_by_maps() == ["base.flake_x", "base.flake_y"]
    _, notes = load_model(f"weidlich_wilkie:base={paint}")
    assert len(notes) == 2
    assert "base.flake_x comes from a map of flakes; here it is 0" in notes[0]
    assert isinstance(load(f"weidlich_wilkie:base={paint},base.flake_x=0.1"), gonio.Model)


def test_values_of_the_text_win_over_params() -> None:
    assert load("eon:roughness=1", ["roughness=0.5", "rho=0.25"]).roughness == 1
    assert load("eon:roughness=1", ["roughness=0.5", "rho=0.25"]).rho == 0.25


def test_metals_have_their_symbols_in_texts_too() -> None:
    assert load("torrance_sparrow:metal=Cu").eta == metal("Cu")["eta"]
    assert load("weidlich_wilkie:base=torrance_sparrow,base.metal=Ag").base.k == metal("Ag")["k"]
    with pytest.raises(ModelError, match="eon has no eta and k for a metal"):
        load("eon:metal=Cu")
    with pytest.raises(ModelError, match="metal says what eta is; leave one of them out"):
        load("torrance_sparrow:metal=Cu,eta=1/1/1")


# From the definition in IEC 61966-2-1: sRGB 0x80 is 0.2158605, 0xc0 is 0.5271151, 0x40 is 0.0512695.
def test_hex_colours_are_srgb() -> None:
    assert hex_colour("#c08040") == pytest.approx(
        (0.5271151, 0.2158605, 0.0512695), abs=decimals(7)
    )
    assert hex_colour("#fff") == (1, 1, 1)
    assert hex_colour("c08040") is None
    assert load("eon:rho=#c08040").rho == hex_colour("#c08040")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("gold:alfa=0.3", "has no 'alfa'; did you mean 'alpha'"),
        ("gold:alpha=7", "alpha=7.0 is out of range"),
        ("nothing.toml", "there is no material file nothing.toml"),
        ("nothing.py", "there is no file nothing.py"),
        ("weidlich_wilkie:base=eno", "did you mean the model 'eon'"),
        ("weidlich_wilkie:base.rho=red", "rho=red is not one or three numbers"),
        ("weidlich_wilkie:base.base.rho=1", "has no"),
        ("lambert+", "nothing on one side of a plus sign"),
        ("lambert+goldd", "did you mean the material 'gold'"),
        ("goldd", "did you mean the material 'gold'"),
        ("eon:rho=#12345", "rho=#12345 is not one or three numbers"),
    ],
)
def test_mistakes_say_what_is_allowed(text: str, message: str) -> None:
    with pytest.raises((ValueError, OSError), match=message):
        load(text)


def test_material_files_name_files_and_materials_inside(folder: Path) -> None:
    (folder / "sub").mkdir()
    (folder / "sub" / "inner.toml").write_text('model = "gold"\nalpha = 0.4\n', encoding="utf-8")
    outer = folder / "outer.toml"
    outer.write_text('model = "weidlich_wilkie"\nbase = "sub/inner.toml"\n', encoding="utf-8")
    assert load("outer.toml").model.base.alpha == 0.4
    outer.write_text(
        'model = "weidlich_wilkie"\n[base]\nmodel = "my_clay.py"\nrho = "#808080"\n',
        encoding="utf-8",
    )
    assert load("outer.toml").model.base.rho == hex_colour("#808080")
    outer.write_text('model = "outer.toml"\n', encoding="utf-8")
    with pytest.raises(MaterialError, match="in a circle") as error:
        load("outer.toml")
    assert str(error.value).count("outer.toml") == 1  # and not once for every round


def test_a_byte_order_mark_is_no_part_of_a_file(folder: Path) -> None:
    (folder / "bom.toml").write_bytes(b'\xef\xbb\xbfmodel = "eon"\n')
    assert load("bom.toml").model == gonio.EON()


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ('model = "car_paint"\n[flakes]\nsize = 2.5\n', 3),
        ('model = "car_paint"\n[flakes]\nsize = true\n', 3),
        ('model = "car_paint"\n[flakes]\ndensity = 2\n', 3),
        ('model = "car_paint"\n[flakes]\nspread = [1, 2]\n', 3),
        ('model = "car_paint"\n[flakes]\nflake_size = nan\n', 3),
        ('model = "car_paint"\n[flakes]\nsize = 8\nflake_size = 9\n', 4),
        ('model = "car_paint"\n[flakes]\ntiles = "many"\n', 3),
        ('model = "torrance_sparrow"\nmetal = 3\n', 2),
        ('model = "torrance_sparrow"\nmetal = "Fe"\nk = [1, 2, 3]\n', 3),
        ('model = "torrance_sparrow"\nmetal = "Fe"\nneutral = "yes"\n', 3),
        ('model = "weidlich_wilkie"\nbase = [1]\n', 2),
        ('model = "weidlich_wilkie"\n\n[base]\nrho = 1\n', 3),
        ('model = "eon"\nroughness = {a = 1}\n', 2),
        ('model = "eon"\nrho = ["a", "b", "c"]\n', 2),
        ('model = "eon"\nrho = [[1, 2, 3]]\n', 2),
        ('model = "eon"\nsampler = 3\n', 2),
        ('model = "eon"\nroughness = inf\n', 2),
    ],
)
def test_every_wrong_type_has_its_line(folder: Path, text: str, line: int) -> None:
    (folder / "wrong.toml").write_text(text, encoding="utf-8")
    with pytest.raises(MaterialError, match=rf"^wrong.toml:{line}: "):
        load("wrong.toml")


# --- there and back --------------------------------------------------------------------------------------


def same(one: gonio.Model, other: gonio.Model) -> bool:
    pairs = zip(one.parameters(), other.parameters(), strict=True)
    return type(one) is type(other) and all(a[2] == b[2] for a, b in pairs)


@pytest.mark.parametrize("name", library())
def test_a_ready_material_reads_back_from_its_own_text(name: str, tmp_path: Path) -> None:
    material = load(name)
    file = tmp_path / f"{name}.toml"
    file.write_text(to_toml(material), encoding="utf-8")
    again = load(file)
    assert same(again.model, material.model)
    assert (again.flakes, again.grows, again.description) == (
        material.flakes,
        material.grows,
        material.description,
    )


@settings(max_examples=50, deadline=None)
@given(st.data())
def test_a_model_reads_back_from_its_own_text(data: Any) -> None:
    numbers = st.floats(0, 1, width=32)
    base = gonio.EON(roughness=data.draw(numbers), rho=data.draw(st.tuples(*[numbers] * 3)))
    model = gonio.WeidlichWilkie(thickness=data.draw(numbers), base=base)
    assert same(load(model_text(model)), load(model_text(load(model_text(model)))))


def test_show_prints_a_materials_file() -> None:
    result = run("show", "gold")
    assert result.stdout == library()["gold"].read_text(encoding="utf-8")
    changed = run("show", "gold:alpha=0.4")
    assert "alpha = 0.4" in changed.stdout


def test_eighteen_coats_are_written_at_once() -> None:
    model: gonio.Model = gonio.EON(roughness=1)
    for _ in range(18):
        model = gonio.WeidlichWilkie(base=model)
    assert repr(model).count("WeidlichWilkie") == 18  # 2^18 comparisons would take minutes
    assert model_text(model).count("weidlich_wilkie") == 18


PAGE = Path(__file__).parent.parent / "docs" / "materials.md"


def test_the_page_on_materials_has_every_key_and_its_texts_are_right(folder: Path) -> None:
    text = PAGE.read_text(encoding="utf-8")
    for name, declared in FLAKE_SETTINGS.items():
        default = "" if name == "fade" else f" {declared.default:g}"
        assert f"| `{name}` |{default} |" in text
    for name in ("model", "description", "metal", "normal_map", "texture_scale", "growth"):
        assert f"| `{name}` |" in text
    for file in ("wear.png", "grain.png", "oak.png"):
        Image.new("RGB", (2, 2), (128, 128, 255)).save(file)
    example = text.split("```toml\n")[1].split("```")[0]
    (folder / "oak.toml").write_text(example, encoding="utf-8")
    assert load("oak.toml").textures.keys() == {"thickness", "base.rho"}
    row = re.compile(r"^\| (`[^|]+`) \|", re.M)
    for cell in row.findall(text.split("## In a file")[0]):
        for shown in re.findall("`([^`]+)`", cell):
            load(
                shown.replace("my_model.py", "my_clay.py").replace(
                    "oak.toml:roughness", "gold:alpha"
                )
            )
    (folder / "oak.toml").write_text(example.replace("0.4", "7"), encoding="utf-8")
    with pytest.raises(MaterialError) as caught:
        load("oak.toml")
    assert f"gonio: error: {caught.value}" in text


@pytest.mark.parametrize(
    "command",
    [
        ["render", "eon:roughness=0.5", "--size", "8", "--spp", "1"],
        ["show", "eon:roughness=0.5"],
        ["eval", "eon:roughness=0.5", "--theta-i", "30", "--theta-o", "60"],
        ["plot", "eon:roughness=0.5", "fon:roughness=0.5"],
        ["export", "matte=eon:roughness=0.5", "--to", "glsl"],
        ["compare", "eon:roughness=0.5", "fon:roughness=0.5", "--json"],
    ],
    ids=lambda command: command[0],
)
def test_a_value_is_given_once_beside_a_model_or_in_it(command: list[str]) -> None:
    result = CliRunner().invoke(main, [*command, "-p", "roughness=0.25"])
    assert result.exit_code == 2
    assert "roughness is given twice, by --param and in the model" in result.output


def test_a_value_beside_several_models_is_for_those_that_do_not_say_it() -> None:
    texts = ["eon:roughness=0.5", "eon"]
    values = [m.roughness for m in plain_models(texts, ["roughness=0.25"])]
    assert values == [0.5, 0.25]
