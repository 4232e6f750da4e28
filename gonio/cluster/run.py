"""A run: tasks done once, their results kept, whoever does them and however often it is begun."""

from __future__ import annotations

import random
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence

from gonio.cluster.codec import decode
from gonio.cluster.engine import Engine, Found
from gonio.cluster.folder import RunFolder
from gonio.cluster.task import Done, Failure, Task
from gonio.messages import notice

Progress = Callable[[int, int], None]
Follow = Callable[[Task, Done], Task | None]


class Run:
    """Tasks on an engine, with a folder for their results."""

    def __init__(
        self,
        engine: Engine,
        folder: RunFolder | None = None,
        progress: Progress | None = None,
        tell: Callable[[str], None] | None = None,
    ) -> None:
        """Take who does the tasks, and where results are kept.

        Args:
            engine: does the tasks.
            folder: for results; None keeps none, so that nothing can be gone on with.
            progress: called with the tasks that are done, and all of them.
            tell: says a line to the user.
        """
        self.engine, self.folder = engine, folder
        self.progress, self.tell = progress, tell
        self.failures: list[Failure] = []
        self._said: set[str] = set()

    def results(self, tasks: Sequence[Task]) -> Iterator[tuple[Task, Done | Failure]]:
        """What each task has come to, in the order of the tasks, whoever did them in whatever order.

        Without a folder each is done when it is asked for, and none is kept.
        """
        keys = {id(task): self._key(task) for task in tasks}
        failed: dict[str, Failure] = {}
        if self.folder is None:
            for number, task in enumerate(tasks):
                self._step(number, len(tasks))
                yield task, self._finished(task, self._now(task))
            self._step(len(tasks), len(tasks))
            return
        folder = self.folder
        unique = list({keys[id(task)]: task for task in tasks}.values())
        missing = [task for task in unique if not folder.has(keys[id(task)])]
        self._resumed(len(unique) - len(missing), len(unique))
        done = len(unique) - len(missing)
        # From a place of its own, so that two clients with one folder meet late
        start = random.randrange(len(missing)) if missing else 0
        self._step(done, len(unique))

        def report(task: Task, found: Found) -> Iterable[Task]:
            nonlocal done
            done += 1
            if isinstance(found, Failure):
                failed[keys[id(task)]] = found
            else:
                folder.put(keys[id(task)], found)
            self._step(done, len(unique))
            return ()

        def skip(task: Task) -> bool:
            nonlocal done
            there = folder.has(keys[id(task)])
            done += there
            return there

        self.engine.work(deque(missing[start:] + missing[:start]), skip, report)
        for task in tasks:
            found: Found | None = failed.get(keys[id(task)])
            if found is None:
                found = folder.get(keys[id(task)])
            if found is None:  # damaged, or removed by another client that was ready earlier
                found = self._now(task)
                if isinstance(found, bytes):
                    folder.put(keys[id(task)], found)
            yield task, self._finished(task, found)

    def chains(self, firsts: Sequence[Task], follow: Follow, steps: int) -> None:
        """Do tasks of which each decides the next.

        Args:
            firsts: the first task of each chain.
            follow: takes what a task has come to, and gives the next one, or None at the end.
            steps: how many tasks there are in all, for the progress.
        """
        done = 0

        def undone(task: Task | None) -> Iterable[Task]:
            """The first task of a chain that has no result yet."""
            nonlocal done
            while task is not None:
                found = None if self.folder is None else self.folder.get(self._key(task))
                if found is None:
                    return (task,)
                done += 1
                task = follow(task, self._of(found))
            return ()

        def report(task: Task, found: Found) -> Iterable[Task]:
            nonlocal done
            finished = self._finished(task, found)
            if isinstance(found, bytes) and self.folder is not None:
                self.folder.put(self._key(task), found)
            done += 1
            self._step(min(done, steps), steps)
            return undone(follow(task, finished) if isinstance(finished, Done) else None)

        waiting = deque(task for first in firsts for task in undone(first))
        self._resumed(done, steps)
        self._step(min(done, steps), steps)
        self.engine.work(waiting, lambda task: False, report)

    def _key(self, task: Task) -> str:
        return task.key(self.engine.identity)

    def _now(self, task: Task) -> Found:
        results: list[Found] = []

        def report(task: Task, found: Found) -> Iterable[Task]:
            results.append(found)
            return ()

        self.engine.work(deque([task]), lambda task: False, report)
        return results[0]

    def _finished(self, task: Task, found: Found) -> Done | Failure:
        if isinstance(found, Failure):
            self.failures.append(found)
            return found
        return self._of(found)

    def _of(self, found: bytes) -> Done:
        done: Done = decode(found)
        for note in done.notes:
            if note not in self._said:
                notice(note)
            self._said.add(note)
        return done

    def _resumed(self, done: int, all_: int) -> None:
        if done and self.tell is not None and self.folder is not None:
            self.tell(f"{done} of {all_} tasks are done already, in {self.folder.path}")

    def _step(self, done: int, all_: int) -> None:
        if self.progress is not None:
            self.progress(done, all_)
