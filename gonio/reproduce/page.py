"""An item's picture with its numbers below, on one page."""

from __future__ import annotations

import tempfile
import textwrap
from pathlib import Path
from typing import Any

from gonio.files import replacing
from gonio.reproduce.rendered import fitted
from gonio.reproduce.sheet import Verdict
from gonio.reproduce.table import HEADER, cells
from gonio.reproduce.text import Made

MARGIN, LINE_HEIGHT = 24, 30
WIDTH_MIN = 1100
INK, FAINT, PAPER = "#222222", "#666666", "#ffffff"
COLOURS = {
    Verdict.AGREES: "#00704f",
    Verdict.TEXT_WRONG: "#b04a00",
    Verdict.SHOWN: "#34609a",
    Verdict.NOT_COMPARABLE: FAINT,
    Verdict.DIFFERS: "#c00000",
}


Box = tuple[int, int, int, int]
"""Left, top, right and bottom, in pixels."""


def write_page(made: Made, path: Path) -> Box:
    """Draw the picture, and below it the text's numbers beside gonio's.

    Returns:
        Where the picture alone is, for pages that show the numbers as text.
    """
    from PIL import Image, ImageDraw

    if made.picture is None:
        raise ValueError(f"{made.item.id} has no picture.")
    with (
        tempfile.TemporaryDirectory() as folder,
        Image.open(made.picture.save(Path(folder) / "picture.png")) as picture,
    ):
        drawn = fitted(picture)
    width = max(drawn.width, WIDTH_MIN) + 2 * MARGIN
    rows = _rows(made, width)
    top = MARGIN + 2 * LINE_HEIGHT
    height = top + drawn.height + MARGIN + LINE_HEIGHT * len(rows) + MARGIN
    page = Image.new("RGB", (width, height), PAPER)
    draw = ImageDraw.Draw(page)
    item = made.item
    draw.text((MARGIN, MARGIN), f"{item.id}:  ", font=_font(22, bold=True), fill=INK)
    after = MARGIN + draw.textlength(f"{item.id}:  ", font=_font(22, bold=True))
    verdict = made.verdict
    draw.text((after, MARGIN), verdict.value, font=_font(22, bold=True), fill=COLOURS[verdict])
    stated = f"{item.source}: {item.states}"
    draw.text(
        (MARGIN, MARGIN + LINE_HEIGHT),
        textwrap.shorten(stated, (width - 2 * MARGIN) // 9, placeholder=" …"),
        font=_font(16),
        fill=FAINT,
    )
    left = (width - drawn.width) // 2
    page.paste(drawn, (left, top))
    y = top + drawn.height + MARGIN
    for columns, colour in rows:
        for text, x in columns:
            draw.text((x, y), text, font=_font(17), fill=colour)
        y += LINE_HEIGHT
    with replacing(path) as temporary:
        page.save(temporary, format="PNG")
    return left, top, left + drawn.width, top + drawn.height


def _rows(made: Made, width: int) -> list[tuple[list[tuple[str, float]], str]]:
    """Lines of text: pieces with their places, and a colour."""
    inside = width - 2 * MARGIN
    rows: list[tuple[list[tuple[str, float]], str]] = []
    if made.sheet.lines:
        written = [HEADER, *map(cells, made.sheet.lines)]
        right = [max(_length(row[i]) for row in written) + 28 for i in range(1, 5)]
        longest = max(_length(row[0]) for row in written) + 28
        first = min(max(inside - sum(right), 0.3 * inside), longest)
        starts = [MARGIN + first + sum(right[:i]) for i in range(4)]
        for row, line in zip(written, [None, *made.sheet.lines], strict=True):
            colour = FAINT if line is None else INK
            if line is not None and line.state in ("fails", "text wrong"):
                wrong = line.state == "text wrong"
                colour = COLOURS[Verdict.TEXT_WRONG if wrong else Verdict.DIFFERS]
            pieces = [(text, x) for text, x in zip(row[1:], starts, strict=True)]
            fits = _length(row[0]) <= first
            *above, last = [row[0]] if fits else textwrap.wrap(row[0], max(int(first / 9.4), 12))
            rows += [([(part, MARGIN)], colour) for part in above]
            rows.append(([(last, MARGIN), *pieces], colour))
    for note in made.sheet.notes():
        rows += [([(part, MARGIN)], FAINT) for part in textwrap.wrap(note, int(inside / 9.0))]
    return rows


def _length(text: str) -> float:
    return float(_font(17).getlength(text))


def _font(size: int, bold: bool = False) -> Any:
    import matplotlib
    from PIL import ImageFont

    name = "DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf"
    return ImageFont.truetype(str(Path(matplotlib.get_data_path()) / "fonts/ttf" / name), size)
