"""Runs foreign code in a process of its own: `python -P _worker.py KIND FILE COLUMNS MEMORY FOLDER`.

It does not import gonio: a driver on the processor brings an LLVM that must not meet Dr.Jit's. KIND is
native (FILE is a library), opengl (a fragment shader), webgpu (WGSL) or python (JSON, which says what
to import). Memory is limited in bytes. Answers
go to the pipe: a line "ok DEVICE" or "error NUMBER" with so many bytes of text, then for each request (a
line with a number of rows, and the float32 rows) the outputs, four for each row.
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

OUTPUTS = 4
GROUP = 64
GLOBALS = 1 << 20
LAST_WORDS = 1 << 16
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
    make = {"native": native, "opengl": opengl, "webgpu": webgpu, "python": python}[kind]
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
        # What it says when it dies is written to a file that is open already
        resource.setrlimit(resource.RLIMIT_FSIZE, (LAST_WORDS, LAST_WORDS))
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


# How arrays of n directions and n numbers are given to a function of Python; the first that works is kept.
# Each takes a row's part (n, width) and what it is, and gives the argument.
LAYOUTS: dict[str, Callable[[Any], Any]] = {
    "arrays": lambda x: x if x.shape[1] > 1 else x[:, 0],
    "columns": lambda x: x,
    "components first": lambda x: x.T if x.shape[1] > 1 else x[:, 0],
    "torch": lambda x: tensor(x if x.shape[1] > 1 else x[:, 0]),
    "jax": lambda x: jax_array(x if x.shape[1] > 1 else x[:, 0]),
    "one by one": lambda x: x[0] if x.shape[1] > 1 else float(x[0, 0]),
}


def tensor(x: Any) -> Any:
    """The same for PyTorch."""
    return sys.modules["torch"].as_tensor(np.ascontiguousarray(x))


def jax_array(x: Any) -> Any:
    """The same for JAX."""
    return sys.modules["jax"].numpy.asarray(x)


def python(file: str) -> tuple[str, Call]:
    """A function of Python; exceptions end the process, with their place."""
    import importlib
    import importlib.util
    import json

    with open(file, encoding="utf-8") as stream:
        job = json.load(stream)
    sys.dont_write_bytecode = True
    sys.path[:0] = [os.path.dirname(job["path"]), job["folder"]]
    state: dict[str, Any] = {"loaded": False}
    sys.addaudithook(lambda event, given: guard(event, given, state))
    try:
        if job["module"]:
            module = importlib.import_module(job["module"])
        else:
            spec = importlib.util.spec_from_file_location("gonio_foreign_code", job["path"])
            assert spec is not None
            assert spec.loader is not None
            module = importlib.util.module_from_spec(spec)
            sys.modules["gonio_foreign_code"] = module
            spec.loader.exec_module(module)
        function = getattr(module, job["function"])
    except Exception as error:
        raise RuntimeError(place(error, job["path"])) from None

    def given(layout: str, rows: npt.NDArray[np.float64]) -> Any:
        found = {}
        for name, first, width, whole in job["arguments"]:
            if whole:
                found[name] = bool(rows[0, first]) if whole == "bool" else int(rows[0, first])
            else:
                found[name] = LAYOUTS[layout](rows[:, first : first + width])
        try:
            with np.errstate(all="ignore"):
                return function(**found)
        except TypeError as error:
            if "positional-only" in str(error):
                return function(*found.values())
            raise

    def batch(layout: str, rows: npt.NDArray[np.float64]) -> Rows:
        if layout == "one by one":
            return np.concatenate([shaped(given(layout, r[None]), 1) for r in rows])
        return shaped(given(layout, rows), len(rows))

    def call(rows: Rows) -> Rows:
        double = rows.astype(np.float64)
        if "layout" not in state:
            state["layout"], made = chosen(batch, double, job["path"])
            state["loaded"] = True
            return made
        try:
            return batch(str(state["layout"]), double)
        except Exception as error:
            print(place(error, job["path"]), file=sys.stderr)
            sys.stderr.flush()
            os._exit(1)

    return "Python", call


def chosen(
    batch: Callable[[str, npt.NDArray[np.float64]], Rows], rows: npt.NDArray[np.float64], path: str
) -> tuple[str, Rows]:
    """The first layout with which many rows at once give the same as each alone."""
    first: Exception | None = None
    for layout in LAYOUTS:
        if layout in ("torch", "jax") and layout not in sys.modules:
            continue
        try:
            made = batch(layout, rows)
            alone = np.concatenate(
                [batch(layout, rows[k : k + 1]) for k in range(min(3, len(rows)))]
            )
        except Exception as error:
            first = first or error
            continue
        if np.allclose(made[: len(alone)], alone, rtol=1e-4, atol=1e-6, equal_nan=True):
            return layout, made
    assert first is not None
    print(place(first, path), file=sys.stderr)
    sys.stderr.flush()
    os._exit(1)


def shaped(result: Any, count: int) -> Rows:
    """Numbers (n, 4) of what a function returns: a number, a colour, or a direction and its density."""
    if isinstance(result, (tuple, list)) and len(result) == 2:
        w, density = (np.asarray(r, np.float64) for r in result)
        w = w.T if w.shape == (3, count) and count != 3 else w
        wide = np.broadcast_to(w, (count, 3))
        return np.concatenate(
            [wide, np.broadcast_to(density.reshape(-1, 1), (count, 1))], 1
        ).astype(np.float32)
    if isinstance(result, (tuple, list)):
        result = np.stack(
            [np.broadcast_to(np.asarray(r, np.float64), (count,)) for r in result], -1
        )
    f = np.asarray(result, np.float64)
    if f.ndim == 2 and f.shape[1] == count and f.shape[0] in (3, 4) and f.shape[0] != count:
        f = f.T
    if f.ndim == 1 and f.shape in ((3,), (4,)) and count == 1:
        f = f[None]
    f = np.full((count, 1), f) if f.ndim == 0 else f[:, None] if f.ndim == 1 else f
    if f.ndim > 2 or (
        f.ndim == 2 and (f.shape[0] not in (1, count) or f.shape[1] not in (1, 3, 4))
    ):
        raise ValueError(f"it gives back an array {f.shape} for {count} pairs of directions")
    made = np.full((count, OUTPUTS), np.nan, np.float32)
    made[:, :3] = np.broadcast_to(f if f.ndim == 2 and f.shape[1] == 1 else f[..., :3], (count, 3))
    if f.ndim == 2 and f.shape[1] == 4:
        made[:, 3] = f[:, 3]
    return made


def place(error: BaseException, path: str) -> str:
    """An exception with its line in the user's file, in the form of compilers."""
    import traceback

    frames = [f for f in traceback.extract_tb(error.__traceback__) if f.filename == path]
    where = f"{path}:{frames[-1].lineno}: error: " if frames else ""
    if isinstance(error, SyntaxError):
        where = f"{error.filename}:{error.lineno}: error: "
    return f"{where}{type(error).__name__}: {error}".replace("\n", " ")


