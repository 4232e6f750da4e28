"""The C++ baseline of `gonio bench`: compiles baseline.cpp and calls it.

It knows nothing of the models: the rows (a name, what is timed, and how many parameters it takes) are
read from the library.
"""

import ctypes
import hashlib
import os
import shlex
import shutil
import statistics
import subprocess
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import cast

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float32]
Directions = tuple[Floats, Floats, Floats]
"""x, y and z of n unit vectors: local frame, z > 0, one contiguous float32 array each."""

SOURCE = Path(__file__).with_name("baseline.cpp")
# No -ffast-math: gonio keeps IEEE semantics too.
FLAGS = ("-std=c++17", "-O3", "-march=native", "-fPIC", "-shared", "-pthread")

EVAL_BYTES = 9 * 4
"""Memory moved per pair by `Baseline.eval`: reads wi and wo, writes RGB (lambert reads nothing)."""
SAMPLE_BYTES = 12 * 4
"""Memory moved per pair by `Baseline.sample_pdf_eval`: reads wo, u1, u2, writes wi, pdf, RGB."""

# 128 MiB per array: three of them are several times the cache of a desktop or of rented cores.
TRIAD_FLOATS = 1 << 25


@dataclass(frozen=True)
class Timed:
    """What one row of the baseline computed, and how long that took."""

    seconds: float  # median of the repeats, one call over all pairs
    value: Floats  # (3, n): RGB of the BRDF in 1/sr, without the cosine


@dataclass(frozen=True)
class TimedSamples(Timed):
    """`Timed` for sample + pdf + eval."""

    wi: Floats  # (3, n): the sampled directions
    pdf: Floats  # (n,): their density in 1/sr


class Baseline:
    """The compiled baseline: `eval_names` and `sample_names` are its rows."""

    def __init__(self, library: Path) -> None:
        """Load what `compile_baseline` compiled; call that instead."""
        self.library = library
        self._c = ctypes.CDLL(str(library))
        self._c.baseline_name.restype = ctypes.c_char_p
        self._c.baseline_run.restype = ctypes.c_double
        self._c.baseline_bandwidth.restype = ctypes.c_double
        self._eval_rows: dict[str, int] = {}
        self._sample_rows: dict[str, int] = {}
        row = 0
        while (name := self._c.baseline_name(row)) is not None:
            rows = self._sample_rows if self._c.baseline_samples(row) else self._eval_rows
            rows[name.decode()] = row
            row += 1

    @property
    def eval_names(self) -> tuple[str, ...]:
        """Names that `eval` takes."""
        return tuple(self._eval_rows)

    @property
    def sample_names(self) -> tuple[str, ...]:
        """Names that `sample_pdf_eval` takes."""
        return tuple(self._sample_rows)

    def eval(
        self,
        name: str,
        wi: Directions,
        wo: Directions,
        parameters: Sequence[float],
        *,
        threads: int = 1,
        repeat: int = 5,
        inlined: bool = False,
    ) -> Timed:
        """Evaluate model `name` for every pair, `repeat` times after one call that is not timed.

        `parameters` are the model's numbers in the order in which it declares them, three for a
        colour, those of inner models after its own. `inlined` lets the compiler fuse model and loop
        and vectorise; without it every pair is one call, as in a renderer.
        """
        row = _find(name, self._eval_rows)
        seconds, out = self._run(row, parameters, (*wi, *wo), 3, threads, repeat, inlined)
        return Timed(seconds, out)

    def sample_pdf_eval(
        self,
        name: str,
        wo: Directions,
        u1: Floats,
        u2: Floats,
        parameters: Sequence[float],
        *,
        threads: int = 1,
        repeat: int = 5,
        inlined: bool = False,
    ) -> TimedSamples:
        """Sample wi, its density and the value there for every (wo, u1, u2); else as `eval`."""
        row = _find(name, self._sample_rows)
        seconds, out = self._run(row, parameters, (*wo, u1, u2), 7, threads, repeat, inlined)
        return TimedSamples(seconds, value=out[4:], wi=out[:3], pdf=out[3])

    def bandwidth(self, threads: int = 1, repeat: int = 5) -> float:
        """Bytes per second read and written by STREAM's triad, best of `repeat`."""
        _check_counts(threads, repeat)
        n = ctypes.c_size_t(TRIAD_FLOATS)
        return cast(float, self._c.baseline_bandwidth(n, ctypes.c_int(threads), repeat))

    def _run(
        self,
        row: int,
        parameters: Sequence[float],
        inputs: Sequence[Floats],
        outputs: int,
        threads: int,
        repeat: int,
        inlined: bool,
    ) -> tuple[float, Floats]:
        _check_counts(threads, repeat)
        wanted = self._c.baseline_parameters(row)
        if len(parameters) != wanted:
            name = self._c.baseline_name(row).decode()
            raise ValueError(f"{name} takes {wanted} parameters, given {len(parameters)}")
        n = _common_length(inputs)
        out = np.empty((outputs, n), np.float32)
        c_parameters = (ctypes.c_float * len(parameters))(*parameters)
        c_inputs, c_outputs = pointers(inputs), pointers(list(out))

        def once() -> float:
            seconds = self._c.baseline_run(
                ctypes.c_int(row),
                ctypes.c_int(inlined),
                c_parameters,
                c_inputs,
                c_outputs,
                ctypes.c_size_t(n),
                ctypes.c_int(threads),
            )
            return cast(float, seconds)

        once()  # touches the pages of `out`
        return statistics.median(once() for _ in range(repeat)), out


