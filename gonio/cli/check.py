"""`gonio check`."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import TYPE_CHECKING

import click

import gonio
from gonio.check import data, failed
from gonio.check import fuzz as fuzz_search
from gonio.check.lines import lines, unjudged
from gonio.check.report import Report
from gonio.cli import _baseline as baselines
from gonio.cli._check_plan import Plan, Result, check_places, plan
from gonio.cli._cluster import cluster_options, run_of
from gonio.cli._code import Code, code_options
from gonio.cli.program import complete, echo_json, json_option, param_option, progress

if TYPE_CHECKING:
    from gonio.cluster import Run


def _fuzz(
    planned: Plan,
    count: str,
    state: str | None,
    record: str | None,
    shared: AbstractContextManager[Run] | None,
) -> tuple[list[Report], bool]:
    """Search, and write the record of all that the state knows; whether all of it could be done."""
    cases = fuzz_search.parse_count(count)
    check_places(state, None)
    check_places(record, None)
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


def _processes_refused(
    planned: Plan, effort: str | None, fuzz: str | None, shared: str | None
) -> None:
    """Raise a UsageError where --processes has no effect."""
    if shared is not None:
        raise click.UsageError("--cluster and --run-dir share the checks; leave --processes out")
    if fuzz is not None or effort == "thorough":
        other = "--fuzz" if fuzz is not None else "--thorough"
        raise click.UsageError(f"{other} uses all cores in one process; leave --processes out")
    if not planned.groups:
        raise click.UsageError(
            f"--processes shares checks of models; check {planned.others[0]} without it"
        )


def _show(result: Result, as_json: bool, since: Sequence[str] = ()) -> None:
    """Print what was found and written, and what has changed since an earlier run."""
    if as_json:
        echo_json(data(result.reports))
        for line in since:
            click.echo(line, err=True)
    else:
        click.echo("\n".join([*lines(result.reports), *since, *map(str, result.written)]))


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
@click.option(
    "--processes",
    type=click.IntRange(min=1),
    metavar="N",
    help="Share the checks of models among N processes; by default among as many as there are cores, up "
    "to 8, where there is work for some seconds. The results are the same.",
)
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
    processes: int | None,
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
    if processes is not None:
        _processes_refused(planned, effort, fuzz, cluster or run_dir)
    shared = None
    if cluster is not None or run_dir is not None:
        shared = run_of(cluster, run_dir, record or junit or "gonio-check", "checking")
    if fuzz is not None:
        if only or effort or picture or baseline:
            raise click.UsageError(
                "--fuzz is a search of its own; it goes with no effort, --only, --plot or --baseline"
            )
        if planned.others:
            raise click.UsageError(
                f"--fuzz searches models and materials; check {planned.others[0]} without it"
            )
        reports, whole = _fuzz(planned, fuzz, resume, record, shared)
        _show(planned.written(reports), as_json)
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
            result = planned.run(effort or "normal", step, processes)
    change = None if before is None else baselines.checks(before, data(result.reports))
    since = change.lines(str(baseline)) if change is not None else []
    _show(result, as_json, since)
    bad = (
        bool(change.worse)
        if change is not None
        else failed(result.reports) or unjudged(result.reports)
    )
    return 0 if whole and not bad else 1
