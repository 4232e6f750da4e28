"""Named metals and their measured complex index of refraction eta + i k.

    gonio.model("torrance_sparrow", alpha=0.2, **metal("Au"))

Linear RGB comes from a table that `python tools/make_metals.py` makes with Mitsuba's own colour
conversion, so that it is what Mitsuba's `roughconductor` has in its rgb variants. For spectral variants
`spectra` gives the measurement itself.

Sources: the tables that Mitsuba 3 distributes (luxpop.com, and Palik, "Handbook of Optical Constants of
Solids", 1985); iron and titanium from Johnson and Christy, "Optical constants of transition metals", Phys.
Rev. B 9, 5056 (1974), in the transcription of refractiveindex.info (public domain).
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from gonio.messages import did_you_mean
from gonio.parts.metal_table import EQUAL_ENERGY, RGB

# What they are called, and which of Mitsuba's tables they come from.
MITSUBA = {
    "Ag": ("silver", "Ag"),
    "Al": ("aluminium", "Al"),
    "Au": ("gold", "Au"),
    "Be": ("beryllium", "Be"),
    "Cr": ("chromium", "Cr"),
    "Cu": ("copper", "Cu"),
    "Cu2O": ("cuprite", "Cu2O"),
    "CuO": ("tenorite", "CuO"),
    "Hg": ("mercury", "Hg"),
    "Ir": ("iridium", "Ir"),
    "Mo": ("molybdenum", "Mo"),
    "Nb": ("niobium", "Nb_palik"),
    "Ni": ("nickel", "Ni_palik"),
    "Rh": ("rhodium", "Rh"),
    "Ta": ("tantalum", "Ta"),
    "TiN": ("titanium nitride", "TiN"),
    "V": ("vanadium", "V_palik"),
    "W": ("tungsten", "W"),
}

# Those that Mitsuba does not have: wavelength in nm, eta, k.
# fmt: off
MEASURED = {
    "Fe": ("iron", (
        (354, 1.93, 2.35), (368, 2.02, 2.43), (381, 2.12, 2.50), (397, 2.24, 2.58), (413, 2.35, 2.65),
        (431, 2.48, 2.71), (451, 2.59, 2.77), (471, 2.67, 2.82), (496, 2.74, 2.88), (521, 2.86, 2.91),
        (549, 2.95, 2.93), (582, 2.94, 2.99), (617, 2.88, 3.05), (659, 2.92, 3.10), (704, 2.86, 3.19),
        (756, 2.87, 3.28), (821, 2.94, 3.39), (892, 2.96, 3.56),
    )),
    "Ti": ("titanium", (
        (354, 1.82, 2.87), (368, 1.90, 2.90), (381, 1.99, 2.93), (397, 2.08, 2.95), (413, 2.14, 2.98),
        (431, 2.21, 3.01), (451, 2.27, 3.04), (471, 2.32, 3.10), (496, 2.36, 3.19), (521, 2.44, 3.30),
        (549, 2.54, 3.43), (582, 2.60, 3.58), (617, 2.67, 3.72), (659, 2.76, 3.84), (704, 2.86, 3.96),
        (756, 3.00, 4.01), (821, 3.21, 4.01), (892, 3.29, 3.96),
    )),
}
# fmt: on


def metals() -> dict[str, str]:
    """All symbols, sorted, with their names in plain words."""
    names = {symbol: entry[0] for symbol, entry in MITSUBA.items()}
    names |= {symbol: entry[0] for symbol, entry in MEASURED.items()}
    return dict(sorted(names.items()))


def metal(symbol: str, *, neutral: bool = False) -> dict[str, tuple[float, float, float]]:
    """`eta` and `k` in linear RGB, ready to be passed to a model.

    Args:
        symbol: a key of `metals()`.
        neutral: Mitsuba's conversion turns a constant spectrum into the colour of equal-energy white,
            (1.20, 0.95, 0.91), which makes grey metals reddish. True divides by that colour.

    Raises:
        ValueError: an unknown symbol.
    """
    _require(symbol)
    white = EQUAL_ENERGY if neutral else (1.0, 1.0, 1.0)
    eta, k = (tuple(c / w for c, w in zip(part, white, strict=True)) for part in RGB[symbol])
    return {"eta": (eta[0], eta[1], eta[2]), "k": (k[0], k[1], k[2])}


def spectra(symbol: str) -> dict[str, dict[str, Any]]:
    """`eta` and `k` as Mitsuba spectra, for dicts that `mitsuba.load_dict` takes.

    Raises:
        ValueError: an unknown symbol.
    """
    _require(symbol)
    if symbol in MEASURED:
        rows = MEASURED[symbol][1]
        return {
            part: {"type": "spectrum", "value": [(float(row[0]), row[column]) for row in rows]}
            for part, column in (("eta", 1), ("k", 2))
        }
    files = spectrum_files(symbol)
    return {part: {"type": "spectrum", "filename": str(path)} for part, path in files.items()}


def spectrum_files(symbol: str) -> dict[str, Path]:
    """The files with the measured `eta` and `k`, of a metal that Mitsuba has."""
    import mitsuba

    folder = Path(mitsuba.__file__).parent / "data" / "ior"
    name = MITSUBA[symbol][1]
    return {"eta": folder / f"{name}.eta.spd", "k": folder / f"{name}.k.spd"}


def _require(symbol: str) -> None:
    known = metals()
    if symbol in known:
        return
    wanted = str(symbol).lower()
    named = [s for s, name in known.items() if wanted in (s.lower(), name)]
    did = did_you_mean(named[0] if named else str(symbol), known)
    raise ValueError(f"no metal {symbol!r}; {did}known are {', '.join(known)}.")
