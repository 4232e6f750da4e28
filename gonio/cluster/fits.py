"""Fits of many files by many models: each pair is a task, and several where there are many starts."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from gonio import fit, measured
from gonio.cluster.run import Run
from gonio.cluster.task import Done, Task
from gonio.fit import Fit
from gonio.materials.notation import model_text
from gonio.model import Model

# Starts of a task; more are several tasks.
STARTS = 8


def data_files(folder: str | Path) -> list[Path]:
    """Files of measured reflection in a folder and below, in order.

    Raises:
        ValueError: there are none.
    """
    every = sorted(path for path in Path(folder).rglob("*") if path.is_file())
    found = [path for path in every if measured.is_data_file(str(path))]
    if not found:
        raise ValueError(
            f"{folder} has no file of measured reflection; 'gonio data FILE' says why."
        )
    return found


def fits(
    run: Run,
    data: Sequence[Path | Model],
    models: Sequence[tuple[Model, tuple[str, ...], tuple[tuple[str, ...], ...]]],
    arguments: Mapping[str, Any],
) -> Iterator[tuple[Path | Model, list[Fit]]]:
    """The fits of each file or model, the best first; those that failed are left out.

    Args:
        run: does the tasks.
        data: files, or models that are fitted by others.
        models: are fitted to each of them, with what is fixed and what is tied.
        arguments: of `gonio.fit.fit`.
    """
    given = dict(arguments)
    starts = given.pop("starts")
    parts = [min(STARTS, starts - first) for first in range(0, starts, STARTS)]
    tasks = []
    for target in data:
        name = target if isinstance(target, Path) else model_text(target)
        for model, fixed, tied in models:
            for number, count in enumerate(parts):
                title = f"{name} by {model_text(model)}"
                if len(parts) > 1:
                    title += f", starts {number * STARTS} to {number * STARTS + count}"
                own = given | {"starts": count, "first": number * STARTS}
                own |= {"fixed": fixed, "tied": tied}
                tasks.append(
                    Task.of(f"{__name__}:one", title, data=target, model=model, arguments=own)
                )
    results = run.results(tasks)
    for target in data:
        found = []
        for _ in models:
            done = [next(results)[1] for _ in parts]
            if same := [d.value for d in done if isinstance(d, Done)]:
                found.append(_best(same))
        yield target, sorted(found, key=lambda f: f.misfit[f.metric])


def one(data: Path | Model, model: Model, arguments: dict[str, Any]) -> Fit:
    """The work of a task."""
    return fit.fit(model, measured.load(data) if isinstance(data, Path) else data, **arguments)


def _best(found: Sequence[Fit]) -> Fit:
    """The best of several fits of one model, with what all starts came to."""
    best = min(found, key=lambda f: f.misfit[f.metric])
    return dataclasses.replace(best, starts=tuple(sorted(s for f in found for s in f.starts)))
