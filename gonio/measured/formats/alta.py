"""ALTA's text and binary data: `.alta`, `.dat`, in any of its parametrisations.

Source: Belcour, Barla, Pacanowski, "ALTA: A BRDF Analysis Library", 2014, and its documentation. A
header of lines #DIM nx ny, #PARAM_IN, #PARAM_OUT, #VS (0 no errors, 1 a half width, 2 both ends), then
rows of nx + ny numbers (and 1 or 2 more for each value); or with #FORMAT binary doubles. Radians; V is
the viewer, L the light.
"""

from __future__ import annotations

import sys
from array import array
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from gonio.files import replacing
from gonio.measured.formats import csv as table_of_points
from gonio.measured.frames import Floats, angles, from_half_difference, spherical
from gonio.measured.measurement import Measurement, Reflectance, measurement
from gonio.measured.source import MOST_NUMBERS, Source

NAME, SUFFIX = "ALTA", ".alta"

# Lines of the header, and values per direction.
MOST_LINES, MOST_VALUES = 200, 4096

Pair = tuple[Floats, Floats]
"""V and L, (n, 3) each."""


def _polar(x: Any, y: Any) -> Floats:
    """A direction from theta cos(phi) and theta sin(phi)."""
    return spherical(np.hypot(x, y), np.arctan2(y, x))


def _from_cosine(x: Floats) -> Floats:
    return np.asarray(np.arccos(np.clip(x, -1, 1)))


def _rusinkiewicz(h: Any, p: Any, d: Any, q: Any) -> Pair:
    wi, wo = from_half_difference(h, p, d, q)
    return wi, wo  # ALTA turns V, where others turn L; values are reciprocal


def _up(x: Any) -> Floats:
    return np.broadcast_to(np.array([0.0, 0.0, 1.0]), (len(x), 3))


def _elevated(x: Any, y: Any) -> Floats:
    """A unit vector from its part in the surface."""
    return np.stack([x, y, np.sqrt(np.maximum(1 - x * x - y * y, 0))], -1)


def _retro(light: Floats, x: Floats, y: Floats) -> Pair:
    L = spherical(light, 0.0)
    # The angle from L, in the plane that is turned from the plane of incidence by the azimuth
    along = spherical(np.asarray(light) + 0.5 * np.pi, 0.0)
    t, p = np.hypot(x, y)[:, None], np.arctan2(y, x)[:, None]
    across = np.broadcast_to(np.array([0.0, 1.0, 0.0]), L.shape)
    # Towards the normal for positive x, as cos(theta_v) = cos l cos t + cos p sin l sin t has it
    return np.cos(t) * L + np.sin(t) * (-np.cos(p) * along + np.sin(p) * across), L


def _back(light: Floats, x: Floats, y: Floats) -> Pair:
    """V is the mirror of the reflected light at the back vector K."""
    L = spherical(light, 0.0)
    K = _polar(x, y)
    R = L * np.array([-1.0, -1.0, 1.0])
    V = 2 * np.sum(R * K, -1, keepdims=True) * K - R
    return V, L


def _stark(h: Floats, b: Floats, phi: Any) -> Pair:
    """Half sums H and half differences B, at right angles to each other."""
    H = np.stack([h, 0 * h, np.sqrt(np.maximum(1 - h * h - b * b, 0))], -1)
    c, s = np.cos(phi), np.sin(phi)
    polar = np.arctan2(H[:, 2], -h * c)
    B = b[:, None] * np.stack([np.sin(polar) * c, np.sin(polar) * s, np.cos(polar)], -1)
    return _unit(H - B), _unit(H + B)


def _unit(w: Floats) -> Floats:
    length = np.linalg.norm(w, axis=-1, keepdims=True)
    return np.asarray(w / np.where(length > 0, length, 1))


def _neumann(h: Floats, b: Floats, phi: Any) -> Pair:
    x, y = b * np.cos(phi), b * np.sin(phi)
    return _elevated(h + x, y), _elevated(h - x, -y)


