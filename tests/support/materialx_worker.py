"""Draws points with shaders that MaterialX generated: `python -P materialx_worker.py FOLDER`.

A process of its own that does not import gonio, because a driver on the processor brings an LLVM that must
not meet Dr.Jit's. The folder has jobs.json, a list of drawings: name, shader (of the files SHADER.vert and
SHADER.frag), uniforms by name, environment (a picture in an .npy file) and blurred. Point k has the row
k of points.npy: position, which is the middle of a pixel, normal and tangent. Row k of NAME.out.npy is its
colour.
"""

import json
import sys
from pathlib import Path

import moderngl
import numpy as np

SIDE = 64
INPUTS = {"i_position": slice(0, 3), "i_normal": slice(3, 6), "i_tangent": slice(6, 9)}


def main(folder: Path) -> None:
    """Draw all pictures of the folder."""
    context = moderngl.create_context(standalone=True, backend="egl", require=430)
    points = np.load(folder / "points.npy")
    programs = {}
    for job in json.loads((folder / "jobs.json").read_text(encoding="utf-8")):
        if job["shader"] not in programs:
            texts = [(folder / f"{job['shader']}{end}").read_text() for end in (".vert", ".frag")]
            programs[job["shader"]] = context.program(*texts)
        program = programs[job["shader"]]
        picture = np.load(folder / job["environment"])
        colours = draw(context, program, points, job["uniforms"], picture, job["blurred"])
        np.save(folder / f"{job['name']}.out.npy", colours)


def draw(context, program, points, uniforms, picture, blurred):
    """The colour of every point."""
    for name, value in uniforms.items():
        if name in program:
            program[name] = tuple(value) if isinstance(value, list) else value
    height, width, _ = picture.shape
    texture = context.texture((width, height), 4, picture.tobytes(), dtype="f4")
    texture.repeat_y = False
    if blurred:
        texture.build_mipmaps()
        texture.filter = (moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR)
    for unit, name in enumerate(("u_envRadiance", "u_envIrradiance")):
        if name in program:
            texture.use(unit)
            program[name] = unit
    used = {name: part for name, part in INPUTS.items() if name in program}
    data = np.concatenate([points[:, part] for part in used.values()], 1)
    buffer = context.buffer(np.ascontiguousarray(data, np.float32).tobytes())
    array = context.vertex_array(program, [(buffer, " ".join(["3f"] * len(used)), *used)])
    target = context.texture((SIDE, SIDE), 4, dtype="f4")
    frame = context.framebuffer([target])
    frame.use()
    frame.clear(np.nan, np.nan, np.nan, np.nan)
    array.render(moderngl.POINTS, len(points))
    context.finish()
    colours = np.frombuffer(target.read(), np.float32).reshape(SIDE * SIDE, 4)
    for thing in (texture, buffer, array, frame, target):
        thing.release()
    column, row = np.floor((points[:, :2].T + 1) / 2 * SIDE).astype(int)
    return colours[row * SIDE + column, :3].copy()


if __name__ == "__main__":
    main(Path(sys.argv[1]))
