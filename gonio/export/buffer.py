"""Tables of an export: where they lie in the buffer that its host binds, and how each language reads them.

All tables of a text lie behind each other in one buffer, an entry in four float32: a colour in x, y, z, a
number in x, as `gonio.export.manifest.loader` has parameters. The buffer ends with a whole line of WIDTH
entries, so that the same bytes are a texture of four channels that is WIDTH texels wide, for languages
without buffers. Entries are read as they are; what lies between them is the model's own code.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
import numpy.typing as npt

from gonio.export.tree import ExportError, Function
from gonio.table import Table

# Entries in a line: the width of a texture that every graphics interface has.
WIDTH = 2048

# What the file's name ends with, after the prefix of the text.
FILE = "{prefix}_tables.bin"

# How the buffer is declared. Bindings up to 7 are left to the pictures of lit exports.
RESOURCES: Mapping[str, str] = MappingProxyType(
    {
        "glsl": "layout(std430, binding = 8) readonly buffer {type} {{ vec4 {name}[]; }};",
        "essl": "uniform highp sampler2D {name};",
        "hlsl": "StructuredBuffer<float4> {name} : register(t8);",
        "slang": "StructuredBuffer<float4> {name};",
        "wgsl": "@group(1) @binding(8) var<storage, read> {name}: array<vec4f>;",
        "msl": "device const float4* {name};",
        "cpp": "const float* {name};  // four for each entry",
        "cuda": "const float* {name};  // four for each entry",
    }
)

# The same for programs: the group (or descriptor set) and the binding.
BINDINGS: Mapping[str, tuple[int, int]] = MappingProxyType(
    {"glsl": (0, 8), "spirv": (0, 8), "wgsl": (1, 8)}
)

# Reads an entry: {place} is its number, {first} that of its table's first.
_PLACES: Mapping[str, str] = {
    "wgsl": "i32(index + 0.5) + {first}",
    "cpp": "int(index + 0.5f) + {first}",
    "cuda": "int(index + 0.5f) + {first}",
}
_PLACE = "int(index + 0.5) + {first}"
_BODIES: Mapping[str, tuple[str, ...]] = {
    "essl": (
        "int place = {place};",
        f"return texelFetch({{name}}, ivec2(place % {WIDTH}, place / {WIDTH}), 0).{{part}};",
    ),
    "cpp": ("const float* entry = {name} + 4 * ({place});", "return {value};"),
    "cuda": ("const float* entry = {name} + 4 * ({place});", "return {value};"),
}
_BODY = ("return {name}[{place}].{part};",)


@dataclass(frozen=True)
class Placed:
    """A table, and where it lies."""

    table: Table
    lookup: str
    """What the text calls the function that reads it."""
    first: int
    """The number of its first entry."""


@dataclass(frozen=True)
class Buffer:
    """All tables of a text, behind each other."""

    prefix: str
    placed: tuple[Placed, ...]

    @property
    def file(self) -> str:
        """The name of the file that has them."""
        return FILE.format(prefix=self.prefix)

    @property
    def entries(self) -> int:
        """How many vectors the buffer has, whole lines of them."""
        last = self.placed[-1]
        return -(-(last.first + last.table.count) // WIDTH) * WIDTH

    def rows(self) -> npt.NDArray[np.float32]:
        """The buffer, shape (entries, 4)."""
        found = np.zeros((self.entries, 4), np.float32)
        for place in self.placed:
            width = 3 if place.table.colours else 1
            rows = slice(place.first, place.first + place.table.count)
            found[rows, :width] = place.table.values.reshape(-1, width)
        return found

    def content(self) -> bytes:
        """The buffer as a file has it: little endian, whatever the machine."""
        return self.rows().astype("<f4").tobytes()

    def described(self, reading: Sequence[str]) -> dict[str, Any]:
        """The same for a manifest, with the functions that read tables."""
        return {
            "name": f"{self.prefix}_tables",
            "file": self.file,
            "format": "float32, little endian, four for each entry",
            "entries": self.entries,
            "width": WIDTH,
            "read_by": list(reading),
            "tables": [
                {
                    "lookup": place.lookup,
                    "doc": place.table.doc,
                    "components": 3 if place.table.colours else 1,
                    "shape": list(place.table.shape),
                    "first": place.first,
                    "count": place.table.count,
                }
                for place in self.placed
            ],
        }


def placed(functions: Iterable[Function], prefix: str) -> Buffer | None:
    """A buffer for the tables that some functions read; None if there are none."""
    found: list[Placed] = []
    first = 0
    for function in functions:
        if function.table is not None:
            found.append(Placed(function.table, function.name, first))
            first += function.table.count
    return Buffer(prefix, tuple(found)) if found else None


def check(buffer: Buffer | None, language: str, title: str) -> None:
    """Refuse tables in a language that cannot read them."""
    if buffer is not None and language not in RESOURCES:
        raise ExportError(
            f"{buffer.placed[0].lookup} is a table, and {title} reads none but pictures, filtered; name "
            f"another language ({', '.join(RESOURCES)}), or export a model fitted to it: gonio fit."
        )


def check_unread(buffer: Buffer | None, who: str) -> None:
    """Refuse tables where nobody binds them."""
    if buffer is not None:
        raise ExportError(
            f"{buffer.prefix} reads tables from a buffer, which {who} does not bind; "
            "gonio render shows it, gonio export --prove runs it."
        )


def resource(language: str, prefix: str, name: str) -> str:
    """The declaration of the buffer, under this name."""
    kind = "".join(part.capitalize() for part in f"{prefix}_tables".split("_"))
    return RESOURCES[language].format(name=name, type=f"{kind}Buffer")


def body(language: str, name: str, place: Placed, vector: str) -> list[str]:
    """The statements that read an entry; `vector` is C++'s type of colours."""
    colours = place.table.colours
    words = {
        "name": name,
        "place": _PLACES.get(language, _PLACE).format(first=place.first).removesuffix(" + 0"),
        "part": "xyz" if colours else "x",
        "value": f"{vector}{{entry[0], entry[1], entry[2]}}" if colours else "entry[0]",
    }
    return [line.format(**words) for line in _BODIES.get(language, _BODY)]
