"""`gonio bake` and its commands."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import click

from gonio.cli._numbers import Number
from gonio.cli.program import complete, echo_json, json_option, progress

if TYPE_CHECKING:
    from gonio.bake.tables import TableError

# An error of F that shows; rows of metals and glass have a fifth of it, 8 bits included.
SEEN = 0.02


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
      gonio bake cube studio.hdr -o studio.ktx2
      gonio bake split-sum ue4
    """
    if ctx.invoked_subcommand is None:
        click.echo(ctx.get_help())


@command.command(short_help="F of a material, by the cosine.")
@click.option(
    "--eta", metavar="N[,N,N]", help="Relative index; one number or three, or a dielectric's name."
)
@click.option("--k", metavar="N[,N,N]", help="Extinction, for metals (default: 0).")
@click.option("--metal", metavar="SYMBOL", help="A metal such as Cu instead of --eta and --k.")
@click.option("--entries", type=click.IntRange(2, 1 << 16), default=128, show_default=True)
@click.option("-o", "--output", default="fresnel.npy", metavar="FILE", help="A .npy or .exr file.")
def fresnel(eta: str | None, k: str | None, metal: str | None, entries: int, output: str) -> None:
    """Write a table of the exact Fresnel reflectance at evenly spaced cosines from 0 to 1.

    \b
    Examples:
      gonio bake fresnel --eta 1.5 -o glass.npy
      gonio bake fresnel --eta water -o water.npy
      gonio bake fresnel --metal Cu --entries 64 -o copper.exr
    """
    from gonio.bake import tables
    from gonio.parts import metals

    if (eta is None) == (metal is None):
        raise click.UsageError("give either --eta, such as 1.5, or --metal, such as Cu")
    if metal is not None and k is not None:
        raise click.UsageError("--metal says what k is; leave out --k")
    tables.check_table(output)
    if metal is not None:
        index: dict[str, Any] = dict(metals.metal(metal))
    else:
        index = {"eta": _parse_index(str(eta)), "k": _parse_numbers("--k", k or "0")}
    tables.check_index(**index)
    table = tables.fresnel_table(**index, entries=entries)
    tables.write_table(output, table)
    error = tables.fresnel_error(table, **index)
    click.echo(f"{output}: {_said(error)}")


def _said(error: TableError) -> str:
    """How far a table of F is off, and what to do where that shows."""
    said = f"largest error {error.largest:.2g}, at {error.at:.1f} degrees"
    return said if error.largest < SEEN else f"{said}; more --entries make it less"


def _parse_index(text: str) -> list[float]:
    """Numbers, or the index of a named dielectric."""
    from gonio.parts.dielectrics import dielectric

    return [dielectric(text)] if text[:1].isalpha() else _parse_numbers("--eta", text)


def _parse_numbers(option: str, text: str) -> list[float]:
    try:
        numbers = [float(number) for number in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) not in (1, 3) or not all(map(math.isfinite, numbers)):
        raise ValueError(f"{option} {text} is not a finite number, or three as in 0.2,0.9,1.1.")
    return numbers


@command.command(short_help="F of many materials in one picture.")
@click.argument("materials", nargs=-1, required=True, metavar="MATERIAL...")
@click.option("--entries", type=click.IntRange(2, 1 << 14), default=128, show_default=True)
@click.option("--bits", type=click.Choice(["8", "16"]), default="8", show_default=True)
@click.option("-o", "--output", default="atlas.png", show_default=True, metavar="FILE.png")
def atlas(materials: tuple[str, ...], entries: int, bits: str, output: str) -> None:
    """Write the exact Fresnel reflectance of MATERIALs, a row for each, over cosines from 0 to 1.

    A MATERIAL is a metal's symbol, such as Cu, a dielectric's name, such as water, or an index, such as
    1.5, relative to the side that the light comes from: 1 or more. Says what rounding and interpolation
    cost each row.

    \b
    Examples:
      gonio bake atlas Cu Au Al water 1.5
      gonio bake atlas Cu Cr --bits 16 --entries 256 -o metals.png
    """
    from gonio.bake import atlas as atlases

    if twice := sorted({name for name in materials if materials.count(name) > 1}):
        raise ValueError(f"{twice[0]} is named twice; rows have their materials' names.")
    indices = {name: _index_of(name) for name in materials}
    made = atlases.fresnel_atlas(indices, entries=entries, bits=int(bits))
    made.write(output)
    for row, name in enumerate(made.names):
        click.echo(f"row {row}, {name}: {_said(made.errors[name])}")
    click.echo(output)


def _index_of(name: str) -> dict[str, Any]:
    """Index and extinction of a metal, a dielectric or a number."""
    from gonio.parts import dielectrics, metals

    if name[:1].isdecimal() or name[:1] == ".":
        return {"eta": _parse_numbers("the index", name)}
    if name in metals.metals():
        return dict(metals.metal(name))
    try:
        return {"eta": dielectrics.dielectric(name)}
    except ValueError as error:
        known = ", ".join(metals.metals())
        raise ValueError(f"no metal and {str(error)[:-1]}; of metals {known}.") from None


