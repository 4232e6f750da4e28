"""`gonio view` in a real browser: numbers against arrays, pictures against Mitsuba, the page in use.

Chromium draws with SwiftShader here, by WebGPU and by WebGL2. Canvases are small and paths few: what is
tested is that the numbers are right, not that they are smooth.
"""

from __future__ import annotations

import base64
import json
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from playwright.sync_api import Browser, BrowserContext, ConsoleMessage, Page, sync_playwright
from support.tolerances import SINGLE_LONG

import gonio
from gonio.claims import as_tuple
from gonio.materials import Material, library, load
from gonio.model import models
from gonio.view import page as pages
from gonio.view.server import Viewer
from gonio.view.variants import pool

# What shows WebGPU and WebGL2 without a GPU.
FLAGS = [
    "--no-sandbox",
    "--enable-unsafe-webgpu",
    "--use-webgpu-adapter=swiftshader",
    "--enable-features=Vulkan",
    "--use-vulkan=swiftshader",
    "--use-angle=swiftshader",
]
INTERFACES = ("webgpu", "webgl2")
PATIENCE = 120.0  # seconds, on a machine that does much else


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with sync_playwright() as playwright:
        found = playwright.chromium.launch(executable_path="/usr/bin/chromium", args=FLAGS)
        yield found
        found.close()


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Viewer]:
    mine = tmp_path_factory.mktemp("mine") / "too_bright.py"
    mine.write_text(BROKEN, encoding="utf-8")
    looked = mine.with_name("looked.py")
    looked.write_text(LOOKED, encoding="utf-8")
    viewer = Viewer(["eon"], [str(mine), str(looked)])
    thread = threading.Thread(target=viewer.serve_forever, kwargs={"poll_interval": 0.05})
    thread.start()
    yield viewer
    viewer.shutdown()
    viewer.server_close()
    thread.join()


# A white diffuse surface that reflects a quarter more than it receives.
BROKEN = '''"""Too bright."""
from gonio.lang import INV_PI, Color, Float, Sample, Vec2, Vec3
from gonio.model import Model, param
from gonio.parts.hemisphere import pdf_cosine, sample_cosine


class TooBright(Model):
    """White, and a quarter more."""

    rho: Color = param((1.0, 1.0, 1.0), 0, 1, "albedo")

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        return self.rho * (1.25 * INV_PI)

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        wi = sample_cosine(u)
        return Sample(wi, pdf_cosine(wi))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        return pdf_cosine(wi)
'''


# Every direction has numbers of its own, from more entries than a line of the buffer has.
LOOKED = '''"""Greys and tints from tables."""
import numpy as np
from gonio.lang import Color, Float, Sample, Vec2, Vec3, fract
from gonio.model import Model, param
from gonio.parts.hemisphere import pdf_cosine, sample_cosine
from gonio.table import Table, fetch


class Looked(Model):
    """A grey for wi, a tint for wo."""

    scale: Float = param(1.0, 0, 1, "of all")
    grey = Table("grey", np.random.default_rng(3).random(5000))
    tint = Table("tint", np.random.default_rng(4).random((7, 3)), colours=True)

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        i = 5000 * wi.z
        k = 7 * wo.z
        return self.scale * fetch(self.grey, i - fract(i)) * fetch(self.tint, k - fract(k))

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        wi = sample_cosine(u)
        return Sample(wi, pdf_cosine(wi))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        return pdf_cosine(wi)
'''


class Shown:
    """A page, and what a test asks of it."""

    def __init__(
        self, browser: Browser | BrowserContext, url: str, size: tuple[int, int] = (900, 700)
    ) -> None:
        self.page: Page = browser.new_page()
        self.page.set_viewport_size({"width": size[0], "height": size[1]})
        self.complaints: list[str] = []
        self.requests: list[str] = []
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.on("console", self.hear)
        self.page.on("request", lambda request: self.requests.append(request.url))
        self.page.goto(url)
        self.until("globalThis.gonio?.sides[0].program != null")
        # The picture rests until a test wants it: two cores have enough to do
        self.run("gonio.renderer.paused = true; gonio.renderer.limit = 2")

    def hear(self, message: ConsoleMessage) -> None:
        # That reading pixels waits for the GPU is no complaint, nor is a choice that the server refuses
        expected = ("GL Driver Message (OpenGL, Performance", "status of 422")
        if message.type in ("error", "warning") and not any(e in message.text for e in expected):
            self.complaints.append(message.text)

    def run(self, script: str, argument: Any = None) -> Any:
        return self.page.evaluate(f"async (given) => {{ {script} }}", argument)

    def value(self, expression: str) -> Any:
        return self.page.evaluate(f"() => ({expression})")

    def until(self, condition: str) -> None:
        end = time.monotonic() + PATIENCE
        while not self.value(f"Boolean({condition})"):
            assert time.monotonic() < end, f"{condition} did not come; {self.complaints}"
            self.page.wait_for_timeout(30)

    def film(self, samples: int, size: int, estimator: str = "both", **state: Any) -> Any:
        """The mean of a square picture's samples, shape (size, size, 3)."""
        packed = self.run(FILM, [samples, size, estimator, state])
        values = np.frombuffer(base64.b64decode(packed), np.float32).reshape(size, size, 4)
        return values[..., :3].astype(np.float64) / samples

    def rows(self, text: str, rows: Any, values: Any = None) -> Any:
        """f, pdf, sampled wi and its pdf of a model at rows of wi, wo and u."""
        given = np.zeros((len(rows), 12), np.float32)
        given[:, 0:3], given[:, 4:7], given[:, 8:10] = rows[:, :3], rows[:, 3:6], rows[:, 6:]
        numbers = base64.b64encode(given.tobytes()).decode()
        packed = self.run(ROWS, [text, numbers, values or {}])
        return np.frombuffer(base64.b64decode(packed), np.float32).reshape(-1, 8).astype(float)


PACK = """
const pack = (f) => {
  const u = new Uint8Array(f.buffer, f.byteOffset, f.byteLength);
  let s = "";
  for (let i = 0; i < u.length; i += 32768) s += String.fromCharCode(...u.subarray(i, i + 32768));
  return btoa(s);
};
"""
FILM = (
    PACK
    + """
const [samples, size, estimator, state] = given, r = gonio.renderer, side = gonio.sides[0];
gonio.observer.disconnect();
gonio.gpu.canvas.width = gonio.gpu.canvas.height = size;
Object.assign(r, { size: [size, size], limit: samples, estimator, paused: false });
Object.assign(gonio.state, state); gonio.moved(false);
const done = () => side.epoch === r.epoch && side.scale === 1 && side.samples >= samples;
while (!done()) await new Promise((q) => setTimeout(q, 10));
r.paused = true;
return pack(await gonio.gpu.readFilm(side.film));
"""
)
ROWS = (
    PACK
    + """
const [text, numbers, values] = given, payload = await gonio.source.model(text);
const data = new Float32Array(Uint8Array.from(atob(numbers), (c) => c.charCodeAt(0)).buffer);
const program = await gonio.gpu.compile(payload, { trace: false });
const params = new Float32Array(4 * Math.max(1, payload.members.length));
const value = (path) => values[path] ?? payload.parameters.find((p) => p.path === path).value;
payload.members.forEach((path, i) => params.set(value(path), 4 * i));
const made = await gonio.gpu.rows(program, params, data);
gonio.gpu.forget(program);
return pack(made);
"""
)


