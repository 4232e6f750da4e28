"""What notebooks show in place of text: tables as HTML."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

LEFT = 'style="text-align: left"'


def table(title: str, about: str, heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table under a bold title and some words. Its style is the notebook's own; all text is escaped."""

    def line(tag: str, cells: Sequence[str]) -> str:
        return "<tr>" + "".join(f"<{tag} {LEFT}>{escape(cell)}</{tag}>" for cell in cells) + "</tr>"

    return "\n".join(
        [
            "<table>",
            f"<caption {LEFT}><b>{escape(title)}</b> {escape(about)}</caption>",
            f"<thead>{line('th', heads)}</thead>",
            "<tbody>",
            *(line("td", row) for row in rows),
            "</tbody>",
            "</table>",
        ]
    )
