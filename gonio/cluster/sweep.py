"""Sweeps: numbers of a model over a grid of its parameters, as rows of a table."""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

import gonio
from gonio.cluster.grid import COLUMNS, Axis, Value, points
from gonio.cluster.run import Run
from gonio.cluster.task import Failure, Task
from gonio.compare import measure
from gonio.fields import ModelError
from gonio.files import check_place, replacing
from gonio.materials.notation import model_text
from gonio.model import Model
from gonio.plot.numbers import direction, sample_weights

WORK = f"{__name__}:rows"

Floats = NDArray[np.float64]

# Points of a task: a second or some, so that sending it costs little, and little is lost with it.
POINTS = {"variance": 32, "difference": 128, "albedo": 256, "mean_albedo": 64}

# Samples for which this holds; with more, a task has fewer points.
SAMPLES = 1 << 18

# Pairs of directions for one difference.
PAIRS = 4000

# Of these there is a number for each angle of the viewer.
BY_ANGLE = ("albedo", "variance")

FORMATS = (".parquet", ".csv")


@dataclass(frozen=True)
class Sweep:
    """What is to be measured, and where."""

    model: Model
    axes: tuple[Axis, ...]
    measures: tuple[str, ...]
    against: Model | None = None
    theta_o: tuple[float, ...] = (0.0, 30.0, 60.0, 80.0)
    """Polar angles of the viewer in degrees."""
    samples: int = SAMPLES
    """Of the sampler, at each point and angle."""
    fixed: frozenset[str] = frozenset()
    """What of `against` was given, and is not varied with the model's."""

    def __post_init__(self) -> None:
        """Look at it as a whole.

        Raises:
            ModelError: something is missing, or has no effect.
        """
        if not self.axes:
            raise ModelError("a sweep varies something; give --vary name=0..1.")
        if ("difference" in self.measures) != (self.against is not None):
            raise ModelError("--measure difference and --against MODEL go together; give both.")
        points(self.axes)

    @property
    def by_angle(self) -> bool:
        """Whether there is a row for each angle of the viewer."""
        return any(name in BY_ANGLE for name in self.measures)

    def columns(self) -> list[str]:
        """Names of the table's columns."""
        angle = ["theta_o"] if self.by_angle else []
        values = [column for name in self.measures for column in COLUMNS[name]]
        return [*(a.name for a in self.axes), *angle, *values]

    def groups(self) -> Iterator[tuple[tuple[Value, ...], ...]]:
        """The points of each task."""
        count = min(POINTS[name] for name in self.measures)
        if "variance" in self.measures:
            count = max(1, min(count, POINTS["variance"] * SAMPLES // self.samples))
        every = points(self.axes)
        return iter(lambda: tuple(itertools.islice(every, count)), ())

    def tasks(self) -> list[Task]:
        """A task for each handful of points."""
        names = tuple(a.name for a in self.axes)
        found = []
        for group in self.groups():
            title = f"{self.model.name} at {_named(names, group[0])}"
            if len(group) > 1:
                title += f" to {_named(names, group[-1])}"
            task = Task.of(
                WORK,
                title,
                model=self.model,
                names=names,
                points=group,
                measures=self.measures,
                against=self._others(names),
                theta_o=self.theta_o if self.by_angle else (),
                samples=self.samples if "variance" in self.measures else 0,
            )
            found.append(task)
        return found

    def _others(self, names: Sequence[str]) -> tuple[Model, tuple[str, ...]] | None:
        """The model that it is compared with, and what of it is varied too."""
        if self.against is None:
            return None
        own = {path for path, _, _ in self.against.parameters()} | set(self.against.fields)
        return self.against, tuple(n for n in names if n in own and n not in self.fixed)

    def run(self, run: Run, path: str | Path) -> int:
        """Measure all points and write the table; the number of its rows.

        Where a task has failed its rows hold no numbers.
        """
        tasks = self.tasks()
        angles = self.theta_o if self.by_angle else (None,)
        facts = {"gonio": gonio.__version__, "model": model_text(self.model)}
        if self.against is not None:
            facts["against"] = model_text(self.against)
        rows = 0
        results = run.results(tasks)
        # The table is begun when most of the work is done: a process that is killed before leaves none
        first = next(results)
        with _table(path, self.columns(), facts) as table:
            every = itertools.chain([first], results)
            for (_, done), group in zip(every, self.groups(), strict=True):
                wide = sum(len(COLUMNS[name]) for name in self.measures)
                values = (
                    np.full((len(group), len(angles), wide), np.nan)
                    if isinstance(done, Failure)
                    else done.value
                )
                made: dict[str, list[Any]] = {name: [] for name in self.columns()}
                for point, block in zip(group, values, strict=True):
                    for theta, row in zip(angles, block, strict=True):
                        entries = [*point, *([] if theta is None else [theta]), *row.tolist()]
                        for name, entry in zip(made, entries, strict=True):
                            made[name].append(entry)
                rows += len(group) * len(angles)
                table.write(made)
        return rows


def _named(names: Sequence[str], point: Sequence[Value]) -> str:
    return ",".join(
        f"{n}={v if isinstance(v, str) else format(v, 'g')}"
        for n, v in zip(names, point, strict=True)
    )


# --- the work of a task ----------------------------------------------------------------------------


def rows(
    model: Model,
    names: tuple[str, ...],
    points: tuple[tuple[Value, ...], ...],
    measures: tuple[str, ...],
    against: tuple[Model, tuple[str, ...]] | None,
    theta_o: tuple[float, ...],
    samples: int,
) -> Floats:
    """The numbers of some points, (points, angles, columns)."""
    angles = np.array(theta_o or (0.0,))
    found = []
    for point in points:
        given = dict(zip(names, point, strict=True))
        here = model.replace(**given)
        blocks = []
        for name in measures:
            if name == "albedo":
                block = np.asarray(here.albedo(direction(angles)), np.float64)
            elif name == "mean_albedo":
                block = np.asarray(here.mean_albedo(), np.float64)[None]
            elif name == "variance":
                block = sample_weights(here, angles, "luminance", samples)
            else:
                assert against is not None
                other, varied = against
                block = _difference(here, other.replace(**{n: given[n] for n in varied}))
            blocks.append(np.broadcast_to(block, (len(angles), block.shape[-1])))
        found.append(np.concatenate(blocks, axis=1))
    return np.stack(found)


def _difference(model: Model, other: Model) -> Floats:
    """Mean difference and energy, as `gonio.compare` has them."""
    errors = measure(model, other, pairs=PAIRS, maps=False).judge(model)[0]
    return np.array([[errors.mean, errors.energy]])


# --- the table -------------------------------------------------------------------------------------


class Table(Protocol):
    """A file that takes rows."""

    def write(self, rows: Mapping[str, Sequence[Any]]) -> None:
        """Add rows, given by columns."""


def check_format(path: str | Path) -> None:
    """Raise before the work is done if the table cannot be written.

    Raises:
        ValueError: the suffix is of no known format, or pyarrow is missing.
        OSError: nothing can be written there.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in FORMATS:
        raise ValueError(f"{path} is a table: its name ends in {' or '.join(FORMATS)}.")
    if suffix == ".parquet":
        try:
            import pyarrow.parquet  # noqa: F401
        except ImportError:
            raise ValueError(
                "a .parquet file needs pyarrow; run: pip install 'gonio[cluster]', or write a .csv."
            ) from None
    check_place(path)


@contextmanager
def _table(path: str | Path, columns: Sequence[str], facts: Mapping[str, str]) -> Iterator[Table]:
    """A table that appears when it is complete; rows go to the disk as they come."""
    with replacing(path) as temporary:
        if Path(path).suffix.lower() == ".csv":
            with temporary.open("w", encoding="utf-8", newline="") as file:
                yield _Csv(file, columns)
        else:
            made = _Parquet(temporary, facts)
            try:
                yield made
            finally:
                made.close()


class _Csv:
    def __init__(self, file: Any, columns: Sequence[str]) -> None:
        import csv

        self.writer = csv.writer(file, lineterminator="\n")
        self.writer.writerow(columns)

    def write(self, rows: Mapping[str, Sequence[Any]]) -> None:
        for row in zip(*rows.values(), strict=True):
            self.writer.writerow("" if isinstance(v, float) and math.isnan(v) else v for v in row)


class _Parquet:
    """Columnar, typed, compressed: pandas, Polars, DuckDB and Spark read it without being told anything."""

    def __init__(self, path: Path, facts: Mapping[str, str]) -> None:
        self.path, self.facts = path, facts
        self.writer: Any = None

    def write(self, rows: Mapping[str, Sequence[Any]]) -> None:
        import pyarrow as pa
        import pyarrow.parquet as pq

        table = pa.table({name: pa.array(c, from_pandas=True) for name, c in rows.items()})
        if self.writer is None:
            schema = pa.schema(
                [
                    pa.field(n, pa.string() if _is_text(c) else pa.float64())
                    for n, c in rows.items()
                ],
                metadata={"gonio": json.dumps(dict(self.facts))},
            )
            self.writer = pq.ParquetWriter(self.path, schema)
        self.writer.write_table(table.cast(self.writer.schema))

    def close(self) -> None:
        if self.writer is not None:
            self.writer.close()


def _is_text(column: Sequence[Any]) -> bool:
    return any(isinstance(v, str) for v in column)
