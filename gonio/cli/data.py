"""`gonio data`."""

from __future__ import annotations

import click

from gonio.cli.program import echo_json, json_option, plain_models, say


@click.command("data", short_help="Look at, judge and convert files of measured reflection.")
@click.argument("file", metavar="FILE|MODEL")
@click.option("--part", metavar="NAME", help="Another part of the file, such as transmission.")
@click.option(
    "--convert",
    "output",
    metavar="OUT",
    help="Write it as MERL (.binary), RGL (.bsdf), MDL (.mbsdf), ALTA (.alta) or CSV (.csv).",
)
@click.option(
    "--format", "format_", metavar="NAME", help="Of --convert, if the suffix does not say it."
)
@click.option(
    "--picture",
    metavar="PNG",
    help="Draw lobes, directions, values and albedos (.png .svg .pdf .csv).",
)
@json_option
def command(
    file: str,
    part: str | None,
    output: str | None,
    format_: str | None,
    picture: str | None,
    as_json: bool,
) -> None:
    """Say what a file of measured reflection holds: format, angles, holes, noise, spectra, albedos.

    Formats are known by their content: MERL, RGL, MDL .mbsdf, Zemax, ASTM E1392, pbrt, FRED, ALTA, BSDF
    XML (Klems and tensor trees) and CSV. Given a model, --convert writes it as such a file.

    \b
    Examples:
      gonio data paint.binary
      gonio data paint.bsdf --picture paint.png
      gonio data blind.xml --part transmission
      gonio data paint.mbsdf --convert paint.binary
      gonio data disney:roughness=0.3 --convert disney.bsdf   # for Mitsuba's 'measured'
    """
    from gonio import measured
    from gonio.plot.output import check_output

    if format_ is not None and output is None:
        raise click.UsageError("--format belongs to --convert")
    if output is not None:
        measured.format_for(output, format_)
    if picture is not None:
        check_output(picture)
    if _is_model(file):
        _convert_model(file, part, output, format_, picture, as_json)
        return
    parts = measured.load_parts(file)
    found = parts[0] if part is None else measured.load(file, part)
    if output is not None:
        say(f"converting {file} ...")
        for lost in measured.save(output, found, format_):
            click.echo(f"gonio: {output}: {lost}", err=True)
        if picture is None and not as_json:
            click.echo(output)
            return
    from gonio.measured import summary
    from gonio.measured.quality import quality

    say(f"looking at {len(found.values)} places ...")
    q = quality(found)
    if picture is not None:
        from gonio.measured.picture import save

        save(picture, found, q)
    if as_json:
        echo_json(summary.data(found, q))
        return
    for line in summary.lines(
        found, q, [p.part for p in parts if p is not found and p.part != found.part]
    ):
        click.echo(line)
    for written in (output, picture):
        if written is not None:
            click.echo(written)


def _is_model(text: str) -> bool:
    """Whether a text names a model and no file."""
    from pathlib import Path

    from gonio.materials import library
    from gonio.model import models

    name = text.partition(":")[0]
    return not Path(text).exists() and (
        name in models() or name in library() or name.endswith(".py")
    )


def _convert_model(
    text: str,
    part: str | None,
    output: str | None,
    format_: str | None,
    picture: str | None,
    as_json: bool,
) -> None:
    from gonio import measured

    if output is None or part is not None or picture is not None or as_json:
        raise click.UsageError(
            f"{text} is a model, not a file: --convert OUT writes it, and nothing else goes with it"
        )
    (found,) = plain_models([text])
    say(f"evaluating {text} ...")
    for lost in measured.save(output, found, format_):
        click.echo(f"gonio: {output}: {lost}", err=True)
    click.echo(output)
