"""Finds an LLVM that works and chooses where models are computed: llvm, cuda or scalar.

This is the only file that knows about LLVM and about Dr.Jit's backends. `prepare` has to run before
Dr.Jit is imported for the first time, because Dr.Jit reads `DRJIT_LIBLLVM_PATH` only then.
"""

from __future__ import annotations

import ctypes
import functools
import importlib.metadata
import os
import platform
import re
import sys
import warnings
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

BACKENDS = ("llvm", "cuda", "scalar")

# Dr.Jit refuses LLVM 14 and older; 15 aborts the process ("Cannot select: fmaximum").
LLVM_MINIMUM = 16

# Dr.Jit looks for a system LLVM of any version when the variable is unset. A name that cannot
# exist stops it from loading one that would abort the process.
NO_LLVM = "gonio-found-no-usable-llvm"

_chosen: str | None = None
_refused: str | None = None
"""Why the LLVM that the user named was not taken."""
_validate = True


class BackendError(RuntimeError):
    """A backend is not available on this machine; the message says what to install."""


def prepare() -> None:
    """Point Dr.Jit at a usable LLVM, unless the user already did or Dr.Jit is already loaded.

    An LLVM of the user's that would end the process is not taken; `missing_llvm_reason` tells.
    """
    if "drjit" in sys.modules:
        return
    global _refused
    given = os.environ.get("DRJIT_LIBLLVM_PATH")
    if given and given != NO_LLVM:
        version = llvm_version(Path(given))
        if version is not None and version < LLVM_MINIMUM:
            _refused = (
                f"DRJIT_LIBLLVM_PATH={given} is LLVM {version}; {LLVM_MINIMUM} or newer is needed. "
                f"Unset it, or {install_hint()}"
            )
            os.environ["DRJIT_LIBLLVM_PATH"] = NO_LLVM
        return
    os.environ["DRJIT_LIBLLVM_PATH"] = str(next(usable_llvm(), NO_LLVM))


def usable_llvm() -> Iterator[Path]:
    """Yield shared libraries of LLVM 16 or newer: the wheel's first, then the system's, newest first."""
    yield from _wheel_llvm()
    found = []
    for folder in _system_folders():
        for path in folder.glob("libLLVM*"):
            version = llvm_version(path) if ".so" in path.name or path.suffix == ".dylib" else None
            if version is not None and version >= LLVM_MINIMUM:
                found.append((version, path))
    yield from (path for _, path in sorted(found, reverse=True))


def _wheel_llvm() -> Iterator[Path]:
    try:
        files = importlib.metadata.distribution("karellen-llvm-core").files or []
    except importlib.metadata.PackageNotFoundError:
        return
    for file in files:
        if re.fullmatch(r"libLLVM\.so\.[\d.]+", file.name):
            path = Path(str(file.locate())).resolve()
            if path.exists():
                yield path


def _system_folders() -> Iterator[Path]:
    patterns = (
        "/usr/lib/*-linux-gnu",
        "/usr/lib/llvm-*/lib",
        "/usr/lib64",
        "/usr/lib",
        "/usr/local/lib",
        "/opt/homebrew/opt/llvm*/lib",
        "/usr/local/opt/llvm*/lib",
    )
    for pattern in patterns:
        yield from sorted(Path("/").glob(pattern.lstrip("/")))


def llvm_version(path: Path) -> int | None:
    """Major version of an LLVM library from its (resolved) file name; None when it does not say.

    The name is read instead of the library, because loading two LLVMs into one process can end it.
    """
    for name in (path.resolve().name, path.name):
        if match := re.search(r"LLVM(?:-C)?(?:[-.](?:so\.|dylib\.)?)(\d+)", name):
            return int(match[1])
    return None


def install_hint() -> str:
    """One line that says how to get a usable LLVM on this platform."""
    if sys.platform == "darwin":
        return "install LLVM with 'brew install llvm'."
    if sys.platform == "win32":
        return (
            "install LLVM 16 or newer from llvm.org and set DRJIT_LIBLLVM_PATH to its LLVM-C.dll."
        )
    if platform.machine() == "x86_64":
        return (
            "run 'pip install karellen-llvm-core' (it also needs the system's libatomic1: "
            "'apt-get install libatomic1')."
        )
    return "install LLVM 16 or newer, for example 'apt-get install libllvm19'."


