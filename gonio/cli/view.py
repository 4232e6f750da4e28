"""`gonio view`: models in real time, in the browser."""

from __future__ import annotations

from pathlib import Path

import click

from gonio.cli.program import complete, say
from gonio.foreign import is_foreign
from gonio.materials.notation import split


@click.command("view", short_help="Look at models interactively, in the browser.")
@click.argument("models", nargs=-1, metavar="[MODEL]...", shell_complete=complete)
@click.option("--save", metavar="FILE", help="Write one .html file that works without gonio.")
@click.option("--port", type=click.IntRange(0, 65535), default=0, help="Default: a free one.")
@click.option("--no-open", is_flag=True, help="Print the address, and open no browser.")
def command(models: tuple[str, ...], save: str | None, port: int, no_open: bool) -> None:
    """Show MODELs path traced, with sliders, plots, probe and code; two are compared.

    A MODEL is a model (eon, or eon:roughness=1), a ready material, or your own .py or .toml file, which is
    read again when you save it. The page comes from this machine alone and sends nothing anywhere.

    \b
    Examples:
      gonio view                        start with eon, choose others in the page
      gonio view car_paint_red_strong
      gonio view eon:roughness=1 oren_nayar:sigma=0.5
      gonio view my_model.py            edit the file and watch
      gonio view gold --save gold.html  one file to send, with its sliders
    """
    from gonio.view import page, server

    texts = list(models) or ["eon"]
    for text in texts:
        if is_foreign(text):
            raise click.UsageError(
                f"{text} is code that others wrote, which the page cannot run; 'gonio plot' draws it, and "
                "'gonio compare FILE#FUNCTION MODEL -o difference.png' shows where it differs from a model."
            )
    if len(texts) > 2 and save is None:
        raise click.UsageError("the page shows two models, A and B; name at most two.")
    files = list(dict.fromkeys(name for name in map(_file_of, texts) if name))
    names = page.Names(files)
    for text in texts:
        names.find(text)  # what is wrong is said here rather than in the page
    if save is not None:
        path = Path(save)
        if path.suffix.lower() not in (".html", ".htm"):
            raise click.UsageError(f"--save writes a page; name it {path.stem or 'page'}.html.")
        from gonio.files import check_place, replacing
        from gonio.view.variants import pool

        check_place(path)
        text = page.saved(names, texts, pool(names, texts, say))
        with replacing(path) as temporary:
            temporary.write_text(text, encoding="utf-8")
        click.echo(path)
        return
    viewer = server.Viewer(texts, files, port)
    click.echo(f"gonio view: {viewer.url}\nCtrl C ends it.")
    try:
        server.serve(viewer, open_browser=not no_open)
    except KeyboardInterrupt:
        click.echo()


def _file_of(text: str) -> str:
    """The file that a text names, or nothing."""
    name, _ = split(text)
    return name if name.endswith((".py", ".toml")) else ""
