"""Comma-separated text: theta_i, phi_i, theta_o, phi_o and values, named by the first line.

The names say the unit of angles: theta_i_deg or "theta_i (deg)", theta_i_rad or "theta_i [rad]"; without
one they are degrees. Values are r, g, b, or one of any name, or wavelengths such as 550 or 550nm. phi_i
may be missing: it is 0 then. In place of the angles there may be wi_x, wi_y, wi_z, wo_x, wo_y, wo_z. #
begins a comment.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from gonio.files import replacing
from gonio.measured.frames import angles as angles_of
from gonio.measured.measurement import Measurement, Reflectance, measurement
from gonio.measured.points import Rows, points
from gonio.measured.source import Source

NAME, SUFFIX = "CSV", ".csv"

ANGLES = ("theta_i", "phi_i", "theta_o", "phi_o")
VECTORS = ("wi_x", "wi_y", "wi_z", "wo_x", "wo_y", "wo_z")
OTHER_NAMES = {"theta_s": "theta_o", "phi_s": "phi_o", "theta_r": "theta_o", "phi_r": "phi_o"}

MOST_COLUMNS = 4096

# Directions that gonio writes of something that is a function everywhere: angles of the light and of the
# viewer, and azimuths between them.
WRITTEN = (19, 45, 72)

# Accepted departure of a direction's length from 1.
UNIT = 1e-2


def _header(line: str) -> list[tuple[str, str]] | None:
    """Name and unit of each column."""
    found = []
    cells = [cell.strip().strip("\"'") for cell in re.split(r"[,;\t]", line)]
    for cell in cells:
        match = re.fullmatch(
            r"([A-Za-z]\w*?)(?:[ _]*[\[(]?(deg|degrees|rad|radians|°)[\])]?)?", cell
        )
        name, unit = (match[1], match[2] or "") if match else (cell, "")
        lower = OTHER_NAMES.get(name.lower(), name.lower())
        found.append((lower if lower in (*ANGLES, *VECTORS) else cell, unit))
    return found if len(found) > 1 else None


def sniff(source: Source) -> bool:
    """By a first line with the names of the angles or vectors."""
    if b"\0" in source.head:
        return False
    for line in source.head.splitlines():
        text = line.decode("utf-8", "replace").removeprefix("\ufeff").strip()
        if text and not text.startswith("#"):
            names = {name for name, _ in _header(text) or []}
            return {"theta_i", "theta_o"} <= names or set(VECTORS) <= names
    return False


def read(source: Source) -> list[Measurement]:
    """The reflection, or transmission where wo is below the surface."""
    rows: Rows | None = None
    header: list[tuple[str, str]] = []
    comments: list[str] = []
    separator = ","
    for number, text in source.lines():
        if not text or text.startswith("#"):
            comments += [text.strip("# ")] if text and len(comments) < 50 else []
            continue
        if rows is None:
            header = _header(text) or []
            if not header or len(header) > MOST_COLUMNS:
                raise source.error(f"has a header of {len(header)} columns.", number)
            separator = next((s for s in (",", ";", "\t") if s in text), ",")
            rows = Rows(source, len(header))
            continue
        rows.add([cell.strip("\"' ") for cell in text.split(separator)], number)
    if rows is None:
        raise source.error("has no header.")
    names = [name for name, _ in header]
    repeated = {name for name in names if names.count(name) > 1}
    if repeated:
        raise source.error(f"has the column {sorted(repeated)[0]!r} twice.")
    table = rows.table()
    used = VECTORS if set(VECTORS) <= set(names) else ANGLES
    rest = [i for i, name in enumerate(names) if name not in used]
    if not rest:
        raise source.error("has no column of values beside the directions.")
    channels, wavelengths = _channels([names[i] for i in rest])
    more: dict[str, Any] = {
        "channels": channels,
        "wavelengths": wavelengths,
        "metadata": {"comment": " ".join(comments)[:500]} if comments else {},
    }
    if used is VECTORS:
        w = table[:, [names.index(n) for n in VECTORS]]
        return [_vectors(source, w, table[:, rest], rows.lines, more)]
    if "theta_o" not in names:
        raise source.error("has no column theta_o.")
    units = {unit for name, unit in header if name in ANGLES and unit}
    if len({unit[0] for unit in units} - {"°"} | ({"d"} if "°" in units else set())) > 1:
        raise source.error(f"mixes units of angles: {', '.join(sorted(units))}.")
    radians = any(unit.startswith("rad") for unit in units)
    angles = np.stack(
        [table[:, names.index(n)] if n in names else np.zeros(len(table)) for n in ANGLES], -1
    )
    if not units:
        more["notes"] = ("the header does not say the unit of angles: taken as degrees",)
    return [
        points(
            NAME,
            source,
            angles,
            table[:, rest],
            unit=1.0 if radians else np.pi / 180,
            lines=rows.lines,
            **more,
        )
    ]


def _vectors(
    source: Source, w: Any, values: Any, lines: Sequence[int], more: dict[str, Any]
) -> Measurement:
    source.finite(w, "the directions")
    found = []
    for start in (0, 3):
        length = np.linalg.norm(w[:, start : start + 3], axis=-1)
        wrong = np.abs(length - 1) > UNIT
        if wrong.any():
            row = int(np.argmax(wrong))
            raise source.error(
                f"has a direction of length {float(length[row]):g}; unit vectors are needed.",
                lines[row],
            )
        found.append(w[:, start : start + 3] / length[:, None])
    wi, wo = found
    if (wo[:, 2] < -1e-6).all():
        more["part"] = "transmission"
    phi = angles_of(wi)[1][angles_of(wi)[0] > 1e-4]
    more["isotropic"] = phi.size == 0 or bool(np.ptp(phi) < 1e-5)
    return measurement(NAME, source.title, wi, wo, values, **more)


def _channels(names: list[str]) -> tuple[tuple[str, ...], Any]:
    """The names of the values, and wavelengths if they are some."""
    lower = tuple(name.lower() for name in names)
    if lower in {("r", "g", "b"), ("red", "green", "blue")}:
        return ("r", "g", "b"), None
    spectrum = [re.fullmatch(r"(\d+(?:\.\d+)?) ?(?:nm)?", name) for name in lower]
    if all(spectrum):
        wavelengths = np.array([float(m[1]) for m in spectrum if m])
        if (wavelengths > 0).all() and (np.diff(wavelengths) > 0).all():
            return tuple(f"{w:g} nm" for w in wavelengths), wavelengths
    return ("value",) if len(names) == 1 else tuple(name[:40] for name in names), None


def write(path: str | Path, reflectance: Reflectance, **options: Any) -> list[str]:
    """Write the points of a measurement as they are, or a model at directions all over the hemisphere."""
    if isinstance(reflectance, Measurement):
        use = reflectance.valid
        wi, wo = reflectance.wi[use], reflectance.wo[use]
        values: Any = reflectance.values[use]
    else:
        wi, wo = directions(reflectance.isotropic)
        values = reflectance.evaluate(wi, wo)
    (theta_i, phi_i), (theta_o, phi_o) = angles_of(wi), angles_of(wo)
    columns = np.degrees(np.stack([theta_i, phi_i, theta_o, phi_o], -1))
    head = ",".join(["theta_i_deg", "phi_i_deg", "theta_o_deg", "phi_o_deg", *reflectance.channels])
    with replacing(path) as temporary, temporary.open("w", encoding="utf-8") as file:
        title = " ".join(reflectance.title.split())
        file.write(f"# {title}, BSDF in 1/sr without the cosine\n{head}\n")
        for start in range(0, len(columns), 1 << 14):
            part = slice(start, start + (1 << 14))
            np.savetxt(
                file, np.concatenate([columns[part], values[part]], -1), "%.7g", delimiter=","
            )
    return []


def directions(isotropic: bool) -> tuple[Any, Any]:
    """Directions all over the hemisphere, crowded around the mirror direction, (n, 3) each."""
    from gonio.measured.frames import from_half_difference

    n_d, n_h, n_p = WRITTEN
    theta_d = 0.5 * np.pi * (np.arange(n_d) + 0.5) / n_d
    theta_h = 0.5 * np.pi * ((np.arange(n_h) + 0.5) / n_h) ** 2
    phi_d = 2 * np.pi * (np.arange(n_p) + 0.5) / n_p
    phi_h = np.zeros(1) if isotropic else 2 * np.pi * np.arange(8) / 8
    a, b, c, d = (x.ravel() for x in np.meshgrid(theta_h, phi_h, theta_d, phi_d, indexing="ij"))
    wi, wo = from_half_difference(a, b, c, d)
    above = (wi[:, 2] > 1e-3) & (wo[:, 2] > 1e-3)
    wi, wo = wi[above], wo[above]
    if isotropic:  # the light at azimuth 0, as files of isotropic samples have it
        phi = angles_of(wi)[1]
        c, s = np.cos(phi), np.sin(phi)
        wi = np.stack([np.hypot(wi[:, 0], wi[:, 1]), 0 * phi, wi[:, 2]], -1)
        wo = np.stack([c * wo[:, 0] + s * wo[:, 1], c * wo[:, 1] - s * wo[:, 0], wo[:, 2]], -1)
    return wi, wo
