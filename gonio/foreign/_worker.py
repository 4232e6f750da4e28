"""Runs foreign code in a process of its own: `python -P _worker.py KIND FILE COLUMNS MEMORY FOLDER`.

It does not import gonio: a driver on the processor brings an LLVM that must not meet Dr.Jit's. KIND is
native (FILE is a library), opengl (a fragment shader) or webgpu (WGSL). Memory is limited in bytes. Answers
go to the pipe: a line "ok DEVICE" or "error NUMBER" with so many bytes of text, then for each request (a
line with a number of rows, and the float32 rows) the outputs, three for each row.
"""

import ctypes
import os
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

Rows = npt.NDArray[np.float32]
Call = Callable[[Rows], Rows]

OUTPUTS = 3
GROUP = 64
GLOBALS = 1 << 20
SIDE = 128  # pixels in a line of the picture; the shader does not need to know

CORNERS = """{version}
in vec2 corner;
void main() {{ gl_Position = vec4(corner, 0.0, 1.0); }}
"""


def main(kind: str, file: str, columns: int, memory: int) -> None:
    """Answer requests until the pipe is closed."""
    # What foreign code prints goes where nobody reads it
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    make = {"native": native, "opengl": opengl, "webgpu": webgpu}[kind]
    try:
        device, call = make(file)
        limit(memory, kind == "native")
    except Exception as error:
        text = str(error).encode()
        answers.write(b"error %d\n" % len(text) + text)
        answers.flush()
        return
    answers.write(f"ok {device}\n".encode())
    answers.flush()
    while line := sys.stdin.buffer.readline():
        count = int(line)
        data = sys.stdin.buffer.read(4 * count * columns)
        rows = np.frombuffer(data, np.float32).reshape(count, columns)
        answers.write(np.ascontiguousarray(call(rows), np.float32).tobytes())
        answers.flush()


def limit(memory: int, alone: bool) -> None:
    """No more memory than this; for native code no new file, socket or process either."""
    try:
        import resource
    except ImportError:  # not on Windows
        return
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    kind = resource.RLIMIT_AS if alone else resource.RLIMIT_DATA
    resource.setrlimit(kind, (memory, memory))
    if alone:
        resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))
        resource.setrlimit(resource.RLIMIT_NOFILE, (0, 0))
        resource.setrlimit(resource.RLIMIT_NPROC, (0, 0))


def native(file: str) -> tuple[str, Call]:
    """A library with the function gonio_run."""
    function = ctypes.CDLL(file).gonio_run
    pointer = ctypes.POINTER(ctypes.c_float)
    function.argtypes = [pointer, pointer, ctypes.c_int, ctypes.c_void_p]
    function.restype = None
    # slangc's C++ keeps variables of the file, uniforms for example, in a place of the caller's
    place = ctypes.create_string_buffer(GLOBALS)

    def call(rows: Rows) -> Rows:
        made = np.full((len(rows), OUTPUTS), np.nan, np.float32)
        given = np.ascontiguousarray(rows)
        function(given.ctypes.data_as(pointer), made.ctypes.data_as(pointer), len(rows), place)
        return made

    return "processor", call


def opengl(file: str) -> tuple[str, Call]:
    """A fragment shader that takes its rows from a texture."""
    import moderngl

    context = moderngl.create_context(standalone=True, backend="egl", require=430)
    with open(file, encoding="utf-8") as stream:
        text = stream.read()
    version = text.partition("\n")[0]
    program = context.program(vertex_shader=CORNERS.format(version=version), fragment_shader=text)
    quad = context.buffer(np.array([-1, -1, 1, -1, -1, 1, 1, 1], np.float32).tobytes())
    array = context.vertex_array(program, [(quad, "2f", "corner")])

    def call(rows: Rows) -> Rows:
        count = len(rows)
        texels = -(-rows.shape[1] // 4)
        height = -(-count // SIDE)
        padded = np.zeros((SIDE * height, 4 * texels), np.float32)
        padded[:count, : rows.shape[1]] = rows
        padded[count:, : rows.shape[1]] = rows[-1]
        texture = context.texture((SIDE * texels, height), 4, padded.tobytes(), dtype="f4")
        target = context.texture((SIDE, height), 4, dtype="f4")
        frame = context.framebuffer([target])
        texture.use(0)
        frame.use()
        frame.clear(np.nan, np.nan, np.nan, np.nan)
        array.render(moderngl.TRIANGLE_STRIP)
        context.finish()
        made = np.frombuffer(target.read(), np.float32).reshape(-1, 4)[:count, :OUTPUTS].copy()
        for used in (frame, target, texture):
            used.release()
        return made

    return f"{context.info['GL_RENDERER']}, OpenGL", call


def webgpu(file: str) -> tuple[str, Call]:
    """A compute shader over buffers."""
    import wgpu

    adapter = wgpu.gpu.request_adapter_sync(power_preference="high-performance")
    device = adapter.request_device_sync()
    with open(file, encoding="utf-8") as stream:
        module = device.create_shader_module(code=stream.read())
    pipeline = device.create_compute_pipeline(
        layout="auto", compute={"module": module, "entry_point": "gonio_main"}
    )
    usage = wgpu.BufferUsage.STORAGE | wgpu.BufferUsage.COPY_SRC

    def call(rows: Rows) -> Rows:
        given: Any = device.create_buffer_with_data(data=np.ascontiguousarray(rows), usage=usage)
        empty = np.full(len(rows) * OUTPUTS, np.nan, np.float32)
        made: Any = device.create_buffer_with_data(data=empty, usage=usage)
        group = device.create_bind_group(
            layout=pipeline.get_bind_group_layout(0),
            entries=[
                {"binding": k, "resource": {"buffer": b, "offset": 0, "size": b.size}}
                for k, b in enumerate((given, made))
            ],
        )
        encoder = device.create_command_encoder()
        commands = encoder.begin_compute_pass()
        commands.set_pipeline(pipeline)
        commands.set_bind_group(0, group)
        commands.dispatch_workgroups(-(-len(rows) // GROUP))
        commands.end()
        device.queue.submit([encoder.finish()])
        data = device.queue.read_buffer(made)
        return np.frombuffer(data, np.float32).reshape(len(rows), OUTPUTS).copy()

    return f"{adapter.info['device']}, WebGPU", call


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4]))
