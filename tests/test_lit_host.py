"""Cube maps and tables as files, and the host that lights a sphere with them."""

from __future__ import annotations

import functools
import json
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from support.tolerances import HALF

import gonio
import gonio.mitsuba
from gonio.bake import cube
from gonio.bake.environment import Environment
from gonio.bake.prefiltered import Prefiltered
from gonio.bake.split_sum import split_sum_table
from gonio.cli import main
from gonio.lights.shading import shade

HOSTS = Path(__file__).parent.parent / "examples/hosts"
SIZE = 64


@functools.cache
def sky() -> Environment:
    """Another colour on every side, and two soft lamps."""
    rows, columns = 65, 128
    theta = np.pi * np.arange(rows)[:, None] / (rows - 1)
    phi = 2 * np.pi * (np.arange(columns)[None] + 0.5) / columns
    x, y, z = np.sin(theta) * np.sin(phi), np.cos(theta) + 0 * phi, -np.sin(theta) * np.cos(phi)
    w = np.stack([x, y, z], -1)

    def lamp(towards: Any, width: float, colour: Any) -> Any:
        direction = np.asarray(towards) / np.linalg.norm(towards)
        return np.exp(width * (w @ direction - 1))[..., None] * np.asarray(colour)

    above = 0.25 + 0.2 * np.maximum(y, 0)[..., None] * [0.5, 0.8, 1.3]
    return Environment(
        above + lamp((1, 1, 1), 40, (6, 5, 4)) + lamp((-1, 0.3, 0.5), 20, (1, 1.5, 3))
    )


@functools.cache
def baked() -> cube.Cube:
    return cube.prefiltered(sky(), 64)


# Linear between texels of 1.4 degrees, over the whole sphere; and between the levels of two widths.
TEXELS, BETWEEN = 0.01, 0.03


def test_a_cube_shows_the_blurred_picture_at_its_levels_and_between() -> None:
    assert [level.shape[1] for level in baked().levels] == [64, 32, 16, 8, 4, 2]
    assert cube.error(baked(), sky(), 0.04) < TEXELS
    assert cube.error(baked(), sky(), 0.09) < BETWEEN
    w = np.random.default_rng(1).normal(size=(500, 3))
    w /= np.linalg.norm(w, axis=1, keepdims=True)
    exact = sky().radiance(w)
    assert np.abs(baked().radiance(w, 0) - exact).mean() < TEXELS * exact.mean()
    turned = cube.Cube(tuple(level[[1, 0, 2, 3, 4, 5]] for level in baked().levels))
    assert cube.error(turned, sky(), 0.04) > 5 * TEXELS


@pytest.mark.parametrize("row", [5, 75, 128])
def test_a_lamp_of_one_pixel_is_neither_missed_nor_doubled(row: int) -> None:
    """Whether its picture is much finer than the cube or not, near the pole and far from it."""
    pixels = np.zeros((257, 512, 3))
    pixels[row, 333] = 1000
    lamp = Environment(pixels)
    received = lamp.harmonics()[0] * np.sqrt(4 * np.pi)
    for size in (32, 64):  # 5 and 2.5 pixels in a texel
        level = cube.faces(lamp, size)
        s = (np.arange(size) + 0.5) * 2 / size - 1
        solid_angle = (2 / size) ** 2 / (1 + s**2 + s[:, None] ** 2) ** 1.5
        # The places in a texel and its neighbour's are not equally many: some percent.
        np.testing.assert_allclose(np.einsum("fijc,ij->c", level, solid_angle), received, rtol=0.1)


@pytest.mark.parametrize("shape", [(3, 600), (400, 4)])
def test_pictures_of_any_shape_become_cubes(shape: tuple[int, int]) -> None:
    np.testing.assert_allclose(cube.faces(Environment(np.ones((*shape, 3))), 32), 1)


def test_faces_are_those_of_graphics_interfaces() -> None:
    """The table of the Vulkan specification, section "Cube Map Face Selection": sc and tc of each face."""
    table = {
        "+x": "-z -y",
        "-x": "+z -y",
        "+y": "+x +z",
        "-y": "+x -z",
        "+z": "+x -y",
        "-z": "-x -y",
    }
    axes = {"x": 0, "y": 1, "z": 2}
    for face, w in zip(cube.FACES, cube.directions(2), strict=True):
        sc, tc = table[face].split()
        # The last texel of the last row has the largest sc and tc
        corner = w[1, 1]
        assert np.sign(corner[axes[sc[1]]]) == (1 if sc[0] == "+" else -1)
        assert np.sign(corner[axes[tc[1]]]) == (1 if tc[0] == "+" else -1)
        assert np.argmax(np.abs(w.sum((0, 1)))) == axes[face[1]]


READ = """
import { readFileSync } from "fs";
const { read } = await import(process.argv[1]);
const k = read(new Uint8Array(readFileSync(process.argv[2])));
const texels = k.levels.map((l) => [...new Uint16Array(l.levelData.slice().buffer)]);
const { vkFormat, pixelWidth, pixelHeight, faceCount } = k;
console.log(JSON.stringify({ vkFormat, pixelWidth, pixelHeight, faceCount, texels }));
"""


