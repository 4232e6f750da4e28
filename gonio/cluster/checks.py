"""Checks of models by tasks: each check of each model is one; a long search is a chain of them.

Processes of this machine share the checks of each variant, and need no Dask.
"""

from __future__ import annotations

import contextlib
import dataclasses
import functools
import time
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import drjit as dr

from gonio import backend
from gonio.check import (
    CHECKS,
    ModelSubject,
    Progress,
    Runner,
    Step,
    Subject,
    check_subjects,
    fuzz,
    one_by_one,
)
from gonio.check.report import Effort, Report
from gonio.cluster.codec import NotPortableError, encode
from gonio.cluster.processes import Processes
from gonio.cluster.run import Run
from gonio.cluster.task import Done, Task
from gonio.model import Model

# Cases that a task of a search tries: some seconds. Batches end where its end lies.
CASES = 8 * fuzz.LARGE_BATCH

Described = tuple[Model, tuple[str, ...], str]
"""A model's options and fixed values, what is fixed, and how it is called on the command line."""


def describe(subject: Subject) -> Described:
    """A subject in words that can be sent.

    Raises:
        NotPortableError: it is none of a model of gonio's kind.
    """
    if not isinstance(subject, ModelSubject):
        raise NotPortableError(
            f"{subject.name} is checked on this machine only; leave --cluster out."
        )
    return subject.model, tuple(sorted(subject.fixed)), subject.label


@functools.lru_cache(maxsize=256)
def subject_of(described: Described, name: str) -> ModelSubject:
    """The subject again."""
    model, fixed, label = described
    subject = ModelSubject(model, frozenset(fixed), label)
    subject.name = name
    return subject


def tasks(groups: Sequence[Sequence[Subject]], effort: str, only: Iterable[str] = ()) -> list[Task]:
    """All checks, or those named, of each group of subjects, which are the variants of one model."""
    return [
        Task.of(
            f"{__name__}:check",
            f"{group[0].name}: {name}",
            subjects=tuple(describe(s) for s in group),
            names=tuple(s.name for s in group),
            effort=effort,
            name=name,
        )
        for group in groups
        for name in list(only) or CHECKS
    ]


def reports(
    run: Run, groups: Sequence[Sequence[Subject]], effort: str, only: Iterable[str] = ()
) -> list[Report]:
    """What the tasks find."""
    found: list[Report] = []
    for _, done in run.results(tasks(groups, effort, only)):
        if isinstance(done, Done):
            found += done.value
    return found


def check(
    subjects: tuple[Described, ...], names: tuple[str, ...], effort: str, name: str
) -> list[Report]:
    """The work of a task: one check of all variants of a model."""
    these = [subject_of(s, n) for s, n in zip(subjects, names, strict=True)]
    return list(check_subjects(these, effort, [name]))


# --- on the cores of this machine ----------------------------------------------------------------

# Checks that are worth a process, which comes up in half a second, by effort; with fewer than 5 none is.
EACH = {"quick": 4, "normal": 1}
ENOUGH = 5

# More processes than these wait for the checks of the first variant, which are the longest.
MOST = 8


def worthwhile(groups: Sequence[Sequence[Subject]], effort: str, only: Sequence[str] = ()) -> int:
    """How many processes are worth their start; with the thorough effort one, which has many threads."""
    steps = sum(map(len, groups)) * len(only or CHECKS)
    if effort not in EACH or steps < ENOUGH or backend.current() != "llvm":
        return 1
    try:
        for group in groups:
            encode(describe(group[0]))
    except NotPortableError:
        return 1
    cores: int = dr.thread_count()
    return min(cores, MOST, steps // EACH[effort])


@contextlib.contextmanager
def beside(count: int) -> Iterator[Runner]:
    """Does the steps of `gonio.check.check_subjects` together with so many other processes.

    What they find is the same bit by bit; what they cannot do is done here, and gives its own errors.
    """
    if count < 1:
        yield one_by_one
        return
    with Processes(count) as processes:

        def run(steps: Sequence[Step], progress: Progress | None) -> list[Report]:
            def task(number: int) -> Task:
                one = steps[number]
                return Task.of(
                    f"{__name__}:step",
                    f"{one.subject.name}: {one.check}",
                    subject=describe(one.subject),
                    name=one.subject.name,
                    check=one.check,
                    effort=one.effort,
                )

            begin = time.perf_counter()
            found: list[Report] = processes.results(
                len(steps), task, lambda number: steps[number].run(), progress
            )
            # Seconds are those that were waited for, also where some were spent at the same time
            share = (time.perf_counter() - begin) / max(sum(r.seconds for r in found), 1e-9)
            return [dataclasses.replace(r, seconds=r.seconds * share) for r in found]

        yield run


def step(subject: Described, name: str, check: str, effort: Effort) -> Report:
    """The work of a task: one check of one variant."""
    return Step(subject_of(subject, name), check, effort).run()


# --- long searches ---------------------------------------------------------------------------------


def search(
    run: Run, subjects: Sequence[Subject], count: int, state_file: str | Path | None = None
) -> list[fuzz.State]:
    """`gonio.check.fuzz.run` by tasks, with the same result: one chain for each subject."""
    path = None if state_file is None else Path(state_file)
    states = {(s.model, s.options): s for s in fuzz.load(path)}
    goals = fuzz.goals(subjects, count)
    firsts: list[Task] = []
    own: dict[str, tuple[Subject, int]] = {}

    def next_task(subject: Subject, goal: int, state: fuzz.State) -> Task | None:
        if state.cases >= goal:
            return None
        title = f"{subject.name} {subject.tag()}".strip()
        task = Task.of(
            f"{__name__}:advance",
            f"{title}: cases {state.cases:,} to {min(state.cases + CASES, goal):,}",
            subject=describe(subject),
            name=subject.name,
            # Not part of what the next state depends on
            state=dataclasses.replace(state, seconds=0.0),
            goal=min(state.cases + CASES, goal),
        )
        own[task.title] = (subject, goal)
        return task

    def follow(task: Task, done: Done) -> Task | None:
        subject, goal = own[task.title]
        before = states[subject.name, subject.tag()]
        state: fuzz.State = done.value
        states[state.model, state.options] = dataclasses.replace(
            state, seconds=before.seconds + state.seconds
        )
        if path is not None:
            fuzz.save(path, states.values())
        return next_task(subject, goal, state)

    steps = 0
    for subject, goal in zip(subjects, goals, strict=True):
        state = states.setdefault(
            (subject.name, subject.tag()), fuzz.State(subject.name, subject.tag())
        )
        steps += max(-(-(goal - state.cases) // CASES), 0)
        if (task := next_task(subject, goal, state)) is not None:
            firsts.append(task)
    run.chains(firsts, follow, steps)
    if path is not None:
        fuzz.save(path, states.values())
    return [states[s.name, s.tag()] for s in subjects]


def advance(subject: Described, name: str, state: fuzz.State, goal: int) -> fuzz.State:
    """The work of a task: a search that goes on from a state."""
    fuzz.advance(subject_of(subject, name), state, goal)
    return state
