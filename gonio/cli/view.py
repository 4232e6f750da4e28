"""`gonio view`: models in real time, in the browser."""

from __future__ import annotations

from pathlib import Path

import click

from gonio.cli._code import Code, code_options
from gonio.cli.program import complete, say
from gonio.foreign import ForeignError, is_foreign
from gonio.materials import library
from gonio.materials.notation import split
from gonio.measured.files import is_named_like_data
from gonio.model import models


@click.command("view", short_help="Look at models interactively, in the browser.")
@click.argument("models", nargs=-1, metavar="[MODEL]...", shell_complete=complete)
@click.option("--save", metavar="FILE", help="Write one .html file that works without gonio.")
@click.option("--port", type=click.IntRange(0, 65535), default=0, help="Default: a free one.")
@click.option("--no-open", is_flag=True, help="Print the address, and open no browser.")
@code_options
def command(
    models: tuple[str, ...], save: str | None, port: int, no_open: bool, code: Code
) -> None:
    """Show MODELs path traced, with sliders, plots, probe and code; two are compared.

    A MODEL is a model (eon, or eon:roughness=1), a ready material, or your own .py or .toml file, which is
    read again when you save it; a file of measured reflection; or a function of shader code that others
    wrote (.glsl, .frag, .essl, .brdf and .wgsl), whose own text draws the picture. The page comes from this
    machine alone and sends nothing anywhere.

    \b
    Examples:
      gonio view                        start with eon, choose others in the page
      gonio view car_paint_red_strong
      gonio view eon:roughness=1 oren_nayar:sigma=0.5
      gonio view my_model.py            edit the file and watch
      gonio view paint.binary eon       a measurement beside a model
      gonio view brdf.glsl#ggx eon      your engine's function beside a model
      gonio view gold --save gold.html  one file to send, with its sliders
    """
    from gonio.view import page, server

    texts = [code.named(text) for text in models] or ["eon"]
    files = list(dict.fromkeys(name for name in map(_file_of, texts) if name))
    _check_code(code, [name for name in files if is_foreign(name)])
    if len(texts) > 2 and save is None:
        raise click.UsageError("the page shows two models, A and B; name at most two.")
    names = page.Names(files, code.load, code.defines)
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
    try:
        viewer = server.Viewer(texts, names, port)
    except OSError as error:
        raise click.UsageError(
            f"port {port} cannot be used ({error.strerror}); leave --port out for a free one."
        ) from None
    click.echo(f"gonio view: {viewer.url}\nCtrl C ends it.")
    try:
        server.serve(viewer, open_browser=not no_open)
    except KeyboardInterrupt:
        click.echo()


def _file_of(text: str) -> str:
    """The file that a text names, or nothing; of code with its function."""
    name, _ = split(text)
    own = name.endswith((".py", ".toml")) or is_foreign(name)
    known = name in models() or name in library()
    return name if own or (not known and is_named_like_data(name)) else ""


def _check_code(code: Code, foreign: list[str]) -> None:
    """Say early which code and which of its options the page has no use for.

    Raises:
        ForeignError: with what to do instead.
    """
    from gonio.view.foreign_code import check_runs

    if code.given and not foreign:
        raise ForeignError(
            "--function, --map and the like belong to a FILE of code, such as x.glsl#eval."
        )
    for name in foreign:
        check_runs(name)
    if code.sample or code.pdf or code.albedo:
        raise ForeignError(
            "the page samples code by a rule of its own; 'gonio check' judges --sample, --pdf and --albedo."
        )
    if code.textures:
        raise ForeignError("the page binds no textures to code; 'gonio plot' takes --texture.")
