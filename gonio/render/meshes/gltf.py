"""glTF 2.0, in one file (.glb) or in several (.gltf): the default scene's triangles in its rest pose.

Read as the Khronos specification 2.0 says: nodes' transforms, triangle lists, strips and fans, accessors
with strides, sparse values and normalised integers, morph targets with their default weights, skins in
the pose of their joints. The uvs are those of the base colour's picture, with KHR_texture_transform,
else TEXCOORD_0. What an extension that the file requires would change is refused by its name.
"""

from __future__ import annotations

import base64
import json
import re
import struct
import urllib.parse
from pathlib import Path
from typing import Any

import numpy as np

from gonio.messages import notice
from gonio.render.triangles import Floats, Ints, Triangles, joined

# Required extensions that change nothing here: looks, lights and notes of a file whose material is
# replaced, and those that this reader does itself.
_HARMLESS = re.compile(
    r"KHR_(materials_\w+|texture_\w+|lights_\w+|mesh_quantization|node_visibility|animation_\w+|xmp\w*"
    r"|environment_map|techniques_webgl)|EXT_(texture_\w+|lights_\w+)|MSFT_texture_dds"
)
_COMPRESSED = ("KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression")
_INSTANCING = "EXT_mesh_gpu_instancing"
_REMEDIES = {
    **dict.fromkeys(_COMPRESSED, "export it without compression"),
    _INSTANCING: "export the copies as nodes of their own",
}

_KINDS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}
_TRIANGLES, _STRIP, _FAN = 4, 5, 6


def read_gltf(file: Path) -> Triangles:
    """The triangles of a .glb or .gltf file, in the coordinates of its scene.

    Raises:
        ValueError: no glTF, data cut short, or a feature that is required and not done, by its name.
    """
    return _File(file).triangles()


class RefusedError(ValueError):
    """A file that is right but needs what is not done here."""


