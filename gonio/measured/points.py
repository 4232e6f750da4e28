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


def check_angles(source: Source, theta: Any, phi: Any, unit: float) -> None:
    """Raise unless angles to the normal are in [0, 180°] and azimuths are finite."""
    theta, phi = np.asarray(theta), np.asarray(phi)
    if not (np.isfinite(theta).all() and np.isfinite(phi).all()):
        raise source.error("has an angle that is no number.")
    if (np.abs(theta) * unit > np.pi + 1e-3).any():
        raise source.error(
            f"has an angle to the normal of {float(np.abs(theta).max()):g}; at most "
            f"{np.pi / unit:g} makes sense."
        )
    if (np.abs(phi) * unit > MOST_TURNS * np.pi).any():
        raise source.error(f"has an azimuth of {float(np.abs(phi).max()):g}.")


def points(
    format: str,
    source: Source,
    angles: Any,
    values: Any,
    *,
    unit: float = 1.0,
    **more: Any,
) -> Measurement:
    """A measurement from angles (n, 4), theta_i phi_i theta_o phi_o, and values (n, channels).

    Args:
        format: its name.
        source: the file.
        angles: theta_i, phi_i, theta_o, phi_o.
        values: in 1/sr.
        unit: radians in the file's unit of angle.
        more: other fields of a measurement.

    Raises:
        DataError: angles that make no sense.
    """
    angles = np.asarray(angles, np.float64)
    check_angles(source, angles[:, 0::2], angles[:, 1::2], unit)
    angles = angles * unit
    wi, wo = spherical(angles[:, 0], angles[:, 1]), spherical(angles[:, 2], angles[:, 3])
    if "isotropic" not in more:
        # One azimuth of the light says nothing about turning the sample
        more["isotropic"] = bool(np.ptp(np.round(angles[:, 1], 6)) < 1e-5)
    if "part" not in more and (wo[:, 2] < -1e-6).all():
        more["part"] = "transmission"
    return measurement(format, source.title, wi, wo, values, **more)
