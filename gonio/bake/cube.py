"""Cube maps with prefiltered levels, for the environments of real-time renderers.

    cube = gonio.bake.cube.prefiltered(sky, size=256)
    cube.write("sky.ktx2")                                 # or a folder of EXR files
    cube.radiance(directions, alpha)                       # as a shader looks it up

Level k is blurred by a GGX lobe of alpha = (k / LAST_LEVEL)^2 (see `gonio.lights.lookups`). Faces stand in
the order +x, -x, +y, -y, +z, -z, their rows from the top, as Vulkan, Direct3D, Metal and OpenGL have them.

Sources: Karis, "Real shading in Unreal Engine 4", SIGGRAPH 2013 course, for the blur; Khronos, "KTX file
format specification", version 2.0.4, for the file.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gonio.bake.environment import Environment
from gonio.bake.tables import HALF_MAX
from gonio.files import check_place, replacing
from gonio.images import write_linear
from gonio.lights.lookups import LAST_LEVEL

Floats = NDArray[np.float64]
Progress = Callable[[int, int], None]

SIZE = 256
"""Texels along a face of the sharpest level."""

FACES = ("+x", "-x", "+y", "-y", "+z", "-z")


@dataclass(frozen=True)
class Cube:
    """Radiance from all directions, once for each level of blur; linear RGB."""

    levels: tuple[Floats, ...]
    """Each of shape (6, size, size, 3), half as large as the one before."""

    def radiance(self, directions: ArrayLike, alpha: ArrayLike) -> Floats:
        """What a shader sees: linear between texels of a face and between levels; shape (..., 3)."""
        w, alpha = np.asarray(directions, np.float64), np.asarray(alpha, np.float64)
        level = np.broadcast_to(np.clip(LAST_LEVEL * np.sqrt(alpha), 0, LAST_LEVEL), w.shape[:-1])
        low = np.minimum(level.astype(int), LAST_LEVEL - 1)
        found = np.zeros(w.shape)
        for k in np.unique([low, low + 1]):
            weight = np.maximum(1 - np.abs(level - k), 0)
            found += weight[..., None] * _look_up(self.levels[k], w)
        return found

    def write(self, path: str | Path) -> list[Path]:
        """Write one .ktx2 file of half floats, or a folder of .exr files, one for each face and level.

        Raises:
            ValueError: another suffix.
            FileNotFoundError: the folder above does not exist.
        """
        path = check_place_of(path)
        if path.suffix.lower() == ".ktx2":
            with replacing(path) as temporary:
                temporary.write_bytes(ktx2(self))
            return [path]
        path.mkdir(exist_ok=True)
        written = []
        for number, level in enumerate(self.levels):
            for name, face in zip(("px", "nx", "py", "ny", "pz", "nz"), level, strict=True):
                target = path / f"{name}_{number}.exr"
                with replacing(target) as temporary:
                    write_linear(temporary, face)
                written.append(target)
        return written


def check_place_of(path: str | Path) -> Path:
    """The path, or a ValueError or OSError unless `Cube.write` can write there."""
    path = Path(path)
    if path.suffix.lower() == ".ktx2":
        return check_place(path)
    if path.suffix or path.is_file():
        raise ValueError(
            f"cannot write {path.name!r}; name a .ktx2 file, or a folder for six .exr files a level."
        )
    return path if path.is_dir() else check_place(path)


def check_size(size: int) -> None:
    """A ValueError unless a face of a cube can be so large."""
    if size & (size - 1) or not 64 <= size <= 2048:
        raise ValueError(
            f"size={size} is out of range; allowed are 64, 128, 256, 512, 1024 and 2048."
        )


def prefiltered(
    environment: Environment, size: int = SIZE, *, progress: Progress | None = None
) -> Cube:
    """An environment as a cube with LAST_LEVEL + 1 levels.

    Args:
        environment: not blurred.
        size: texels along a face of the sharpest level, a power of two from 64 to 2048.
        progress: called with (levels done, levels in all).

    Raises:
        ValueError: a size out of its range.
    """
    check_size(size)
    levels = []
    for k in range(LAST_LEVEL + 1):
        alpha = (k / LAST_LEVEL) ** 2
        picture = environment if k == 0 else environment.blurred(alpha)
        levels.append(faces(picture, size >> k))
        if progress is not None:
            progress(k + 1, LAST_LEVEL + 1)
    return Cube(tuple(levels))


def error(cube: Cube, environment: Environment, alpha: float, count: int = 2000) -> float:
    """Mean difference of what a shader sees from the picture blurred by alpha, as a share of its mean."""
    w = np.random.default_rng(0).normal(size=(count, 3))
    w /= np.linalg.norm(w, axis=1, keepdims=True)
    exact = environment.blurred(alpha).radiance(w)
    return float(np.abs(cube.radiance(w, alpha) - exact).mean() / exact.mean())


def directions(size: int, inset: ArrayLike = (0.5, 0.5)) -> Floats:
    """Unit directions of a cube's texels, shape (6, size, size, 3); inset: where in the texel."""
    a, b = np.asarray(inset, np.float64)
    s = 2 * (np.arange(size) + a) / size - 1
    t = 2 * (np.arange(size) + b) / size - 1
    u, v = np.broadcast_arrays(s[None, :], t[:, None])
    one = np.ones_like(u)
    faces = [(one, -v, -u), (-one, -v, u), (u, one, v), (u, -one, -v), (u, -v, one), (-u, -v, -one)]
    w = np.stack([np.stack(face, axis=-1) for face in faces])
    return np.asarray(w / np.linalg.norm(w, axis=-1, keepdims=True))


