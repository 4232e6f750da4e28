"""The page that a shader programmer starts from: what it prints, copied, draws the right thing."""

from __future__ import annotations

import functools
import http.server
import io
import re
import shlex
import shutil
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from PIL import Image
from playwright.sync_api import sync_playwright
from test_view_browser import FLAGS

import gonio
from gonio.cli import main

ROOT = Path(__file__).parent.parent
GUIDE = (ROOT / "docs/guides/shader.md").read_text(encoding="utf-8")
MATERIAL = "orange_lacquer"


def block(language: str) -> str:
    """The page's first block of a language."""
    found = re.search(rf"^```{language}\n(.*?)^```", GUIDE, re.M | re.S)
    assert found
    return found[1]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What the page's command writes."""
    made = tmp_path_factory.mktemp("host")
    words = shlex.split(block("sh"))
    assert f"paint={MATERIAL}" in words
    words[words.index("-o") + 1] = f"{made}/"
    done = CliRunner().invoke(main, words[1:])
    assert done.exit_code == 0, done.output
    return made


def radiance(place: Any, normal: Any, eye: Any, light: Any, irradiance: Any) -> Any:
    """The same in double precision, in a frame of this test's own."""
    n = normal / np.linalg.norm(normal, axis=-1, keepdims=True)
    s = np.cross([0.0, 1.0, 0.0], n)
    s /= np.linalg.norm(s, axis=-1, keepdims=True)
    frame = np.stack([s, np.cross(n, s), n], -2)
    view = eye - place
    view /= np.linalg.norm(view, axis=-1, keepdims=True)
    wi, wo = frame @ np.asarray(light), np.einsum("...ij,...j", frame, view)
    return gonio.load(MATERIAL).model.eval(wi, wo) * wi[..., 2:] * irradiance


def test_the_webgpu_stages_give_the_radiance_of_the_arrays(folder: Path) -> None:
    import wgpu

    eye, light = np.array([0.5, -0.3, 2.0]), np.array([1, 2, 2]) / 3
    irradiance, normal = np.array([3.0, 2.0, 1.0]), np.array([0.2, -0.1, 1.0])
    frame = np.concatenate([np.eye(4).ravel(), eye, [1], light, [0], irradiance, [0]])
    corners = np.array([[x, y, 0.25, *normal] for x, y in ((-1, -1), (3, -1), (-1, 3))])

    device = wgpu.gpu.request_adapter_sync().request_device_sync()
    text = (folder / "paint.wgsl").read_text(encoding="utf-8") + block("wgsl")
    module = device.create_shader_module(code=text)
    uniform = device.create_buffer_with_data(
        data=frame.astype("f4"), usage=wgpu.BufferUsage.UNIFORM
    )
    vertices = device.create_buffer_with_data(
        data=corners.astype("f4"), usage=wgpu.BufferUsage.VERTEX
    )
    film = device.create_texture(
        size=(8, 8, 1),
        format="rgba32float",
        usage=wgpu.TextureUsage.RENDER_ATTACHMENT | wgpu.TextureUsage.COPY_SRC,
    )
    attributes = [{"format": "float32x3", "offset": 12 * i, "shader_location": i} for i in (0, 1)]
    layout = {"array_stride": 24, "step_mode": "vertex", "attributes": attributes}
    pipeline = device.create_render_pipeline(
        layout="auto",
        vertex={"module": module, "entry_point": "vertex", "buffers": [layout]},
        fragment={
            "module": module,
            "entry_point": "fragment",
            "targets": [{"format": "rgba32float"}],
        },
        primitive={"topology": "triangle-list"},
    )
    bound = device.create_bind_group(
        layout=pipeline.get_bind_group_layout(0),
        entries=[{"binding": 0, "resource": {"buffer": uniform}}],
    )
    encoder = device.create_command_encoder()
    drawing = encoder.begin_render_pass(
        color_attachments=[{"view": film.create_view(), "load_op": "clear", "store_op": "store"}]
    )
    drawing.set_pipeline(pipeline)
    drawing.set_bind_group(0, bound)
    drawing.set_vertex_buffer(0, vertices)
    drawing.draw(3)
    drawing.end()
    device.queue.submit([encoder.finish()])
    read = device.queue.read_texture({"texture": film}, {"bytes_per_row": 128}, (8, 8, 1))
    made = np.frombuffer(read, np.float32).reshape(8, 8, 4)[..., :3]

    x, y = np.meshgrid((np.arange(8) + 0.5) / 4 - 1, 1 - (np.arange(8) + 0.5) / 4)
    place = np.stack([x, y, np.full_like(x, 0.25)], -1)
    wanted = radiance(place, normal, eye, light, irradiance)
    assert wanted.max() > 0.3
    # Single precision
    np.testing.assert_allclose(made, wanted, rtol=1e-4, atol=1e-6)
    for wrong in (
        radiance(place, normal, -eye, light, irradiance),
        radiance(place, normal, eye, light * [1, -1, 1], irradiance),
        radiance(place, normal, eye, light, irradiance[::-1]),
    ):
        assert np.abs(made - wrong).max() > 0.05


