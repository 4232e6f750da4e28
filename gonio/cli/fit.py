"""`gonio fit`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from gonio.cli._cluster import cluster_options, run_of
from gonio.cli._code import Code, code_options
from gonio.cli.program import complete, echo_json, json_option, progress
from gonio.files import check_place, replacing
from gonio.fit import METRICS, POINTS, Fit, named, report
from gonio.fit.named import Candidate
from gonio.foreign.model import ForeignModel
from gonio.materials.toml_file import to_toml

PICTURES = (".png", ".svg", ".pdf", ".csv")


@click.command("fit", short_help="Fit models to measured reflection, or to another model.")
@click.argument("data", metavar="DATA")
@click.argument("models", nargs=-1, required=True, metavar="MODEL...", shell_complete=complete)
@click.option(
    "--metric",
    type=click.Choice(list(METRICS)),
    default=next(iter(METRICS)),
    show_default=True,
    help="What is made small: ln(1 + f cos), its cube root, or f cos itself.",
)
@click.option(
    "--fix",
    multiple=True,
    metavar="NAME[=VALUE]",
    help="A parameter that stays, at its default or a value; again for more.",
)
@click.option(
    "--free",
    multiple=True,
    metavar="NAME",
    help="A parameter that is given to a MODEL, and begins there instead of staying.",
)
@click.option(
    "--tie",
    multiple=True,
    metavar="NAME=NAME",
    help="Parameters that are one number, as alpha_x=alpha_y; again for more.",
)
@click.option(
    "--truth", is_flag=True, help="DATA is a layered model: fit to random walks through its layers."
)
@click.option("--starts", type=click.IntRange(1, 1000), default=4, show_default=True)
@click.option(
    "--points",
    type=click.IntRange(0),
    default=POINTS,
    show_default=True,
    help="Directions that are drawn from the data; 0 for all.",
)
@click.option(
    "--seed", type=click.IntRange(0, 65535), default=0, help="Of the draw and the starts."
)
@click.option(
    "-o",
    "--output",
    "outputs",
    multiple=True,
    metavar="FILE",
    help="Write the best: a material (.toml), or a picture of data, fit and difference (.png .svg .pdf "
    ".csv); again for both.",
)
@cluster_options
@code_options
@json_option
def command(
    data: str,
    models: tuple[str, ...],
    metric: str,
    fix: tuple[str, ...],
    free: tuple[str, ...],
    tie: tuple[str, ...],
    truth: bool,
    starts: int,
    points: int,
    seed: int,
    outputs: tuple[str, ...],
    cluster: str | None,
    run_dir: str | None,
    code: Code,
    as_json: bool,
) -> int:
    """Find the parameters of each MODEL that come nearest to DATA: a measured file, a folder, a model.

    Of a folder, every file of measured reflection in it and below is fitted. With --cluster or --run-dir,
    more than 8 starts are several tasks; what is found is the same.

    What is given to a MODEL, as in disney:metallic=1, stays; --free lets it go from there. A sum of
    lobes is written with plus signs. All metrics are reported, because they do not agree: the misfit of
    real data is the models', not noise, and how much of it is noise is said. A material that is written
    is ready for gonio render and gonio export.

    \b
    Examples:
      gonio fit paint.binary disney torrance_sparrow
      gonio fit paint.binary disney:metallic=1 -o paint.toml -o paint.png
      gonio fit metal.bsdf "lambert+ward" --tie alpha_x=alpha_y
      gonio fit paint.binary "lambert+torrance_sparrow:fresnel=schlick+torrance_sparrow:fresnel=schlick"
      gonio fit oren_nayar:sigma=0.5 eon
      gonio fit merl/ disney torrance_sparrow --cluster local --json
      gonio fit lacquered_oak disney --truth        # the nearest to the lacquer's layers
      gonio fit paint.binary shading.glsl#specular --range roughness=0.05..1
    """
    _check_outputs(outputs)
    shared = Path(data).is_dir() or cluster is not None or run_dir is not None
    if shared and (code.given or truth or outputs):
        raise click.UsageError(
            "folders, --cluster and --run-dir are for gonio's models and files, and print what is found; "
            "leave --truth, -o and options of code out"
        )
    target: Any = None
    if Path(data).is_dir():
        found_models = code.models(models)
    else:
        target, found_models = _target(data, models, truth, code)
    if any(Path(o).suffix.lower() == ".toml" for o in outputs) and any(
        isinstance(model, ForeignModel) for model in found_models
    ):
        raise click.UsageError("-o writes a material of gonio's own models; code has no such file")
    candidates = named.candidates(zip(models, found_models, strict=True), fix, free, tie)
    given = {"metric": metric, "starts": starts, "points": points or None, "seed": seed}
    if shared:
        return _many(data, target, candidates, given, cluster, run_dir, as_json)
    found = _one_by_one(target, candidates, given)
    costs = [_instructions(f.model) for f in found]
    for output in outputs:
        _write(output, found[0], target, data, seed)
    if as_json:
        echo_json([report.data(f, cost) for f, cost in zip(found, costs, strict=True)])
        return 0
    for line in report.lines(found, costs):
        click.echo(line)
    for output in outputs:
        click.echo(output)
    return 0


def _one_by_one(target: Any, candidates: list[Candidate], given: dict[str, Any]) -> list[Fit]:
    """Fits of all models to one thing, the best first."""
    from gonio import fit

    found = []
    with progress("fitting") as step:
        for number, (model, fixed, tied) in enumerate(candidates):

            def part(done: int, total: int, number: int = number) -> None:
                step(number * total + done, len(candidates) * total)

            found.append(fit.fit(model, target, fixed=fixed, tied=tied, progress=part, **given))
    return sorted(found, key=lambda f: f.misfit[given["metric"]])


def _many(
    data: str,
    target: Any,
    candidates: list[Candidate],
    given: dict[str, Any],
    cluster: str | None,
    run_dir: str | None,
    as_json: bool,
) -> int:
    """Fits by tasks, of a folder or of one thing."""
    from gonio.cluster import fits
    from gonio.measured import is_data_file

    folder = Path(data).is_dir()
    targets: list[Any] = [Path(data) if is_data_file(data) else target]
    if folder:
        targets = list(fits.data_files(data))
    printed: list[dict[str, Any]] = []
    beside = Path(data).name if folder else "gonio-fit"
    with run_of(cluster, run_dir, beside, "fitting") as run:
        for place, found in fits.fits(run, targets, candidates, given):
            costs = [_instructions(f.model) for f in found]
            these = [report.data(f, cost) for f, cost in zip(found, costs, strict=True)]
            printed += [{"data": str(place), "fits": these}] if folder else these
            if not as_json and found:
                for line in [str(place)] * folder + list(report.lines(found, costs)):
                    click.echo(line)
    if as_json:
        echo_json(printed)
    return 1 if run.failures else 0


def _check_outputs(outputs: tuple[str, ...]) -> None:
    from gonio.plot.output import check_output

    for output in outputs:
        suffix = Path(output).suffix.lower()
        if suffix == ".toml":
            check_place(output)
        elif suffix in PICTURES:
            check_output(output)
        else:
            raise click.UsageError(
                f"--output {output}: a material file's name ends in .toml, a picture's in "
                f"{', '.join(PICTURES)}"
            )
    kinds = [Path(output).suffix.lower() == ".toml" for output in outputs]
    if len(set(outputs)) < len(outputs) or sum(kinds) > 1:
        raise click.UsageError("--output names two files for one thing; give one of each")


def _target(data: str, texts: tuple[str, ...], truth: bool, code: Code) -> tuple[Any, list[Any]]:
    """What is fitted to, and the models that are fitted."""
    from gonio import measured
    from gonio.reference import Stack

    if measured.is_data_file(data):
        if truth:
            raise click.UsageError(f"--truth is for layered models; {data} is measured")
        return measured.load(data), code.models(texts)
    model, *named = code.models([data, *texts])
    return (Stack.of(model) if truth else model), named


def _instructions(model: Any) -> int | None:
    """What the model's `eval` costs in a shader; None where the compilers are not there."""
    from gonio.bench.shaders import length
    from gonio.export import export
    from gonio.export.prove.tools import ProofError
    from gonio.export.tree import ExportError

    try:
        return length(export({model.name: model}, "glsl", only=("eval",))[0]).instructions
    except (ProofError, ExportError):
        return None


def _write(output: str, found: Fit, target: Any, data: str, seed: int) -> None:
    if Path(output).suffix.lower() != ".toml":
        from gonio.fit import picture

        picture.save(output, found, target, Path(data).name, seed)
        return
    from gonio import materials

    size = f"misfit {found.relative:.2g} of the data in {found.metric}"
    best = materials.Material(
        Path(output).stem, found.model, f"Fitted to {Path(data).name}: {size}."
    )
    with replacing(output) as temporary:
        temporary.write_text(to_toml(best), encoding="utf-8")
