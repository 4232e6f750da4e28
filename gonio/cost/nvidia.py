"""What shaders cost on NVIDIA's GPUs: instructions and registers of their machine code, without a GPU."""

from __future__ import annotations

import struct
import tempfile
from collections.abc import Sequence
from pathlib import Path

from gonio.cost.gpus import Gpu
from gonio.cost.measured import Measured
from gonio.cost.program import Program
from gonio.export.prove.cuda import compile_kernels
from gonio.export.prove.tools import ProofError

FAST = "--use_fast_math"
"""As games are compiled: short functions of the hardware in place of exact ones."""

WORD = 16
"""Bytes per instruction, on all GPUs since 2017."""

# The low 12 bits of an instruction say which it is
NOP, BRANCH = 0x918, 0x947

REGISTERS = 0x2F04
"""The attribute of a kernel that holds how many registers a thread has."""


def measure(programs: Sequence[Program], gpu: Gpu, *options: str) -> list[Measured]:
    """Compile each program's kernel to machine code, with more options for the compiler.

    Raises:
        ProofError: the compiler is missing, or refuses a kernel.
    """
    with tempfile.TemporaryDirectory(prefix="gonio-") as name:
        folder = Path(name)
        compile_kernels([program.cuda for program in programs], folder, gpu.name, FAST, *options)
        return [_read(program, gpu, folder / str(k)) for k, program in enumerate(programs)]


def _read(program: Program, gpu: Gpu, stem: Path) -> Measured:
    error = stem.with_suffix(".error")
    if error.exists():
        said = error.read_text(encoding="utf-8", errors="replace").strip()
        wrong = [line for line in said.splitlines() if "error" in line] or said.splitlines()
        first = wrong[0] if said else "no message"
        raise ProofError(f"{program.label}: NVRTC refuses it for {gpu.name}: {first}")
    instructions, registers = machine_code(stem.with_suffix(".cubin").read_bytes())
    return Measured(instructions=instructions, registers=registers)


def machine_code(cubin: bytes) -> tuple[int, int]:
    """Instructions and registers of the only kernel in an ELF file of machine code.

    What fills the end is not counted: a branch to itself, and instructions that do nothing.
    """
    table = struct.unpack_from("<Q", cubin, 0x28)[0]
    size, count, names = struct.unpack_from("<HHH", cubin, 0x3A)
    sections = [struct.unpack_from("<IIQQQQIIQQ", cubin, table + k * size) for k in range(count)]
    start = sections[names][4]
    instructions = registers = 0
    for section in sections:
        place, length = section[4], section[5]
        name = cubin[start + section[0] : cubin.index(b"\0", start + section[0])]
        content = cubin[place : place + length]
        if name.startswith(b".text."):
            words = [struct.unpack_from("<Q", content, k)[0] for k in range(0, length, WORD)]
            kinds = [word & 0xFFF for word in words]
            while kinds and kinds[-1] == NOP:
                kinds.pop()
            if kinds and kinds[-1] == BRANCH:
                kinds.pop()
            instructions += sum(kind != NOP for kind in kinds)
            registers = max(registers, section[7] >> 24)
        elif name == b".nv.info":
            registers = max(registers, _attribute(content))
    return instructions, registers


def _attribute(content: bytes) -> int:
    """Registers as newer compilers write them: format and kind, size, symbol, value."""
    at = 0
    while at + 12 <= len(content):
        kind, length = struct.unpack_from("<HH", content, at)
        if kind == REGISTERS:
            return int(struct.unpack_from("<I", content, at + 8)[0])
        # Formats other than 4 hold their value in place of the size
        at += 4 + (length if kind & 0xFF == 4 else 0)
    return 0
