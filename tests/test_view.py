"""`gonio view` without a browser: what the server refuses, what pages are told, what saved ones hold."""

from __future__ import annotations

import base64
import gzip
import http.client
import json
import math
import os
import re
import shutil
import subprocess
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from support.tolerances import DOUBLE_DIVIDED, HALF

import gonio
from gonio import foreign
from gonio.cli import main
from gonio.export.text import export
from gonio.fields import ModelError, Option
from gonio.view import page, server
from gonio.view.variants import pool

WEB = Path(page.__file__).parent / "web"
DOCUMENTED = (Path(__file__).parents[1] / "docs" / "viewer.md").read_text(encoding="utf-8")

# Bytes of the script that every page waits for and every saved page holds
OPENING = 120_000


@pytest.fixture(scope="module")
def viewer() -> Iterator[server.Viewer]:
    made = server.Viewer(["eon"])
    thread = threading.Thread(target=made.serve_forever, kwargs={"poll_interval": 0.05})
    thread.start()
    yield made
    made.shutdown()
    made.server_close()
    thread.join()


def ask(
    viewer: server.Viewer,
    path: str = "/api/model",
    body: Any = None,
    method: str = "POST",
    **changed: str | None,
) -> tuple[int, Any, dict[str, str]]:
    """A request as the page makes it, with some headers changed or (None) left out."""
    text = body if isinstance(body, (str, bytes)) else json.dumps(body or {"text": "eon"})
    headers: dict[str, str | None] = {
        "Host": f"127.0.0.1:{viewer.server_port}",
        "Origin": viewer.origin,
        "X-Gonio-Token": viewer.token,
        "Content-Type": "application/json",
    }
    headers |= {name.replace("_", "-"): value for name, value in changed.items()}
    connection = http.client.HTTPConnection("127.0.0.1", viewer.server_port, timeout=30)
    connection.putrequest(method, path, skip_host=True)
    for name, value in headers.items():
        if value is not None:
            connection.putheader(name, value)
    if method == "POST":
        connection.putheader("Content-Length", str(len(text)))
        connection.endheaders(text.encode() if isinstance(text, str) else text)
    else:
        connection.endheaders()
    answer = connection.getresponse()
    content = answer.read()
    connection.close()
    kind = answer.headers.get_content_type()
    return (
        answer.status,
        json.loads(content) if kind == "application/json" else content.decode(),
        dict(answer.headers),
    )


def test_the_page_itself_gets_a_model(viewer: server.Viewer) -> None:
    status, found, _ = ask(viewer)
    assert status == 200
    assert found["code"]["wgsl"] == export({"model": gonio.model("eon")}, "wgsl")[0].source


# Each is what another page, another machine or a broken program might send.
HOSTILE: dict[str, tuple[dict[str, Any], int]] = {
    "a foreign name that points to this machine": ({"Host": "evil.example:80"}, 403),
    "localhost, which is not what was printed": ({"Host": "localhost:80"}, 403),
    "another page": ({"Origin": "http://evil.example"}, 403),
    "no origin": ({"Origin": None}, 403),
    "a file": ({"Origin": "null"}, 403),
    "no token": ({"X_Gonio_Token": None}, 403),
    "a wrong token": ({"X_Gonio_Token": "a" * 32}, 403),
    "a token that is no ASCII": ({"X_Gonio_Token": "ü"}, 403),
    "a form": ({"Content_Type": "application/x-www-form-urlencoded"}, 415),
    "text, which needs no permission between pages": ({"Content_Type": "text/plain"}, 415),
    "a path out of the folder": ({"path": "/../../etc/passwd"}, 404),
    "an encoded path": ({"path": "/%2e%2e/%2e%2e/etc/passwd"}, 404),
    "a file of the package": ({"path": "/gonio/view/server.py"}, 404),
    "a body that is too long": ({"body": json.dumps({"text": "e" * 20000})}, 413),
    "a body that is no JSON": ({"body": "{"}, 400),
    "a body of many brackets": ({"body": "[" * 8000}, 400),
    "a list": ({"body": "[]"}, 400),
    "no text": ({"body": "{}"}, 400),
    "a number for a text": ({"body": '{"text": 3}'}, 400),
    "half a character": ({"body": '{"text": "eon:rho=\\ud800"}'}, 422),
    "a body in chunks": ({"Transfer_Encoding": "chunked"}, 411),
    "a file that was not named": ({"body": '{"text": "/etc/x.glsl#f"}'}, 422),
    "no direction": ({"path": "/api/albedo", "body": '{"text": "eon", "wo": [0, 0, 0]}'}, 422),
    "a text for a direction": ({"path": "/api/albedo", "body": '{"text": "eon", "wo": "up"}'}, 400),
    "an unknown language": (
        {"path": "/api/code", "body": '{"text": "eon", "language": "exe"}'},
        400,
    ),
}


