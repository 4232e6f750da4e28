"""What docs/formulas.md says of a model or of a text: read from the page, which alone has the equations."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Passage:
    """A piece of the page: what stands below a bold name, or below a table's head."""

    heading: str
    """Of the section that it stands in."""
    text: str


def passages(page: str) -> Iterator[Passage]:
    """The pieces of the page in front of the errata; each begins with a bold name or a table."""
    body, _, _ = page.partition("\n## Errata")
    heading, lines = "", []
    for line in body.splitlines():
        starts = line.startswith("## ")
        if starts or re.match(r"\*\*[^*]+\*\*", line):
            if lines:
                yield Passage(heading, "\n".join(lines).strip())
            lines = []
        if starts:
            heading = line[3:]
        else:
            lines.append(line)
    if lines:
        yield Passage(heading, "\n".join(lines).strip())


def of_class(page: str, name: str) -> list[Passage]:
    """The passages that name a class such as `gonio.EON`.

    Raises:
        ValueError: there are none.
    """
    wanted = re.compile(rf"`gonio\.{name}`")
    found = [p for p in passages(page) if p.heading and wanted.search(p.text)]
    if not found:
        raise ValueError(f"docs/formulas.md: the equations of `gonio.{name}` are missing.")
    return found


def errata(page: str) -> dict[str, str]:
    """The errata of each text by the key of its publication."""
    _, _, rest = page.partition("\n## Errata")
    found = {}
    for section in re.split(r"^### ", rest, flags=re.MULTILINE)[1:]:
        title, _, body = section.partition("\n")
        key = re.search(r"\[(\w+)\]", title)
        if key is None:
            raise ValueError(f"docs/formulas.md: no key of a publication in the heading {title!r}.")
        found[key[1]] = body.strip()
    return found


def read(root: Path) -> str:
    """The page."""
    return (root / "docs" / "formulas.md").read_text(encoding="utf-8")
