"""Runs OSL shaders in Blender's renderer Cycles: `python -P _cycles_worker.py FOLDER`, its own process.

Every row is a quad per three outputs, each of which fills one pixel of a picture without light. The inputs
are attributes of the quad, linked to the shader's parameters; a second shader makes the outputs shine.
Job k is the shader k.osl with the rows k.npy, as listed in jobs.json with the names and widths of its
parameters and outputs. Results go to k.out.npy, the compiler's complaints to k.error, and the name of the
device to device.
"""

import contextlib
import json
import os
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import numpy.typing as npt

sys.path.append(
    f"{bpy.utils.resource_path('LOCAL')}/python/lib/python3.{sys.version_info[1]}/site-packages"
)
sys.path.append(f"{bpy.utils.resource_path('LOCAL')}/scripts/addons_core")

import _cycles
import OpenImageIO
from cycles import osl

Rows = npt.NDArray[np.float32]
Named = Sequence[tuple[str, int]]
"""Names and widths of parameters or outputs."""

WIDTH = 512  # pixels in a line of the picture
LEAST_HEIGHT = 4  # of a picture in Blender

# Light of this colour stands for numbers that are not finite, which Cycles would make 0.
NOT_FINITE = -12345.0

# Emits one of the vectors given, as light. Numbers come together as vectors.
COLLECT = f"""shader collect(
    vector given0 = 0.0,
    vector given1 = 0.0,
    vector given2 = 0.0,
    vector given3 = 0.0,
    float part = 0.0,
    output color shown = 0.0)
{{
    vector given = part < 0.5 ? given0 : part < 1.5 ? given1 : part < 2.5 ? given2 : given3;
    for (int k = 0; k < 3; ++k)
        shown[k] = isfinite(given[k]) ? given[k] : {NOT_FINITE};
}}
"""


def main(folder: Path) -> None:
    """Run all jobs of the folder in one picture."""
    version = ".".join(map(str, bpy.app.version))
    language = ".".join(map(str, _cycles.osl_version))
    text = f"Cycles {version}, OSL {language}, processor"
    (folder / "device").write_text(text, encoding="utf-8")
    (folder / "collect.osl").write_text(COLLECT, encoding="utf-8")
    _cycles.osl_compile(str(folder / "collect.osl"), str(folder / "collect.oso"))
    scene = prepare()
    start, placed = 0, []
    for job in json.loads((folder / "jobs.json").read_text(encoding="utf-8")):
        path = folder / job["file"]
        compiled = path.with_suffix(".oso")
        with caught(folder / "messages") as messages:
            done = _cycles.osl_compile(str(path), str(compiled))
        if not done:
            (folder / f"{job['number']}.error").write_text(messages.read_text(), encoding="utf-8")
            continue
        rows = np.load(folder / f"{job['number']}.npy")
        parts = len(groups(job["outputs"]))
        place(
            scene, job["inputs"], np.tile(rows, (parts, 1)), parts, start, material(job, compiled)
        )
        placed.append((job, start, parts, len(rows)))
        start += parts * len(rows)
    if not placed:
        return
    light = render(scene, start, folder / "picture.exr")
    light[light == NOT_FINITE] = np.nan
    for job, first, parts, count in placed:
        shown = light[first : first + parts * count].reshape(parts, count, 3)
        columns: dict[str, Rows] = {}
        for part, names in zip(shown, groups(job["outputs"]), strict=True):
            alone = dict(job["outputs"])[names[0]] == 3
            columns |= {n: part if alone else part[:, [k]] for k, n in enumerate(names)}
        outputs = np.concatenate([columns[name] for name, _ in job["outputs"]], 1)
        np.save(folder / f"{job['number']}.out.npy", outputs)


