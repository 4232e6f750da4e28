"""Compiles CUDA by NVIDIA's runtime compiler: `python -P _nvrtc_worker.py LIBRARY FOLDER`, its own process.

It does not import gonio: the compiler brings an LLVM that must not meet Dr.Jit's. Kernel k is the file
k.cu, which includes k.cuh as "export.h". What the compiler refuses goes to k.error; nothing runs.
"""

import ctypes
import sys
from pathlib import Path

# A virtual architecture that GPUs from 2020 on have.
OPTIONS = (b"--gpu-architecture=compute_80", b"--std=c++17")

# The compiler has the functions of math.h without the file.
MATH = b"#pragma once\n"


def main(library: Path, folder: Path) -> None:
    """Compile all kernels of the folder."""
    nvrtc = ctypes.CDLL(str(library))
    for kernel in sorted(folder.glob("*.cu")):
        complaint = refused(nvrtc, kernel.read_bytes(), kernel.with_suffix(".cuh").read_bytes())
        if complaint is not None:
            kernel.with_suffix(".error").write_text(complaint, encoding="utf-8")


def refused(nvrtc: ctypes.CDLL, kernel: bytes, header: bytes) -> str | None:
    """The compiler's messages if it refuses a kernel."""
    program = ctypes.c_void_p()
    texts = (ctypes.c_char_p * 2)(header, MATH)
    names = (ctypes.c_char_p * 2)(b"export.h", b"math.h")
    made = nvrtc.nvrtcCreateProgram(ctypes.byref(program), kernel, b"kernel.cu", 2, texts, names)
    if made != 0:
        raise RuntimeError(f"nvrtcCreateProgram returned {made}")
    options = (ctypes.c_char_p * len(OPTIONS))(*OPTIONS)
    done = nvrtc.nvrtcCompileProgram(program, len(OPTIONS), options)
    size = ctypes.c_size_t()
    nvrtc.nvrtcGetProgramLogSize(program, ctypes.byref(size))
    log = ctypes.create_string_buffer(size.value)
    nvrtc.nvrtcGetProgramLog(program, log)
    nvrtc.nvrtcDestroyProgram(ctypes.byref(program))
    return log.value.decode("utf-8", "replace") if done != 0 else None


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
