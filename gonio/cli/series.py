"""`gonio series`: the steps of a ready material in a strip."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from gonio.cli._cluster import cluster_options, exact_spp, pictures_of
from gonio.cli._stage import (
    check_denoise,
    check_look,
    denoise_option,
    exposure_option,
    light_of,
    stage_options,
    stage_settings,
    stops,
    tone_option,
)
from gonio.cli.program import (
    Size,
    environment_option,
    noise_option,
    progress,
    seed_option,
    spp_option,
    time_option,
    until,
)


@click.command("series", short_help="Render the steps of a ready material in a strip.")
@click.argument("name", metavar="NAME")
@environment_option
@click.option("--furnace", is_flag=True, help="Radiance 1 from everywhere: shows lost energy.")
@stage_options
@spp_option(None)
@noise_option
@time_option
@denoise_option
@click.option(
    "--size", type=Size(), metavar="N|WxH", default="320", help="Pixels of a step (default: 320)."
)
@seed_option
@exposure_option
@tone_option
@cluster_options
@click.option("-o", "--output", metavar="FILE", help="A .png or .exr file (default: NAME.png).")
def command(
    name: str,
    environment: str | None,
    furnace: bool,
    spp: int | None,
    noise: float | None,
    seconds: float | None,
    denoise: bool,
    size: tuple[int, int],
    seed: int,
    exposure: float | str | None,
    tone: str | None,
    cluster: str | None,
    run_dir: str | None,
    output: str | None,
    **stage: Any,
) -> None:
    """Render the ready materials NAME_1, NAME_2, ... side by side, with what changes below each.

    \b
    Examples:
      gonio series patina                         copper turning green
      gonio series patina --env sunsky -o green.png
      gonio series patina --spp 1024 --cluster local
    """
    from gonio.materials import load_series
    from gonio.render import sheets
    from gonio.render.picture import captions, check_format, write_picture

    check_denoise(denoise, cluster, run_dir)
    shown = load_series(name)
    target = Path(f"{name}.png" if output is None else output)
    check_format(target)
    check_look(target, exposure, tone)
    settings = stage_settings(**stage)
    light = light_of(environment, furnace, exposure)
    brighter = stops(light, furnace, exposure, target)
    row = {"environment": light, "furnace": furnace}
    common = {"size": size, "seed": seed, **settings}
    if cluster is not None or run_dir is not None:
        row |= common | {"spp": exact_spp(spp, noise, seconds)}
        pixels = sheets.beside(
            [pictures_of(cluster, run_dir, target, [(material, row) for material in shown])]
        )
    else:
        with progress("rendering") as step:
            pixels = sheets.compare(
                [row],
                shown,
                progress=step,
                **until(spp, noise, seconds, denoise),
                **common,
            )
    write_picture(target, pixels, exposure=brighter, tone=tone or "linear", labels=captions(shown))
    click.echo(target)
