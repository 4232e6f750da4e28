"""`gonio fit`."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import click

from gonio.cli._code import Code, code_options
from gonio.cli.program import complete, echo_json, json_option, progress
from gonio.files import check_place, replacing
from gonio.fit import METRICS, POINTS, Fit
from gonio.foreign.model import ForeignModel
from gonio.materials.notation import model_text
from gonio.materials.toml_file import to_toml


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
    "--fix", multiple=True, metavar="NAME", help="A parameter that stays; again for more."
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
@click.option("-o", "--output", metavar="TOML", help="Write the best one as a material file.")
@code_options
@json_option
def command(
    data: str,
    models: tuple[str, ...],
    metric: str,
    fix: tuple[str, ...],
    starts: int,
    points: int,
    seed: int,
    output: str | None,
    code: Code,
    as_json: bool,
) -> None:
    """Find the parameters of each MODEL that come nearest to DATA, a measured file or a model.

    A model's values are the first of the starts. Parameters that are given to it, as in
    disney:metallic=1, are where it begins; --fix metallic keeps one there. All metrics are reported,
    because they do not agree: the misfit of real data is the models', not noise.

    \b
    Examples:
      gonio fit paint.binary disney torrance_sparrow
      gonio fit paint.binary disney:metallic=1 --fix metallic -o paint.toml
      gonio fit oren_nayar:sigma=0.5 eon
      gonio fit paint.binary shading.glsl#specular --range roughness=0.05..1
    """
    from gonio import fit, materials, measured

    if output is not None and Path(output).suffix != ".toml":
        raise click.UsageError(f"--output {output} is a material file: its name ends in .toml")
    if output is not None:
        check_place(output)
    if measured.is_data_file(data):
        target: Any = measured.load(data)
        candidates = code.models(models)
    else:
        target, *candidates = code.models([data, *models])
    if output is not None and any(isinstance(model, ForeignModel) for model in candidates):
        raise click.UsageError("-o writes a material of gonio's own models; code has no such file")
    found: list[Fit] = []
    with progress("fitting") as step:
        for number, model in enumerate(candidates):

            def part(done: int, total: int, number: int = number) -> None:
                step(number * total + done, len(candidates) * total)

            found.append(
                fit.fit(
                    model,
                    target,
                    metric=metric,
                    fixed=fix,
                    starts=starts,
                    points=points or None,
                    seed=seed,
                    progress=part,
                )
            )
    found.sort(key=lambda f: f.misfit[metric])
    if output is not None:
        best = materials.Material(
            Path(output).stem, found[0].model, f"Fitted to {Path(data).name}."
        )
        with replacing(output) as temporary:
            temporary.write_text(to_toml(best), encoding="utf-8")
    if as_json:
        echo_json([_data(f) for f in found])
        return
    for line in lines(found):
        click.echo(line)
    if output is not None:
        click.echo(output)


def lines(found: list[Fit]) -> Iterator[str]:
    """What was found, the best model first."""
    for f in found:
        yield model_text(f.model)
        others = ", ".join(f"{name} {value:.4g}" for name, value in f.misfit.items())
        yield f"  {'misfit':<13} {f.relative:.2%} of the data in {f.metric}; root mean squares: {others}"
        if f.undetermined:
            names = ", ".join(f.undetermined)
            yield f"  {'undetermined':<13} {names}: this data says nothing about it"
        if f.at_bounds:
            yield f"  {'at an end':<13} {', '.join(f.at_bounds)}"
        same = sum(s <= f.starts[0] * 1.001 + 1e-12 for s in f.starts)
        yield (
            f"  {'starts':<13} {same} of {len(f.starts)} came to the same; {f.directions} directions, "
            f"{f.evaluations} evaluations, {f.seconds:.1f} s"
        )


def _data(f: Fit) -> dict[str, Any]:
    return {
        "model": model_text(f.model),
        "parameters": {path: value for path, _, value in f.model.parameters()},
        "metric": f.metric,
        "misfit": f.misfit,
        "relative": f.relative,
        "undetermined": list(f.undetermined),
        "at_bounds": list(f.at_bounds),
        "starts": list(f.starts),
        "directions": f.directions,
        "seconds": f.seconds,
    }