def missing_llvm_reason() -> str:
    """Why the LLVM backend is missing, and what to do, in one line."""
    path = os.environ.get("DRJIT_LIBLLVM_PATH", "")
    if _refused:
        return _refused
    if path and path != NO_LLVM and not Path(path).exists():
        return f"DRJIT_LIBLLVM_PATH={path} does not exist. Unset it, or {install_hint()}"
    if path and path != NO_LLVM:
        try:
            ctypes.CDLL(path)
        except OSError as error:
            return f"LLVM was found but does not load ({error}); {install_hint()}"
        return (
            "Dr.Jit was imported before gonio and looked for LLVM alone; import gonio first, or "
            f"set DRJIT_LIBLLVM_PATH={path} before starting Python."
        )
    return f"No LLVM {LLVM_MINIMUM} or newer was found; {install_hint()}"


def available(backend: str) -> bool:
    """Whether `backend` ("llvm", "cuda" or "scalar") can compute on this machine. Never raises."""
    if backend == "scalar":
        return True
    import drjit as dr

    # Asking is safe; creating an array without the backend would end the process.
    if backend == "cuda":
        return bool(dr.has_backend(dr.JitBackend.CUDA))
    # Dr.Jit, imported before gonio, may have taken an LLVM that cannot compile its kernels.
    usable = dr.detail.llvm_version()[0] >= LLVM_MINIMUM
    return usable and bool(dr.has_backend(dr.JitBackend.LLVM))


def use(backend: str | None = None, *, validate: bool | None = None) -> None:
    """Choose where NumPy, PyTorch-CPU and JAX arrays are computed, and whether arrays are checked.

    Args:
        backend: "llvm" (all cores, SIMD), "cuda" (NVIDIA GPU) or "scalar" (plain Python; slow, always
            works). The environment variable GONIO_BACKEND does the same. Without either: cuda when
            there is a GPU, else llvm, else scalar.
        validate: False turns off the checks of array values (range, unit length, NaN) for speed;
            shapes and Python numbers are always checked.

    Raises:
        ValueError: an unknown name.
        BackendError: the backend is not available here; the message says what to install.
    """
    global _chosen, _validate
    if backend is not None:
        _require(backend, "use()")
        _chosen = backend
    if validate is not None:
        _validate = validate


def _require(backend: str, source: str) -> None:
    if backend not in BACKENDS:
        raise ValueError(f"{source} got {backend!r}; allowed are {', '.join(BACKENDS)}.")
    if not available(backend):
        if backend == "cuda":
            raise BackendError(
                f"{source} asked for cuda, but there is no NVIDIA GPU with a driver here; use 'llvm'."
            )
        raise BackendError(f"{source} asked for llvm. {missing_llvm_reason()}")


def validating() -> bool:
    """Whether values of arrays are checked (see `use`)."""
    return _validate


def current() -> str:
    """The backend in force: the one given to `use`, else GONIO_BACKEND, else the best there is."""
    if _chosen is not None:
        return _chosen
    if named := os.environ.get("GONIO_BACKEND"):
        _require(named, "GONIO_BACKEND")
        return named
    for backend in ("cuda", "llvm"):
        if available(backend):
            return backend
    _warn_scalar()
    return "scalar"


@functools.cache
def _warn_scalar() -> None:
    """Say once why everything is slow."""
    warnings.warn(
        f"computing in plain Python, which is slow: {missing_llvm_reason()}",
        RuntimeWarning,
        stacklevel=4,
    )


def array_module(backend: str | None = None) -> ModuleType:
    """The Dr.Jit module with the array types of a backend: differentiable ones, except for scalar."""
    import drjit as dr

    modules: dict[str, Any] = {
        "llvm": lambda: dr.llvm.ad,
        "cuda": lambda: dr.cuda.ad,
        "scalar": lambda: dr.scalar,
    }
    module: ModuleType = modules[backend or current()]()
    return module


def mitsuba_variant(kind: str = "rgb") -> str:
    """Name of the Mitsuba variant that fits the backend in force, such as "llvm_ad_rgb"."""
    backend = current()
    return f"scalar_{kind}" if backend == "scalar" else f"{backend}_ad_{kind}"