def _stereographic(x: Floats, y: Floats) -> Floats:
    n = x * x + y * y
    return np.stack([2 * x, 2 * y, 1 - n], -1) / (1 + n)[:, None]


PARAMETRISATIONS: dict[str, tuple[int, Callable[..., Pair]]] = {
    "COS_TH": (1, lambda c: _rusinkiewicz(_from_cosine(c), 0 * c, 0 * c, 0 * c)),
    "COS_TK": (
        1,
        lambda c: (
            spherical(0.5 * np.pi - _from_cosine(c), np.pi),
            spherical(0.5 * np.pi - _from_cosine(c), 0.0),
        ),
    ),
    "COS_TLV": (1, lambda c: (spherical(_from_cosine(c), 0.0), _up(c))),
    "COS_TLR": (1, lambda c: (spherical(_from_cosine(c), np.pi), _up(c))),
    "COS_TH_TD": (2, lambda h, d: _rusinkiewicz(_from_cosine(h), 0 * h, _from_cosine(d), 0 * h)),
    "RUSIN_TH_TD": (2, lambda h, d: _rusinkiewicz(h, 0 * h, d, 0 * h + 0.5 * np.pi)),
    "ISOTROPIC_TV_PROJ_DPHI": (2, lambda x, y: (_polar(x, y), _up(x))),
    "STARK_2D": (2, lambda h, b: _stark(h, b, 0.5 * np.pi)),
    "NEUMANN_2D": (2, lambda h, b: _neumann(h, b, 0.5 * np.pi)),
    "RUSIN_TH_PH_TD": (3, lambda h, p, d: _rusinkiewicz(h, p, d, 0 * h)),
    "RUSIN_TH_TD_PD": (3, lambda h, d, q: _rusinkiewicz(h, 0 * h, d, q)),
    "RUSIN_VH": (3, lambda x, y, z: _rusinkiewicz(_from_cosine(z), np.arctan2(y, x), 0 * x, 0 * x)),
    "ISOTROPIC_TV_TL_DPHI": (3, lambda v, i, p: (spherical(v, p), spherical(i, 0.0))),
    "ISOTROPIC_TL_TV_PROJ_DPHI": (3, lambda i, x, y: (_polar(x, y), spherical(i, 0.0))),
    "SCHLICK_TL_TK_PROJ_DPHI": (3, _back),
    "RETRO_TL_TVL_PROJ_DPHI": (3, _retro),
    "STARK_3D": (3, _stark),
    "NEUMANN_3D": (3, _neumann),
    "RUSIN_TH_PH_TD_PD": (4, _rusinkiewicz),
    "SPHERICAL_TL_PL_TV_PV": (4, lambda i, p, v, q: (spherical(v, q), spherical(i, p))),
    "STEREOGRAPHIC": (4, lambda a, b, c, d: (_stereographic(a, b), _stereographic(c, d))),
    "CARTESIAN": (6, lambda a, b, c, d, e, f: (np.stack([a, b, c], -1), np.stack([d, e, f], -1))),
}
"""Dimensions, and V and L from the numbers."""

OUTPUTS = ("INV_STERADIAN", "INV_STERADIAN_COSINE_FACTOR", "RGB_COLOR", "XYZ_COLOR", "ENERGY")

# Those that say nothing about turning the sample.
ANISOTROPIC = ("RUSIN_TH_PH_TD_PD", "SPHERICAL_TL_PL_TV_PV", "STEREOGRAPHIC", "CARTESIAN")


def sniff(source: Source) -> bool:
    """By the words of its header."""
    lines = source.head.splitlines()[:MOST_LINES]
    words = {line.split(None, 1)[0] for line in lines if line.startswith(b"#") and line.split()}
    return b"#ALTA_BEGIN_HEADER" in words or {b"#DIM", b"#PARAM_IN"} <= words


