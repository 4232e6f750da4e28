"""STL, triangles without anything else: binary, and ASCII.

Binary files may begin with the word "solid" as well; what tells is that their length is the one that
their count of triangles asks for. Facet normals are passed over: they say nothing that the order of the
corners does not, and many programs write zeros.
"""

from __future__ import annotations

import re
import struct

import numpy as np

from gonio.render.triangles import Floats, Triangles

_HEADER, _COUNT = 80, 4
_ROW = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_ASCII = re.compile(rb"\s*solid\b.*?\bfacet\s", re.IGNORECASE | re.DOTALL)
_LOOP = re.compile(rb"\bouter\s+loop\b(.*?)\bendloop\b", re.IGNORECASE | re.DOTALL)


def read_stl(data: bytes) -> Triangles:
    """The triangles of an STL file; corners at the same place are one vertex.

    Raises:
        ValueError: less data than its count promises, or no numbers where corners belong.
    """
    text = data.removeprefix(b"\xef\xbb\xbf")
    corners = _ascii(text) if _is_ascii(text) else _binary(data)
    places, faces = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    return Triangles(places, faces.reshape(-1, 3).astype(np.int64))


def _is_ascii(data: bytes) -> bool:
    if len(data) >= _HEADER + _COUNT and len(data) == _promised(data):
        return False
    return _ASCII.match(data[:4096]) is not None


def _promised(data: bytes) -> int:
    """The length that a binary file's count of triangles asks for."""
    (count,) = struct.unpack_from("<I", data, _HEADER)
    return _HEADER + _COUNT + int(count) * _ROW.itemsize


def _binary(data: bytes) -> Floats:
    """Corners (F, 3, 3)."""
    if len(data) < _HEADER + _COUNT:
        raise ValueError("it is neither a binary nor an ASCII STL file, or cut short")
    if len(data) < _promised(data):
        raise ValueError(f"it is cut short: {len(data)} bytes of {_promised(data)}")
    if len(data) - _promised(data) >= _ROW.itemsize:
        there = (len(data) - _HEADER - _COUNT) // _ROW.itemsize
        raise ValueError(f"its count is wrong: there are data for {there} triangles")
    rows = np.frombuffer(data[_HEADER + _COUNT : _promised(data)], _ROW)
    return np.asarray(rows["corners"], np.float64)


def _ascii(data: bytes) -> Floats:
    """Corners (F, 3, 3)."""
    # The solid's name may be anything, so that only what stands inside of loops is looked at.
    loops = _LOOP.findall(data)
    if data.lower().count(b"endloop") < len(re.findall(rb"(?i)\bouter\s+loop\b", data)):
        raise ValueError("it is cut short: a facet does not end")
    words = [loop.split() for loop in loops]
    for number, corners in enumerate(words, 1):
        if len(corners) != 12 or {w.lower() for w in corners[::4]} != {b"vertex"}:
            raise ValueError(f"its facet {number} does not have three corners of three numbers")
    numbers = [w for corners in words for k, w in enumerate(corners) if k % 4]
    try:
        flat = np.array(numbers, dtype="S").astype(np.float64) if numbers else np.zeros(0)
    except ValueError:
        raise ValueError("it has something else where a number belongs") from None
    return np.asarray(flat.reshape(-1, 3, 3))
