"""Compiling foreign code, and the process that it runs in, with limits of time and memory."""

from __future__ import annotations

import contextlib
import re
import subprocess
import sys
import tempfile
import threading
import weakref
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import IO

import numpy as np
from numpy.typing import NDArray

from gonio.export.prove import tools
from gonio.export.prove.native import FLAGS
from gonio.foreign.harness import OUTPUTS, OWN
from gonio.foreign.library import wrapper
from gonio.foreign.loops import COUNTING, CUT, TURNS
from gonio.foreign.source import FILE_LINES, ForeignError, Source
from gonio.foreign.textures import write as write_textures

Singles = NDArray[np.float32]

# Bytes that foreign code may use: a driver on the processor takes most of one gigabyte for itself.
MEMORY = 4 << 30

# Seconds for a call: the first ones are of a few rows, and others of up to a quarter of a million.
SECONDS = 20.0
ROWS = 1 << 18

# Seconds in which the process has to be there, with its shader compiled.
START = 120.0

CUDA = Path(__file__).with_name("cuda")
METAL = Path(__file__).with_name("metal")
OSL = Path(__file__).with_name("osl_words.h")


class Running:
    """Compiled foreign code in its own process."""

    def __init__(
        self,
        source: Source,
        text: str,
        columns: int,
        *,
        include: Sequence[str | Path] = (),
        defines: Sequence[str] = (),
        seconds: float = SECONDS,
        memory: int = MEMORY,
        textures: Mapping[str, str] | None = None,
    ) -> None:
        """Compile and start.

        Args:
            source: what it was made of.
            text: with the harness.
            columns: numbers in a row of inputs.
            include: folders with headers.
            defines: macros, NAME or NAME=VALUE.
            seconds: for each call.
            memory: in bytes.
            textures: files or values by the names of samplers.

        Raises:
            ForeignError: it does not compile, or a tool is missing.
        """
        self.source, self.columns, self.seconds, self.memory = source, columns, seconds, memory
        self._folder = tempfile.TemporaryDirectory(prefix="gonio-")
        folder = Path(self._folder.name)
        try:
            write_textures(folder, source, dict(textures or {}))
            kind, file = _compiled(source, text, folder, include, defines)
            self._command = [sys.executable, "-P", str(Path(__file__).with_name("_worker.py"))]
            self._command += [kind, str(file), str(columns), str(memory)]
            self._text = text
            self.device = ""
        except tools.ProofError as error:
            self._folder.cleanup()
            raise ForeignError(str(error)) from None
        except ForeignError:
            self._folder.cleanup()
            raise
        try:
            self._start()
        except ForeignError:
            self._close()
            raise

    def _start(self) -> None:
        self._errors = Path(self._folder.name) / "errors"
        with self._errors.open("wb") as errors:
            self._process = subprocess.Popen(
                self._command,
                cwd=self._folder.name,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=errors,
            )
        self._close = weakref.finalize(self, _stop, self._process, self._folder)
        with _Limit(self._process, START) as limit:
            words = self._answers.readline().decode().strip()
            state, _, rest = words.partition(" ")
            if state == "error":
                message = self._answers.read(int(rest)).decode()
                raise _refused(self.source, message)
        if state != "ok":
            raise ForeignError(self._ended(limit.over, START, "while it was loaded"))
        self.device = rest

    @property
    def _answers(self) -> IO[bytes]:
        assert self._process.stdout is not None
        return self._process.stdout

    def call(self, rows: NDArray[np.floating]) -> Singles:
        """Outputs (n, 4) for inputs (n, columns).

        Raises:
            ForeignError: it does not come back in time, or ends its process.
        """
        rows = np.ascontiguousarray(rows, np.float32)
        found = [self._part(rows[k : k + ROWS]) for k in range(0, len(rows), ROWS)]
        return np.concatenate(found) if found else np.empty((0, OUTPUTS), np.float32)

    def _part(self, rows: Singles) -> Singles:
        size = 4 * OUTPUTS * len(rows)
        assert self._process.stdin is not None
        with _Limit(self._process, self.seconds) as limit:
            try:
                self._process.stdin.write(b"%d\n" % len(rows) + rows.tobytes())
                self._process.stdin.flush()
                data = self._answers.read(size)
            except (BrokenPipeError, OSError):
                data = b""
        if len(data) != size:
            raise ForeignError(
                self._ended(limit.over, self.seconds, f"in a call of {len(rows)} rows")
            )
        made = np.frombuffer(data, np.float32).reshape(-1, OUTPUTS)
        if COUNTING in self.device and (made[:, 3] == np.float32(CUT)).any():
            raise ForeignError(
                f"{self.source.path}: loops turned more than {TURNS} times in one call, and Mesa's "
                "driver on the processor ends them in silence; is there an endless loop? If not, let "
                "them turn less often, or use a machine with a GPU."
            )
        return made

    def _ended(self, over: bool, seconds: float, when: str) -> str:
        """What has happened to the process, in a sentence."""
        path = self.source.path
        if over:
            late = f"the code did not come back within {seconds:g} s {when}"
            return f"{path}: {late}; is there an endless loop?"
        code = self._process.wait()
        said = self._errors.read_text(errors="replace").strip() or "no message"
        last = said.splitlines()[-1]
        if self.source.language == "python" and code == 1:
            return str(_refused(self.source, last))
        if code >= 0 and self.source.language != "python":
            return f"{path}: the code ended its process by itself (exit code {code}) {when}."
        if "MemoryError" in last or "bad_alloc" in last or "ENOMEM" in last:
            return f"{path}: the code needs more than {self.memory / 2**30:.3g} GB of memory."
        names = {
            -11: "a segmentation fault",
            -8: "an arithmetic exception",
            -6: "abort",
            -4: "an illegal instruction",
            -7: "a bus error",
        }
        reason = names.get(code, f"signal {-code}" if code < 0 else last)
        if code == -6 and (thrown := re.search(r"what\(\):\s*(.+)", said)):
            reason = f"an exception that nobody catches: {thrown[1].strip()}"
        return f"{path}: the code crashed ({reason}) {when}."

    def close(self) -> None:
        """End the process."""
        self._close()


