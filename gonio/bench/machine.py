"""The machine that `gonio bench` ran on, in words."""

from __future__ import annotations

import datetime
import importlib.metadata
import os
import platform
import re
import subprocess
from pathlib import Path

import drjit as dr

from gonio.bench import native
from gonio.bench.kernels import launched


def describe() -> dict[str, str]:
    """Processor, threads, vector width, compilers, versions and the date."""
    return {
        "processor": _processor(),
        "cores": f"{_cores()}, of which Dr.Jit and the C++ baseline use {dr.thread_count()} threads",
        "vector width": f"{vector_width()} × float32",
        "system": f"{platform.system()} {platform.release()}, Python {platform.python_version()}",
        "C++": f"{_compiler()}, {' '.join(native.FLAGS)}",
        "Dr.Jit": f"{dr.__version__}, LLVM {'.'.join(map(str, dr.detail.llvm_version()))}",
        "Mitsuba": _version("mitsuba"),
        "load": _load(),
        "date": datetime.date.today().isoformat(),
    }


def vector_width() -> int:
    """How many float32 an LLVM kernel computes at a time, read from one."""
    Float = dr.llvm.Float

    def work() -> None:
        dr.eval(dr.opaque(Float, 1, 64) + dr.opaque(Float, 2, 64))

    widths = [
        int(width)
        for kernel in launched(work)
        for width in re.findall(r"<(\d+) x float>", kernel.ir)
    ]
    return max(widths, default=1)


def _processor() -> str:
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace")
    except OSError:
        text = ""
    fields = {
        name.strip(): value.strip()
        for name, _, value in (line.partition(":") for line in reversed(text.splitlines()))
    }
    if "model name" not in fields:
        return platform.processor() or platform.machine()
    numbers = [
        f"{name} {fields[name]}" for name in ("cpu family", "model", "stepping") if name in fields
    ]
    return f"{fields['model name']} ({', '.join(numbers)})" if numbers else fields["model name"]


def _cores() -> int:
    if hasattr(os, "sched_getaffinity"):  # not on macOS
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _load() -> str:
    if not hasattr(os, "getloadavg"):  # not on Windows
        return "unknown"
    load = os.getloadavg()[0]
    noisy = "; other processes were running, and the times are noisy" if load > 0.5 else ""
    return f"{load:.1f} in the minute before{noisy}"


def _compiler() -> str:
    done = subprocess.run(
        [*native._find_compiler(), "--version"], capture_output=True, text=True, check=False
    )
    return (done.stdout.splitlines() or ["unknown compiler"])[0]


def _version(package: str) -> str:
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return "not installed"