def guard(event: str, given: Any, state: dict[str, Any]) -> None:
    """No network, process or written file for Python code, and none that is read after it is loaded."""
    if event.startswith(
        ("socket.", "subprocess.", "os.system", "os.exec", "os.posix_spawn", "os.fork")
    ):
        if event in ("socket.gethostname",):
            return
        raise PermissionError(f"foreign code may not use {event}")
    if event == "open" and given and isinstance(given[0], (str, bytes)):
        name, mode = os.fsdecode(given[0]), str(given[1] or "")
        writes = any(c in mode for c in "wax+") or bool((given[2] or 0) & (os.O_WRONLY | os.O_RDWR))
        if name == os.devnull:
            return
        own = name.startswith((sys.prefix, sys.base_prefix)) or name.endswith(
            (".py", ".pyc", ".so")
        )
        if writes or (state["loaded"] and not own):
            raise PermissionError(f"foreign code may not open {name}")
    if event in ("os.remove", "os.rename", "os.rmdir", "os.mkdir", "shutil.rmtree"):
        raise PermissionError(f"foreign code may not use {event}")


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
    kept = []
    pictures = os.path.join(os.path.dirname(file), "textures.npz")
    if os.path.exists(pictures):
        with np.load(pictures) as stored:
            for unit, name in enumerate(stored.files, 1):
                if name not in program:
                    continue
                texels = np.ascontiguousarray(stored[name], np.float32)
                size = (texels.shape[1], texels.shape[0])
                picture = context.texture(size, 4, texels.tobytes(), dtype="f4")
                picture.build_mipmaps()
                picture.filter = (moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR)
                picture.use(unit)
                program[name] = unit
                kept.append(picture)

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