class _Limit:
    """Kills a process that takes longer."""

    def __init__(self, process: subprocess.Popen[bytes], seconds: float) -> None:
        self.over = False
        self._process = process
        self._timer = threading.Timer(seconds, self._kill)
        self._timer.daemon = True

    def _kill(self) -> None:
        self.over = True
        self._process.kill()

    def __enter__(self) -> _Limit:
        self._timer.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._timer.cancel()


def _stop(process: subprocess.Popen[bytes], folder: tempfile.TemporaryDirectory[str]) -> None:
    process.kill()
    process.wait()
    for pipe in (process.stdin, process.stdout):
        if pipe is not None:
            with contextlib.suppress(OSError):
                pipe.close()
    folder.cleanup()


def _compiled(
    source: Source, text: str, folder: Path, include: Sequence[str | Path], defines: Sequence[str]
) -> tuple[str, Path]:
    """The kind of worker and its file."""
    language = source.language
    if language in ("glsl", "essl", "brdf"):
        tools.program("moderngl", "runs GLSL")
        (folder / "shader.frag").write_text(text, encoding="utf-8")
        return "opengl", folder / "shader.frag"
    if language == "python":
        (folder / "job.json").write_text(text, encoding="utf-8")
        return "python", folder / "job.json"
    if language == "wgsl":
        tools.program("wgpu", "compiles and runs WGSL")
        (folder / "shader.wgsl").write_text(text, encoding="utf-8")
        return "webgpu", folder / "shader.wgsl"
    gxx = tools.program("g++", "compiles what is to be run")
    folders = [str(Path(p).resolve()) for p in (source.path.parent, *include)]
    options = [f"-I{p}" for p in folders] + [f"-D{d}" for d in defines]
    more: list[str] = []
    if language in ("hlsl", "slang"):
        slangc = tools.program("slangc", "compiles Slang and HLSL to C++")
        (folder / "code.slang").write_text(text, encoding="utf-8")
        command = [slangc, "code.slang", "-target", "cpp", "-o", "code.cpp"]
        for p in folders:
            command += ["-I", p]
        _run([*command, *(f"-D{d}" for d in (*source.macros, *defines))], folder, source)
        options = []
    else:
        if language == "library":
            return "native", _linked(gxx, source, text, folder)
        (folder / "code.cpp").write_text(text, encoding="utf-8")
        kinds = {
            "cuda": ["-include", str(CUDA / "cuda_runtime.h"), f"-I{CUDA}"],
            "msl": ["-fsingle-precision-constant", "-Wno-attributes", "-x", "c++", f"-I{METAL}"],
            "osl": ["-include", str(OSL), "-fsingle-precision-constant"],
        }
        more = kinds.get(language, [])
        if language in ("cpp", "cuda"):  # members of classes are set, private ones too
            more = [*more, "-fno-access-control"]
        if source.path.suffix == ".c":  # C converts pointers that C++ does not
            more = ["-fpermissive"]
        more = [*more, "-Dmain=gonio_unused_main"]
    command = [gxx, *FLAGS, "-w", *more, *options, "code.cpp", "-o", "library.so"]
    _run(command, folder, source)
    return "native", folder / "library.so"