ALBEDO = """
const [text, wo] = given, payload = await gonio.source.model(text);
const program = await gonio.gpu.compile(payload, { trace: false });
const params = new Float32Array(4 * Math.max(1, payload.members.length));
const value = (path) => payload.parameters.find((p) => p.path === path).value;
payload.members.forEach((path, i) => params.set(value(path), 4 * i));
const made = await gonio.gpu.albedo(program, params, new Float32Array([...wo, 0]));
gonio.gpu.forget(program);
return [...made.subarray(0, 3)];
"""


@pytest.fixture(scope="module", params=INTERFACES)
def shown(request: pytest.FixtureRequest, browser: Browser, server: Viewer) -> Iterator[Shown]:
    found = Shown(browser, server.url.replace("/#", f"/?graphics={request.param}#"))
    assert found.value("gonio.gpu.name").lower() == request.param
    yield found
    # Nothing that a test did made the graphics or the page complain
    assert found.complaints == []
    assert found.value("gonio.gpu.errors") == []
    assert all(url.startswith((server.origin, "data:", "blob:")) for url in found.requests)
    found.page.close()


def directions(count: int) -> Any:
    """Rows of wi, wo, u: anywhere, a quarter grazing, a quarter near the mirror direction."""
    rng = np.random.default_rng(1)
    w = rng.normal(size=(2, count, 3))
    w[..., 2] = abs(w[..., 2])
    quarter = count // 4
    w[0, :quarter, 2] *= 1e-3
    w[1] /= np.linalg.norm(w[1], axis=-1, keepdims=True)
    mirror = w[1, quarter : 2 * quarter] * [-1, -1, 1]
    w[0, quarter : 2 * quarter] = mirror + rng.normal(size=(quarter, 3)) * 0.05
    w[0, :, 2] = np.maximum(abs(w[0, :, 2]), 1e-4)
    w[0] /= np.linalg.norm(w[0], axis=-1, keepdims=True)
    u = np.minimum(rng.random((count, 2)), 1 - 2**-24)
    return np.concatenate([w[0], w[1], u], axis=1).astype(np.float32)


# SwiftShader's exp, pow and sin are off by up to 2e-4 of their value; densities add a few of them.
F_ERROR, PDF_ERROR = 3e-4, 1e-3
SMALL = 1e-3  # below it errors are absolute
DIRECTIONS = 1024
# The light of a furnace is 1, and is seen beside the sphere without another operation than the mean.
BACKGROUND = 1e-4


def far_off(made: Any, wanted: Any, error: float) -> Any:
    return np.abs(made - wanted) / np.maximum(np.abs(wanted), SMALL) > error


def single_error(model: gonio.Model) -> float:
    """What a model documents of its values in single precision, or what drivers do to any.

    Values that are further off than usual are products of many exponentials and powers, as densities are.
    """
    sizes = [k.size for k in as_tuple(model.written.claims.float32) if not k.options]
    return max([PDF_ERROR if sizes else F_ERROR, *sizes])


def random_values(model: gonio.Model, rng: np.random.Generator) -> dict[str, list[float]]:
    """A value for every parameter, anywhere where sliders go."""
    from gonio.export.manifest import soft_range

    found = {}
    for path, declared, _ in model.parameters():
        low, high = soft_range(declared)
        found[path] = [float(np.float32(v)) for v in rng.uniform(low, high, declared.width)]
    return found


class Known(NamedTuple):
    """What a model computes for the rows of `directions`."""

    name: str
    values: dict[str, list[float]]
    """Of its parameters, where they are not its own."""
    f: Any
    pdf: Any
    error: float


@pytest.fixture(scope="module")
def known() -> list[Known]:
    """Every material, every model, and every model with random values: once for both interfaces."""
    rows = directions(DIRECTIONS)
    wi, wo = rows[:, :3].astype(float), rows[:, 3:6].astype(float)
    rng = np.random.default_rng(2)
    found = []
    for name in [*models(), *library()]:
        what = load(name)
        model = what.model if isinstance(what, Material) else what
        chosen = [({}, model)]
        if name in models():
            values = random_values(model, rng)
            plain = {k: tuple(v) if len(v) > 1 else v[0] for k, v in values.items()}
            chosen.append((values, model.replace(**plain)))
        for values, one in chosen:
            f, pdf = np.asarray(one.eval(wi, wo)), np.asarray(one.pdf(wi, wo))
            found.append(Known(name, values, f, pdf, single_error(one)))
    return found


def test_every_model_and_material_has_its_numbers(shown: Shown, known: list[Known]) -> None:
    rows = directions(DIRECTIONS)
    wrong = []
    for name, values, f, pdf, error in known:
        made = shown.rows(name, rows, values)
        bad_f = far_off(made[:, :3], f, error).any(axis=1)
        bad_pdf = far_off(made[:, 3], pdf, PDF_ERROR)
        # Single precision: a few rows lie where a highlight is steepest
        if not np.isfinite(made).all() or bad_f.mean() > 2e-3 or bad_pdf.mean() > 2e-3:
            wrong.append((name, bool(values), bad_f.mean(), bad_pdf.mean()))
    assert wrong == []


def test_wrong_numbers_would_be_seen(shown: Shown) -> None:
    rows = directions(256)
    made = shown.rows("eon", rows)
    f = np.asarray(gonio.model("eon", roughness=0.501).eval(rows[:, :3], rows[:, 3:6]))
    assert far_off(made[:, :3], f, F_ERROR).mean() > 0.5


def test_tables_are_read_as_they_stand(shown: Shown, server: Viewer) -> None:
    path = server.names.files[1]
    rng = np.random.default_rng(5)
    places = rng.integers(1, (5000, 7), (300, 2))
    z = (places + 0.5) / (5000, 7)  # the middle of an entry: rounding does not matter
    rows = np.zeros((300, 8))
    rows[:, [2, 5]], rows[:, [0, 3]] = z, np.sqrt(1 - z * z)
    grey = np.random.default_rng(3).random(5000)
    tint = np.random.default_rng(4).random((7, 3))
    made = shown.rows(path, rows)[:, :3]
    wanted = grey[places[:, :1]] * tint[places[:, 1]]
    assert not far_off(made, wanted, 1e-6).any()
    # A buffer that begins one entry too late
    assert far_off(made, grey[places[:, :1] - 1] * tint[places[:, 1]], 1e-6).mean() > 0.9
    # And the picture has them
    shown.run("await gonio.show(given)", path)
    assert shown.film(1, 16, shape="sphere", furnace=True).max() > 0.1
    shown.run("await gonio.show('eon')")


# --- pictures ------------------------------------------------------------------------------------------


