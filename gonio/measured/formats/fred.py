"""FRED's text table: for each incidence theta_i phi_i, rows theta_s phi_s value.

Azimuths of FRED follow the light: with phi_i = 0 the mirror direction is at phi_s = 0. So gonio's wi,
which points back to the light, is half a turn away.
"""

from __future__ import annotations

import numpy as np

from gonio.measured.measurement import Measurement
from gonio.measured.points import Rows, points
from gonio.measured.source import Source

NAME, SUFFIX = "FRED table", ".txt"


def sniff(source: Source) -> bool:
    """By its first words."""
    if b"\0" in source.head:
        return False
    lines = [line.split() for line in source.head.lower().splitlines()[:50] if line.strip()]
    return any(line[:2] == [b"type", b"bsdf_data"] for line in lines) or any(
        line[0] == b"format" and any(word.startswith(b"bsdf=") for word in line) for line in lines
    )


def read(source: Source) -> list[Measurement]:
    """The reflection; directions below the surface are transmission."""
    words: dict[str, str] = {}
    comments: list[str] = []
    rows = Rows(source, 5)
    incidence: list[str] | None = None
    for number, text in source.lines():
        if not text:
            continue
        if text[0] in "#!/;":
            comments.append(text.strip("#!/; "))
            continue
        parts = text.split()
        if parts[0].lower() == "format":
            words |= dict(p.lower().split("=", 1) for p in parts[1:] if "=" in p)
        elif parts[0].lower() == "type":
            words["type"] = " ".join(parts[1:])[:80]
        elif len(parts) == 2:
            incidence = parts
        elif len(parts) == 3:
            if incidence is None:
                raise source.error("has a value before the first incidence, theta phi.", number)
            rows.add([*incidence, *parts], number)
        else:
            raise source.error(
                f"has {len(parts)} entries; 2 are an incidence and 3 a value.", number
            )
    unit = words.get("angles", "deg")
    if unit not in {"deg", "degrees", "rad", "radians"}:
        raise source.error(f"its angles are in {unit[:40]!r}; deg and rad are read.")
    scale = source.number(words.get("scale", "1"), 0, "the scale")
    kind = words.get("bsdf", "value")
    table = rows.table()
    radians = 1.0 if unit.startswith("rad") else np.pi / 180
    values = table[:, 4:] * scale
    if kind in {"log", "log10"}:
        with np.errstate(over="ignore"):
            values = scale * 10.0 ** table[:, 4:]
    elif kind != "value":
        raise source.error(f"its values are bsdf={kind[:40]}; value and log are read.")
    angles = table[:, :4].copy()
    angles[:, 1] += np.pi / radians
    notes = ["azimuths followed the light: half a turn was added to the light's"]
    if scale != 1:
        notes.append(f"values were multiplied by the file's scale {scale:g}")
    return [
        points(
            NAME,
            source,
            angles,
            values,
            unit=radians,
            lines=rows.lines,
            channels=("value",),
            notes=tuple(notes),
            metadata=words | ({"comment": " ".join(comments)[:500]} if comments else {}),
        )
    ]
