"""Material files: gonio's own library, and users' files with their errors."""

from __future__ import annotations

import tomllib
import warnings
from pathlib import Path

import mitsuba as mi
import numpy as np
import pytest

import gonio
from gonio.fields import ModelError
from gonio.images import write_linear
from gonio.materials import MaterialError, library, load_material
from gonio.materials.toml_lines import lines
from gonio.messages import Notice
from gonio.mitsuba.nodes import node
from gonio.parts.metals import metal
from gonio.render import render
from gonio.render.sheets import write_sheet

# Pictures of the same paths: roundings of single precision along them.
SAME_PATHS = 1e-4


# What the library has to offer: a kind, and how many of it there are at least.
KINDS = {
    "lacquered_": 3,
    "car_paint_": 8,
    "patina_": 6,
    "_lacquer": 2,
    "_plastic": 1,
    "ceramic": 1,
    "concrete": 1,
    "clay": 1,
    "moon": 1,
    "skin": 1,
}


@pytest.fixture(autouse=True)
def _variant() -> None:
    mi.set_variant("llvm_ad_rgb")


def write(folder: Path, text: str) -> Path:
    path = folder / "clay.toml"
    path.write_text(text)
    return path


def test_the_library_has_what_it_promises() -> None:
    names = list(library())
    assert {k: sum(k in n for n in names) >= v for k, v in KINDS.items()} == dict.fromkeys(
        KINDS, True
    )
    metals = [n for n in names if load_material(n).model.name == "torrance_sparrow"]
    assert len(metals) >= 9
    colours = {n.split("_")[2] for n in names if n.startswith("car_paint_")}
    assert len(colours) == 4


@pytest.mark.parametrize("name", library())
def test_every_material_of_the_library_reflects_and_loads(name: str) -> None:
    material = load_material(name)
    assert material.description.endswith(".")
    up, tilted = [0, 0, 1], [0.6, 0, 0.8]
    f = material.model.eval(tilted, up)
    assert np.isfinite(f).all()
    assert (f >= 0).all()
    assert (material.model.albedo(tilted) < 1.0001).all()
    assert mi.load_dict(node(material)) is not None


def test_nested_files_and_metals_are_read(tmp_path: Path) -> None:
    material = load_material(
        write(
            tmp_path,
            'model = "weidlich_wilkie"\nalpha = 0.2\n[base]\nmodel = "torrance_sparrow"\nmetal = "Au"\n',
        )
    )
    assert material.model.alpha == 0.2
    assert material.model.base.eta == gonio.model("torrance_sparrow").eta  # whose default is gold


def test_a_metal_can_be_neutral(tmp_path: Path) -> None:
    text = 'model = "torrance_sparrow"\nmetal = "Fe"\nneutral = true\n'
    assert load_material(write(tmp_path, text)).model.eta == metal("Fe", neutral=True)["eta"]


