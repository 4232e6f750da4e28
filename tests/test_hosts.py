"""The hosts in examples/hosts: each runs as its head says, and its picture is Mitsuba's."""

from __future__ import annotations

import functools
import http.server
import re
import shutil
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from playwright.sync_api import sync_playwright
from test_view_browser import FLAGS

import gonio
import gonio.mitsuba
from gonio.cli import main
from gonio.export.prove import tools

HOSTS = Path(__file__).parent.parent / "examples/hosts"
SIZE = 256
MATERIAL = "orange_lacquer"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The hosts beside the export that their README asks for."""
    made = tmp_path_factory.mktemp("hosts")
    command = re.search(r"^gonio (export .*)$", (HOSTS / "README.md").read_text("utf-8"), re.M)
    assert command
    arguments = command[1].replace(" -o .", f" -o {made}/").split()
    done = CliRunner().invoke(main, arguments)
    assert done.exit_code == 0, done.output
    for path in HOSTS.iterdir():
        if path.is_file():
            shutil.copy(path, made)
    (made / "node_modules").symlink_to(HOSTS / "node_modules")
    return made


@functools.cache
def sphere() -> Any:
    """The sphere under one directional light, by Mitsuba and gonio's own plug-in."""
    import mitsuba as mi

    mi.set_variant("llvm_ad_rgb")
    look = mi.ScalarTransform4f().look_at([0, 0, 5], [0, 0, 0], [0, 1, 0])
    light = np.array([0.5, 0.6, 0.62])
    scene = {
        "type": "scene",
        "integrator": {"type": "direct"},
        "sensor": {
            "type": "orthographic",
            "to_world": look @ mi.ScalarTransform4f().scale([1.1, 1.1, 1]),
            "film": film(SIZE),
            "sampler": {"type": "multijitter", "sample_count": 16},
        },
        "sun": {
            "type": "directional",
            "direction": (-light).tolist(),
            "irradiance": {"type": "rgb", "value": [np.pi] * 3},
        },
        "sphere": {"type": "sphere", "bsdf": gonio.mitsuba.node(gonio.load(MATERIAL))},
    }
    return np.array(mi.render(mi.load_dict(scene), spp=16))


def film(size: int) -> dict[str, Any]:
    return {
        "type": "hdrfilm",
        "width": size,
        "height": size,
        "pixel_format": "rgb",
        "component_format": "float32",
        "rfilter": {"type": "box"},
    }


def assert_is_the_sphere(picture: Any) -> None:
    wanted = sphere()
    assert wanted.mean() > 0.05
    assert picture.shape == wanted.shape
    # Means over pixels against their middles: they differ along the sphere's edge and in the highlight
    assert np.abs(picture - wanted).mean() < 0.01 * wanted.mean()
    inside = np.zeros((SIZE, SIZE), bool)
    inside[100:156, 100:156] = True
    # Means over pixels: how much the curve of the highlight bends inside one; and half floats
    np.testing.assert_allclose(picture[inside], wanted[inside], rtol=0.02, atol=1e-3)


def test_the_comparison_sees_a_mirrored_picture_and_a_wrong_parameter() -> None:
    with pytest.raises(AssertionError):
        assert_is_the_sphere(sphere()[:, ::-1])
    with pytest.raises(AssertionError):
        assert_is_the_sphere(sphere() * 1.03)


