"""Measures what sharing out costs, and says how far it carries: the tables of docs/cluster.md.

    python tools/measure_cluster.py

Starts a scheduler with one worker and with two, as processes of this machine, and takes the processor
time of each process: of workers for a task, of scheduler and client for a task and for a megabyte of it.
From these it computes how many workers a scheduler keeps busy: tasks are done side by side, while scheduler
and client handle one after the other.
"""

from __future__ import annotations

import tempfile
import time
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import gonio
from gonio import check
from gonio.cluster import Run, RunFolder, Task, checks, connect, pictures, sweep
from gonio.cluster.codec import encode
from gonio.cluster.grid import axis
from gonio.materials import load

# Workers whose work is measured, and for which it is modelled.
MEASURED, MODELLED = (1, 2), (10, 100, 1000)

# Of tasks that do nothing, and of those that give a megabyte back.
EMPTY, HEAVY = 400, 60

MEGABYTE = 1 << 20


@dataclass(frozen=True)
class Cost:
    """What a batch of tasks took, in seconds."""

    wall: float
    workers: tuple[float, ...]
    """Processor time of each worker."""
    middle: float
    """Processor time of scheduler and client, which are one process here."""


def timed(cluster: Any, tasks: Sequence[Task]) -> Cost:
    """Do tasks, with their results written to a folder as always."""
    with tempfile.TemporaryDirectory() as folder:
        run = Run(cluster, RunFolder(Path(folder) / "run"))
        before = cluster.client.run(time.process_time)
        wall, own = time.perf_counter(), time.process_time()
        for _ in run.results(tasks):
            pass
        wall, own = time.perf_counter() - wall, time.process_time() - own
        after = cluster.client.run(time.process_time)
    assert not run.failures, run.failures[0]
    return Cost(wall, tuple(after[name] - before[name] for name in after), own)


def jobs() -> dict[str, list[Task]]:
    """Work as users have it, some seconds of each."""
    eon, ggx = gonio.model("eon"), gonio.model("torrance_sparrow")
    variance = sweep.Sweep(
        ggx,
        (axis(ggx, "alpha=0.05..1:64"), axis(ggx, "eta=1.3,1.5")),
        ("variance",),
        samples=sweep.SAMPLES,
    )
    difference = sweep.Sweep(
        eon, (axis(eon, "roughness=0..1:1024"),), ("difference",), gonio.model("oren_nayar")
    )
    picture = {"environment": "studio", "size": (512, 512), "spp": 64, "seed": 0}
    subjects = [check.subjects(gonio.model(name)) for name in ("lambert", "minnaert")]
    return {
        "sweep, variance": variance.tasks(),
        "sweep, difference": difference.tasks(),
        "render, 512 x 512": pictures.tasks(load("gold"), picture),
        "check --quick": checks.tasks(subjects, "quick"),
    }


def empty(count: int, size: int) -> list[Task]:
    """Tasks that give `size` bytes back."""
    work = "gonio.cluster.worker:content"
    data = np.random.default_rng(0).bytes(size).hex()[:size]
    return [Task.of(work, str(n), data=f"{n:09}{data}") for n in range(count)]


def drain(cluster: Any) -> None:
    """Let every worker load what it needs, and compile what it will run."""
    cluster.work(deque(empty(8, 1)), lambda task: False, lambda task, found: ())


def measure() -> tuple[dict[str, dict[int, Cost]], float, float]:
    """Costs of all work by workers; seconds of scheduler and client for a task, and for a megabyte."""
    found: dict[str, dict[int, Cost]] = {}
    for count in MEASURED:
        cluster = connect(f"local:{count}", print)
        try:
            drain(cluster)
            small, large = empty(EMPTY, 1), empty(HEAVY, MEGABYTE)
            costs = {"nothing": timed(cluster, small), "a megabyte": timed(cluster, large)}
            for name, tasks in jobs().items():
                timed(cluster, tasks[:count])  # compiles
                costs[name] = timed(cluster, tasks)
        finally:
            cluster.close()
        for name, cost in costs.items():
            found.setdefault(name, {})[count] = cost
    last = MEASURED[-1]
    task = found["nothing"][last].middle / EMPTY
    # A megabyte goes to the worker and comes back; half of it is the result
    megabyte = max(found["a megabyte"][last].middle / HEAVY - task, 0.0) / 2
    return found, task, megabyte


def report() -> list[str]:
    """The tables, as Markdown."""
    sizes = {name: (len(tasks), _result_size(tasks)) for name, tasks in jobs().items()}
    found, task, megabyte = measure()
    lines = [
        f"Scheduler and client together: {1e3 * task:.2f} ms for a task, {1e3 * megabyte:.1f} ms for a "
        "megabyte of result, of one core.",
        "",
        "| work | tasks | s of a worker for each | MB of result | wall, 1 worker | wall, 2 | speed-up |",
        "| :-- | --: | --: | --: | --: | --: | --: |",
    ]
    for name, (count, size) in sizes.items():
        one, two = (found[name][workers] for workers in MEASURED)
        each = sum(one.workers) / count
        lines.append(
            f"| {name} | {count} | {each:.2f} | {size / MEGABYTE:.3f} | {one.wall:.1f} s | "
            f"{two.wall:.1f} s | {one.wall / two.wall:.2f} |"
        )
    heads = " | ".join(f"{workers:,} workers" for workers in MODELLED)
    lines += [
        "",
        f"| work | {heads} | most workers kept busy |",
        f"| :-- | {' | '.join(['--:'] * len(MODELLED))} | --: |",
    ]
    for name, (count, size) in sizes.items():
        each = sum(found[name][1].workers) / count
        middle = task + megabyte * size / MEGABYTE
        shares = " | ".join(f"{min(1.0, each / (middle * w)):.0%}" for w in MODELLED)
        lines.append(f"| {name} | {shares} | {each / middle:,.0f} |")
    return lines


def _result_size(tasks: Sequence[Task]) -> int:
    from gonio.cluster.engine import at_hand
    from gonio.cluster.task import do

    first = do(tasks[0].work, tasks[0].title, tasks[0].data, at_hand(tasks[0].files))
    assert isinstance(first, bytes), first
    return len(first) + len(encode(None)[0])


if __name__ == "__main__":
    print("\n".join(report()))