class _File:
    def __init__(self, file: Path) -> None:
        self.file = file
        data = file.read_bytes()
        self.chunk: bytes | None = None
        if data[:4] == b"glTF":
            data, self.chunk = _chunks(data)
        try:
            self.json: dict[str, Any] = json.loads(data.decode("utf-8-sig"))
        except (UnicodeDecodeError, json.JSONDecodeError) as error:
            raise ValueError(f"it is not glTF, or cut short ({error})") from None
        if not isinstance(self.json, dict) or not isinstance(self.json.get("asset"), dict):
            raise ValueError("it is not glTF: it has no 'asset'")
        version = str(self.json["asset"].get("version", ""))
        if not version.startswith("2"):
            raise RefusedError(f"it is glTF {version or 'without a version'}; 2.0 is read")
        for name in self.json.get("extensionsRequired", []):
            if not _HARMLESS.fullmatch(name):
                raise RefusedError(_refusal(name))
        self.buffers: dict[int, bytes] = {}
        self.world: dict[int, Floats] = {}

    def triangles(self) -> Triangles:
        nodes = self.json.get("nodes", [])
        scenes = self.json.get("scenes", [])
        if scenes:
            roots = scenes[self.json.get("scene", 0)].get("nodes", [])
        else:
            children = {c for node in nodes for c in node.get("children", [])}
            roots = [n for n in range(len(nodes)) if n not in children]
        shown = self._walk(roots)
        parts = [part for n in shown if "mesh" in nodes[n] for part in self._node(nodes[n], n)]
        if not nodes:
            meshes = self.json.get("meshes", [])
            parts = [part for mesh in meshes for part in self._mesh(mesh, {}, np.eye(4), None)]
        if not parts:
            return Triangles(np.zeros((0, 3)), np.zeros((0, 3), np.int64))
        return joined(parts)

    def _walk(self, roots: list[int]) -> list[int]:
        """Visible nodes from the roots down; their transforms are left in `world`."""
        nodes = self.json.get("nodes", [])
        shown: list[int] = []
        pending = [(n, np.eye(4), True) for n in reversed(roots)]
        while pending:
            n, above, visible = pending.pop()
            if n in self.world:
                raise ValueError(f"its node {n} is its own ancestor, or has two parents")
            node = nodes[n]
            self.world[n] = above @ _local(node)
            hidden = node.get("extensions", {}).get("KHR_node_visibility", {})
            visible = visible and hidden.get("visible", True) is not False
            if visible:
                shown.append(n)
            children = node.get("children", [])
            pending += [(c, self.world[n], visible) for c in reversed(children)]
        return shown

    def _node(self, node: dict[str, Any], number: int) -> list[Triangles]:
        if _INSTANCING in node.get("extensions", {}):
            notice(f"mesh {self.file} has {_INSTANCING}, which is not done; one instance is drawn.")
        skin = None
        if "skin" in node:
            skin = self._joints(self.json["skins"][node["skin"]])
        mesh = self.json["meshes"][node["mesh"]]
        return self._mesh(mesh, node, self.world[number], skin)

    def _joints(self, skin: dict[str, Any]) -> Floats:
        """For each joint of a skin, what takes a vertex of the bind pose to the scene; (J, 4, 4)."""
        joints = skin["joints"]
        inverse = np.broadcast_to(np.eye(4), (len(joints), 4, 4))
        if "inverseBindMatrices" in skin:
            stored = self._accessor(skin["inverseBindMatrices"]).reshape(-1, 4, 4)
            inverse = stored.transpose(0, 2, 1)[: len(joints)]
        here = np.stack([self.world.get(j, np.eye(4)) for j in joints])
        return np.asarray(here @ inverse)

    def _mesh(
        self, mesh: dict[str, Any], node: dict[str, Any], world: Floats, skin: Floats | None
    ) -> list[Triangles]:
        parts = []
        weights = node.get("weights", mesh.get("weights", []))
        for primitive in mesh["primitives"]:
            part = self._primitive(primitive, weights, world, skin)
            if part is not None and len(part.faces):
                parts.append(part)
        return parts

    def _primitive(
        self,
        primitive: dict[str, Any],
        weights: list[float],
        world: Floats,
        skin: Floats | None,
    ) -> Triangles | None:
        mode = primitive.get("mode", _TRIANGLES)
        attributes = primitive["attributes"]
        if mode not in (_TRIANGLES, _STRIP, _FAN) or "POSITION" not in attributes:
            return None  # points or lines
        for name in _COMPRESSED:
            position = self.json["accessors"][attributes["POSITION"]]
            if name in primitive.get("extensions", {}) and not {"bufferView", "sparse"} & set(
                position
            ):
                raise RefusedError(_refusal(name))
        positions = self._accessor(attributes["POSITION"])
        normals = self._accessor(attributes["NORMAL"]) if "NORMAL" in attributes else None
        for name, found in (("POSITION", positions), ("NORMAL", normals)):
            if found is not None and found.shape != (len(positions), 3):
                raise ValueError(f"its {name} does not have three numbers for each vertex")
        for weight, target in zip(weights, primitive.get("targets", []), strict=False):
            if weight and "POSITION" in target:
                positions = positions + weight * self._accessor(target["POSITION"])
            if weight and "NORMAL" in target and normals is not None:
                normals = normals + weight * self._accessor(target["NORMAL"])
        count = len(positions)
        if "indices" in primitive:
            index = self._accessor(primitive["indices"])[:, 0].astype(np.int64)
        else:
            index = np.arange(count)
        faces = _faces(index, mode)
        if len(faces) and (faces.min() < 0 or faces.max() >= count):
            raise ValueError(
                f"it has a triangle with a vertex that is not there (there are {count})"
            )
        matrices = self._matrices(attributes, count, world, skin)
        linear = matrices[..., :3, :3]
        positions = np.einsum("...ij,...j->...i", linear, positions) + matrices[..., :3, 3]
        if normals is not None:
            # Cofactors turn normals as inverse transposes do, and exist for flattened nodes too.
            rows = linear[..., [1, 2, 0], :], linear[..., [2, 0, 1], :]
            cofactor = np.cross(rows[0], rows[1])
            normals = np.einsum("...ij,...j->...i", cofactor, normals)
            length = np.linalg.norm(normals, axis=-1, keepdims=True)
            normals = normals / np.where(length > 0, length, 1)
        mirrored = np.linalg.det(world[:3, :3]) < 0 if skin is None else False
        if mirrored:  # a mirrored node turns its triangles inside out, and cofactors its normals
            faces = faces[:, ::-1]
            normals = None if normals is None else -normals
        return Triangles(positions, faces, normals, self._uvs(primitive, count))

    def _matrices(
        self, attributes: dict[str, int], count: int, world: Floats, skin: Floats | None
    ) -> Floats:
        """What takes the vertices to the scene: the node's transform, or the mean of each's joints."""
        if skin is None or "JOINTS_0" not in attributes or "WEIGHTS_0" not in attributes:
            return world
        total: Floats = np.zeros((count, 4, 4))
        weight_sum = np.zeros(count)
        for k in range(8):
            if f"JOINTS_{k}" not in attributes or f"WEIGHTS_{k}" not in attributes:
                break
            joints = self._accessor(attributes[f"JOINTS_{k}"]).astype(np.int64)
            weights = self._accessor(attributes[f"WEIGHTS_{k}"])
            if joints.max() >= len(skin):
                raise ValueError("a vertex hangs on a joint that is not there")
            for column in range(4):
                total += weights[:, column, None, None] * skin[joints[:, column]]
            weight_sum += weights.sum(axis=1)
        return np.asarray(total / np.where(weight_sum > 0, weight_sum, 1)[:, None, None])

    def _uvs(self, primitive: dict[str, Any], count: int) -> Floats | None:
        """Coordinates of the base colour's picture, v = 0 at its top row, as Mitsuba has it."""
        materials = self.json.get("materials", [])
        material = materials[primitive["material"]] if "material" in primitive else {}
        picture = material.get("pbrMetallicRoughness", {}).get("baseColorTexture", {})
        change = picture.get("extensions", {}).get("KHR_texture_transform", {})
        number = change.get("texCoord", picture.get("texCoord", 0))
        attributes = primitive["attributes"]
        name = f"TEXCOORD_{number}"
        if name not in attributes:
            name, change = "TEXCOORD_0", {}
        if name not in attributes:
            return None
        uvs = self._accessor(attributes[name])
        if len(uvs) != count or uvs.shape[1] != 2:
            raise ValueError(f"its {name} does not have two numbers for each vertex")
        angle = float(change.get("rotation", 0.0))
        turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        scaled = uvs * np.asarray(change.get("scale", (1, 1)), np.float64)
        return np.asarray(scaled @ turn.T + np.asarray(change.get("offset", (0, 0)), np.float64))

    def _accessor(self, number: int) -> Floats:
        """All values of an accessor, (count, width); normalised integers are fractions."""
        accessor = self.json["accessors"][number]
        kind, width = np.dtype(_KINDS[accessor["componentType"]]), _WIDTHS[accessor["type"]]
        count = int(accessor["count"])
        if "bufferView" in accessor:
            view, offset = accessor["bufferView"], accessor.get("byteOffset", 0)
            values = self._values(view, offset, kind, count, width, accessor["type"])
        else:
            values = np.zeros((count, width), kind)
        if "sparse" in accessor:
            sparse = accessor["sparse"]
            where, what, n = sparse["indices"], sparse["values"], int(sparse["count"])
            index_kind = np.dtype(_KINDS[where["componentType"]])
            index = self._values(
                where["bufferView"], where.get("byteOffset", 0), index_kind, n, 1, "SCALAR"
            )[:, 0]
            replaced = self._values(
                what["bufferView"], what.get("byteOffset", 0), kind, n, width, accessor["type"]
            )
            if n and index.max() >= count:
                raise ValueError("a sparse accessor changes a value that is not there")
            values = values.copy()
            values[index] = replaced
        result = values.astype(np.float64)
        if accessor.get("normalized") and kind.kind in "iu":
            return np.asarray(np.maximum(result / np.iinfo(kind).max, -1.0))
        return np.asarray(result)

    def _values(
        self, view_number: int, offset: int, kind: Any, count: int, width: int, shape: str
    ) -> Any:
        view = self.json["bufferViews"][view_number]
        for name in _COMPRESSED:
            fallback = self.json["buffers"][view["buffer"]].get("extensions", {}).get(name, {})
            if name in view.get("extensions", {}) and fallback.get("fallback"):
                raise RefusedError(_refusal(name))
        row = _row(kind, width, shape)
        stride = view.get("byteStride", row.itemsize)
        start = view.get("byteOffset", 0)
        data = self._buffer(view["buffer"])[start : start + view["byteLength"]]
        needed = offset + (count - 1) * stride + row.itemsize if count else 0
        if stride < row.itemsize or offset < 0 or needed > len(data):
            raise ValueError("it is cut short: an accessor reaches beyond its data")
        if not count:
            return np.zeros((0, width), kind)
        table = np.ndarray((count,), row, data, offset, (stride,))["value"]
        return table

    def _buffer(self, number: int) -> bytes:
        if number not in self.buffers:
            self.buffers[number] = self._load(self.json["buffers"][number], number)
        return self.buffers[number]

    def _load(self, buffer: dict[str, Any], number: int) -> bytes:
        uri = buffer.get("uri")
        if uri is None:
            if number != 0 or self.chunk is None:
                raise ValueError(f"its buffer {number} has no data")
            return self.chunk
        if uri.startswith("data:"):
            head, _, body = uri.partition(",")
            if head.endswith(";base64"):
                return base64.b64decode(body)
            return urllib.parse.unquote_to_bytes(body)
        if re.match(r"\w+://", uri):
            raise RefusedError(f"its data are at {uri}; download them beside it")
        path = self.file.parent / urllib.parse.unquote(uri)
        if not path.is_file():
            raise ValueError(f"its data file {path} is not there; copy it beside the .gltf")
        return path.read_bytes()


