"""What may end a process, tried in one of its own: an LLVM that does not fit, a broken GPU driver.

Each probe answers with plain data, which `gonio.doctor.findings` puts into words.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
from typing import Any

from gonio import backend

# A first start reads libLLVM from a cold disk and compiles; the machine may be busy.
PROBE_SECONDS = 120


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
    found: dict[str, Any] = {}
    try:
        found["current"] = backend.current()
    except (ValueError, backend.BackendError) as error:
        found["current_error"] = str(error)
    if backend.available("cuda"):
        found |= _compile("cuda")
    return found


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


PROBES = {"llvm": _probe_llvm, "cuda": _probe_cuda, "mitsuba": _probe_mitsuba}


def start(name: str) -> subprocess.Popen[str] | Exception:
    """Begin a probe in a process of its own; the error where none can be started."""
    # The same search path as here, whatever the working folder holds.
    code = (
        f"import json, sys; sys.path[:] = {sys.path!r}\n"
        f"from gonio.doctor import probes\n"
        f"print('\\n' + json.dumps(probes.PROBES[{name!r}]()))"
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


def answer(process: subprocess.Popen[str] | Exception) -> dict[str, Any]:
    """What a probe found, or "error" with the reason why it found nothing."""
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
        found: dict[str, Any] = json.loads(out.strip().rpartition("\n")[2])
    except ValueError:
        return {"error": err.strip().rpartition("\n")[2] or f"exit code {process.returncode}"}
    return found
