"""A sphere with an exported material, drawn by OpenGL: python sphere_moderngl.py FOLDER SIZE OUTPUT.png

FOLDER holds material.glsl and material.json, as README.md says.
"""

import json
import sys
from pathlib import Path

import moderngl
import numpy as np
from PIL import Image

VERTEX = """#version 450
const vec2 corners[3] = vec2[](vec2(-1, -1), vec2(3, -1), vec2(-1, 3));
void main() { gl_Position = vec4(corners[gl_VertexID], 0, 1); }
"""
FRAGMENT = """
uniform vec4 values[COUNT];
uniform float size;
out vec4 colour;
void main() {
    vec2 q = (gl_FragCoord.xy / size * 2.0 - 1.0) * 1.1;
    if (dot(q, q) >= 1.0) { colour = vec4(0, 0, 0, 1); return; }
    vec3 n = vec3(q, sqrt(1.0 - dot(q, q))), s = normalize(cross(vec3(0, 1, 0), n)), t = cross(n, s);
    vec3 light = normalize(vec3(0.5, 0.6, 0.62)), view = vec3(0, 0, 1);
    vec3 wi = vec3(dot(light, s), dot(light, t), dot(light, n));
    vec3 wo = vec3(dot(view, s), dot(view, t), dot(view, n));
    STRUCT params = PREFIX_load(values);
    colour = vec4(PREFIX_eval(params, wi, wo) * max(wi.z, 0.0) * 3.14159265, 1);
}
"""


def draw(folder: Path, size: int) -> np.ndarray:
    """Linear radiance, shape (size, size, 3), the top line first."""
    about = json.loads((folder / "material.json").read_text(encoding="utf-8"))
    read = [p for p in about["parameters"] if p["offset"] is not None]
    values = np.zeros((max(len(read), 1), 4), np.float32)
    for p in read:
        values[p["offset"] // about["stride"], : p["width"]] = p["value"]
    main = FRAGMENT.replace("COUNT", str(len(values))).replace("STRUCT", about["struct"])
    main = main.replace("PREFIX", about["prefix"])
    text = "#version 450\n" + (folder / "material.glsl").read_text(encoding="utf-8") + main

    context = moderngl.create_context(standalone=True, backend="egl")
    program = context.program(vertex_shader=VERTEX, fragment_shader=text)
    program["values"].write(values.tobytes())
    program["size"].value = size
    film = context.simple_framebuffer((size, size), components=4, dtype="f4")
    film.use()
    context.vertex_array(program, []).render(moderngl.TRIANGLES, vertices=3)
    pixels = np.frombuffer(film.read(components=4, dtype="f4"), np.float32)
    return pixels.reshape(size, size, 4)[::-1, :, :3]


def to_srgb(linear: np.ndarray) -> np.ndarray:
    """Eight bits of what a screen shows."""
    x = np.clip(linear, 0, 1)
    encoded = np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)
    return (encoded * 255 + 0.5).astype(np.uint8)


if __name__ == "__main__":
    folder, size, output = Path(sys.argv[1]), int(sys.argv[2]), Path(sys.argv[3])
    picture = draw(folder, size)
    if output.suffix == ".npy":
        np.save(output, picture)
    else:
        Image.fromarray(to_srgb(picture)).save(output)