def _header(source: Source) -> tuple[dict[str, str], int]:
    """The words, and where the data begin."""
    words: dict[str, str] = {}
    place, lines = 0, source.head.split(b"\n")
    for line in lines[:-1] if source.size > len(source.head) else lines:
        text = line.decode("latin-1").strip()
        if text and not text.startswith("#"):
            break
        place += len(line) + 1
        key, _, value = text[1:].partition(" ")
        if key.strip() in {"ALTA_END_HEADER", "BEGIN_STREAM"}:
            break
        if key.isupper() or key.replace("_", "").isupper():
            words[key.strip()] = value.strip().strip('"')[:300]
        if words.get("FORMAT") == "binary" and len(words) > MOST_LINES:
            break
    if place > source.size:
        place = source.size
    return words, place


def read(source: Source) -> list[Measurement]:
    """The reflection."""
    words, place = _header(source)
    dims = words.get("DIM", "").split()
    if len(dims) != 2:
        raise source.error("has no line #DIM with two numbers, of directions and of values.")
    nx = source.count(dims[0], 0, "the first number of #DIM", 6)
    ny = source.count(dims[1], 0, "the second number of #DIM", MOST_VALUES)
    name = words.get("PARAM_IN", "")
    if name not in PARAMETRISATIONS:
        raise source.error(
            f"its #PARAM_IN is {name[:40]!r}; known are {', '.join(PARAMETRISATIONS)}."
        )
    dimensions, convert = PARAMETRISATIONS[name]
    if dimensions != nx:
        raise source.error(f"{name} has {dimensions} numbers; #DIM says {nx}.")
    kind = words.get("PARAM_OUT", "INV_STERADIAN")
    if kind not in OUTPUTS:
        raise source.error(f"its #PARAM_OUT is {kind[:40]!r}; known are {', '.join(OUTPUTS)}.")
    announced = words.get("VS", "0")
    if announced not in {"0", "1", "2"}:
        raise source.error(f"its #VS is {announced[:40]!r}; 0, 1 and 2 are read.")
    errors = int(announced)
    binary = words.get("FORMAT", "text") == "binary"
    table, precision = (_binary if binary else _text)(source, words, place, nx, ny, errors)
    source.finite(table[:, :nx], "the directions")
    if np.abs(table[:, :nx]).max() > 1e3:
        raise source.error("has an angle above 1000 radians.")
    V, L = convert(*table[:, :nx].T)
    length = np.linalg.norm(V, axis=-1), np.linalg.norm(L, axis=-1)
    if any((np.abs(n - 1) > 1e-2).any() for n in length):
        raise source.error("has a direction that is no unit vector.")
    values = table[:, nx : nx + ny]
    notes = []
    if kind == "INV_STERADIAN_COSINE_FACTOR":
        # In the horizon what is left is a hole anyway
        values = values / np.maximum(np.abs(V[:, 2:]), 1e-6)
        notes.append("values were divided by cos(theta_v), with which the file has weighted them")
    elif kind == "ENERGY":
        notes.append("the file calls its values energy; they are taken as BRDFs")
    if name in {"COS_TH", "COS_TK", "COS_TLV", "COS_TLR", "RUSIN_VH"}:
        notes.append(f"{name} is a slice: the other angles are those that ALTA takes")
    known = {"RGB_COLOR": ("r", "g", "b"), "XYZ_COLOR": ("X", "Y", "Z")}.get(kind)
    channels: tuple[str, ...] = known or ()
    if len(channels) != ny:
        channels = ("value",) if ny == 1 else tuple(f"value {i + 1}" for i in range(ny))
    return [
        measurement(
            NAME,
            source.title,
            _unit(L),
            _unit(V),
            values,
            precision=precision,
            channels=channels,
            isotropic=name not in ANISOTROPIC,
            units="1/sr times cos(theta_v)" if kind.endswith("FACTOR") else "1/sr",
            notes=tuple(notes),
            metadata=words,
        )
    ]