# Places along a texel's side whose mean stands for it.
INSIDE = 4

# Where the picture is finer than the cube, places in a texel would miss some of its pixels, and near the
# poles, where these are slivers, most. Then every pixel is poured into the texels that it covers, so finely
# that POURED places lie side by side in the middle of a face (a third of that in its corners).
PIXELS_MOST, POURED = 1, 6

# Rows of a picture that are poured at a time, for little memory.
ROWS = 16


def faces(picture: Environment, size: int) -> Floats:
    """A picture as the faces of one level: the mean over each texel, shape (6, size, size, 3)."""
    rows, columns = picture.pixels.shape[:2]
    pixels = np.array([2 * (rows - 1), columns]) / (np.pi * size)  # down and across a texel
    if pixels.max() > PIXELS_MOST:
        down, across = np.maximum(np.ceil(POURED / pixels), 2).astype(int)
        return _poured(picture, size, down, across)
    places = (np.arange(INSIDE) + 0.5) / INSIDE
    found = [picture.radiance(directions(size, (a, b))) for a in places for b in places]
    return np.asarray(np.mean(found, axis=0))


def _poured(picture: Environment, size: int, down: int, across: int) -> Floats:
    """The mean of a picture over each texel, from so many places along a pixel's sides."""
    rows, columns = picture.pixels.shape[:2]
    phi = 2 * np.pi * (np.arange(across * columns) + 0.5) / (across * columns)
    solid: Floats = np.zeros(6 * size * size)
    light: Floats = np.zeros((solid.size, 3))
    for first in range(0, rows - 1, ROWS):
        last = min(first + ROWS, rows - 1)
        theta = np.pi * (np.arange(down * first, down * last) + 0.5)[:, None] / (down * (rows - 1))
        sine = np.sin(theta)
        x, z = sine * np.sin(phi), -sine * np.cos(phi)
        w = np.stack(np.broadcast_arrays(x, np.cos(theta), z), axis=-1)
        face, s, t = _on_faces(w)
        i, j = (np.minimum((c * size).astype(int), size - 1) for c in (s, t))
        texel = ((face * size + j) * size + i).ravel()
        weight = np.broadcast_to(sine, face.shape)
        solid += np.bincount(texel, weight.ravel(), solid.size)
        for channel, values in enumerate(np.moveaxis(picture.radiance(w), -1, 0)):
            light[:, channel] += np.bincount(texel, (weight * values).ravel(), solid.size)
    return np.asarray((light / solid[:, None]).reshape(6, size, size, 3))


