"""`gonio cite`."""

from __future__ import annotations

from pathlib import Path

import click

from gonio.cli.program import complete


@click.command("cite", short_help="Print the BibTeX of a model's sources.")
@click.argument("models", nargs=-1, required=True, metavar="MODEL...", shell_complete=complete)
@click.option("--parts", is_flag=True, help="Also the sources of what the models are made of.")
@click.option("-o", "--output", metavar="FILE.bib", help="A file (default: print the text).")
def command(models: tuple[str, ...], parts: bool, output: str | None) -> None:
    """Print the publications behind each MODEL as BibTeX, each of them once.

    A MODEL is a model, a ready material, or a .toml or .py file. Models inside a model count: a coat over
    EON cites both. With --parts, also the distributions, maskings and so on that their files use.

    \b
    Examples:
      gonio cite eon
      gonio cite lacquered_walnut skin -o sources.bib
      gonio cite torrance_sparrow --parts
    """
    from gonio.description.citations import bibtex
    from gonio.files import replacing
    from gonio.materials import Material, load

    wanted = [load(text) for text in models]
    text = bibtex([m.model if isinstance(m, Material) else m for m in wanted], parts=parts)
    if output is None:
        click.echo(text, nl=False)
        return
    with replacing(output) as path:
        Path(path).write_text(text, encoding="utf-8")
    click.echo(output)
