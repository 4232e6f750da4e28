"""The process that foreign code runs in, with limits of time and memory."""

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

from gonio.foreign.complaints import refused
from gonio.foreign.harness import OUTPUTS
from gonio.foreign.loops import COUNTING, CUT, TURNS
from gonio.foreign.source import ForeignError, Source
from gonio.foreign.textures import write as write_textures

Singles = NDArray[np.float32]

# Bytes that foreign code may use: a driver on the processor takes most of one gigabyte for itself.
MEMORY = 4 << 30

# Seconds for a call: the first ones are of a few rows, and others of up to a quarter of a million.
SECONDS = 20.0
ROWS = 1 << 18

# Seconds in which the process has to be there, with its shader compiled.
START = 120.0


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
            # Most commands ask only whether a name is one of code; compilers bring all of gonio.export
            from gonio.foreign.compiling import compiled

            kind, file = compiled(source, text, folder, include, defines)
            self._command = [sys.executable, "-P", str(Path(__file__).with_name("_worker.py"))]
            self._command += [kind, str(file), str(columns), str(memory)]
            self._text = text
            self.device = ""
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
                raise refused(self.source, message)
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
            return str(refused(self.source, last))
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