def _on_faces(w: Floats) -> tuple[NDArray[np.intp], Floats, Floats]:
    """The face that each direction meets, and where on it, from 0 to 1."""
    axis = np.argmax(np.abs(w), axis=-1)
    major = np.take_along_axis(w, axis[..., None], axis=-1)[..., 0]
    x, y, z = np.moveaxis(w / np.abs(major)[..., None], -1, 0)
    positive = major > 0
    s = np.select([axis == 0, axis == 1], [np.where(positive, -z, z), x], np.where(positive, x, -x))
    t = np.select([axis == 0, axis == 1], [-y, np.where(positive, z, -z)], -y)
    return 2 * axis + ~positive, (s + 1) / 2, (t + 1) / 2


def _look_up(level: Floats, w: Floats) -> Floats:
    """Linear between the texels of a face; at its edge the outermost texel."""
    size = level.shape[1]
    face, s, t = _on_faces(w)
    i, j = (np.clip(c * size - 0.5, 0, size - 1) for c in (s, t))
    i0, j0 = (np.minimum(c.astype(int), max(size - 2, 0)) for c in (i, j))
    p, q = (i - i0)[..., None], (j - j0)[..., None]
    above = (1 - p) * level[face, j0, i0] + p * level[face, j0, i0 + 1]
    below = (1 - p) * level[face, j0 + 1, i0] + p * level[face, j0 + 1, i0 + 1]
    return np.asarray((1 - q) * above + q * below)


# --- the file ------------------------------------------------------------------------------------------

MAGIC = b"\xabKTX 20\xbb\r\n\x1a\n"

# VK_FORMAT_R16G16B16A16_SFLOAT, and bytes of one of its texels.
FORMAT, TEXEL = 97, 8


def ktx2(cube: Cube) -> bytes:
    """The bytes of a KTX 2 file with RGBA half floats, not compressed."""
    descriptor = _descriptor()
    count = len(cube.levels)
    start = 80 + 24 * count
    head_end = start + len(descriptor)
    data = [_half(level).tobytes() for level in cube.levels]
    # The smallest level comes first, and each begins at a multiple of a texel's size.
    offsets, at = [0] * count, -(-head_end // TEXEL) * TEXEL
    for k in reversed(range(count)):
        offsets[k] = at
        at += len(data[k])
    size = cube.levels[0].shape[1]
    head = MAGIC + struct.pack("<9I", FORMAT, 2, size, size, 0, 0, 6, count, 0)
    head += struct.pack("<4I2Q", start, len(descriptor), 0, 0, 0, 0)
    for offset, level in zip(offsets, data, strict=True):
        head += struct.pack("<3Q", offset, len(level), len(level))
    head += descriptor
    head += bytes(offsets[-1] - len(head))
    return head + b"".join(reversed(data))


def _half(level: Floats) -> NDArray[np.float16]:
    alpha = np.ones((*level.shape[:-1], 1))
    # Brighter suns are cut off in files of 16 bits.
    return np.concatenate([np.minimum(level, HALF_MAX), alpha], axis=-1).astype("<f2")


def _descriptor() -> bytes:
    """The data format descriptor: four channels of 16 bit floats, linear, Rec. 709."""
    samples = b"".join(
        struct.pack("<HBB4BII", 16 * i, 15, channel | 0xC0, 0, 0, 0, 0, 0xBF800000, 0x3F800000)
        for i, channel in enumerate((0, 1, 2, 15))
    )
    block = struct.pack(
        "<IHH4B4B8B", 0, 2, 24 + len(samples), 1, 1, 1, 0, 0, 0, 0, 0, TEXEL, *[0] * 7
    )
    return struct.pack("<I", 4 + len(block) + len(samples)) + block + samples
