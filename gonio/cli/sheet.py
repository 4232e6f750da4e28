"""`gonio sheet`: all ready materials in one picture."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from gonio.cli._cluster import cluster_options, pictures_of
from gonio.cli._stage import (
    check_denoise,
    denoise_option,
    exposure_option,
    light_of,
    stops,
    tone_option,
)
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
@denoise_option
@seed_option
@exposure_option
@tone_option
@cluster_options
@click.option("-o", "--output", default="materials.png", metavar="FILE", help="A .png file.")
def command(
    environment: str | None,
    furnace: bool,
    size: int,
    spp: int,
    denoise: bool,
    seed: int,
    exposure: float | str | None,
    tone: str | None,
    cluster: str | None,
    run_dir: str | None,
    output: str,
) -> None:
    """Render a contact sheet of all ready materials, each with its name.

    \b
    Examples:
      gonio sheet
      gonio sheet --env sunsky --size 320 -o materials.png
      gonio sheet --denoise -o materials.png
      gonio sheet --size 512 --spp 1024 --cluster tcp://node1:8786
    """
    from gonio.materials import library, load_material
    from gonio.render.sheets import write_cells, write_sheet

    target = Path(output)
    if target.suffix.lower() != ".png":
        raise click.UsageError(f"--output {output} is a contact sheet: its name ends in .png")
    check_denoise(denoise, cluster, run_dir)
    check_place(target)
    light = light_of(environment, furnace, exposure)
    brighter = stops(light, furnace, exposure, target)
    materials = [load_material(name) for name in library()]
    common: Any = {"spp": spp, "seed": seed, "environment": light, "furnace": furnace}
    look: Any = {"exposure": brighter, "tone": tone or "linear"}
    if cluster is not None or run_dir is not None:
        row = common | {"size": (size, size)}
        cells = pictures_of(cluster, run_dir, target, [(material, row) for material in materials])
        write_cells(target, materials, cells, **look)
    else:
        with progress("rendering") as step:
            write_sheet(
                target, materials, cell=size, progress=step, denoise=denoise, **look, **common
            )
    click.echo(target)
