"""What shaders cost on AMD's GPUs: Mesa's driver compiles for hardware that is not there.

The driver is RADV, with its compiler ACO, as games on Linux use it. Its cycles are a static estimate of the
machine code, as were those in Elek's Table 1 (2010): comparable as ratios.
"""

from __future__ import annotations

import json
import os
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from gonio.cost.gpus import GPUS, Gpu
from gonio.cost.measured import Measured
from gonio.cost.program import Program
from gonio.export.prove import tools
from gonio.export.prove.tools import ProofError

PLACES = ("/usr/share/vulkan/icd.d", "/usr/local/share/vulkan/icd.d", "/etc/vulkan/icd.d")
"""Where drivers of Vulkan say that they are there."""


def driver() -> Path:
    """The description of AMD's driver.

    Raises:
        ProofError: it is not installed.
    """
    for place in PLACES:
        for file in sorted(Path(place).glob("radeon_icd*.json")):
            return file
    raise ProofError(
        f"RADV is not installed, which compiles for AMD's GPUs; {tools.INSTALL['radv']}."
    )


def measure(programs: Sequence[Program], gpu: Gpu) -> list[Measured]:
    """Compile each program's compute shader to machine code.

    Raises:
        ProofError: the driver or a compiler is missing, or refuses a shader.
    """
    return [_read(statistics) for statistics in _compiled(programs, gpu)["shaders"]]


def version() -> str:
    """Of the driver, such as "22.3.6".

    Raises:
        ProofError: the driver is missing.
    """
    return str(_compiled([], GPUS["navi21"])["driver"])


def _compiled(programs: Sequence[Program], gpu: Gpu) -> dict[str, Any]:
    """What the driver says of all programs, from one process for all of them."""
    file = driver()
    tools.program("vulkan", "asks AMD's driver")
    with tempfile.TemporaryDirectory(prefix="gonio-") as name:
        folder = Path(name)
        for k, program in enumerate(programs):
            (folder / f"{k}.spv").write_bytes(program.spirv())
        bindings = [list(program.bindings) for program in programs]
        (folder / "job.json").write_text(json.dumps({"bindings": bindings}), encoding="utf-8")
        script = str(Path(__file__).with_name("_amd_worker.py"))
        environment = {
            **os.environ,
            "VK_ICD_FILENAMES": str(file),
            "VK_DRIVER_FILES": str(file),
            "NODEVICE_SELECT": "1",
            "MESA_SHADER_CACHE_DISABLE": "true",
            "XDG_RUNTIME_DIR": os.environ.get("XDG_RUNTIME_DIR", name),
        }
        seconds = tools.SECONDS + tools.SECONDS_PER_JOB * len(programs)
        command = [sys.executable, "-P", script, name]
        for family in filter(None, (gpu.name, gpu.older)):
            environment["RADV_FORCE_FAMILY"] = family
            done = tools.run(command, folder, seconds, environment)
            if "Unknown family" not in done.stderr:
                break
        if done.returncode != 0:
            reason = (done.stderr.strip() or f"signal {-done.returncode}").splitlines()[-1]
            raise ProofError(f"RADV does not compile for {gpu.name} here: {reason}")
        found: dict[str, Any] = json.loads((folder / "statistics.json").read_text(encoding="utf-8"))
    return found


def _read(statistics: dict[str, int]) -> Measured:
    return Measured(
        instructions=statistics["Instructions"],
        registers=statistics["VGPRs"],
        cycles=statistics.get("Inverse Throughput"),
        latency=statistics.get("Latency"),
    )
