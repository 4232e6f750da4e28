"""`gonio sheet`: all ready materials in one picture."""

from __future__ import annotations

from pathlib import Path

import click

from gonio.cli._stage import exposure_option, light_of, stops, tone_option
from gonio.cli.program import (
    environment_option,
    progress,
    seed_option,
    spp_option,
)
from gonio.files import check_place


@click.command("sheet", short_help="Render all ready materials on one sheet.")
@environment_option
@click.option("--furnace", is_flag=True, help="Radiance 1 from everywhere: shows lost energy.")
@click.option(
    "--size", type=click.IntRange(16, 4096), default=256, show_default=True, help="Of one cell."
)
@spp_option(64)
@seed_option
@exposure_option
@tone_option
@click.option("-o", "--output", default="materials.png", metavar="FILE", help="A .png file.")
def command(
    environment: str | None,
    furnace: bool,
    size: int,
    spp: int,
    seed: int,
    exposure: float | str | None,
    tone: str | None,
    output: str,
) -> None:
    """Render a contact sheet of all ready materials, each with its name.

    \b
    Examples:
      gonio sheet
      gonio sheet --env sunsky --size 320 -o materials.png
    """
    from gonio.materials import library, load_material
    from gonio.render.sheets import write_sheet

    target = Path(output)
    if target.suffix.lower() != ".png":
        raise click.UsageError(f"--output {output} is a contact sheet: its name ends in .png")
    check_place(target)
    light = light_of(environment, furnace, exposure)
    brighter = stops(light, furnace, exposure, target)
    with progress("rendering") as step:
        write_sheet(
            target,
            [load_material(name) for name in library()],
            cell=size,
            spp=spp,
            seed=seed,
            environment=light,
            furnace=furnace,
            exposure=brighter,
            tone=tone or "linear",
            progress=step,
        )
    click.echo(target)
