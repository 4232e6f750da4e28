"""A Dask cluster as an engine: connecting, who may compute, a bounded number of tasks on their way.

`distributed` does what it is good at: it hands tasks to workers, again when one has died, and moves bytes.
"""

from __future__ import annotations

import dataclasses
import json
import logging
import queue
import re
import time
from collections import deque
from collections.abc import Callable
from pathlib import Path
from typing import Any

from gonio.cluster.engine import Report, Skip
from gonio.cluster.identity import Identity, identity
from gonio.cluster.task import Failure, Task
from gonio.cluster.worker import Stranger, content, do_here, ignore_interrupts, who
from gonio.messages import notice

# Seconds after which a scheduler that does not answer is given up.
PATIENCE = 5.0

# Tasks on their way for each worker: one that it does, one that it has ready.
AHEAD = 2

# Results that are fetched together.
BATCH = 64

# How often a task is sent again after its scheduler or its workers have gone.
AGAIN = 3

Tell = Callable[[str], None]
"""Says a line to the user."""


class ClusterError(ValueError):
    """A cluster that cannot be used, or is gone; the message says what to do."""


def connect(text: str, tell: Tell) -> Cluster:
    """A cluster from what stands behind --cluster.

    Args:
        text: "local" for one worker on each core, "local:4", "tcp://host:8786", or a scheduler file.
        tell: says a line, as when workers are waited for.

    Raises:
        ClusterError: Dask is not installed, nobody answers, or workers have other code.
    """
    address = ""
    local = re.fullmatch(r"local(?::(\d+))?", text)
    if re.match(r"\w+://", text):
        address = text
    elif text.endswith(".json"):
        address = _address(Path(text))
    elif local is None:
        raise ClusterError(
            f"--cluster {text!r} is not local, local:N, a scheduler's address such as tcp://host:8786, or "
            "the .json file of 'dask scheduler --scheduler-file'."
        )
    try:
        import dask
        import distributed
    except ImportError:
        raise ClusterError("--cluster needs Dask; run: pip install 'gonio[cluster]'") from None
    # A file's content is part of a task, so that it can be had again; Dask would warn of the size
    dask.config.set({"distributed.admin.large-graph-warning-threshold": "1TB"})
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    if local is not None:
        return _local(distributed, int(local[1]) if local[1] else None)
    try:
        client = distributed.Client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError) as error:
        detail = "" if isinstance(error, TimeoutError) else f" ({' '.join(str(error).split())})"
        raise ClusterError(
            f"no Dask scheduler answers at {address}{detail}; start one with 'dask scheduler', and workers "
            f"with 'dask worker {address}'."
        ) from None
    try:
        return Cluster(client, None, *_strangers_refused(client, address, tell))
    except BaseException:
        client.close(timeout=1)
        raise


def _local(distributed: Any, count: int | None) -> Cluster:
    """Workers on this machine, one thread each, that end with this process."""
    from dask.system import CPU_COUNT

    if count == 0:
        raise ClusterError(
            "--cluster local:0 has no workers; write local, or local:2 and the like."
        )
    # Memory is not watched: a task's results leave its worker at once, and what is large is its scene
    made = distributed.LocalCluster(
        n_workers=count or CPU_COUNT,
        threads_per_worker=1,
        dashboard_address=None,
        memory_limit=0,
        silence_logs=logging.CRITICAL,
    )
    client = distributed.Client(made, set_as_default=False)
    client.run(ignore_interrupts)
    client.register_plugin(_quiet(distributed), name="gonio-quiet")
    return Cluster(client, made, identity(), "local")


def _quiet(distributed: Any) -> Any:
    """A plugin by which workers that are started anew leave Ctrl-C to the client as well."""

    class Quiet(distributed.WorkerPlugin):  # type: ignore[misc]
        def setup(self, worker: Any) -> None:
            ignore_interrupts()

    return Quiet()


def _address(path: Path) -> str:
    """Where the scheduler of a file is."""
    if not path.is_file():
        raise ClusterError(
            f"there is no scheduler file {path}; 'dask scheduler --scheduler-file {path}' writes it when "
            "it has started."
        )
    try:
        return str(json.loads(path.read_text(encoding="utf-8"))["address"])
    except (ValueError, KeyError, TypeError):
        raise ClusterError(
            f"{path} is no scheduler file; 'dask scheduler --scheduler-file {path}' writes one."
        ) from None


def _strangers_refused(client: Any, address: str, tell: Tell) -> tuple[Identity, str]:
    """Who the workers are, all of them alike; and the scheduler's address.

    Raises:
        ClusterError: one of them has other code, or none that is gonio's.
    """
    own = identity()
    there = "install the same there, with the same Python: pip install 'gonio[cluster]'"
    try:
        scheduler = client.run_on_scheduler(who)
    except Exception as error:
        raise ClusterError(
            f"the scheduler at {address} cannot load this gonio ({_short(error)}); {there}."
        ) from None
    if scheduler.python != own.python:
        raise ClusterError(
            f"the scheduler at {address} runs Python {scheduler.python}, here it is {own.python}; {there}."
        )
    found: dict[str, Any] = {}
    waited = False
    while not found:
        there_are = client.nthreads()
        if not there_are and not waited:
            tell(f"{address} has no workers yet; waiting for one (dask worker {address})")
            waited = True
        if there_are:
            # One that dies at this moment says nothing about its code
            answers = client.run(who, on_error="return")
            found = {name: a for name, a in answers.items() if not isinstance(a, OSError)}
        if not found:
            time.sleep(0.5)
    first = next((i for i in found.values() if isinstance(i, Identity)), own)
    # The backend is the workers' own, such as cuda where this machine has no GPU
    expected = dataclasses.replace(own, backend=first.backend)
    for name, other in found.items():
        what = (
            expected.differences(other)
            if isinstance(other, Identity)
            else f"no gonio that loads: {_short(other)}"
        )
        if what:
            raise ClusterError(f"the worker at {name} has {what}; {there}.")
    return expected, address


