"""Runs compute shaders through wgpu: `python -P _wgpu_worker.py FOLDER`, a process of its own.

It does not import gonio: a Vulkan driver on the processor brings an LLVM that must not meet Dr.Jit's.
Job k is the shader k.wgsl or k.spv with the rows k.npy and the tables k.tables.npy, if it reads some, as
listed in jobs.json. Results go to k.out.npy,
the compiler's complaints to k.error, and the name of the device to device.
"""

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import wgpu

Rows = npt.NDArray[np.float32]

GROUP = 64


def main(folder: Path) -> None:
    """Run all jobs of the folder."""
    adapter = wgpu.gpu.request_adapter_sync(power_preference="high-performance")
    info = adapter.info
    (folder / "device").write_text(f"{info['device']}, {info['description']}", encoding="utf-8")
    # Native limits: the rows of a large model exceed the default size of a buffer
    device = adapter.request_device_sync()
    for job in json.loads((folder / "jobs.json").read_text(encoding="utf-8")):
        number, columns = job["number"], job["columns"]
        rows = np.load(folder / f"{number}.npy")
        try:
            tables = folder / f"{number}.tables.npy"
            bound = (job["tables"], np.load(tables)) if tables.exists() else None
            outputs = compute(device, folder / job["file"], rows, columns, bound)
        except Exception as error:
            (folder / f"{number}.error").write_text(str(error), encoding="utf-8")
        else:
            np.save(folder / f"{number}.out.npy", outputs)


def compute(
    device: Any,
    path: Path,
    rows: Rows,
    columns: int,
    tables: tuple[tuple[int, int], Rows] | None = None,
) -> Rows:
    """Run one shader on all rows; it may read tables, at a group and binding."""
    words = path.read_bytes()
    module = device.create_shader_module(
        code=words if path.suffix == ".spv" else words.decode("utf-8")
    )
    pipeline = device.create_compute_pipeline(
        layout="auto", compute={"module": module, "entry_point": "main"}
    )
    given = device.create_buffer_with_data(data=rows, usage=wgpu.BufferUsage.STORAGE)
    size = len(rows) * columns * 4
    usage = wgpu.BufferUsage.STORAGE | wgpu.BufferUsage.COPY_SRC
    made = device.create_buffer_with_data(data=np.full(size // 4, np.nan, np.float32), usage=usage)
    buffers = {(0, 0): given, (0, 1): made}
    if tables is not None:
        place, numbers = tables
        usage = wgpu.BufferUsage.STORAGE
        buffers[place[0], place[1]] = device.create_buffer_with_data(data=numbers, usage=usage)
    groups = {
        number: device.create_bind_group(
            layout=pipeline.get_bind_group_layout(number),
            entries=[
                {"binding": k, "resource": {"buffer": b, "offset": 0, "size": b.size}}
                for (group, k), b in buffers.items()
                if group == number
            ],
        )
        for number in {group for group, _ in buffers}
    }
    encoder = device.create_command_encoder()
    commands = encoder.begin_compute_pass()
    commands.set_pipeline(pipeline)
    for number, group in groups.items():
        commands.set_bind_group(number, group)
    commands.dispatch_workgroups(-(-len(rows) // GROUP))
    commands.end()
    device.queue.submit([encoder.finish()])
    data = device.queue.read_buffer(made)
    return np.frombuffer(data, np.float32).reshape(len(rows), columns)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
