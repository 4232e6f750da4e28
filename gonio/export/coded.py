"""Tables of F and D, as pictures and arrays in a text hold them: whole numbers of 8 or 16 bits.

Which functions they stand for, and what an export looks up, is in `gonio.export.tabled`. A model's own
tables are float32 in a buffer: `gonio.table`, `gonio.export.buffer`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gonio.export.tree import ExportError
from gonio.images import BITS
from gonio.messages import did_you_mean

if TYPE_CHECKING:
    from gonio.model import Model

Array = NDArray[np.float64]

FRESNEL, DISTRIBUTION = "fresnel", "distribution"
KINDS = (FRESNEL, DISTRIBUTION)

# Cosines of a row of F, evenly spaced from 0 to 1 (Elek, section 3.1).
COSINES = 128

# Sines and widths of D; and the most that are an array in a shader, whose compiler copies it: for proofs.
PLACES = 512
ARRAY_PLACES = 32


@dataclass(frozen=True)
class Request:
    """Which functions become tables, and how these are stored."""

    kinds: tuple[str, ...]
    """Of KINDS."""
    bits: int = 16
    varying: frozenset[str] = frozenset()
    """Paths of parameters that textures or the mesh give, which no table can know."""
    places: int = PLACES
    """Sines, and widths, of D."""
    materials: tuple[tuple[str, Model], ...] = ()
    """Those that a model with a row chooses among, by name (`gonio.export.by_row`); none of others."""

    def __post_init__(self) -> None:
        """Refuse what there is not."""
        for kind in self.kinds:
            if kind not in KINDS:
                did = did_you_mean(kind, KINDS)
                raise ExportError(f"no table {kind!r}; {did}there are {', '.join(KINDS)}.")
        if self.bits not in BITS:
            raise ExportError(f"bits={self.bits} is out of range; allowed are 8 and 16.")


@dataclass(frozen=True)
class CodedTable:
    """What a texture holds, and by how much it is off."""

    kind: str
    """Of KINDS."""
    codes: NDArray[Any]
    """Whole numbers of the chosen bits, the largest one is 1: (rows, cosines, 3) or (rows, sines)."""
    rows: tuple[str, ...]
    """What each row of F stands for; of D each block of as many rows as there are sines."""
    errors: tuple[float, ...]
    """Largest error of each, interpolated: of F itself; of D over its peak."""

    @property
    def bits(self) -> int:
        """Of a number."""
        return 8 * self.codes.dtype.itemsize

    @property
    def most(self) -> int:
        """The code of 1."""
        return int(np.iinfo(self.codes.dtype).max)

    @property
    def starts(self) -> list[int]:
        """The first row of each."""
        step = 1 if self.kind == FRESNEL else self.codes.shape[1]
        return [step * i for i in range(len(self.rows))]

    def meaning(self) -> list[str]:
        """What the rows are, for the text of a shader."""
        return [f"    row {row}: {name}" for row, name in zip(self.starts, self.rows, strict=True)]

    def said(self) -> list[str]:
        """Each row with its error, for people."""
        what = "" if self.kind == FRESNEL else " of its peak"
        return [
            f"{self.kind} row {row}, {name}: off by at most {error:.2g}{what}, {self.bits} bits"
            for row, name, error in zip(self.starts, self.rows, self.errors, strict=True)
        ]

    def look_up(self, place: Array, row: Array) -> Array:
        """Linear between entries, as a shader reads it; of F `place` is the cosine, of D it is u.

        In the precision of the place, whose digits within the table count.
        """
        place = np.asarray(place)
        values = self.codes.astype(place.dtype) / place.dtype.type(self.most)
        last = values.shape[1] - 1
        at = np.clip(np.nan_to_num(place), 0, 1) * place.dtype.type(last)
        left = np.minimum(at.astype(int), last - 1)
        row = np.clip(np.nan_to_num(np.asarray(row, place.dtype)), 0, len(values) - 1)
        top = np.minimum(row.astype(int), max(len(values) - 2, 0))
        left, top, at, row = np.broadcast_arrays(left, top, at, row)
        s, t = (at - left).astype(place.dtype), (row - top).astype(place.dtype)
        if values.ndim == 3:
            s, t = s[:, None], t[:, None]
        below = np.minimum(top + 1, len(values) - 1)
        upper = (1 - s) * values[top, left] + s * values[top, left + 1]
        lower = (1 - s) * values[below, left] + s * values[below, left + 1]
        return np.asarray((1 - t) * upper + t * lower)


@dataclass
class Tables:
    """The tables of an export."""

    request: Request
    prefix: str
    """Of what the models of the text share, by which the files are called."""
    fresnel: CodedTable | None = None
    distribution: CodedTable | None = None
    fixed: frozenset[str] = frozenset()
    """Paths of the parameters whose values are in F's rows; other values would need other rows."""
    left: tuple[str, ...] = ()
    """Functions that stayed, as their index changes from point to point, or depends on directions."""

    @property
    def all(self) -> tuple[CodedTable, ...]:
        """Those that there are."""
        return tuple(t for t in (self.fresnel, self.distribution) if t is not None)

    def files(self) -> dict[str, CodedTable]:
        """The tables by the names of their pictures."""
        return {picture_file(self.prefix, t): t for t in self.all}

    def external(self) -> dict[str, Any]:
        """The lookups, for `Machine`."""
        return {f"{t.kind}_table": t.look_up for t in self.all}


def picture_file(prefix: str, table: CodedTable) -> str:
    """The name of the picture that holds a table."""
    return f"{prefix}_{table.kind}.png"
