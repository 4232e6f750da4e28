"""MaterialX: its package reads the documents, generates shaders, and they compute what the models do."""

from __future__ import annotations

import importlib.util
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import MaterialX
import numpy as np
import pytest
from click.testing import CliRunner
from MaterialX import PyMaterialXGenOsl, PyMaterialXGenShader
from support import materialx as support
from support.materialx import FIS, PREFILTER, Job, Rows, generate, load, points, written
from support.tolerances import (
    DOUBLE_DIVIDED,
    SINGLE,
    SINGLE_LONG,
    SINGLE_PROMISED,
    single_promised,
)

import gonio
from gonio.check.variants import value_at
from gonio.cli import main
from gonio.export import ExportError, materialx
from gonio.export.entry import Member
from gonio.export.files import texts
from gonio.export.prove import tools
from gonio.export.prove.rows import rows_for, with_parameters
from gonio.materials import library, load_material
from gonio.model import Model

MODELS = list(gonio.models())

VIEW = (0.3, -0.2, 0.9)
LIGHT = (0.48, 0.36, 0.8)


def nested() -> Model:
    """A coat over an anisotropic metal: nested parameters, and a tangent that only the base needs."""
    base = gonio.model("torrance_sparrow", anisotropy=0.8, alpha=0.4)
    return gonio.model("weidlich_wilkie", base=base)


SUBJECTS: dict[str, Callable[[], Model]] = {
    **{name: (lambda name=name: gonio.model(name)) for name in MODELS},  # type: ignore[misc]
    "coated_metal": nested,
}


def uniforms(model: Model, name: str, weight: float = 1.0) -> dict[str, Any]:
    """Values of a shader's uniforms that are those of a model."""
    found: dict[str, Any] = {f"gonio_{name}_reflection_weight": weight}
    for path, declared, value in model.parameters():
        colour = value if isinstance(value, tuple) else (value,) * declared.width
        key = f"gonio_{name}_reflection_{path.replace('.', '_')}"
        found[key] = list(colour) if declared.width == 3 else value
    return found


def varied(model: Model, t: float) -> Model:
    """The model with other parameters, at places around t of their ranges."""
    values, k = {}, 0
    for path, declared, _ in model.parameters():
        near = [(t + 0.37 * (k + c)) % 1 * 0.8 + 0.1 for c in range(declared.width)]
        placed = tuple(float(np.float32(value_at(declared, x))) for x in near)
        values[path] = placed if declared.width == 3 else placed[0]
        k += declared.width
    return model.replace(**values)


# --- the document ------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", SUBJECTS)
def test_materialx_finds_the_document_valid(name: str, tmp_path: Path) -> None:
    document = written(tmp_path, name, SUBJECTS[name]())
    valid, message = document.validate()
    assert valid, message
    broken = (tmp_path / f"{name}.mtlx").read_text().replace('type="BSDF"/>', 'type="EDF"/>')
    (tmp_path / "broken.mtlx").write_text(broken)
    assert not load(tmp_path / "broken.mtlx").validate()[0]


