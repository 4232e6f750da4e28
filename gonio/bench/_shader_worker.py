"""Times compute shaders through OpenGL: `python -P _shader_worker.py FOLDER`, a process of its own.

It does not import gonio: a driver on the processor brings an LLVM that must not meet Dr.Jit's.
job.json says how many shaders there are; k.comp reads rows.npy, and writes what is saved as k.npy. Their
median times and the name of the device go to times.json.
"""

import json
import statistics
import sys
import time
from pathlib import Path

import moderngl
import numpy as np

GROUP = 64


def main(folder: Path) -> None:
    """Run all shaders of the folder in turn, so that what else the machine does hits all of them."""
    context = moderngl.create_context(standalone=True, backend="egl", require=430)
    job = json.loads((folder / "job.json").read_text(encoding="utf-8"))
    rows = np.load(folder / "rows.npy")
    given = context.buffer(rows.tobytes())
    made = context.buffer(reserve=len(rows) * job["columns"] * 4)
    given.bind_to_storage_buffer(0)
    made.bind_to_storage_buffer(1)
    shaders = [
        context.compute_shader((folder / f"{k}.comp").read_text(encoding="utf-8"))
        for k in range(job["shaders"])
    ]
    times: list[list[float]] = [[] for _ in shaders]
    for number in range(job["repeat"] + 1):
        for k, shader in enumerate(shaders):
            start = time.perf_counter()
            shader.run(-(-len(rows) // GROUP))
            context.finish()
            if number:  # the first round compiles
                times[k].append(time.perf_counter() - start)
            else:
                values = np.frombuffer(made.read(), np.float32).reshape(len(rows), -1)
                np.save(folder / f"{k}.npy", values)
    found = {
        "seconds": [statistics.median(t) for t in times],
        "device": context.info["GL_RENDERER"],
    }
    (folder / "times.json").write_text(json.dumps(found), encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