@pytest.mark.parametrize("what", list(HOSTILE))
def test_the_server_refuses(viewer: server.Viewer, what: str) -> None:
    changed, wanted = HOSTILE[what]
    status, found, headers = ask(viewer, **changed)
    assert status == wanted
    assert set(found) == {"error"}
    assert "\n" not in found["error"]
    assert not [name for name in headers if name.startswith("Access-Control")]


@pytest.mark.parametrize("method", ["GET", "PUT", "DELETE", "OPTIONS", "HEAD"])
def test_only_the_page_and_its_script_are_there_to_get(viewer: server.Viewer, method: str) -> None:
    status, _, headers = (
        ask(viewer, "/api/model", method=method)
        if method != "HEAD"
        else (
            501,
            "",
            {},
        )
    )
    assert status in (404, 501)
    assert not [name for name in headers if name.startswith("Access-Control")]


def test_the_page_may_load_nothing_from_elsewhere(viewer: server.Viewer) -> None:
    status, text, headers = ask(viewer, "/", method="GET")
    assert status == 200
    assert headers["Content-Security-Policy"].startswith("default-src 'self'")
    assert "unsafe" not in headers["Content-Security-Policy"]
    assert viewer.token not in text
    assert not re.search(r"https?://", text)


def test_a_file_that_was_not_named_is_neither_opened_nor_run(
    viewer: server.Viewer, tmp_path: Path
) -> None:
    trap = tmp_path / "trap.py"
    trap.write_text(f"open({str(tmp_path / 'sprung')!r}, 'w').close()\n", encoding="utf-8")
    (tmp_path / "trap.toml").write_text('model = "eon"\n', encoding="utf-8")
    for text in (
        str(trap),
        f"{trap}:rho=0.5",
        f"weidlich_wilkie:base={trap}",
        f"weidlich_wilkie:base={tmp_path / 'trap.toml'}",
        str(tmp_path / "trap.toml"),
    ):
        status, found, _ = ask(viewer, body={"text": text})
        assert status == 422, text
        assert "was not named" in found["error"]
    assert not (tmp_path / "sprung").exists()


def test_layers_are_not_nested_without_end(viewer: server.Viewer) -> None:
    pieces = [f"{'base.' * i}base=weidlich_wilkie" for i in range(9)]
    status, found, _ = ask(viewer, body={"text": f"weidlich_wilkie:{','.join(pieces)}"})
    assert status == 422
    assert "deep" in found["error"]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("eno", "did you mean"),
        ("eon:roughness=2", "out of range"),
        ("eon:roughnes=1", "did you mean 'roughness'"),
        ("torrance_sparrow:distribution=beckmann,compensation=turquin", "is made for"),
    ],
)
def test_what_cannot_be_shown_has_the_models_own_sentence(
    viewer: server.Viewer, text: str, says: str
) -> None:
    status, found, _ = ask(viewer, body={"text": text})
    assert status == 422
    assert says in found["error"]


