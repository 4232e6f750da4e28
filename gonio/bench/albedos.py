"""Albedos without a closed form: how long they take, beside the speed of `eval` itself."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from gonio.albedos.numeric import for_quadrature
from gonio.albedos.quadrature import evaluations, mean_nodes
from gonio.bench.pairs import Entry, Only, Pairs, entries, finished, random_pairs
from gonio.bench.report import Column, Section, Value, goal_text, milliseconds, percent
from gonio.bench.timing import alternate, stopwatch
from gonio.model import Model

# What is asked of every model: seconds for DIRECTIONS albedos, and for one mean albedo.
DIRECTIONS = 1000
GOAL, MEAN_GOAL = 0.1, 0.4

# Pairs of the `eval` that albedos are compared with: enough to keep all threads busy for a while.
PEAK_PAIRS = 1_000_000

NOTES = (
    f"Albedos of {DIRECTIONS:,} random directions (NumPy arrays in and out), and one mean albedo, of every "
    "model whose default parameters have no closed form; warm kernels.",
    "Evaluations: how often the rule asks `eval` (and a part of it that is integrated alone) for one "
    "direction; their time includes the rule's own arithmetic.",
    "Share of peak: the time that `eval` itself takes for a pair, on Dr.Jit arrays of single precision "
    f"with {PEAK_PAIRS:,} pairs on all threads and in the same rounds, over that of one evaluation. The "
    "rules half_vectors and mirror compute in double precision, half as many numbers at a time: they can "
    "have 50 % at most.",
)


def albedo_section(repeat: int, only: Only, progress: Callable[[str], None]) -> Section:
    """Directional and mean albedos of the models that have no formula for them."""
    pairs = random_pairs(PEAK_PAIRS)
    wo = np.stack(pairs.wo, -1)[:DIRECTIONS]
    rows = []
    for entry in entries(()):
        if not entry.model.writes("albedo") and only(entry):
            progress(f"albedo {entry.label}")
            rows.append(_row(entry, pairs, wo, repeat))
    columns = (
        Column("row", "model"),
        Column("rule", "rule"),
        Column("evaluations", "evaluations/direction", lambda n: f"{n:,.0f}"),
        Column("seconds", f"{DIRECTIONS:,} albedos, ms", milliseconds),
        Column("goal", "goal"),
        Column("seconds_per_evaluation", "ns/evaluation", lambda s: f"{1e9 * s:.2f}"),
        Column("eval_seconds", "eval, ns/pair", lambda s: f"{1e9 * s:.2f}"),
        Column("share", "of peak", percent),
        Column("mean_evaluations", "evaluations/mean", lambda n: f"{n:,.0f}"),
        Column("mean_seconds", "mean albedo, ms", milliseconds),
        Column("mean_goal", "goal"),
    )
    return Section("albedos", "Albedos without a closed form", NOTES, columns, rows)


def _row(entry: Entry, pairs: Pairs, wo: Any, repeat: int) -> dict[str, Value]:
    model = entry.model
    numeric = for_quadrature(model, wo, {}).numeric

    def peak() -> Any:
        return finished(model.eval(pairs.jit_wi, pairs.jit_wo))

    sides = {
        "albedo": stopwatch(lambda: model.albedo(wo)),
        "mean": stopwatch(model.mean_albedo),
        "eval": stopwatch(peak),
    }
    seconds = alternate(sides, repeat)
    count = evaluations(numeric)
    each = seconds["albedo"] / (count * len(wo))
    itself = seconds["eval"] / pairs.count
    row: dict[str, Value] = {
        "row": entry.label,
        "rule": numeric.rule or "angles",
        "evaluations": count,
        "seconds": seconds["albedo"],
        "goal": _at_most(seconds["albedo"], GOAL),
        "seconds_per_evaluation": each,
        "eval_seconds": itself,
        "share": itself / each,
    }
    if not model.writes("mean_albedo"):
        row["mean_evaluations"] = count * _mean_directions(model)
        row["mean_seconds"] = seconds["mean"]
        row["mean_goal"] = _at_most(seconds["mean"], MEAN_GOAL)
    return row


def _mean_directions(model: Model) -> int:
    return len(mean_nodes(model.follows_tangents())[1])


def _at_most(seconds: float, goal: float) -> str:
    return goal_text(1e3 * seconds, at_most=1e3 * goal)
