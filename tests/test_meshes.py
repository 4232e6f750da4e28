"""Mesh files: the same surface whatever the format and its liberties, or one clear line."""

import base64
import json
import struct
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.tolerances import DOUBLE_DIVIDED, SINGLE, SINGLE_LONG

from gonio.messages import Notice
from gonio.render.meshes.polygons import corner_triangles
from gonio.render.meshes.uvs import projected
from gonio.render.user_mesh import MESH_RADIUS, load_mesh, on_stage, with_normals

# A square of side 2 in the plane z = 0, whose picture stands upright: v runs up from the lower edge.
CORNERS = [(-1, 0, 0), (1, 0, 0), (1, 2, 0), (-1, 2, 0)]
UVS = [(0, 0), (1, 0), (1, 1), (0, 1)]
SQUARE_OBJ = (
    "".join(f"v {x} {y} {z}\n" for x, y, z in CORNERS)
    + "".join(f"vt {u} {v}\n" for u, v in UVS)
    + "f 1/1 2/2 3/3 4/4\n"
)


def obj(tmp_path: Path, text: str | bytes, name: str = "m.obj") -> Path:
    path = tmp_path / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def area(path: Path) -> float:
    return float(load_mesh(path).face_areas().sum())


def corner_uvs(path: Path) -> set[tuple[float, ...]]:
    mesh = load_mesh(path)
    assert mesh.uvs is not None
    rows = np.concatenate([mesh.positions, mesh.uvs], axis=1)[mesh.faces.reshape(-1)]
    return {tuple(np.round(row, 5).tolist()) for row in rows}


UPRIGHT = {(*map(float, p), float(u), 1.0 - v) for p, (u, v) in zip(CORNERS, UVS, strict=True)}

# ------------------------------------------------------------------------------------------- OBJ


@pytest.mark.parametrize(
    "change",
    [
        lambda t: t.replace("f 1/1 2/2", "f 1/1 \\\n2/2"),
        lambda t: t.replace("f 1/1 2/2", "f 1/1 \\\r\n  2/2"),
        lambda t: t.replace("f 1/1 2/2", "f 1/1 \\  \n2/2"),  # blanks behind the backslash
        lambda t: t.replace("f 1/1 2/2", "f 1/1 \\ # a comment\n2/2"),
        lambda t: t.rstrip("\n") + " \\",
        lambda t: "# made of C:\\models\\\n" + t,  # no continuation: the next line is a vertex
        lambda t: "mtllib C:\\models\\\no a\\\n" + t,
        lambda t: t.replace("\n", "\r\n"),
        lambda t: t.replace("\n", "\r"),
        lambda t: t.replace("\n", "\n\t  "),
        lambda t: t.replace(" ", "\t"),
        lambda t: t.replace("\n", " # a comment\n"),
        lambda t: "\ufeff" + t,
        lambda t: t.rstrip("\n"),
        lambda t: t.replace("v -1 0 0", "v -1 0 0 1.0 0.5 0.25"),  # a colour
        lambda t: t.replace("vt 1 1", "vt 1 1 0"),
        lambda t: t.replace("f 1/1 2/2 3/3 4/4", "f -4/-4 -3/-3 -2/-2 -1/-1"),
        lambda t: t.replace("f 1/1 2/2 3/3 4/4", "f 1/1 2/2 3/3\nf 1/1 3/3 4/4"),
        lambda t: t.replace("f 1/1 2/2 3/3 4/4", "f 1/1/ 2/2/ 3/3/ 4/4/"),
        lambda t: t.replace("v 1 2 0", "v 1.0e+0 2.E0 0"),
        lambda t: t + "l 1 2\np 1\ng name\ns off\nusemtl none\n" + "# " + "x" * 100_000 + "\n",
        lambda t: t.replace("f 1/1 2/2 3/3 4/4", "f 1/1/7 2/2/7 3/3/7 4/4/7"),  # no vn in the file
    ],
)
def test_a_square_is_the_same_however_obj_writes_it(tmp_path: Path, change) -> None:
    path = obj(tmp_path, change(SQUARE_OBJ))
    assert area(path) == pytest.approx(4)
    assert corner_uvs(path) == UPRIGHT


