"""Timing two sides of a comparison fairly: in turn, so that what else the machine does hits both."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Mapping

Side = Callable[[], float]
"""Runs one side once and returns its seconds."""

# Calls of a side whose calls are short, for each one of a side whose calls are long.
SHORT_CALLS = 5


def stopwatch(work: Callable[[], object], calls: int = 1) -> Side:
    """A side that times `work`, which must return only when its results are there."""

    def side() -> float:
        seconds = []
        for _ in range(calls):
            start = time.perf_counter()
            result = work()
            seconds.append(time.perf_counter() - start)
            # Freed outside the time, so that the next call finds the memory in Dr.Jit's cache.
            del result
        return statistics.median(seconds)

    return side


def alternate(sides: Mapping[str, Side], repeat: int) -> dict[str, float]:
    """Median seconds of every side, after one round that does not count."""
    seconds: dict[str, list[float]] = {name: [] for name in sides}
    for round_ in range(repeat + 1):
        for name, side in sides.items():
            measured = side()
            if round_ > 0:
                seconds[name].append(measured)
    return {name: statistics.median(values) for name, values in seconds.items()}
