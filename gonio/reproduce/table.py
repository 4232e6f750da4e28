"""An item's numbers as a table, in Markdown."""

from __future__ import annotations

import math

from gonio.reproduce.sheet import Line
from gonio.reproduce.text import Made

HEADER = ("", "text", "gonio", "difference", "verdict")

SIGNS = {"=": "", "<=": "≤ ", ">=": "≥ ", "": ""}


def table(made: Made) -> str:
    """Title, verdict, and the text's numbers beside gonio's."""
    item = made.item
    lines = [
        f"# {item.id}: {made.verdict.value}",
        "",
        f"{item.text.title}, {item.source}: {item.states}",
        "",
    ]
    if made.sheet.lines:
        lines += [_row(HEADER), _row(["---"] * len(HEADER))]
        lines += [_row(cells(line)) for line in made.sheet.lines]
        lines.append("")
    lines += [f"- {note}" for note in made.sheet.notes()]
    return "\n".join(lines).rstrip() + "\n"


def cells(line: Line) -> tuple[str, str, str, str, str]:
    """One line's name, the text's number, ours, the difference, and what follows."""
    difference = line.difference
    shown = "" if not math.isfinite(difference) else _difference(line)
    proof = "" if line.proof is None else f", right is {number(line.proof)}"
    return (
        line.what,
        f"{SIGNS[line.relation]}{line.text}",
        number(line.ours),
        shown,
        line.state + proof,
    )


def _difference(line: Line) -> str:
    difference, stated = line.difference, line.stated
    if difference == 0:
        return "0"
    percent = 100 * difference / stated if stated else 0
    # A percentage of a bound, or of next to nothing, tells nobody anything
    told = line.relation == "=" and 1e-4 <= abs(percent) < 1000
    relative = f" ({percent:+.2g} %)" if told else ""
    return f"{difference:+.2g}{relative}"


def number(x: float) -> str:
    """Six digits, as short as they go."""
    return f"{x:.6g}"


def _row(columns: object) -> str:
    return "| " + " | ".join(str(c).replace("|", "\\|") for c in columns) + " |"  # type: ignore[attr-defined]