@pytest.mark.parametrize("name", SUBJECTS)
def test_every_parameter_is_an_input_with_its_default_range_and_meaning(
    name: str, tmp_path: Path
) -> None:
    model = SUBJECTS[name]()
    definition = written(tmp_path, name, model).getNodeDef(f"ND_gonio_{name}_bsdf")
    assert definition.getNodeGroup() == "pbr"
    assert definition.getAttribute("bsdf") == "R"
    assert definition.getType() == "BSDF"
    inputs = {i.getName(): i for i in definition.getActiveInputs()}
    parameters = {path.replace(".", "_"): (path, d, v) for path, d, v in model.parameters()}
    assert next(iter(inputs)) == "weight"
    assert list(inputs)[1 : 1 + len(parameters)] == list(parameters)
    rest = list(inputs)[1 + len(parameters) :]
    turned = np.sqrt(0.5) * np.array([[1, 1, 0], [-1, 1, 0], [0, 0, np.sqrt(2)]])
    wi, wo = (np.array(w) / np.linalg.norm(w) for w in ([0.6, 0.2, 0.5], [-0.3, 0.4, 0.7]))
    # Widths along x and y move together when all parameters do; one of them alone makes the difference.
    along_x = {p: 0.5 * v for p, _, v in model.parameters() if p.endswith("_x")}
    same = all(
        np.allclose(m.eval(turned @ wi, turned @ wo), m.eval(wi, wo), rtol=DOUBLE_DIVIDED)
        for m in (model, varied(model, 0.3), model.replace(**along_x))
    )
    assert rest == (["normal"] if same else ["normal", "tangent"])
    for key, (path, declared, value) in parameters.items():
        found = inputs[key]
        assert found.getType() == ("color3" if declared.width == 3 else "float")

        def numbers(text: str) -> Any:
            return np.array([float(part) for part in text.split(",")])

        assert np.allclose(numbers(found.getValueString()), value, rtol=SINGLE)
        assert np.allclose(numbers(found.getAttribute("uimin")), declared.low, rtol=SINGLE)
        assert np.allclose(numbers(found.getAttribute("uimax")), declared.high, rtol=SINGLE)
        assert declared.doc.split(";")[0].split("·")[0][:12] in found.getDocString()
        assert (found.getAttribute("uifolder") == "Base") == path.startswith("base.")


def test_each_model_gets_files_of_its_own_that_no_other_language_writes() -> None:
    models = {name: gonio.model(name) for name in ("eon", "lambert")}
    mine = materialx.files(models)
    assert set(mine) == {
        "eon.mtlx",
        "gonio_eon_bsdf.glsl",
        "lambert.mtlx",
        "gonio_lambert_bsdf.glsl",
    }
    assert not set(mine) & set(texts(models, ["glsl", "essl"], together=False))
    assert all(text.isascii() for text in mine.values())


def test_all_models_fit_into_one_shader(tmp_path: Path) -> None:
    """No function of one model's file is called like one of another's."""
    document = MaterialX.createDocument()
    document.setDataLibrary(support.standard_libraries()[0])
    for name in MODELS:
        written(tmp_path, name)
        MaterialX.readFromXmlFile(document, str(tmp_path / f"{name}.mtlx"))
    last = f"gonio_{MODELS[0]}_reflection"
    for name in MODELS[1:]:
        node = document.addNode("mix", f"mix_{name}", "BSDF")
        node.addInput("fg", "BSDF").setNodeName(last)
        node.addInput("bg", "BSDF").setNodeName(f"gonio_{name}_reflection")
        node.addInput("mix", "float").setValue(0.5)
        last = node.getName()
    # MaterialX's own lobe includes the same declarations
    own = document.addNode("oren_nayar_diffuse_bsdf", "own", "BSDF")
    both = document.addNode("mix", "mix_own", "BSDF")
    both.addInput("fg", "BSDF").setNodeName(last)
    both.addInput("bg", "BSDF").setNodeName(own.getName())
    surface = document.addNode("surface", "all_surface", "surfaceshader")
    surface.addInput("bsdf", "BSDF").setNodeName(both.getName())
    material = document.addNode("surfacematerial", "all", "material")
    material.addInput("surfaceshader", "surfaceshader").setNodeName(surface.getName())
    assert document.validate()[0]
    compile_glsl(generate(document, "all", "glsl").pixel, tmp_path)


# --- compilers ---------------------------------------------------------------------------------------