def test_a_white_eon_vanishes_in_the_furnace_and_a_bright_model_does_not(
    shown: Shown, server: Viewer
) -> None:
    state = {"furnace": True, "shape": "sphere"}
    shown.run("await gonio.show('lambert:rho=1')")  # every sample has the weight 1
    np.testing.assert_allclose(shown.film(2, 32, **state), 1, atol=1e-4)
    shown.run("await gonio.show('eon:rho=1,roughness=1')")
    # Its samples' weights deviate by a quarter: over 32 x 32 pixels by a hundredth of that
    assert shown.film(4, 32, **state).mean() == pytest.approx(1, abs=0.01)
    shown.run("await gonio.show('qon:rho=1,sigma=1.5')")
    assert shown.film(8, 32, **state)[12:20, 12:20].mean() < 0.95  # "loses energy at larger sigma"
    shown.run("await gonio.show(given)", server.names.files[0])
    # One reflection on a convex body: the albedo itself
    assert shown.film(2, 32, **state)[12:20, 12:20].mean() == pytest.approx(1.25, abs=1e-4)
    shown.run("await gonio.show('eon')")


def test_both_interfaces_draw_the_same_picture(browser: Browser, server: Viewer) -> None:
    films = []
    for interface in INTERFACES:
        found = Shown(browser, server.url.replace("/#", f"/?graphics={interface}#"))
        found.run("await gonio.show('car_paint_red_strong')")
        films.append(found.film(2, 48, env="studio", furnace=False, shape="ball"))
        found.page.close()
    # The same paths: they part where a sine's last digits choose another flake or lobe
    apart = np.abs(films[0] - films[1]).max(axis=-1) > 1e-3
    assert apart.mean() < 0.05
    # 5 % of the pixels may part, by their own size at most
    assert films[0].mean() == pytest.approx(films[1].mean(), rel=0.01)


def test_a_picture_of_another_shape_is_not_stretched_until_the_next(shown: Shown) -> None:
    shown.run("await gonio.show('lambert:rho=0')")
    assert shown.film(1, 48, furnace=True, shape="sphere").min() == 0
    # The stage is twice as wide now, or half, and nothing has been drawn since: a black disk on white
    for size in ([96, 48], [48, 96]):
        seen = shown.run(
            """
            const { canvas } = gonio.gpu, copy = document.createElement("canvas");
            [canvas.width, canvas.height] = given;
            gonio.renderer.show();
            const bitmap = await createImageBitmap(canvas);
            [copy.width, copy.height] = given;
            const g = copy.getContext("2d");
            g.drawImage(bitmap, 0, 0);
            return [...g.getImageData(0, 0, ...given).data].filter((_, i) => i % 4 === 0);
            """,
            size,
        )
        dark = np.array(seen).reshape(size[1], size[0]) < 128
        across, down = dark.any(axis=0).sum(), dark.any(axis=1).sum()
        assert across > 10
        assert abs(int(across) - int(down)) <= 2
    shown.run("await gonio.show('eon')")


def test_estimators_and_mitsuba_agree(shown: Shown) -> None:
    if shown.value("gonio.gpu.name") != "WebGPU":
        return  # WebGL2 draws the same, by the test above
    import mitsuba as mi

    mi.set_variant("llvm_ad_rgb")
    from gonio.mitsuba import node
    from gonio.render.stage import shader_ball

    size, state = 40, {"env": "sun", "furnace": False, "shape": "ball"}
    text = "torrance_sparrow:alpha=0.5"
    shown.run("await gonio.show(given)", text)
    both = shown.film(32, size, **state)
    scene = shader_ball(node(load(text)), environment="sun", size=(size, size), spp=128)
    wanted = np.array(mi.render(mi.load_dict(scene), spp=128, seed=1))
    # 1600 pixels of 32 samples, of a few tenths each
    assert both.mean() == pytest.approx(wanted.mean(), rel=5e-3)
    # Each kind of sample alone finds the same light: the lamps' by their own, the lamps' by the model's
    light = shown.film(32, size, "light", **state)
    # Samples of one kind have several times the noise
    assert light.mean() == pytest.approx(both.mean(), rel=0.02)
    state["env"] = "studio"
    both, model = (shown.film(32, size, kind, **state).mean() for kind in ("both", "model"))
    # A path finds the large lamp one time in thirty: 50,000 paths know its light to about 3 %
    assert model == pytest.approx(both, rel=0.1)
    shown.run("await gonio.show('eon')")


@pytest.mark.parametrize(
    "text",
    [
        "torrance_sparrow:alpha=0.0001",
        "torrance_sparrow:alpha=1,anisotropy=1",
        "weidlich_wilkie:alpha=0.0001,eta=3,base=torrance_sparrow,base.alpha=0.0001",
        "phong:shininess=100000",
        "eon:roughness=0,rho=0",
    ],
)
def test_extremes_draw_no_pixel_that_is_no_number(shown: Shown, text: str) -> None:
    shown.run("await gonio.show(given)", text)
    picture = shown.film(1, 24, env="sun", furnace=False, shape="ball", el=4)
    assert np.isfinite(picture).all()
    assert (picture >= 0).all()
    shown.run("await gonio.show('eon'); gonio.set({ el: 13 })")


# --- the page as people use it -------------------------------------------------------------------------


def test_a_dragged_slider_compiles_nothing_and_shows_in_the_link(shown: Shown) -> None:
    shown.run("await gonio.show('eon'); gonio.kept = gonio.sides[0].program;")
    slider = shown.page.get_by_label("roughness", exact=True)
    slider.focus()
    for _ in range(3):
        slider.press("ArrowRight")
    assert shown.value("gonio.sides[0].text()") == "eon:roughness=0.53"
    assert shown.value("gonio.sides[0].program === gonio.kept")
    assert "a=eon:roughness=0.53" in shown.value("location.hash")
    shown.page.keyboard.press("Control+z")
    shown.until("gonio.sides[0].text() === 'eon'")


def test_a_reset_is_undone_by_itself_and_a_drag_as_a_whole(shown: Shown) -> None:
    value = "gonio.sides[0].values.get('roughness')[0]"
    shown.run("await gonio.show('eon:roughness=0.5')")
    shown.run("for (const v of [0.1, 0.2, 0.3]) gonio.setParameter('roughness', [v])")
    shown.run("gonio.resetParameter('roughness')")
    start = shown.value(value)
    assert start != 0.3
    found = [shown.run(f"await gonio.step({by}); return {value}") for by in (-1, -1, 1, 1)]
    assert found == [0.3, 0.5, 0.3, start]


def test_plots_keep_their_letters_where_sides_are_swapped_meanwhile(shown: Shown) -> None:
    shown.run("await gonio.show('eon:roughness=0.5'); await gonio.follow('eon:roughness=0.5')")
    settled = "!gonio.busyMeasuring && gonio.plots().length === 2"
    shown.until(settled)
    shown.run("""
      gonio.set({ theta: 31 });
      while (!gonio.busyMeasuring) await new Promise((q) => setTimeout(q, 0));
      gonio.swap();
    """)
    shown.until(f"{settled} && gonio.plots().every((p) => p.key.endsWith('|31'))")
    assert shown.value("gonio.plots().map((p) => p.letter)") == ["A", "B"]
    shown.run("gonio.set({ theta: 45 }); await gonio.follow('')")


