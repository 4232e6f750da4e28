"""MaterialX as another program: it reads exported documents and generates shaders, which run here."""

from __future__ import annotations

import ctypes
import json
import re
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import MaterialX
import numpy as np
from MaterialX import (
    PyMaterialXGenGlsl,
    PyMaterialXGenMsl,
    PyMaterialXGenShader,
    PyMaterialXGenSlang,
)
from numpy.typing import NDArray

import gonio
from gonio.export import materialx
from gonio.export.prove import tools
from gonio.export.prove.judge import LLVMPIPE
from gonio.export.prove.native import FLAGS, METAL_FLAGS
from gonio.model import Model

Array = NDArray[Any]

GENERATORS = {
    "glsl": PyMaterialXGenGlsl.GlslShaderGenerator,
    "essl": PyMaterialXGenGlsl.EsslShaderGenerator,
    "msl": PyMaterialXGenMsl.MslShaderGenerator,
    "slang": PyMaterialXGenSlang.SlangShaderGenerator,
}
FIS = PyMaterialXGenShader.HwSpecularEnvironmentMethod.SPECULAR_ENVIRONMENT_FIS
PREFILTER = PyMaterialXGenShader.HwSpecularEnvironmentMethod.SPECULAR_ENVIRONMENT_PREFILTER

FLUSHED = 2 * float(np.finfo(np.float32).tiny)  # for a light of half the brightness

SIDE = 64  # of the square of pixels that the worker draws


@cache
def standard_libraries() -> tuple[Any, Any]:
    """The document with MaterialX's own nodes, and where their code is found."""
    document, path = MaterialX.createDocument(), MaterialX.getDefaultDataSearchPath()
    MaterialX.loadLibraries(MaterialX.getDefaultDataLibraryFolders(), path, document)
    return document, path


def load(path: Path) -> Any:
    """A document from a file, with the standard libraries."""
    document = MaterialX.createDocument()
    document.setDataLibrary(standard_libraries()[0])
    MaterialX.readFromXmlFile(document, str(path))
    return document


def written(folder: Path, name: str, model: Model | None = None) -> Any:
    """Export a model into a folder and load the document."""
    for file, text in materialx.files({name: model or gonio.model(name)}).items():
        (folder / file).write_text(text, encoding="utf-8")
    return load(folder / f"{name}.mtlx")


@dataclass(frozen=True)
class Shader:
    """What MaterialX generated for a material."""

    vertex: str
    pixel: str
    uniforms: dict[str, Any]
    """Values that MaterialX gives to the inputs of nodes, by name."""


def generate(
    document: Any, element: str, target: str, environment: Any = FIS, **options: Any
) -> Shader:
    """The shader of a material, for one directional light; options are those of MaterialX."""
    generator = GENERATORS[target].create()
    context = PyMaterialXGenShader.GenContext(generator)
    context.registerSourceCodeSearchPath(standard_libraries()[1])
    chosen = {"hwMaxActiveLightSources": 1, "hwSpecularEnvironmentMethod": environment}
    for option, value in (chosen | options).items():
        setattr(context.getOptions(), option, value)
    light = standard_libraries()[0].getNodeDef("ND_directional_light")
    PyMaterialXGenShader.HwShaderGenerator.bindLightShader(light, 1, context)
    shader = generator.generate("test", document.getNode(element), context)
    stage = shader.getStage("pixel")
    uniforms: dict[str, Any] = {}
    for port in stage.getUniformBlock("PublicUniforms"):
        if port.getType().getName() in ("float", "color3"):
            value = port.getValue().getData()
            uniforms[port.getVariable()] = (
                value if isinstance(value, float) else list(value.asTuple())
            )
    return Shader(shader.getSourceCode("vertex"), stage.getSourceCode(), uniforms)


# --- what a shader should compute --------------------------------------------------------------------

# A direction that goes through a frame in float32 comes out wrong by up to this in each component: three
# products and two sums, each rounded, of numbers up to 1 (2.5 units of 6e-8), and the frame is no better.
TURNED = 3e-7

# How many times the model's own float32 rounding counts: what gonio.export.prove allows this device.
ROUNDINGS = LLVMPIPE.factor


# How many rows may get a closer look, and how many tries each of them then has: where a value changes fast,
# few tries do not find its largest change.
CLOSE_LOOKS, TRIES, CLOSER = 40, 8, 256