def prepare() -> Any:
    """An empty scene for Cycles with OSL: one sample per pixel, no light, no colour management."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.shading_system = True
    scene.cycles.samples = 1
    scene.cycles.use_adaptive_sampling = False
    scene.cycles.use_denoising = False
    scene.cycles.pixel_filter_type = "BOX"
    scene.cycles.max_bounces = 0
    scene.view_settings.view_transform = "Raw"
    return scene


@contextlib.contextmanager
def caught(path: Path) -> Iterator[Path]:
    """What the process writes to its terminal, from C++ too, goes to a file."""
    sys.stdout.flush()
    sys.stderr.flush()
    saved = os.dup(1), os.dup(2)
    handle = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    try:
        os.dup2(handle, 1)
        os.dup2(handle, 2)
        yield path
    finally:
        for number, copy in zip((1, 2), saved, strict=True):
            os.dup2(copy, number)
            os.close(copy)
        os.close(handle)


def material(job: dict[str, Any], compiled: Path) -> Any:
    """A material that links the quads' attributes to the shader and its outputs to the layers."""
    made = bpy.data.materials.new(f"job{job['number']}")
    # Blender 5 makes no materials without nodes; earlier ones need to be told
    if bpy.app.version < (5, 0, 0):
        made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    nodes.clear()
    script = nodes.new("ShaderNodeScript")
    script.mode = "EXTERNAL"
    script.filepath = str(compiled)
    osl.update_script_node(script, lambda kind, message: None)
    sockets = {socket.identifier: socket for socket in script.inputs}
    for name, width in job["inputs"]:
        attribute = nodes.new("ShaderNodeAttribute")
        attribute.attribute_name = f"in_{name}"
        links.new(attribute.outputs["Vector" if width == 3 else "Fac"], sockets[name])
    part = nodes.new("ShaderNodeAttribute")
    part.attribute_name = "part"
    collect = nodes.new("ShaderNodeScript")
    collect.mode = "EXTERNAL"
    collect.filepath = str(compiled.with_name("collect.oso"))
    osl.update_script_node(collect, lambda kind, message: None)
    shown = {socket.identifier: socket for socket in collect.inputs}
    links.new(part.outputs["Fac"], shown["part"])
    sockets = {socket.identifier: socket for socket in script.outputs}
    for number, names in enumerate(groups(job["outputs"])):
        source = sockets[names[0]]
        if len(names) > 1 or dict(job["outputs"])[names[0]] == 1:
            together = nodes.new("ShaderNodeCombineXYZ")
            for axis, name in zip("XYZ", names, strict=False):
                links.new(sockets[name], together.inputs[axis])
            source = together.outputs["Vector"]
        links.new(source, shown[f"given{number}"])
    emission = nodes.new("ShaderNodeEmission")
    links.new(collect.outputs[0], emission.inputs["Color"])
    surface = nodes.new("ShaderNodeOutputMaterial")
    links.new(emission.outputs["Emission"], surface.inputs["Surface"])
    return made


def groups(outputs: Named) -> list[list[str]]:
    """Names of outputs that are shown together: vectors alone, all numbers in one."""
    vectors = [[name] for name, width in outputs if width == 3]
    numbers = [name for name, width in outputs if width == 1]
    return vectors + ([numbers] if numbers else [])


def place(scene: Any, inputs: Named, rows: Rows, parts: int, start: int, surface: Any) -> None:
    """Add one quad per row; quad k covers pixel start + k, counted from below."""
    count = len(rows)
    pixel = start + np.arange(count)
    corner = np.stack([pixel % WIDTH, pixel // WIDTH, np.zeros(count)], -1).astype(np.float32)
    offsets = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], np.float32)
    mesh = bpy.data.meshes.new(surface.name)
    mesh.vertices.add(4 * count)
    mesh.vertices.foreach_set("co", (corner[:, None] + offsets).ravel())
    mesh.loops.add(4 * count)
    mesh.loops.foreach_set("vertex_index", np.arange(4 * count, dtype=np.int32))
    mesh.polygons.add(count)
    mesh.polygons.foreach_set("loop_start", np.arange(0, 4 * count, 4, dtype=np.int32))
    part = mesh.attributes.new("part", "FLOAT", "FACE")
    part.data.foreach_set("value", np.repeat(np.arange(parts, dtype=np.float32), count // parts))
    column = 0
    for name, width in inputs:
        kind, key = ("FLOAT_VECTOR", "vector") if width == 3 else ("FLOAT", "value")
        attribute = mesh.attributes.new(f"in_{name}", kind, "FACE")
        values = np.ascontiguousarray(rows[:, column : column + width])
        attribute.data.foreach_set(key, values.ravel())
        column += width
    mesh.materials.append(surface)
    mesh.update()
    scene.collection.objects.link(bpy.data.objects.new(surface.name, mesh))


def render(scene: Any, count: int, path: Path) -> Rows:
    """Render all quads from above; return their light in their order."""
    height = max(-(-count // WIDTH), LEAST_HEIGHT)
    camera = bpy.data.cameras.new("camera")
    camera.type = "ORTHO"
    camera.ortho_scale = max(WIDTH, height)
    seen = bpy.data.objects.new("camera", camera)
    seen.location = (WIDTH / 2, height / 2, 1)
    scene.collection.objects.link(seen)
    scene.camera = seen
    scene.render.resolution_x, scene.render.resolution_y = WIDTH, height
    scene.render.resolution_percentage = 100
    scene.render.use_compositing = scene.render.use_sequencer = False
    settings = scene.render.image_settings
    settings.file_format = "OPEN_EXR"
    settings.color_mode = "RGB"
    settings.color_depth = "32"
    settings.exr_codec = "NONE"
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    pixels = np.asarray(OpenImageIO.ImageInput.open(str(path)).read_image("float"))
    return pixels.reshape(height, WIDTH, -1)[::-1, :, :3].reshape(-1, 3)[:count]


if __name__ == "__main__":
    main(Path(sys.argv[1]))