# Another model comes between two requests for numbers, and its values before its shaders
MEANWHILE = """
const app = gonio, { gpu } = app, [side] = app.sides, seen = [];
let left = 0;
for (const name of ["rows", "albedo"]) {
    const compute = gpu[name].bind(gpu);
    gpu[name] = async (program, params, given) => {
        seen.push([name, params.length, 4 * Math.max(1, program.model.members.length)]);
        const found = await compute(program, params, given);
        if (left-- === 0) await app.show("lambert");
        return found;
    };
}
const until = async (done) => { while (!done()) await new Promise((q) => setTimeout(q, 20)); };
const settled = () => !app.busyMeasuring && app.lobes.A?.key.endsWith(`|${app.state.theta}`);
app.set({ view: "lobe", probe: "0.5,0.5" });
for (const request of [0, 2, 4]) {  // the first of the plots, the lobe and the probe
    left = Infinity;
    await app.show("eon"); // both have an albedo of their own, so that the probe asks for it
    app.set({ theta: 20 + request });
    await until(settled);
    left = request;
    app.set({ theta: 40 + request });
    await until(() => left < 0 && settled());
}
await until(() => !app.replaced.length);
const own = side.packed().length;
side.take(await app.source.model("eon"));
let early = 0;
try { early = side.packed().length; } catch {}
delete gpu.rows;
delete gpu.albedo;
app.set({ view: "picture", probe: "", theta: 45 });
await app.show("eon");
return { seen, own, early };
"""


def test_numbers_keep_their_model_where_another_one_comes_meanwhile(shown: Shown) -> None:
    found = shown.run(MEANWHILE)
    assert {name for name, *_ in found["seen"]} == {"rows", "albedo"}
    assert [row for row in found["seen"] if row[1] != row[2]] == []
    assert found["early"] == found["own"] == 4  # of lambert: one vector


def test_a_number_out_of_range_is_refused_and_the_picture_stays(shown: Shown) -> None:
    field = shown.page.get_by_label("roughness, value")
    field.fill("1.4")
    field.press("Enter")
    alert = shown.page.get_by_role("alert").filter(has_text="Allowed is 0 to 1")
    alert.wait_for()
    assert "still shows 0.5" in alert.inner_text()
    assert shown.value("gonio.sides[0].values.get('roughness')[0]") == 0.5
    field.press("Escape")
    shown.until("gonio.fieldError === null")


def test_a_refused_option_says_why_and_what_would_allow_it(shown: Shown) -> None:
    shown.run("await gonio.show('torrance_sparrow:distribution=beckmann')")
    shown.until("gonio.sides[0].payload.options.some((o) => o.values.some((v) => !v.allowed))")
    shown.page.get_by_label("compensation", exact=True).select_option("kulla_conty")
    shown.page.get_by_text("is made for distribution='ggx'").wait_for()
    assert shown.value("gonio.sides[0].options.get('compensation')") == "none"
    shown.page.get_by_role("button", name="Set distribution = ggx").click()
    shown.until("gonio.sides[0].options.get('compensation') === 'kulla_conty'")
    assert shown.value("gonio.sides[0].text()") == "torrance_sparrow:compensation=kulla_conty"
    shown.run("await gonio.show('eon')")


def test_options_show_their_values_where_another_model_had_others(shown: Shown) -> None:
    for text in ("car_paint", "weidlich_wilkie", "torrance_sparrow"):
        shown.run("await gonio.show(given, 'a')", text)
        shown.until(
            f"gonio.root.querySelectorAll('.opt select').length && gonio.sides[0].payload.name === '{text}'"
        )
        empty = shown.value(
            "[...gonio.root.querySelectorAll('.opt select')].filter((s) => !s.value).length"
        )
        assert empty == 0


def test_choices_are_ready_before_they_are_made(shown: Shown) -> None:
    start, chosen = "torrance_sparrow:alpha=0.4", "torrance_sparrow:masking=cook_torrance,alpha=0.4"
    shown.run("await gonio.show(given)", start)
    shown.run("""
      gonio.asked = [];
      const { model } = gonio.source;
      gonio.source.model = (text) => { gonio.asked.push(text); return model.call(gonio.source, text); };
    """)
    # Every choice is asked for once, while the list is looked at
    shown.page.get_by_label("masking", exact=True).hover()
    shown.until(f"gonio.asked.includes('{chosen}')")
    for masking, text in (("cook_torrance", chosen), ("smith_correlated", start)):
        shown.run("await gonio.setOptions({ masking: given })", masking)
        assert shown.value("gonio.sides[0].text()") == text
        assert shown.value("gonio.sides[0].payload.text") == text
    asked = shown.value("gonio.asked")
    assert asked.count(chosen) == 1
    assert start not in asked
    shown.run("delete gonio.source.model; await gonio.show('eon')")


def test_a_hidden_coat_shows_what_is_below(shown: Shown) -> None:
    state = {"env": "studio", "furnace": False, "shape": "sphere"}
    shown.run("await gonio.show('weidlich_wilkie:base=eon,base.rho=0.9/0.5/0.2')")
    below = shown.film(1, 24, **state)
    coats = "base=weidlich_wilkie,base.base=eon,base.base.rho=0.9/0.5/0.2,base.sigma_a=1/2/3"
    shown.run("await gonio.show(given)", f"weidlich_wilkie:{coats}")
    assert np.abs(shown.film(1, 24, **state) - below).max() > 0.1
    shown.page.get_by_role("button", name="Hide layer 2").click()
    shown.until("gonio.sides[0].active.payload.models.length === 1")
    np.testing.assert_array_equal(shown.film(1, 24, **state), below)
    shown.page.get_by_role("button", name="Show layer 2").click()
    shown.until("gonio.sides[0].active.payload.models.length === 2")
    shown.run("await gonio.show('eon')")


def test_coats_are_put_on_and_taken_off_and_the_base_stays(shown: Shown) -> None:
    shown.run("await gonio.show('eon:rho=0.9/0.5/0.2')")
    shown.page.get_by_role("button", name="+ Coat").click()
    shown.until("gonio.sides[0].models.size === 1")
    assert shown.value("gonio.sides[0].text()").endswith(",base.rho=0.9/0.5/0.2")
    shown.page.get_by_role("button", name="Remove layer 1").click()
    shown.until("gonio.sides[0].models.size === 0")
    assert shown.value("gonio.sides[0].text()") == "eon:rho=0.9/0.5/0.2"
    shown.run("await gonio.show('eon')")


