"""`gonio demo`."""

from __future__ import annotations

import click

from gonio.cli.program import progress


@click.command("demo", short_help="Render the Oren-Nayar family side by side.")
@click.option("-o", "--output", default="demo", metavar="FOLDER", help="Where to (default: demo).")
@click.option("--size", type=click.IntRange(16, 4096), default=320, help="Pixels of one cell.")
@click.option("--spp", type=click.IntRange(1, 1 << 20), default=64, help="Samples per pixel.")
def command(output: str, size: int, spp: int) -> None:
    """Render Lambert, QON, FON and EON at full roughness: front-lit, side-lit, white furnace.

    After Figures 1 and 4 of the EON paper. Takes about half a minute on two cores.

    \b
    Examples:
      gonio demo
      gonio demo --size 512 --spp 256 -o pictures
    """
    from gonio.render import sheets

    with progress("rendering") as step:
        paths = sheets.demo(output, cell=size, spp=spp, progress=step)
    for path in paths:
        click.echo(f"The picture is {path}")