@command.command(short_help="D for all widths and angles.")
@click.argument("kind", default="beckmann", metavar="[DISTRIBUTION]")
@click.option("--size", type=click.IntRange(2, 8192), default=512, show_default=True)
@click.option(
    "--exponent",
    type=Number(1, 16),
    default=8,
    show_default=True,
    help="The angle is a quarter turn times u to this power; with 1 sharp highlights are lost.",
)
@click.option("--bits", type=click.Choice(["16", "32"]), default="32", show_default=True)
@click.option("-o", "--output", metavar="FILE", help="A .npy or .exr file (default: NAME.npy).")
def distribution(kind: str, size: int, output: str | None, exponent: float, bits: str) -> None:
    """Write D over u (to the right, theta = 90 degrees times u^8) and width (downwards).

    DISTRIBUTION is beckmann, ggx, blinn_phong or gaussian. Row v, from 0 to 1, has alpha = 0.003^(1 - v).

    \b
    Examples:
      gonio bake distribution
      gonio bake distribution ggx --size 256 --bits 16 -o ggx.exr
      gonio bake distribution beckmann --exponent 1 -o linear.exr
    """
    from gonio.bake import tables

    target = output or f"{kind}.npy"
    tables.check_table(target)
    table = tables.distribution_table(kind, size, exponent)
    tables.write_table(target, table, int(bits))
    stored = table if bits == "32" else tables.in_halves(table)
    error = tables.distribution_error(stored, kind, exponent)
    click.echo(
        f"{target}: largest error {error.largest:.2g} of the peak, at {error.at:.1f} degrees; "
        f"of the integral {error.mean:.2g}"
    )


@command.command(short_help="An environment as a rough surface mirrors it.")
@click.argument("environment", metavar="NAME|FILE")
@click.option(
    "--alpha",
    type=Number(0, 1, above=True),
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
    environments.check_blur(alpha, width)
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


@command.command(short_help="A cube map with prefiltered levels.")
@click.argument("environment", metavar="NAME|FILE")
@click.option("--size", type=int, default=256, show_default=True, help="Texels along a face.")
@click.option(
    "-o",
    "--output",
    default="environment.ktx2",
    show_default=True,
    metavar="PATH",
    help="A .ktx2 file, or a folder for six .exr files a level.",
)
def cube(environment: str, size: int, output: str) -> None:
    """Write an environment as a cube map whose 6 levels are blurred by GGX lobes, for --lit exports.

    Level k has alpha = (k / 5)^2. Also says how far the cube is from the blurred picture between levels.

    \b
    Examples:
      gonio bake cube studio.hdr -o studio.ktx2
      gonio bake cube sunsky --size 128 -o sky/
    """
    from gonio.bake import cube as cubes
    from gonio.bake import environment as environments

    target = cubes.check_place_of(output.rstrip("/") or "/")
    cubes.check_size(size)
    sky = environments.load(environment)
    with progress("blurring") as step:
        made = cubes.prefiltered(sky, size, progress=step)
    paths = made.write(target)
    click.echo("\n".join(map(str, paths)))
    for alpha in (0.09, 0.49):  # half way between two levels
        off = cubes.error(made, sky, alpha)
        click.echo(f"alpha {alpha:.2f}, between two levels: {100 * off:.2g} % off on the mean")


@command.command(
    "split-sum", short_help="What a model's highlight reflects of light from everywhere."
)
@click.argument("model", metavar="MODEL", shell_complete=complete)
@click.option("--size", type=click.IntRange(2, 1024), default=64, show_default=True)
@click.option("-o", "--output", metavar="FILE", help="A .npy or .exr file (default: NAME.exr).")
def split_sum(model: str, size: int, output: str | None) -> None:
    """Write the split-sum table of a model's highlight, for --lit exports; tri-Ace's is the AmbientBRDF.

    Two channels, A and B: the highlight reflects f0 A + f90 B. The viewer's cosine goes to the right, the
    root of alpha down, both from 0 to 1 with values in the middles of the texels. A coat has its base's.

    \b
    Examples:
      gonio bake split-sum ue4:light=image
      gonio bake split-sum triace_blinn_phong --size 128 -o ambient_brdf.exr
    """
    from gonio.bake import split_sum as sums
    from gonio.bake.tables import check_table, write_table
    from gonio.materials import Material, load

    found = load(model)
    given = found.model if isinstance(found, Material) else found
    target = output or f"{found.name}.exr"
    check_table(target)
    chosen = sums.highlighted(given)
    with progress("integrating") as step:
        table = sums.split_sum_table(chosen, size, progress=step)
    write_table(target, table)
    off = sums.split_sum_error(table, chosen)
    click.echo(f"{target}: between texels at most {off:.2g} off")