def test_the_probe_has_the_numbers_of_gonio_eval(shown: Shown) -> None:
    shown.run("await gonio.show('weidlich_wilkie:alpha=0.2,base=eon'); gonio.state.probe = '';")
    shown.film(1, 32, env="studio", furnace=False, shape="ball")
    model = gonio.model("weidlich_wilkie", alpha=0.2, base="eon")
    shown.run("gonio.probe(0.45, 0.5)")
    shown.until("gonio.probed?.values.length === 1")
    seen = shown.value("({ ...gonio.probed.found, ...gonio.probed.values[0] })")
    wi, wo = np.array(seen["wi"]), np.array(seen["wo"])
    np.testing.assert_allclose(seen["f"], model.eval(wi, wo), rtol=F_ERROR)
    np.testing.assert_allclose(seen["pdf"], model.pdf(wi, wo), rtol=PDF_ERROR)
    # Where there is no closed form, the arrays' own number stands for the shader's coarse sum
    np.testing.assert_allclose(seen["albedo"], model.albedo(wo), rtol=1e-4)
    shown.run("gonio.set({ probe: '' }); await gonio.show('eon')")


def test_cards_and_the_probe_need_no_mouse(shown: Shown) -> None:
    shown.run("gonio.pointer = null; gonio.set({ probe: '' })")
    chip = shown.page.get_by_role("button", name="Model A: eon")
    chip.focus()
    chip.press("Enter")
    search = shown.page.get_by_label("Search", exact=True)
    shown.until("gonio.root.activeElement?.type === 'search'")
    search.press("Escape")
    shown.until("gonio.root.activeElement?.className === 'chip A'")  # where it came from
    picture = shown.page.locator(".canvas")
    picture.press("p")
    shown.until("gonio.probed?.values.length === 1")
    picture.press("Shift+ArrowLeft")
    shown.until("gonio.probed?.x === 0.49")
    picture.press("Escape")
    shown.until("gonio.state.probe === ''")


def test_plots_have_the_numbers_of_the_arrays(shown: Shown) -> None:
    shown.run("await gonio.show('eon:roughness=1'); gonio.set({ theta: 60 })")
    shown.until("gonio.data.A?.thetaO === 60 && gonio.data.A.key.includes('roughness')")
    data = shown.value("({ slice: gonio.data.A.slice, albedo: gonio.data.A.albedo })")
    model = gonio.model("eon", roughness=1)
    angle = np.radians([s["angle"] for s in data["slice"]])
    wi = np.stack([np.sin(angle), 0 * angle, np.cos(angle)], -1)
    wo = np.array([-np.sin(np.pi / 3), 0, 0.5])
    inside = wi[:, 2] > 1e-3
    f = np.array([s["f"] for s in data["slice"]])
    np.testing.assert_allclose(f[inside], model.eval(wi, wo)[inside], rtol=F_ERROR)
    angle = np.radians([s["angle"] for s in data["albedo"]])
    wanted = model.albedo(np.stack([np.sin(angle), 0 * angle, np.cos(angle)], -1))
    np.testing.assert_allclose([s["value"] for s in data["albedo"]], wanted, rtol=F_ERROR)
    shown.run("gonio.set({ theta: 45 }); await gonio.show('eon')")


def test_the_code_tab_is_the_exporters_text(shown: Shown, server: Viewer) -> None:
    from gonio.export.text import export

    shown.run("await gonio.show('eon:albedo_form=fitted'); gonio.set({ dock: 'code' })")
    shown.until("gonio.code.text && gonio.code.of === 'eon:albedo_form=fitted'")
    model = gonio.model("eon", albedo_form="fitted")
    assert shown.value("gonio.code.text") == export({"eon": model}, "wgsl")[0].source
    # An answer that comes after another language was chosen is not shown as that one's
    shown.run("""
      const { code } = gonio.source, wait = (ms) => new Promise((q) => setTimeout(q, ms));
      gonio.source.code = (...asked) => code.call(gonio.source, ...asked).then(async (found) => {
          if (asked[1] === "wgsl") await wait(600);
          return found;
      });
      gonio.setLanguage("wgsl");
      await wait(200);
      gonio.setLanguage("glsl");
      await wait(1000);
      delete gonio.source.code;
    """)
    shown.until("gonio.code.text")
    assert shown.value("gonio.code.text") == export({"eon": model}, "glsl")[0].source
    shown.run("gonio.setLanguage('wgsl'); gonio.set({ dock: 'plots' }); await gonio.show('eon')")


def test_a_lost_device_is_replaced_and_the_values_stay(shown: Shown) -> None:
    shown.run(
        "await gonio.show('eon:roughness=0.25'); gonio.kept = gonio.gpu; gonio.testLoss = true;"
    )
    shown.run(
        "const { device, gl } = gonio.gpu;"
        "if (device) device.destroy(); else gl.getExtension('WEBGL_lose_context').loseContext();"
    )
    shown.until("gonio.gpu && gonio.gpu !== gonio.kept && gonio.sides[0].program")
    assert shown.value("gonio.sides[0].text()") == "eon:roughness=0.25"
    shown.until("gonio.notes.some((n) => n.title.includes('is back'))")
    picture = shown.film(1, 16, furnace=True, shape="sphere")
    assert np.isfinite(picture).all()
    assert picture.max() == pytest.approx(1, abs=BACKGROUND)
    shown.complaints[:] = [
        c for c in shown.complaints if "CONTEXT_LOST" not in c and "Lost" not in c
    ]


def test_a_device_that_only_throws_is_replaced(shown: Shown) -> None:
    shown.run(
        "await gonio.show('eon'); gonio.kept = gonio.gpu; gonio.notes.length = 0; delete gonio.lostAt;"
        "gonio.gpu.trace = () => { throw new Error('The instance is gone.'); };"
        "gonio.renderer.paused = false; gonio.moved(false);"
    )
    # Said at the end, when sizes and programs are those of the new one
    shown.until("gonio.notes.some((n) => n.title.includes('is back'))")
    assert shown.value("gonio.gpu !== gonio.kept")
    assert "The picture stopped." in shown.value("gonio.notes.map((n) => n.title)")
    picture = shown.film(1, 16, furnace=True, shape="sphere")
    assert picture.max() == pytest.approx(1, abs=BACKGROUND)


def test_what_is_lost_twice_is_left_for_the_other_interface(
    browser: Browser, server: Viewer
) -> None:
    found = Shown(browser, f"{server.origin}/#token={server.token}&a=eon")
    found.until("gonio.gpu?.name === 'WebGPU' && gonio.sides[0].program")
    found.run("gonio.kept = gonio.gpu; gonio.testLoss = true; gonio.gpu.device.destroy();")
    found.until("gonio.notes.some((n) => n.title.includes('is back'))")
    found.run("gonio.testLoss = true; gonio.gpu.device.destroy();")
    found.until("gonio.notes.some((n) => n.title.startsWith('WebGL2 is used instead'))")
    assert found.value("gonio.gpu.name") == "WebGL2"
    assert np.isfinite(found.film(1, 16, furnace=True, shape="sphere")).all()
    found.page.close()