def test_a_texture_drives_an_inner_parameter(tmp_path: Path) -> None:
    mi.Bitmap(np.full((2, 2, 3), 0.25, np.float32)).write(str(tmp_path / "grey.exr"))
    text = 'model = "weidlich_wilkie"\n[base]\nmodel = "lambert"\nrho = "grey.exr"\n'
    material = load_material(write(tmp_path, text))
    assert list(material.textures) == ["base.rho"]
    plain = gonio.model("weidlich_wilkie", base=gonio.Lambert(rho=0.25))
    common = {"size": (24, 24), "spp": 16, "environment": "white"}
    np.testing.assert_allclose(render(material, **common), render(plain, **common), rtol=SAME_PATHS)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            'model = "weidlich_wilkie"\n[base]\nmodel = "eno"\n',
            r"clay.toml:3: no model, .* 'eno'",
        ),
        ('model = "weidlich_wilkie"\n[base]\nrho = 1\n', r"is missing under \[base\]"),
        (
            'model = "weidlich_wilkie"\nalpha = 0.1\n\n[base]\nmodel = "eon"\nroughness = 7\n',
            r"clay.toml:6: eon: roughness=7 is out of range",
        ),
        (
            'model = "weidlich_wilkie"\nbase = 3\n',
            r"clay.toml:2: base is a model",
        ),
        ('model = "eon"\nmetal = "Au"\n', r"clay.toml:2: eon has no eta and k"),
        ('model = "torrance_sparrow"\nmetal = "Xx"\n', r"clay.toml:2: .*Xx"),
        ('model = "eon"\n[flakes]\n seed = 1\n', r"clay.toml:1: eon has no flake_x.* is car_paint"),
        ('model = "eon"\n[Flakes]\n seed = 1\n', r"clay.toml:2: eon has no 'Flakes'.* 'flakes'\?"),
        (
            'model = "weidlich_wilkie"\n[base]\nmodel = "eon"\n[base.flakes]\nseed = 1\n',
            r"clay.toml:4: flakes is for the whole file",
        ),
        ('model = "car_paint"\n[flakes]\nsize = 3\n', r"clay.toml:3: .*flake_size=4 is larger"),
        (
            'model = "car_paint"\n[flakes]\nsede = 1\n',
            r"clay.toml:3: flakes: no setting 'sede'; did you mean 'seed'",
        ),
        (
            'model = "car_paint"\n[flakes]\nseed = "a"\n',
            r"clay.toml:3: flakes: seed must be a whole number, got 'a'; allowed is 0 to 4294967295",
        ),
        ('model = "car_paint"\nflakes = 3\n', r"clay.toml:2: flakes is a table"),
        ('model = "eon"\ngrowth = "mesh"\n', r"clay.toml:1: eon has no growth"),
        ('model = "eon"\ndescription = 3\n', r"clay.toml:2: description must be a text"),
        (
            'model = "weidlich_wilkie"\nbase.model = "eon"\nbase.roughness = 7\n',
            r"clay.toml:3: eon: roughness=7 is out of range",
        ),
        (
            'model = "weidlich_wilkie"\n\nbase = { model = "eon", roughness = 7 }\n',
            r"clay.toml:3: eon: roughness=7 is out of range",
        ),
        (
            'model = "weidlich_wilkie"\n"base" . model = "eon" # base.rho = 1\nbase.rho = [\n 7, 1]\n',
            r"clay.toml:3: eon: rho takes",
        ),
        ('model = "weidlich_wilkie"\n\nbase = { rho = 1 }\n', r"clay.toml:3: .*missing under"),
        (
            'model = "car_paint"\nflakes.size = 64\nflakes.seed = "a"\n',
            r"clay.toml:3: flakes: seed must",
        ),
        (
            'model = "eon"\ndescription = """\nrho = 1\n[base]\n"""\nrho = 7\n',
            r"clay.toml:6: eon: rho=7",
        ),
    ],
)
def test_a_bad_file_names_the_line(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(MaterialError, match=message):
        load_material(write(tmp_path, text))


EVERY_KIND_OF_KEY = r"""# c = 0
a = 1  # b = 2
b.c = [1, { d = 2 },
  'x = ]', # ]
  { e = "}" }]
[ t . "u v" ]
f = '''
g = 1
'''
h = "[z]\" = 3"
i = 1979-05-27 07:32:00
[[l]]
j = -inf
[[l]]
k = {}
"""


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_every_key_of_a_file_has_the_line_in_which_it_is_first_named(end: str) -> None:
    expected = {"a": 2, "b": 3, "b.c": 3, "b.c.d": 3, "b.c.e": 5, "t": 6, "t.u v": 6}
    expected |= {"t.u v.f": 7, "t.u v.h": 10, "t.u v.i": 11, "l": 12, "l.j": 13, "l.k": 15}
    text = EVERY_KIND_OF_KEY.replace("\n", end)
    assert tomllib.loads(text)
    assert lines(text) == expected


def test_keys_with_escapes_have_their_line_too(tmp_path: Path) -> None:
    text = 'model = "eon"\n\n"ro\\u0075ghness" = 7\n'
    with pytest.raises(MaterialError, match=r"clay\.toml:3: .*roughness=7 is out of range"):
        load_material(write(tmp_path, text))
    assert lines('"a\\"b" = 1\n"\\\\" = 2') == {'a"b': 1, "\\": 2}


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b'model = "eon"\n# caf\xe9\n', r"a\.toml:2: .*save it as UTF-8"),
        (b'model = "eon"\nrho = 1' + b"0" * 5000, r"a\.toml: a number in it has too many digits"),
    ],
)
def test_what_tomllib_cannot_read_names_the_file(tmp_path, content: bytes, message: str) -> None:
    (tmp_path / "a.toml").write_bytes(content)
    with pytest.raises(MaterialError, match=message):
        load_material(tmp_path / "a.toml")


