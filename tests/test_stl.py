"""STL files, binary and ASCII, however programs write them."""

import struct
from pathlib import Path

import numpy as np
import pytest

from gonio.render.user_mesh import load_mesh

TRIANGLES = [
    [(-1, 0, 0), (1, 0, 0), (1, 2, 0)],
    [(-1, 0, 0), (1, 2, 0), (-1, 2, 0)],
]  # a square of side 2, seen from +z

BINARY = b"made here".ljust(80) + struct.pack("<I", len(TRIANGLES))
for corners in TRIANGLES:
    BINARY += struct.pack("<12fH", 0, 0, 0, *sum(corners, ()), 0)

ASCII = "solid a part\n"
for corners in TRIANGLES:
    ASCII += "facet normal 0 0 1\nouter loop\n"
    ASCII += "".join(f"vertex {x} {y} {z}\n" for x, y, z in corners) + "endloop\nendfacet\n"
ASCII += "endsolid a part\n"


def stl(tmp_path: Path, data: str | bytes) -> Path:
    path = tmp_path / "m.stl"
    path.write_bytes(data if isinstance(data, bytes) else data.encode())
    return path


@pytest.mark.parametrize(
    "data",
    [
        BINARY,
        b"solid facet outer loop".ljust(80) + BINARY[80:],  # the word does not make it ASCII
        BINARY.replace(b"made here", b"COLOR=\x10 a"),
        BINARY[:-2] + b"\xff\x8f",  # a colour in the attribute
        BINARY + b"\0" * 17,
        ASCII,
        ASCII.upper(),
        ASCII.replace("\n", "\r\n"),
        ASCII.replace("\n", "\n\t "),
        "\ufeff" + ASCII,
        ASCII.replace(" a part", ""),
        ASCII.replace(" a part", " facet vertex 1 endsolid"),
        ASCII.encode().replace(b"a part", b"pi\xe8ce"),
        ASCII.replace("endsolid a part\n", ""),
        ASCII.replace("vertex 1 ", "vertex 1.0E+00 ").replace("normal 0 0 1", "normal nan -0 0"),
        ASCII[: len(ASCII) // 2].rpartition("facet")[0].rpartition("end")[0]
        + "endfacet\nendsolid\nsolid two\n"
        + ASCII[ASCII.rindex("facet normal") :],
    ],
)
def test_a_square_is_the_same_however_stl_writes_it(tmp_path: Path, data: str | bytes) -> None:
    mesh = load_mesh(stl(tmp_path, data))
    a, b, c = (mesh.positions[mesh.faces[:, k]] for k in range(3))
    np.testing.assert_allclose(np.cross(b - a, c - a), [[0, 0, 4]] * 2)
    assert (
        len(mesh.positions) == 4
    )  # corners at one place are one vertex, so that normals are smooth


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (BINARY[:-20], "cut short: 164 bytes of 184"),
        (BINARY[:60], "neither a binary nor an ASCII STL"),
        (BINARY[:80] + struct.pack("<I", 1) + BINARY[84:], "its count is wrong.*2 triangles"),
        (ASCII[: ASCII.rindex("endloop")], "cut short: a facet does not end"),
        (ASCII.replace("vertex 1 2 0\n", "", 1), "facet 1 does not have three corners"),
        (ASCII.replace("vertex 1 2", "vertex one 2", 1), "where a number belongs"),
        (ASCII.replace("vertex 1 2", "vertex nan 2", 1), "NaN or infinite"),
        ("solid empty\nendsolid empty\n" + " " * 100, "no triangles|cut short"),
    ],
)
def test_what_is_wrong_with_an_stl_is_one_line(tmp_path: Path, data, message: str) -> None:
    with pytest.raises(ValueError, match=message) as error:
        load_mesh(stl(tmp_path, data))
    assert "m.stl" in str(error.value)