def test_a_continued_line_keeps_the_numbers_of_those_that_follow(tmp_path: Path) -> None:
    path = obj(tmp_path, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 \\\n2 \\\n3\nf 1 2 9\n")
    with pytest.raises(ValueError, match="line 7: a face has a vertex that is not there"):
        load_mesh(path)


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("f 1 2 0", "line 4: an index is 0; OBJ counts from 1"),
        ("f 1 2 -4", "line 4: a face has a vertex that is not there"),
        ("vt 0 0\nf 1/1 2/2 3/1", "line 5: a face has a texture coordinate that is not there"),
        ("v 1,5 0 0", "line 4: could not read 'v 1,5 0 0'"),
        ("f 1/1/1/1 2 3", "line 4: could not read the corner '1/1/1/1'"),
        ("f 1 2 99999999999999999999999", "line 4: could not read the corner|is not there"),
    ],
)
def test_a_bad_line_is_named(tmp_path: Path, line: str, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        load_mesh(obj(tmp_path, f"v 0 0 0\nv 1 0 0\nv 0 1 0\n{line}\n"))


def test_corners_without_uv_or_normal_get_defined_values(tmp_path: Path) -> None:
    text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt .2 .2\nvt .8 .2\nvt .2 .8\nvn 0 0 2\nvn 0 0 0\n"
    mesh = load_mesh(obj(tmp_path, text + "f 1/1/1 2/2/1 3/3/2\nf 2 4 3\n"))
    assert mesh.uvs is not None
    np.testing.assert_allclose(mesh.uvs[mesh.faces[0]], [[0.2, 0.8], [0.8, 0.8], [0.2, 0.2]])
    np.testing.assert_array_equal(mesh.uvs[mesh.faces[1]], 0)
    np.testing.assert_allclose(with_normals(mesh).normals, [[0, 0, 1]] * len(mesh.positions))


# -------------------------------------------------------------------------------------- polygons


def shoelace(xy: np.ndarray) -> float:
    x, y = xy.T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


def star(radii: list[float]) -> np.ndarray:
    angle = 2 * np.pi * np.arange(len(radii)) / len(radii)
    return np.asarray(radii)[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)


@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.floats(0.1, 3.0), min_size=4, max_size=24),
    st.integers(0, 23),
    st.floats(-3.0, 3.0),
    st.floats(-3.0, 3.0),
)
def test_star_shaped_polygons_keep_their_area_from_any_first_corner(radii, first, a, b) -> None:
    """The area is the shoelace formula's, and no triangle is turned over: their areas add up."""
    flat = np.roll(star(radii), first % len(radii), axis=0)
    turn = np.linalg.qr(np.array([[1.0, a, b], [0.5, 1, a], [b, 0, 1]]) + 4 * np.eye(3))[0]
    points = np.pad(flat, ((0, 0), (0, 1))) @ turn.T + [1e3, -2e3, 5e2]
    corners = np.arange(len(points))
    triangles = corner_triangles(points, np.array([len(points)]), corners)
    p, q, r = (points[triangles[:, k]] for k in range(3))
    areas = np.cross(q - p, r - p) / 2
    assert len(triangles) == len(points) - 2
    wanted = shoelace(flat)
    # 1e-6: the plane is found from coordinates of a few thousand in double precision
    assert np.linalg.norm(areas.sum(axis=0)) == pytest.approx(abs(wanted), rel=1e-6)
    assert np.linalg.norm(areas, axis=1).sum() == pytest.approx(abs(wanted), rel=SINGLE)


@pytest.mark.parametrize("first", range(5))
def test_a_concave_polygon_keeps_its_area_in_obj_and_ply(tmp_path: Path, first: int) -> None:
    points = [(0, 0, 0), (2, 0, 0), (2, 2, 0), (1, 0.2, 0), (0, 2, 0)]
    order = [(first + k) % 5 for k in range(5)]
    wanted = shoelace(np.array(points)[:, :2])
    assert wanted == pytest.approx(2.2)
    rows = "".join(f"v {x} {y} {z}\n" for x, y, z in points)
    face = " ".join(str(k + 1) for k in order)
    assert area(obj(tmp_path, f"{rows}f {face}\n")) == pytest.approx(wanted)
    for order_name in ("ascii", "binary_little_endian", "binary_big_endian"):
        path = tmp_path / "m.ply"
        path.write_bytes(ply(order_name, points, [order]))
        assert area(path) == pytest.approx(wanted)


