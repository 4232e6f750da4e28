"""PLY, the Stanford polygon format: ASCII, and binary of either byte order.

Read are positions, normals (nx, ny, nz), uvs of vertices (under the four names that programs give
them) or of corners (`texcoord`, as MeshLab writes it), polygons of any size and triangle strips.
Other elements and properties are passed over.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from gonio.render.meshes.polygons import MISSING, Polygons
from gonio.render.triangles import Floats, Ints

_TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4",
    "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4",
    "float": "f4", "double": "f8", "float32": "f4", "float64": "f8", "int64": "i8", "uint64": "u8",
}  # fmt: skip
_UV_NAMES = (("s", "t"), ("u", "v"), ("texture_u", "texture_v"), ("tex_u", "tex_v"))
_FORMATS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}


@dataclass
class _Property:
    name: str
    kind: str
    count_kind: str | None = None  # of a list


@dataclass
class _Element:
    name: str
    count: int
    properties: list[_Property] = field(default_factory=list)


@dataclass
class _List:
    """A list property: `sizes` of each row, and all values behind each other."""

    sizes: Ints
    values: Floats | Ints


def read_ply(data: bytes) -> Polygons:
    """The polygons of a PLY file.

    Raises:
        ValueError: no PLY, or less data than its header promises.
    """
    order, elements, body = _header(data)
    found: dict[str, dict[str, Any]] = {}
    reader: _Ascii | _Binary = _Binary(body, order) if order else _Ascii(body)
    for element in elements:
        columns = reader.element(element)
        found.setdefault(element.name, columns)
    vertex = found.get("vertex", {})
    if not {"x", "y", "z"} <= set(vertex):
        raise ValueError("its vertices have no x, y and z")

    def columns_of(names: tuple[str, ...]) -> Floats | None:
        if not set(names) <= set(vertex):
            return None
        return np.stack([np.asarray(vertex[n], np.float64) for n in names], axis=-1)

    positions = columns_of(("x", "y", "z"))
    assert positions is not None
    normals = columns_of(("nx", "ny", "nz"))
    uvs = next((c for names in _UV_NAMES if (c := columns_of(names)) is not None), None)
    face = found.get("face", {})
    index = next((face[n] for n in ("vertex_indices", "vertex_index") if n in face), None)
    if isinstance(index, _List):
        sizes, corners = index.sizes, np.asarray(index.values, np.int64)
    else:
        sizes, corners = _strips(found.get("tristrips", {}))
    corner_uvs = None if uvs is None else corners
    wedge = face.get("texcoord")
    if isinstance(wedge, _List) and isinstance(index, _List):
        uvs, corner_uvs = _wedges(wedge, sizes)
    return Polygons(
        positions,
        sizes,
        corners,
        uvs,
        corner_uvs,
        normals,
        None if normals is None else corners,
    )


def _header(data: bytes) -> tuple[str, list[_Element], bytes]:
    """Byte order ("" for ASCII), the elements, and what follows the header."""
    data = data.removeprefix(b"\xef\xbb\xbf")
    first = re.match(rb"ply[ \t]*(\r?\n|\r)", data)
    # A line of its own: comments may speak of it. Where lines end in a lone carriage return, a line feed
    # behind the last one belongs to the data.
    end = rb"\r" if first and first[1] == b"\r" else rb"\r?\n"
    last = re.search(rb"(?<=[\r\n])[ \t]*end_header[ \t]*" + end, data)
    if first is None or last is None:
        raise ValueError("its header is not that of a PLY file, or cut short")
    order: str | None = None
    elements: list[_Element] = []
    for raw in data[: last.start()].decode("latin-1").splitlines()[1:]:
        words = raw.split()
        if not words or words[0] in ("comment", "obj_info"):
            continue
        try:
            if words[0] == "format":
                order = _FORMATS[words[1]]
            elif words[0] == "element":
                elements.append(_Element(words[1], int(words[2])))
                if elements[-1].count < 0:
                    raise ValueError
            elif words[0] == "property" and words[1] == "list":
                kind = _Property(words[4], _TYPES[words[3]], _TYPES[words[2]])
                elements[-1].properties.append(kind)
            elif words[0] == "property":
                elements[-1].properties.append(_Property(words[2], _TYPES[words[1]]))
            else:
                raise ValueError
        except (KeyError, IndexError, ValueError):
            raise ValueError(f"its header has the line {raw[:60]!r}, which is not PLY") from None
    if order is None:
        raise ValueError("its header has no line 'format'")
    return order, elements, data[last.end() :]


class _Ascii:
    """Elements of an ASCII file, one number after the other; line ends have no meaning."""

    def __init__(self, body: bytes) -> None:
        self.words = body.split()
        self.place = 0

    def take(self, count: int) -> Floats:
        words = self.words[self.place : self.place + count]
        if len(words) < count:
            raise ValueError("it is cut short: it has less numbers than its header promises")
        self.place += count
        try:
            return (
                np.asarray(np.array(words, dtype="S").astype(np.float64)) if words else np.zeros(0)
            )
        except ValueError:
            raise ValueError(
                f"it has something else where a number belongs, near {words[:4]}"
            ) from None

    def element(self, element: _Element) -> dict[str, Any]:
        properties, count = element.properties, element.count
        width = len(properties)
        if not any(p.count_kind for p in properties):
            table = self.take(count * width).reshape(count, width)
            return {p.name: table[:, k] for k, p in enumerate(properties)}
        scalars: dict[str, list[float]] = {p.name: [] for p in properties if not p.count_kind}
        sizes: dict[str, list[int]] = {p.name: [] for p in properties if p.count_kind}
        pieces: dict[str, list[list[bytes]]] = {name: [] for name in sizes}
        words, place = self.words, self.place
        try:
            for _ in range(count):
                for p in properties:
                    if p.count_kind:
                        size = int(words[place])
                        if size < 0 or place + 1 + size > len(words):
                            raise IndexError
                        sizes[p.name].append(size)
                        pieces[p.name].append(words[place + 1 : place + 1 + size])
                        place += 1 + size
                    else:
                        scalars[p.name].append(float(words[place]))
                        place += 1
        except IndexError:
            raise ValueError(
                "it is cut short: it has less numbers than its header promises"
            ) from None
        except ValueError:
            raise ValueError(f"it has {words[place][:20]!r} where a number belongs") from None
        self.place = place
        result: dict[str, Any] = {name: np.array(v, np.float64) for name, v in scalars.items()}
        for name, lengths in sizes.items():
            flat = [word for piece in pieces[name] for word in piece]
            try:
                values = np.array(flat, dtype="S").astype(np.float64) if flat else np.zeros(0)
            except ValueError:
                raise ValueError(f"the list {name} has something that is no number") from None
            result[name] = _List(np.array(lengths, np.int64), values)
        return result


class _Binary:
    """Elements of a binary file."""

    def __init__(self, body: bytes, order: str) -> None:
        self.body = body
        self.order = order
        self.place = 0

    def element(self, element: _Element) -> dict[str, Any]:
        if not any(p.count_kind for p in element.properties):
            kinds = [(f"f{k}", self.order + p.kind) for k, p in enumerate(element.properties)]
            table = self._rows(np.dtype(kinds), element.count)
            return {p.name: table[f"f{k}"] for k, p in enumerate(element.properties)}
        return self._equal_lists(element) or self._any_lists(element)

    def _rows(self, kind: Any, count: int) -> Any:
        if len(self.body) - self.place < count * kind.itemsize:
            raise ValueError("it is cut short: it has less data than its header promises")
        table = np.frombuffer(self.body, kind, count, self.place)
        self.place += count * kind.itemsize
        return table

    def _equal_lists(self, element: _Element) -> dict[str, Any] | None:
        """All rows at once where every list is as long as in the first row; None else."""
        kinds: list[Any] = []
        place = self.place
        for k, p in enumerate(element.properties):
            if p.count_kind:
                counter = np.dtype(self.order + p.count_kind)
                if element.count == 0 or len(self.body) < place + counter.itemsize:
                    return None
                size = int(np.frombuffer(self.body, counter, 1, place)[0])
                if size < 0 or size > len(self.body):
                    return None
                kinds += [(f"n{k}", counter), (f"f{k}", self.order + p.kind, (size,))]
            else:
                kinds.append((f"f{k}", self.order + p.kind))
            place = self.place + np.dtype(kinds).itemsize
        kind = np.dtype(kinds)
        if len(self.body) - self.place < element.count * kind.itemsize:
            return None
        table = np.frombuffer(self.body, kind, element.count, self.place)
        result: dict[str, Any] = {}
        for k, p in enumerate(element.properties):
            values = table[f"f{k}"]
            if p.count_kind:
                if (table[f"n{k}"] != values.shape[1]).any():
                    return None
                sizes = np.full(element.count, values.shape[1], np.int64)
                result[p.name] = _List(sizes, values.reshape(-1))
            else:
                result[p.name] = values
        self.place += element.count * kind.itemsize
        return result

    def _any_lists(self, element: _Element) -> dict[str, Any]:
        scalars: dict[str, list[Any]] = {p.name: [] for p in element.properties if not p.count_kind}
        sizes: dict[str, list[int]] = {p.name: [] for p in element.properties if p.count_kind}
        pieces: dict[str, list[Any]] = {name: [] for name in sizes}
        kinds = {p.name: np.dtype(self.order + p.kind) for p in element.properties}
        for _ in range(element.count):
            for p in element.properties:
                if p.count_kind:
                    size = int(self._rows(np.dtype(self.order + p.count_kind), 1)[0])
                    if size < 0:
                        raise ValueError(f"a list {p.name} has the length {size}")
                    sizes[p.name].append(size)
                    pieces[p.name].append(self._rows(kinds[p.name], size))
                else:
                    scalars[p.name].append(self._rows(kinds[p.name], 1)[0])
        result: dict[str, Any] = {name: np.array(values) for name, values in scalars.items()}
        for name, lengths in sizes.items():
            flat = np.concatenate(pieces[name]) if pieces[name] else np.zeros(0)
            result[name] = _List(np.array(lengths, np.int64), flat)
        return result


def _strips(columns: dict[str, Any]) -> tuple[Ints, Ints]:
    """The triangles of strips, which -1 separates; every second one is turned over."""
    strips = columns.get("vertex_indices", columns.get("vertex_index"))
    if not isinstance(strips, _List):
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    values = np.asarray(strips.values, np.int64)
    # Rows of the element are separate strips, as if -1 stood between them.
    values = np.insert(values, np.cumsum(strips.sizes), -1)
    triangles = np.stack([values[:-2], values[1:-1], values[2:]], axis=-1)
    first = np.concatenate([[0], np.flatnonzero(values == -1) + 1])
    place = np.arange(len(triangles))
    odd = (place - first[np.searchsorted(first, place, side="right") - 1]) % 2 == 1
    triangles[odd] = triangles[odd][:, [1, 0, 2]]
    a, b, c = triangles.T
    triangles = triangles[(triangles >= 0).all(axis=1) & (a != b) & (b != c) & (a != c)]
    return np.full(len(triangles), 3, np.int64), triangles.reshape(-1)


def _wedges(wedge: _List, sizes: Ints) -> tuple[Floats, Ints]:
    """uvs of the corners; a face whose list is not two numbers per corner has none."""
    values = np.asarray(wedge.values, np.float64)
    values = np.append(values, 0.0) if len(values) % 2 else values
    starts = np.concatenate([[0], np.cumsum(wedge.sizes)[:-1]])
    good = wedge.sizes == 2 * sizes
    within = np.arange(int(sizes.sum())) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    pair = np.repeat(starts, sizes) + 2 * within
    fits = np.repeat(good, sizes)
    pair = np.where(fits, pair, 0)
    if not fits.any():
        return np.zeros((0, 2)), np.full(len(pair), MISSING)
    flat = np.stack([values[pair], values[pair + 1]], axis=-1)
    return flat, np.where(fits, np.arange(len(pair)), MISSING)
