"""`gonio convert`."""

from __future__ import annotations

import click

from gonio.cli.program import echo_json, json_option


@click.command("convert", short_help="Convert between scales of roughness.")
@click.argument("value", metavar="NUMBER")
@click.option("--from", "source", required=True, metavar="SCALE", help="The scale of NUMBER.")
@click.option("--to", "target", required=True, metavar="SCALE", help="The scale that is wanted.")
@json_option
def command(value: str, source: str, target: str, as_json: bool) -> None:
    """Convert NUMBER between scales of roughness, and say what the conversion takes them to mean.

    \b
    Scales:
      perceptual  artists' roughness, alpha = perceptual^2
      alpha       width of a microfacet distribution; for Beckmann the rms slope m
      shininess   Blinn-Phong exponent n
      sigma       Oren-Nayar: standard deviation of the facet angle, radians
      r           roughness of FON and EON; unitless, not an angle

    \b
    Examples:
      gonio convert 0.5 --from perceptual --to alpha
      gonio convert 10 --from shininess --to r
      gonio convert pi/4 --from sigma --to r
    """
    from gonio import conversions
    from gonio.materials.notation import parse_angle

    try:
        given = parse_angle(value)
    except ValueError:
        raise click.UsageError(f"{value!r} is not a number, such as 0.5 or pi/4") from None
    result = conversions.convert(given, source, target)
    if as_json:
        steps = [step.__name__ for step in result.steps]
        echo_json({"value": result.value, "from": source, "to": target, "steps": steps})
        return
    click.echo(f"{result.value:.9g}")
    for step, meaning in zip(result.steps, result.meanings(), strict=True):
        click.echo(f"  {step.__name__}: {meaning}")
