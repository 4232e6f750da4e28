"""Proof for a model: checks that measure what it claims, each with the worst case it could find.

    from gonio import check
    reports = check.check_model(gonio.model("qon"), effort="quick")
    print(reports)                             # a table; in a notebook, `reports` alone shows one

Every module here is one check, `check(subject, effort) -> Report`; `CHECKS` is all of them.
"""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gonio.check import (
    albedo,
    all_parts,
    continuity,
    finite,
    gradient,
    isotropy,
    kernels,
    monotonicity,
    reciprocity,
    sampling,
)
from gonio.check.adversarial import hard_numbers, hard_pairs, hard_parameters
from gonio.check.dark import judged
from gonio.check.report import (
    EFFORTS,
    NOTE,
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
from gonio.check.subject import Array, ModelSubject, Subject
from gonio.check.variants import options, pairs
from gonio.model import Model, models

__all__ = [
    "CHECKS",
    "Effort",
    "Finding",
    "ModelSubject",
    "Report",
    "Reports",
    "Runner",
    "Step",
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
    "energy": all_parts.check,
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
OF_VALUES = {"energy", "reciprocity", "albedo", "continuity", "monotonicity"}

# The check of samplers: where those of two variants are the same, one is tested.
SAMPLING = "sampling"

# Every so many hard pairs tell whether two variants have the same values or samples.
ALIKE = 3

# So many albedos that take long.
FEW = 64

Progress = Callable[[int, int], None]


def subjects(
    model: Model | type[Model], fixed: Iterable[str] = (), label: str | None = None
) -> list[Subject]:
    """What there is to check of a model.

    A class, or a model with nothing fixed: its whole range, once with the default options, once with each
    other choice of each option, and with choices of two options together until all pairs have met. With
    something fixed: that one model.

    Args:
        model: to be checked.
        fixed: paths of parameters, and names of options, that keep the model's values.
        label: how the model is called on the command line, if not by its name.
    """
    model = model() if isinstance(model, type) else model
    kept = frozenset(fixed)
    if kept:
        return [ModelSubject(model, kept, label)]
    cls = model.written
    return [
        ModelSubject(model.replace(**choice), frozenset(), label)
        for choice in [*options(cls), *pairs(cls)]
    ]


@dataclass(frozen=True)
class Step:
    """One check of one subject."""

    subject: Subject
    check: str
    effort: Effort

    def run(self) -> Report:
        """Measure."""
        # What is no number fails, and is named: NumPy need not warn of it
        with faults(self.subject), np.errstate(invalid="ignore", over="ignore"):
            report = judged(self.subject, self._run())
            return replace(report, findings=tuple(map(self._in_whole, report.findings)))

    def _in_whole(self, finding: Finding) -> Finding:
        """The finding; that nothing comes near a size is shown by the whole range and all options alone."""
        if not finding.overstated:
            return finding
        return replace(finding, replay=self.subject.recheck(self.check))

    def _run(self) -> Report:
        report = CHECKS[self.check](self.subject, self.effort)
        if self.effort.bounds:
            return report.within_bounds()
        # That nothing comes near a documented size is said after whole searches
        for whole in self.effort.whole():
            if not report.overstated:
                break
            report = CHECKS[self.check](self.subject, whole)
        return report


Runner = Callable[[Sequence[Step], Progress | None], Iterable[Report]]
"""Does steps, in whatever order, and gives their reports in theirs."""


def one_by_one(steps: Sequence[Step], progress: Progress | None) -> Iterator[Report]:
    """The steps in this process."""
    for done, step in enumerate(steps):
        if progress is not None:
            progress(done, len(steps))
        yield step.run()


def check_subjects(
    these: Iterable[Subject],
    effort: str | Effort = "normal",
    only: Iterable[str] = (),
    progress: Progress | None = None,
    runner: Runner = one_by_one,
) -> Reports:
    """Run all checks, or `only` those named, and put what belongs together into one report each.

    The first subject gets the whole effort, variants of it less. `runner` does the steps.
    """
    level = EFFORTS[effort] if isinstance(effort, str) else effort
    with kernels.one_thread() if level.small else contextlib.nullcontext():
        return _check_subjects(list(these), level, list(only), progress, runner)


def _check_subjects(
    these: list[Subject], level: Effort, only: list[str], progress: Progress | None, runner: Runner
) -> Reports:
    chosen = only or list(CHECKS)
    subjects = _efforts(these, level)
    for subject, _ in subjects:
        subject.prepare()
    alike, sampled_alike = _alike(
        [s for s, _ in subjects], bool(set(chosen) & OF_VALUES), SAMPLING in chosen
    )
    steps: list[Step] = []
    reports: list[Report | None] = []  # None where a step says it
    for subject, amount in subjects:
        for name in chosen:
            if name in OF_VALUES and subject.tag() in alike:
                text = f"the values are those {alike[subject.tag()]}, bit by bit"
                finding = Finding("differs from the default", 0.0, PASS, text, subject.tag())
                reports.append(judged(subject, Report(name, subject.name, (finding,))))
                continue
            tested = name == SAMPLING and subject.tag() in sampled_alike
            steps.append(Step(subject, name, replace(amount, tests=0) if tested else amount))
            reports.append(None)
    measured = iter(runner(steps, progress))
    found: dict[tuple[str, str], Report] = {}
    for given in reports:
        report = next(measured) if given is None else given
        key = (report.model, report.check)
        if given is not None and not found.get(key, report).findings:
            continue  # that nothing was measured is no verdict on what is alike
        if key in found:
            report = replace(
                found[key],
                findings=found[key].findings + report.findings,
                seconds=found[key].seconds + report.seconds,
            )
        found[key] = report
    return Reports(report for report in found.values() if report.findings)


def notes(these: Iterable[Subject]) -> list[Report]:
    """What was left out of the checks of these, and what else is to be known, each once."""
    found: dict[tuple[str, str], dict[Finding, None]] = {}
    for subject in these:
        if len(subject.varied) < 2:  # what two options do together, each does by itself
            for remark in subject.notes():
                own = found.setdefault((remark.check, subject.name), {})
                own[Finding(remark.what, 0.0, NOTE, remark.text)] = None
    return [Report(*key, tuple(findings)) for key, findings in found.items()]


@contextlib.contextmanager
def faults(subject: Subject) -> Iterator[None]:
    """What goes wrong inside a subject's own code, in the subject's words."""
    try:
        yield
    except Exception as error:
        better = subject.fault(error)
        if better is error:
            raise
        raise better from error


def _alike(
    these: Sequence[Subject], of_values: bool, of_samples: bool
) -> tuple[dict[str, str], dict[str, str]]:
    """Tags of the subjects that give what an earlier one gives, and in words which: values, and samples.

    Args:
        these: subjects.
        of_values: whether the first of the two is asked for.
        of_samples: whether the second one is.
    """
    alike: tuple[dict[str, str], dict[str, str]] = ({}, {})
    if len(these) < 2 or not (of_values or of_samples):
        return alike
    wi, wo = (w[::ALIKE].astype(np.float64) for w in hard_pairs())
    parameters = hard_parameters(these[0], len(wi), 71)
    index = np.arange(len(wi), dtype=np.uint32)
    seen: tuple[dict[tuple[str, bytes], Subject], ...] = ({}, {})
    for subject in these:
        if subject.parameters != these[0].parameters:  # another kind of subject
            continue
        with faults(subject):
            f, pdf = kernels.evaluate(subject, parameters, index, wi, wo)
            given = (
                _values(subject, parameters, wo, f) if of_values else None,
                _samples(subject, parameters, index, wo, pdf) if of_samples else None,
            )
        for found, before, bits in zip(alike, seen, given, strict=True):
            twin = subject if bits is None else before.setdefault((subject.name, bits), subject)
            if twin is not subject:
                options = f"with {twin.tag()}" if twin.tag() else "of the default options"
                found[subject.tag()] = options
    return alike


def _values(subject: Subject, parameters: Array, wo: Array, f: NDArray[Any]) -> bytes:
    """Values and closed-form albedos at hard pairs, bit by bit."""
    found = [f.tobytes(), subject.albedos.encode()]
    if subject.albedos == "closed form":
        found.append(kernels.albedo(subject, parameters, wo).tobytes())
    elif subject.albedos == "composed":
        few = slice(0, None, max(len(wo) // FEW, 1))
        found.append(kernels.albedo(subject, parameters[few], wo[few]).tobytes())
    return b"".join(found)


def _samples(
    subject: Subject, parameters: Array, index: NDArray[np.uint32], wo: Array, pdf: NDArray[Any]
) -> bytes:
    """Samples and densities at hard cases, bit by bit."""
    u = hard_numbers(len(wo), 72).astype(np.float64)
    drawn = kernels.draw(subject, parameters, index, wo, u)
    return b"".join(part.tobytes() for part in (*drawn, pdf))


def _efforts(these: list[Subject], level: Effort) -> list[tuple[Subject, Effort]]:
    """Every subject with the effort that it gets; of pairs of options as many as are affordable."""
    found: list[tuple[Subject, Effort]] = []
    first = these[0].chosen if these else {}
    single = sum(_changed(subject, first) < 2 for subject in these)
    left = max(level.variants - single, 0)
    for number, subject in enumerate(these):
        if number == 0 or subject.name != these[0].name:
            found.append((subject, level))
        elif _changed(subject, first) < 2:
            found.append((subject, level.less()))
        elif left > 0:
            left -= 1
            # Each of these options has been looked at by itself; left is what they do to each other
            found.append((subject, replace(level.less().less(), briefly=True)))
    return found


def _changed(subject: Subject, first: Mapping[str, str]) -> int:
    """How many options differ from those of the first subject."""
    return sum(value != first.get(name) for name, value in subject.chosen.items())


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
    these = subjects(model, fixed, label)
    reports = check_subjects(these, effort, only, progress)
    return Reports([*notes(these), *reports])


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