def test_concave_quads_are_cut_along_the_right_diagonal(tmp_path: Path) -> None:
    arrow = [(0, 0, 0), (2, 2, 0), (0, 1, 0), (-2, 2, 0)]  # shoelace: 2
    for first in range(4):
        order = " ".join(str((first + k) % 4 + 1) for k in range(4))
        text = "".join(f"v {x} {y} {z}\n" for x, y, z in arrow) + f"f {order}\n"
        assert area(obj(tmp_path, text)) == pytest.approx(2)


# ------------------------------------------------------------------------------------------- PLY


def ply(order, positions, faces, uvs=None, names=("s", "t"), kind="float", wedge=False):
    """A PLY file; faces of any size, uvs at vertices or (wedge) at corners."""
    lines = ["ply", f"format {order} 1.0", "comment made here", f"element vertex {len(positions)}"]
    lines += [f"property {kind} {n}" for n in "xyz"]
    if uvs is not None and not wedge:
        lines += [f"property float {n}" for n in names]
    lines += [f"element face {len(faces)}", "property list uchar int vertex_indices"]
    if wedge:
        lines += ["property list uchar float texcoord", "property int texnumber"]
    header = "\n".join([*lines, "end_header"]) + "\n"
    end = ">" if "big" in order else "<"
    letter = "d" if kind == "double" else "f"
    ascii_rows, data = [], b""
    for n, p in enumerate(positions):
        uv = () if uvs is None or wedge else uvs[n]
        ascii_rows.append(" ".join(repr(float(x)) for x in (*p, *uv)))
        data += struct.pack(f"{end}3{letter}{len(uv)}f", *p, *uv)
    for face in faces:
        ascii_row = [len(face), *face]
        data += struct.pack(f"{end}B{len(face)}i", len(face), *face)
        if wedge:
            flat = [x for k in face for x in uvs[k]]
            ascii_row += [len(flat), *flat, 0]
            data += struct.pack(f"{end}B{len(flat)}fi", len(flat), *flat, 0)
        ascii_rows.append(" ".join(map(str, ascii_row)))
    return header.encode() + ("\n".join(ascii_rows).encode() + b"\n" if order == "ascii" else data)


@pytest.mark.parametrize("order", ["ascii", "binary_little_endian", "binary_big_endian"])
@pytest.mark.parametrize("faces", [[[0, 1, 2, 3]], [[0, 1, 2], [0, 2, 3]]])
@pytest.mark.parametrize("wedge", [False, True])
def test_a_square_is_the_same_however_ply_writes_it(tmp_path: Path, order, faces, wedge) -> None:
    path = tmp_path / "m.ply"
    path.write_bytes(ply(order, CORNERS, faces, UVS, wedge=wedge))
    assert area(path) == pytest.approx(4)
    assert corner_uvs(path) == UPRIGHT


@pytest.mark.parametrize("names", [("s", "t"), ("u", "v"), ("texture_u", "texture_v")])
def test_ply_finds_uvs_under_the_names_that_programs_use(tmp_path: Path, names) -> None:
    path = tmp_path / "m.ply"
    path.write_bytes(ply("ascii", CORNERS, [[0, 1, 2, 3]], UVS, names))
    assert corner_uvs(path) == UPRIGHT


@pytest.mark.parametrize("order", ["ascii", "binary_little_endian"])
def test_polygons_of_all_sizes_may_be_mixed_in_ply(tmp_path: Path, order: str) -> None:
    path = tmp_path / "m.ply"
    five = [*CORNERS, (0, 3, 0)]
    path.write_bytes(ply(order, five, [[0, 1, 2, 3], [3, 2, 4], [0, 1], [0, 1, 2, 4, 3]]))
    assert area(path) == pytest.approx(4 + 1 + 5)


def test_ply_strips_are_turned_as_their_triangles(tmp_path: Path) -> None:
    header = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
    header += "property float z\nelement tristrips 1\nproperty list int int vertex_indices\n"
    rows = "0 0 0\n1 0 0\n0 1 0\n1 1 0\n8 0 1 2 3 -1 0 1 2\n"
    (tmp_path / "m.ply").write_text(header + "end_header\n" + rows)
    mesh = load_mesh(tmp_path / "m.ply")
    a, b, c = (mesh.positions[mesh.faces[:, k]] for k in range(3))
    np.testing.assert_allclose(np.cross(b - a, c - a)[:, 2], [1, 1, 1])


