"""Pictures: what is rendered, what is written, and what stays behind when something fails."""

from __future__ import annotations

import inspect
import math
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np
import pytest
from support.tolerances import SINGLE_LONG

import gonio
from gonio.files import replacing
from gonio.materials import load, load_material, load_series
from gonio.messages import Notice
from gonio.render import passes, render
from gonio.render.passes import _passes
from gonio.render.picture import captions, describe, write_picture
from gonio.render.sheets import compare, demo
from gonio.render.user_scene import render_scene

SMALL: Any = {"size": (32, 24), "spp": 4}

SCENE = """<scene version="3.0.0">
  <integrator type="direct"/>
  <sensor type="orthographic">
    <transform name="to_world"><lookat origin="0, 0, 4" target="0, 0, 0" up="0, 1, 0"/></transform>
    <film type="hdrfilm"><integer name="width" value="16"/><integer name="height" value="16"/>
      <string name="pixel_format" value="rgb"/></film>
    <sampler type="independent"><integer name="sample_count" value="16"/></sampler>
  </sensor>
  <emitter type="constant"/>
  <bsdf type="diffuse" id="paint"><rgb name="reflectance" value="0.1, 0.1, 0.1"/></bsdf>
  <shape type="rectangle" id="wall">
    <transform name="to_world"><scale value="5"/></transform>
    {bsdf}
  </shape>
</scene>"""


@pytest.fixture(autouse=True)
def _variant() -> None:
    mi.set_variant("llvm_ad_rgb")


def test_the_seed_decides_the_picture() -> None:
    model = gonio.EON(roughness=1)
    first = render(model, **SMALL)
    assert first.shape == (24, 32, 3)
    assert first.dtype == np.float32
    # Threads add their samples to a pixel in any order, so the last bit may differ.
    np.testing.assert_allclose(first, render(model, **SMALL), rtol=1e-5)
    assert np.abs(first / render(model, seed=1, **SMALL) - 1).max() > 1e-2


def test_passes_are_squares_that_add_up() -> None:
    for spp in (1, 7, 16, 50, 64, 100, 1000):
        for limit in (1, 5, 16, 40, 1000):
            counts = list(_passes(spp, limit))
            assert sum(counts) == spp
            assert all(math.isqrt(n) ** 2 == n and n <= limit for n in counts)


def test_progress_arrives_at_the_end() -> None:
    seen: list[tuple[int, int]] = []
    render(gonio.Lambert(), size=(16, 16), spp=20, progress=lambda n, of: seen.append((n, of)))
    assert seen == [(16, 20), (20, 20)]


def test_large_pictures_are_made_of_bands_without_a_seam(monkeypatch: pytest.MonkeyPatch) -> None:
    from gonio.render import passes

    # A black ball before white: all noise is at its rim.
    black: Any = {"size": (32, 24), "spp": 4, "furnace": True}
    whole = render(gonio.Lambert(rho=0), **black)
    monkeypatch.setattr(passes, "PATHS_PER_PASS", 32 * 5)
    seen: list[tuple[int, int]] = []
    banded = render(gonio.Lambert(rho=0), **black, progress=lambda n, of: seen.append((n, of)))
    assert len(seen) == 4 * 5  # each of four passes of one sample in five bands
    assert seen[-1] == (4, 4)
    # 0.1: one to two of 32 pixels of a row are on the rim, and miss by up to 1; a band that is a row off
    # misses by the rim's slope everywhere, one put in another's place by a third.
    assert np.abs(whole - banded).mean(axis=(1, 2)).max() < 0.1
    inside = whole[:, :, 0] < 1e-3
    assert 40 < inside.sum() < 400
    # Samples of a pixel inside may see a little of the rim beside it
    np.testing.assert_allclose(banded[inside], 0, atol=0.2)


@pytest.mark.parametrize(
    ("pixel_format", "expected"),
    [
        # The wall reflects all of a light whose radiance is linear sRGB (1, 0.5, 0.25).
        ("rgb", (1, 0.5, 0.25)),
        ("rgba", (1, 0.5, 0.25)),
        ("xyz", (1, 0.5, 0.25)),
        ("xyza", (1, 0.5, 0.25)),
        # Its luminance, ITU-R BT.709: 0.2126 + 0.7152 / 2 + 0.0722 / 4
        ("luminance", (0.58825,) * 3),
        ("luminance_alpha", (0.58825,) * 3),
    ],
)
def test_a_films_pixels_are_shown_as_what_they_are(
    tmp_path: Path, pixel_format: str, expected: tuple[float, ...]
) -> None:
    text = SCENE.format(bsdf='<bsdf type="diffuse"><rgb name="reflectance" value="1,1,1"/></bsdf>')
    text = text.replace('value="rgb"', f'value="{pixel_format}"')
    text = text.replace(
        '<emitter type="constant"/>',
        '<emitter type="constant"><rgb name="radiance" value="1,0.5,0.25"/></emitter>',
    )
    path = tmp_path / "scene.xml"
    path.write_text(text)
    pixels = render_scene(path, {}, spp=64)
    # 2 %: Mitsuba's XYZ has rounded coefficients; noise of 16,000 samples
    np.testing.assert_allclose(pixels.mean((0, 1)), expected, rtol=0.02)


