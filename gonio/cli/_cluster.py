"""Options of commands whose work can be shared out and gone on with: --cluster and --run-dir."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import click

from gonio.cli.program import progress

# Seconds between lines of progress where there is no terminal, as in the log of a batch system.
EVERY = 30.0

# Failures that are printed; all are counted.
SHOWN = 20

_OPTIONS = (
    click.option(
        "--cluster",
        metavar="local[:N]|ADDRESS|FILE.json",
        help="Share the work out with Dask: N processes here, the scheduler at tcp://host:8786, or that "
        "of a scheduler file. Can be interrupted: the same command goes on. See docs/cluster.md.",
    ),
    click.option(
        "--run-dir",
        metavar="FOLDER",
        help="Keep the results of tasks there, so that the same command goes on from them, with or without "
        "--cluster, which by itself keeps them beside the output until it is complete.",
    ),
)


def cluster_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add --cluster and --run-dir to a command."""
    for option in reversed(_OPTIONS):
        command = option(command)
    return command


@contextmanager
def run_of(
    cluster: str | None, run_dir: str | None, output: str | Path, label: str
) -> Iterator[Any]:
    """A `gonio.cluster.Run` for a command, and what is to be said when it ends.

    The folder is removed when everything is done, unless it was given.

    Args:
        cluster: --cluster.
        run_dir: --run-dir.
        output: what the command writes; results of tasks are kept beside it.
        label: of the progress.
    """
    from gonio.cluster import Here, Run, RunFolder, connect

    given = run_dir is not None
    folder = None
    if cluster is not None or given:
        folder = RunFolder(run_dir if run_dir is not None else f"{output}.run")
    engine = Here() if cluster is None else connect(cluster, _tell)
    try:
        with progress(label) as bar:
            run = Run(engine, folder, _Lines(label, bar), _tell)
            yield run
    except KeyboardInterrupt:
        if folder is not None and folder.path.is_dir():
            _tell(f"what is done is kept in {folder.path}; the same command goes on from there")
        raise
    finally:
        engine.close()
    if run.failures:
        _complain(run.failures)
    elif folder is not None and not given:
        folder.remove()


def _tell(text: str) -> None:
    click.echo(f"gonio: {text}", err=True)


class _Lines:
    """A bar on a terminal, a line now and then elsewhere."""

    def __init__(self, label: str, bar: Callable[[int, int], None]) -> None:
        self.label, self.bar = label, bar
        self.said = time.monotonic()

    def __call__(self, done: int, total: int) -> None:
        self.bar(done, total)
        if not sys.stderr.isatty() and time.monotonic() - self.said > EVERY:
            self.said = time.monotonic()
            _tell(f"{self.label}: {done} of {total} tasks")


def _complain(failures: list[Any]) -> None:
    for failure in failures[:SHOWN]:
        click.echo(f"gonio: error: {failure.title}: {failure.reason}", err=True)
        if "--debug" in sys.argv:
            click.echo(failure.trace, err=True)
    more = len(failures) - SHOWN
    if more > 0:
        click.echo(f"gonio: error: and {more} more", err=True)
    tasks = "task has" if len(failures) == 1 else "tasks have"
    click.echo(
        f"gonio: {len(failures)} {tasks} failed; the same command tries them again, and keeps the others.",
        err=True,
    )


def pictures_of(
    cluster: str | None,
    run_dir: str | None,
    output: Path,
    wanted: Sequence[tuple[Any, Mapping[str, Any]]],
) -> list[Any]:
    """Pictures by tasks, for commands that put them beside each other.

    Args:
        cluster: --cluster.
        run_dir: --run-dir.
        output: what the command writes.
        wanted: what is shown, and arguments of `gonio.render`.

    Raises:
        ClickException: something of them could not be rendered; what was is kept.
    """
    from gonio.cluster import pictures

    with run_of(cluster, run_dir, output, "rendering") as run:
        found = list(pictures.pictures(run, wanted))
    if run.failures:
        raise click.ClickException(f"{output} was not written, because parts of it are missing")
    return found


def exact_spp(spp: int | None, noise: float | None, seconds: float | None) -> int:
    """The number of samples that can be shared out.

    Raises:
        UsageError: the picture decides when it ends, which nobody knows before.
    """
    if spp is None or noise is not None or seconds is not None:
        raise click.UsageError(
            "--cluster and --run-dir share out a number of samples; give --spp N, no --noise and --time"
        )
    return spp