def _text(
    source: Source, words: dict[str, str], place: int, nx: int, ny: int, errors: int
) -> tuple[Floats, Floats | None]:
    data, spread = array("d"), array("d")
    for number, text in source.lines():
        if not text or text.startswith("#"):
            continue
        parts = text.split()
        if len(parts) < nx + ny:
            raise source.error(f"has {len(parts)} numbers; rows have {nx + ny}.", number)
        row = source.numbers(parts, number)
        data.extend(row[: nx + ny])
        if errors:  # ALTA reads those of the first value
            rest = row[nx + ny :]
            if len(rest) < errors:
                raise source.error(f"has no error bars, which #VS {errors} announces.", number)
            spread.append(rest[0] if errors == 1 else 0.5 * (rest[1] - rest[0]))
        if len(data) > MOST_NUMBERS // 4:
            raise source.error(f"has more than {MOST_NUMBERS // 4} numbers.", number)
    if not data:
        raise source.error("has no data.")
    table = np.frombuffer(data, np.float64).reshape(-1, nx + ny)
    return table, _precision(np.frombuffer(spread, np.float64)) if errors else None


def _precision(spread: Floats) -> Floats:
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        return np.asarray(np.where(spread > 0, 1 / spread**2, 0.0))


def _binary(
    source: Source, words: dict[str, str], place: int, nx: int, ny: int, errors: int
) -> tuple[Floats, Floats | None]:
    if words.get("PRECISION", "ieee754-double") != "ieee754-double":
        raise source.error(f"its numbers are {words['PRECISION'][:40]}; ieee754-double is read.")
    endian = words.get("ENDIAN", "little")
    if endian not in {"little", "big"}:
        raise source.error(f"its byte order is {endian[:40]!r}; little and big are read.")
    count = source.count(words.get("SAMPLE_COUNT", ""), 0, "#SAMPLE_COUNT")
    width = nx + ny + ny * errors
    dtype = "<f8" if endian == "little" else ">f8"
    data = np.array(source.binary(place, dtype, (count, width)), np.float64)
    spread = None
    if errors == 1:
        spread = _precision(data[:, nx + ny])
    elif errors == 2:
        spread = _precision(0.5 * (data[:, nx + 2 * ny] - data[:, nx + ny]))
    return data[:, : nx + ny], spread


def write(
    path: str | Path, reflectance: Reflectance, *, binary: bool = False, **options: Any
) -> list[str]:
    """Write text, or doubles if `binary`, as SPHERICAL_TL_PL_TV_PV or ISOTROPIC_TV_TL_DPHI."""
    if isinstance(reflectance, Measurement):
        use = reflectance.valid
        wi, wo = reflectance.wi[use], reflectance.wo[use]
        values: Any = reflectance.values[use]
    else:
        wi, wo = table_of_points.directions(reflectance.isotropic)
        values = reflectance.evaluate(wi, wo)
    (theta_i, phi_i), (theta_o, phi_o) = angles(wi), angles(wo)
    if reflectance.isotropic:
        name = "ISOTROPIC_TV_TL_DPHI"
        columns = np.stack([theta_o, theta_i, (phi_o - phi_i) % (2 * np.pi)], -1)
    else:
        name = "SPHERICAL_TL_PL_TV_PV"
        columns = np.stack([theta_i, phi_i, theta_o, phi_o], -1)
    count = values.shape[1]
    kinds = {("r", "g", "b"): "RGB_COLOR", ("X", "Y", "Z"): "XYZ_COLOR"}
    kind = next((k for names, k in kinds.items() if names == reflectance.channels), "INV_STERADIAN")
    head = [f"#DIM {columns.shape[1]} {count}", f"#PARAM_IN {name}", f"#PARAM_OUT {kind}", "#VS 0"]
    table = np.concatenate([columns, values], -1)
    with replacing(path) as temporary, temporary.open("wb") as file:
        if binary:
            head += ["#FORMAT binary", "#VERSION 0", "#PRECISION ieee754-double"]
            head += [f"#SAMPLE_COUNT {len(table)}", f"#ENDIAN {sys.byteorder}"]
        lines = ["#ALTA_BEGIN_HEADER", *head, "#ALTA_END_HEADER", ""]
        file.write("\n".join(lines).encode())
        if binary:
            file.write(table.astype("=f8").tobytes())
        else:
            for start in range(0, len(table), 1 << 14):
                np.savetxt(file, table[start : start + (1 << 14)], "%.9g")
    return []
