"""The languages that can be proven, each with what compiles and runs it.

SPIR-V is no language of the exporter: GLSL becomes it, and is run a second time that way.
"""

from __future__ import annotations

from dataclasses import replace

from gonio.export.entry import Export
from gonio.export.prove.cuda import run_cuda
from gonio.export.prove.harness import Runner
from gonio.export.prove.native import run_cpp, run_msl
from gonio.export.prove.opengl import run_essl, run_glsl
from gonio.export.prove.osl import run_osl
from gonio.export.prove.slang import run_slang
from gonio.export.prove.vulkan import run_spirv
from gonio.export.prove.webgpu import run_wgsl

RUNNERS: dict[str, Runner] = {
    "glsl": run_glsl,
    "spirv": run_spirv,
    "essl": run_essl,
    "hlsl": run_slang,
    "wgsl": run_wgsl,
    "msl": run_msl,
    "slang": run_slang,
    "osl": run_osl,
    "cpp": run_cpp,
    "cuda": run_cuda,
}


def each_way(export: Export) -> list[Export]:
    """An export once for every way in which it is run: GLSL by OpenGL, and as SPIR-V by Vulkan."""
    if export.language == "glsl":
        return [export, replace(export, language="spirv")]
    return [export]