def test_the_code_tab_has_the_text_of_gonio_export(viewer: server.Viewer) -> None:
    for text, language in (("eon:albedo_form=fitted", "glsl"), ("gold", "hlsl"), ("eon", "mtlx")):
        _, found, _ = ask(viewer, "/api/code", body={"text": text, "language": language})
        done = CliRunner().invoke(main, ["export", text, "--to", language])
        if language == "mtlx":  # several files; the command writes them to a folder
            assert "nodedef" in found["text"]
        else:
            assert found["text"] == done.stdout


def test_an_albedo_that_shaders_sum_is_that_of_the_arrays(viewer: server.Viewer) -> None:
    text, wo = "torrance_sparrow:alpha=0.2", [0.6, 0.0, 0.8]
    _, found, _ = ask(viewer, "/api/albedo", body={"text": text, "wo": wo})
    wanted = gonio.model("torrance_sparrow", alpha=0.2).albedo(np.array(wo))
    np.testing.assert_allclose(found["albedo"], wanted, rtol=DOUBLE_DIVIDED)
    _, made, _ = ask(viewer, body={"text": text})
    _, closed, _ = ask(viewer, body={"text": "eon"})
    assert (made["sums"], closed["sums"]) == (True, False)


def test_a_saved_file_is_told_to_the_page(tmp_path: Path) -> None:
    material = tmp_path / "floor.toml"
    material.write_text('model = "eon"\nroughness = 0.2\n', encoding="utf-8")
    viewer = server.Viewer([str(material)], [str(material)])
    thread = threading.Thread(target=viewer.serve_forever, kwargs={"poll_interval": 0.05})
    thread.start()
    try:
        _, found, _ = ask(viewer, body={"text": str(material)})
        assert found["parameters"][1]["value"] == [0.2]
        connection = http.client.HTTPConnection("127.0.0.1", viewer.server_port, timeout=30)
        headers = {
            "Origin": viewer.origin,
            "X-Gonio-Token": viewer.token,
            "Content-Type": "application/json",
        }
        connection.request("POST", "/api/changes", "{}", headers)
        answer = connection.getresponse()
        material.write_text('model = "eon"\nroughness = 0.25\n', encoding="utf-8")
        assert answer.readline() == f"data: {json.dumps({'file': str(material)})}\n".encode()
        _, found, _ = ask(viewer, body={"text": str(material)})
        assert found["parameters"][1]["value"] == [0.25]
    finally:
        viewer.shutdown()
        viewer.server_close()
        thread.join()


# --- what the page is told -----------------------------------------------------------------------------


def test_a_materials_maps_and_hooks_are_those_of_gonio_render(tmp_path: Path) -> None:
    from PIL import Image

    wood = np.zeros((4, 4, 3), np.uint8)
    wood[:, 2:] = (255, 188, 0)
    Image.fromarray(wood).save(tmp_path / "wood.png")
    path = tmp_path / "floor.toml"
    path.write_text('model = "eon"\nrho = "wood.png"\n', encoding="utf-8")
    found = page.payload(page.Names([str(path)]), str(path))
    (hook,) = found["hooks"]
    assert (hook["path"], hook["source"], hook["width"]) == ("rho", "texture", 3)
    maps = found["maps"]
    texels = np.frombuffer(base64.b64decode(maps["half"]), np.float16).reshape(4, 4, 3)
    # 188 in sRGB is half of white's light
    np.testing.assert_allclose(texels[0, 3], [1, 0.5029, 0], atol=1e-3)
    np.testing.assert_array_equal(texels[0, 0], 0)


def test_flakes_are_the_map_that_gonio_render_has() -> None:
    from gonio.mitsuba.textures import flake_map

    maps = page.payload(page.Names(), "car_paint_red_strong")["maps"]
    texels = np.frombuffer(base64.b64decode(maps["half"]), np.float16)
    wanted = flake_map(density=0.95, spread=0.3, flake_size=3, seed=1)  # as its file says
    np.testing.assert_allclose(texels.reshape(wanted.shape), wanted, atol=1e-3)


