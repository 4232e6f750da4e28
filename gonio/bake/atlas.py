"""F of many materials in one picture, a row for each, with 8 or 16 bits, and what that costs.

    atlas = gonio.bake.atlas.fresnel_atlas({"copper": metal("Cu"), "glass": {"eta": 1.5}}, bits=8)
    atlas.errors["copper"].largest
    atlas.write("atlas.png")

Source: Elek, "Layered materials in real-time rendering", CESCG 2010, section 3.1: 128 entries of 8 bits for
each material, hundreds of them in one texture.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gonio.bake.tables import (
    FRESNEL_ENTRIES,
    Table,
    TableError,
    check_index,
    fresnel_error,
    fresnel_table,
)
from gonio.images import BITS, codes_of, write_codes


@dataclass(frozen=True)
class Atlas:
    """Rows of F, as a texture holds them."""

    codes: NDArray[Any]
    """Shape (materials, entries, 3), whole numbers of the chosen bits; the largest one is 1."""
    names: tuple[str, ...]
    """Of the rows, from the top."""
    errors: Mapping[str, TableError]
    """How far each row, interpolated, is from its exact F."""

    @property
    def values(self) -> Table:
        """What a shader reads."""
        return np.asarray(self.codes / np.iinfo(self.codes.dtype).max, np.float32)

    def write(self, path: str | Path) -> None:
        """Write a .png with the atlas's bits.

        Raises:
            ValueError: another suffix.
            FileNotFoundError: the folder does not exist.
        """
        write_codes(path, self.codes)


def fresnel_atlas(
    materials: Mapping[str, Mapping[str, Any]], *, entries: int = FRESNEL_ENTRIES, bits: int = 8
) -> Atlas:
    """The exact F of some materials at evenly spaced cosines from 0 to 1, rounded to whole numbers.

    Args:
        materials: eta, and k of metals, by name; numbers or triples.
        entries: how many cosines, at least 2.
        bits: 8 or 16.

    Raises:
        ValueError: no material, an argument out of its range, or light from inside a dielectric.
    """
    if bits not in BITS:
        raise ValueError(f"bits={bits} is out of range; allowed are 8 and 16.")
    if not materials:
        raise ValueError("no material; name one, such as Cu or 1.5.")
    for index in materials.values():
        check_index(**index)
    rows, errors = [], {}
    for name, index in materials.items():
        table = np.broadcast_to(fresnel_table(**index, entries=entries), (entries, 3))
        codes = codes_of(table, bits)
        rows.append(codes)
        stored = np.asarray(codes / np.iinfo(codes.dtype).max, np.float32)
        errors[name] = fresnel_error(stored, **index)
    return Atlas(np.stack(rows), tuple(materials), errors)