def test_a_link_restores_everything(browser: Browser, server: Viewer) -> None:
    a = "weidlich_wilkie:base=eon,base.roughness=0.4,alpha=0.05"
    wanted = f"a={a}&b=eon&cmp=side&env=sun&ev=0.5&theta=30&az=20"
    found = Shown(browser, f"{server.origin}/#token={server.token}&{wanted}")
    assert found.value("gonio.sides.map((s) => s.text())") == [
        "weidlich_wilkie:base=eon,alpha=0.05,base.roughness=0.4",
        "eon",
    ]
    state = found.value("gonio.state")
    shown = {k: state[k] for k in ("cmp", "env", "ev", "theta", "az")}
    assert shown == {"cmp": "side", "env": "sun", "ev": 0.5, "theta": 30, "az": 20}
    link = found.value("gonio.link()")
    assert server.token not in link
    assert "b=eon&cmp=side&env=sun" in link
    found.page.close()


def test_a_saved_file_is_read_again_and_an_error_leaves_the_picture(
    browser: Browser, tmp_path: Path
) -> None:
    mine = tmp_path / "mine.py"
    mine.write_text(BROKEN.replace("TooBright", "Mine"), encoding="utf-8")
    viewer = Viewer([str(mine)], [str(mine)])
    thread = threading.Thread(target=viewer.serve_forever, kwargs={"poll_interval": 0.05})
    thread.start()
    try:
        tabs = browser.new_context()
        found = Shown(tabs, viewer.url)
        found.run("gonio.setParameter('rho', [0.5, 0.5, 0.5])")
        second = Shown(tabs, viewer.url)
        mine.write_text(
            BROKEN.replace("TooBright", "Mine").replace("1.25", "1.5"), encoding="utf-8"
        )
        for tab in (found, second):
            tab.until("gonio.sides[0].payload.code.wgsl.includes('1.5')")
        # Browsers keep six connections to a server: a seventh tab would wait for ever if each held one
        streams = [url for tab in (found, second) for url in tab.requests if "changes" in url]
        assert len(streams) == 1
        second.page.close()
        assert found.value("gonio.sides[0].values.get('rho')[0]") == 0.5  # the slider stays
        mine.write_text(BROKEN.replace("wi = sample_cosine(u)", "wi = ="), encoding="utf-8")
        found.until("gonio.sides[0].error")
        error = found.value("gonio.sides[0].error.text")
        assert "mine.py, line 16" in error
        assert "the last model that worked" in error
        assert found.value("gonio.sides[0].program != null")
        # The end of the server is told where nothing is asked of it
        viewer.shutdown()
        viewer.server_close()
        found.until("gonio.notes.some((n) => n.title.includes('has stopped'))")
        assert found.value("gonio.sides[0].program != null")
        found.run("gonio.setParameter('rho', [0.25, 0.25, 0.25])")
        assert found.value("gonio.sides[0].values.get('rho')[0]") == 0.25
        tabs.close()
    finally:
        viewer.shutdown()
        viewer.server_close()
        thread.join()


def test_a_bad_link_says_so_and_something_is_shown(browser: Browser, server: Viewer) -> None:
    bad = "a=eno&ev=bright&what=1&toString=2&cmp=diff&probe=2,x"
    found = Shown(browser, f"{server.origin}/#token={server.token}&{bad}")
    assert found.value("gonio.sides[0].text()") == "eon"
    notes = json.dumps(found.value("gonio.notes"))
    assert "ev, what, toString, probe" in notes
    assert found.value("gonio.state.cmp") == "A"
    assert "eno cannot be shown" in notes
    found.page.close()


def test_without_its_token_the_page_says_what_to_do(browser: Browser, server: Viewer) -> None:
    page = browser.new_context().new_page()
    page.goto(f"{server.origin}/")
    page.get_by_text("use the one that gonio view printed").wait_for()
    page.close()


def test_a_saved_page_works_from_a_file(browser: Browser, tmp_path: Path) -> None:
    names = pages.Names()
    path = tmp_path / "eon.html"
    path.write_text(pages.saved(names, ["eon"], pool(names, ["eon"])), encoding="utf-8")
    found = Shown(browser, path.as_uri())
    found.run("gonio.setParameter('roughness', [0.75])")
    found.run("await gonio.setOptions({ albedo_form: 'fitted' })")
    assert found.value("gonio.sides[0].text()") == "eon:albedo_form=fitted,roughness=0.75"
    assert found.value("gonio.sides[0].values.get('roughness')[0]") == 0.75
    assert found.value("gonio.gpu.name") == "WebGPU"
    # Its rarely used parts come from the file as well
    found.run("gonio.set({ view: 'lobe', dock: 'about' })")
    found.page.get_by_text("Promised, and measured").first.wait_for()
    assert found.run("return Boolean((await gonio.part('files')).openFile)")
    assert [url for url in found.requests if not url.startswith(("file:", "data:", "blob:"))] == []
    assert found.complaints == []
    found.page.close()


def test_a_saved_page_has_the_values_of_words(browser: Browser, tmp_path: Path) -> None:
    texts = ["torrance_sparrow:metal=Cu", "eon:rho=#c08040"]
    path = tmp_path / "words.html"
    path.write_text(pages.saved(pages.Names(), texts), encoding="utf-8")
    found = Shown(browser, path.as_uri())
    metal: Any = load(texts[0])
    clay: Any = load(texts[1])
    for side, name, value in ((0, "eta", metal.eta), (0, "k", metal.k), (1, "rho", clay.rho)):
        assert found.value(f"gonio.sides[{side}].values.get('{name}')") == pytest.approx(value)
    # Links to other materials of the same shader, as people paste them behind the page's address
    for text, names in (
        ("torrance_sparrow:metal=Al,alpha=0.2", ("eta", "k", "alpha")),
        ("torrance_sparrow:eta=flint glass", ("eta", "k")),
        ("eon:rho=#48c", ("rho",)),
    ):
        read = found.run("return gonio.source.model(given)", text)
        shown = {p["path"]: p["value"] for p in read["parameters"]}
        for name in names:
            value = np.broadcast_to(getattr(load(text), name), len(shown[name]))
            assert shown[name] == pytest.approx(list(value))
    for text in ("eon:rho=red", "eon:metal=Cu", "torrance_sparrow:metal=Xx"):
        told = found.run("return gonio.source.model(given).catch((e) => e.message)", text)
        assert told == f"This saved page does not know {text.partition(':')[2]}."
    told = found.run("return gonio.source.model('eon:rough=1').catch((e) => e.message)")
    assert told == "eon has no 'rough'."
    found.page.close()


# A notebook's widget model, whose kernel is the server.
WIDGET = """
const values = { a: "eon:roughness=0.2", b: "", settings: "env=sun", height: 600, link: "" }, calls = {};
const widget = {
  get: (k) => values[k],
  set: (k, v) => { values[k] = v; },
  on: (name, call) => { calls[name] = call; },
  off: (name) => { delete calls[name]; },
  save_changes: () => { globalThis.saved = { ...values }; },
  send: async ({ id, question, body }) => {
    const found = await gonio.source[question](body.text, body.language);
    const answer = question === "file" ? { text: found } : found;
    calls["msg:custom"]({ id, answer });
  },
};
const { default: view } = await import("/viewer.js"), el = document.createElement("div");
document.body.append(el);
globalThis.unmount = await view.render({ model: widget, el });
globalThis.widget = { values, calls, el };
"""