def compile_glsl(text: str, folder: Path) -> None:
    (folder / "shader.frag").write_text(text, encoding="utf-8")
    validator = tools.program("glslangValidator", "compiles GLSL")
    done = subprocess.run(
        [validator, "shader.frag"], cwd=folder, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout


@pytest.mark.parametrize("environment", [FIS, PREFILTER])
@pytest.mark.parametrize("target", ["glsl", "essl"])
@pytest.mark.parametrize("name", SUBJECTS)
def test_generated_glsl_compiles(name: str, target: str, environment: Any, tmp_path: Path) -> None:
    document = written(tmp_path, name, SUBJECTS[name]())
    compile_glsl(generate(document, f"gonio_{name}", target, environment).pixel, tmp_path)


def test_a_shader_with_shadows_and_transparency_compiles(tmp_path: Path) -> None:
    """As the MaterialX Viewer generates it."""
    names = ("hwShadowMap", "hwTransparency", "hwAmbientOcclusion", "hwSrgbEncodeOutput")
    options = dict.fromkeys(names, True)
    shader = generate(written(tmp_path, "car_paint"), "gonio_car_paint", "glsl", FIS, **options)
    assert "mx_variance_shadow_occlusion" in shader.pixel
    compile_glsl(shader.pixel, tmp_path)


def test_a_shader_without_surroundings_does_not_compile(tmp_path: Path) -> None:
    """As docs/materialx.md says."""
    none = PyMaterialXGenShader.HwSpecularEnvironmentMethod.SPECULAR_ENVIRONMENT_NONE
    pixel = generate(written(tmp_path, "eon"), "gonio_eon", "glsl", none).pixel
    assert "u_envRadianceSamples" in pixel
    assert "uniform int u_envRadianceSamples" not in pixel
    with pytest.raises(AssertionError, match=": undeclared identifier"):
        compile_glsl(pixel, tmp_path)


@pytest.mark.parametrize("name", SUBJECTS)
def test_generated_slang_compiles_to_a_whole_shader(name: str, tmp_path: Path) -> None:
    document = written(tmp_path, name, SUBJECTS[name]())
    text = generate(document, f"gonio_{name}", "slang").pixel
    (tmp_path / "shader.slang").write_text(text, encoding="utf-8")
    slangc = tools.program("slangc", "compiles Slang")
    command_line = [slangc, "shader.slang", "-target", "metal", "-entry", "fragmentMain"]
    done = subprocess.run(
        [*command_line, "-stage", "fragment", "-o", "shader.metal"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr


def test_osl_has_no_implementation_because_it_takes_closures_only(tmp_path: Path) -> None:
    document = written(tmp_path, "eon")
    generator = PyMaterialXGenOsl.OslShaderGenerator.create()
    context = PyMaterialXGenShader.GenContext(generator)
    context.registerSourceCodeSearchPath(support.standard_libraries()[1])
    with pytest.raises(Exception, match="Could not find a matching implementation"):
        generator.generate("test", document.getNode("gonio_eon"), context)


# --- numbers, one light ------------------------------------------------------------------------------


def local(given: Any, view: Any, light: Any) -> tuple[Any, Any]:
    frame = support.frames(given, view)
    light = np.float64(np.float32(light))
    return frame.local(light / np.linalg.norm(light)), frame.wo


@pytest.mark.parametrize("target", ["glsl", "essl"])
@pytest.mark.parametrize("name", SUBJECTS)
def test_drawn_points_have_the_colours_of_the_model(name: str, target: str, tmp_path: Path) -> None:
    """The whole shader, as generated: vertices in, colours out, normals on all sides."""
    first = SUBJECTS[name]()
    shader = generate(written(tmp_path, name, first), f"gonio_{name}", target)
    models = [first, *(varied(first, t) for t in (0.1, 0.45, 0.8))]
    given, weight = points(), 0.625
    jobs = [Job(shader, VIEW, uniforms(m, name, weight), LIGHT, samples=1) for m in models]
    wi, wo = local(given, VIEW, LIGHT)
    for model, got in zip(models, support.drawn(tmp_path, given, jobs), strict=True):
        found = support.compare(
            lambda *_, model=model: model, wi, wo, got / weight, single_promised(model)
        )
        assert not len(found.wrong), (
            f"{len(found.wrong)} points, such as {found.wrong[:3]}; {model}"
        )
        if model is first:
            assert np.isfinite(found.error).mean() > 0.5
            assert np.nanquantile(found.error, 0.99) < SINGLE_PROMISED


@pytest.mark.parametrize("language", ["slang", "msl"])
@pytest.mark.parametrize("name", SUBJECTS)
def test_node_functions_in_slang_and_metal_reflect_as_the_model_does(
    name: str, language: str, tmp_path: Path
) -> None:
    """Slang by slangc and g++; Metal's text by g++ with the stand-in for Metal's library."""
    model = SUBJECTS[name]()
    document = written(tmp_path, name, model)
    shader = generate(document, f"gonio_{name}", language)
    definition = document.getNodeDef(f"ND_gonio_{name}_bsdf")
    members = tuple(Member(path, declared.width) for path, declared, _ in model.parameters())
    rng = np.random.default_rng(2)
    given, count = points(3), support.SIDE**2
    view = rng.normal(size=(count, 3))
    light = rng.normal(size=(count, 3))
    view, light = (w / np.linalg.norm(w, axis=1, keepdims=True) for w in (view, light))
    view, light = view.astype(np.float32), light.astype(np.float32)
    rows = rows_for(model, members, count, seed=4)
    usual = [c for _, d, v in model.parameters() for c in (v if d.width == 3 else (v,))]
    rows[::2, 8:] = np.float32(usual)
    weight = np.full((count, 1), 0.625, np.float32)
    inputs = np.concatenate([weight, rows[:, 8:]], 1)
    got = support.call(shader, definition, language, Rows(given, view, light, inputs), tmp_path)
    frame = support.frames_towards(given, view)
    wi = frame.local(light.astype(np.float64))
    wi = wi / np.linalg.norm(wi, axis=1, keepdims=True)
    found = support.compare(
        lambda dtype, chosen: with_parameters(model, members, rows[chosen], dtype),
        wi,
        frame.wo,
        got / 0.625,
        single_promised(model),
    )
    assert not len(found.wrong), f"{len(found.wrong)} rows, such as {found.wrong[:3]}"
    assert np.isfinite(found.error[::2]).mean() > 0.3
    assert np.nanquantile(found.error[::2], 0.99) < SINGLE_PROMISED


BREAKS = {
    "a frame of the other hand": ("flakes", "cross(N, T)", "cross(T, N)"),
    "tangent and bitangent swapped": (
        "brushed",
        "vec3(dot(L, T), dot(L, B)",
        "vec3(dot(L, B), dot(L, T)",
    ),
    "no cosine": ("eon", "cosine * closureData", "closureData"),
    "no weight": ("eon", "closureData.occlusion * weight", "closureData.occlusion"),
    "light and view swapped": ("classical", "_eval(params, wi, wo) *", "_eval(params, wo, wi) *"),
    "a normal that faces away": ("eon", "N = mx_forward_facing_normal(N, V);", ""),
    "a tangent that is not perpendicular": ("brushed", "X - dot(X, N) * N", "X"),
    "a constant that is off by 1e-4": ("eon", "C1 = 0.2877934;", "C1 = 0.28782;"),
}


@pytest.mark.parametrize("case", BREAKS)
def test_broken_code_has_other_colours(case: str, tmp_path: Path) -> None:
    kind, correct, wrong = BREAKS[case]
    settings: dict[str, dict[str, Any]] = {
        "flakes": {"flake_x": 0.1, "flake_y": 0.3},
        "brushed": {"anisotropy": 0.8},
        "classical": {"form": "classical"},  # not reciprocal
    }
    models = {"flakes": "car_paint", "brushed": "torrance_sparrow", "classical": "phong"}
    name = models.get(kind, kind)
    model = gonio.model(name, **settings.get(kind, {}))
    given = points()
    wi, wo = local(given, VIEW, LIGHT)

    def missed() -> int:
        shader = generate(load(tmp_path / f"{name}.mtlx"), f"gonio_{name}", "glsl")
        job = Job(shader, VIEW, uniforms(model, name, 0.625), LIGHT, samples=1)
        got = support.drawn(tmp_path, given, [job])[0] / 0.625
        return len(support.compare(lambda *_: model, wi, wo, got, SINGLE_PROMISED).wrong)

    written(tmp_path, name, model)
    assert missed() == 0
    source = tmp_path / f"gonio_{name}_bsdf.glsl"
    text = source.read_text()
    assert correct in text
    source.write_text(text.replace(correct, wrong))
    assert missed() > 100


# --- numbers, light from all sides -------------------------------------------------------------------


def radiance(w: Any) -> Any:
    """Light that comes from a direction of the world: no symmetry, and different for each colour."""
    x, y, z = np.moveaxis(np.asarray(w, np.float64), -1, 0)
    return np.stack([1 + 0.8 * x, 0.7 + 0.5 * y + 0.2 * z * z, np.exp(z - 0.5 * x)], -1)


def latlong(height: int) -> Any:
    """The radiance as MaterialX's picture of the surroundings: +y up, and -z at the left and right.

    The matrix that MaterialX gives to the surroundings turns them by 180 degrees about y.
    """
    latitude = (0.5 - (np.arange(height) + 0.5) / height) * np.pi
    longitude = ((np.arange(2 * height) + 0.5) / (2 * height) - 0.5) * 2 * np.pi
    latitude, longitude = np.meshgrid(latitude, longitude, indexing="ij")
    x, y = np.cos(latitude) * np.sin(longitude), np.sin(latitude)
    z = -np.cos(latitude) * np.cos(longitude)
    return radiance(np.stack([-x, y, -z], -1)).astype(np.float32)


def reflected_surroundings(model: Model, frame: Any, chosen: Any) -> Any:
    """The integral of BRDF, light and cosine over the hemisphere, by a rule that knows no samples."""
    rows, columns = 250, 500
    node, width = np.polynomial.legendre.leggauss(rows)
    sine = (node + 1) / 2  # of the angle from the normal: more points at the horizon
    phi = (np.arange(columns) + 0.5) / columns * 2 * np.pi
    mu = np.sqrt(1 - sine**2)
    wi = np.stack(
        [
            np.outer(sine, np.cos(phi)),
            np.outer(sine, np.sin(phi)),
            np.broadcast_to(mu[:, None], (rows, columns)),
        ],
        -1,
    ).reshape(-1, 3)
    # d mu = sine / mu d sine, and the cosine cancels mu
    measure = np.repeat(width / 2 * sine * 2 * np.pi / columns, columns)[:, None]
    found = []
    for k in chosen:
        value = np.asarray(model.eval(wi, frame.wo[k]), np.float64)
        found.append((value * radiance(wi @ frame.axes[k]) * measure).sum(0))
    return np.array(found)


SURROUNDED = {
    "lambert": {},
    "eon": {"roughness": 0.8},
    "torrance_sparrow": {"alpha": 0.35, "anisotropy": 0.7},
    "weidlich_wilkie": {"alpha": 0.3},
    "disney": {"roughness": 0.6, "clearcoat": 0.5, "clearcoat_gloss": 0.1},
}


@pytest.mark.parametrize("name", SURROUNDED)
def test_light_from_all_sides_is_the_integral_over_the_hemisphere(
    name: str, tmp_path: Path
) -> None:
    model = gonio.model(name, **SURROUNDED[name])
    shader = generate(written(tmp_path, name, model), f"gonio_{name}", "glsl")
    given = points(5)
    frame = support.frames(given, VIEW)
    chosen = np.nonzero(frame.wo[:, 2] > 0.1)[0][:8]
    job = Job(shader, VIEW, uniforms(model, name, 0.625), environment=latlong(256), samples=4096)
    got = support.drawn(tmp_path, given[chosen], [job])[0] / 0.625
    expected = reflected_surroundings(model, frame, chosen)
    # 4096 samples of a lattice; what they miss is about 1 / 4096 of the range of the weights
    assert np.allclose(got, expected, rtol=5e-3)
    source = tmp_path / f"gonio_{name}_bsdf.glsl"
    source.write_text(source.read_text().replace("wi.z * N", "wi.z * T"))
    broken = generate(load(tmp_path / f"{name}.mtlx"), f"gonio_{name}", "glsl")
    job = Job(broken, VIEW, job.uniforms, environment=latlong(256), samples=4096)
    other = support.drawn(tmp_path, given[chosen], [job])[0] / 0.625
    # The fault is outside of the same tolerance
    assert not np.allclose(other, expected, rtol=5e-3)


def test_blurred_looks_at_the_surroundings_make_few_samples_do(tmp_path: Path) -> None:
    """The smaller versions of the picture stand for the directions between the samples."""
    name, model = "torrance_sparrow", gonio.model("torrance_sparrow", alpha=0.35)
    shader = generate(written(tmp_path, name, model), f"gonio_{name}", "glsl")
    given = points(7)[:1024]
    rng = np.random.default_rng(8)
    lamps = (latlong(128) + 40 * (rng.random((128, 256, 1)) < 0.02)).astype(np.float32)
    settings: list[dict[str, Any]] = [
        {"samples": 4096},
        {"samples": 16},
        {"samples": 16, "blurred": True},
    ]
    values = uniforms(model, name)
    jobs = [Job(shader, VIEW, values, environment=lamps, **more) for more in settings]
    exact, sharp, blurred = support.drawn(tmp_path, given, jobs)
    assert np.median(np.abs(blurred - exact)) < 0.4 * np.median(np.abs(sharp - exact))


def mean_weight(model: Model, wo: Any, count: int) -> Any:
    """The mean of BRDF times cosine over density, for the random numbers that MaterialX uses."""
    total = np.zeros_like(wo)
    for i in range(count):
        u = np.array([(i + 0.5) / count, (i + 1) * (1 + np.sqrt(5)) / 2 % 1])
        drawn = model.sample(wo, np.broadcast_to(u, (len(wo), 2)))
        usable = drawn.pdf > 0
        weight = np.where(usable, drawn.wi[:, 2] / np.where(usable, drawn.pdf, 1), 0)
        total += np.asarray(model.eval(drawn.wi, wo)) * weight[:, None]
    return total / count


def any_tangents(normal: Any) -> Any:
    """Duff et al. 2017, listing 3: the tangents of isotropic models, whose samples depend on them."""
    x, y, z = normal.T
    sign = np.copysign(1, z)
    a = -1 / (sign + z)
    return np.stack([1 + sign * x * x * a, sign * x * y * a, -sign * x], 1)


def share_near(got: Any, expected: Any) -> float:
    """How many points agree; a few may not, whose random number is at a threshold of the sampler."""
    return float((np.abs(got - expected) <= 1e-3 * np.abs(expected) + 1e-5).all(-1).mean())


@pytest.mark.parametrize("target", ["glsl", "essl"])
@pytest.mark.parametrize("name", SUBJECTS)
def test_white_surroundings_show_the_mean_weight_of_the_models_own_samples(
    name: str, target: str, tmp_path: Path
) -> None:
    """With 16 samples, which is MaterialX's default; the mean weight is near the albedo."""
    model = SUBJECTS[name]()
    shader = generate(written(tmp_path, name, model), f"gonio_{name}", target)
    given = points(6)[:1024]
    white = np.ones((4, 8, 3), np.float32)
    job = Job(shader, VIEW, uniforms(model, name), environment=white, samples=16)
    got = support.drawn(tmp_path, given, [job])[0]
    if "vec3 X" not in (tmp_path / f"gonio_{name}_bsdf.glsl").read_text():
        given = np.concatenate(
            [given[:, :6], any_tangents(support.frames(given, VIEW).axes[:, 2])], 1
        )
    wo = support.frames(given, VIEW).wo
    assert share_near(got, mean_weight(model, wo, 16)) > 0.97
    # The standard error of 16 samples, of weights that differ by a sixth of the albedo
    assert np.median(np.abs(got - np.asarray(model.albedo(wo)))) < 0.04
    assert share_near(got, mean_weight(model.replace(**darker(model)), wo, 16)) < 0.5


def darker(model: Model) -> dict[str, Any]:
    """Another value for one parameter that changes the colour."""
    path, declared, value = next(p for p in model.parameters() if p[0] in DARKER)
    return {path: 0.9 * value if declared.width == 1 else tuple(0.9 * v for v in value)}


DARKER = ("rho", "base_color", "metal_k", "k", "base.rho", "base.k", "first_weight", "f0")


# --- what users do wrong -----------------------------------------------------------------------------


def test_values_out_of_range_count_as_the_end_of_the_range(tmp_path: Path) -> None:
    name, model = "torrance_sparrow", gonio.model("torrance_sparrow", alpha=1, f0=0, anisotropy=0)
    shader = generate(written(tmp_path, name, model), f"gonio_{name}", "glsl")
    given = points()
    inside = uniforms(model, name)
    outside = inside | {
        f"gonio_{name}_reflection_alpha": 7.0,
        f"gonio_{name}_reflection_anisotropy": -3.0,
        f"gonio_{name}_reflection_f0": [-1.0, -0.5, -9.0],
    }
    jobs = [Job(shader, VIEW, values, LIGHT, samples=1) for values in (inside, outside)]
    first, second = support.drawn(tmp_path, given, jobs)
    assert np.array_equal(first, second)
    assert first.max() > 0


def test_a_mesh_without_tangents_is_still_lit(tmp_path: Path) -> None:
    """Without anisotropy every tangent is right; MaterialX passes NaN for a tangent of length 0."""
    name, model = "torrance_sparrow", gonio.model("torrance_sparrow", anisotropy=0)
    shader = generate(written(tmp_path, name, model), f"gonio_{name}", "glsl")
    given = points()
    bare = given.copy()
    bare[:, 6:] = 0
    along = given.copy()
    along[:, 6:] = along[:, 3:6]
    job = Job(shader, VIEW, uniforms(model, name), LIGHT, samples=1)
    usual = support.drawn(tmp_path, given, [job])[0]
    for other in (bare, along):
        # Another tangent turns the same samples: what 1 sample a point keeps in single precision
        assert np.allclose(support.drawn(tmp_path, other, [job])[0], usual, rtol=1e-3, atol=SINGLE)


def own_model(folder: Path, fields: str, body: str) -> Model:
    """A user's model, from a file."""
    path = folder / "own.py"
    path.write_text(
        '"""Own: a model from a user."""\n\n'
        "from gonio.lang import *\n"
        "from gonio.lang import Color, Float, Sample, Vec2, Vec3\n"
        "from gonio.model import Model, param\n"
        "from gonio.parts.hemisphere import pdf_cosine, sample_cosine\n\n\n"
        "class Own(Model, register=False):\n"
        '    """Own."""\n\n'
        '    rho: Color = param((0.8, 0.3, 0.5), 0, 1, "albedo < 1, \\"linear\\" & plain")\n'
        f"{fields}\n\n"
        "    def eval(self, wi: Vec3, wo: Vec3) -> Color:\n"
        f"{body}\n\n"
        "    def sample(self, wo: Vec3, u: Vec2) -> Sample:\n"
        "        wi = sample_cosine(u)\n"
        "        return Sample(wi, pdf_cosine(wi))\n\n"
        "    def pdf(self, wi: Vec3, wo: Vec3) -> Float:\n"
        "        return pdf_cosine(wi)\n",
        encoding="utf-8",
    )
    name = f"own_{folder.name}"
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    made = module.Own()
    assert isinstance(made, Model)
    return made


COMPARISONS = """\
        a = select(self.rho < 0.5, self.rho, self.mix)
        b = select(self.rho <= self.mix, a * 0.5, a)
        c = select(b > self.T, b, 0.25 * b)
        d = select(c >= 0.5, c, 2 * c)
        e = select(d == 0.1, 1, d)
        return INV_PI * self.dot * select(self.rho != self.mix, e, 0.5 * e)"""


@pytest.mark.parametrize("language", ["slang", "msl"])
def test_a_users_model_may_use_words_of_the_other_languages_and_compare_colours(
    language: str, tmp_path: Path
) -> None:
    fields = (
        '    mix: Color = param((0.4, 0.3, 0.9), 0, 1, "a colour")\n'
        '    T: Float = param(0.3, 0, 1, "a number")\n'
        '    dot: Float = param(1, 0, 1, "a number")\n'
        '    far: Float = param(5, 1, float("inf"), "a number without an upper end")'
    )
    model = own_model(tmp_path, fields, COMPARISONS)
    document = written(tmp_path, "own", model)
    assert document.validate()[0]
    definition = document.getNodeDef("ND_gonio_own_bsdf")
    unbounded = definition.getInput("far")
    assert not unbounded.hasAttribute("uimax")
    assert float(unbounded.getAttribute("uisoftmax")) == 50
    assert definition.getInput("rho").getDocString().startswith('albedo < 1, "linear" & plain')
    given = points()
    view = light = np.float32(given[:, 3:6])
    values = np.float32([0.625, 0.8, 0.3, 0.5, 0.4, 0.3, 0.9, 0.3, 1, 5])
    rows = Rows(given, view, light, np.tile(values, (len(given), 1)))
    shader = generate(document, "gonio_own", language)
    got = support.call(shader, definition, language, rows, tmp_path)
    up = np.array([[0.0, 0.0, 1.0]])
    assert np.allclose(got / 0.625, model.eval(up, up), rtol=SINGLE_LONG)
    job = Job(generate(document, "gonio_own", "glsl"), (0, 0, 9), light=(0, 0, 1), samples=1)
    upright = given.copy()
    upright[:, 3:6] = 0, 0, 1
    drawn = support.drawn(tmp_path, upright, [job])[0]
    assert np.allclose(drawn, model.eval(up, up), rtol=SINGLE_LONG)


def test_the_examples_of_the_documentation_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    text = (Path(__file__).parents[1] / "docs" / "materialx.md").read_text(encoding="utf-8")
    written(tmp_path, "eon")
    monkeypatch.chdir(tmp_path)
    exec(re.findall(r"```python\n(.*?)```", text, re.DOTALL)[0], {})
    printed = capsys.readouterr().out
    assert "void gonio_eon_bsdf(" in printed
    compile_glsl(printed, tmp_path)
    xml = re.findall(r"```xml\n(.*?)```", text, re.DOTALL)[0]
    head = '<materialx version="1.39" xmlns:xi="http://www.w3.org/2001/XInclude">'
    (tmp_path / "clay.mtlx").write_text(f"{head}\n{xml}</materialx>\n", encoding="utf-8")
    document = load(tmp_path / "clay.mtlx")
    assert document.validate()[0]
    surface = document.addNode("surface", "clay_surface", "surfaceshader")
    surface.addInput("bsdf", "BSDF").setNodeName("clay")
    material = document.addNode("surfacematerial", "clay_material", "material")
    material.addInput("surfaceshader", "surfaceshader").setNodeName("clay_surface")
    shader = generate(document, "clay_material", "glsl")
    assert shader.uniforms["clay_roughness"] == np.float32(0.9)
    compile_glsl(shader.pixel, tmp_path)


def test_a_parameter_that_a_node_has_itself_is_refused(tmp_path: Path) -> None:
    field = '    weight: Float = param(0.3, 0, 1, "a number")'
    model = own_model(tmp_path, field, "        return self.rho * self.weight")
    with pytest.raises(ExportError, match=r"own: .*'weight'; rename weight"):
        materialx.files({"own": model})


def test_a_picture_for_a_parameter_is_refused() -> None:
    with pytest.raises(ExportError, match="roughness is an array; give it one value"):
        materialx.files({"eon": gonio.model("eon", roughness=np.linspace(0, 1, 4))})


def test_the_command_writes_documents_that_materialx_reads(tmp_path: Path) -> None:
    arguments = ["export", "eon", "rough_gold", "--to", "mtlx", "-o", f"{tmp_path}/"]
    result = CliRunner().invoke(main, arguments)
    assert result.exit_code == 0, result.output
    for name in ("eon", "rough_gold"):
        document = load(tmp_path / f"{name}.mtlx")
        assert document.validate()[0]
        compile_glsl(generate(document, f"gonio_{name}", "glsl").pixel, tmp_path)
    gold = load_material("rough_gold").model
    lobe = document.getNode("gonio_rough_gold_reflection")
    for path, _, value in gold.parameters():
        text = lobe.getInput(path.replace(".", "_")).getValueString()
        assert np.allclose([float(part) for part in text.split(",")], value, rtol=SINGLE)


def test_every_ready_material_becomes_a_valid_document_that_compiles(tmp_path: Path) -> None:
    for name in library():
        document = written(tmp_path, name, load_material(name).model)
        valid, message = document.validate()
        assert valid, f"{name}: {message}"
        compile_glsl(generate(document, f"gonio_{name}", "glsl").pixel, tmp_path)