def test_a_drawn_ball_has_the_shapes_of_gonio_render() -> None:
    from gonio.render.ball import BALL_CENTRE, CORE_RADIUS
    from gonio.view.scene import shapes

    found = shapes()
    shell = found["shell"]
    steps = np.frombuffer(base64.b64decode(shell["positions"]), np.uint16).reshape(-1, 3)
    low, high = np.array(shell["low"]), np.array(shell["high"])
    points = low + steps / 65535 * (high - low) - [0, BALL_CENTRE, 0]
    radii = np.linalg.norm(points, axis=1)
    # Positions are stored in steps of 1/65535 of the box
    assert radii.max() == pytest.approx(1, abs=1e-4)
    assert radii.min() == pytest.approx(0.9, abs=1e-3)  # the shell's inside
    assert found["core"]["radius"] == CORE_RADIUS
    faces = np.frombuffer(base64.b64decode(shell["faces"]), np.uint16)
    assert len(faces) / 3 < 30_000


def test_what_is_not_known_is_an_error_of_one_line() -> None:
    with pytest.raises(ModelError, match="at most"):
        page.Names().find("eon:" + "a" * 5000)


# --- the widget ----------------------------------------------------------------------------------------


def test_the_widget_answers_the_page_and_has_its_values() -> None:
    import gonio.view

    viewer = gonio.view.Viewer(gonio.model("eon", roughness=0.8), "lambert")
    assert (viewer.a, viewer.b) == ("eon:roughness=0.8", "lambert")
    sent: list[dict[str, Any]] = []
    viewer.send = lambda message, buffers=None: sent.append(message)
    viewer._answer(viewer, {"id": 1, "question": "model", "body": {"text": "eon"}}, [])
    viewer._answer(viewer, {"id": 2, "question": "model", "body": {"text": "eno"}}, [])
    viewer._answer(viewer, {"id": 3, "question": "start", "body": {}}, [])
    viewer._answer(viewer, {"id": 4, "question": "shell", "body": {"text": "ls"}}, [])
    assert sent[0]["answer"]["model"] == "eon"
    assert "did you mean" in sent[1]["error"]
    assert sent[2]["answer"]["show"] == ["eon:roughness=0.8", "lambert"]
    assert "no question" in sent[3]["error"]
    viewer.a = "eon:roughness=0.3"  # as the page does when a slider moves
    assert viewer.model == gonio.model("eon", roughness=0.3)


def test_the_widget_takes_materials_and_refuses_what_is_not_there() -> None:
    import gonio.view

    material = gonio.load("gold:alpha=0.3")
    assert gonio.view.Viewer(material).model == material
    with pytest.raises(ModelError, match="eno"):
        gonio.view.Viewer("eno")


def test_textures_are_scaled_and_normals_bent_as_in_gonio_render(tmp_path: Path) -> None:
    from PIL import Image

    Image.new("RGB", (2, 2), (128, 128, 255)).save(tmp_path / "bumps.png")
    path = tmp_path / "floor.toml"
    path.write_text(
        'model = "eon"\nrho = "bumps.png"\nnormal_map = "bumps.png"\ntexture_scale = [3, 2]\n',
        encoding="utf-8",
    )
    found = page.payload(page.Names([str(path)]), str(path))
    hooks = {h["source"]: h for h in found["hooks"]}
    assert hooks["texture"]["scale"] == hooks["normal_map"]["scale"] == [3, 2]
    assert [hooks["texture"]["layer"], hooks["normal_map"]["layer"]] == [0, 1]
    texels = np.frombuffer(base64.b64decode(found["maps"]["half"]), np.float16).reshape(2, 2, 2, 3)
    # Normals are stored as numbers, the colour is in sRGB: 128 there is 0.216 of white's light
    np.testing.assert_allclose(texels[1, 0, 0], [0.502, 0.502, 1], atol=HALF)
    np.testing.assert_allclose(texels[0, 0, 0], [0.2159, 0.2159, 1], atol=HALF)