def test_another_program_reads_the_ktx2_file(tmp_path: Path) -> None:
    """The reader of three.js, ktx-parse."""
    baked().write(tmp_path / "sky.ktx2")
    reader = HOSTS / "node_modules/three/examples/jsm/libs/ktx-parse.module.js"
    node = shutil.which("node")
    if node is None or not reader.is_file():
        pytest.skip("node or three.js is not installed: npm install in examples/hosts")
    command = [node, "--input-type=module", "-e", READ, str(reader), str(tmp_path / "sky.ktx2")]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    found = json.loads(done.stdout)
    assert (found["vkFormat"], found["pixelWidth"], found["pixelHeight"]) == (97, 64, 64)
    assert found["faceCount"] == 6
    for level, texels in zip(baked().levels, found["texels"], strict=True):
        halves = np.array(texels, np.uint16).view(np.float16).reshape(6, *level.shape[1:3], 4)
        np.testing.assert_allclose(halves[..., :3], level, rtol=HALF)
        assert (halves[..., 3] == 1).all()


def test_a_cube_becomes_a_folder_of_pictures_or_says_why_not(tmp_path: Path) -> None:
    paths = baked().write(tmp_path / "sky")
    assert len(paths) == 36
    assert (tmp_path / "sky/nz_5.exr") in paths
    with pytest.raises(ValueError, match=r"\.ktx2 file, or a folder"):
        baked().write(tmp_path / "sky.png")
    with pytest.raises(ValueError, match="64, 128"):
        cube.prefiltered(sky(), 100)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What the host needs, made by the commands of the README."""
    made = tmp_path_factory.mktemp("lit")
    sky().write(made / "sky.exr")
    readme = (HOSTS / "README.md").read_text("utf-8")
    commands = re.findall(r"^gonio (.*(?:paint|sky).*)$", readme, re.M)
    assert len(commands) == 4
    for line in commands:
        text, _, target = line.partition(" > ")
        text = re.sub(r"\b(sky\.exr|sky\.ktx2|paint\.npy)", rf"{made}/\1", text)
        done = CliRunner().invoke(main, text.replace(" -o .", f" -o {made}/").split())
        assert done.exit_code == 0, done.output
        if target:
            (made / target).write_text(done.output, encoding="utf-8")
    return made


def test_the_lit_host_draws_what_mitsuba_renders_under_the_same_sky(folder: Path) -> None:
    import mitsuba as mi

    mi.set_variant("llvm_ad_rgb")
    about = json.loads((folder / "paint.json").read_text("utf-8"))
    values = {p["path"]: tuple(p["value"]) for p in about["parameters"]}
    model = gonio.model(
        "ue4", light="image", **{k: v if len(v) == 3 else v[0] for k, v in values.items()}
    )
    command = [sys.executable, "-P", HOSTS / "lit_wgpu.py", ".", str(SIZE), "sphere.npy"]
    subprocess.run(command, cwd=folder, check=True)
    picture = np.load(folder / "sphere.npy")

    look = mi.ScalarTransform4f().look_at([0, 0, 5], [0, 0, 0], [0, 1, 0])
    film = {"type": "hdrfilm", "width": SIZE, "height": SIZE, "pixel_format": "rgb"}
    scene = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 2},
        "sensor": {
            "type": "orthographic",
            "to_world": look @ mi.ScalarTransform4f().scale([1.1, 1.1, 1]),
            "film": film | {"component_format": "float32", "rfilter": {"type": "box"}},
        },
        "sky": {"type": "envmap", "filename": str(folder / "sky.exr")},
        "sphere": {"type": "sphere", "bsdf": gonio.mitsuba.node(model)},
    }
    rendered = np.array(mi.render(mi.load_dict(scene), spp=256))
    y, x = np.mgrid[1.1 : -1.1 : SIZE * 1j, -1.1 : 1.1 : SIZE * 1j]
    inside = x * x + y * y < 0.9
    seen, wanted = picture[inside], rendered[inside]
    # The two sums are no integral of the product, and 256 samples are noisy: 3 % on the mean.
    np.testing.assert_allclose(seen.mean(0), wanted.mean(0), rtol=0.01)
    assert np.abs(seen - wanted).mean() < 0.05 * wanted.mean()
    assert np.abs(picture[:, ::-1][inside] - wanted).mean() > 0.08 * wanted.mean()

    # And what Python looks up in the same maps
    points = np.stack([x, y, np.sqrt(np.maximum(1 - x * x - y * y, 0))], -1)[inside]
    host = Prefiltered(cube.prefiltered(sky(), 64), split_sum_table(model))
    python = shade(model, ["image"], points, (0, 0, 0), (0, 0, 1), sky=sky().harmonics(), host=host)
    assert np.abs(python - wanted).mean() < 0.06 * wanted.mean()
