"""What gonio finds on this machine, and what to do about what is missing: `gonio doctor`.

    for finding in gonio.cli.doctor.diagnose():
        print(finding.status, finding.name, finding.value)

Everything that might end a process (an LLVM that does not fit, a broken GPU driver) is tried in
processes of its own, so that looking never crashes.
"""

from __future__ import annotations

import dataclasses
import functools
import importlib.metadata
import json
import os
import platform
import re
import shutil
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

from gonio import backend
from gonio.cli.program import echo_json, json_option
from gonio.version import __version__

SYMBOLS = {"ok": "✓", "absent": "–", "broken": "✗"}

# A first start reads libLLVM from a cold disk and compiles; the machine may be busy.
PROBE_SECONDS = 120


@dataclass(frozen=True)
class Finding:
    """One thing that was looked at."""

    name: str
    status: str
    """"ok", "absent" (optional and not there) or "broken" (models suffer from it)."""
    value: str
    advice: str = ""
    """What to do, one line; empty when there is nothing to do."""


def diagnose() -> list[Finding]:
    """Look at versions, backends, GPU, kernel cache and optional packages. Never raises.

    Takes about two seconds: every backend compiles and runs a small kernel in its own process.
    """
    probes = {name: _start(name) for name in _PROBES}
    answers = {name: _answer(process) for name, process in probes.items()}
    checks: list[tuple[str, Any]] = [
        ("Python", _python),
        ("gonio", lambda: Finding("gonio", "ok", __version__)),
        ("Dr.Jit", lambda: _package("Dr.Jit", "drjit", "pip install drjit")),
        ("NumPy", lambda: _package("NumPy", "numpy", "pip install numpy")),
        ("Mitsuba", lambda: _mitsuba(answers["mitsuba"])),
        ("LLVM", lambda: _llvm(answers["llvm"])),
        ("vector width", lambda: _vector_width(answers["llvm"])),
        ("threads", lambda: _threads(answers["llvm"])),
        ("GPU", lambda: _gpu(answers["cuda"])),
        ("backend", lambda: _backend(answers)),
        ("kernel cache", _kernel_cache),
        *((name, functools.partial(_optional, name)) for name in _OPTIONAL),
        ("g++", _compiler),
        *((name, functools.partial(_prover, name)) for name in _PROVERS),
    ]
    return [_guarded(name, check) for name, check in checks]


def can_compute(findings: Sequence[Finding]) -> bool:
    """Whether a compiled backend (llvm or cuda) computes models here, and not plain Python."""
    return any(f.name == "backend" and f.status != "broken" for f in findings)


def report(findings: Sequence[Finding]) -> str:
    """The findings as lines of text: a mark, a name, a value, and what to do."""
    width = max((len(f.name) for f in findings), default=0)
    lines = []
    for f in findings:
        lines.append(f"{SYMBOLS[f.status]} {f.name:<{width}}  {f.value}")
        if f.advice:
            lines.append(f"  {'':<{width}}  → {f.advice}")
    return "\n".join(lines)


def _guarded(name: str, check: Any) -> Finding:
    try:
        found: Finding = check()
    except Exception as error:  # a doctor that crashes helps nobody
        return Finding(name, "broken", f"could not be found out: {type(error).__name__}: {error}")
    return found


# ---------------------------------------------------------------- probes, each in its own process


def _probe_llvm() -> dict[str, Any]:
    import drjit as dr

    if not backend.available("llvm"):
        return {"error": backend.missing_llvm_reason()}
    return {
        "version": ".".join(map(str, dr.detail.llvm_version())),
        "threads": dr.thread_count(),
        **_compile("llvm"),
    }


def _probe_cuda() -> dict[str, Any]:
    answer: dict[str, Any] = {}
    try:
        answer["current"] = backend.current()
    except (ValueError, backend.BackendError) as error:
        answer["current_error"] = str(error)
    if backend.available("cuda"):
        answer |= _compile("cuda")
    return answer


def _probe_mitsuba() -> dict[str, Any]:
    import mitsuba as mi

    return {"version": mi.__version__, "variants": list(mi.variants())}


def _compile(name: str) -> dict[str, Any]:
    """Compile and run a kernel; its text says how wide the vectors are."""
    import drjit as dr

    module: Any = backend.array_module(name)
    with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
        total = dr.sum(dr.fma(module.Float([1.0, 2.0, 3.0]), 2.0, 1.0))
        if float(total[0]) != 15:
            return {"error": f"1 + 2 x summed over 1, 2, 3 gives {total[0]}, not 15"}
        texts = [entry["ir"].getvalue() for entry in dr.kernel_history() if "ir" in entry]
    widths = [int(n) for text in texts for n in re.findall(r"<(\d+) x float>", text)]
    targets = [t for text in texts for t in re.findall(r'"target-cpu"="([^"]+)"', text)]
    return {"width": max(widths, default=None), "cpu": targets[0] if targets else None}


_PROBES = {"llvm": _probe_llvm, "cuda": _probe_cuda, "mitsuba": _probe_mitsuba}


def _start(name: str) -> subprocess.Popen[str] | Exception:
    # The same search path as here, whatever the working folder holds.
    code = (
        f"import json, sys; sys.path[:] = {sys.path!r}\n"
        f"from gonio.cli import doctor\n"
        f"print('\\n' + json.dumps(doctor._PROBES[{name!r}]()))"
    )
    try:
        return subprocess.Popen(
            [sys.executable, "-c", code],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            errors="replace",
        )
    except OSError as error:
        return error


