"""Which kernels Dr.Jit runs: how much memory they move, and whether a changed number needs new ones."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import drjit as dr

from gonio.fields import Parameter
from gonio.model import Model


@dataclass(frozen=True)
class Kernel:
    """A compiled kernel that was run."""

    hash: str
    """Identifies its code: two runs with the same hash share one compilation."""
    ir: str
    size: int


def launched(work: Callable[[], object]) -> list[Kernel]:
    """The kernels that `work` runs (a copy, a reduction or a fill by Dr.Jit itself is none)."""
    with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
        dr.kernel_history_clear()
        work()
        dr.sync_thread()
        history = dr.kernel_history()
    return [
        Kernel(entry["hash"], entry["ir"].getvalue(), entry["size"])
        for entry in history
        if entry["type"] == dr.KernelType.JIT
    ]


def moved_bytes(kernel: Kernel) -> int:
    """Bytes per element that an LLVM kernel reads from and writes to whole arrays.

    Counted in the kernel's own code. Parameters, which are one number for all elements, are loaded
    there in another way and do not count.
    """
    total = 0
    for count, bits in re.findall(r"(?:\bload|\bstore) <(\d+) x [a-z]+(\d*)>", kernel.ir):
        del count  # the vector width
        total += int(bits) // 8 if bits else 4  # `float` has no number, `double` is not used here
    return total


def exact_operations(kernel: Kernel) -> int:
    """Quotients and roots per element of an LLVM kernel, all of which round exactly.

    They take as long as five to ten products; compilers that may round as they like estimate them.
    """
    return len(re.findall(r"= (?:fdiv|call [^@]*@llvm\.sqrt\.)", kernel.ir))


def needed_again(before: Callable[[], object], after: Callable[[], object]) -> int:
    """How many kernels `after` has to compile that `before` had not compiled yet."""
    known = {kernel.hash for kernel in launched(before)}
    return len({kernel.hash for kernel in launched(after)} - known)


def changed_copies(model: Model) -> Iterator[tuple[str, Model]]:
    """For every parameter: its name, and a copy of the model in which only that number differs."""
    for name, declared in model.fields.items():
        if isinstance(declared, Parameter):
            value = getattr(model, name)
            yield name, model.replace(**{name: another_value(declared, value)})


def another_value(declared: Parameter, value: object) -> object:
    """A number (or triple) in the parameter's range that is not `value`."""
    if isinstance(value, tuple):
        return tuple(another_value(declared, v) for v in value)
    assert isinstance(value, float | int)
    low, high = declared.low, min(declared.high, declared.low + 2 * abs(value) + 1)
    middle = low + 0.375 * (high - low)
    return middle if middle != value else low + 0.625 * (high - low)