@pytest.mark.parametrize("order", ["ascii", "binary_little_endian"])
@pytest.mark.parametrize(
    "change",
    [
        lambda d: b"\xef\xbb\xbf" + d,
        lambda d: d.replace(b"element vertex", b"comment before end_header\nelement vertex", 1),
        lambda d: b"\r".join(d.split(b"\n", d[: d.index(b"end_header") + 11].count(b"\n"))),
    ],
)
def test_ply_headers_may_be_odd(tmp_path: Path, order: str, change) -> None:
    # The last one ends its lines as old Macs did; x of the first vertex begins with a line feed, so that
    # a reader which looks for the next one would begin too late.
    x = -1 - 10 / 2**23
    data = ply(order, [(x, *CORNERS[0][1:]), *CORNERS[1:]], [[0, 1, 2, 3]])
    if order != "ascii":
        assert data.startswith(b"\n", data.index(b"end_header\n") + 11)
    assert area(obj(tmp_path, change(data), "m.ply")) == pytest.approx(4, rel=SINGLE_LONG)


@pytest.mark.parametrize("order", ["ascii", "binary_little_endian"])
def test_a_cut_ply_is_said_to_be_cut(tmp_path: Path, order: str) -> None:
    whole = ply(order, CORNERS, [[0, 1, 2, 3]], UVS)
    (tmp_path / "m.ply").write_bytes(whole[:-5])
    with pytest.raises(ValueError, match="cut short"):
        load_mesh(tmp_path / "m.ply")


# ------------------------------------------------------------------------------------- precision


