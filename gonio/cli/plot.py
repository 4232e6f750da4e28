"""`gonio plot`."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import click

from gonio.cli.program import complete, param_option


@click.command("plot", short_help="Plot models to PNG, SVG, PDF or CSV.")
@click.argument("models", nargs=-1, required=True, metavar="MODEL...", shell_complete=complete)
@click.option(
    "-k",
    "--kind",
    type=click.Choice(["polar", "albedo", "surface", "sampling"]),
    default="polar",
    show_default=True,
    help="Lobe slices, albedo curves, lobes in space, or the quality of the samplers.",
)
@click.option(
    "-o",
    "--output",
    metavar="FILE",
    help="A .png, .svg, .pdf or .csv file (default: KIND.png).",
)
@param_option
@click.option(
    "--vary",
    metavar="NAME=A,B,...",
    help="Plot every model once for each of these values of a parameter or option.",
)
@click.option(
    "--theta-o", metavar="DEG,...", help="Angles of the viewer, for polar and surface plots."
)
@click.option("--no-cosine", is_flag=True, help="Plot f, not f cos(theta_i) (polar, surface).")
@click.option("--along", metavar="NAME", help="The parameter mean albedos are plotted against.")
@click.option(
    "--channel",
    type=click.Choice(["luminance", "red", "green", "blue"]),
    help="What to plot of a coloured model (default: luminance); a .csv has all.",
)
@click.option("--title", metavar="TEXT", help="Another title.")
@click.option("--dpi", type=click.IntRange(20, 1200), default=200, show_default=True)
def command(
    models: tuple[str, ...],
    kind: str,
    output: str | None,
    params: tuple[str, ...],
    vary: str | None,
    theta_o: str | None,
    no_cosine: bool,
    along: str | None,
    channel: str | None,
    title: str | None,
    dpi: int,
) -> None:
    """Plot one or more models into a picture, or the numbers into a CSV file.

    A MODEL may carry parameters: eon:roughness=1,rho=0.8/0.3/0.1 (colours with slashes).

    \b
    Examples:
      gonio plot lambert qon:sigma=1.57 fon:roughness=1 eon:roughness=1 -o lobes.svg
      gonio plot eon --vary roughness=0,0.25,0.5,0.75,1 --theta-o 60 --no-cosine
      gonio plot eon qon oren_nayar --kind albedo -p rho=1 -o albedo.pdf
      gonio plot eon:roughness=1 --kind surface --theta-o 30,75
      gonio plot eon --kind sampling --vary sampler=cltc_uniform,cltc,cosine -p rho=1
      gonio plot eon -o eon.csv
    """
    from gonio import plot as plots
    from gonio.materials.notation import parse_model

    materials = [parse_model(text, params) for text in _variations(models, vary)]
    settings: dict[str, Any] = {"along": along, "channel": channel, "title": title}
    if theta_o is not None:
        settings["theta_o"] = _parse_angles(theta_o)
    if no_cosine:
        settings["cosine"] = False
    given = {name: value for name, value in settings.items() if value is not None}
    path = plots.plot(materials, kind, output or f"{kind}.png", dpi=dpi, **given)
    click.echo(path)


def _variations(models: Iterable[str], vary: str | None) -> list[str]:
    """Every model's text with every value of "name=a,b,...", as texts of models."""
    if vary is None:
        return list(models)
    name, equals, values = vary.partition("=")
    if not (name and equals and values):
        raise ValueError(f"--vary {vary} is not NAME=A,B,..., such as roughness=0,0.5,1.")
    return [
        f"{text}{',' if ':' in text else ':'}{name}={value}"
        for text in models
        for value in values.split(",")
    ]


def _parse_angles(text: str) -> list[float]:
    try:
        return [float(angle) for angle in text.split(",")]
    except ValueError:
        raise ValueError(f"--theta-o {text} is not a list of degrees, such as 0,30,60.") from None
