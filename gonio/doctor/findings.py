"""Each thing that is looked at, in words: what is there, and what to do about what is missing."""

from __future__ import annotations

import importlib.metadata
import os
import platform
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gonio import backend


@dataclass(frozen=True)
class Finding:
    """One thing that was looked at."""

    name: str
    status: str
    """"ok", "absent" (optional and not there) or "broken" (models suffer from it)."""
    value: str
    advice: str = ""
    """What to do, one line; empty when there is nothing to do."""


def _version(distribution: str) -> str | None:
    try:
        return importlib.metadata.version(distribution)
    except importlib.metadata.PackageNotFoundError:
        return None


def package(name: str, distribution: str, install: str) -> Finding:
    """A package that gonio cannot do without."""
    version = _version(distribution)
    if version is None:
        return Finding(name, "broken", "not installed", f"run '{install}'")
    return Finding(name, "ok", version)


# The package of each extra of pyproject.toml that gonio itself uses, the extra, and what for.
OPTIONAL = {
    "PyTorch": ("torch", "torch", "for tensors in and out"),
    "JAX": ("jax", "jax", "for JAX arrays in and out"),
    "denoiser": ("mitsuba-oidn", "denoise", "for pictures with --denoise"),
    "notebooks": ("anywidget", "notebook", "for gonio.view.Viewer in a notebook"),
    "Dask": ("distributed", "cluster", "for work with --cluster"),
}


def optional(name: str) -> Finding:
    """A package of an extra."""
    distribution, extra, use = OPTIONAL[name]
    version = _version(distribution)
    if version is None:
        advice = f"optional, {use}: pip install 'gonio[{extra}]'"
        return Finding(name, "absent", "not installed", advice)
    return Finding(name, "ok", version)


def python() -> Finding:
    """The interpreter and the system."""
    return Finding("Python", "ok", f"{platform.python_version()} on {platform.platform()}")


def mitsuba(answer: dict[str, Any]) -> Finding:
    """Mitsuba, as its probe found it."""
    installed = _version("mitsuba")
    advice = "'gonio render' and the plug-ins need it: pip install --upgrade mitsuba"
    if installed is None:
        return Finding("Mitsuba", "absent", "not installed", advice)
    if "error" in answer:
        return Finding("Mitsuba", "broken", f"{installed}: {answer['error']}", advice)
    return Finding("Mitsuba", "ok", f"{answer['version']}, {len(answer['variants'])} variants")


def llvm(answer: dict[str, Any]) -> Finding:
    """Dr.Jit's LLVM, as its probe found it."""
    path = os.environ.get("DRJIT_LIBLLVM_PATH", "")
    if "error" in answer:
        reason, _, hint = answer["error"].partition(";")
        given = path and path != backend.NO_LLVM and not Path(path).exists()
        value = f"DRJIT_LIBLLVM_PATH={path} does not exist" if given else reason
        advice = f"unset it, or {backend.install_hint()}" if given else hint.strip()
        return Finding("LLVM", "broken", value, advice or backend.install_hint())
    return Finding("LLVM", "ok", f"{answer['version']}, {path}")


def vector_width(answer: dict[str, Any]) -> Finding:
    """How many numbers a compiled kernel computes at once."""
    width, cpu = answer.get("width"), answer.get("cpu")
    if width is None:
        return Finding("vector width", "absent", "unknown without LLVM")
    return Finding("vector width", "ok", f"{width} × float32" + (f" for {cpu}" if cpu else ""))


def threads(answer: dict[str, Any]) -> Finding:
    """How many threads kernels run on."""
    limited = getattr(os, "sched_getaffinity", None)  # not on macOS and Windows
    usable = len(limited(0)) if limited else os.cpu_count() or 1
    count = answer.get("threads")
    if count is None:
        return Finding("threads", "absent", f"none without LLVM; {usable} processors")
    return Finding("threads", "ok", f"{count} on {usable} processors")


def gpu(answer: dict[str, Any]) -> Finding:
    """The graphics card, and whether kernels run on it."""
    names = _nvidia_gpus()
    listing = "; ".join(names)
    if "error" in answer:
        advice = "update the NVIDIA driver, or use llvm: GONIO_BACKEND=llvm"
        return Finding("GPU", "broken", f"{listing or 'CUDA'}: {answer['error']}", advice)
    if "width" in answer:  # the kernel ran
        return Finding("GPU", "ok", listing or "CUDA works")
    if names:
        advice = "install or update the NVIDIA driver (libcuda.so must load)"
        return Finding("GPU", "broken", f"{listing}, but Dr.Jit cannot use it", advice)
    return Finding("GPU", "absent", "no NVIDIA GPU; models run on the processor")