def test_names_of_models_and_materials_are_found() -> None:
    assert repr(gonio.load("eon:roughness=1")) == "EON(roughness=1.0)"
    assert gonio.load("gold").name == "gold"
    with pytest.raises(ModelError, match=r"did you mean the material 'gold'\?"):
        gonio.load("godl")
    with pytest.raises(ModelError, match=r"did you mean the model 'eon'\?"):
        gonio.load("eno")
    with pytest.raises(FileNotFoundError, match=r"did you mean 'gold'\? 'gonio list --materials'"):
        load_material("golt")


def test_a_sheet_shows_every_material(tmp_path: Path) -> None:
    from PIL import Image

    seen: list[tuple[int, int]] = []
    shown = [load_material(n) for n in ("clay", "moon", "plaster")]
    target = tmp_path / "sheet.png"
    write_sheet(
        target, shown, columns=2, cell=24, spp=1, progress=lambda n, of: seen.append((n, of))
    )
    picture = np.asarray(Image.open(target))
    assert picture.shape[1] == 48
    assert picture.shape[0] > 48
    assert seen[-1][0] == seen[-1][1]
    with pytest.raises(ValueError, match=r"the suffix must be .png"):
        write_sheet(tmp_path / "a.exr", shown)


def test_a_material_file_is_read(tmp_path: Path) -> None:
    material = load_material(
        write(tmp_path, 'model = "eon"\nrho = [0.6, 0.3, 0.2]\nroughness = 1\nsampler = "cosine"\n')
    )
    assert material.name == "clay"
    assert material.model.rho == (0.6, 0.3, 0.2)
    assert material.model.roughness == 1
    assert material.model.sampler == "cosine"


def test_a_texture_drives_a_parameter(tmp_path: Path) -> None:
    mi.Bitmap(np.full((2, 2, 3), 0.25, np.float32)).write(str(tmp_path / "grey.exr"))
    material = load_material(write(tmp_path, 'model = "lambert"\nrho = "grey.exr"\n'))
    common = {"size": (24, 24), "spp": 16}
    plain = render(gonio.Lambert(rho=0.25), **common)
    np.testing.assert_allclose(render(material, **common), plain, rtol=SAME_PATHS)


def picture(kind: str, path: Path) -> None:
    """One of the pictures that a material may name."""
    from PIL import Image

    noise = np.random.default_rng(0).integers(0, 255, (16, 16, 3)).astype(np.uint8)
    if kind == "cut":
        Image.fromarray(noise).save(path)
        path.write_bytes(path.read_bytes()[:300])
    elif kind == "nan":
        mi.Bitmap(np.full((2, 2, 3), np.nan, np.float32)).write(str(path))
    elif kind == "cmyk":
        Image.new("CMYK", (4, 4)).save(path)
    elif kind == "colours":
        Image.fromarray(noise).save(path)
    else:
        path.write_bytes({"empty": b"", "text": b"some words"}[kind])


@pytest.mark.parametrize(
    ("kind", "suffix", "reason"),
    [
        ("cut", ".png", "cut short"),
        ("empty", ".png", "an empty file"),
        ("text", ".jpg", "not a picture"),
        ("text", ".exr", "not an OpenEXR file"),
        ("nan", ".exr", "4 pixels that are NaN or infinite"),
        ("cmyk", ".jpg", "CMYK"),
        ("text", ".gif", "must end in"),
    ],
)
def test_a_bad_texture_names_file_parameter_line_and_reason(
    tmp_path: Path, kind: str, suffix: str, reason: str
) -> None:
    picture(kind, tmp_path / f"p{suffix}")
    text = f'model = "weidlich_wilkie"\n\n[base]\nmodel = "eon"\nrho = "p{suffix}"\n'
    with pytest.raises(MaterialError, match=rf"clay.toml:5: rho: picture .*p\{suffix}: .*{reason}"):
        load_material(write(tmp_path, text))


