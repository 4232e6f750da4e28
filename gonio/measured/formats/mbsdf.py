"""NVIDIA's `.mbsdf` of the Material Definition Language: isotropic, over theta_i, theta_o and azimuth.

Source: the MDL SDK and its specification, section "Measured BSDF". Text "NVIDIA ARC MBSDF V1", lines
key="value", then one or two blocks MBSDF_DATA=, MBSDF_DATA_REFLECTION= or MBSDF_DATA_TRANSMISSION= with
uint32 type (0 scalar, 1 RGB), n_theta, n_phi and float32 [theta_i][theta_o][phi] (x 3). Angles are cut
into equal steps of [0, pi / 2] and [0, pi]; renderers look the numbers up as a texture, so each stands
for the middle of its step.
"""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import numpy as np

from gonio.files import replacing
from gonio.measured.frames import Floats, angles, spherical
from gonio.measured.grid import Grid
from gonio.measured.measurement import Mask, Measurement, Reflectance, measurement
from gonio.measured.source import LONGEST_LINE, Source

NAME, SUFFIX = "MDL mbsdf", ".mbsdf"

MAGIC = b"NVIDIA ARC MBSDF V1\n"
BLOCKS = {
    b"MBSDF_DATA=": "reflection",
    b"MBSDF_DATA_REFLECTION=": "reflection",
    b"MBSDF_DATA_TRANSMISSION=": "transmission",
}

# Lines of text before the data.
MOST_LINES = 1000

# What gonio writes: MDL's own files have 45 and 90, this resolves twice as much.
N_THETA, N_PHI = 90, 180


def sniff(source: Source) -> bool:
    """By its first line."""
    return source.head.replace(b"\r\n", b"\n").startswith(MAGIC)


def read(source: Source) -> list[Measurement]:
    """Reflection and transmission, whichever there are."""
    metadata: dict[str, str] = {}
    found: list[Measurement] = []
    place, lines = source.head.index(b"\n") + 1, 0
    while place < source.size:
        content = source.bytes(place, min(LONGEST_LINE, source.size - place))
        line, newline, _ = content.partition(b"\n")
        lines += 1
        if not newline:
            if line.strip(b"\0\r\n\t "):
                raise source.error(f"ends in {line[:40]!r}, which is neither a line nor data.")
            break
        if lines > MOST_LINES:
            raise source.error(f"has more than {MOST_LINES} lines before its data.")
        place += len(line) + 1
        line = line.strip()
        if line in BLOCKS:
            block, place = _block(source, place, BLOCKS[line], metadata)
            found.append(block)
        elif b"=" in line:
            key, _, value = line.decode("latin-1").partition("=")
            metadata[key.strip()[:80]] = value.strip().strip('"')[:1000]
        elif line:
            raise source.error(f"has the line {line[:40]!r}; key=value or a block was expected.")
    if not found:
        raise source.error(
            f"has no data; a block {' or '.join(b.decode() for b in BLOCKS)} is missing."
        )
    if len({m.part for m in found}) < len(found):
        raise source.error(f"has several blocks of {found[-1].part}.")
    return found


def _block(
    source: Source, place: int, part: str, metadata: dict[str, str]
) -> tuple[Measurement, int]:
    kind, n_theta, n_phi = source.unpack("<3I", place)
    if kind not in {0, 1} or n_theta == 0 or n_phi == 0:
        raise source.error(
            f"has a block of type {kind} with {n_theta} x {n_phi} angles; type 0 or 1 is read."
        )
    channels = ("r", "g", "b") if kind else ("value",)
    shape = (n_theta, n_theta, n_phi, len(channels))
    data = source.binary(place + 12, "<f4", shape)
    values = np.array(data, np.float32)
    theta, phi = _axes(n_theta, n_phi)
    wi = spherical(theta, 0.0).astype(np.float32)
    wo = spherical(theta[:, None], phi).astype(np.float32)
    if part == "transmission":
        wo[..., 2] *= -1
    found = measurement(
        NAME,
        source.title,
        np.repeat(wi, n_theta * n_phi, 0),
        np.tile(wo.reshape(-1, 3), (n_theta, 1)),
        values.reshape(-1, len(channels)),
        channels=channels,
        part=part,
        notes=("numbers stand for the middle of their steps of angle",),
        metadata=dict(metadata),
        grid={"theta_i": n_theta, "theta_o": n_theta, "phi": n_phi},
        interpolator=_Between(values),
    )
    return found, place + 12 + 4 * values.size


def _axes(n_theta: int, n_phi: int) -> tuple[Floats, Floats]:
    return (
        0.5 * np.pi * (np.arange(n_theta) + 0.5) / n_theta,
        np.pi * (np.arange(n_phi) + 0.5) / n_phi,
    )


class _Between:
    """Values between the numbers of the table."""

    def __init__(self, values: Any) -> None:
        self.grid = Grid(np.nan_to_num(values), np.isfinite(values).all(-1), (False, False, False))

    def __call__(self, wi: Floats, wo: Floats) -> tuple[Floats, Mask]:
        (theta_i, phi_i), (theta_o, phi_o) = angles(wi), angles(wo)
        theta_o = np.minimum(theta_o, np.pi - theta_o)  # transmission is told apart by its block
        n_theta, _, n_phi = self.grid.valid.shape
        apart = np.abs((phi_o - phi_i + np.pi) % (2 * np.pi) - np.pi)
        return self.grid(
            n_theta * theta_i / (0.5 * np.pi) - 0.5,
            n_theta * theta_o / (0.5 * np.pi) - 0.5,
            n_phi * apart / np.pi - 0.5,
        )


def write(path: str | Path, reflectance: Reflectance, **options: Any) -> list[str]:
    """Write the reflection, RGB or one value. Returns what was lost."""
    theta, phi = _axes(N_THETA, N_PHI)
    wo = spherical(theta[:, None], phi).reshape(-1, 3)
    scalar = len(reflectance.channels) == 1
    count = 1 if scalar else 3
    turns = [0.0] if reflectance.isotropic else [0.25 * np.pi * (k + 0.5) for k in range(8)]
    values = np.empty((N_THETA, N_THETA * N_PHI, count), "<f4")
    for row, t in enumerate(theta):
        total: Any = 0.0
        for turn in turns:
            c, s = np.cos(turn), np.sin(turn)
            about = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
            wi = np.broadcast_to(spherical(t, 0.0) @ about, wo.shape)
            total = total + reflectance.evaluate(wi, wo @ about)[:, :count]
        values[row] = total / len(turns)
    title = "".join(c if c.isprintable() and c != '"' else " " for c in reflectance.title)
    head = MAGIC + f'name="{title[:200]}"\n'.encode() + b"MBSDF_DATA_REFLECTION=\n"
    head += struct.pack("<3I", 0 if scalar else 1, N_THETA, N_PHI)
    with replacing(path) as temporary:
        temporary.write_bytes(head + values.tobytes())
    return [] if reflectance.isotropic else ["anisotropy: an average over eight azimuths"]
