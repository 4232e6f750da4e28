"""pbrt-v2's `.brdf` text: wavelengths, then rows of angles with a value for each of them.

Source: pbrt-v2, materials/measured.cpp. Radians; wavelengths in nm; # begins a comment.
"""

from __future__ import annotations

from array import array

import numpy as np

from gonio.measured.measurement import Measurement
from gonio.measured.points import points
from gonio.measured.source import MOST_NUMBERS, Source

NAME, SUFFIX = "pbrt BRDF", ".brdf"

# pbrt's spectra; files have 3 to some hundreds.
MOST_WAVELENGTHS = 4096

# Wavelengths in nm that make sense, so that other tables of numbers are not taken for this format.
SHORTEST, LONGEST = 100.0, 30_000.0


def sniff(source: Source) -> bool:
    """By a first number that counts growing wavelengths."""
    if b"\0" in source.head:
        return False
    numbers: list[float] = []
    lines = source.head.splitlines()
    complete = source.size <= len(source.head)
    for line in lines if complete else lines[:-1]:
        text = line.split(b"#")[0].split()
        try:
            numbers += [float(t) for t in text]
        except ValueError:
            return False
    if not numbers or not 1 <= numbers[0] <= MOST_WAVELENGTHS or numbers[0] % 1:
        return False
    found = np.array(numbers[1 : 1 + int(numbers[0])])
    return bool(
        found.size
        and (found >= SHORTEST).all()
        and (found <= LONGEST).all()
        and (np.diff(found) > 0).all()
    )


def read(source: Source) -> list[Measurement]:
    """The reflection."""
    data = array("d")
    for number, text in source.lines():
        data.extend(source.numbers(text.partition("#")[0].split(), number))
        if len(data) > MOST_NUMBERS // 4:
            raise source.error(f"has more than {MOST_NUMBERS // 4} numbers.", number)
    numbers = np.frombuffer(data, np.float64)
    count = int(numbers[0])
    width = 4 + count
    body = numbers[1 + count :]
    if body.size == 0 or body.size % width:
        raise source.error(
            f"has {body.size} numbers after its {count} wavelengths; rows have {width}. It is truncated."
        )
    wavelengths = source.finite(numbers[1 : 1 + count].copy(), "the wavelengths")
    table = body.reshape(-1, width)
    return [
        points(
            NAME,
            source,
            table[:, :4],
            table[:, 4:],
            channels=tuple(f"{w:g} nm" for w in wavelengths),
            wavelengths=wavelengths,
            isotropic=True,
            notes=("pbrt takes these files as isotropic",),
        )
    ]
