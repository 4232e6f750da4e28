"""Fresnel terms and colours of shaders, in the ways people write them."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from gonio.foreign.expressions import Array

TINY = 1e-30

# So many colours at most are tried in pairs, one times the other.
PAIRED = 5


@dataclass(frozen=True)
class Cosines:
    """Of the directions that the code is called with, (n,) each."""

    i: Array
    o: Array
    h: Array
    d: Array
    v: Array


def schlick(c: Array, f0: Array, f90: Array | float = 1.0) -> Array:
    """Schlick's term."""
    return np.asarray(f0 + (f90 - f0) * (1 - np.clip(c, 0, 1)) ** 5)


def srgb_decoded(c: Array) -> Array:
    """Linear values of sRGB ones (IEC 61966-2-1)."""
    return np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)


def srgb_encoded(c: Array) -> Array:
    """sRGB values of linear ones."""
    return np.where(c <= 0.0031308, 12.92 * c, 1.055 * np.maximum(c, TINY) ** (1 / 2.4) - 0.055)


COLOURS: dict[str, tuple[Callable[[Array], Array], bool]] = {
    "{}": (lambda c: c, True),
    "{}, decoded from sRGB": (srgb_decoded, False),
    "{}, encoded to sRGB": (srgb_encoded, False),
    "{}^2.2": (lambda c: c**2.2, False),
    "{}^(1/2.2)": (lambda c: c ** (1 / 2.2), False),
    "{} squared": (lambda c: c * c, False),
}

# F0 of a number that artists set: Burley 2012; Lagarde and de Rousiers 2014, Sec. 3.1.2.
REMAPPED: dict[str, Callable[[Array], Array]] = {
    "0.08 {}": lambda c: 0.08 * c,
    "0.16 {}^2": lambda c: 0.16 * c * c,
}

# No material has an F0 below 0.02: where it is set lower, light is shut off, and Schlick's term fades at
# grazing angles as well (Lagarde and de Rousiers 2014), by one channel or as 50 * 0.33 of their sum.
FADED = {"saturate(50 F0)": 50.0, "saturate(dot(F0, 50 * 0.33))": 49.5}


# F0 at which that shows, and how near factors have to be.
DIM = (0.004, 0.018)
NEAR = 4e-3


def of_half(f0: str) -> str:
    """What Schlick's term is called, with F0 as it comes from a parameter."""
    return f"Schlick's Fresnel of V.H, F0 = {f0}"


def faded(c: Array, f0: Array, F: Array) -> str:
    """How F90 follows a small F0, from values of Schlick's term; empty if it is 1.

    Args:
        c: V.H at grazing angles, (n,).
        f0: in DIM.
        F: the term there.
    """
    away = (1 - c) ** 5
    f90 = (F - f0 * (1 - away)) / away
    if np.abs(np.median(f90) - 1) < 0.1:
        return ""
    middle = float(np.median(f90 / f0))
    for name, factor in FADED.items():
        if abs(middle / factor - 1) < NEAR:
            return f"F90 = {name}"
    return f"F90 = {middle:.3g} F0" if np.ptp(f90 / f0) < 0.05 * middle else "another F90"


def terms(c: Cosines, colours: dict[str, Array]) -> Iterator[tuple[str, Array, bool]]:
    """Name, F, and whether it is usual."""
    yield "no Fresnel term", np.ones_like(c.d), True
    gaussian = 2 ** ((-5.55473 * c.d - 6.98316) * c.d)  # Lagarde 2012
    fixed = np.full_like(c.d, 0.04)
    yield "Schlick's Fresnel, F0 = 0.04", schlick(c.d, fixed), True
    yield "1 - Schlick's Fresnel of V.H, F0 = 0.04", 1 - schlick(c.d, fixed), True
    yield (
        "Schlick's Fresnel with F0 and F90 exchanged, 0.04",
        schlick(c.d, np.ones_like(fixed), fixed),
        False,
    )
    for where, cosine in (("N.V", c.o), ("N.L", c.i), ("N.H", c.h)):
        yield (
            f"Schlick's Fresnel of {where} instead of V.H, F0 = 0.04",
            schlick(cosine, fixed),
            False,
        )
    for name, f0 in colours.items():
        for text, (turn, usual) in COLOURS.items():
            colour = turn(f0)
            shown = text.format(name)
            yield f"times {shown}", colour, usual
            if usual or "sRGB" in text or "2.2" in text:
                yield of_half(shown), schlick(c.d, colour), usual
        for text, remap in REMAPPED.items():
            colour = remap(f0)
            shown = of_half(text.format(name))
            yield shown, schlick(c.d, colour), True
            for end, factor in FADED.items():
                yield (
                    f"{shown}, F90 = {end}",
                    schlick(c.d, colour, np.minimum(factor * colour, 1)),
                    True,
                )
        yield f"1 - Schlick's Fresnel of V.H, F0 = {name}", 1 - schlick(c.d, f0), True
        exchanged = schlick(c.d, np.ones_like(f0), f0)
        yield f"Schlick's Fresnel with F0 and F90 exchanged, {name}", exchanged, False
        gauss = f0 + (1 - f0) * gaussian
        yield f"Schlick's Fresnel as a spherical Gaussian, F0 = {name}", gauss, True
        for where, cosine in (("N.V", c.o), ("N.L", c.i), ("N.H", c.h)):
            yield (
                f"Schlick's Fresnel of {where} instead of V.H, F0 = {name}",
                schlick(cosine, f0),
                False,
            )
    if len(colours) <= PAIRED:
        for (a, x), (b, y) in itertools.permutations(colours.items(), 2):
            yield f"times {a} (1 - {b})", x * (1 - y), True
            for how, away in (("of V.H", (1 - c.d) ** 5), ("as a spherical Gaussian", gaussian)):
                f90 = x + (y - x) * away
                yield f"Schlick's Fresnel {how}, F0 = {a}, F90 = {b}", f90, True
            yield f"times {a}; Schlick's Fresnel of V.H, F0 = {b}", x * schlick(c.d, y), True
            if a < b:
                yield f"times {a} {b}", x * y, True