def test_map_coordinates_keep_double_precision_until_the_mesh_is_centred(tmp_path: Path) -> None:
    """A strip of 1 mm steps at UTM coordinates; float32 has steps of half a metre there."""
    points = [(500000 + 0.001 * (k % 2), 4649776 + 0.001 * (k // 2), 100.0) for k in range(6)]
    faces = [[0, 1, 3, 2], [2, 3, 5, 4]]
    rows = "".join("v " + " ".join(map(repr, p)) + "\n" for p in points)
    text = rows + "".join("f " + " ".join(str(k + 1) for k in f) + "\n" for f in faces)
    paths = [obj(tmp_path, text), tmp_path / "m.ply"]
    paths[1].write_bytes(ply("binary_little_endian", points, faces, kind="double"))
    for path in paths:
        # 1e-5: double precision has 1e-9 there, on 1e-3
        assert area(path) == pytest.approx(2e-6, rel=1e-5)
        staged = on_stage(load_mesh(path))
        width, depth = np.ptp(staged.positions.astype(np.float32), axis=0)[:2]
        assert depth / width == pytest.approx(2, rel=SINGLE_LONG)


# ------------------------------------------------------------------------------------------ glTF

FLOAT, BYTE, USHORT, UINT = 5126, 5121, 5123, 5125


class Gltf:
    """Builds a small glTF file accessor by accessor."""

    def __init__(self) -> None:
        self.data = b""
        self.json: dict = {"asset": {"version": "2.0"}, "accessors": [], "bufferViews": []}

    def view(self, array: np.ndarray, **more) -> int:
        self.data += b"\0" * (-len(self.data) % 4)
        view = {"buffer": 0, "byteOffset": len(self.data), "byteLength": array.nbytes, **more}
        self.data += array.tobytes()
        self.json["bufferViews"].append(view)
        return len(self.json["bufferViews"]) - 1

    def accessor(self, array, kind=FLOAT, **more) -> int:
        dtype = {FLOAT: "<f4", BYTE: "<u1", USHORT: "<u2", UINT: "<u4"}[kind]
        array = np.asarray(array, dtype)
        width = 1 if array.ndim == 1 else array.shape[1]
        shape = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}[width]
        entry = {"bufferView": self.view(array), "componentType": kind, "count": len(array)}
        self.json["accessors"].append(entry | {"type": shape} | more)
        return len(self.json["accessors"]) - 1

    def mesh(self, *primitives, **node) -> None:
        meshes, nodes = (self.json.setdefault(key, []) for key in ("meshes", "nodes"))
        meshes.append({"primitives": list(primitives)})
        nodes.append({"mesh": len(meshes) - 1, **node})

    def write(self, path: Path) -> Path:
        self.json["scenes"] = [{"nodes": self.json.pop("roots", [*range(len(self.json["nodes"]))])}]
        self.json["scene"] = 0
        self.json["buffers"] = [{"byteLength": len(self.data)}]
        text = json.dumps(self.json).encode()
        text += b" " * (-len(text) % 4)
        data = self.data + b"\0" * (-len(self.data) % 4)
        chunks = struct.pack("<I4s", len(text), b"JSON") + text
        chunks += struct.pack("<I4s", len(data), b"BIN\0") + data
        path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)
        return path


def square(file: Gltf, indices=(0, 1, 2, 0, 2, 3), mode=4, uv_kind=FLOAT, **primitive) -> dict:
    uvs = np.array([(u, 1 - v) for u, v in UVS], float)
    top = {FLOAT: 1, BYTE: 255, USHORT: 65535}[uv_kind]
    normalized = {} if uv_kind == FLOAT else {"normalized": True}
    attributes = {
        "POSITION": file.accessor(np.array(CORNERS, float)),
        "TEXCOORD_0": file.accessor(uvs * top, uv_kind, **normalized),
    }
    index = {"indices": file.accessor(indices, USHORT)} if indices is not None else {}
    return {"attributes": attributes, "mode": mode, **index, **primitive}


@pytest.mark.parametrize(
    "kind",
    ["plain", "no indices", "strip", "fan", "bytes", "shorts", "scaled node", "gltf", "files"],
)
def test_a_square_is_the_same_however_gltf_writes_it(tmp_path: Path, kind: str) -> None:
    file, node = Gltf(), {}
    if kind == "no indices":
        primitive = square(file, None, 6)  # as a fan of all vertices
    elif kind == "strip":
        primitive = square(file, (0, 1, 3, 2), 5)
    elif kind == "fan":
        primitive = square(file, (0, 1, 2, 3), 6)
    elif kind in ("bytes", "shorts"):
        primitive = square(file, uv_kind=BYTE if kind == "bytes" else USHORT)
    else:
        primitive = square(file)
    if kind == "scaled node":
        node = {"scale": [0.5, 0.5, 0.5]}  # halves what the accessor doubles
        primitive["attributes"]["POSITION"] = file.accessor(2 * np.array(CORNERS, float))
    file.mesh(primitive, **node)
    path = file.write(tmp_path / "m.glb")
    if kind in ("gltf", "files"):
        document = dict(file.json)
        uri = "data:application/octet-stream;base64," + base64.b64encode(file.data).decode()
        if kind == "files":
            uri = "data%20of%20it.bin"
            (tmp_path / "data of it.bin").write_bytes(file.data)
        document["buffers"] = [{"byteLength": len(file.data), "uri": uri}]
        path = tmp_path / "m.gltf"
        path.write_text(json.dumps(document))
    assert area(path) == pytest.approx(4)
    assert corner_uvs(path) == UPRIGHT


def test_a_part_without_uvs_does_not_cost_the_others_theirs(tmp_path: Path) -> None:
    file = Gltf()
    file.mesh(square(file))
    bare = square(file)
    del bare["attributes"]["TEXCOORD_0"]
    file.mesh(bare, translation=[0, 0, 5])
    mesh = load_mesh(file.write(tmp_path / "m.glb"))
    assert mesh.uvs is not None
    front = mesh.positions[:, 2] == 0
    assert front.sum() == 4
    np.testing.assert_allclose(
        sorted(map(tuple, mesh.uvs[front])), [(0, 0), (0, 1), (1, 0), (1, 1)]
    )
    np.testing.assert_array_equal(mesh.uvs[~front], 0)


def test_sparse_values_replace_what_is_there_and_zeros(tmp_path: Path) -> None:
    for bare in (False, True):
        file = Gltf()
        position = file.accessor([(0, 0, 0), (1, 0, 0), (0, 1, 0)])
        entry = file.json["accessors"][position]
        where, what = np.array([1, 2], "<u2"), np.array([(3, 0, 0), (0, 5, 0)], "<f4")
        if bare:
            del entry["bufferView"]
        entry["sparse"] = {
            "count": 2,
            "indices": {"bufferView": file.view(where), "componentType": USHORT},
            "values": {"bufferView": file.view(what)},
        }
        file.mesh({"attributes": {"POSITION": position}})
        assert area(file.write(tmp_path / "m.glb")) == pytest.approx(7.5)


def test_interleaved_vertices_are_read_with_their_stride(tmp_path: Path) -> None:
    file = Gltf()
    rows = np.array([(*p, *uv) for p, uv in zip(CORNERS, UVS, strict=True)], "<f4")
    view = file.view(rows, byteStride=20)
    common = {"bufferView": view, "componentType": FLOAT, "count": 4}
    file.json["accessors"] += [
        {**common, "type": "VEC3"},
        {**common, "type": "VEC2", "byteOffset": 12},
    ]
    index = file.accessor([0, 1, 2, 0, 2, 3], BYTE)
    file.mesh({"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": index})
    path = file.write(tmp_path / "m.glb")
    assert {row[3:] for row in corner_uvs(path)} == {(0, 0), (1, 0), (1, 1), (0, 1)}
    assert area(path) == pytest.approx(4)


def test_mirrored_nodes_keep_outside_outside_and_normals_too(tmp_path: Path) -> None:
    file = Gltf()
    primitive = square(file)
    primitive["attributes"]["NORMAL"] = file.accessor([(0, 0, 1)] * 4)
    file.mesh(primitive, scale=[-1, 1, 2])
    mesh = load_mesh(file.write(tmp_path / "m.glb"))
    a, b, c = (mesh.positions[mesh.faces[:, k]] for k in range(3))
    assert (np.cross(b - a, c - a)[:, 2] > 0).all()
    np.testing.assert_allclose(mesh.normals, [[0, 0, 1]] * 4)


def test_a_skin_is_shown_in_the_pose_of_its_joints_and_not_of_its_node(tmp_path: Path) -> None:
    """Two joints of equal weight, one of which moved by 4: the mesh moves by 2 (linear blending)."""
    file = Gltf()
    primitive = square(file)
    primitive["attributes"] |= {
        "JOINTS_0": file.accessor([(0, 1, 0, 0)] * 4, BYTE),
        "WEIGHTS_0": file.accessor([(0.5, 0.5, 0, 0)] * 4),
    }
    file.mesh(primitive, skin=0, translation=[100, 0, 0])
    file.json["nodes"] += [{}, {"translation": [0, 0, 4]}]
    file.json["skins"] = [{"joints": [1, 2]}]
    mesh = load_mesh(file.write(tmp_path / "m.glb"))
    np.testing.assert_allclose(mesh.positions[:, 2], 2)
    assert mesh.positions[:, 0].max() == pytest.approx(1)


def test_morph_targets_have_their_default_weights(tmp_path: Path) -> None:
    file = Gltf()
    moved = file.accessor([(0, 0, 8)] * 4)
    file.mesh(square(file, targets=[{"POSITION": moved}]), weights=[0.25])
    mesh = load_mesh(file.write(tmp_path / "m.glb"))
    np.testing.assert_allclose(mesh.positions[:, 2], 2)


def test_uvs_are_those_of_the_base_colours_picture(tmp_path: Path) -> None:
    """Its own set of coordinates, scaled and moved as KHR_texture_transform says (gltfpack needs it)."""
    file = Gltf()
    primitive = square(file, material=0)
    primitive["attributes"]["TEXCOORD_1"] = file.accessor(np.full((4, 2), 0.25))
    change = {"offset": [0.5, 0], "scale": [2, 4]}
    picture = {"index": 0, "texCoord": 1, "extensions": {"KHR_texture_transform": change}}
    file.json["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": picture}}]
    file.json["extensionsRequired"] = ["KHR_texture_transform", "KHR_mesh_quantization"]
    file.mesh(primitive)
    np.testing.assert_allclose(load_mesh(file.write(tmp_path / "m.glb")).uvs, [[1, 1]] * 4)