def _row(kind: Any, width: int, shape: str) -> Any:
    """One value as it is stored."""
    if shape[:3] == "MAT" and int(shape[3]) * kind.itemsize % 4:
        # Their columns start at multiples of four bytes.
        raise RefusedError(f"it has {shape} of small integers, which are not read")
    return np.dtype([("value", kind, (width,))])


def _refusal(name: str) -> str:
    remedy = _REMEDIES.get(name, "export it without that extension")
    return f"it needs the extension {name}, which is not done here; {remedy}"


def _chunks(data: bytes) -> tuple[bytes, bytes | None]:
    """The JSON and the binary chunk of a .glb."""
    if len(data) < 20:
        raise ValueError("it is cut short")
    version, length = struct.unpack_from("<II", data, 4)
    if version != 2:
        raise ValueError(f"it is GLB version {version}; 2 is read")
    if length > len(data):
        raise ValueError(f"it is cut short: {len(data)} bytes of {length}")
    found: dict[bytes, bytes] = {}
    place = 12
    while place + 8 <= length:
        size, kind = struct.unpack_from("<I4s", data, place)
        if place + 8 + size > length:
            raise ValueError("it is cut short: a chunk reaches beyond its end")
        found.setdefault(kind, data[place + 8 : place + 8 + size])
        place += 8 + size
    if b"JSON" not in found:
        raise ValueError("it has no JSON chunk")
    return found[b"JSON"], found.get(b"BIN\0")


