"""`gonio render`: a picture of a model."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from gonio.cli._cluster import cluster_options, exact_spp, pictures_of
from gonio.cli._numbers import Number
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
    check_params,
    complete,
    environment_option,
    noise_option,
    param_option,
    progress,
    seed_option,
    spp_option,
    time_option,
    until,
)


@click.command("render", short_help="Render a picture of a model.")
@click.argument("model", shell_complete=complete)
@param_option
@click.option(
    "--compare",
    "others",
    multiple=True,
    metavar="MODEL",
    help="Another model beside the first; again for more. Makes a labelled strip.",
)
@environment_option
@click.option("--furnace", is_flag=True, help="Radiance 1 from everywhere: shows lost energy.")
@stage_options
@click.option(
    "--diffusion",
    type=Number(0, 10),
    default=0.0,
    metavar="MM",
    help="Diffuse light wanders as in skin, red the farthest: a millimetre in units of the ball's radius, "
    "such as 0.01.",
)
@click.option(
    "--sampler",
    type=click.Choice(["own", "cosine", "uniform"]),
    default="own",
    help="How paths go on: by MODEL's own sampler (default), or by one that knows nothing of it.",
)
@spp_option(None)
@noise_option
@time_option
@click.option(
    "--clamp",
    type=Number(0, above=True),
    metavar="WHITES",
    help="Against bright dots (fireflies): cut samples of indirect light above so many times white, "
    "such as 1. The picture gets darker; a line says by how much.",
)
@denoise_option
@click.option("--size", type=Size(), metavar="N|WxH", default="512", help="Pixels (default: 512).")
@seed_option
@exposure_option
@tone_option
@cluster_options
@click.option("-o", "--output", metavar="FILE", help="A .png or .exr file (default: MODEL.png).")
def command(
    model: str,
    params: tuple[str, ...],
    others: tuple[str, ...],
    environment: str | None,
    furnace: bool,
    diffusion: float,
    sampler: str,
    spp: int | None,
    noise: float | None,
    seconds: float | None,
    clamp: float | None,
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
    """Render MODEL on a shader ball or on your mesh.

    MODEL is a model, a ready material ('gonio list --materials' shows them), a material file (.toml) or a
    model file (.py), and may carry parameters: eon:roughness=1,rho=0.8/0.3/0.1 (colours with slashes).
    --param is for MODEL, not for those of --compare. See also 'gonio sheet', 'gonio series', and
    'gonio scene' for your own Mitsuba scenes.

    \b
    Examples:
      gonio render eon --param roughness=1 -o clay.png
      gonio render eon --mesh bunny.obj --env studio.hdr
      gonio render gold --mesh car.glb --camera 35,10 --tone agx
      gonio render gold --transparent -o gold.png
      gonio render lambert --compare qon:sigma=1.57 --compare eon:roughness=1 --env side
      gonio render eon:rho=1,roughness=1 --furnace
      gonio render eon:rho=1,roughness=1 --furnace --sampler cosine --spp 50 --max-depth 51
      gonio render lacquered_walnut --compare gold --env sunsky
      gonio render skin --diffusion 0.01
      gonio render clay.toml --size 1024x768 --spp 256 -o clay.exr
      gonio render gold --env street.hdr --denoise
      gonio render skin --spp 4096 --cluster node1.json
    """
    from gonio.materials import load
    from gonio.render import sheets
    from gonio.render.light import auto_exposure
    from gonio.render.picture import check_format, describe, write_picture

    check_params([model], params)
    first = load(model, params)
    shown = [first, *(load(text) for text in others)]
    labels = [describe(m) for m in shown] if others else []
    target = Path(f"{first.name}.png" if output is None else output)
    check_format(target)
    check_look(target, exposure, tone)
    settings = stage_settings(**stage)
    light = light_of(environment, furnace, exposure)
    brighter = stops(light, furnace, exposure, target)
    if clamp is not None:
        if cluster is not None or run_dir is not None:
            raise click.UsageError("--clamp is for pictures that are rendered here and at once.")
        # An .exr has no exposure of its own, and the white that a .png would have
        linear = target.suffix.lower() == ".exr" and not furnace
        settings["clamp"] = clamp / 2 ** (auto_exposure(light) if linear else brighter)
    check_denoise(denoise, cluster, run_dir)
    row = {
        "environment": light,
        "furnace": furnace,
        "diffusion": diffusion,
        "sampler": sampler,
    }
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
    write_picture(target, pixels, exposure=brighter, tone=tone or "linear", labels=labels)
    click.echo(target)