# --- a saved page --------------------------------------------------------------------------------------


def data_of(text: str) -> dict[str, Any]:
    found = re.search(r'id="gonio-data">([^<]*)</script>', text)
    assert found
    return dict(json.loads(gzip.decompress(base64.b64decode(found[1]))))


def test_a_saved_page_is_small_and_asks_for_nothing() -> None:
    names = page.Names()
    text = page.saved(names, ["car_paint_red_strong"], pool(names, ["car_paint_red_strong"]))
    assert len(text.encode()) < 1_000_000
    markup = re.sub(r"<script.*?</script>", "", text, flags=re.S)
    assert not re.search(r'(src|href)="(?!data:)', markup)


def test_a_saved_page_may_hold_more_than_it_opens_with() -> None:
    names, held = page.Names(), ["eon", "lambert", "gold"]
    data = data_of(page.saved(names, held, opens=["gold"]))
    assert (data["show"], list(data["models"])) == (["gold"], held)
    assert data_of(page.saved(names, held))["show"] == held


def test_a_saved_page_has_the_exporters_text_for_every_choice() -> None:
    names = page.Names()
    data = data_of(page.saved(names, ["eon"], pool(names, ["eon"])))
    choices = [f.values for f in gonio.EON.fields.values() if isinstance(f, Option)]
    # One set is the model itself
    assert len(data["variants"]) == math.prod(map(len, choices)) - 1
    key = "eon|albedo_form=fitted,color_shift=none,sampler=ltc"
    numbers = data["variants"][key]["wgsl"]
    text = "\n\n".join(data["pool"]["wgsl"][i] for i in numbers)
    model = gonio.model("eon", albedo_form="fitted", color_shift="none", sampler="ltc")
    assert text == export({"model": model}, "wgsl")[0].source


# Its value is called with a formula, and its parameter has a range.
FOREIGN = """#ifdef GL_ES
precision mediump float;
#endif
#define PI 3.14159265
#ifdef WHITE
float lambert(float NdotL, float NdotV, float albedo2) { return NdotV > 0.0 ? albedo2 * NdotL / PI : 0.0; }
#endif
"""


def test_code_of_others_has_its_text_its_parameters_and_no_export(tmp_path: Path) -> None:
    path = tmp_path / "own.glsl"
    path.write_text(FOREIGN, encoding="utf-8")
    name = f"{path}#lambert"

    def read(text: str) -> foreign.Foreign:
        mapping, ranges = ["albedo2=rho^2"], ["rho=0.1..1"]
        return foreign.load(text, mapping=mapping, ranges=ranges, defines=["WHITE"])

    names = page.Names([name], read, ["WHITE"])
    made = page.payload(names, f"{name}:rho=0.25")
    (rho,) = made["parameters"]
    assert (rho["path"], rho["value"], rho["low"]) == ("rho", [0.25], 0.1)
    text = made["code"]["essl"]
    assert FOREIGN in text
    # The macro, the formula, the cosine that the code's value has, and an end of what is the code's own
    assert text.startswith("#define WHITE 1\n")
    assert "(gonio_m.p0 * gonio_m.p0)" in text
    assert "gonio_found / max(gonio_wi.z" in text
    assert text.endswith("precision highp float;\nprecision highp int;\n#undef WHITE\n#undef PI\n")
    with pytest.raises(server.Refused, match="stays in its own language"):
        server.code(names, name, "hlsl")
    saved = data_of(page.saved(names, [name], pool(names, [name])))
    assert saved["models"][name]["code"] == page.payload(names, name)["code"]


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["x.hlsl#f"], "no browser compiles"),
        (["x.glsl#f", "--sample", "g", "--pdf", "h"], "'gonio check' judges"),
        (["x.glsl#f", "--texture", "t=0.5"], "binds no textures"),
        (["eon", "--map", "a=wi"], "belong to a FILE of code"),
        (["missing.glsl#f"], "missing.glsl: No such file"),
    ],
)
def test_code_that_the_page_cannot_run_is_refused_in_one_line(
    arguments: list[str], says: str
) -> None:
    done = CliRunner().invoke(main, ["view", "--no-open", *arguments])
    assert done.exit_code != 0
    assert says in done.output.replace("\n", " ")


