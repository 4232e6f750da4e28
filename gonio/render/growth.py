"""What materials need of the mesh that they are on: texture coordinates, and where patina grows."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np

from gonio.materials import Material


def textured(shown: Any) -> list[str]:
    """What of a material is laid out by texture coordinates."""
    if not isinstance(shown, Material):
        return []
    return [
        *shown.textures,
        *(["the normal map"] if shown.normal_map else []),
        *(["the flakes"] if shown.flakes else []),
    ]


def has_triangles(shape: Any) -> bool:
    """Whether a shape of Mitsuba's holds its triangles; a rectangle does not."""
    import mitsuba as mi

    return "faces" in mi.traverse(shape)


def add_to(mesh: Any) -> None:
    """Put growth on a `mitsuba.Mesh`, for materials that grow in cavities."""
    import mitsuba as mi

    from gonio.mitsuba.textures import add_growth

    buffers = mi.traverse(mesh)
    positions, faces = (np.array(buffers[key]) for key in ("vertex_positions", "faces"))
    add_growth(mesh, _growth(positions.tobytes(), faces.tobytes(), positions.dtype, faces.dtype))


@functools.lru_cache(maxsize=8)  # a second or two each; the steps of a series have the same meshes
def _growth(positions: bytes, faces: bytes, real: Any, integer: Any) -> Any:
    from gonio.mitsuba.textures import growth_map

    return growth_map(
        np.frombuffer(positions, real).reshape(-1, 3), np.frombuffer(faces, integer).reshape(-1, 3)
    )
