"""The languages that can be proven, each with what compiles and runs it."""

from __future__ import annotations

from gonio.export.prove.harness import Runner
from gonio.export.prove.native import run_cpp, run_msl
from gonio.export.prove.opengl import run_essl, run_glsl
from gonio.export.prove.osl import run_osl
from gonio.export.prove.slang import run_slang
from gonio.export.prove.webgpu import run_wgsl

RUNNERS: dict[str, Runner] = {
    "glsl": run_glsl,
    "essl": run_essl,
    "hlsl": run_slang,
    "wgsl": run_wgsl,
    "msl": run_msl,
    "slang": run_slang,
    "osl": run_osl,
    "cpp": run_cpp,
    "cuda": run_cpp,
}
