"""Processes of this machine that do tasks beside this one: for work of seconds, without Dask.

A process is there half a second after it was asked for, and ends with this one, however that ends. What it
cannot do, or had not done when it died, is done here: with the same result, or the same error.
"""

from __future__ import annotations

import contextlib
import json
import os
import queue
import subprocess
import sys
import threading
import weakref
from collections import deque
from collections.abc import Callable
from pathlib import Path
from typing import IO, Any

import drjit as dr

from gonio import backend
from gonio.cluster.codec import Place, decode, digest
from gonio.cluster.task import Done, Task, do
from gonio.messages import notice

Progress = Callable[[int, int], None]

# Bytes of a message's length, which comes first; and the message that a task was not done.
HEAD, NOT_DONE = 8, b""

# Seconds after which a wait for a result looks up, so that Ctrl-C is heard on every system.
HEARD = 0.2


class Processes:
    """Some processes, which do tasks together with this one."""

    def __init__(self, count: int) -> None:
        """Start so many; they are there a little later."""
        self._waiting: deque[tuple[int, Callable[[int], Task]]] = deque()
        self._more = threading.Semaphore(0)
        self._landed: queue.SimpleQueue[tuple[int, bytes]] = queue.SimpleQueue()
        self._said: set[str] = set()
        running: list[subprocess.Popen[bytes]] = []
        with contextlib.suppress(OSError):  # where no more may be started, fewer help
            for _ in range(count):
                running.append(_start())
        self._close = weakref.finalize(self, _stop, running, self._more)
        for process in running:
            lane = (process, self._waiting, self._more, self._landed)
            threading.Thread(target=_lane, args=lane, daemon=True).start()

    def __enter__(self) -> Processes:
        """The same."""
        return self

    def __exit__(self, *_: object) -> None:
        """End them, whatever they do."""
        self._close()

    def results(
        self,
        count: int,
        task: Callable[[int], Task],
        here: Callable[[int], Any],
        progress: Progress | None = None,
    ) -> list[Any]:
        """What so many tasks come to, in their order.

        This process does them from the first one on, the others from the last: neighbours share kernels.

        Args:
            count: of tasks.
            task: the task of a number.
            here: does the same in this process.
            progress: called with what is done and what there is to do.
        """
        found: dict[int, Any] = {}
        self._waiting.extend((number, task) for number in range(count))
        for _ in range(count):
            self._more.release()
        while len(found) < count:
            if progress is not None:
                progress(len(found), count)
            own = None
            with contextlib.suppress(IndexError):
                own, _ = self._waiting.popleft()
            if own is not None:
                found[own] = here(own)
            with contextlib.suppress(queue.Empty):
                while True:
                    number, data = self._landed.get(timeout=HEARD if own is None else 0)
                    found[number] = self._of(data) if data else here(number)
                    if own is None:
                        break
        return [found[number] for number in range(count)]

    def _of(self, data: bytes) -> Any:
        done: Done = decode(data)
        for note in done.notes:
            if note not in self._said:
                notice(note)
            self._said.add(note)
        return done.value


# --- the threads that speak with the processes -----------------------------------------------------


def _start() -> subprocess.Popen[bytes]:
    # The same search path as here, whatever the working folder holds; Ctrl-C is this process' to hear, and
    # what a model says has been said here
    code = (
        "import signal, sys; signal.signal(signal.SIGINT, signal.SIG_IGN)\n"
        f"sys.path[:] = {sys.path!r}\n"
        f"from gonio.cluster import processes; processes.serve({backend.current()!r})"
    )
    command = [sys.executable, "-c", code]
    return subprocess.Popen(
        command,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
    )


def _lane(
    process: subprocess.Popen[bytes],
    waiting: deque[tuple[int, Callable[[int], Task]]],
    more: threading.Semaphore,
    landed: queue.SimpleQueue[tuple[int, bytes]],
) -> None:
    """Give one process tasks as long as it lives."""
    assert process.stdin is not None
    assert process.stdout is not None
    if _read(process.stdout) is None:  # it has not come up: this one does all
        return
    while True:
        more.acquire()
        try:
            number, task = waiting.pop()
        except IndexError:  # somebody else was faster, or this is the end
            if process.poll() is not None:
                return
            continue
        data = None
        try:
            one = task(number)
            files = {name: str(path) for name, path in one.files.items()}
            _write(process.stdin, json.dumps([one.work, one.title, files]).encode())
            _write(process.stdin, one.data)
            data = _read(process.stdout)
        except (ValueError, OSError):  # cannot be sent, or the process is gone
            pass
        finally:
            landed.put((number, data or NOT_DONE))
        if data is None:
            return


def _stop(running: list[subprocess.Popen[bytes]], more: threading.Semaphore) -> None:
    for process in running:
        process.kill()
    for process in running:
        process.wait()
    more.release(max(len(running), 1))
    for process in running:
        for pipe in (process.stdin, process.stdout):
            if pipe is not None:
                with contextlib.suppress(OSError):
                    pipe.close()


def _write(pipe: IO[bytes], data: bytes) -> None:
    pipe.write(len(data).to_bytes(HEAD, "big") + data)
    pipe.flush()


def _read(pipe: IO[bytes]) -> bytes | None:
    """A message; None if there is nobody any more to write one."""
    head = pipe.read(HEAD)
    size = int.from_bytes(head, "big")
    data = pipe.read(size) if len(head) == HEAD else b""
    return data if len(head) == HEAD and len(data) == size else None


# --- what happens in them --------------------------------------------------------------------------


def serve(name: str) -> None:
    """Do tasks with one thread and this backend until nobody asks for more."""
    # What a model prints is no answer
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
    backend.use(name)
    dr.set_thread_count(1)
    try:
        _write(answers, NOT_DONE)
        while (head := _read(sys.stdin.buffer)) is not None:
            work, title, files = json.loads(head)
            data = _read(sys.stdin.buffer)
            if data is None:
                break
            found = do(work, title, data, _at_hand(files))
            _write(answers, found if isinstance(found, bytes) else NOT_DONE)
    except OSError:  # who asked is gone
        os._exit(1)


def _at_hand(files: dict[str, str]) -> Place:
    """Files where they are, as they were."""

    def place(wanted: str, name: str) -> Path:
        path = Path(files[wanted])
        if digest(path) != wanted:
            raise ValueError(f"{name} has changed.")
        return path

    return place