def test_a_path_tracer_in_cpp_converges_to_mitsubas_picture(folder: Path) -> None:
    text = (folder / "path_tracer.cpp").read_text("utf-8")
    assert text.count("\n") <= 150
    values = subprocess.run(
        [sys.executable, "values.py"], cwd=folder, check=True, capture_output=True
    )
    (folder / "material.values").write_bytes(values.stdout)
    flags = ["-O2", "-Wall", "-Wextra", "-Werror"]
    command = ["g++", *flags, "path_tracer.cpp", "-o", "path_tracer"]
    subprocess.run(command, cwd=folder, check=True)
    subprocess.run([folder / "path_tracer", "64", "400", "sphere.pfm"], cwd=folder, check=True)
    data = (folder / "sphere.pfm").read_bytes().split(b"-1.0\n", 1)[1]
    picture = np.frombuffer(data, "<f4").reshape(64, 64, 3)[::-1]

    import mitsuba as mi

    mi.set_variant("llvm_ad_rgb")
    sun = np.array([0.5, 0.8, 0.6]) / np.linalg.norm([0.5, 0.8, 0.6])
    cosine, far = 0.995, 1e4
    radiance = 2 / (2 * np.pi * (1 - cosine))
    radius = far * np.sqrt(1 - cosine**2) / cosine
    look = mi.ScalarTransform4f().look_at
    grey = {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.3] * 3}}
    scene = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 12},
        "sensor": {
            "type": "perspective",
            "fov": float(np.degrees(2 * np.arctan(0.25))),
            "to_world": look([0, 1.6, 7], [0, 1, 0], [0, 1, 0]),
            "film": film(64),
        },
        "sky": {"type": "constant", "radiance": {"type": "rgb", "value": [1.0] * 3}},
        "sun": {
            "type": "disk",
            "to_world": look((far * sun).tolist(), [0, 0, 0], [0, 1, 0])
            @ mi.ScalarTransform4f().scale([radius, radius, 1]),
            "emitter": {
                "type": "area",
                "radiance": {"type": "rgb", "value": [radiance] * 3},
            },
        },
        "ground": {
            "type": "rectangle",
            "to_world": mi.ScalarTransform4f().rotate([1, 0, 0], -90)
            @ mi.ScalarTransform4f().scale([1e4, 1e4, 1]),
            "bsdf": grey,
        },
        "ball": {
            "type": "sphere",
            "center": [0, 1, 0],
            "bsdf": gonio.mitsuba.node(gonio.load(MATERIAL)),
        },
    }
    wanted = np.array(mi.render(mi.load_dict(scene), spp=512))
    # The noise of both pictures
    np.testing.assert_allclose(picture.mean((0, 1)), wanted.mean((0, 1)), rtol=0.01)
    ball = (slice(20, 44), slice(20, 44))
    # The noise of both, in a part of the picture
    np.testing.assert_allclose(picture[ball].mean((0, 1)), wanted[ball].mean((0, 1)), rtol=0.02)


def run(folder: Path, script: str, **environment: str) -> Any:
    import os

    command = [sys.executable, "-P", script, ".", str(SIZE), "sphere.npy"]
    subprocess.run(command, cwd=folder, check=True, env={**os.environ, **environment})
    return np.load(folder / "sphere.npy")


def test_moderngl_draws_mitsubas_sphere(folder: Path) -> None:
    assert_is_the_sphere(run(folder, "sphere_moderngl.py"))


def test_hlsl_through_slang_draws_mitsubas_sphere(folder: Path) -> None:
    slangc = tools.program("slangc", "compiles HLSL")
    assert_is_the_sphere(run(folder, "sphere_slang.py", SLANGC=slangc))


@pytest.fixture(scope="module")
def site(folder: Path) -> Iterator[str]:
    class Quiet(http.server.SimpleHTTPRequestHandler):
        def log_message(self, format: str, *arguments: Any) -> None:
            """Nothing."""

    handler = functools.partial(Quiet, directory=str(folder))
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
    thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.05})
    thread.start()
    yield f"http://127.0.0.1:{server.server_port}"
    server.shutdown()
    server.server_close()
    thread.join()


def test_pages_draw_mitsubas_sphere(site: str) -> None:
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path="/usr/bin/chromium", args=FLAGS)
        for name in ("webgpu", "webgl2", "three"):
            page = browser.new_page()
            page.goto(f"{site}/sphere_{name}.html")
            page.wait_for_function("globalThis.ready", timeout=60_000)
            assert page.inner_text("#message") == "", name
            pixels = page.evaluate("pixels()")
            assert_is_the_sphere(np.array(pixels).reshape(SIZE, SIZE, 4)[..., :3])
            page.close()
        browser.close()
