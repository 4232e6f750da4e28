"""The numbers of one program on one GPU."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Measured:
    """What a compiler says of the machine code that it made."""

    instructions: int
    registers: int
    """Vector registers of a thread; more of them leave room for fewer threads."""
    cycles: int | None = None
    """Of a group of threads on a unit that is kept busy by others; only AMD's compiler knows it."""
    latency: int | None = None
    """Cycles from the start to the end of one group of threads alone."""

    def __sub__(self, empty: Measured) -> Measured:
        """What is left when the harness is taken away. Registers are not a sum: they stay."""

        def less(a: int | None, b: int | None) -> int | None:
            return None if a is None or b is None else a - b

        return Measured(
            self.instructions - empty.instructions,
            self.registers,
            less(self.cycles, empty.cycles),
            less(self.latency, empty.latency),
        )

    @property
    def price(self) -> int:
        """What ratios are made of: cycles where they are known, else instructions."""
        return self.instructions if self.cycles is None else self.cycles