def test_white_eon_disappears_in_the_furnace_and_qon_does_not() -> None:
    white = {"size": (48, 48), "spp": 64, "furnace": True}
    eon = render(gonio.EON(rho=1, roughness=1), **white)
    qon = render(gonio.QON(rho=1, sigma=math.pi / 2), **white)
    # The noise of 48 x 48 pixels with 64 samples each
    assert abs(float(eon.mean()) - 1) < 2e-3
    assert float(qon[20:28, 20:28].mean()) < 0.8


@pytest.mark.parametrize(
    ("bsdf", "name"),
    [('<ref id="paint"/>', "paint"), ('<ref id="paint"/>', "wall"), ("", "wall")],
)
def test_a_users_scene_gets_the_model(tmp_path: Path, bsdf: str, name: str) -> None:
    """A plane seen at right angles under radiance 1 shows the albedo at the normal, a closed form."""
    path = tmp_path / "scene.xml"
    path.write_text(SCENE.format(bsdf=bsdf))
    before = path.read_bytes()
    qon = gonio.QON(rho=(0.9, 0.5, 0.2), sigma=1.2)
    pixels = render_scene(path, {name: qon}, spp=256)
    A = 1 - 0.5 * 1.2**2 / (1.2**2 + 0.33)  # G_Q = 0 at the normal
    # The noise of 256 samples
    np.testing.assert_allclose(pixels.mean((0, 1)), A * np.array([0.9, 0.5, 0.2]), rtol=5e-3)
    assert path.read_bytes() == before
    assert render_scene(path, {}, size=(8, 4)).shape == (4, 8, 3)


@pytest.mark.parametrize(
    ("text", "assign", "message"),
    [
        (
            SCENE.format(bsdf=""),
            {"wal": "lambert"},
            r"no shape or bsdf with the id 'wal'; ids: paint, wall",
        ),
        ("<scene>", {}, r"is not an XML file"),
        ("<mesh/>", {}, r"its root is <mesh>, not <scene>"),
        ('<scene version="3.0.0"/>', {}, r"has no <sensor>"),
        (SCENE.format(bsdf='<bsdf type="difuse"/>'), {}, r"does not load: .*difuse"),
    ],
)
def test_a_bad_scene_gets_one_clear_line(
    tmp_path: Path, text: str, assign: dict[str, str], message: str
) -> None:
    path = tmp_path / "scene.xml"
    path.write_text(text)
    with pytest.raises(ValueError, match=message) as caught:
        render_scene(path, {k: gonio.model(v) for k, v in assign.items()})
    assert "\n" not in str(caught.value)


def test_a_missing_scene_is_named(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match="no scene file"):
        render_scene(tmp_path / "none.xml", {})


def test_pictures_are_srgb_and_labelled(tmp_path: Path) -> None:
    from PIL import Image

    pixels = np.full((40, 80, 3), 0.5, np.float32)
    write_picture(tmp_path / "a.png", pixels, labels=["left", "right"], row_labels=["row"])
    picture = np.asarray(Image.open(tmp_path / "a.png"))
    assert picture.shape[0] > 40
    assert picture.shape[1] > 80
    write_picture(tmp_path / "b.png", pixels)
    # IEC 61966-2-1: linear 0.5 is 187.5 of 255, linear 0.25 is 136.96
    assert abs(int(np.asarray(Image.open(tmp_path / "b.png"))[5, 5, 0]) - 188) <= 1
    write_picture(tmp_path / "b.png", pixels, exposure=-1)
    assert abs(int(np.asarray(Image.open(tmp_path / "b.png"))[5, 5, 0]) - 137) <= 1
    write_picture(tmp_path / "c.exr", pixels)
    np.testing.assert_array_equal(np.array(mi.Bitmap(str(tmp_path / "c.exr"))), pixels)


def test_a_failed_write_leaves_nothing_and_keeps_the_old_file(tmp_path: Path) -> None:
    target = tmp_path / "a.png"
    target.write_text("old")

    with pytest.raises(KeyboardInterrupt), replacing(target) as temporary:  # noqa: PT012
        temporary.write_text("half")
        raise KeyboardInterrupt
    with pytest.raises(ValueError, match="not finite"):
        write_picture(target, np.full((2, 2, 3), np.nan, np.float32))
    with pytest.raises(ValueError, match=r"a.jpg'; the suffix must be .png or .exr"):
        write_picture(tmp_path / "a.jpg", np.zeros((2, 2, 3), np.float32))
    with pytest.raises(FileNotFoundError, match="no folder"):
        write_picture(tmp_path / "none" / "a.png", np.zeros((2, 2, 3), np.float32))
    assert target.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["a.png"]


