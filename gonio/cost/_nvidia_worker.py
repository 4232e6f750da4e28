"""Compiles CUDA to machine code by NVRTC: `python -P _nvidia_worker.py LIBRARY ARCHITECTURE FOLDER`.

A process of its own, without gonio: the compiler brings an LLVM that must not meet Dr.Jit's. Kernel k is
the file k.cu, which includes k.cuh as "export.h". Machine code goes to k.cubin, what the compiler
refuses to k.error.
"""

import ctypes
import sys
from pathlib import Path

# As games are compiled: short functions of the hardware in place of exact ones
OPTIONS = (b"--std=c++17", b"--use_fast_math")

# The compiler has the functions of math.h without the file.
MATH = b"#pragma once\n"


def main(library: Path, architecture: str, folder: Path) -> None:
    """Compile all kernels of the folder."""
    nvrtc = ctypes.CDLL(str(library))
    for kernel in sorted(folder.glob("*.cu")):
        compiled(nvrtc, architecture, kernel)


def compiled(nvrtc: ctypes.CDLL, architecture: str, kernel: Path) -> None:
    """Write machine code or messages beside the kernel."""
    program = ctypes.c_void_p()
    texts = (ctypes.c_char_p * 2)(kernel.with_suffix(".cuh").read_bytes(), MATH)
    names = (ctypes.c_char_p * 2)(b"export.h", b"math.h")
    made = nvrtc.nvrtcCreateProgram(
        ctypes.byref(program), kernel.read_bytes(), b"kernel.cu", 2, texts, names
    )
    if made != 0:
        raise RuntimeError(f"nvrtcCreateProgram returned {made}")
    options = (b"--gpu-architecture=" + architecture.encode(), *OPTIONS)
    done = nvrtc.nvrtcCompileProgram(
        program, len(options), (ctypes.c_char_p * len(options))(*options)
    )
    what = "ProgramLog" if done != 0 else "CUBIN"
    size = ctypes.c_size_t()
    getattr(nvrtc, f"nvrtcGet{what}Size")(program, ctypes.byref(size))
    content = ctypes.create_string_buffer(size.value)
    getattr(nvrtc, f"nvrtcGet{what}")(program, content)
    nvrtc.nvrtcDestroyProgram(ctypes.byref(program))
    kernel.with_suffix(".error" if done != 0 else ".cubin").write_bytes(content.raw)


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2], Path(sys.argv[3]))