def _answer(process: subprocess.Popen[str] | Exception) -> dict[str, Any]:
    if isinstance(process, Exception):
        return {"error": f"no process could be started: {process}"}
    try:
        out, err = process.communicate(timeout=PROBE_SECONDS)
    except subprocess.TimeoutExpired:
        process.kill()
        process.communicate()
        return {"error": f"no answer within {PROBE_SECONDS} s"}
    if process.returncode < 0:
        return {"error": f"the process was ended by signal {-process.returncode}"}
    try:
        answer: dict[str, Any] = json.loads(out.strip().rpartition("\n")[2])
    except ValueError:
        return {"error": err.strip().rpartition("\n")[2] or f"exit code {process.returncode}"}
    return answer


# ------------------------------------------------------------------------------------ the findings


def _version(distribution: str) -> str | None:
    try:
        return importlib.metadata.version(distribution)
    except importlib.metadata.PackageNotFoundError:
        return None


def _package(name: str, distribution: str, install: str) -> Finding:
    version = _version(distribution)
    if version is None:
        return Finding(name, "broken", "not installed", f"run '{install}'")
    return Finding(name, "ok", version)


# The package of each extra of pyproject.toml that gonio itself uses, the extra, and what for.
_OPTIONAL = {
    "PyTorch": ("torch", "torch", "for tensors in and out"),
    "JAX": ("jax", "jax", "for JAX arrays in and out"),
    "denoiser": ("mitsuba-oidn", "denoise", "for pictures with --denoise"),
    "notebooks": ("anywidget", "notebook", "for gonio.view.Viewer in a notebook"),
    "Dask": ("distributed", "cluster", "for work with --cluster"),
}


def _optional(name: str) -> Finding:
    distribution, extra, use = _OPTIONAL[name]
    version = _version(distribution)
    if version is None:
        advice = f"optional, {use}: pip install 'gonio[{extra}]'"
        return Finding(name, "absent", "not installed", advice)
    return Finding(name, "ok", version)


def _python() -> Finding:
    return Finding("Python", "ok", f"{platform.python_version()} on {platform.platform()}")


def _mitsuba(answer: dict[str, Any]) -> Finding:
    installed = _version("mitsuba")
    advice = "'gonio render' and the plug-ins need it: pip install --upgrade mitsuba"
    if installed is None:
        return Finding("Mitsuba", "absent", "not installed", advice)
    if "error" in answer:
        return Finding("Mitsuba", "broken", f"{installed}: {answer['error']}", advice)
    return Finding("Mitsuba", "ok", f"{answer['version']}, {len(answer['variants'])} variants")


def _llvm(answer: dict[str, Any]) -> Finding:
    path = os.environ.get("DRJIT_LIBLLVM_PATH", "")
    if "error" in answer:
        reason, _, hint = answer["error"].partition(";")
        given = path and path != backend.NO_LLVM and not Path(path).exists()
        value = f"DRJIT_LIBLLVM_PATH={path} does not exist" if given else reason
        advice = f"unset it, or {backend.install_hint()}" if given else hint.strip()
        return Finding("LLVM", "broken", value, advice or backend.install_hint())
    return Finding("LLVM", "ok", f"{answer['version']}, {path}")


def _vector_width(answer: dict[str, Any]) -> Finding:
    width, cpu = answer.get("width"), answer.get("cpu")
    if width is None:
        return Finding("vector width", "absent", "unknown without LLVM")
    return Finding("vector width", "ok", f"{width} × float32" + (f" for {cpu}" if cpu else ""))


def _threads(answer: dict[str, Any]) -> Finding:
    limited = getattr(os, "sched_getaffinity", None)  # not on macOS and Windows
    usable = len(limited(0)) if limited else os.cpu_count() or 1
    threads = answer.get("threads")
    if threads is None:
        return Finding("threads", "absent", f"none without LLVM; {usable} processors")
    return Finding("threads", "ok", f"{threads} on {usable} processors")


def _gpu(answer: dict[str, Any]) -> Finding:
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


def _backend(answers: dict[str, dict[str, Any]]) -> Finding:
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


def _kernel_cache() -> Finding:
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
_PROVERS = {
    "glslangValidator": "GLSL and HLSL",
    "slangc": "Slang and HLSL",
    "wgpu": "WGSL",
    "moderngl": "GLSL",
    "bpy": "OSL",
    "nvrtc": "CUDA",
    "spirv-opt": "counting instructions",
    "vulkan": "what shaders cost on AMD's GPUs",
}


def _prover(name: str) -> Finding:
    from gonio.export.prove import tools

    found = tools.locate(name)
    if found is None:
        advice = (
            f"only 'gonio export --prove' needs it, for {_PROVERS[name]}: {tools.INSTALL[name]}"
        )
        return Finding(name, "absent", "not installed", advice)
    return Finding(name, "ok", _version(name) or found)


def _compiler() -> Finding:
    program = shutil.which("g++")
    if program is None:
        from gonio.export.prove.tools import INSTALL

        advice = f"only 'gonio bench' and 'gonio export --prove' need it: {INSTALL['g++']}"
        return Finding("g++", "absent", "not installed", advice)
    done = subprocess.run(
        [program, "-dumpfullversion"], capture_output=True, text=True, timeout=20, check=False
    )
    return Finding("g++", "ok", f"{done.stdout.strip() or 'unknown version'}, {program}")


@click.command("doctor", short_help="Show whether this machine can run models.")
@json_option
def command(as_json: bool) -> int:
    """Show what was found on this machine, and what to do about what is missing.

    Ends with exit code 1 when models cannot be computed by a compiled backend.

    \b
    Examples:
      gonio doctor
      gonio doctor --json > machine.json
    """
    findings = diagnose()
    if as_json:
        echo_json([dataclasses.asdict(f) for f in findings])
    else:
        click.echo(report(findings))
    return 0 if can_compute(findings) else 1