# Errors are relative to a channel, or to this share of the row's brightest one: of a mixture of a bright
# and a dark part, float32 keeps no more of the dark one.
DARKEST = 5e-3

Maker = Callable[[Any, Any], Model]
"""The model in a precision, np.float32 or np.float64, for some rows."""


def reflected(model: Model, dtype: Any, wi: Array, wo: Array) -> Array:
    """BRDF times cosine for local directions, computed in a precision."""
    value = model.eval(_unit(wi).astype(dtype), _unit(wo).astype(dtype))
    return np.asarray(value, np.float64) * np.maximum(wi[:, 2:], 0)


def _rounding(model: Maker, rows: Array, wi: Array, wo: Array, tries: int) -> Array:
    """By how much rounding may change the rows: that of directions, and that inside the model."""
    wi, wo = wi[rows], wo[rows]
    exact, rng = model(np.float64, rows), np.random.default_rng(1)
    value = reflected(exact, np.float64, wi, wo)
    spread = np.zeros_like(value)
    for _ in range(tries):
        off_i, off_o = rng.uniform(-TURNED, TURNED, (2, *wi.shape))
        around = reflected(exact, np.float64, wi + off_i, wo + off_o)
        spread = np.maximum(spread, np.abs(around - value))
    own = np.abs(reflected(model(np.float32, rows), np.float32, wi, wo) - value)
    return np.asarray(4 * spread + ROUNDINGS * own)


@dataclass(frozen=True)
class Comparison:
    """Colours beside what the float64 model reflects."""

    wrong: Array
    """Numbers of the rows that differ by more than a relative error and rounding; NaN differs."""
    error: Array
    """Relative errors of the lit rows and channels; NaN elsewhere."""


def compare(model: Maker, wi: Array, wo: Array, got: Array, relative: float) -> Comparison:
    """Compare reflected light, of one light of radiance 1, with the model."""
    every = np.arange(len(wi))
    value = reflected(model(np.float64, every), np.float64, wi, wo)
    off = np.abs(got - value)
    size = np.maximum(np.abs(value), DARKEST * np.abs(value).max(-1, keepdims=True))
    # What is below the smallest normal number may be 0 in a shader
    limit = relative * size + FLUSHED + _rounding(model, every, wi, wo, TRIES)
    wrong = np.nonzero(~(off <= limit).all(-1))[0]
    if 0 < len(wrong) <= CLOSE_LOOKS:
        closer = relative * size[wrong] + _rounding(model, wrong, wi, wo, CLOSER)
        wrong = wrong[~(off[wrong] <= np.maximum(limit[wrong], closer)).all(-1)]
    lit = value > 0
    return Comparison(wrong, np.where(lit, off / np.where(lit, value, 1), np.nan))


# --- points that a shader draws ----------------------------------------------------------------------


def points(seed: int = 0) -> Array:
    """Position, normal and tangent of one point per pixel, float32: normals of all directions.

    A point's position is its place on the screen, because all matrices are the identity.
    """
    rng = np.random.default_rng(seed)
    axis = (np.arange(SIDE) + 0.5) / SIDE * 2 - 1
    x, y = np.meshgrid(axis, axis)
    position = np.stack([x.ravel(), y.ravel(), np.zeros(SIDE * SIDE)], 1)
    normal, tangent = _unit(rng.normal(size=(SIDE * SIDE, 3))), rng.normal(size=(SIDE * SIDE, 3))
    return np.concatenate([position, normal, _unit(tangent)], 1).astype(np.float32)


def _unit(v: Array) -> Array:
    return np.asarray(v / np.linalg.norm(v, axis=-1, keepdims=True))


@dataclass(frozen=True)
class Frame:
    """The local frames of points as MaterialX's specification makes them, in float64."""

    axes: Array
    """Tangent, bitangent and normal, shape (..., 3, 3)."""
    wo: Array

    def local(self, w: Any) -> Array:
        """World directions in the local frames."""
        return np.einsum("nij,nj->ni", self.axes, np.broadcast_to(w, self.wo.shape))


def frames(given: Array, view: Sequence[float]) -> Frame:
    """The frames at points, seen from the place `view`."""
    return frames_towards(given, np.float64(np.float32(view)) - given[:, :3])


