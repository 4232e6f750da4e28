"""What `gonio check` is asked for: everything that is checked, and the files that tell of it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import click

from gonio.check import CHECKS, Progress, check_subjects, notes
from gonio.check.measured_data import DATA_CHECKS, check_file
from gonio.check.named import subjects_of
from gonio.check.picture import check_format, drawable, plot
from gonio.check.report import Report, junit
from gonio.check.subject import ModelSubject, Subject
from gonio.cli._code import Code
from gonio.files import check_place, replacing
from gonio.foreign import Foreign, ForeignError, is_foreign
from gonio.foreign.verdicts import VERDICTS
from gonio.foreign.verdicts import check as check_code
from gonio.measured import is_data_file

if TYPE_CHECKING:
    from gonio.cluster import Run


@dataclass(frozen=True)
class Result:
    """Reports, and the files that were written."""

    reports: list[Report]
    written: list[Path]


@dataclass(frozen=True)
class Plan:
    """What is to be checked and written; everything that a user can get wrong has been looked at."""

    groups: list[list[Subject]]
    only: list[str]
    junit_file: str | None
    picture_file: str | None
    files: list[str] = field(default_factory=list)
    """Of measured reflection."""
    code: list[Foreign] = field(default_factory=list)
    """Functions that others wrote."""
    identify: bool = False
    """Whether to find out which models these are."""

    def run(
        self,
        effort: str = "normal",
        progress: Progress | None = None,
        processes: int | None = None,
    ) -> Result:
        """Check one group after the other, and write what is asked for.

        Args:
            effort: "quick", "normal" or "thorough".
            progress: called with what is done and what there is to do.
            processes: share the checks among so many; None for as many as are worth it.
        """
        # Tasks bring what is needed for clusters
        from gonio.cluster import checks

        reports: list[Report] = []
        wanted = [name for name in self.only if name in CHECKS]
        groups = self.groups if wanted or not self.only else []
        count = checks.worthwhile(groups, effort, wanted) if processes is None else processes
        with checks.beside(count - 1) as runner:
            for done, group in enumerate(groups):

                def step(part: int, parts: int, done: int = done) -> None:
                    if progress is not None:
                        progress(done * 1000 + 1000 * part // parts, len(groups) * 1000)

                checked = check_subjects(group, effort, wanted, step, runner)
                reports += [*notes(group), *checked]
        for path in self.files:
            wanted = [name for name in self.only if name in DATA_CHECKS]
            if wanted or not self.only:
                reports += check_file(path, tuple(wanted))
        for foreign in self.code:
            wanted = [name for name in self.only if name in VERDICTS]
            if wanted or not self.only:
                reports += check_code(foreign, effort, wanted, progress)
            if self.identify:
                from gonio.foreign import identify

                found = identify(foreign, thorough=effort == "thorough", progress=progress)
                reports.append(found.report(foreign.name))
        return self.written(reports)

    def share(self, run: Run, effort: str = "normal") -> Result:
        """The same by tasks: each check of each model is one.

        Raises:
            UsageError: something in the plan that is no model of gonio's kind.
        """
        if self.others or any(not isinstance(s, ModelSubject) for g in self.groups for s in g):
            what = self.others[0] if self.others else "--mitsuba"
            raise click.UsageError(
                f"--cluster and --run-dir are for models and materials; check {what} without them"
            )
        from gonio.cluster import checks

        wanted = [name for name in self.only if name in CHECKS]
        groups = self.groups if wanted or not self.only else []
        found = checks.reports(run, groups, effort, wanted)
        return self.written([*(note for group in groups for note in notes(group)), *found])

    @property
    def others(self) -> list[str]:
        """Names of what is no model and no material."""
        return [*self.files, *(foreign.name for foreign in self.code)]

    def written(self, reports: list[Report]) -> Result:
        """Write the files that are asked for."""
        written = []
        if self.junit_file is not None:
            with replacing(self.junit_file) as temporary:
                temporary.write_bytes(junit(reports))
            written.append(Path(self.junit_file))
        if self.picture_file is not None:
            every = [subject for group in self.groups for subject in group]
            if drawable(every, reports):
                written.append(plot(self.picture_file, every, reports))
        return Result(reports, written)


def plan(
    texts: Sequence[str],
    params: Iterable[str] = (),
    *,
    plugins: Sequence[str] = (),
    only: Iterable[str] = (),
    junit_file: str | None = None,
    picture_file: str | None = None,
    code: Code | None = None,
    identify: bool = False,
) -> Plan:
    """Find everything that the texts name.

    Args:
        texts: models, materials and model files, as `subjects_of` takes them, and files of measured
            reflection.
        params: "name=value" for all of them.
        plugins: Mitsuba's BSDFs, as `gonio.check.mitsuba_bsdf.MitsubaSubject` takes them.
        only: names of checks; all if empty.
        junit_file: where to write a JUnit report.
        picture_file: where to draw the worst cases.
        code: options of code that others wrote; texts that name such a file are code.
        identify: find out which models that code is.

    Raises:
        ValueError: an unknown name, check or format.
    """
    chosen = [name.strip() for name in only]
    for name in chosen:
        if name not in CHECKS and name not in DATA_CHECKS and name not in VERDICTS:
            known = ", ".join(dict.fromkeys([*CHECKS, *DATA_CHECKS, *VERDICTS]))
            raise ValueError(f"no check {name!r}; there are {known}.")
    check_places(junit_file, picture_file)
    given = list(params)
    files = [text for text in texts if is_data_file(text)]
    if files and given:
        raise ValueError(f"{files[0]} is a measurement and has no parameters.")
    foreign = [text for text in texts if is_foreign(text)]
    if foreign and given:
        raise ForeignError(f"{foreign[0]} is code; --uniform NAME=VALUE keeps one of its numbers.")
    if foreign and picture_file is not None:
        raise ForeignError(f"--plot draws models; {foreign[0]} is code.")
    if not foreign and (identify or (code is not None and code.given)):
        raise ForeignError(
            "--function, --map and the like belong to a FILE of code, such as x.glsl#eval."
        )
    if foreign and chosen and not set(chosen) & set(VERDICTS):
        raise ForeignError(f"code has values only; its checks are {', '.join(VERDICTS)}.")
    groups = [subjects_of(t, given) for t in texts if t not in files and t not in foreign]
    loaded = _loaded(foreign, code) if code is not None else []
    if plugins:
        from gonio.check.mitsuba_bsdf import sides_of

        groups += [[*sides_of(text, given)] for text in plugins]
    if picture_file is not None and files:
        raise ValueError(
            f"{files[0]} is a measurement; 'gonio data {files[0]} --picture {picture_file}' draws it."
        )
    return Plan(groups, chosen, junit_file, picture_file, files, loaded, identify)


def _loaded(texts: Sequence[str], code: Code) -> list[Foreign]:
    """Functions that others wrote; two files of one name, in two folders, are told apart."""
    found = [code.load(text) for text in texts]
    names = [each.name for each in found]
    for each in found:
        each.alias = each.label if names.count(each.name) > 1 else ""
    return found


def check_places(junit_file: str | None, picture_file: str | None) -> None:
    """Raise before the work is done if a result cannot be written."""
    if junit_file is not None:
        check_place(junit_file)
    if picture_file is not None:
        check_format(picture_file)
