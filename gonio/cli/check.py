"""What `gonio check` does: finds out what is meant, runs the checks, shows and writes the reports."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import click

import gonio
from gonio.check import CHECKS, Progress, check_subjects, data, failed, subjects
from gonio.check import fuzz as fuzz_search
from gonio.check.measured_data import DATA_CHECKS, check_file
from gonio.check.picture import check_format, drawable, plot
from gonio.check.report import FAIL, NOTE, PASS, UNSURE, Report, junit, summary, table
from gonio.check.subject import ModelSubject, Subject
from gonio.cli import _baseline as baselines
from gonio.cli._cluster import cluster_options, run_of
from gonio.cli._code import Code, code_options
from gonio.cli.program import complete, echo_json, json_option, param_option, progress
from gonio.files import check_place, replacing
from gonio.foreign import Foreign, ForeignError, is_foreign
from gonio.foreign import check as check_code
from gonio.foreign import identify as identify_code
from gonio.foreign.verdicts import VERDICTS
from gonio.materials import Material, load
from gonio.materials.notation import split
from gonio.measured import is_data_file

if TYPE_CHECKING:
    from gonio.cluster import Run

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
    name, pieces = split(text)
    found = load(text, given)
    if isinstance(found, Material):
        return _of_material(found)
    if not (pieces or given):
        return subjects(found.written, label=name)
    named = {piece.partition("=")[0].strip() for piece in [*pieces, *given]}
    return subjects(found, named, name)


def _of_material(material: Material) -> list[Subject]:
    """A material as it is; what pictures, flakes and growth drive keeps its whole range."""
    driven = {*material.textures, *material.driven_by_maps()}
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

    @property
    def unjudged(self) -> bool:
        """Whether of something nothing at all could be judged, as of code that is black."""
        names = {r.model for r in self.reports}
        return any(_state([r for r in self.reports if r.model == n]) == UNSURE for n in names)


@dataclass(frozen=True)
class Plan:
    """What is to be checked and written; everything that a user can get wrong has been looked at."""

    groups: list[list[Subject]]
    notes: list[Report]
    only: list[str]
    junit_file: str | None
    picture_file: str | None
    files: list[str] = field(default_factory=list)
    """Of measured reflection."""
    code: list[Foreign] = field(default_factory=list)
    """Functions that others wrote."""
    identify: bool = False
    """Whether to find out which models these are."""

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

            wanted = [name for name in self.only if name in CHECKS]
            if wanted or not self.only:
                reports += check_subjects(group, effort, wanted, step)
        for path in self.files:
            wanted = [name for name in self.only if name in DATA_CHECKS]
            if wanted or not self.only:
                reports += check_file(path, tuple(wanted))
        for foreign in self.code:
            wanted = [name for name in self.only if name in VERDICTS]
            if wanted or not self.only:
                reports += check_code(foreign, effort, wanted, progress)
            if self.identify:
                found = identify_code(foreign, thorough=effort == "thorough", progress=progress)
                reports.append(found.report(foreign.name))
        return self._written(reports)

    def share(self, run: Run, effort: str = "normal") -> Result:
        """The same by tasks: each check of each model is one.

        Raises:
            UsageError: something in the plan that is no model of gonio's kind.
        """
        others = [*self.files, *(foreign.name for foreign in self.code)]
        if (
            others
            or self.notes
            or any(not isinstance(s, ModelSubject) for g in self.groups for s in g)
        ):
            what = others[0] if others else "--mitsuba"
            raise click.UsageError(
                f"--cluster and --run-dir are for models and materials; check {what} without them"
            )
        from gonio.cluster import checks

        wanted = [name for name in self.only if name in CHECKS]
        groups = self.groups if wanted or not self.only else []
        return self._written(checks.reports(run, groups, effort, wanted))

    def _written(self, reports: list[Report]) -> Result:
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
    _writable(junit_file, picture_file)
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
    plain = [text for text in texts if text not in files and text not in foreign]
    if foreign and chosen and not set(chosen) & set(VERDICTS):
        raise ForeignError(f"code has values only; its checks are {', '.join(VERDICTS)}.")
    groups = [subjects_of(text, given) for text in plain]
    loaded = [code.load(text) for text in foreign] if code is not None else []
    names = [each.name for each in loaded]
    for each in loaded:  # two files of one name, in two folders
        each.alias = each.label if names.count(each.name) > 1 else ""
    notes: list[Report] = []
    if plugins:
        from gonio.check.mitsuba_bsdf import MitsubaSubject

        others = [MitsubaSubject(text) for text in plugins]
        notes = [note for subject in others for note in subject.notes()]
        groups += [[subject] for subject in others]
    if picture_file is not None and files:
        raise ValueError(
            f"{files[0]} is a measurement; 'gonio data {files[0]} --picture {picture_file}' draws it."
        )
    return Plan(groups, notes, chosen, junit_file, picture_file, files, loaded, identify)


def _state(own: Sequence[Report]) -> str:
    """The verdict on one model; UNSURE where nothing could be judged, NOTE where nothing was."""
    verdicts = {f.verdict for r in own for f in r.findings}
    if failed(own):
        return FAIL
    return PASS if verdicts - {NOTE, UNSURE} else UNSURE if UNSURE in verdicts else NOTE


def lines(reports: Sequence[Report]) -> list[str]:
    """The tables of all models, each with a line of counts below."""
    found: list[str] = []
    for name in dict.fromkeys(r.model for r in reports):
        own = [r for r in reports if r.model == name]
        seconds = sum(r.seconds for r in own)
        state = {UNSURE: "not judged", NOTE: "not judged"}.get(_state(own), _state(own))
        found += [f"{name}: {state}", *table(own), f"  {summary(own)} in {seconds:.1f} s", ""]
    return found[:-1]


def _writable(junit_file: str | None, picture_file: str | None) -> None:
    """Raise before the work is done if a result cannot be written."""
    if junit_file is not None:
        check_place(junit_file)
    if picture_file is not None:
        check_format(picture_file)


def _fuzz(
    planned: Plan,
    count: str,
    state: str | None,
    record: str | None,
    shared: AbstractContextManager[Run] | None,
) -> tuple[list[Report], bool]:
    """Search, and write the record of all that the state knows; whether all of it could be done."""
    cases = fuzz_search.parse_count(count)
    _writable(state, None)
    _writable(record, None)
    variants = [subject for group in planned.groups for subject in group]
    whole = True
    if shared is not None:
        from gonio.cluster import checks

        with shared as run:
            states = checks.search(run, variants, cases, state)
        whole = not run.failures
    else:
        with progress("searching") as step:
            states = fuzz_search.run(variants, cases, state, step)
    if record is not None:
        known = fuzz_search.load(Path(state)) if state is not None else states
        fuzz_search.record(record, known)
    return fuzz_search.reports(states), whole


@click.command("check", short_help="Measure whether a model is what it claims to be.")
@click.argument("models", nargs=-1, metavar="[MODEL|MATERIAL|FILE]...", shell_complete=complete)
@param_option
@click.option("--all", "everything", is_flag=True, help="Every model of gonio.")
@click.option(
    "--mitsuba",
    "plugins",
    multiple=True,
    metavar="NAME|XML|JSON",
    help="A Mitsuba BSDF: a plug-in's name, its XML or JSON, or a file with it; again for more.",
)
@click.option("--quick", "effort", flag_value="quick", help="Seconds for each model.")
@click.option("--thorough", "effort", flag_value="thorough", help="Minutes for each model.")
@click.option("--only", metavar="CHECK,...", help="Only these checks, such as energy,sampling.")
@click.option(
    "--fuzz", metavar="N", help="Search N hard cases in float32 instead, such as 1e9: hours."
)
@click.option("--resume", metavar="FILE.json", help="With --fuzz: the state, read and written.")
@click.option("--record", metavar="FILE.md", help="With --fuzz: write a table of all states.")
@click.option(
    "--baseline",
    metavar="FILE.json",
    help="What an earlier run wrote with --json: only what got worse since counts.",
)
@click.option("--junit", metavar="FILE", help="Also write a JUnit report for other programs.")
@click.option("--plot", "picture", metavar="FILE", help="Also draw the worst cases.")
@click.option("--identify", is_flag=True, help="Of code: also say which model it is.")
@cluster_options
@code_options
@json_option
def command(
    models: tuple[str, ...],
    params: tuple[str, ...],
    everything: bool,
    plugins: tuple[str, ...],
    effort: str | None,
    only: str | None,
    fuzz: str | None,
    resume: str | None,
    record: str | None,
    baseline: str | None,
    junit: str | None,
    picture: str | None,
    identify: bool,
    cluster: str | None,
    run_dir: str | None,
    code: Code,
    as_json: bool,
) -> int:
    """Measure energy, reciprocity, sampling, precision, derivatives and more; compare with the claims.

    Worst cases are searched for over all angles, parameters and options. What is given of them stays
    fixed; a material is checked as it is. Of a file of measured reflection: negative values, holes, energy,
    reciprocity, isotropy and noise. Of code that others wrote, FILE.glsl#FUNCTION (GLSL, HLSL, WGSL, MSL,
    Slang, C++, CUDA, .brdf): its values, in a process of its own. Ends with exit code 1 when something is
    not as it is claimed.

    \b
    Examples:
      gonio check eon
      gonio check qon:sigma=0.2 --only energy --plot qon.png
      gonio check my_model.py --quick
      gonio check lacquered_walnut
      gonio check paint.binary
      gonio check --all --quick --junit report.xml
      gonio check --mitsuba roughplastic
      gonio check --mitsuba '{"type": "roughconductor", "alpha": 0.5}' --only energy
      gonio check shading.hlsl#SpecularGGX --map "L=wi V=wo" --range roughness=0.05..1 --identify
      gonio check eon --fuzz 1e9 --resume eon.json --record eon.md
      gonio check --all --thorough --cluster tcp://node1:8786 --junit report.xml
    """
    if everything and (models or params):
        raise click.UsageError("--all checks every model; it goes with no MODEL and no --param")
    texts = list(gonio.models()) if everything else [code.named(text) for text in models]
    if not texts and not plugins:
        raise click.UsageError("give a MODEL, a FILE.py, --all or --mitsuba NAME")
    planned = plan(
        texts,
        params,
        plugins=plugins,
        only=only.split(",") if only else (),
        junit_file=junit,
        picture_file=picture,
        code=code,
        identify=identify,
    )
    shared = None
    if cluster is not None or run_dir is not None:
        shared = run_of(cluster, run_dir, record or junit or "gonio-check", "checking")
    if fuzz is not None:
        if only or effort or picture or baseline:
            raise click.UsageError(
                "--fuzz is a search of its own; it goes with no effort, --only or --baseline"
            )
        reports, whole = _fuzz(planned, fuzz, resume, record, shared)
        click.echo("\n".join(lines(reports)))
        return 0 if whole and not failed(reports) else 1
    before = None if baseline is None else baselines.load(baseline, list)
    if resume or record:
        raise click.UsageError("--resume and --record belong to --fuzz N")
    whole = True
    if shared is not None:
        with shared as run:
            result = planned.share(run, effort or "normal")
        whole = not run.failures
    else:
        with progress("checking") as step:
            result = planned.run(effort or "normal", step)
    change = None if before is None else baselines.checks(before, data(result.reports))
    since = change.lines(str(baseline)) if change is not None else []
    if as_json:
        echo_json(data(result.reports))
        for line in since:
            click.echo(line, err=True)
    else:
        click.echo("\n".join([*lines(result.reports), *since, *map(str, result.written)]))
    bad = bool(change.worse) if change is not None else failed(result.reports) or result.unjudged
    return 0 if whole and not bad else 1
