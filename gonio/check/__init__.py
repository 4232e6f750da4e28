"""Proof for a model: checks that measure what it claims, each with the worst case it could find.

    from gonio import check
    reports = check.check_model(gonio.model("qon"), effort="quick")
    print(reports)                             # a table; in a notebook, `reports` alone shows one

Every module here is one check, `check(subject, effort) -> Report`; `CHECKS` is all of them.
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace

import numpy as np

from gonio.check import (
    albedo,
    continuity,
    energy,
    finite,
    gradient,
    isotropy,
    monotonicity,
    reciprocity,
    sampling,
)
from gonio.check.adversarial import hard_pairs, places
from gonio.check.report import (
    EFFORTS,
    PASS,
    Effort,
    Finding,
    Report,
    Reports,
    data,
    junit,
    summary,
    table,
)
from gonio.check.subject import ModelSubject, Subject, evaluate
from gonio.check.variants import options
from gonio.model import Model, models

__all__ = [
    "CHECKS",
    "Effort",
    "Finding",
    "ModelSubject",
    "Report",
    "Reports",
    "Subject",
    "check_all",
    "check_model",
    "check_subjects",
    "data",
    "failed",
    "junit",
    "subjects",
    "summary",
    "table",
]

CHECKS: dict[str, Callable[[Subject, Effort], Report]] = {
    "energy": energy.check,
    "reciprocity": reciprocity.check,
    "finite": finite.check,
    "gradient": gradient.check,
    "sampling": sampling.check,
    "albedo": albedo.check,
    "isotropy": isotropy.check,
    "continuity": continuity.check,
    "monotonicity": monotonicity.check,
}

# Checks that depend on nothing but the values: options that only change the sampler need them once.
OF_VALUES = {"energy", "reciprocity", "albedo", "isotropy", "continuity", "monotonicity"}

Progress = Callable[[int, int], None]


def subjects(
    model: Model | type[Model], fixed: Iterable[str] = (), label: str | None = None
) -> list[Subject]:
    """What there is to check of a model.

    A class, or a model with nothing fixed: its whole range, once with the default options and once with
    each other choice of each option. With something fixed: that one model.

    Args:
        model: to be checked.
        fixed: paths of parameters, and names of options, that keep the model's values.
        label: how the model is called on the command line, if not by its name.
    """
    model = model() if isinstance(model, type) else model
    kept = frozenset(fixed)
    if kept:
        return [ModelSubject(model, kept, label)]
    return [
        ModelSubject(model.replace(**choice), frozenset(), label) for choice in options(type(model))
    ]


def check_subjects(
    these: Iterable[Subject],
    effort: str | Effort = "normal",
    only: Iterable[str] = (),
    progress: Progress | None = None,
) -> Reports:
    """Run all checks, or `only` those named, and put what belongs together into one report each."""
    level = EFFORTS[effort] if isinstance(effort, str) else effort
    chosen = {name: CHECKS[name] for name in (list(only) or CHECKS)}
    these = list(these)
    found: dict[tuple[str, str], Report] = {}
    steps = list(itertools.product(these, chosen.items()))
    alike = {
        subject.tag()
        for subject in these[1:]
        if set(chosen) & OF_VALUES and same(these[0], subject)
    }
    for done, (subject, (name, run)) in enumerate(steps):
        if progress is not None:
            progress(done, len(steps))
        if name in OF_VALUES and subject.tag() in alike:
            text = "the values are those of the default options, bit by bit"
            finding = Finding("differs from the default", 0.0, PASS, text, subject.tag())
            report = Report(name, subject.name, (finding,))
        else:
            report = run(subject, level)
        key = (subject.name, name)
        if key in found:
            report = replace(
                found[key],
                findings=found[key].findings + report.findings,
                seconds=found[key].seconds + report.seconds,
            )
        found[key] = report
    return Reports(report for report in found.values() if report.findings)


def check_model(
    model: Model | type[Model],
    effort: str | Effort = "normal",
    *,
    fixed: Iterable[str] = (),
    only: Iterable[str] = (),
    label: str | None = None,
    progress: Progress | None = None,
) -> Reports:
    """Check a model over its whole range and all options, or one with some parameters `fixed`.

    Args:
        model: a model or its class.
        effort: "quick", "normal" or "thorough".
        fixed: paths of parameters that keep the model's values.
        only: names of checks; all of CHECKS if empty.
        label: how the model is called on the command line, if not by its name.
        progress: called with what is done and what there is to do.
    """
    return check_subjects(subjects(model, fixed, label), effort, only, progress)


def same(first: Subject, other: Subject) -> bool:
    """Whether two subjects are variants of one model with the same values and albedos everywhere."""
    if not isinstance(first, ModelSubject) or not isinstance(other, ModelSubject):
        return False
    if type(first.model) is not type(other.model) or first.columns != other.columns:
        return False
    wi, wo = (w.astype(np.float64) for w in hard_pairs())
    where = places(len(wi), len(first.columns), 71)
    index = np.arange(len(wi), dtype=np.uint32)
    a, b = (evaluate(s, where, index, wi, wo)[0] for s in (first, other))
    if not np.array_equal(a, b, equal_nan=True):
        return False
    if not first.closed_form:
        return True
    own, others = (finite.closed_albedo(s, where, wo) for s in (first, other))
    return np.array_equal(own, others, equal_nan=True)


def check_all(
    effort: str | Effort = "normal",
    only: Iterable[str] = (),
    progress: Progress | None = None,
) -> Iterator[tuple[str, Reports, float]]:
    """Check every registered model; yields name, reports and seconds as they come."""
    registered = models()
    for done, (name, cls) in enumerate(registered.items()):
        start = time.perf_counter()

        def step(part: int, parts: int, done: int = done) -> None:
            if progress is not None:
                progress(done * 1000 + 1000 * part // parts, len(registered) * 1000)

        reports = check_model(cls, effort, only=only, progress=step)
        yield name, reports, time.perf_counter() - start


def failed(reports: Iterable[Report]) -> bool:
    """Whether something is not as it is claimed."""
    return any(report.failed for report in reports)
