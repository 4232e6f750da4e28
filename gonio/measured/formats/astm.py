"""ASTM E1392 and E2387 as the Cornell Light Measurement Laboratory wrote it: `.astm`.

Lines KEY "value", NUM_POINTS n, VARS with the names of the columns, then rows with commas. Angles are in
radians.
"""

from __future__ import annotations

import re

import numpy as np

from gonio.measured.measurement import Measurement
from gonio.measured.points import Rows, points
from gonio.measured.source import Source

NAME, SUFFIX = "ASTM E1392", ".astm"

ANGLES = ("theta_i", "phi_i", "theta_s", "phi_s")

# Names that stand for one of red, green and blue.
COLOURS = {"red": "r", "green": "g", "blue": "b"}

MOST_COLUMNS = 4096


def sniff(source: Source) -> bool:
    """By the line VARS with the four angles."""
    found = re.search(rb"^[ \t]*VARS\b(.*)$", source.head, re.MULTILINE | re.IGNORECASE)
    return bool(found) and b"\0" not in source.head and b"theta" in source.head.lower()


def read(source: Source) -> list[Measurement]:
    """The reflection."""
    words: dict[str, str] = {}
    rows: Rows | None = None
    names: list[str] = []
    announced: int | None = None
    for number, text in source.lines():
        if not text or text.startswith("#"):
            continue
        if rows is not None:
            rows.add(re.split(r"\s*,\s*|\s+", text.strip(",; ")), number)
            continue
        key, _, value = text.partition(" ") if " " in text else text.partition("\t")
        value = value.strip()
        if key.upper() == "VARS":
            names = [name.strip() for name in re.split(r"[,\s]+", value) if name.strip()]
            missing = [a for a in ANGLES if a not in [n.lower() for n in names]]
            if missing or not len(ANGLES) < len(names) <= MOST_COLUMNS:
                raise source.error(
                    f"its columns are {', '.join(names)[:100] or 'none'}; {', '.join(ANGLES)} and values "
                    "are needed.",
                    number,
                )
            rows = Rows(source, len(names))
        elif key.upper() == "NUM_POINTS":
            announced = source.count(value, number, "NUM_POINTS")
        else:
            words[key[:40]] = value.strip('"')[:300]
    if rows is None:
        raise source.error("has no line VARS with the names of its columns.")
    table = rows.table()
    if announced is not None and announced != len(table):
        raise source.error(f"announces {announced} points; there are {len(table)}.")
    lower = [name.lower() for name in names]
    order = [lower.index(a) for a in ANGLES]
    rest = [i for i in range(len(names)) if i not in order]
    channels = tuple(COLOURS.get(lower[i], names[i][:40]) for i in rest)
    if len(rest) == 1:
        channels = ("value",)
    degrees = np.abs(table[:, order[0::2]]).max() > np.pi  # theta cannot be that large
    return [
        points(
            NAME,
            source,
            table[:, order],
            table[:, rest],
            unit=np.pi / 180 if degrees else 1.0,
            lines=rows.lines,
            channels=channels,
            notes=("angles are in degrees, though radians are the rule",) if degrees else (),
            metadata=words,
        )
    ]