def frames_towards(given: Array, towards: Array) -> Frame:
    """The frames at points, with directions to the viewer; the normal is on the viewer's side."""
    _, normal, tangent = np.split(given.astype(np.float64), 3, axis=1)
    towards, normal, tangent = _unit(towards.astype(np.float64)), _unit(normal), _unit(tangent)
    normal = np.where((normal * towards).sum(1, keepdims=True) < 0, -normal, normal)
    tangent = _unit(tangent - (tangent * normal).sum(1, keepdims=True) * normal)
    axes = np.stack([tangent, np.cross(normal, tangent), normal], 1)
    return Frame(axes, np.einsum("nij,nj->ni", axes, towards))


@dataclass(frozen=True)
class Job:
    """A drawing: what differs from its shader's defaults, and the surroundings, black if not given."""

    shader: Shader
    view: Sequence[float]
    uniforms: dict[str, Any] = field(default_factory=dict)
    light: Sequence[float] | None = None
    """Direction towards the one light."""
    environment: Array | None = None
    """Radiance, latitude by longitude, float32 RGB."""
    samples: int = 16
    blurred: bool = False
    """Whether the picture of the surroundings has smaller versions of itself."""

    @property
    def levels(self) -> int:
        """How many versions there are."""
        if self.environment is None or not self.blurred:
            return 1
        return int(np.log2(max(self.environment.shape))) + 1


def drawn(folder: Path, given: Array, jobs: Sequence[Job]) -> list[Array]:
    """The colours of the points in each drawing, by OpenGL in a process of its own."""
    np.save(folder / "points.npy", given)
    np.save(folder / "black.npy", np.zeros((2, 4, 4), np.float32))
    listing, shaders = [], {}
    identity = np.eye(4).ravel().tolist()
    for number, job in enumerate(jobs):
        shader = shaders.setdefault(id(job.shader), f"shader{len(shaders)}")
        (folder / f"{shader}.vert").write_text(job.shader.vertex, encoding="utf-8")
        (folder / f"{shader}.frag").write_text(job.shader.pixel, encoding="utf-8")
        picture = "black.npy"
        if job.environment is not None:
            picture = f"environment{number}.npy"
            alpha = np.ones((*job.environment.shape[:2], 1), np.float32)
            np.save(folder / picture, np.concatenate([job.environment, alpha], 2))
        uniforms = job.shader.uniforms | job.uniforms
        uniforms |= dict.fromkeys(
            ("u_worldMatrix", "u_viewProjectionMatrix", "u_worldInverseTransposeMatrix"), identity
        )
        uniforms |= {
            "u_viewPosition": list(job.view),
            "u_numActiveLightSources": int(job.light is not None),
            "u_lightData[0].type": 1,
            "u_lightData[0].direction": [-c for c in job.light or (0, 0, 1)],
            "u_lightData[0].color": [1, 1, 1],
            "u_lightData[0].intensity": 1,
            "u_envMatrix": np.diag([-1.0, 1.0, -1.0, 1.0]).ravel().tolist(),
            "u_envLightIntensity": 1.0,
            "u_envRadianceMips": job.levels,
            "u_envRadianceSamples": job.samples,
        }
        facts = {"name": str(number), "shader": shader, "uniforms": uniforms}
        listing.append(facts | {"environment": picture, "blurred": job.blurred})
    (folder / "jobs.json").write_text(json.dumps(listing), encoding="utf-8")
    worker = Path(__file__).with_name("materialx_worker.py")
    done = subprocess.run(
        [sys.executable, "-P", str(worker), str(folder)],
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode != 0:
        raise RuntimeError(done.stderr)
    return [np.load(folder / f"{number}.out.npy") for number in range(len(jobs))]


# --- the node's function alone, for Slang and Metal --------------------------------------------------


@dataclass(frozen=True)
class Rows:
    """Calls of a node's function: directions and vectors in the world, and values of its inputs."""

    points: Array
    view: Array
    light: Array
    inputs: Array
    """Columns in the order of the inputs, weight first; colours take three."""


def call(shader: Shader, definition: Any, language: str, rows: Rows, folder: Path) -> Array:
    """The response to the light of every row, computed by what MaterialX made of our code."""
    normal, tangent = rows.points[:, 3:6], rows.points[:, 6:9]
    columns = np.concatenate([rows.light, rows.view, normal, tangent, rows.inputs], 1)
    columns = np.ascontiguousarray(columns, np.float32)
    body = _loop(definition, columns.shape[1])
    # A name of its own: a loaded library stays, and one with the same path would be taken for it
    library = f"{definition.getNodeString()}_{language}.so"
    if language == "slang":
        functions = shader.pixel[: shader.pixel.index('[shader("fragment")]')]
        text = f"{functions}\nexport __extern_cpp void run(float* x, float* y, int rows) {{\n{body}}}\n"
        (folder / "node.slang").write_text(text, encoding="utf-8")
        slangc = tools.program("slangc", "compiles Slang")
        _run([slangc, "node.slang", "-target", "cpp", "-o", "node.cpp"], folder)
        flags = ["-w"]
    else:
        head = 'extern "C" void run(const float* x, float* y, int rows) {'
        text = f"{_metal(shader.pixel)}\n{head}\n{body}}}\n"
        (folder / "node.cpp").write_text(text, encoding="utf-8")
        flags = [*METAL_FLAGS, "-Wall", "-Wextra", "-Werror", "-Wno-unused"]
    _run(["g++", *FLAGS, *flags, "node.cpp", "-o", library], folder)
    response = np.full((len(columns), 3), np.nan, np.float32)
    function = ctypes.CDLL(str(folder / library)).run
    pointer = ctypes.POINTER(ctypes.c_float)
    function.argtypes, function.restype = [pointer, pointer, ctypes.c_int], None
    function(columns.ctypes.data_as(pointer), response.ctypes.data_as(pointer), len(columns))
    return response


def _run(command: Sequence[str], folder: Path) -> None:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"{command[0]}: {done.stdout[-2000:]}{done.stderr[-2000:]}")


