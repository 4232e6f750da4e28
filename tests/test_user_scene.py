"""The user's own Mitsuba scenes: their files, includes, parameters, films, and what is put into them."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np
import pytest
from click.testing import CliRunner
from PIL import Image
from support.tolerances import SINGLE

import gonio
from gonio.cli import main
from gonio.materials import load_material
from gonio.messages import Notice
from gonio.render.user_scene import render_scene


@pytest.fixture(autouse=True)
def _variant() -> None:
    mi.set_variant("llvm_ad_rgb")


NOISE = 0.02  # of a picture's mean: 4096 samples, each off by a few tenths

FILM = """<film type="hdrfilm"><integer name="width" value="16"/>
    <integer name="height" value="16"/>{more}</film>"""


def scene(wall: str = "", film: str = FILM, more: str = "") -> str:
    """A wall that fills the picture, in radiance 1: pixels are its reflectance."""
    return f"""<scene version="3.0.0">
  <integrator type="path"/>
  <sensor type="orthographic">
    <transform name="to_world"><lookat origin="0, 0, 4" target="0, 0, 0" up="0, 1, 0"/></transform>
    {film.format(more="")}
    <sampler type="independent"><integer name="sample_count" value="16"/></sampler>
  </sensor>
  <emitter type="constant"/>
  {more}
  <shape type="rectangle" id="wall"><transform name="to_world"><scale value="5"/></transform>
    {wall}</shape>