def test_a_number_never_takes_the_luminance_of_colours_without_a_word(tmp_path: Path) -> None:
    picture("colours", tmp_path / "orm.png")
    with pytest.raises(MaterialError, match=r"clay.toml:2: roughness: .*':r', ':g', ':b'"):
        load_material(write(tmp_path, 'model = "eon"\nroughness = "orm.png"\n'))
    with pytest.raises(MaterialError, match=r"clay.toml:2: rho: .*takes the whole picture"):
        load_material(write(tmp_path, 'model = "eon"\nrho = "orm.png:g"\n'))
    with pytest.raises(MaterialError, match=r"clay.toml:2: roughness: .*no channel a"):
        load_material(write(tmp_path, 'model = "eon"\nroughness = "orm.png:a"\n'))


def test_a_channel_drives_a_number_as_it_is_stored(tmp_path: Path) -> None:
    from PIL import Image

    Image.new("RGB", (4, 4), (10, 51, 200)).save(tmp_path / "orm.png")
    material = load_material(write(tmp_path, 'model = "eon"\nroughness = "orm.png:g"\n'))
    assert material.channels == {"roughness": "g"}
    common = {"size": (24, 24), "spp": 16}
    plain = render(gonio.EON(roughness=51 / 255), **common)
    np.testing.assert_allclose(render(material, **common), plain, rtol=SAME_PATHS)
    Image.new("RGB", (4, 4), (51, 51, 51)).save(tmp_path / "grey.png")  # no choice to make
    grey = load_material(write(tmp_path, 'model = "eon"\nroughness = "grey.png"\n'))
    np.testing.assert_allclose(render(grey, **common), plain, rtol=SAME_PATHS)


def test_values_of_a_picture_out_of_range_are_said(tmp_path: Path) -> None:
    values = np.full((2, 4, 3), 0.5, np.float32)
    values[0, 1, 2] = -0.25
    values[1, 3, 0] = 9
    write_linear(tmp_path / "a.exr", values)
    (tmp_path / "a.toml").write_text('model = "eon"\nrho = "a.exr"\n')
    said = r"a.toml:2: rho: .* 2 of 8 pixels are out of range \(0 to 1\).* -0.25 to 9"
    with pytest.warns(Notice, match=said):
        gonio.load(tmp_path / "a.toml")
    write_linear(tmp_path / "a.exr", np.clip(values, -5e-4, 1 + 5e-4))  # what compression does
    with warnings.catch_warnings():
        warnings.simplefilter("error", Notice)
        gonio.load(tmp_path / "a.toml")


def test_a_normal_map_is_read_when_it_is_named(tmp_path: Path) -> None:
    from PIL import Image

    Image.new("L", (2, 2)).save(tmp_path / "grey.png")
    (tmp_path / "a.toml").write_text('model = "eon"\nnormal_map = "grey.png"\n')
    with pytest.raises(
        MaterialError, match=r"a.toml:2: normal_map: picture .*grey.png: it is grey"
    ):
        gonio.load(tmp_path / "a.toml")


def test_coloured_pictures_are_srgb_in_every_format(tmp_path: Path) -> None:
    from PIL import Image

    code = 188  # linear 0.50289, IEC 61966-2-1
    plain = render(gonio.Lambert(rho=0.50289), size=(24, 24), spp=16)
    for suffix in (".png", ".tif", ".webp"):
        lossless = {"lossless": True} if suffix == ".webp" else {}
        Image.new("RGB", (4, 4), (code,) * 3).save(tmp_path / f"p{suffix}", **lossless)
        material = load_material(write(tmp_path, f'model = "lambert"\nrho = "p{suffix}"\n'))
        shown = render(material, size=(24, 24), spp=16)
        np.testing.assert_allclose(shown, plain, rtol=SAME_PATHS)


