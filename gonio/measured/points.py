"""Loose points: what formats that list directions and values have in common."""

from __future__ import annotations

from array import array
from collections.abc import Sequence
from typing import Any

import numpy as np

from gonio.measured.frames import Floats, spherical
from gonio.measured.measurement import Measurement, measurement
from gonio.measured.source import MOST_NUMBERS, Source

# Azimuths may turn often, but no file means this.
MOST_TURNS = 1e4


class Rows:
    """Rows of numbers as they come out of a text, 8 bytes each."""

    def __init__(self, source: Source, width: int) -> None:
        """`width`: numbers in a row."""
        self.source, self.width, self.data = source, width, array("d")
        self.lines = array("q")

    def add(self, texts: Sequence[str], line: int) -> None:
        """Append a row.

        Raises:
            DataError: another width, no number, or too many.
        """
        if len(texts) != self.width:
            raise self.source.error(
                f"has {len(texts)} numbers; the rows of this file have {self.width}.", line
            )
        self.data.extend(self.source.numbers(texts, line))
        self.lines.append(line)
        if len(self.data) > MOST_NUMBERS // 4:
            raise self.source.error(f"has more than {MOST_NUMBERS // 4} numbers.", line)

    def table(self) -> Floats:
        """The rows (n, width).

        Raises:
            DataError: there is none.
        """
        if not self.data:
            raise self.source.error("has no data.")
        return np.frombuffer(self.data, np.float64).reshape(-1, self.width).copy()


def check_angles(
    source: Source, theta: Any, phi: Any, unit: float, lines: Sequence[int] | None = None
) -> None:
    """Raise unless angles to the normal are in [0, 180°] and azimuths are finite; (n, k) each.

    lines: of the file, where each row stands.
    """
    theta, phi = np.asarray(theta), np.asarray(phi)

    def line(wrong: Any) -> int | None:
        return lines[int(np.argmax(wrong.any(axis=-1)))] if lines is not None else None

    no_number = ~(np.isfinite(theta) & np.isfinite(phi))
    if no_number.any():
        raise source.error("has an angle that is no number.", line(no_number))
    below = np.abs(theta) * unit > np.pi + 1e-3
    if below.any():
        raise source.error(
            f"has an angle to the normal of {float(theta[below][0]):g}; at most "
            f"{np.pi / unit:g} makes sense.",
            line(below),
        )
    turned = np.abs(phi) * unit > MOST_TURNS * np.pi
    if turned.any():
        raise source.error(f"has an azimuth of {float(phi[turned][0]):g}.", line(turned))


def points(
    format: str,
    source: Source,
    angles: Any,
    values: Any,
    *,
    unit: float = 1.0,
    lines: Sequence[int] | None = None,
    **more: Any,
) -> Measurement:
    """A measurement from angles (n, 4), theta_i phi_i theta_o phi_o, and values (n, channels).

    Args:
        format: its name.
        source: the file.
        angles: theta_i, phi_i, theta_o, phi_o.
        values: in 1/sr.
        unit: radians in the file's unit of angle.
        lines: of the file, where each row stands; for errors.
        more: other fields of a measurement.

    Raises:
        DataError: angles that make no sense.
    """
    angles = np.asarray(angles, np.float64)
    check_angles(source, angles[:, 0::2], angles[:, 1::2], unit, lines)
    angles = angles * unit
    wi, wo = spherical(angles[:, 0], angles[:, 1]), spherical(angles[:, 2], angles[:, 3])
    if "isotropic" not in more:
        # One azimuth of the light says nothing about turning the sample
        more["isotropic"] = bool(np.ptp(np.round(angles[:, 1], 6)) < 1e-5)
    if "part" not in more and (wo[:, 2] < -1e-6).all():
        more["part"] = "transmission"
    return measurement(format, source.title, wi, wo, values, **more)
