"""Zemax's (Radiant's) text `.bsdf`: about the mirror direction.

Source: "Zemax Tabular BSDF data file format", support.zemax.com. Azimuth 0 points from the mirror
direction to the normal; a plane-symmetric file has azimuths from 0 to 180. Numbers are in 1/sr. Below
the horizon files have 0, and where nothing was measured as well: both are holes.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from gonio.measured.frames import around_mirror, spherical
from gonio.measured.measurement import Measurement, measurement
from gonio.measured.source import MOST_NUMBERS, Source

NAME, SUFFIX = "Zemax BSDF", ".bsdf"

LISTS = ("SampleRotation", "AngleOfIncidence", "ScatterAzimuth", "ScatterRadial")
SYMMETRIES = ("planesymmetrical", "asymmetrical", "asymmetrical4d")

# Angles in one list.
MOST_ANGLES = 1 << 16


def sniff(source: Source) -> bool:
    """By the words that begin its lines."""
    return b"\0" not in source.head and any(
        word in line
        for line in source.head.splitlines()
        if not line.startswith(b"#")
        for word in (b"SampleRotation", b"AngleOfIncidence", b"ScatterRadial", b"ScatterAzimuth")
    )


def read(source: Source) -> list[Measurement]:
    """Reflection or transmission."""
    lines = ((n, t) for n, t in source.lines() if t)
    words: dict[str, str] = {}
    lists: dict[str, list[float]] = {}
    comments: list[str] = []
    for number, text in lines:
        if text.startswith("#"):
            comments.append(text.strip("# ="))
            continue
        key, *rest = text.split()
        if key.lower() == "databegin":
            break
        name = next((name for name in LISTS if name.lower() == key.lower()), None)
        if name is None:
            words[key.lower()] = " ".join(rest)
            continue
        count = source.count(rest[0] if rest else "", number, f"the number of {name}", MOST_ANGLES)
        lists[name] = _list(source, lines, name, count, number)
    else:
        raise source.error("has no line DataBegin; it is truncated.")
    missing = [name for name in LISTS if name not in lists]
    if missing:
        raise source.error(f"has no list {' and no list '.join(missing)} before DataBegin.")
    rotation, incidence, azimuth, radial = (np.radians(lists[name]) for name in LISTS)
    spectrum = words.get("spectralcontent", "monochrome").lower()
    channels = ("X", "Y", "Z") if spectrum in {"xyz", "tristimulus"} else ("value",)
    shape = (len(channels), len(rotation), len(incidence), len(azimuth), len(radial))
    count = int(np.prod([len(lists[name]) for name in LISTS], dtype=object)) * len(channels)
    if count > MOST_NUMBERS // 4:
        raise source.error(f"claims {count} numbers; at most {MOST_NUMBERS // 4} are read.")
    data, scatter = _data(source, lines, count)
    symmetry = words.get("symmetry", "").lower()
    if symmetry not in SYMMETRIES:
        raise source.error(
            f"its symmetry is {words.get('symmetry', '')[:40]!r}; PlaneSymmetrical, ASymmetrical or "
            "ASymmetrical4D are known."
        )
    through = words.get("scattertype", "BRDF").upper() == "BTDF"
    values = np.moveaxis(data.reshape(shape), 0, -1)
    turn, theta, a, r = np.meshgrid(rotation, incidence, azimuth, radial, indexing="ij")
    wi = spherical(theta, -turn)
    wo = around_mirror(wi, a, r)
    if through:  # about the straight direction instead of the mirrored one
        wo = wo * [1, 1, -1]
    notes = ["zeros are holes: below the horizon or not measured"]
    if symmetry == "planesymmetrical" and azimuth.max() <= np.pi + 1e-6:
        notes.append(
            "given for one side of the plane of incidence; the other side is its mirror image"
        )
    return [
        measurement(
            NAME,
            source.title,
            wi.reshape(-1, 3),
            wo.reshape(-1, 3),
            values.reshape(-1, len(channels)),
            hole=(values == 0).all(-1).reshape(-1),
            channels=channels,
            isotropic=len(rotation) == 1 and symmetry != "asymmetrical4d",
            part="transmission" if through else "reflection",
            notes=tuple(notes),
            metadata=_metadata(words, comments, scatter),
            grid={
                "rotation": len(rotation),
                "theta_i": len(incidence),
                "azimuth": len(azimuth),
                "radial": len(radial),
            },
        )
    ]


def _list(
    source: Source, lines: Iterator[tuple[int, str]], name: str, count: int, number: int
) -> list[float]:
    found: list[float] = []
    while len(found) < count:
        number, text = next(lines, (0, ""))
        if not text:
            raise source.error(f"ends inside its list {name}.")
        if not text.startswith("#"):
            found += source.numbers(text.split(), number)
    if len(found) > count:
        raise source.error(f"{name} has {len(found)} angles; {count} are announced.", number)
    source.finite(found, f"the angles of {name}")
    return found


def _data(source: Source, lines: Iterator[tuple[int, str]], count: int) -> tuple[Any, list[float]]:
    found: list[float] = []
    scatter: list[float] = []
    for number, text in lines:
        word = text.split(None, 1)[0].lower()
        if word == "dataend":
            break
        if word == "tis":
            scatter += source.numbers(text.split()[1:2], number)
        elif (not text.startswith("#") and not word.isalpha()) or word in {"nan", "inf"}:
            found += source.numbers(text.split(), number)
        if len(found) > count:
            raise source.error(f"has more than the {count} numbers that are announced.", number)
    if len(found) < count:
        raise source.error(f"is truncated: {count} numbers are announced, there are {len(found)}.")
    return np.array(found), scatter


def _metadata(words: dict[str, str], comments: list[str], scatter: list[float]) -> dict[str, str]:
    found = {k: v for k, v in words.items() if v}
    for comment in comments[:200]:
        key, colon, value = comment.partition(":")
        if colon and len(key) < 40 and value.strip():
            found.setdefault(key.strip(), value.strip()[:300])
    if scatter:
        found["total integrated scatter"] = ", ".join(f"{s:g}" for s in scatter[:50])
    return found
