"""Random numbers for walks: a PCG32 sequence for every lane, its seed scrambled from whole numbers.

Scrambling: TEA, after Zafar, Olano, Curtis, "GPU random numbers via the tiny encryption algorithm", HPG
2010. Generator: O'Neill, "PCG", 2014, as Dr.Jit has it.
"""

from __future__ import annotations

from typing import Any

import drjit as dr

WORD = 0xFFFFFFFF


def scramble(first: Any, second: Any, rounds: int = 6) -> tuple[Any, Any]:
    """Two 32-bit numbers, Python's or Dr.Jit's, that depend on every bit of two others."""
    total = 0
    for _ in range(rounds):
        total = (total + 0x9E3779B9) & WORD
        mixed = ((second << 4) + 0xA341316C) ^ (second + total) ^ ((second >> 5) + 0xC8013EA4)
        first = (first + mixed) & WORD
        mixed = ((first << 4) + 0xAD90777D) ^ (first + total) ^ ((first >> 5) + 0x7E95761E)
        second = (second + mixed) & WORD
    return first, second


def generator(first: Any, second: Any) -> Any:
    """A generator whose sequence belongs to two 32-bit numbers, or to two in each lane."""
    state, sequence = scramble(first, second)
    if isinstance(state, int):
        return dr.scalar.PCG32(1, state, sequence)
    UInt64 = dr.uint64_array_t(type(state))
    rng = _pcg(type(state))(dr.width(state))
    rng.seed(UInt64(state), UInt64(sequence))
    return rng


def _pcg(UInt: Any) -> Any:
    """Dr.Jit's generator for the backend of an array type."""
    if dr.backend_v(UInt) == dr.JitBackend.CUDA:
        return dr.cuda.ad.PCG32 if dr.is_diff_v(UInt) else dr.cuda.PCG32
    return dr.llvm.ad.PCG32 if dr.is_diff_v(UInt) else dr.llvm.PCG32