def test_a_notebooks_widget_follows_the_page_and_leads_it(shown: Shown) -> None:
    shown.run(WIDGET)
    slider = shown.page.locator(".embedded").get_by_label("roughness", exact=True)
    slider.focus()
    slider.press("ArrowRight")
    shown.until("globalThis.saved?.a === 'eon:roughness=0.21'")
    assert "env=sun" in shown.value("saved.link")
    shown.run("widget.values.a = 'lambert'; await widget.calls['change:a']()")
    shown.page.locator(".embedded").get_by_text("Lambert").first.wait_for()
    shown.run("unmount(); widget.el.remove()")
    assert shown.value("Object.keys(widget.calls)") == ["msg:custom"]
    # Parts of a widget's script are data: URLs, as in a saved page; the server's page, which a notebook's
    # is not, forbids these.
    shown.complaints[:] = [c for c in shown.complaints if "data:text/javascript" not in c]
    # The page's own graphics are still there
    shown.run("await gonio.show('eon')")
    assert np.isfinite(shown.film(1, 16, furnace=True, shape="sphere")).all()


# --- code that others wrote ----------------------------------------------------------------------------

# Karis's terms in GLSL of desktops, with names that the page's own passes have, and a macro of one letter.
GLSL = """#version 450
#define k(x) clamp(x, 0.0, 1.0)
struct Light { float path; };
uniform float strength;
float hash(float NoH, Light ball) {
    float a2 = ball.path * ball.path, f = NoH * NoH * (a2 - 1.0) + 1.0;
    return a2 / (3.14159265 * f * f);
}
float model_eval(float x, float a) { return sqrt(x * x * (1.0 - a * a) + a * a); }
vec3 ggx(vec3 L, vec3 V, vec3 N, vec3 f0, float roughness) {
    vec3 H = normalize(L + V);
    float NoL = k(dot(N, L)), NoV = k(dot(N, V)), NoH = k(dot(N, H));
    Light box;
    box.path = roughness * roughness;
    float G = 2.0 * NoL * NoV / (NoV * model_eval(NoL, box.path) + NoL * model_eval(NoV, box.path));
    vec3 F = f0 + (1.0 - f0) * pow(1.0 - k(dot(V, H)), 5.0);
    return strength * hash(NoH, box) * G * F / max(4.0 * NoL * NoV, 1e-7);
}
"""
# Its value has the cosine and is given half vector and cosines.
WGSL = """struct Surface { rho: vec3f, meet: f32 }
fn box(x: f32, f90: f32) -> f32 { return 1.0 + (f90 - 1.0) * pow(1.0 - x, 5.0); }
fn burley(s: Surface, NdotL: f32, NdotV: f32, LdotH: f32) -> vec3f {
    let f90 = 0.5 + 2.0 * s.meet * LdotH * LdotH;
    return s.rho * (box(NdotL, f90) * box(NdotV, f90) * NdotL / 3.14159265);
}
"""
BRDF = """analytic
::begin parameters
color Kd 0.8 0.4 0.1
float n 1 50 8
::end parameters
::begin shader
vec3 BRDF(vec3 L, vec3 V, vec3 N, vec3 X, vec3 Y) {
    return Kd / 3.14159265 + vec3(pow(max(dot(reflect(-L, N), V), 0.0), n));
}
::end shader
"""


def test_code_of_others_draws_with_its_own_text(browser: Browser, tmp_path: Path) -> None:
    from gonio.foreign.model import ForeignModel

    texts = {"g.glsl": GLSL, "b.wgsl": WGSL, "p.brdf": BRDF}
    for name, text in texts.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    files = [f"{tmp_path / name}" for name in ("g.glsl#ggx", "b.wgsl#burley", "p.brdf#BRDF")]
    viewer = Viewer([files[0], "eon"], files)
    thread = threading.Thread(target=viewer.serve_forever, kwargs={"poll_interval": 0.05})
    thread.start()
    try:
        found = Shown(browser, viewer.url)
        # GLSL runs where a browser runs GLSL, and takes the other side along
        assert found.value("[gonio.gpu.name, gonio.sides[1].text()]") == ["WebGL2", "eon"]
        rows = directions(1024)
        wi, wo = rows[:, :3].astype(float), rows[:, 3:6].astype(float)
        for name in (files[0], files[2], files[1]):
            found.run("await gonio.show(given); await gonio.compare(false)", name)
            made = found.rows(name, rows)
            model = viewer.names.code.model(name)
            assert isinstance(model, ForeignModel)
            f = model.foreign.brdf(wi, wo)
            # The code itself is single precision: where it is steep, roundings are larger than a driver's
            assert far_off(made[:, :3], f, 10 * F_ERROR).any(axis=1).mean() < 0.01, name
            # Samples hit what the density says: over them, cos / pi / pdf has the mean 1, its integral. It
            # lies between 0 and 2, so that 4,096 know their mean to 0.02
            oblique = np.zeros((4096, 8), np.float32)
            oblique[:, 2], oblique[:, 3], oblique[:, 5] = 1, 0.6, 0.8
            oblique[:, 6:] = np.minimum(np.random.default_rng(3).random((4096, 2)), 1 - 2**-24)
            drawn = found.rows(name, oblique)
            hit = drawn[:, 7] > 0
            mean = np.sum(drawn[hit, 6] / np.pi / drawn[hit, 7]) / len(drawn)
            # Three times 0.02
            assert mean == pytest.approx(1, abs=0.06), name
            albedo = found.run(ALBEDO, [name, [0.6, 0, 0.8]])
            wanted = model.albedo(np.array([0.6, 0, 0.8]))
            # Shaders sum some hundred samples
            np.testing.assert_allclose(albedo, wanted, rtol=5e-3)
            assert np.isfinite(found.film(1, 24, env="studio", furnace=False, shape="ball")).all()
        assert found.value("gonio.gpu.name") == "WebGPU"
        assert found.value("gonio.sides[0].payload.foreign.text") == WGSL
        # Two languages cannot share one interface
        found.run("await gonio.compare(true); await gonio.show(given, 'b')", files[0])
        assert "side by side" in found.value("gonio.sides[1].error.text")
        assert found.value("gonio.sides[0].program !== null")
        # A saved file is read again, and one that is wrong leaves the picture
        (tmp_path / "b.wgsl").write_text(WGSL.replace("0.5 + 2.0", "0.6 + 2.0"), encoding="utf-8")
        found.until("gonio.sides[0].payload.code.wgsl.includes('0.6 + 2.0')")
        (tmp_path / "b.wgsl").write_text(WGSL.replace("let f90", "lt f90"), encoding="utf-8")
        found.until("gonio.sides[0].error")
        assert "b.wgsl:4" in found.value("gonio.sides[0].error.text")
        assert found.complaints == []
        found.page.close()
    finally:
        viewer.shutdown()
        viewer.server_close()
        thread.join()


