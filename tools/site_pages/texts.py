"""A page for each text: its figures, tables, equations and numbers beside gonio's, and its errata.

Nothing is computed here. What `gonio reproduce` has written into a folder is shown; of what it has not, the
command stands on the page.
"""

from __future__ import annotations

import importlib
import inspect
import json
import re
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from gonio import reproduce
from gonio.description import citations
from gonio.reproduce.runner import fingerprint
from gonio.reproduce.table import HEADER, SIGNS, number
from site_pages import formulas
from site_pages.markdown import fence, page, plain, sentence, table
from site_pages.sources import Sources

FOLDER = "texts"

WIDE = 1100  # pixels of a picture on the page
LONG = 16  # rows of a table that is folded away

CLASSES = {
    "agrees": "agrees",
    "text wrong": "text-wrong",
    "shown": "shown",
    "cannot be compared": "not-comparable",
    "gonio differs": "differs",
}


def write(sources: Sources, results: Path, formulas_page: str) -> None:
    """All texts, with the results that lie in a folder."""
    rows = []
    for name, text in reproduce.texts().items():
        made = {item.id: _result(results, item.id) for item in text.items}
        sources.write(f"{FOLDER}/{name}.md", _page(sources, text, made, results, formulas_page))
        told = _counted(made) or f"{len(text.items)} items"
        rows.append((f"[{plain(text.title)}]({name}.md)", told))
    hidden = "\n".join(["```{toctree}", ":hidden:", "", *reproduce.texts(), "```"])
    head = (
        "Four texts, each figure, table, equation and number of them beside what gonio computes, and their "
        "errata, each with its proof. Verdicts are computed from the numbers; they stand nowhere in the "
        "code. [How they are found](../docs/reproduce.md)."
    )
    sources.write(
        f"{FOLDER}/index.md", page("# The texts", head, table(("text", "verdicts"), rows), hidden)
    )


def _result(folder: Path, item: str) -> dict[str, Any] | None:
    path = folder / f"{item.replace(':', '-')}.json"
    if not path.is_file():
        return None
    found: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return found


def _counted(made: dict[str, dict[str, Any] | None]) -> str:
    verdicts = Counter(result["verdict"] for result in made.values() if result)
    missing = sum(result is None for result in made.values())
    told = [f"{verdicts[verdict]} {verdict}" for verdict in CLASSES if verdicts[verdict]]
    if told and missing:
        told.append(f"{missing} not made yet")
    return ", ".join(told)


def _publication(text: reproduce.Text) -> tuple[str, citations.Publication]:
    """What a text's folder says that it is, in words and as an entry of the bibliography."""
    told = inspect.getdoc(importlib.import_module(f"gonio.reproduce.{text.name}")) or ""
    return told, citations.named(told)[0]


def _page(
    sources: Sources,
    text: reproduce.Text,
    made: dict[str, dict[str, Any] | None],
    results: Path,
    formulas_page: str,
) -> str:
    told, publication = _publication(text)
    errata = formulas.errata(formulas_page).get(publication.key, "")
    counted = _counted(made)
    stale = any(result and result["fingerprint"] != fingerprint() for result in made.values())
    blocks: list[str | None] = [
        f"# {plain(text.title)}",
        plain(told),
        f"**{len(text.items)} items{': ' + counted if counted else ''}.**",
        "A few of these results were made by an earlier state of gonio's code." if stale else None,
        "Make them all, with pictures, numbers and verdicts:",
        fence(f"gonio reproduce --text {text.name}", "sh"),
    ]
    if errata:
        blocks += ["[Errata](#errata) are below."]
    if counted:
        blocks += [_overview(text, made)]
    named_before = Counter(item.source for item in text.items)
    for heading, items in _sections(text).items():
        blocks.append(f"## {heading}")
        for item in items:
            result = made[item.id]
            box = result["picture"] if result else None
            picture = results / f"{item.id.replace(':', '-')}.png"
            address = _put(sources, picture, box) if box else ""
            blocks += _item(item, result, address, named_before[item.source] > 1)
    if errata:
        blocks += ["## Errata", errata]
    blocks += ["## To cite it", fence(publication.bibtex(), "bibtex")]
    return page(*blocks)


# Sections of a page, and how the places of their items begin; all else is what the sentences say.
SECTIONS = {
    "Figures": ("Figure",),
    "Tables": ("Table", "Appendix"),
    "Equations": ("Eq.",),
    "Listings": ("Listing", "Algorithm"),
}
SENTENCES = "Sentences and numbers"


