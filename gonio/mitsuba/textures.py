"""Maps for models that vary over a surface: flakes of car paint, and where patina grows.

Maps are NumPy arrays. The functions named `..._texture` turn them into Mitsuba textures, which are passed
to the model's plug-in:

    flakes = gonio.mitsuba.textures.flake_map(seed=1)
    bsdf = {"type": "gonio_car_paint", **gonio.mitsuba.textures.flake_texture(flakes, tiles=40)}

Sources: Elek, "Layered materials in real-time rendering", CESCG 2010, section 4, for what the maps are for;
Perlin, "Improving noise", SIGGRAPH 2002, for the noise.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gonio.files import replacing
from gonio.images import write_linear
from gonio.mitsuba import viewer_distance

Floats = NDArray[np.float64]
Map = NDArray[np.float32]

# Largest slope that gonio's car paint takes.
SLOPE_MAX = 2.0

ATTRIBUTE = "vertex_growth"


# Radius of a curve that counts as a marked cavity or ridge, over the mesh's diagonal.
CAVITY_RADIUS = 0.1


# --- flakes --------------------------------------------------------------------------------------------


def flake_map(
    size: int = 256,
    density: float = 0.9,
    flake_size: float = 4.0,
    spread: float = 0.4,
    seed: int = 0,
) -> Map:
    """Slopes of flake normals, a tile that repeats without seams.

    Each flake is a cell around a point (a Voronoi cell of a jittered grid) and has one normal.

    Args:
        size: pixels along each side.
        density: share of the cells that hold a flake, 0 to 1; the others are flat.
        flake_size: mean distance of neighbouring flakes, in pixels.
        spread: standard deviation of the slopes along x and y; 0.4 tilts most flakes by up to 30 degrees.
        seed: the same seed gives the same map.

    Returns:
        Slopes along x and y, shape (size, size, 2): the flake's normal is normalize(x, y, 1).

    Raises:
        ValueError: an argument out of its range.
    """
    if size < 1 or not 1 <= flake_size <= size:
        raise ValueError(
            f"flake_size={flake_size} is out of range; allowed is 1 to size, which is {size}."
        )
    if not 0 <= density <= 1:
        raise ValueError(f"density={density} is out of range; allowed is 0 to 1.")
    if not spread >= 0:
        raise ValueError(f"spread={spread} is out of range; allowed is at least 0.")
    rng = np.random.default_rng(seed)
    cells = max(1, round(size / flake_size))
    points = rng.random((cells, cells, 2))
    slopes = np.clip(rng.normal(0, spread, (cells, cells, 2)), -SLOPE_MAX, SLOPE_MAX)
    slopes[rng.random((cells, cells)) >= density] = 0

    at = (np.arange(size) + 0.5) * cells / size
    y, x = np.meshgrid(at, at, indexing="ij")
    row, column = y.astype(int), x.astype(int)
    nearest = np.full((size, size), np.inf)
    owner = np.zeros((size, size, 2), int)
    # The nearest of jittered points lies at most two cells away.
    for down in range(-2, 3):
        for right in range(-2, 3):
            i, j = (row + down) % cells, (column + right) % cells
            distance = np.hypot(
                row + down + points[i, j, 0] - y, column + right + points[i, j, 1] - x
            )
            closer = distance < nearest
            nearest[closer] = distance[closer]
            owner[closer] = np.stack([i, j], -1)[closer]
    return np.asarray(slopes[owner[..., 0], owner[..., 1]], np.float32)


def flake_texture(slopes: Map, tiles: float = 100.0, fade: float | None = None) -> dict[str, Any]:
    """`flake_x` and `flake_y` of a flake map as Mitsuba textures, tiled and unfiltered.

    Args:
        slopes: as `flake_map` makes them.
        tiles: how often the map repeats along u and along v.
        fade: how far away, in the scene's unit, the flakes begin to even out; adds `distance`, which
            follows the viewer (see `gonio.mitsuba.viewer_distance`). None leaves `distance` as it is.

    Raises:
        ValueError: slopes of another shape, or a `fade` that is not above 0.
    """
    import mitsuba as mi

    if slopes.ndim != 3 or slopes.shape[2] != 2:
        raise ValueError(f"slopes have shape {slopes.shape}; needed is (height, width, 2).")
    if fade is not None and not fade > 0:
        raise ValueError(f"fade={fade} is out of range; allowed is above 0.")
    nodes: dict[str, Any] = {
        name: {
            "type": "bitmap",
            "bitmap": mi.Bitmap(np.ascontiguousarray(slopes[..., axis : axis + 1], np.float32)),
            "raw": True,
            "filter_type": "nearest",
            "wrap_mode": "repeat",
            "to_uv": mi.ScalarTransform4f().scale([tiles, tiles, 1]),
        }
        for axis, name in enumerate(("flake_x", "flake_y"))
    }
    if fade is not None:
        nodes["distance"] = {"type": viewer_distance.NAME, "unit": fade}
    return nodes


def write_map(path: str | Path, values: Map) -> None:
    """Write one channel of a map, shape (height, width), as a float32 .exr that `bitmap` reads.

    Raises:
        ValueError: another shape or suffix.
    """

    path = Path(path)
    if path.suffix.lower() != ".exr":
        raise ValueError(f"cannot write {path.name!r}; the suffix must be .exr.")
    if values.ndim != 2:
        raise ValueError(f"the map has shape {values.shape}; needed is (height, width).")
    with replacing(path) as temporary:
        write_linear(temporary, values)


# --- growth --------------------------------------------------------------------------------------------


def growth_map(
    vertices: NDArray[Any],
    faces: NDArray[Any],
    *,
    noise: float = 0.4,
    scale: float = 0.15,
    smoothing: int = 4,
    seed: int = 0,
) -> Map:
    """Where patina grows first on a mesh: 0 in cavities, 1 on ridges, broken up by noise.

    The values are spread evenly over the area: a quarter of it has values below a quarter.

    Args:
        vertices: positions, shape (V, 3).
        faces: triangles, shape (F, 3).
        noise: share of the noise, from 0 (curvature alone) to 1 (noise alone).
        scale: size of the noise's largest blobs, relative to the mesh's diagonal.
        smoothing: how often the curvature is averaged with the neighbours'.
        seed: of the noise.

    Returns:
        One value in [0, 1] for each vertex, shape (V,).

    Raises:
        ValueError: arrays of the wrong shape, or an argument out of its range.
    """
    positions, triangles = np.asarray(vertices, np.float64), np.asarray(faces)
    if positions.ndim != 2 or positions.shape[1] != 3 or triangles.ndim != 2:
        raise ValueError(
            f"vertices and faces have shapes {positions.shape} and {triangles.shape}; "
            "needed are (V, 3) and (F, 3)."
        )
    if not 0 <= noise <= 1:
        raise ValueError(f"noise={noise} is out of range; allowed is 0 to 1.")
    if not scale > 0:
        raise ValueError(f"scale={scale} is out of range; allowed is more than 0.")
    # Seams of uvs and normals double vertices: what lies at one place is one vertex here.
    extent = positions.max(axis=0) - positions.min(axis=0)
    diagonal = float(np.linalg.norm(extent))
    if not diagonal > 0:
        raise ValueError("the mesh has no extent: all its vertices are one point.")
    places, back = np.unique(np.round(positions / diagonal, 7), axis=0, return_inverse=True)
    triangles = back.reshape(-1)[triangles]
    areas = _vertex_areas(places, triangles)
    # Relative to the usual curvature: on a sphere, which has neither cavities nor ridges, noise decides.
    bend = _cavity(places, triangles, smoothing)
    usual = bend[np.argmin(np.abs(_even(bend, areas) - 0.5))]
    cavity = 0.5 + 0.5 * np.tanh(CAVITY_RADIUS * (bend - usual))
    blobs = _even(fractal_noise(places / scale, seed=seed), areas)
    values = _even((1 - noise) * (1 - cavity) + noise * blobs, areas)
    return np.asarray(values[back.reshape(-1)], np.float32)


def growth_texture() -> dict[str, Any]:
    """The texture that reads what `add_growth` put on a mesh."""
    return {"type": "mesh_attribute", "name": ATTRIBUTE}


def add_growth(mesh: Any, values: Map) -> None:
    """Put one value per vertex on a `mitsuba.Mesh`, for `growth_texture`."""
    mesh.add_attribute(ATTRIBUTE, 1, np.ascontiguousarray(values, np.float32))


def growth_picture(size: int = 512, blobs: int = 6, seed: int = 0) -> Map:
    """Growth from noise alone as a picture that tiles, for surfaces with uvs: shape (size, size).

    Args:
        size: pixels along each side.
        blobs: how many of the largest blobs there are along each side.
        seed: the same seed gives the same picture.
    """
    if size < 1 or blobs < 1:
        raise ValueError(f"size={size} and blobs={blobs} must be at least 1.")
    at = (np.arange(size) + 0.5) * blobs / size
    y, x = np.meshgrid(at, at, indexing="ij")
    points = np.stack([x.ravel(), y.ravel(), np.full(x.size, 0.5)], -1)
    values = fractal_noise(points, seed=seed, period=blobs)
    return np.asarray(_even(values, np.ones(x.size)).reshape(size, size), np.float32)


def _vertex_areas(positions: Floats, faces: NDArray[Any]) -> Floats:
    a, b, c = (positions[faces[:, k]] for k in range(3))
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 6
    return np.asarray(
        np.bincount(faces.ravel(), np.repeat(areas, 3), minlength=len(positions)), np.float64
    )


def _cavity(positions: Floats, faces: NDArray[Any], smoothing: int) -> Floats:
    """Positive where a vertex lies below its neighbours, seen along its normal."""
    a, b, c = (positions[faces[:, k]] for k in range(3))
    face_normals = np.cross(b - a, c - a)
    normals = np.stack(
        [
            np.bincount(faces.ravel(), np.repeat(face_normals[:, k], 3), minlength=len(positions))
            for k in range(3)
        ],
        -1,
    )
    normals = normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-30)
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    edges = np.concatenate([edges, edges[:, ::-1]])
    step = positions[edges[:, 1]] - positions[edges[:, 0]]
    length2 = np.maximum(np.einsum("ij,ij->i", step, step), 1e-30)
    # Normal curvature along each edge: 2 (n . step) / |step|^2
    bend = 2 * np.einsum("ij,ij->i", normals[edges[:, 0]], step) / length2
    values = _mean_over_edges(edges, bend, len(positions))
    for _ in range(smoothing):
        values = 0.5 * (
            values + _mean_over_edges(edges, values[edges[:, 1]], len(positions), values)
        )
    return values


def _mean_over_edges(
    edges: NDArray[Any], values: Floats, count: int, alone: Floats | float = 0.0
) -> Floats:
    """Mean of the edges that start at each vertex; `alone` where there are none."""
    number = np.bincount(edges[:, 0], minlength=count)
    total = np.bincount(edges[:, 0], values, minlength=count)
    return np.asarray(np.where(number > 0, total / np.maximum(number, 1), alone))


def _even(values: Floats, areas: Floats) -> Floats:
    """The share of the area that has smaller values, which is spread evenly over [0, 1]."""
    _, group = np.unique(values, return_inverse=True)
    area = np.bincount(group.reshape(-1), areas)
    below = np.cumsum(area) - area / 2
    return np.asarray((below / max(float(area.sum()), 1e-30))[group.reshape(-1)])


def fractal_noise(points: Floats, *, octaves: int = 5, seed: int = 0, period: int = 0) -> Floats:
    """Gradient noise in space, halved in size and strength from octave to octave (Perlin 2002).

    Args:
        points: shape (N, 3), in units of the largest blobs.
        octaves: how many sizes are added.
        seed: of the gradients.
        period: after which x and y repeat; 0 for never.

    Returns:
        About -1 to 1, shape (N,).
    """
    total = np.zeros(len(points))
    for octave in range(octaves):
        frequency = 2**octave
        total += _gradient_noise(points * frequency, seed + octave, period * frequency) / frequency
    return total


def _gradient_noise(points: Floats, seed: int, period: int) -> Floats:
    rng = np.random.default_rng(seed)
    gradients = rng.normal(size=(256, 3))
    gradients /= np.linalg.norm(gradients, axis=1, keepdims=True)
    shuffled = rng.permutation(256)
    cell = np.floor(points).astype(np.int64)
    inside = points - cell
    fade = inside**3 * (inside * (inside * 6 - 15) + 10)
    total = np.zeros(len(points))
    for corner in np.ndindex(2, 2, 2):
        place = cell + corner
        if period:
            place[:, :2] %= period
        key = np.zeros(len(points), np.int64)
        for axis in range(3):
            key = shuffled[(key + place[:, axis]) % 256]
        dots = np.einsum("ij,ij->i", gradients[key], inside - corner)
        total += dots * np.prod(np.where(np.array(corner) == 1, fade, 1 - fade), axis=1)
    return total