@pytest.mark.parametrize(
    "name",
    [
        "KHR_draco_mesh_compression",
        "EXT_meshopt_compression",
        "EXT_mesh_gpu_instancing",
        "ACME_unheard_of",
    ],
)
def test_what_a_file_requires_and_is_not_done_is_refused_by_name(tmp_path: Path, name: str) -> None:
    file = Gltf()
    file.mesh(square(file))
    file.json["extensionsRequired"] = file.json["extensionsUsed"] = [name]
    with pytest.raises(ValueError, match=f"cannot use mesh .*needs the extension {name}"):
        load_mesh(file.write(tmp_path / "m.glb"))


def test_copies_that_are_not_drawn_are_said(tmp_path: Path) -> None:
    file = Gltf()
    file.mesh(square(file), extensions={"EXT_mesh_gpu_instancing": {"attributes": {}}})
    with pytest.warns(Notice, match="EXT_mesh_gpu_instancing"):
        assert area(file.write(tmp_path / "m.glb")) == pytest.approx(4)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda j: j["accessors"][0].update(count=99), "an accessor reaches beyond its data"),
        (lambda j: j["asset"].update(version="1.0"), "it is glTF 1.0"),
        (lambda j: j["nodes"][0].update(children=[0]), "its own ancestor"),
        (lambda j: j["meshes"][0]["primitives"][0].update(mode=1), "has no triangles"),
        (lambda j: j["accessors"][0].update(componentType=1), "is it damaged"),
        (lambda j: j.update(meshes=[]), "is it damaged"),
    ],
)
def test_a_wrong_gltf_is_one_clear_line(tmp_path: Path, change, message: str) -> None:
    file = Gltf()
    file.mesh(square(file))
    change(file.json)
    with pytest.raises(ValueError, match=message) as error:
        load_mesh(file.write(tmp_path / "m.glb"))
    assert "\n" not in str(error.value)