def _sections(text: reproduce.Text) -> dict[str, list[reproduce.Item]]:
    """The items by what they are, figures first."""
    found: dict[str, list[reproduce.Item]] = {name: [] for name in (*SECTIONS, SENTENCES)}
    for item in text.items:
        kinds = [name for name, starts in SECTIONS.items() if item.source.startswith(starts)]
        found[kinds[0] if kinds else SENTENCES].append(item)
    for name, items in found.items():
        if name != SENTENCES:
            items.sort(key=lambda item: _order(item.source))
    return {name: items for name, items in found.items() if items}


def _order(source: str) -> tuple[str, int]:
    """By the kind of place, and by the first number in it."""
    kind, number = re.match(r"(\D*)(\d*)", source).groups()  # type: ignore[union-attr]
    return kind, int(number or 0)


def _heading(item: reproduce.Item, shared: bool) -> str:
    """Where it stands; of a sentence what it says, because many stand in one section.

    The part of an item's name that follows the number tells those apart that share a place.
    """
    if item.source.startswith(tuple(s for starts in SECTIONS.values() for s in starts)):
        part = item.name.partition("-")[2] if shared else ""
        return plain(f"{item.source}, {part}" if part else item.source)
    return plain(sentence(item.states).rstrip("."))


def _overview(text: reproduce.Text, made: dict[str, dict[str, Any] | None]) -> str:
    """All verdicts in one table, folded away."""
    rows = []
    for item in text.items:
        place = f"[{plain(item.source)}](#{item.text.name}-{item.name})"
        rows.append((place, plain(sentence(item.states)), _badge(made[item.id])))
    listed = table(("where", "what it states", "verdict"), rows)
    return f"::::{{dropdown}} All {len(rows)} at a glance\n\n{listed}\n::::"


def _badge(result: dict[str, Any] | None) -> str:
    if result is None:
        return ""
    verdict = result["verdict"]
    return f'<span class="verdict {CLASSES[verdict]}">{verdict}</span> '


def _item(
    item: reproduce.Item, result: dict[str, Any] | None, picture: str, shared: bool
) -> list[str]:
    heading = _heading(item, shared)
    blocks = [f"({item.text.name}-{item.name})=\n### {heading}"]
    told = item.states if heading.startswith(plain(item.source)) else item.source
    blocks.append(f"{_badge(result)}{plain(sentence(told))}")
    if result is None:
        blocks.append(fence(f"gonio reproduce {item.id}", "sh"))
        return blocks
    if picture:
        blocks.append(f"![{plain(item.source)}: gonio's]({picture})")
    if result["lines"]:
        rows = [_cells(line) for line in result["lines"]]
        numbers = table(*_without_empty(HEADER, rows))
        if len(rows) > LONG:
            folded = f":::{{container}} numbers\n\n{numbers}\n:::"
            blocks.append(f"::::{{dropdown}} {len(rows)} numbers\n\n{folded}\n::::")
        else:
            blocks.append(f"::::{{container}} numbers\n\n{numbers}\n::::")
    if result["remarks"]:
        blocks.append("\n".join(f"- {plain(remark)}" for remark in result["remarks"]))
    blocks.append(f"`gonio reproduce {item.id}`")
    return blocks


def _without_empty(
    header: Sequence[str], rows: Sequence[Sequence[str]]
) -> tuple[list[str], list[list[str]]]:
    """A table without the columns that say nothing, such as the text's where it has no numbers."""
    told = [n for n in range(len(header)) if n == 0 or any(row[n] for row in rows)]
    return [header[n] for n in told], [[row[n] for n in told] for row in rows]


def _cells(line: dict[str, Any]) -> list[str]:
    right = "" if line["right"] is None else f", right is {number(line['right'])}"
    difference = "" if line["difference"] is None else _difference(line["difference"])
    ours = "not finite" if line["gonio"] is None else number(line["gonio"])
    return [
        plain(line["what"]),
        plain(f"{SIGNS[line['relation']]}{line['text']}"),
        ours,
        difference,
        plain(line["state"] + right),
    ]


def _difference(number: float) -> str:
    return f"{number:+.2g}".replace("-", "−") if number else "0"


def _put(sources: Sources, picture: Path, box: Sequence[int]) -> str:
    """The picture alone, in a size for the page, which has its title and its numbers as text."""
    from PIL import Image

    small = sources.folder / FOLDER / "pictures" / f"{picture.stem}.webp"
    if not small.is_file() or small.stat().st_mtime < picture.stat().st_mtime:
        small.parent.mkdir(parents=True, exist_ok=True)
        with Image.open(picture) as full:
            image = full.convert("RGB").crop(tuple(box))
            image.thumbnail((WIDE, 10 * WIDE))
            image.save(small, format="WEBP", quality=88)
    sources.put.add(small)
    return f"pictures/{small.name}"
