"""`gonio plot`."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import click
from click.shell_completion import CompletionItem

from gonio.cli._code import Code, code_options
from gonio.cli._numbers import AZIMUTHS, POLAR_ANGLES
from gonio.cli.program import complete, param_option
from gonio.messages import did_you_mean

KINDS_HELP = (
    "polar and cartesian slices of lobes, surface for lobes in space, scattering for single and "
    "multiple apart, albedo, error for the difference from the first model, distribution, masking and "
    "fresnel for D, G and F, sampling for the quality of the samplers"
)


# How publications call what these show.
SYMBOLS = {"D": "distribution", "NDF": "distribution", "F": "fresnel", "G": "masking"}


class Kind(click.ParamType[str]):
    """A kind of plot."""

    name = "kind"

    def convert(self, value: Any, param: Any, ctx: Any) -> str:
        """The kind, if there is such a one."""
        from gonio.plot import KINDS

        if value not in KINDS:
            meant = SYMBOLS.get(str(value).upper())
            hint = f"did you mean {meant!r}? " if meant else did_you_mean(str(value), KINDS)
            known = f"{'Known' if hint else 'known'} are {', '.join(KINDS)}"
            self.fail(f"no plot {value!r}; {hint}{known}", param, ctx)
        return str(value)

    def shell_complete(self, ctx: Any, param: Any, incomplete: str) -> list[CompletionItem]:
        """The kinds that begin so."""
        from gonio.plot import KINDS

        return [CompletionItem(name) for name in KINDS if name.startswith(incomplete)]


@click.command("plot", short_help="Plot models to PNG, SVG, PDF or CSV.")
@click.argument("models", nargs=-1, required=True, metavar="MODEL...", shell_complete=complete)
@click.option(
    "-k",
    "--kind",
    type=Kind(),
    default="polar",
    show_default=True,
    metavar="KIND",
    help=f"What to plot: {KINDS_HELP}.",
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
    "--theta-o", type=POLAR_ANGLES, metavar="DEG,...", help="Angles of the viewer, a panel each."
)
@click.option(
    "--phi",
    type=AZIMUTHS,
    metavar="DEG,...",
    help="Planes through the normal, by their azimuth from the viewer: 90 is the one across.",
)
@click.option(
    "--theta-i",
    type=POLAR_ANGLES,
    metavar="DEG,...",
    help="Angles of the light: it turns about the normal at these (cartesian), or stands there (masking).",
)
@click.option("--axis", type=click.Choice(["degrees", "cosine"]), help="Of a cartesian plot.")
@click.option("--log", is_flag=True, help="A logarithmic axis, which shows tails.")
@click.option("--dots", is_flag=True, help="Albedos by quadrature as dots, beside the formulas.")
@click.option("--samples", type=click.IntRange(1), help="Drawn for each point of a sampling plot.")
@click.option("--no-cosine", is_flag=True, help="Plot f, not f cos(theta_i).")
@click.option(
    "--along", metavar="NAME", help="The parameter of the axis, for albedo and sampling plots."
)
@click.option(
    "--channel",
    type=click.Choice(["luminance", "red", "green", "blue"]),
    help="What to plot of a coloured model (default: luminance); a .csv has all.",
)
@click.option("--title", metavar="TEXT", help="Another title.")
@click.option("--dpi", type=click.IntRange(20, 1200), default=200, show_default=True)
@code_options
def command(
    models: tuple[str, ...],
    kind: str,
    output: str | None,
    params: tuple[str, ...],
    vary: str | None,
    theta_o: tuple[float, ...] | None,
    phi: tuple[float, ...] | None,
    theta_i: tuple[float, ...] | None,
    axis: str | None,
    log: bool,
    dots: bool,
    samples: int | None,
    no_cosine: bool,
    along: str | None,
    channel: str | None,
    title: str | None,
    dpi: int,
    code: Code,
) -> None:
    """Plot one or more models into a picture, or the numbers into a CSV file.

    A MODEL may carry parameters: eon:roughness=1,rho=0.8/0.3/0.1 (colours with slashes). It may also be
    code that others wrote, as in 'gonio check': shading.glsl#specular.

    \b
    Examples:
      gonio plot lambert qon:sigma=1.57 fon:roughness=1 eon:roughness=1 -o lobes.svg
      gonio plot eon --vary roughness=0,0.25,0.5,0.75,1 --theta-o 60 --no-cosine
      gonio plot eon qon oren_nayar --kind albedo -p rho=1 -o albedo.pdf
      gonio plot eon:roughness=1 --kind surface --theta-o 30,75
      gonio plot oren_nayar qon:sigma=pi/4 eon --kind cartesian --theta-o 75 --phi 0,90
      gonio plot torrance_sparrow --kind distribution --vary distribution=ggx,beckmann --log
      gonio plot triace_layered --kind fresnel --vary bottom_fresnel=exact,constant --log
      gonio plot eon eon:albedo_form=fitted --kind error -p roughness=1
      gonio plot eon --kind sampling --vary sampler=cltc_uniform,cltc,cosine -p rho=1
      gonio plot eon --kind sampling --along roughness --theta-o 0,85
      gonio plot eon -o eon.csv
      gonio plot shading.glsl#specular ue4 --vary roughness=0.2,0.5 --map "rough=roughness"
    """
    from gonio import plot as plots

    materials = code.materials(_variations([code.named(text) for text in models], vary), params)
    settings: dict[str, Any] = {
        "along": along,
        "channel": channel,
        "title": title,
        "axis": axis,
        "samples": samples,
        "log": log or None,
        "dots": dots or None,
        "cosine": False if no_cosine else None,
    }
    alone = phi is not None and kind == "polar" and len(phi) == 1
    settings |= {"theta_o": theta_o, "theta_i": theta_i, "phi": phi[0] if phi and alone else phi}
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
        f"{text}{',' if '=' in text else ':'}{name}={value}"
        for text in models
        for value in values.split(",")
    ]