def test_comparison_puts_materials_side_by_side() -> None:
    models = [gonio.Lambert(rho=0.2), gonio.Lambert(rho=0.9)]
    sheet = compare([{}, {"environment": "white"}], models, **SMALL)
    assert sheet.shape == (48, 64, 3)
    np.testing.assert_allclose(sheet[:24, :32], render(models[0], **SMALL), rtol=SINGLE_LONG)
    np.testing.assert_allclose(
        sheet[24:, 32:], render(models[1], environment="white", **SMALL), rtol=SINGLE_LONG
    )


def test_a_series_is_the_numbered_materials_in_order() -> None:
    steps = load_series("patina")
    extents = [-0.65, -0.05, 0.15, 0.45, 0.75, 1.65]  # Elek's Figure 8
    assert [getattr(step.model, "extent") for step in steps] == extents  # noqa: B009
    assert captions(steps) == [f"extent {extent:g}".replace("-", "−") for extent in extents]
    with pytest.raises(ValueError, match="no series of materials 'patena'; known are patina"):
        load_series("patena")


def test_captions_name_all_that_differs_and_nothing_else() -> None:
    red, blue = (load_material(f"car_paint_{c}_strong") for c in ("red", "blue"))
    assert captions([red, blue]) == ["sigma_a 0.12/1.6/1.9", "sigma_a 1.9/0.9/0.12"]


def test_demo_writes_its_strip(tmp_path: Path) -> None:
    seen: list[tuple[int, int]] = []
    (path,) = demo(tmp_path / "out", cell=24, spp=1, progress=lambda n, of: seen.append((n, of)))
    assert path.is_file()
    assert seen[-1][0] == seen[-1][1]
    assert sorted(n / of for n, of in seen) == [n / of for n, of in seen]


def test_labels_say_what_differs() -> None:
    assert describe(gonio.EON()) == "eon"
    assert describe(gonio.EON(roughness=1, rho=(0.1, 0.2, 0.3), sampler="cosine")) == (
        "eon rho=0.1/0.2/0.3 roughness=1 cosine"
    )


def test_a_model_file_is_rendered_as_it_is(tmp_path: Path) -> None:
    text = Path(str(inspect.getsourcefile(gonio.Lambert))).read_text(encoding="utf-8")
    (tmp_path / "my_clay.py").write_text(text, encoding="utf-8")
    mine = render(load(f"{tmp_path / 'my_clay.py'}:rho=0.5"), **SMALL)
    np.testing.assert_allclose(mine, render(gonio.Lambert(rho=0.5), **SMALL), rtol=SINGLE_LONG)


# --- until the noise is below a goal ---------------------------------------------------------------


def test_noise_is_the_error_that_another_picture_shows() -> None:
    """The spread of passes foretells how far two pictures with other random numbers are apart."""
    rng = np.random.default_rng(0)
    found = passes.Noise((64, 64))
    for _ in range(16):
        found.add(1 + 0.4 * rng.normal(size=(64, 64, 1)).repeat(3, 2).astype(np.float32))
    # 0.4 / sqrt(16) over 1 + NOISE_BLACK
    assert found.value() == pytest.approx(0.1 / 1.05, rel=0.05)


def test_a_noisier_material_gets_more_samples_and_both_end_at_the_goal() -> None:
    taken: dict[str, list[float]] = {"eon": [], "gold": []}

    class Counted(passes.Noise):
        def value(self) -> float:
            taken[name].append(super().value())
            return taken[name][-1]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(passes, "Noise", Counted)
        for name in taken:
            render(name, size=(24, 24), spp=512, noise=0.02)
    assert all(values[-1] <= 0.02 < values[-2] for values in taken.values())
    assert len(taken["gold"]) > len(taken["eon"])


def test_samples_and_time_are_limits() -> None:
    done: list[tuple[int, int]] = []
    common = {"size": (16, 16), "progress": lambda n, of: done.append((n, of))}
    with pytest.warns(Notice, match="the noise is not known after 32 samples per pixel; the goal"):
        render("gold", spp=32, noise=1e-9, **common)
    assert done[-1] == (32, 32)
    whole = len(done)
    render("gold", spp=512, seconds=1e-9, **common)
    assert len(done) - whole < 8  # one pass, and the end


def test_a_goal_gives_the_mean_of_the_same_passes() -> None:
    exact = render("eon", size=(16, 16), spp=64)
    with pytest.warns(Notice, match="the goal of 1e-07 % takes more samples or time"):
        until = render("eon", size=(16, 16), spp=64, noise=1e-9)
    assert abs(until.mean() / exact.mean() - 1) < 0.02
