"""Denoised pictures are nearer to the truth than what they were made from, and nothing else changes."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

import gonio
from gonio.cli import main
from gonio.materials import load
from gonio.render import denoise, sheets
from gonio.render.passes import ready_mitsuba
from gonio.render.user_scene import render_scene

pytest.importorskip("mitsuba_oidn")


def error(pixels: np.ndarray, truth: np.ndarray) -> float:
    return float(np.sqrt(np.mean((pixels[..., :3] - truth) ** 2)))


def test_a_denoised_picture_is_nearer_to_the_truth_and_as_bright() -> None:
    truth = gonio.render("eon", size=(64, 64), spp=400, rfilter="box")
    noisy = gonio.render("eon", size=(64, 64), spp=4, seed=1, rfilter="box")
    calm = gonio.render("eon", size=(64, 64), spp=4, seed=1, denoise=True)
    # Half: measured a third. With smeared noise, of a wider filter, next to nothing is won.
    assert error(calm, truth) < 0.5 * error(noisy, truth)
    # Light moves between neighbours; it is not lost: the noise of the whole is below 1 %.
    assert float(calm.mean()) == pytest.approx(float(truth.mean()), rel=0.03)


def test_alpha_stays_as_it_is() -> None:
    settings = {"size": (48, 48), "spp": 4, "transparent": True}
    plain = gonio.render("eon", rfilter="box", **settings)
    calm = gonio.render("eon", denoise=True, **settings)
    assert calm.shape == (48, 48, 4)
    np.testing.assert_array_equal(calm[..., 3], plain[..., 3])
    assert not np.array_equal(calm[..., :3], plain[..., :3])


def test_colours_and_normals_are_of_what_each_pixel_sees_first() -> None:
    ready_mitsuba()
    scene = gonio.render.scene(
        gonio.EON(rho=(0.6, 0.3, 0.1), roughness=0.5),
        environment="white",
        size=(33, 33),
        spp=4,
        furnace=True,
    )
    colours, normals = denoise.first_seen(scene)
    # A point of the shell right of its cut
    seen = colours[16, 23], normals[16, 23]
    mean = gonio.EON(rho=(0.6, 0.3, 0.1), roughness=0.5).mean_albedo()
    # A look at which colour it is: 4 samples, light that bounced inside the shell, half floats
    assert seen[0][0] / seen[0][2] == pytest.approx(mean[0] / mean[2], rel=0.5)
    assert np.linalg.norm(seen[1]) == pytest.approx(1, abs=0.02)
    assert seen[1][0] > 0.5  # it faces right
    assert colours[0, 0] == pytest.approx(0), "nothing is seen in the corner"


@pytest.mark.parametrize("name", ["patina_3", "car_paint_red_strong"])
def test_growth_and_flakes_are_not_integrated_at_every_point(name: str) -> None:
    """Their albedos are integrals: at each sample of a small picture they took minutes."""
    assert denoise.stand_in(load(name)).name == "lambert"


SCENE = """<scene version="3.0.0"><integrator type="path"/>
  <sensor type="orthographic">
    <transform name="to_world"><lookat origin="0, 0, 4" target="0, 0, 0" up="0, 1, 0"/></transform>
    {film}<sampler type="independent"/>
  </sensor>
  <emitter type="constant"/><shape type="sphere" id="ball"/></scene>"""


def test_a_scene_is_denoised_whatever_film_and_filter_it_has(tmp_path: Path) -> None:
    film = '<film type="hdrfilm"><integer name="width" value="48"/>{rfilter}</film>'
    films = ["", *(film.format(rfilter=f'<rfilter type="{f}"/>') for f in ("mitchell", "box"))]

    def picture(film: str, **more: Any) -> np.ndarray:
        path = tmp_path / "scene.xml"
        path.write_text(SCENE.format(film=film))
        return render_scene(path, {"ball": gonio.EON(roughness=1)}, size=(48, 48), **more)

    calm, *others = (picture(film, spp=4, denoise=True) for film in films)
    for other in others:
        # Threads add samples in their own order, and the network works with half floats
        np.testing.assert_allclose(other, calm, atol=5e-3)
    noisy, truth = (picture(films[-1], spp=spp) for spp in (4, 400))
    # Half, as above
    assert error(calm, truth) < 0.5 * error(noisy, truth)


def test_small_numbers_are_still_there_afterwards() -> None:
    """Some libraries leave the thread that calls them flushing to zero."""
    gonio.render("eon", size=(16, 16), spp=1, denoise=True)
    assert np.float32(1e-40) * np.float32(0.5) > 0


def test_without_the_package_one_line_tells_what_to_install(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(sys.modules, "mitsuba_oidn", None)
    with pytest.raises(ValueError, match=r"pip install 'gonio\[denoise\]'\.$"):
        gonio.render("gold", size=(16, 16), denoise=True)


def test_a_filter_that_smears_noise_is_refused() -> None:
    with pytest.raises(ValueError, match="leave rfilter='gaussian' out"):
        gonio.render("eon", size=(16, 16), denoise=True, rfilter="gaussian")


COMMANDS = (["render", "gold"], ["series", "patina"], ["sheet"])


@pytest.mark.parametrize("command", COMMANDS)
def test_commands_refuse_what_they_cannot_do(command: list[str]) -> None:
    run = CliRunner().invoke(main, [*command, "--denoise", "--cluster", "local"])
    assert run.exit_code == 2
    assert "--denoise is for pictures that are rendered here" in run.output


@pytest.mark.parametrize("command", COMMANDS)
def test_commands_hand_it_on_and_stop_earlier(
    command: list[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    asked: list[dict[str, Any]] = []

    def instead(*_: Any, **settings: Any) -> np.ndarray:
        asked.append(settings)
        return np.zeros((16, 16, 3), np.float32)

    monkeypatch.setattr(sheets, "compare", instead)
    monkeypatch.setattr(sheets, "write_sheet", instead)
    output = ["-o", str(tmp_path / "a.png")]
    for more in ([], ["--denoise"], ["--denoise", "--noise", "0.3"]):
        if more[2:] and command == ["sheet"]:
            continue  # it takes a number of samples
        assert CliRunner().invoke(main, [*command, *more, *output]).exit_code == 0
    assert [settings["denoise"] for settings in asked] == [False, True, True][: len(asked)]
    # What docs/guides/artist.md says
    goals = [settings["noise"] for settings in asked if "noise" in settings]
    assert goals in ([0.02, 0.1, 0.3], [])
