"""The compilers that `gonio cost` used, in words."""

from __future__ import annotations

import datetime
import importlib.metadata
import subprocess
from collections.abc import Sequence

from gonio.cost import amd
from gonio.cost.gpus import Gpu
from gonio.export.prove import tools


def describe(gpus: Sequence[Gpu]) -> dict[str, str]:
    """Compilers with their versions, the GPUs, and the date.

    Raises:
        ProofError: a compiler that one of the GPUs needs is missing.
    """
    found = {}
    vendors = {gpu.vendor for gpu in gpus}
    if "amd" in vendors:
        found["AMD"] = f"Mesa {amd.version()}, RADV with ACO; SPIR-V by {_glslang()}"
    if "nvidia" in vendors:
        tools.program("nvrtc", "compiles CUDA")
        found["NVIDIA"] = f"NVRTC {_version('nvidia-cuda-nvrtc-cu12')}, --use_fast_math"
    found |= {gpu.name: gpu.products for gpu in gpus}
    return {**found, "date": datetime.date.today().isoformat()}


def _glslang() -> str:
    program = tools.program("glslangValidator", "compiles GLSL and HLSL")
    done = subprocess.run(
        [program, "--version"], capture_output=True, text=True, timeout=20, check=False
    )
    first = done.stdout.splitlines()[0] if done.stdout else ""
    return f"glslang {first.rpartition(':')[2].strip()}".strip()


def _version(package: str) -> str:
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:  # of an installed CUDA toolkit
        return ""
