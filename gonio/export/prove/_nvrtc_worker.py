"""Compiles CUDA by NVIDIA's runtime compiler: `python -P _nvrtc_worker.py LIBRARY FOLDER ARCHITECTURE ...`.

What follows is given to the compiler. A process of its own, without gonio: the compiler brings an LLVM that
must not meet Dr.Jit's. Kernel k is the file k.cu, which includes k.cuh as "export.h". What is refused goes
to k.error, machine code of a real architecture (sm_86) to k.cubin; a virtual one (compute_80) has none.
"""

import ctypes
import sys
from pathlib import Path

LANGUAGE = "--std=c++17"

# The compiler has the functions of math.h without the file.
MATH = b"#pragma once\n"


def main(library: Path, folder: Path, options: list[str]) -> None:
    """Compile all kernels of the folder."""
    nvrtc = ctypes.CDLL(str(library))
    for kernel in sorted(folder.glob("*.cu")):
        compiled(nvrtc, kernel, options)


def compiled(nvrtc: ctypes.CDLL, kernel: Path, options: list[str]) -> None:
    """Write machine code or messages beside the kernel."""
    program = ctypes.c_void_p()
    texts = (ctypes.c_char_p * 2)(kernel.with_suffix(".cuh").read_bytes(), MATH)
    names = (ctypes.c_char_p * 2)(b"export.h", b"math.h")
    made = nvrtc.nvrtcCreateProgram(
        ctypes.byref(program), kernel.read_bytes(), b"kernel.cu", 2, texts, names
    )
    if made != 0:
        raise RuntimeError(f"nvrtcCreateProgram returned {made}")
    given = (ctypes.c_char_p * len(options))(*(option.encode() for option in options))
    if nvrtc.nvrtcCompileProgram(program, len(options), given) != 0:
        kernel.with_suffix(".error").write_bytes(
            written(nvrtc, program, "ProgramLog").rstrip(b"\0")
        )
    elif code := written(nvrtc, program, "CUBIN"):
        kernel.with_suffix(".cubin").write_bytes(code)
    nvrtc.nvrtcDestroyProgram(ctypes.byref(program))


def written(nvrtc: ctypes.CDLL, program: ctypes.c_void_p, what: str) -> bytes:
    """Something that the compiler holds."""
    size = ctypes.c_size_t()
    getattr(nvrtc, f"nvrtcGet{what}Size")(program, ctypes.byref(size))
    content = ctypes.create_string_buffer(size.value)
    getattr(nvrtc, f"nvrtcGet{what}")(program, content)
    return content.raw


if __name__ == "__main__":
    architecture = f"--gpu-architecture={sys.argv[3]}"
    main(Path(sys.argv[1]), Path(sys.argv[2]), [architecture, LANGUAGE, *sys.argv[4:]])