def _short(error: BaseException) -> str:
    last = error
    while last.__cause__ is not None:
        last = last.__cause__
    return " ".join(f"{type(last).__name__}: {last}".split())[:200]


class Cluster:
    """The workers of a Dask scheduler."""

    shared = True

    def __init__(self, client: Any, local: Any, who: Identity, address: str) -> None:
        """Take a connection, and who its workers are."""
        self.client, self.local = client, local
        self.identity, self.address = who, address
        self.refused: set[str] = set()
        self._files: dict[str, Any] = {}
        self._looked = 0.0
        self._alive: list[str] = []

    def workers(self) -> list[str]:
        """Addresses of the workers that may compute, as they were a second ago."""
        if time.monotonic() - self._looked > 1.0:
            try:
                self._alive = sorted(self.client.nthreads())
            except Exception as error:
                raise self._gone() from error
            self._looked = time.monotonic()
        return [address for address in self._alive if address not in self.refused]

    def work(self, waiting: deque[Task], skip: Skip, report: Report) -> None:
        """Do all tasks, and those that follow from them; `AHEAD` for each worker are on their way."""
        flying: dict[Any, tuple[Task, int, list[str] | None]] = {}
        again: deque[tuple[Task, int]] = deque()
        landed: queue.SimpleQueue[Any] = queue.SimpleQueue()
        try:
            while waiting or again or flying:
                workers = self.workers()
                while (waiting or again) and len(flying) < AHEAD * max(len(workers), 1):
                    task, attempt = again.popleft() if again else (waiting.popleft(), 0)
                    if skip(task):
                        continue
                    only = workers if self.refused else None
                    future = self._send(task, attempt, only)
                    flying[future] = (task, attempt, only)
                    future.add_done_callback(landed.put)
                self._stuck(flying, again)
                for future, found in self._results(landed, flying):
                    task, attempt, _ = flying.pop(future)
                    if isinstance(found, Stranger):
                        self._refuse(found)
                        again.append((task, attempt + 1))
                    elif found is None and attempt < AGAIN:
                        again.append((task, attempt + 1))
                    elif found is None:
                        raise self._gone()
                    else:
                        waiting.extend(report(task, found))
                    future.release()
        finally:
            if flying and self.client.status == "running":
                self.client.cancel(list(flying), force=True)

    def _send(self, task: Task, attempt: int, only: list[str] | None) -> Any:
        contents = {}
        for digest, path in task.files.items():
            if digest not in self._files:
                self._files[digest] = self.client.submit(
                    content, path.read_bytes(), key=f"gonio-file-{digest}"
                )
            contents[digest] = self._files[digest]
        # Two clients that ask one scheduler for the same task share it
        key = f"gonio-{task.key(self.identity)}" + (f"-{attempt}" if attempt else "")
        return self.client.submit(
            do_here,
            task.work,
            task.title,
            task.data,
            contents,
            self.identity,
            key=key,
            workers=only,
        )

    def _results(self, landed: Any, flying: Any) -> list[tuple[Any, Any]]:
        """What has landed within a second: results, failures, strangers; None is to be sent again."""
        arrived: list[Any] = []
        try:
            arrived.append(landed.get(timeout=1.0))
            while len(arrived) < BATCH:
                arrived.append(landed.get_nowait())
        except queue.Empty:
            pass
        if self.client.status not in ("running", "connecting"):
            raise self._gone()
        arrived = [future for future in arrived if future in flying]
        good = [future for future in arrived if future.status == "finished"]
        try:
            found = dict(zip(good, self.client.gather(good), strict=True)) if good else {}
        except Exception:  # who held a result has gone in this moment
            found = {}
        results = []
        for future in arrived:
            if future in found:
                results.append((future, found[future]))
            elif future.status == "error":
                results.append((future, _failure(flying[future][0], future)))
            else:
                results.append((future, None))
        return results

    def _stuck(self, flying: Any, again: deque[tuple[Task, int]]) -> None:
        """Take back what only workers may do that have gone."""
        if not self.refused:
            return
        alive = set(self.workers())
        if not alive:
            raise ClusterError(
                f"no worker at {self.address} has this gonio any more; what is done is kept."
            )
        for future, (task, attempt, only) in list(flying.items()):
            if only is not None and not alive & set(only):
                del flying[future]
                self.client.cancel([future], force=True)
                again.append((task, attempt + 1))

    def _refuse(self, stranger: Stranger) -> None:
        if stranger.address not in self.refused:
            notice(
                f"the worker at {stranger.address} has {stranger.differences}; it gets no tasks."
            )
        self.refused.add(stranger.address)

    def _gone(self) -> ClusterError:
        return ClusterError(
            f"the scheduler at {self.address} has gone; what is done is kept, and the same command goes on "
            "from there."
        )

    def close(self) -> None:
        """Let go of the scheduler, and end workers that were started here."""
        self._files.clear()
        if self.client.status == "running":
            self.client.close(timeout=2)
        if self.local is not None:
            self.local.close(timeout=5)


def _failure(task: Task, future: Any) -> Failure:
    """Why Dask could not do a task; errors of the task itself are results."""
    from distributed.scheduler import KilledWorker

    error = future.exception()
    if isinstance(error, KilledWorker):
        times = error.allowed_failures + 1
        return Failure(
            task.title,
            f"{times} workers died while they did it; perhaps they ran out of memory.",
        )
    return Failure(task.title, _short(error))