def test_nothing_in_a_model_can_end_the_pages_script(tmp_path: Path) -> None:
    path = tmp_path / "sly.toml"
    path.write_text(
        'model = "eon"\ndescription = "</script><script>alert(1)</script>"\n', encoding="utf-8"
    )
    text = page.saved(page.Names([str(path)]), [str(path)])
    assert "alert(1)" not in text
    assert data_of(text)["models"][str(path)]["description"].startswith("</script>")


def test_gonio_view_saves_a_page(tmp_path: Path) -> None:
    done = CliRunner().invoke(main, ["view", "lambert", "--save", str(tmp_path / "a.html")])
    assert done.exit_code == 0, done.output
    assert data_of((tmp_path / "a.html").read_text(encoding="utf-8"))["show"] == ["lambert"]
    wrong = CliRunner().invoke(main, ["view", "lambert", "--save", str(tmp_path / "a.png")])
    assert wrong.exit_code != 0
    assert list(tmp_path.iterdir()) == [tmp_path / "a.html"]


def test_a_saved_page_takes_names_that_are_no_utf8(tmp_path: Path) -> None:
    file = os.fsdecode(os.fsencode(tmp_path) + b"/x\xff.toml")
    Path(file).write_text('model = "lambert"\n')
    done = CliRunner().invoke(main, ["view", file, "--save", str(tmp_path / "a.html")])
    assert done.exit_code == 0, done.output
    (shown,) = data_of((tmp_path / "a.html").read_text(encoding="utf-8"))["show"]
    assert shown == f"{tmp_path}/x?.toml"


def test_the_built_script_is_current(tmp_path: Path) -> None:
    node = shutil.which("node")
    assert node, "node is missing: 'make test' installs it"
    assert (WEB / "node_modules/esbuild").is_dir(), "run 'npm ci' in gonio/view/web"
    subprocess.run([node, "build.mjs", str(tmp_path)], cwd=WEB, check=True)
    for name in page.FILES:
        built = (tmp_path / name).read_bytes()
        assert built == (WEB / name).read_bytes(), "run 'npm run build' there"
        told = re.search(rf"^\| `{name}` \| (\d+) \|", DOCUMENTED, re.M)
        assert told, f"docs/viewer.md does not list {name}"
        # Rounded to whole kB
        assert abs(len(built) / 1000 - int(told[1])) <= 0.5, f"docs/viewer.md: {name}"
    assert (WEB / page.SCRIPT).stat().st_size <= OPENING, "move what is rarely wanted to more.js"


def test_the_pages_source_is_formatted_and_has_nothing_that_a_linter_knows() -> None:
    node = shutil.which("node")
    assert node, "node is missing: 'make test' installs it"
    biome = WEB / "node_modules/@biomejs/biome/bin/biome"
    assert biome.is_file(), "run 'npm ci' in gonio/view/web"
    command = [node, str(biome), "ci", "--error-on-warnings"]
    done = subprocess.run(command, cwd=WEB, capture_output=True, text=True)
    assert done.returncode == 0, f"run 'npm run format' there:\n{done.stderr}"


def test_the_skys_picture_is_mitsubas() -> None:
    import make_view_sky

    fresh = make_view_sky.sky()
    with np.load(make_view_sky.OUTPUT) as file:
        # Half floats, and a little room for another Mitsuba
        np.testing.assert_allclose(file["picture"], fresh["picture"], atol=2e-3)
        np.testing.assert_allclose(file["sun"], fresh["sun"], rtol=1e-3)
