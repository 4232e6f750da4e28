"""What notebooks show in place of text: tables as HTML."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from html import escape

LEFT = 'style="text-align: left"'


def _text(plain: str) -> str:
    """Text as HTML; names in backticks, as docstrings have them, are code."""
    return re.sub(r"`(\w+)`", r"<code>\1</code>", escape(plain))


def table(title: str, about: str, heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table under a bold title and some words. Its style is the notebook's own; all text is escaped."""

    def line(tag: str, cells: Sequence[str]) -> str:
        return "<tr>" + "".join(f"<{tag} {LEFT}>{_text(cell)}</{tag}>" for cell in cells) + "</tr>"

    return "\n".join(
        [
            "<table>",
            f"<caption {LEFT}><b>{_text(title)}</b> {_text(about)}</caption>",
            f"<thead>{line('th', heads)}</thead>",
            "<tbody>",
            *(line("td", row) for row in rows),
            "</tbody>",
            "</table>",
        ]
    )
