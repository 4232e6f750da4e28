"""`gonio bench`."""

from __future__ import annotations

import click

from gonio.cli.program import json_option


@click.command("bench", short_help="Measure speed on this machine.")
@click.argument("rows", nargs=-1, metavar="[ROW]...")
@click.option("--pairs", type=click.IntRange(1), default=4_000_000, help="Pairs of directions.")
@click.option("--repeat", type=click.IntRange(1), default=7, help="Rounds; medians are reported.")
@click.option("-o", "--output", metavar="FILE", help="Also write a .md or .json file.")
@json_option
def command(
    rows: tuple[str, ...], pairs: int, repeat: int, output: str | None, as_json: bool
) -> None:
    """Measure gonio beside plain C++ (compiled for the purpose), Mitsuba's own plug-ins and the clock.

    ROWs choose what to measure: sections (eval, sample, albedos, numpy, render, shaders, kernels,
    startup), models, or rows such as eon_fitted. Everything takes about four minutes; close other
    programs first.

    \b
    Examples:
      gonio bench
      gonio bench eon oren_nayar --repeat 15
      gonio bench shaders             exported GLSL beside GLSL written by hand
      gonio bench -o docs/performance.md
    """
    from pathlib import Path

    from gonio import bench as benches

    report = benches.bench(
        pairs, repeat, list(rows) or None, None if output is None else Path(output)
    )
    click.echo(report.json() if as_json else report.text())
