"""How long things take from nothing: `import gonio`, `gonio list`, `gonio render`."""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path

from gonio.bench.report import Column, Section, Value, goal_text, milliseconds

IMPORT_GOAL, LIST_GOAL, RENDER_GOAL = 0.25, 0.5, 6.0  # seconds

COMMAND = ("-c", "from gonio.cli import main; main()")

# With a number of samples: without one, a picture is rendered until its noise is below a goal.
RENDER = ("render", "eon", "--spp", "36")


def startup_section(repeat: int, progress: Callable[[str], None]) -> Section:
    """Median wall times of fresh processes, after one that fills the caches of disk and kernels."""

    def timed(name: str, arguments: Sequence[str], goal: float, runs: int) -> dict[str, Value]:
        progress(f"start of {name}")
        seconds = process_seconds(arguments, runs)
        row: dict[str, Value] = {"row": name, "seconds": seconds}
        if isinstance(seconds, float):
            row["goal"] = goal_text(seconds, at_most=goal)
        return row

    with tempfile.TemporaryDirectory() as folder:
        picture = str(Path(folder, "eon.png"))
        rows = [
            _import_row(repeat, progress),
            timed("gonio list", [*COMMAND, "list"], LIST_GOAL, repeat),
            timed(" ".join(("gonio", *RENDER)), [*COMMAND, *RENDER, "-o", picture], RENDER_GOAL, 1),
        ]
    columns = (
        Column("row", "what"),
        Column("seconds", "ms", milliseconds),
        Column("goal", "goal, s"),
    )
    notes = (
        "Fresh processes with warm disk and kernel caches, from start to end; for the import, less "
        "the time of a Python that does nothing.",
        f"Medians of {repeat}; the picture of 512×512 pixels once.",
    )
    return Section("startup", "Starting", notes, columns, rows)


def _import_row(repeat: int, progress: Callable[[str], None]) -> dict[str, Value]:
    progress("import gonio")
    nothing = process_seconds(["-c", "pass"], repeat)
    importing = process_seconds(["-c", "import gonio"], repeat)
    if isinstance(nothing, str) or isinstance(importing, str):
        return {"row": "import gonio", "seconds": importing}
    seconds = importing - nothing
    goal = goal_text(seconds, at_most=IMPORT_GOAL)
    return {"row": "import gonio", "seconds": seconds, "goal": goal}


def process_seconds(arguments: Sequence[str], runs: int) -> float | str:
    """Median wall time of a Python process, or in a few words why there is none."""
    # Where Python may not keep what it has compiled, as in some containers, that is no part of gonio's time
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    seconds = []
    for _ in range(runs + 1):
        start = time.perf_counter()
        done = subprocess.run(
            [sys.executable, *arguments], capture_output=True, text=True, env=environment
        )
        seconds.append(time.perf_counter() - start)
        if done.returncode != 0:
            lines = done.stderr.strip().splitlines() or [f"exit code {done.returncode}"]
            return f"failed: {lines[-1]}"
    return statistics.median(seconds[1:])
