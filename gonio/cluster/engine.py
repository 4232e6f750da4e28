"""Who does the tasks: this process, or the workers of a Dask cluster. Both do the same."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Protocol

from gonio.cluster.identity import Identity, identity
from gonio.cluster.task import Failure, Task, do

Found = bytes | Failure
Report = Callable[[Task, Found], Iterable[Task]]
"""Takes what a task has come to, and gives tasks that can only be known now."""
Skip = Callable[[Task], bool]
"""Whether a task has become needless since it was put into the queue."""


class Engine(Protocol):
    """Does tasks in any order."""

    identity: Identity
    """Of those who compute."""
    shared: bool
    """Whether others compute, and results can come in another order than tasks."""

    def work(self, waiting: deque[Task], skip: Skip, report: Report) -> None:
        """Do all tasks, and those that follow from them."""

    def close(self) -> None:
        """Let go of all that it holds."""


def at_hand(files: Mapping[str, Path]) -> Callable[[str, str], Path]:
    """Files where they are."""
    return lambda digest, name: files[digest]


class Here:
    """This process: one task after the other."""

    shared = False

    def __init__(self) -> None:
        """Take the backend in force."""
        self.identity = identity()

    def work(self, waiting: deque[Task], skip: Skip, report: Report) -> None:
        """Do all tasks, and those that follow from them."""
        while waiting:
            task = waiting.popleft()
            if not skip(task):
                found = do(task.work, task.title, task.data, at_hand(task.files))
                waiting.extend(report(task, found))

    def close(self) -> None:
        """Nothing is held."""
