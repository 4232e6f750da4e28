"""`gonio scene`: your own Mitsuba scene."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from gonio.cli._stage import check_look, denoise_option, scene_exposure_option, tone_option
from gonio.cli.program import (
    Size,
    check_params,
    param_option,
    progress,
    seed_option,
    spp_option,
)


@click.command("scene", short_help="Render your own Mitsuba scene with gonio's models in it.")
@click.argument("scene", metavar="FILE.xml")
@click.option(
    "--assign",
    "assignments",
    multiple=True,
    metavar="ID=MODEL",
    help="Give a shape or bsdf of the scene this model; again for more.",
)
@param_option
@click.option(
    "-D",
    "--define",
    "defined",
    multiple=True,
    metavar="NAME=VALUE",
    help="A parameter of the scene ($NAME), as Mitsuba has it; again for more.",
)
@spp_option(None)
@denoise_option
@click.option("--size", type=Size(), metavar="N|WxH", help="Pixels (default: the scene's).")
@seed_option
@scene_exposure_option
@tone_option
@click.option("-o", "--output", metavar="FILE", help="A .png or .exr file (default: FILE.png).")
def command(
    scene: str,
    assignments: tuple[str, ...],
    params: tuple[str, ...],
    defined: tuple[str, ...],
    spp: int | None,
    denoise: bool,
    size: tuple[int, int] | None,
    seed: int,
    exposure: float | None,
    tone: str | None,
    output: str | None,
) -> None:
    """Render FILE.xml, a Mitsuba scene, with models of gonio in place of some of its materials.

    The scene's own plug-ins may be gonio's as well: <bsdf type="gonio_eon">.

    \b
    Examples:
      gonio scene room.xml --assign wall=eon:roughness=0.8 -o room.png
      gonio scene room.xml --size 320x240 --spp 16 --denoise
      gonio scene room.xml -D lamp=3.5 -o bright.png
    """
    from gonio.materials import load
    from gonio.render.picture import check_format, write_picture
    from gonio.render.user_scene import render_scene

    assigned: dict[str, Any] = {}
    values: list[str] = []
    for text in assignments:
        name, equals, value = text.partition("=")
        if not (name and equals and value):
            raise click.UsageError(f"--assign {text} is not ID=MODEL, such as wall=eon")
        if name in assigned:
            raise click.UsageError(f"--assign gives {name} twice; once is enough")
        assigned[name] = load(value, params)
        values.append(value)
    check_params(values, params)
    if params and not assigned:
        raise click.UsageError(
            "--param is for the models of --assign; give --assign ID=MODEL with it"
        )
    define = {}
    for text in defined:
        name, equals, value = text.partition("=")
        if not (name and equals):
            raise click.UsageError(f"-D {text} is not NAME=VALUE, such as -D spp=64")
        if name in define:
            raise click.UsageError(f"-D gives {name} twice; once is enough")
        define[name] = value
    target = Path(f"{Path(scene).stem}.png" if output is None else output)
    check_format(target)
    check_look(target, exposure, tone)
    with progress("rendering") as step:
        pixels = render_scene(
            scene,
            assigned,
            define=define,
            size=size,
            spp=spp,
            denoise=denoise,
            seed=seed,
            progress=step,
        )
    write_picture(target, pixels, exposure=exposure or 0.0, tone=tone or "linear")
    click.echo(target)
