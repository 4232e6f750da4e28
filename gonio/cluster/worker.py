"""What happens inside a Dask worker: one task of gonio's at a time, with the files that it names."""

from __future__ import annotations

import signal
import threading
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from gonio.cluster.identity import Identity, identity
from gonio.cluster.task import Failure, do
from gonio.files import replacing

# One thread does all of gonio's work of a process, however many a worker has: Dr.Jit's own threads share
# the cores, and Mitsuba keeps a state for each thread.
_lane = ThreadPoolExecutor(1, thread_name_prefix="gonio")


@dataclass(frozen=True)
class Stranger:
    """What a worker says that computes with other code than was asked for."""

    address: str
    differences: str


def who() -> Identity:
    """Who computes here."""
    return identity()


def content(data: bytes) -> bytes:
    """A file's content, as a task of Dask's: it can be had again when who holds it dies."""
    return data


def ignore_interrupts() -> None:
    """Leave Ctrl-C to the client, whose terminal a local worker shares."""
    if threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGINT, signal.SIG_IGN)


def do_here(
    work: str,
    title: str,
    data: bytes,
    contents: Mapping[str, bytes],
    expected: Identity,
) -> bytes | Failure | Stranger:
    """Do a task in this worker.

    Args:
        work: the task's function.
        title: its inputs in words.
        data: its inputs.
        contents: of files, by digest.
        expected: who should compute.
    """
    from distributed import get_worker

    worker = get_worker()
    if differences := expected.differences(identity()):
        return Stranger(worker.address, differences)
    folder = Path(worker.local_directory) / "gonio"

    def place(digest: str, name: str) -> Path:
        path = folder / digest / name
        if not path.is_file():
            path.parent.mkdir(parents=True, exist_ok=True)
            with replacing(path) as temporary:
                temporary.write_bytes(contents[digest])
        return path

    def lane() -> bytes | Failure:
        _share_cores(worker.state.nthreads)
        return do(work, title, data, place)

    return _lane.submit(lane).result()


def _share_cores(count: int) -> None:
    """Let Dr.Jit use as many threads as the worker was given, instead of all that the machine has."""
    import drjit as dr

    if dr.thread_count() != count:
        dr.set_thread_count(count)