def _faces(index: Ints, mode: int) -> Ints:
    if mode == _TRIANGLES:
        return np.asarray(index[: len(index) // 3 * 3].reshape(-1, 3))
    if len(index) < 3:
        return np.zeros((0, 3), np.int64)
    if mode == _FAN:
        first = np.full(len(index) - 2, index[0])
        return np.stack([first, index[1:-1], index[2:]], axis=-1)
    faces = np.stack([index[:-2], index[1:-1], index[2:]], axis=-1)
    faces[1::2] = faces[1::2][:, [0, 2, 1]]  # every second triangle of a strip is turned over
    a, b, c = faces.T
    return np.asarray(faces[(a != b) & (b != c) & (a != c)])  # what joins strips has no area


def _local(node: dict[str, Any]) -> Floats:
    """A node's own transform."""
    if "matrix" in node:
        return np.asarray(node["matrix"], np.float64).reshape(4, 4).T
    x, y, z, w = np.asarray(node.get("rotation", (0, 0, 0, 1)), np.float64)
    n = x * x + y * y + z * z + w * w
    s = 2 / n if n > 0 else 0.0
    turn = np.array(
        [
            [1 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w)],
            [s * (x * y + z * w), 1 - s * (x * x + z * z), s * (y * z - x * w)],
            [s * (x * z - y * w), s * (y * z + x * w), 1 - s * (x * x + y * y)],
        ]
    )
    result = np.eye(4)
    result[:3, :3] = turn * np.asarray(node.get("scale", (1, 1, 1)), np.float64)
    result[:3, 3] = node.get("translation", (0, 0, 0))
    return result
