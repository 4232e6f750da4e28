"""Builds the documentation's site: `make docs`.

Pages are made from the code (`tools/site_pages`) and put beside those of docs/ into build/site/source, in
the same places as in the repository, so that their links lead to the same files; Sphinx makes
build/site/html of that. Pictures and plots are kept in build/site/pictures for as long as what they show
does not change.
"""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import click
from site_pages import api, formulas, materials, models, texts
from site_pages.pictures import Pictures
from site_pages.sources import Sources

from gonio.export.materialx import NAME as MATERIALX
from gonio.export.targets import TARGETS

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
BUILD = ROOT / "build" / "site"

# Pages that lie at the top of the repository.
TOP = ("CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md")


def assemble(sources: Sources, pictures: Pictures, results: Path) -> None:
    """All pages, written and generated, in the folder that Sphinx reads."""
    languages = list(TARGETS)[:1] if pictures.quick else [*TARGETS, MATERIALX]
    formulas_page = formulas.read(ROOT)
    models.write(sources, pictures, formulas_page, languages)
    materials.write(sources, pictures)
    texts.write(sources, results, formulas_page)
    api.write(sources)
    pages = [*DOCS.glob("*.md"), *DOCS.glob("guides/*.md"), *(ROOT / name for name in TOP)]
    places = {path: path.relative_to(ROOT) for path in pages}
    places[DOCS / "site" / "index.md"] = Path("index.md")
    places[ROOT / "README.md"] = Path("README.md")
    for path, place in places.items():
        sources.copy(path, str(place))
        for target in _linked_files(path, ROOT / place.parent):
            sources.copy(target, str(target.relative_to(ROOT)))


def _linked_files(page: Path, folder: Path) -> list[Path]:
    """Files of the repository that a page links to or shows from a folder, other than pages."""
    links = re.findall(r"\]\(([^)#\s]+)", page.read_text(encoding="utf-8"))
    found = [(folder / link).resolve() for link in links if "://" not in link]
    return [path for path in found if path.is_file() and path.suffix != ".md"]


# What the live page opens with: flakes under a clear coat show at once what a sampled BRDF is good for.
LIVE_START = ("car_paint_red_strong",)


def live_page(path: Path, *, quick: bool) -> None:
    """The viewer in one file, with all models and materials, or with those alone that it opens with."""
    from gonio.materials import library
    from gonio.model import models as registry
    from gonio.view import page

    held = LIVE_START if quick else (*registry(), *library())
    path.write_text(page.saved(page.Names(), held, opens=LIVE_START), encoding="utf-8")


# The site's theme puts a tree of all pages on each of them, which takes almost half of the time.
QUICK_THEME = "basic"


class SiteError(RuntimeError):
    """Sphinx found something wrong, and has said what."""


def build(output: Path, *, quick: bool, results: Path, jobs: int = 1) -> None:
    """Build the site below a folder.

    Raises:
        SiteError: Sphinx has warned.
    """
    output.mkdir(parents=True, exist_ok=True)
    sources = Sources(output / "source")
    pictures = Pictures(output / "pictures", quick=quick)
    assemble(sources, pictures, results)
    sources.clean()
    pictures.clean()
    run_sphinx(output, jobs, theme=QUICK_THEME if quick else None)
    live_page(output / "html" / "live.html", quick=quick)


def run_sphinx(output: Path, jobs: int = 1, theme: str | None = None) -> None:
    """Make html/ of source/; a warning is an error.

    Args:
        output: the folder of both.
        jobs: processes of Sphinx.
        theme: another than the site's.

    Raises:
        SiteError: Sphinx has warned.
    """
    command = [sys.executable, "-m", "sphinx", "--builder", "html", "--quiet"]
    command += ["--fail-on-warning", "--keep-going", "--jobs", str(jobs)]
    if theme is not None:
        command += ["-D", f"html_theme={theme}"]
    command += ["--conf-dir", str(DOCS / "site"), "--doctree-dir", str(output / "doctrees")]
    if subprocess.run([*command, str(output / "source"), str(output / "html")]).returncode:
        raise SiteError("Sphinx has warned; see above.")


@click.command()
@click.option("-o", "--output", type=click.Path(path_type=Path), default=BUILD, help="Folder.")
@click.option(
    "--quick", is_flag=True, help="With empty pictures, code in one language, and a plain theme."
)
@click.option(
    "--results",
    type=click.Path(path_type=Path),
    default=ROOT / "reproduced",
    help="What 'gonio reproduce --all' has written; shown on the pages of the texts.",
)
@click.option("--jobs", default=1, help="Processes of Sphinx.")
def command(output: Path, quick: bool, results: Path, jobs: int) -> None:
    """Build the documentation's site."""
    try:
        build(output, quick=quick, results=results, jobs=jobs)
    except SiteError as error:
        raise click.ClickException(str(error)) from None
    click.echo(output / "html" / "index.html")


if __name__ == "__main__":
    command()