def _linked(gxx: str, source: Source, text: str, folder: Path) -> Path:
    """A library of calls into the user's compiled library: as C declares the function, or as C++ does."""
    library = source.path.resolve()
    options = [str(library), f"-Wl,-rpath,{library.parent}", "-Wl,--no-undefined"]
    said = ""
    for head in wrapper(source):
        (folder / "code.cpp").write_text(head + text, encoding="utf-8")
        command = [gxx, *FLAGS, "-w", "code.cpp", "-o", "library.so", *options]
        done = tools.run(command, folder)
        if done.returncode == 0:
            return folder / "library.so"
        said = said or done.stdout + done.stderr
    if "undefined reference" in said:
        raise ForeignError(
            f"{source.path} has no function {source.entry!r}; 'nm -D' shows what it has."
        )
    lines = [line for line in said.splitlines() if "error" in line] or ["no message"]
    raise ForeignError(f"{source.path} cannot be called so: {lines[0].strip()}")


def _run(command: Sequence[str], folder: Path, source: Source) -> None:
    done = tools.run(command, folder)
    if done.returncode != 0:
        raise _refused(source, done.stdout + done.stderr)


# What compilers write: g++ FILE:12:3:, slangc FILE(12) or, from 2026 on, --> FILE:12:3 below the message,
# Mesa 0:12(3), NVIDIA 0(12), naga wgsl:12:3.
_PLACES = (
    re.compile(r"^\s*(?P<file>[^\s:()]*?\.\w+|harness):(?P<line>\d+)(?::\d+)?:.*\berror\b"),
    re.compile(r"^\s*(?P<file>[^\s:()]*?\.\w+)\((?P<line>\d+)[^)]*\).*\berror\b"),
    re.compile(r"(?:^|ERROR:\s*)\d+:(?P<line>\d+)(?:\(\d+\))?:"),
    re.compile(r"^\d+\((?P<line>\d+)\)\s*:"),
    re.compile(r"wgsl:(?P<line>\d+):\d+"),
    re.compile(r"^\s*-+>\s*(?P<file>[^\s:()]*?\.\w+):(?P<line>\d+)(?::\d+)?\s*$"),
)


def _refused(source: Source, message: str) -> ForeignError:
    """The first complaint of a compiler, at the line of the user's file."""
    lines = [line for line in message.splitlines() if line.strip()]
    errors = [line for line in lines if re.search(r"\berror\b", line, re.I)] or lines
    # wgpu puts naga's sentence below its own
    errors = [line for line in errors if line.strip() != "Validation Error"] or errors
    # slangc says only below what is undefined
    below = next((m[1] for line in lines if (m := re.match(r"\s*\|\s*\^+\s*(.+)", line))), "")
    if below and errors[0].startswith("error["):
        errors = [f"error: {below}", *errors]
    if source.entry:
        said = (
            re.sub(r"^.*?\berror\b[^:]*:\s*", "", errors[0], flags=re.I) if errors else "no message"
        )
        return ForeignError(f"{source.path}: the generated code does not compile: {said.strip()}")
    for line in [*errors, *lines]:
        for pattern in _PLACES:
            if match := pattern.search(line):
                return ForeignError(_quoted(source, match, line, errors[0]))
    return ForeignError(
        f"{source.path} does not compile: {errors[0].strip() if errors else 'no message'}"
    )


def _quoted(source: Source, match: re.Match[str], line: str, first: str) -> str:
    groups = match.groupdict()
    number = int(groups["line"])
    path: Path | None = source.path
    k, counted = divmod(number, FILE_LINES)
    if k == OWN:
        path = None
    elif k:
        path, number = source.files[k], counted
    elif groups.get("file"):
        name = Path(groups["file"])
        if name.name in ("harness", "code.cpp"):
            path = None
        elif name.name != source.path.name:
            path = name
    said = re.sub(r"^.*?\berror\b[^:]*:\s*", "", first, flags=re.I).strip() or line.strip()
    if path is None and re.search(
        r"no matching function for call to .(?:\w+::)*(\w+)::\1\(\)", said
    ):
        return (
            f"{source.path}: the class has a constructor that wants arguments; write a function of the "
            "directions and parameters that makes one and calls it."
        )
    if path is None:
        return f"{source.path} does not take the arguments that were read from it: {said}"
    try:
        text = path.read_text(encoding="utf-8", errors="replace").splitlines()[number - 1].strip()
    except (OSError, IndexError):
        text = ""
    return f"{path}:{number}: {said}" + (f"  |  {text}" if text else "")