# --- files that are dropped ----------------------------------------------------------------------------


def radiance_hdr(pixels: Any) -> bytes:
    """A flat .hdr file, written here: mantissas over a shared exponent."""
    height, width, _ = pixels.shape
    lines = [f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n".encode()]
    for value in pixels.reshape(-1, 3):
        exponent = int(np.ceil(np.log2(max(value.max(), 1e-30)) + 1e-9)) + 128
        lines.append(bytes([*np.floor(value / 2.0 ** (exponent - 136)).astype(int), exponent]))
    return b"".join(lines)


def take(shown: Shown, name: str, content: bytes) -> None:
    shown.run(
        "const bytes = Uint8Array.from(atob(given[1]), (c) => c.charCodeAt(0));"
        "await gonio.take(new File([bytes], given[0]));",
        [name, base64.b64encode(content).decode()],
    )


def test_a_dropped_picture_lights_the_scene_and_its_sun_is_not_clipped(shown: Shown) -> None:
    pixels = np.full((4, 8, 3), 0.25)
    pixels[0, 3] = 8192.0
    take(shown, "sky.hdr", radiance_hdr(pixels))
    assert shown.value("gonio.state.env") == "own"
    assert shown.value("Math.max(...gonio.renderer.sky.pixels)") == 8192.0
    assert np.isfinite(shown.film(1, 16, furnace=False, shape="sphere")).all()
    shown.run("gonio.set({ env: 'studio' })")


@pytest.mark.parametrize("compression", ["zip", "piz", "none"])
def test_a_dropped_exr_has_its_first_line_at_the_top(
    shown: Shown, tmp_path: Path, compression: str
) -> None:
    import OpenEXR

    pixels = np.full((8, 16, 3), 0.5, np.float16)
    pixels[0] = (4, 5, 6)
    pixels[3, 2] = np.inf  # an overflowed sun counts as the largest half float
    kind = {"zip": "ZIP_COMPRESSION", "piz": "PIZ_COMPRESSION", "none": "NO_COMPRESSION"}
    header = {
        "compression": getattr(OpenEXR, kind[compression]),
        "type": OpenEXR.scanlineimage,
    }
    OpenEXR.File(header, {"RGB": pixels}).write(str(tmp_path / "sky.exr"))
    take(shown, "sky.exr", (tmp_path / "sky.exr").read_bytes())
    sky = shown.value("({ w: gonio.renderer.sky.width, p: [...gonio.renderer.sky.pixels] })")
    read = np.array(sky["p"]).reshape(8, 16, 4)[..., :3]
    np.testing.assert_array_equal(read, np.minimum(pixels.astype(float), 65504))
    shown.run("gonio.set({ env: 'studio' })")


CORNER = ([[0, 0, 0], [1, 0, 0], [0, 0, -1]], [[0, 1, 2]])


def glb(positions: Any, faces: Any, node: dict[str, Any] | None = None) -> bytes:
    """A binary glTF file of one mesh, written here."""
    place = np.asarray(positions, "<f4").tobytes()
    order = np.asarray(faces, "<u2").tobytes()
    order += bytes(-len(order) % 4)
    views = [
        {"buffer": 0, "byteOffset": 0, "byteLength": len(place)},
        {"buffer": 0, "byteOffset": len(place), "byteLength": len(order)},
    ]
    accessors = [
        {"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": len(positions)},
        {"bufferView": 1, "componentType": 5123, "type": "SCALAR", "count": np.size(faces)},
    ]
    about = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, **(node or {})}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(place + order)}],
    }
    text = json.dumps(about).encode()
    text += b" " * (-len(text) % 4)
    chunks = b"".join(
        len(c).to_bytes(4, "little") + kind + c
        for c, kind in ((text, b"JSON"), (place + order, b"BIN\0"))
    )
    return b"glTF" + (2).to_bytes(4, "little") + (12 + len(chunks)).to_bytes(4, "little") + chunks


def test_a_dropped_glb_is_turned_and_scaled_as_its_node_says(shown: Shown) -> None:
    # A flat triangle that the node turns upright by a quarter about x, and stretches four times
    triangle = glb(
        *CORNER,
        {"rotation": [np.sqrt(0.5), 0, 0, np.sqrt(0.5)], "scale": [1, 1, 4]},
    )
    take(shown, "flag.glb", triangle)
    own = "gonio.renderer.own"
    # Its height is four times its width, and the largest side becomes 2
    assert shown.value(f"{own}.height") == pytest.approx(2, abs=SINGLE_LONG)
    places = np.array(shown.value(f"[...{own}.mesh.positions]")).reshape(-1, 3)
    assert np.ptp(places, axis=0) == pytest.approx([0.5, 2, 0], abs=SINGLE_LONG)
    assert np.isfinite(shown.film(1, 16, furnace=False, shape="own")).all()
    shown.run("gonio.set({ shape: 'ball' })")


def test_a_dropped_mesh_takes_the_balls_place(shown: Shown) -> None:
    take(shown, "quad.obj", b"v 0 0 0\nv 1 0 0\nv 1 2 0\nv 0 2 0\nf 1 2 3 4\n")
    assert shown.value("gonio.state.shape") == "own"
    assert shown.value("[gonio.renderer.own.mesh.faces.length / 3, gonio.renderer.own.height]") == [
        2,
        2,
    ]
    shown.run("gonio.set({ shape: 'ball' })")


@pytest.mark.parametrize(
    ("name", "content", "says"),
    [
        ("harbour.hdr", b"PNG", "Its first line is not #?RADIANCE."),
        ("short.hdr", b"#?RADIANCE\n\n-Y 4 +X 8\n", "The file ends too early."),
        ("huge.hdr", b"#?RADIANCE\n\n-Y 99999 +X 99999\n", "the page takes"),
        ("no.exr", b"not an exr", "does not begin as an OpenEXR"),
        ("bad.obj", b"v 0 0 0\nf 1 2 3\n", "names a point that does not exist"),
        ("no.glb", b"glTF", "does not begin as a binary glTF"),
        ("broken.exr", b"\x76\x2f\x31\x01\2\0\0\0\0", "its header or its data are damaged"),
        (
            "endless.glb",
            glb(*CORNER).replace(b'"VEC3", "count": 3', b'"VEC3","count":9e9'),
            "The file ends too early.",
        ),
        ("circle.glb", glb(*CORNER, {"children": [0, 0]}), "Its nodes are damaged."),
        ("picture.jpeg", b"", "The page takes .hdr and .exr"),
    ],
)
def test_a_file_that_will_not_do_changes_nothing(
    shown: Shown, name: str, content: bytes, says: str
) -> None:
    before = shown.value("[gonio.state.env, gonio.state.shape]")
    take(shown, name, content)
    note = shown.value("gonio.notes.at(-1)")
    assert name in note["title"]
    assert says in note["text"]
    assert shown.value("[gonio.state.env, gonio.state.shape]") == before