def test_a_missing_data_file_is_named(tmp_path: Path) -> None:
    document = {"asset": {"version": "2.0"}, "buffers": [{"byteLength": 4, "uri": "none.bin"}]}
    document["bufferViews"] = [{"buffer": 0, "byteLength": 4}]
    document["accessors"] = [{"bufferView": 0, "componentType": 5126, "count": 1, "type": "SCALAR"}]
    document["meshes"] = [{"primitives": [{"attributes": {"POSITION": 0}}]}]
    (tmp_path / "m.gltf").write_text(json.dumps(document))
    with pytest.raises(ValueError, match=r"none\.bin is not there"):
        load_mesh(tmp_path / "m.gltf")


# ------------------------------------------------------------------------------ normals and uvs


def prism(sides: int) -> str:
    angle = 2 * np.pi * np.arange(sides) / sides
    ring = [(np.cos(a), y, -np.sin(a)) for y in (0, 2) for a in angle]
    text = "".join("v {} {} {}\n".format(*p) for p in ring)
    for k in range(sides):
        n = (k + 1) % sides
        text += f"f {k + 1} {n + 1} {sides + n + 1} {sides + k + 1}\n"
    lid = " ".join(str(sides + k + 1) for k in range(sides))
    return text + f"f {lid}\n"


def test_computed_normals_round_a_tube_and_keep_its_rim_sharp(tmp_path: Path) -> None:
    mesh = with_normals(load_mesh(obj(tmp_path, prism(16))))
    a, b, c = (mesh.positions[mesh.faces[:, k]] for k in range(3))
    lid = np.abs(np.cross(b - a, c - a)[:, 1]) > 1e-9
    np.testing.assert_allclose(
        mesh.normals[mesh.faces[lid]], np.tile([0, 1, 0], (14, 3, 1)), atol=DOUBLE_DIVIDED
    )
    side = np.unique(mesh.faces[~lid])
    radial = mesh.positions[side] * [1, 0, 1]
    # A quad's two triangles weigh a corner alike in all: the normal is radial, by symmetry.
    np.testing.assert_allclose(mesh.normals[side], radial, atol=1e-9)
    hexagon = with_normals(load_mesh(obj(tmp_path, prism(6))))  # edges of 60 degrees are meant
    a, b, c = (hexagon.positions[hexagon.faces[:, k]] for k in range(3))
    flat = np.cross(b - a, c - a)
    flat /= np.linalg.norm(flat, axis=1, keepdims=True)
    np.testing.assert_allclose(
        hexagon.normals[hexagon.faces], flat[:, None].repeat(3, 1), atol=DOUBLE_DIVIDED
    )