</scene>"""


TEXTURED = """<bsdf type="diffuse"><texture type="bitmap" name="reflectance">
    <string name="filename" value="c.png"/></texture></bsdf>"""


def write(folder: Path, name: str, text: str) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / name).write_text(text)
    return folder / name


def colour(folder: Path, code: tuple[int, int, int]) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    Image.new("RGB", (4, 4), code).save(folder / "c.png")


def mean(path: Path, assign: Any = None, **more: Any) -> Any:
    return render_scene(path, assign or {}, **more).mean(axis=(0, 1))


def test_files_come_from_the_scenes_own_folder_whatever_was_loaded_before(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    codes = {"a": (255, 0, 0), "b": (0, 255, 0), "elsewhere": (0, 0, 255)}
    for name, code in codes.items():
        colour(tmp_path / name, code)
        write(tmp_path / name, "scene.xml", scene(TEXTURED))
    monkeypatch.chdir(tmp_path / "elsewhere")
    resolver = mi.file_resolver()
    before = [str(resolver[k]) for k in range(len(resolver))]
    for name in ("a", "b", "a"):
        wanted = np.array(codes[name]) / 255
        np.testing.assert_allclose(mean(tmp_path / name / "scene.xml"), wanted, atol=NOISE)
    assert [str(resolver[k]) for k in range(len(resolver))] == before


def test_included_files_have_their_ids_seen_and_their_own_folders(tmp_path: Path) -> None:
    colour(tmp_path / "parts", (255, 255, 0))
    colour(tmp_path, (0, 0, 255))
    inner = f'<scene version="3.0.0"><bsdf type="twosided" id="paint">{TEXTURED}</bsdf></scene>'
    write(tmp_path / "parts", "paint.xml", inner)
    film = '<include filename="parts/film.xml"/>'
    write(tmp_path / "parts", "film.xml", f'<scene version="3.0.0">{FILM.format(more="")}</scene>')
    text = scene('<ref id="paint"/>', film, '<include filename="parts/paint.xml"/>')
    path = write(tmp_path, "scene.xml", text)
    np.testing.assert_allclose(mean(path), (1, 1, 0), atol=NOISE)
    for name in ("paint", "wall"):
        model = gonio.Lambert(rho=(0.2, 0.4, 0.6))
        np.testing.assert_allclose(mean(path, {name: model}), (0.2, 0.4, 0.6), atol=NOISE)
    with pytest.raises(ValueError, match="no shape or bsdf with the id 'wal'; ids: paint, wall"):
        mean(path, {"wal": gonio.Lambert()})
    assert render_scene(path, {}, size=(8, 4), spp=1).shape == (4, 8, 3)  # an included film


def test_a_bsdf_that_several_shapes_share_is_replaced_for_all(tmp_path: Path) -> None:
    paint = '<bsdf type="twosided" id="paint"><bsdf type="diffuse"/></bsdf>'
    half = """<shape type="rectangle"><transform name="to_world"><scale value="5"/>
        <translate x="5" z="0.1"/></transform><ref id="paint"/></shape>"""
    path = write(tmp_path, "scene.xml", scene('<ref id="paint"/>', more=paint + half))
    pixels = render_scene(path, {"paint": gonio.Lambert(rho=0.25)})
    np.testing.assert_allclose(pixels[:, [0, -1]].mean(axis=(0, 1)), 0.25, atol=NOISE)


def test_parameters_are_defined_as_mitsuba_has_it(tmp_path: Path) -> None:
    wall = '<bsdf type="diffuse"><rgb name="reflectance" value="$r, $r, $r"/></bsdf>'
    text = scene(wall, more='<default name="r" value="0.5"/>')
    # A default stands before its use.
    text = text.replace('<default name="r" value="0.5"/>', "").replace(
        "<integrator", '<default name="r" value="0.5"/><integrator', 1
    )
    path = write(tmp_path, "scene.xml", text)
    np.testing.assert_allclose(mean(path), 0.5, atol=NOISE)
    np.testing.assert_allclose(mean(path, define={"r": "0.25"}), 0.25, atol=NOISE)
    target = tmp_path / "a.exr"
    arguments = ["scene", str(path), "-D", "r=0.125", "-o", str(target)]
    assert CliRunner().invoke(main, arguments).exit_code == 0
    # Single pixels, whose samples are a 256th of the picture's: half a unit of noise in a few tenths
    np.testing.assert_allclose(np.array(mi.Bitmap(str(target))), 0.125, rtol=0.2)
    with pytest.raises(ValueError, match=r"does not load: .*unused parameters.*zz"):
        mean(path, define={"zz": "1"})
    result = CliRunner().invoke(main, ["scene", str(path), "-D", "r"])
    assert "-D r is not NAME=VALUE" in result.stderr


@pytest.mark.parametrize("film", ["", FILM, '<film type="hdrfilm"/>'], ids=["none", "set", "unset"])
def test_size_works_whatever_film_the_scene_has(tmp_path: Path, film: str) -> None:
    path = write(tmp_path, "scene.xml", scene('<bsdf type="diffuse"/>', film))
    pixels = render_scene(path, {}, size=(12, 6), spp=4)
    assert pixels.shape == (6, 12, 3)
    np.testing.assert_allclose(pixels.mean(), 0.5, atol=NOISE)


def test_a_crop_window_is_scaled_with_the_size(tmp_path: Path) -> None:
    crop = "".join(
        f'<integer name="crop_{k}" value="{v}"/>'
        for k, v in (("offset_x", 4), ("offset_y", 8), ("width", 8), ("height", 4))
    )
    film = FILM.replace("{more}", crop)
    path = write(tmp_path, "scene.xml", scene('<bsdf type="diffuse"/>', film))
    assert render_scene(path, {}, spp=1).shape == (4, 8, 3)
    assert render_scene(path, {}, size=(32, 32), spp=1).shape == (8, 16, 3)


def test_errors_keep_their_cause(tmp_path: Path) -> None:
    path = write(tmp_path, "scene.xml", scene(TEXTURED))  # no c.png
    with pytest.raises(ValueError, match=r"does not load: .*c\.png.*No such file") as caught:
        mean(path)
    assert "\n" not in str(caught.value)
    wall = '<bsdf type="gonio_eon"><float name="roughness" value="7"/></bsdf>'
    path = write(tmp_path, "scene.xml", scene(wall))
    with pytest.raises(ValueError, match=r"does not load: .*roughness=7.* is out of range"):
        mean(path)


def test_materials_with_textures_flakes_and_growth_go_into_scenes(tmp_path: Path) -> None:
    import trimesh

    Image.new("RGB", (4, 4), (0, 0, 0)).save(tmp_path / "black.png")
    (tmp_path / "m.toml").write_text('model = "lambert"\nrho = "black.png"\n')
    path = write(tmp_path, "scene.xml", scene())
    np.testing.assert_allclose(
        mean(path, {"wall": load_material(tmp_path / "m.toml")}), 0, atol=SINGLE
    )
    assert (mean(path, {"wall": load_material("car_paint_red_strong")}) > 0).all()
    with pytest.raises(ValueError, match="grows in the cavities of meshes"):
        mean(path, {"wall": load_material("patina_3")})
    ball = trimesh.creation.icosphere(subdivisions=3)
    ball.export(tmp_path / "ball.ply")
    shape = '<shape type="ply" id="ball"><string name="filename" value="ball.ply"/></shape>'
    path = write(tmp_path, "mesh.xml", scene(more=shape))
    assert (mean(path, {"ball": load_material("patina_3")}) > 0).all()
    with pytest.raises(ValueError, match="no texture coordinates, and the flakes of car_paint"):
        mean(path, {"ball": load_material("car_paint_red_strong")})


def test_a_checked_bsdf_finds_its_textures_beside_its_file(tmp_path: Path) -> None:
    from gonio.check.mitsuba_bsdf import sides_of

    colour(tmp_path, (255, 0, 0))
    texture = TEXTURED.replace("<bsdf", '<bsdf version="3.0.0"', 1)
    path = write(tmp_path, "paint.xml", texture)
    assert sides_of(str(path))[0].name == "paint"
    with pytest.raises(ValueError, match=r"cannot load .*c\.png"):
        sides_of(str(write(tmp_path / "other", "paint.xml", texture)))


MATTE = '<bsdf type="twosided" id="both"><bsdf type="diffuse" id="inner"/></bsdf>'


@pytest.mark.parametrize(
    ("wall", "more", "assign", "message"),
    [
        ("", MATTE, ["both"], "no shape wears the bsdf 'both'"),
        ("", MATTE, ["inner"], "no shape wears the bsdf 'inner'"),
        (MATTE, "", ["inner", "wall"], "only wall wears the bsdf 'inner', and gets another model"),
        (
            "",
            '<shape type="shapegroup" id="many"><shape type="sphere" id="one"/></shape>'
            '<shape type="instance"><ref id="many"/></shape>',
            ["many"],
            "many is a group of shapes, .* in it are one",
        ),
    ],
)
def test_an_assignment_that_would_change_nothing_is_an_error(
    tmp_path: Path, wall: str, more: str, assign: list[str], message: str
) -> None:
    path = write(tmp_path, "s.xml", scene(wall, more=more))
    with pytest.raises(ValueError, match=message):
        render_scene(path, dict.fromkeys(assign, gonio.Lambert()), spp=1)


def test_a_shape_and_the_bsdf_that_it_shares_get_different_models(tmp_path: Path) -> None:
    # In front of the wall, over the left half of the picture; convex from nowhere, so that pixels are
    # what each reflects of radiance 1 and of the other's light: nearly nothing, side by side.
    left = """<shape type="rectangle" id="left"><transform name="to_world"><scale value="5"/>
        <translate x="-5" z="0.01"/></transform><ref id="both"/></shape>"""
    path = write(tmp_path, "s.xml", scene('<ref id="both"/>', more=MATTE + left))
    assign = {"both": gonio.Lambert(rho=0.25), "left": gonio.Lambert(rho=0.75)}
    for order in (assign, dict(reversed(assign.items()))):
        picture = render_scene(path, order, spp=64)
        # Noise of 64 samples
        np.testing.assert_allclose(picture[:, 2:6].mean(), 0.75, rtol=0.05)
        # Noise of 64 samples
        np.testing.assert_allclose(picture[:, 10:14].mean(), 0.25, rtol=0.05)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["-p", "roughness=1"], "--param is for the models of --assign"),
        (["--assign", "wall=eon", "--assign", "wall=gold"], "--assign gives wall twice"),
        (["-D", "a=1", "-D", "a=2"], "-D gives a twice"),
        (["-D", "config=1"], "no parameter of the name config"),
        (["-o", "no/such/folder.png"], "there is no folder"),
    ],
)
def test_no_option_of_scene_is_ignored_in_silence(tmp_path: Path, arguments, message: str) -> None:
    path = write(tmp_path, "s.xml", scene())
    result = CliRunner().invoke(main, ["scene", str(path), "--spp", "1", *arguments])
    assert result.exit_code
    assert message in result.output


def test_what_a_scene_lacks_or_has_twice_is_said(tmp_path: Path) -> None:
    whole = scene()
    path = write(tmp_path, "s.xml", whole.replace('<integrator type="path"/>', ""))
    with pytest.raises(ValueError, match="has no <integrator>; add one"):
        render_scene(path, {}, spp=1)
    sensor = whole[whole.index("<sensor") : whole.index("</sensor>") + len("</sensor>")]
    path = write(tmp_path, "s.xml", whole.replace(sensor, 2 * sensor))
    with pytest.warns(Notice, match="2 sensors; what the first one sees"):
        render_scene(path, {}, spp=1)


@pytest.mark.skipif(sys.platform != "linux", reason="names of files are bytes on Linux")
@pytest.mark.parametrize("name", [b"caf\xe9.xml", b"caf\xe9/scene.xml"])
def test_names_that_mitsuba_cannot_open_are_no_obstacle(tmp_path: Path, name: bytes) -> None:
    """Of the scene or of its folder; what it names lies beside it, and below."""
    path = tmp_path / os.fsdecode(name)
    colour(path.parent / "parts", (0, 255, 0))
    inner = f'<scene version="3.0.0"><bsdf type="twosided" id="paint">{TEXTURED}</bsdf></scene>'
    write(path.parent / "parts", "paint.xml", inner)
    text = scene('<ref id="paint"/>', more='<include filename="parts/paint.xml"/>')
    write(path.parent, path.name, text)
    np.testing.assert_allclose(mean(path), (0, 1, 0), atol=NOISE)
    broken = write(path.parent, "broken" + path.name, scene("<bsdf type='none'/>"))
    with pytest.raises(ValueError, match="does not load") as caught:
        mean(broken)
    assert "gonio-" not in str(caught.value)
