"""`gonio reproduce`."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING

import click

from gonio.cli.program import was_given

if TYPE_CHECKING:
    from gonio.reproduce import Item


FOLDER = "reproduced"


@click.command("reproduce", short_help="Figures, tables and numbers of the texts, beside gonio's.")
@click.argument("names", nargs=-1, metavar="[ITEM]...")
@click.option("--text", "texts", multiple=True, metavar="NAME", help="All items of a text: eon.")
@click.option("--all", "everything", is_flag=True, help="All items of all texts.")
@click.option(
    "-o",
    "--output",
    default=FOLDER,
    show_default=True,
    metavar="FOLDER",
    help="Where pages, tables and numbers are written.",
)
@click.option("--again", is_flag=True, help="Also what an earlier run of the same gonio wrote.")
def command(
    names: tuple[str, ...], texts: tuple[str, ...], everything: bool, output: str, again: bool
) -> None:
    """Make what the texts show, with their numbers beside gonio's, the difference and a verdict.

    Without an ITEM it lists them. Each item becomes a table (.md) and its numbers (.json), figures
    also a page (.png). The verdict is computed: "agrees", "text wrong" with the proof, "shown" where
    the text has no number, "cannot be compared" with what cannot be had, or "gonio differs". What an
    interrupted run has written is kept.

    \b
    Examples:
      gonio reproduce
      gonio reproduce eon:11 triace:6a
      gonio reproduce --text eon -o eon
      gonio reproduce --all
    """
    from gonio import reproduce

    known = reproduce.texts()
    for name in texts:
        if name not in known:
            raise ValueError(f"no text {name!r}; there are {', '.join(known)}.")
    chosen = [reproduce.find(name) for name in names]
    chosen += [item for name, text in known.items() if name in texts for item in text.items]
    if everything:
        chosen = list(reproduce.items())
    chosen = list({item.id: item for item in chosen}.values())
    if not chosen:
        if again or was_given("output"):
            raise click.UsageError("nothing to make; name items, or give --text or --all.")
        _list(list(reproduce.items()))
        return
    start = time.monotonic()

    def step(done: int, total: int, item: Item, told: str) -> None:
        seconds = time.monotonic() - start
        click.echo(f"{done}/{total}  {item.id:<24} {told:<20} {seconds:5.0f} s")

    verdicts = reproduce.write_all(chosen, output, again=again, progress=step)
    if len(chosen) <= len(names):
        for item in chosen:
            click.echo("\n" + Path(output, f"{item.id.replace(':', '-')}.md").read_text("utf-8"))
    click.echo(f"{Path(output, 'index.md')}: {reproduce.counted(verdicts.values())}")


def _list(items: list[Item]) -> None:
    text = None
    for item in items:
        if item.text is not text:
            text = item.text
            click.echo(f"\n{text.name}: {text.title}" if text is not None else "")
        parts = f" ({', '.join(item.covers)})" if item.covers else ""
        click.echo(f"  {item.id:<24} {item.source}: {item.states}{parts}")
