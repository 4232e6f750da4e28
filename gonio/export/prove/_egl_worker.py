"""Runs GLSL and GLSL ES through OpenGL: `python -P _egl_worker.py FOLDER`, a process of its own.

It does not import gonio: a driver on the processor brings an LLVM that must not meet Dr.Jit's.
Job k has the rows k.npy, and k.tables.npy if it reads tables, and is one of: k.comp, a compute shader over
buffers; k.frag, a fragment shader of OpenGL ES 3.00 over a texture, one pixel per row, as on a web page.
Results go to k.out.npy, the compiler's complaints to k.error, and the name of the device to device.
"""

import json
import sys
from pathlib import Path
from typing import Any

import moderngl
import numpy as np
import numpy.typing as npt

Rows = npt.NDArray[np.float32]

GROUP = 64
SIDE = 128  # pixels in a line of the picture; the shaders do not need to know

CORNERS = """#version 300 es
in vec2 corner;
void main() { gl_Position = vec4(corner, 0.0, 1.0); }
"""


def main(folder: Path) -> None:
    """Run all jobs of the folder."""
    context = moderngl.create_context(standalone=True, backend="egl", require=430)
    name = f"{context.info['GL_RENDERER']}, OpenGL {context.info['GL_VERSION']}"
    (folder / "device").write_text(name, encoding="utf-8")
    for job in json.loads((folder / "jobs.json").read_text(encoding="utf-8")):
        number, columns = job["number"], job["columns"]
        rows = np.load(folder / f"{number}.npy")
        path = folder / job["file"]
        run = compute if path.suffix == ".comp" else draw
        try:
            tables = folder / f"{number}.tables.npy"
            bound = (job["tables"], np.load(tables)) if tables.exists() else None
            outputs = run(context, path.read_text(encoding="utf-8"), rows, columns, bound)
        except moderngl.Error as error:
            (folder / f"{number}.error").write_text(str(error), encoding="utf-8")
        else:
            np.save(folder / f"{number}.out.npy", outputs)


Tables = tuple[dict[str, Any], Rows]
"""Where tables are bound, and their numbers."""


def compute(
    context: Any, text: str, rows: Rows, columns: int, tables: Tables | None = None
) -> Rows:
    """Run a compute shader on all rows."""
    shader = context.compute_shader(text)
    if tables is not None:
        context.buffer(tables[1].tobytes()).bind_to_storage_buffer(tables[0]["buffer"])
    given = context.buffer(rows.tobytes())
    made = context.buffer(np.full(len(rows) * columns, np.nan, np.float32).tobytes())
    given.bind_to_storage_buffer(0)
    made.bind_to_storage_buffer(1)
    shader.run(-(-len(rows) // GROUP))
    context.finish()
    return np.frombuffer(made.read(), np.float32).reshape(len(rows), columns)


def draw(context: Any, text: str, rows: Rows, columns: int, tables: Tables | None = None) -> Rows:
    """Draw one pixel per row; its inputs are some texels of a texture, its outputs up to three colours."""
    shader = context.program(vertex_shader=CORNERS, fragment_shader=text)
    texels = -(-rows.shape[1] // 4)
    height = -(-len(rows) // SIDE)
    padded = np.zeros((SIDE * height, 4 * texels), np.float32)
    # Pixels after the last row repeat it
    padded[:, : rows.shape[1]] = rows[np.minimum(np.arange(SIDE * height), len(rows) - 1)]
    texture = context.texture((SIDE * texels, height), 4, padded.tobytes(), dtype="f4")
    texture.use(0)
    if tables is not None:
        facts, numbers = tables
        size = (facts["width"], len(numbers) // facts["width"])
        stored = context.texture(size, 4, numbers.tobytes(), dtype="f4")
        stored.use(1)
        shader["rows"].value, shader[facts["texture"]].value = 0, 1
    colours = -(-columns // 4)
    targets = [context.texture((SIDE, height), 4, dtype="f4") for _ in range(colours)]
    frame = context.framebuffer(targets)
    frame.use()
    frame.clear(np.nan, np.nan, np.nan, np.nan)
    quad = context.buffer(np.array([-1, -1, 1, -1, -1, 1, 1, 1], np.float32).tobytes())
    array = context.vertex_array(shader, [(quad, "2f", "corner")])
    array.render(moderngl.TRIANGLE_STRIP)
    context.finish()
    planes = [np.frombuffer(t.read(), np.float32).reshape(-1, 4)[: len(rows)] for t in targets]
    return np.ascontiguousarray(np.concatenate(planes, 1)[:, :columns])


if __name__ == "__main__":
    main(Path(sys.argv[1]))
