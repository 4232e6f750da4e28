"""`gonio sweep`: numbers of a model over a grid of parameters, as a table."""

from __future__ import annotations

from typing import Any

import click

from gonio.cli._cluster import cluster_options, run_of
from gonio.cli._numbers import POLAR_ANGLES
from gonio.cli.program import complete, param_option, plain_models, was_given
from gonio.cluster.grid import COLUMNS
from gonio.materials.notation import split


@click.command("sweep", short_help="Tabulate a model's numbers over its parameters.")
@click.argument("model", shell_complete=complete)
@param_option
@click.option(
    "--vary",
    multiple=True,
    metavar="NAME=A..B[:N][:log]|A,B,...",
    help="A parameter over a range (11 values, or N; evenly, or :log), or some values of a parameter or "
    "option; again for more. All combinations are measured.",
)
@click.option(
    "--measure",
    "measures",
    multiple=True,
    type=click.Choice(list(COLUMNS)),
    help="What is measured (default: albedo); again for more. variance is that of the sampler's weights.",
)
@click.option(
    "--against",
    metavar="MODEL",
    shell_complete=complete,
    help="With difference: the other model. What is varied varies in it too, unless given here.",
)
@click.option(
    "--theta-o",
    type=POLAR_ANGLES,
    metavar="DEG,...",
    default="0,30,60,80",
    show_default=True,
    help="The viewer's angles, for albedo and variance: a row for each.",
)
@click.option(
    "--samples",
    type=click.IntRange(2, 1 << 32),
    default=1 << 18,
    show_default=True,
    help="Of the sampler, for each variance.",
)
@cluster_options
@click.option(
    "-o", "--output", metavar="FILE", help="A .parquet or .csv file (default: MODEL.parquet)."
)
def command(
    model: str,
    params: tuple[str, ...],
    vary: tuple[str, ...],
    measures: tuple[str, ...],
    against: str | None,
    theta_o: tuple[float, ...],
    samples: int,
    cluster: str | None,
    run_dir: str | None,
    output: str | None,
) -> int:
    """Measure MODEL at all combinations of some of its parameters, and write a table.

    \b
    albedo       of each --theta-o: albedo_r, albedo_g, albedo_b
    mean_albedo  under light from everywhere: mean_albedo_r, mean_albedo_g, mean_albedo_b
    variance     of the sampler's weights, in luminance: weight_mean, weight_variance, weight_maximum
    difference   from --against, in luminance: difference is the mean of |f - against| over the mean of
                 against, energy what is gained (above 0) or lost

    Interrupted work goes on with the same command where --run-dir or --cluster was given. Points that fail
    are named, their numbers are empty, and the exit code is 1. Programs read the table as it is:
    pandas.read_parquet, polars.read_parquet, duckdb.

    \b
    Examples:
      gonio sweep eon --vary roughness=0..1
      gonio sweep torrance_sparrow --vary alpha=0.01..1:21:log --vary eta=1.1,1.5,2 --measure mean_albedo
      gonio sweep eon --vary roughness=0..1:5 --vary sampler=cosine,cltc --measure variance -o eon.csv
      gonio sweep qon --vary sigma=0..pi/2:31 --measure difference --against oren_nayar
      gonio sweep disney --vary roughness=0..1:101 --vary metallic=0..1:101 --cluster tcp://node1:8786
    """
    from gonio.cluster import sweep
    from gonio.cluster.grid import axis

    chosen = tuple(dict.fromkeys(measures or ("albedo",)))
    shown = plain_models([model], params)[0]
    other = plain_models([against])[0] if against is not None else None
    given = [piece.partition("=")[0].strip() for piece in split(against)[1]] if against else []
    wanted = sweep.Sweep(
        shown,
        tuple(axis(shown, text) for text in vary),
        chosen,
        other,
        theta_o,
        samples,
        frozenset(given),
    )
    _used(wanted)
    target = f"{shown.name}.parquet" if output is None else output
    sweep.check_format(target)
    with run_of(cluster, run_dir, target, "measuring") as run:
        count = wanted.run(run, target)
    click.echo(f"{target}: {count} rows")
    return 1 if run.failures else 0


def _used(wanted: Any) -> None:
    """Raise a UsageError for an option that has no effect."""
    if was_given("theta_o") and not wanted.by_angle:
        raise click.UsageError("--theta-o is for --measure albedo and variance")
    if was_given("samples") and "variance" not in wanted.measures:
        raise click.UsageError("--samples is for --measure variance")
