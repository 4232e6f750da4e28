"""A sphere with an HLSL export, compiled by Slang and run on the processor.

    python sphere_slang.py FOLDER SIZE OUTPUT.png

FOLDER holds material.hlsl and material.json, as README.md says. slangc (or SLANGC=path) and g++ must be
there; `slangc -target spirv` or `-target dxil` takes the same text to a GPU.
"""

import ctypes
import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

MAIN = """
export __extern_cpp void draw(float* values, float* colour, int size) {
    float4 given[COUNT];
    for (int k = 0; k < COUNT; ++k)
        given[k] = float4(values[4 * k], values[4 * k + 1], values[4 * k + 2], values[4 * k + 3]);
    STRUCT params = PREFIX_load(given);
    float3 light = normalize(float3(0.5, 0.6, 0.62));
    float3 view = float3(0, 0, 1);
    for (int i = 0; i < size * size; ++i) {
        float2 q = (float2(i % size + 0.5, size - 0.5 - i / size) / size * 2.0 - 1.0) * 1.1;
        float3 f = float3(0, 0, 0);
        if (dot(q, q) < 1.0) {
            float3 n = float3(q.x, q.y, sqrt(1.0 - dot(q, q)));
            float3 s = normalize(cross(float3(0, 1, 0), n));
            float3 t = cross(n, s);
            float3 wi = float3(dot(light, s), dot(light, t), dot(light, n));
            float3 wo = float3(dot(view, s), dot(view, t), dot(view, n));
            f = PREFIX_eval(params, wi, wo) * max(wi.z, 0.0) * 3.14159265;
        }
        colour[3 * i] = f.x;
        colour[3 * i + 1] = f.y;
        colour[3 * i + 2] = f.z;
    }
}
"""


def draw(folder: Path, size: int) -> np.ndarray:
    """Linear radiance, shape (size, size, 3), the top line first."""
    about = json.loads((folder / "material.json").read_text(encoding="utf-8"))
    read = [p for p in about["parameters"] if p["offset"] is not None]
    values = np.zeros((max(len(read), 1), 4), np.float32)
    for p in read:
        values[p["offset"] // about["stride"], : p["width"]] = p["value"]
    main = MAIN.replace("COUNT", str(len(values))).replace("STRUCT", about["struct"])
    text = (folder / "material.hlsl").read_text(encoding="utf-8") + main.replace(
        "PREFIX", about["prefix"]
    )
    with tempfile.TemporaryDirectory() as name:
        work = Path(name)
        (work / "host.slang").write_text(text, encoding="utf-8")
        slangc = shutil.which(os.environ.get("SLANGC", "slangc"))
        if slangc is None:
            sys.exit(
                "slangc is missing: put it on the path, or name it with SLANGC=/path/to/slangc"
            )
        subprocess.run(
            [slangc, "host.slang", "-target", "cpp", "-o", "host.cpp"], cwd=work, check=True
        )
        flags = ["-O2", "-shared", "-fPIC", "-w"]
        subprocess.run(["g++", *flags, "host.cpp", "-o", "host.so"], cwd=work, check=True)
        colour = np.zeros((size, size, 3), np.float32)
        pointer = ctypes.POINTER(ctypes.c_float)
        library = ctypes.CDLL(str(work / "host.so"))
        library.draw(values.ctypes.data_as(pointer), colour.ctypes.data_as(pointer), size)
    return colour


if __name__ == "__main__":
    folder, size, output = Path(sys.argv[1]), int(sys.argv[2]), Path(sys.argv[3])
    picture = draw(folder, size)
    if output.suffix == ".npy":
        np.save(output, picture)
    else:
        Image.fromarray((np.clip(picture, 0, 1) ** (1 / 2.2) * 255).astype(np.uint8)).save(output)
