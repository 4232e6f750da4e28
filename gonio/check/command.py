"""What `gonio check` does: finds out what is meant, runs the checks, shows and writes the reports."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from gonio.check import CHECKS, Progress, check_subjects, data, failed, subjects
from gonio.check.picture import check_format, drawable, plot
from gonio.check.report import FAIL, Report, junit, summary, table
from gonio.check.subject import Subject
from gonio.files import replacing
from gonio.material import Material, library, load_material
from gonio.model import models
from gonio.notation import parse_model

__all__ = ["Plan", "Result", "data", "failed", "lines", "plan", "subjects_of"]


def subjects_of(text: str, params: Iterable[str] = ()) -> list[Subject]:
    """What a text on the command line names: a model, a material, or a model file.

    A bare name is a model over its whole range and all its options. Parameters and options that are given,
    as in eon:sampler=cosine,rho=0.5, stay fixed, and the others keep their whole range or the default
    option. A material is fixed altogether.

    Raises:
        ValueError: an unknown name, a parameter out of range, a file without a usable model.
    """
    given = list(params)
    name, _, inline = text.partition(":")
    if name not in models() and (name in library() or name.endswith(".toml")):
        if inline or given:
            raise ValueError(
                f"{name} is a material and has its parameters; check its model instead."
            )
        return _of_material(load_material(name))
    model = parse_model(text, given)
    if not (inline or given):
        return subjects(type(model), label=name)
    named = {piece.partition("=")[0].strip() for piece in [*inline.split(","), *given]}
    return subjects(model, named, name)


def _of_material(material: Material) -> list[Subject]:
    """A material as it is; what pictures, flakes and growth drive keeps its whole range."""
    driven = set(material.textures)
    if material.flakes:
        driven |= {"flake_x", "flake_y"}
    if material.grows:
        driven.add("growth")
    model = material.model
    paths = {path for path, _, _ in model.parameters()}
    found = subjects(model, (paths - driven) | set(model.fields) - driven, model.name)
    for subject in found:
        subject.name = material.name
    return found


@dataclass(frozen=True)
class Result:
    """Reports, and the files that were written."""

    reports: list[Report]
    written: list[Path]


@dataclass(frozen=True)
class Plan:
    """What is to be checked and written; everything that a user can get wrong has been looked at."""

    groups: list[list[Subject]]
    notes: list[Report]
    only: list[str]
    junit_file: str | None
    picture_file: str | None

    def run(self, effort: str = "normal", progress: Progress | None = None) -> Result:
        """Check one group after the other, and write what is asked for.

        Args:
            effort: "quick", "normal" or "thorough".
            progress: called with what is done and what there is to do.
        """
        reports = list(self.notes)
        for done, group in enumerate(self.groups):

            def step(part: int, parts: int, done: int = done) -> None:
                if progress is not None:
                    progress(done * 1000 + 1000 * part // parts, len(self.groups) * 1000)

            reports += check_subjects(group, effort, self.only, step)
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
) -> Plan:
    """Find everything that the texts name.

    Args:
        texts: models, materials and model files, as `subjects_of` takes them.
        params: "name=value" for all of them.
        plugins: Mitsuba's BSDFs, as `gonio.check.mitsuba_bsdf.MitsubaSubject` takes them.
        only: names of checks; all if empty.
        junit_file: where to write a JUnit report.
        picture_file: where to draw the worst cases.

    Raises:
        ValueError: an unknown name, check or format.
    """
    chosen = [name.strip() for name in only]
    for name in chosen:
        if name not in CHECKS:
            raise ValueError(f"no check {name!r}; there are {', '.join(CHECKS)}.")
    _writable(junit_file, picture_file)
    given = list(params)
    groups = [subjects_of(text, given) for text in texts]
    notes: list[Report] = []
    if plugins:
        from gonio.check.mitsuba_bsdf import MitsubaSubject

        foreign = [MitsubaSubject(text) for text in plugins]
        notes = [note for subject in foreign for note in subject.notes()]
        groups += [[subject] for subject in foreign]
    return Plan(groups, notes, chosen, junit_file, picture_file)


def lines(reports: Sequence[Report]) -> list[str]:
    """The tables of all models, each with a line of counts below."""
    found: list[str] = []
    for name in dict.fromkeys(r.model for r in reports):
        own = [r for r in reports if r.model == name]
        seconds = sum(r.seconds for r in own)
        state = FAIL if failed(own) else "pass"
        found += [f"{name}: {state}", *table(own), f"  {summary(own)} in {seconds:.1f} s", ""]
    return found[:-1]


def _writable(junit_file: str | None, picture_file: str | None) -> None:
    """Raise before the work is done if a result cannot be written."""
    for path in (junit_file, picture_file):
        if path is not None and not Path(path).resolve().parent.is_dir():
            folder = Path(path).resolve().parent
            raise FileNotFoundError(f"there is no folder {folder}; create it first.")
    if picture_file is not None:
        check_format(picture_file)