def _nvidia_gpus() -> list[str]:
    program = shutil.which("nvidia-smi")
    if program is None:
        return []
    query = [program, "--query-gpu=name,driver_version", "--format=csv,noheader"]
    try:
        done = subprocess.run(query, capture_output=True, text=True, timeout=20, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return []
    if done.returncode != 0:
        return []
    rows = (line.split(", ") for line in done.stdout.strip().splitlines())
    return [f"{row[0]}, driver {row[-1]}" for row in rows]


def chosen_backend(answers: dict[str, dict[str, Any]]) -> Finding:
    """What computes models here."""
    answer = answers["cuda"]
    source = " (GONIO_BACKEND)" if os.environ.get("GONIO_BACKEND") else ""
    if "current_error" in answer:
        advice = f"unset GONIO_BACKEND, or set it to one of {', '.join(backend.BACKENDS)}"
        return Finding("backend", "broken", answer["current_error"], advice)
    works = [name for name in ("cuda", "llvm") if "width" in answers[name]]
    current = answer.get("current", works[0] if works else "scalar")
    slow = "scalar: one value after the other in plain Python, very slow"
    if not works:
        return Finding("backend", "broken", slow, backend.install_hint())
    if current == "scalar":
        advice = f"unset GONIO_BACKEND, or set it to {works[0]}"
        return Finding("backend", "absent", slow + source, advice)
    if current not in works:
        advice = f"set GONIO_BACKEND={works[0]}"
        return Finding("backend", "broken", f"{current}{source} does not run kernels", advice)
    return Finding("backend", "ok", f"{current}{source}")


def kernel_cache() -> Finding:
    """The folder in which Dr.Jit keeps compiled kernels, found as Dr.Jit finds it."""
    if given := os.environ.get("DRJIT_CACHE_DIR"):
        folder = Path(given)
    elif sys.platform == "win32":
        folder = Path(os.environ.get("LOCALAPPDATA", "")) / "Temp" / "drjit"
    elif home := os.environ.get("HOME"):
        folder = Path(home) / ".drjit"
    else:
        advice = "set HOME or DRJIT_CACHE_DIR; until then every start compiles again"
        return Finding("kernel cache", "absent", "off: HOME is not set", advice)
    if not folder.exists():
        return Finding("kernel cache", "ok", f"{folder}, not made yet")
    if not os.access(folder, os.W_OK | os.X_OK):
        advice = "make it writable, or set DRJIT_CACHE_DIR; until then every start compiles again"
        return Finding("kernel cache", "broken", f"{folder} is not writable", advice)
    sizes = [entry.stat().st_size for entry in os.scandir(folder) if entry.is_file()]
    return Finding(
        "kernel cache", "ok", f"{folder}, {len(sizes)} files, {sum(sizes) / 2**20:.1f} MiB"
    )


# Packages that compile and run exported shaders, and programs that do; what for, and what brings them
# stands beside the programs' use, in gonio.export.prove.tools.
PROVERS = {
    "glslangValidator": "GLSL and HLSL",
    "slangc": "Slang and HLSL",
    "wgpu": "WGSL",
    "moderngl": "GLSL",
    "bpy": "OSL",
    "nvrtc": "CUDA",
    "spirv-opt": "counting instructions",
    "vulkan": "what shaders cost on AMD's GPUs",
}


def prover(name: str) -> Finding:
    """A compiler or runtime of exported shaders."""
    from gonio.export.prove import tools

    found = tools.locate(name)
    if found is None:
        advice = f"only 'gonio export --prove' needs it, for {PROVERS[name]}: {tools.INSTALL[name]}"
        return Finding(name, "absent", "not installed", advice)
    return Finding(name, "ok", _version(name) or found)


def compiler() -> Finding:
    """The compiler of exported C++."""
    program = shutil.which("g++")
    if program is None:
        from gonio.export.prove.tools import INSTALL

        advice = f"only 'gonio bench' and 'gonio export --prove' need it: {INSTALL['g++']}"
        return Finding("g++", "absent", "not installed", advice)
    done = subprocess.run(
        [program, "-dumpfullversion"], capture_output=True, text=True, timeout=20, check=False
    )
    return Finding("g++", "ok", f"{done.stdout.strip() or 'unknown version'}, {program}")