def test_the_moderngl_script_draws_the_picture_of_the_arrays(folder: Path) -> None:
    (folder / "lit.py").write_text(block("python"), encoding="utf-8")
    subprocess.run([sys.executable, "-P", "lit.py"], cwd=folder, check=True)
    made = np.array(Image.open(folder / "paint.png").convert("RGB")).astype(float)
    x, y = np.meshgrid((np.arange(256) + 0.5) / 128 - 1, 1 - (np.arange(256) + 0.5) / 128)
    place = np.stack([x, y, 0.5 - 0.25 * (x * x + y * y)], -1)
    normal = np.stack([x / 2, y / 2, np.ones_like(x)], -1)
    linear = radiance(place, normal, np.array([0, 0, 4]), np.array([1, 2, 2]) / 3, np.pi)
    srgb = np.where(linear < 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    wanted = 255 * np.clip(srgb, 0, 1)
    # Eight bits, and between the mesh's corners a highlight's edge
    assert np.percentile(np.abs(made - wanted), 99) < 1.5
    assert np.percentile(np.abs(made[::-1] - wanted), 99) > 20


def test_three_js_lights_a_matte_surface_as_its_own_material_does(folder: Path) -> None:
    """Signs, spaces, the light's unit and the screen's encoding are those of MeshLambertMaterial."""
    shutil.copytree(
        ROOT / "examples/hosts/node_modules/three/build", folder / "node_modules/three/build"
    )
    words = "export paint=lambert:rho=0.5/0.3/0.8 --lit directional --embed --to essl -o"
    done = CliRunner().invoke(main, [*words.split(), f"{folder}/lambert/"])
    assert done.exit_code == 0, done.output
    shown = block("html").removesuffix("</script>\n") + "globalThis.done = true;\n</script>\n"
    matte = shown.replace('"paint.essl"', '"lambert/paint.essl"')
    assert matte != shown
    theirs = "new THREE.MeshLambertMaterial({ color: new THREE.Color().setRGB(0.5, 0.3, 0.8) })"
    pages = {
        "page": shown,
        "matte": matte,
        "theirs": matte.replace("256, 64), material)", f"256, 64), {theirs})"),
        "wrong": matte.replace("multiplyScalar(sun", "multiplyScalar(1.03 * sun"),
    }
    assert len(set(pages.values())) == len(pages)
    for name, text in pages.items():
        (folder / f"{name}.html").write_text(text, encoding="utf-8")

    class Quiet(http.server.SimpleHTTPRequestHandler):
        def log_message(self, format: str, *arguments: Any) -> None:
            """Nothing."""

    handler = functools.partial(Quiet, directory=str(folder))
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
    thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.05})
    thread.start()
    pictures = {}
    complaints: list[str] = []
    try:
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(executable_path="/usr/bin/chromium", args=FLAGS)
            page = browser.new_page()
            page.on("pageerror", lambda error: complaints.append(str(error)))
            page.on(
                "console",
                lambda m: complaints.append(m.text) if "THREE" in m.text else None,
            )
            for name in pages:
                page.goto(f"http://127.0.0.1:{server.server_port}/{name}.html")
                page.wait_for_function("globalThis.done", timeout=60_000)
                picture = page.locator("canvas").screenshot()
                pictures[name] = np.array(Image.open(io.BytesIO(picture)).convert("RGB"), float)
            browser.close()
    finally:
        server.shutdown()
        server.server_close()
        thread.join()
    assert complaints == []
    assert pictures["page"].max() == 255  # a highlight
    # A rounding of eight bits; along the edges the two compute with other digits
    off = np.abs(pictures["matte"] - pictures["theirs"])
    assert pictures["theirs"].mean() > 50
    assert np.percentile(off, 99) <= 1
    assert np.percentile(np.abs(pictures["wrong"] - pictures["theirs"]), 99) > 1