def test_box_projection_shows_the_picture_upright_on_each_side(tmp_path: Path) -> None:
    text = "".join(f"v {x} {y} {z}\n" for x in (0, 1) for y in (0, 1) for z in (0, 1))
    text += "f 2 6 8 4\nf 5 1 3 7\nf 6 5 7 8\nf 1 2 4 3\nf 3 4 8 7\nf 1 5 6 2\n"
    mesh = projected(with_normals(load_mesh(obj(tmp_path, text))), "box")
    assert mesh.volume() == pytest.approx(1)
    assert mesh.uvs is not None
    p, uv = mesh.positions[mesh.faces], mesh.uvs[mesh.faces]
    e, f = p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]
    s, t = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
    # Not mirrored: u runs right and v down seen from outside, so the uv triangle turns the other way;
    # and as large as the surface, whose longest side is 1.
    np.testing.assert_allclose(s[:, 0] * t[:, 1] - s[:, 1] * t[:, 0], -np.ones(12), atol=1e-9)
    assert np.linalg.norm(np.cross(e, f), axis=1) == pytest.approx(1)
    upright = np.abs(np.cross(e, f)[:, 1]) < 1e-9
    np.testing.assert_allclose(uv[upright][..., 1], 1 - p[upright][..., 1], atol=DOUBLE_DIVIDED)


def test_sphere_projection_is_longitude_and_latitude_without_a_torn_seam(tmp_path: Path) -> None:
    import trimesh

    trimesh.creation.icosphere(subdivisions=3).export(tmp_path / "m.ply")
    mesh = projected(with_normals(load_mesh(tmp_path / "m.ply")), "sphere")
    assert mesh.uvs is not None
    d, uv = mesh.positions, mesh.uvs
    np.testing.assert_allclose(np.cos(np.pi * uv[:, 1]), d[:, 1], atol=SINGLE_LONG)
    away = np.hypot(d[:, 0], d[:, 2]) > 1e-3
    turn = 2 * np.pi * (uv[away, 0] - 0.5)
    flat = d[away][:, [0, 2]] / np.hypot(d[away, 0], d[away, 2])[:, None]
    np.testing.assert_allclose(
        np.stack([np.sin(turn), np.cos(turn)], -1), flat, atol=DOUBLE_DIVIDED
    )
    assert np.ptp(uv[mesh.faces][..., 0], axis=1).max() <= 0.5


def test_an_unknown_projection_names_the_known_ones(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="no uv projection 'cube'; use one of box, sphere"):
        projected(load_mesh(obj(tmp_path, SQUARE_OBJ)), "cube")


@pytest.mark.parametrize(
    ("vertices", "message"),
    [
        ("v 0 0 0\nv 1 1 1\nv 3 3 3\n", "no area"),
        ("v 1e7 0 0\nv 1e7 0.1 0.1\nv 1e7 0.3 0.3\n", "no area"),
        ("v 0 0 0\nv 1e-200 0 0\nv 0 1e-200 0\n", "usual size"),
        ("v 0 0 0\nv 1e200 0 0\nv 0 1e200 0\n", "usual size"),
    ],
)
def test_a_mesh_of_which_nothing_can_be_seen_is_refused(tmp_path: Path, vertices, message) -> None:
    with pytest.raises(ValueError, match=message):
        load_mesh(obj(tmp_path, vertices + "f 1 2 3\n"))


def test_a_mesh_s_own_floor_is_not_the_ground_s_plane(tmp_path: Path) -> None:
    """Rays would hit now the one and now the other."""
    square = "v 0 0 0\nv 1 0 0\nv 1 0 1\nv 0 0 1\n"
    mesh = on_stage(load_mesh(obj(tmp_path, square + "f 4 3 2 1\n")))
    heights = mesh.positions.astype(np.float32)[:, 1]
    assert heights.min() > 1e-4  # many steps of float32, which are 1e-7 there
    assert heights.max() < 0.005 * MESH_RADIUS, "nobody sees it float"


def test_needles_and_unusual_units_are_drawn(tmp_path: Path) -> None:
    needle = "v 0 0 0\nv 1 0 0\nv 1 1e-6 0\nf 1 2 3\n"
    assert area(obj(tmp_path, needle)) == pytest.approx(5e-7)
    for unit in ("e-30", "e30"):
        corners = SQUARE_OBJ.replace("v -1 ", f"v -1{unit} ").replace("v 1 ", f"v 1{unit} ")
        mesh = on_stage(load_mesh(obj(tmp_path, corners.replace(" 2 0\n", f" 2{unit} 0\n"))))
        assert np.ptp(mesh.positions, axis=0)[:2] == pytest.approx(2 * 1.12 / np.sqrt(2))