@cache
def compile_baseline() -> Baseline:
    """Compile the baseline, or load what an earlier call with this source and machine left."""
    return Baseline(compiled_library(SOURCE, FLAGS, "baseline"))


def compiled_library(source: Path, flags: Sequence[str], name: str) -> Path:
    """A library made of one C++ file, or what an earlier call with this text and machine left.

    Raises:
        RuntimeError: there is no compiler, or it refuses the file.
    """
    command = [*_find_compiler(), *flags]
    # The predefined macros hold the compiler's version and, by -march=native, the CPU's features.
    macros = _compile([*command, "-dM", "-E", "-x", "c++", os.devnull])
    key = hashlib.sha256(b"\0".join([source.read_bytes(), shlex.join(command).encode(), macros]))
    library = _cache_folder() / f"{name}-{key.hexdigest()[:20]}.so"
    if not library.exists():
        library.parent.mkdir(parents=True, exist_ok=True)
        # Compiled elsewhere and renamed, so that no other process loads half a file.
        with tempfile.TemporaryDirectory(dir=library.parent) as folder:
            unfinished = Path(folder) / library.name
            _compile([*command, str(source), "-o", str(unfinished)])
            unfinished.replace(library)
    return library


def _find_compiler() -> list[str]:
    chosen = os.environ.get("CXX")
    if chosen:
        command = shlex.split(chosen)
        if shutil.which(command[0]) is None:
            raise RuntimeError(
                f"no C++ compiler {command[0]!r}, which CXX names; correct or unset it"
            )
        return command
    for name in ("g++", "c++", "clang++"):
        if shutil.which(name) is not None:
            return [name]
    raise RuntimeError(
        "no C++ compiler for the baseline; install one (Debian, Ubuntu: apt-get install g++; "
        "Fedora: dnf install gcc-c++; macOS: xcode-select --install) or name it in CXX"
    )


def _compile(command: list[str]) -> bytes:
    """Standard output of the compiler; RuntimeError with its first error if it fails."""
    done = subprocess.run(command, capture_output=True, check=False)
    if done.returncode != 0:
        lines = done.stderr.decode(errors="replace").splitlines()
        first_error = next((line for line in lines if "error" in line), "no message")
        raise RuntimeError(f"{shlex.join(command)} failed: {first_error}")
    return done.stdout


def _cache_folder() -> Path:
    """Per user, as the XDG base directory specification has it."""
    root = os.environ.get("XDG_CACHE_HOME")
    return (Path(root) if root else Path.home() / ".cache") / "gonio"


def _find(name: str, rows: dict[str, int]) -> int:
    if name not in rows:
        raise ValueError(f"no row {name!r} in the baseline; it has {', '.join(rows)}")
    return rows[name]


def _check_counts(threads: int, repeat: int) -> None:
    if threads < 1 or repeat < 1:
        raise ValueError(f"threads={threads}, repeat={repeat}: both must be at least 1")


def _common_length(arrays: Sequence[Floats]) -> int:
    """Length of the arrays; ValueError unless all are 1-D, contiguous, float32 and equally long."""
    n = arrays[0].size
    for array in arrays:
        if array.dtype != np.float32 or array.shape != (n,) or not array.flags.c_contiguous:
            raise ValueError(
                f"the baseline takes contiguous float32 arrays of one length, here ({n},); "
                f"given {array.dtype} {array.shape}; see numpy.ascontiguousarray"
            )
    return n


def pointers(arrays: Sequence[Floats]) -> "ctypes.Array[ctypes.c_void_p]":
    """Addresses of the arrays, for C; they must live on."""
    return (ctypes.c_void_p * len(arrays))(*(array.ctypes.data for array in arrays))