def _loop(definition: Any, columns: int) -> str:
    """Statements, in Slang and Metal alike, that call a node's function for every row."""

    def vector(start: int) -> str:
        return f"float3(x[i + {start}], x[i + {start + 1}], x[i + {start + 2}])"

    arguments, column = [], 12
    for given in definition.getActiveInputs():
        if given.getName() in ("normal", "tangent"):
            arguments.append(vector(6 if given.getName() == "normal" else 9))
        elif given.getType() == "color3":
            arguments.append(vector(column))
            column += 3
        else:
            arguments.append(f"x[i + {column}]")
            column += 1
    assert column == columns
    return f"""\
    for (int row = 0; row < rows; ++row) {{
        int i = row * {columns};
        ClosureData closureData;
        closureData.closureType = CLOSURE_TYPE_REFLECTION;
        closureData.L = {vector(0)};
        closureData.V = {vector(3)};
        closureData.N = {vector(6)};
        closureData.P = float3(0.0);
        closureData.occlusion = 1.0;
        BSDF bsdf;
        bsdf.response = float3(0.0);
        bsdf.throughput = float3(1.0);
        {definition.getNodeString()}(closureData, {", ".join(arguments)}, bsdf);
        y[row * 3] = bsdf.response.x;
        y[row * 3 + 1] = bsdf.response.y;
        y[row * 3 + 2] = bsdf.response.z;
    }}
"""


# What the node's code uses of MaterialX's. The rest of a Metal shader needs Metal's textures and
# matrices, which the stand-in for Metal's library does not have: one picture is a number here.
USED = ("mx_forward_facing_normal", "mx_golden_ratio_sequence", "mx_spherical_fibonacci")
METAL_HEAD = """\
#include <metal_stdlib>
using namespace metal;
#define M_FLOAT_EPS 1e-8
#define bool3(x, y, z) bool3{x, y, z}
struct BSDF { float3 response; float3 throughput; };
const float u_envMatrix = 0.0, u_envRadiance = 0.0, u_envLightIntensity = 1.0;
const int u_envRadianceMips = 1, u_envRadianceSamples = 16;
float mx_latlong_compute_lod(float3, float, float, int) { return 0.0; }
float3 mx_latlong_map_lookup(float3, float, float, float) { return float3(0.0); }
"""


def _metal(shader: str) -> str:
    """The part of a Metal shader that came from our file, with what it uses."""
    start, end = (
        shader.index("#define CLOSURE_TYPE_DEFAULT"),
        shader.index("PixelOutputs FragmentMain()"),
    )
    functions = [
        re.search(rf"^ *\w+ {name}\([^\n]*\n *{{.*?^    }}$", shader, re.MULTILINE | re.DOTALL)[0]
        for name in USED
    ]
    return "\n".join([METAL_HEAD, *functions, shader[start:end]])
