"""A sphere under a picture of the sky, by an exported material function.

python lit_wgpu.py FOLDER SIZE OUTPUT.png

FOLDER holds paint.wgsl, paint.json, paint.npy, sky.ktx2 and sky.json, as README.md says.
"""

import json
import struct
import sys
from pathlib import Path

import numpy as np
import wgpu
from PIL import Image

MAIN = """
@group(0) @binding(0) var<uniform> values: array<vec4f, COUNT>;
@group(0) @binding(1) var<uniform> colours: array<vec4f, 9>;
@group(0) @binding(2) var<storage, read_write> film: array<vec4f>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3u) {
    let q = ((vec2f(id.xy) + 0.5) / SIZE.0 * 2.0 - 1.0) * vec2f(1.1, -1.1);
    let at = id.y * SIZEu + id.x;
    if (dot(q, q) >= 1.0) { film[at] = vec4f(0.0, 0.0, 0.0, 1.0); return; }
    let n = vec3f(q, sqrt(1.0 - dot(q, q)));
    let sky = STRUCT(SKY);
    let tangent = cross(vec3f(0.0, 1.0, 0.0), n);
    let view = vec3f(0.0, 0.0, 1.0);
    film[at] = vec4f(PREFIX_shade(PREFIX_load(values), n, tangent, view, sky), 1.0);
}
"""


def cube(device: wgpu.GPUDevice, path: Path) -> wgpu.GPUTextureView:
    """The levels of a .ktx2 file with half floats."""
    data = path.read_bytes()
    size, count = struct.unpack_from("<I", data, 20)[0], struct.unpack_from("<I", data, 40)[0]
    usage = wgpu.TextureUsage.TEXTURE_BINDING | wgpu.TextureUsage.COPY_DST
    texture = device.create_texture(
        size=(size, size, 6), format="rgba16float", mip_level_count=count, usage=usage
    )
    for level in range(count):
        offset, length, _ = struct.unpack_from("<3Q", data, 80 + 24 * level)
        side = size >> level
        device.queue.write_texture(
            {"texture": texture, "mip_level": level},
            data[offset : offset + length],
            {"bytes_per_row": 8 * side, "rows_per_image": side},
            (side, side, 6),
        )
    return texture.create_view(dimension="cube")


def table(device: wgpu.GPUDevice, path: Path) -> wgpu.GPUTextureView:
    """A split-sum table."""
    pair = np.load(path)
    texels = np.concatenate([pair, np.zeros_like(pair)], axis=-1).astype(np.float16)
    usage = wgpu.TextureUsage.TEXTURE_BINDING | wgpu.TextureUsage.COPY_DST
    size = (pair.shape[1], pair.shape[0], 1)
    texture = device.create_texture(size=size, format="rgba16float", usage=usage)
    rows = {"bytes_per_row": 8 * size[0], "rows_per_image": size[1]}
    device.queue.write_texture({"texture": texture}, texels.tobytes(), rows, size)
    return texture.create_view()


def draw(folder: Path, size: int) -> np.ndarray:
    """Linear radiance, shape (size, size, 3), the top line first."""
    about = json.loads((folder / "paint.json").read_text(encoding="utf-8"))
    read = [p for p in about["parameters"] if p["offset"] is not None]
    values, colours = np.zeros((len(read), 4), np.float32), np.zeros((9, 4), np.float32)
    for p in read:
        values[p["offset"] // about["stride"], : p["width"]] = p["value"]
    sky = json.loads((folder / "sky.json").read_text(encoding="utf-8"))
    colours[:, :3] = [harmonic["rgb"] for harmonic in sky]
    given = next(a for a in about["lit"]["arguments"] if a["name"] == "sky")
    main = MAIN.replace("COUNT", str(len(values))).replace("SIZE", str(size))
    main = main.replace("STRUCT", given["struct"]).replace("PREFIX", about["prefix"])
    main = main.replace("SKY", ", ".join(f"colours[{i}].xyz" for i in range(9)))
    text = (folder / "paint.wgsl").read_text(encoding="utf-8") + main

    device = wgpu.gpu.request_adapter_sync().request_device_sync()
    film = device.create_buffer(
        size=16 * size * size, usage=wgpu.BufferUsage.STORAGE | wgpu.BufferUsage.COPY_SRC
    )
    uniform = [
        device.create_buffer_with_data(data=d, usage=wgpu.BufferUsage.UNIFORM)
        for d in (values, colours)
    ]
    smooth = device.create_sampler(mag_filter="linear", min_filter="linear", mipmap_filter="linear")
    pipeline = device.create_compute_pipeline(
        layout="auto",
        compute={"module": device.create_shader_module(code=text), "entry_point": "main"},
    )
    own = [{"buffer": buffer} for buffer in (*uniform, film)]
    maps = [cube(device, folder / "sky.ktx2"), table(device, folder / "paint.npy"), smooth]
    encoder = device.create_command_encoder()
    run = encoder.begin_compute_pass()
    run.set_pipeline(pipeline)
    for group, resources in enumerate((own, maps)):
        entries = [{"binding": i, "resource": r} for i, r in enumerate(resources)]
        run.set_bind_group(
            group,
            device.create_bind_group(layout=pipeline.get_bind_group_layout(group), entries=entries),
        )
    run.dispatch_workgroups(size // 8, size // 8)
    run.end()
    device.queue.submit([encoder.finish()])
    pixels = np.frombuffer(device.queue.read_buffer(film), np.float32)
    return pixels.reshape(size, size, 4)[..., :3]


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