def test_a_texture_on_a_mesh_without_uvs_is_one_sentence_and_uv_gives_some(tmp_path: Path) -> None:
    mi.Bitmap(np.full((2, 2, 3), 0.25, np.float32)).write(str(tmp_path / "grey.exr"))
    material = load_material(write(tmp_path, 'model = "lambert"\nrho = "grey.exr"\n'))
    (tmp_path / "m.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    common = {"mesh": tmp_path / "m.obj", "size": (16, 16), "spp": 4}
    with pytest.raises(ValueError, match=r"no texture coordinates, and rho of .* --uv box or --uv"):
        render(material, **common)
    flaky = load_material("car_paint_red_strong")
    with pytest.raises(ValueError, match="and the flakes of the material"):
        render(flaky, **common)
    plain = render(gonio.Lambert(rho=0.25), **common)
    for projection in ("box", "sphere"):
        shown = render(material, uv=projection, **common)
        np.testing.assert_allclose(shown, plain, rtol=SAME_PATHS)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('model = "eon"\nrougness = 1\n', r"clay.toml:2: eon has no 'rougness'; did you mean"),
        ('model = "eon"\n\nroughness = 3\n', r"clay.toml:3: eon: roughness=3 is out of range"),
        (
            '# x\nmodel = "eno"\n',
            r"clay.toml:2: .* did you mean the model 'eon'",
        ),
        ("roughness = 1\n", r"the line 'model = \"NAME\"' is missing"),
        (
            'model = "eon"\nrho = "none.png"\n',
            r"clay.toml:2: rho names a picture that does not exist",
        ),
        ('model = "eon"\nrho = "#12345"\n', r"clay.toml:2: rho: #12345 is not a colour such as"),
        (
            'model = "eon"\nroughness = "#888"\n',
            r"clay.toml:2: roughness takes one number, and #888",
        ),
        ('model = "eon"\nroughness = \n', r"not a TOML file: .*line 2"),
        ('model = "eon"\nroughness = [1, 2]\n', r"clay.toml:2: eon: roughness takes one number"),
        ("model = 3\n", r"clay.toml:1: model must be a name in quotes, got 3"),
        (
            'model = "eon"\nroughness = 2020-01-01\n',
            r"clay.toml:2: eon: roughness must be a number",
        ),
        ('model = ["eon"]\n', r"clay.toml:1: model must be a name in quotes"),
    ],
)
def test_a_bad_material_file_names_the_line(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(MaterialError, match=message):
        load_material(write(tmp_path, text))


def test_binary_and_missing_material_files_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "clay.toml"
    with pytest.raises(FileNotFoundError, match="there is no material file"):
        load_material(path)
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(MaterialError, match="not a TOML file"):
        load_material(path)


# --- normal maps and repeated pictures -------------------------------------------------------------


def test_a_flat_normal_map_changes_nothing_and_a_tilted_one_turns_the_light(tmp_path: Path) -> None:
    from PIL import Image

    common = {"size": (24, 24), "spp": 16, "environment": "side"}
    plain = render(gonio.Lambert(), **common)
    # 128 / 255 is as near to 0.5 as 8 bits come: a tilt of 0.2 degrees
    for name, code, limit in (("flat", (128, 128, 255), 0.02), ("tilted", (218, 128, 218), None)):
        Image.new("RGB", (2, 2), code).save(tmp_path / f"{name}.png")
        text = f'model = "lambert"\nnormal_map = "{name}.png"\n'
        shown = render(load_material(write(tmp_path, text)), **common)
        difference = np.abs(shown - plain).max()
        assert difference < limit if limit else difference > 0.05


def test_a_picture_repeats_as_often_as_the_file_says(tmp_path: Path) -> None:
    from PIL import Image

    stripes = np.zeros((1, 2, 3), np.uint8)
    stripes[:, 1] = 255
    Image.fromarray(stripes).save(tmp_path / "stripes.png")
    Image.fromarray(np.tile(stripes, (1, 3, 1))).save(tmp_path / "more.png")
    once = 'model = "lambert"\nrho = "more.png"\n'
    thrice = 'model = "lambert"\ntexture_scale = [3, 1]\nrho = "stripes.png"\n'
    common = {"size": (24, 24), "spp": 16, "environment": "white"}
    # Pixels between texels are interpolated over another distance.
    difference = render(load_material(write(tmp_path, once)), **common) - render(
        load_material(write(tmp_path, thrice)), **common
    )
    assert np.abs(difference).mean() < 0.02


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('model = "eon"\ntexture_scale = 2\n', r":2: texture_scale is for pictures"),
        ('model = "eon"\ntexture_scale = [1, 2, 3]\n', r":2: texture_scale is a number above 0"),
        ('model = "eon"\ntexture_scale = 0\n', r":2: texture_scale is a number above 0"),
        ('model = "eon"\nnormal_map = 3\n', r":2: normal_map is a picture in quotes"),
        ('model = "eon"\nnormal_map = "n.png"\n', r":2: normal_map names a picture that does not"),
    ],
)
def test_wrong_maps_and_scales_have_their_line(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(MaterialError, match=message):
        load_material(write(tmp_path, text))
