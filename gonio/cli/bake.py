"""`gonio bake` and its commands."""

from __future__ import annotations

from typing import Any

import click

from gonio.cli.program import echo_json, json_option, progress


@click.group(
    "bake", short_help="Make tables and prefiltered light for shaders.", invoke_without_command=True
)
@click.pass_context
def command(ctx: click.Context) -> None:
    """Make what real-time shaders look up: tables of F and D, blurred environments, harmonics.

    Each tells how far the table is from the function that it stands for.

    \b
    Examples:
      gonio bake fresnel --metal Cu -o copper.npy
      gonio bake distribution ggx -o ggx.exr
      gonio bake blur studio.hdr --alpha 0.2 -o rough.exr
      gonio bake harmonics sunsky
    """
    if ctx.invoked_subcommand is None:
        click.echo(ctx.get_help())


@command.command(short_help="F of a material, by the cosine.")
@click.option("--eta", metavar="N[,N,N]", help="Relative index; one number, or one per channel.")
@click.option("--k", default="0", metavar="N[,N,N]", help="Extinction, for metals.")
@click.option("--metal", metavar="SYMBOL", help="A metal such as Cu instead of --eta and --k.")
@click.option("--entries", type=click.IntRange(2, 1 << 16), default=128, show_default=True)
@click.option("-o", "--output", default="fresnel.npy", metavar="FILE", help="A .npy or .exr file.")
def fresnel(eta: str | None, k: str, metal: str | None, entries: int, output: str) -> None:
    """Write a table of the exact Fresnel reflectance at evenly spaced cosines from 0 to 1.

    \b
    Examples:
      gonio bake fresnel --eta 1.5 -o glass.npy
      gonio bake fresnel --metal Cu --entries 64 -o copper.exr
    """
    from gonio.bake import tables
    from gonio.parts import metals

    if (eta is None) == (metal is None):
        raise click.UsageError("give either --eta, such as 1.5, or --metal, such as Cu")
    if metal is not None:
        index: dict[str, Any] = dict(metals.metal(metal))
    else:
        index = {"eta": _parse_numbers("--eta", str(eta)), "k": _parse_numbers("--k", k)}
    table = tables.fresnel_table(**index, entries=entries)
    tables.write_table(output, table)
    error = tables.fresnel_error(table, **index)
    click.echo(f"{output}: largest error {error.largest:.2g}, at {error.at:.1f} degrees")


def _parse_numbers(option: str, text: str) -> list[float]:
    try:
        return [float(number) for number in text.split(",")]
    except ValueError:
        raise ValueError(f"{option} {text} is not a number, or three as in 0.2,0.9,1.1.") from None


@command.command(short_help="D for all widths and angles.")
@click.argument("kind", default="beckmann", metavar="[DISTRIBUTION]")
@click.option("--size", type=click.IntRange(2, 8192), default=512, show_default=True)
@click.option(
    "--exponent",
    type=click.FloatRange(1, 16),
    default=8,
    show_default=True,
    help="The angle is a quarter turn times u to this power; with 1 sharp highlights are lost.",
)
@click.option("-o", "--output", metavar="FILE", help="A .npy or .exr file (default: NAME.npy).")
def distribution(kind: str, size: int, output: str | None, exponent: float) -> None:
    """Write D over u (to the right, theta = 90 degrees times u^8) and width (downwards).

    DISTRIBUTION is beckmann, ggx, blinn_phong or gaussian. Row v, from 0 to 1, has alpha = 0.003^(1 - v).

    \b
    Examples:
      gonio bake distribution
      gonio bake distribution ggx --size 256 -o ggx.exr
      gonio bake distribution beckmann --exponent 1 -o linear.exr
    """
    from gonio.bake import tables

    table = tables.distribution_table(kind, size, exponent)
    target = output or f"{kind}.npy"
    tables.write_table(target, table)
    error = tables.distribution_error(table, kind, exponent)
    click.echo(
        f"{target}: largest error {error.largest:.2g} of the peak, at {error.at:.1f} degrees; "
        f"of the integral {error.mean:.2g}"
    )


@command.command(short_help="An environment as a rough surface mirrors it.")
@click.argument("environment", metavar="NAME|FILE")
@click.option(
    "--alpha",
    type=click.FloatRange(0, 1, min_open=True),
    required=True,
    help="Width of the surface's GGX facets.",
)
@click.option("--width", type=int, help="Pixels of the picture (default: as alpha needs).")
@click.option("-o", "--output", default="blurred.exr", metavar="FILE", help="An .exr or .hdr file.")
def blur(environment: str, alpha: float, width: int | None, output: str) -> None:
    """Blur an environment by a GGX lobe about each direction, for split-sum reflections.

    \b
    Examples:
      gonio bake blur studio.hdr --alpha 0.2
      gonio bake blur sunsky --alpha 0.05 --width 512 -o sky.exr
    """
    from gonio.bake import environment as environments

    environments.check_format(output)
    with progress("blurring") as step:
        environments.load(environment).blurred(alpha, width=width, progress=step).write(output)
    click.echo(output)


@command.command(short_help="An environment's spherical harmonics.")
@click.argument("environment", metavar="NAME|FILE")
@json_option
def harmonics(environment: str, as_json: bool) -> None:
    """Print the first nine real spherical harmonics of an environment's radiance, red, green and blue.

    \b
    Examples:
      gonio bake harmonics studio.hdr
      gonio bake harmonics sunsky --json
    """
    from gonio.bake import environment as environments

    found = environments.load(environment).harmonics()
    if as_json:
        names = environments.HARMONICS
        echo_json([{"harmonic": n, "rgb": list(c)} for n, c in zip(names, found, strict=True)])
        return
    for name, colour in zip(environments.HARMONICS, found, strict=True):
        click.echo(f"{name:<10}  " + "  ".join(f"{value:10.6f}" for value in colour))
