"""What the page shows a material on, and in what light: the same shapes and lamps as `gonio render`."""

from __future__ import annotations

import base64
import functools
from pathlib import Path
from typing import Any

import numpy as np

from gonio.mitsuba.textures import growth_map
from gonio.render import light, light_picture
from gonio.render.ball import BALL_CENTRE, CORE_RADIUS, pedestal, shell
from gonio.render.triangles import Triangles

SKY = Path(__file__).parent / "web/assets/sky.npz"

# Coarser than those of `gonio render`: 12,000 triangles, whose edges a page does not show.
SHELL = {"columns": 112, "outer_rows": 28, "inner_rows": 10}
SEGMENTS = 72

# Far enough for the sun's disk to be the same from everywhere on the stage.
SUN_DISTANCE = 1e4


def packed(values: Any, kind: str) -> str:
    """An array as base64 of little-endian numbers, such as "<f4"."""
    return base64.b64encode(np.ascontiguousarray(values, kind).tobytes()).decode("ascii")


def _mesh(mesh: Triangles, growth: Any = None) -> dict[str, Any]:
    """Positions and texture coordinates as sixteen bits over their range, normals over -1 to 1."""
    assert mesh.normals is not None
    low, high = mesh.positions.min(axis=0), mesh.positions.max(axis=0)
    steps = np.round((mesh.positions - low) / np.maximum(high - low, 1e-9) * 65535)
    uvs = np.zeros((len(mesh.positions), 2)) if mesh.uvs is None else mesh.uvs
    reach = max(float(np.abs(uvs).max()), 1.0)
    return {
        "low": low.tolist(),
        "high": high.tolist(),
        "positions": packed(steps, "<u2"),
        "normals": packed(np.round(mesh.normals * 32767), "<i2"),
        "uvs": packed(np.round(uvs / reach * 32767), "<i2"),
        "uv_reach": reach,
        "growth": None if growth is None else packed(np.round(growth * 255), "<u1"),
        "faces": packed(mesh.faces, "<u2"),
    }


@functools.cache
def shapes() -> dict[str, Any]:
    """The meshes of the stage, and the core inside the ball."""
    middle = (0.0, BALL_CENTRE, 0.0)
    ball = shell(**SHELL).moved(middle)
    return {
        "shell": _mesh(ball, growth_map(ball.positions, ball.faces)),
        "pedestal": _mesh(pedestal(SEGMENTS)),
        "core": {"centre": list(middle), "radius": CORE_RADIUS},
        "grounds": {name: _mesh(make(SEGMENTS)) for name, make in light.GROUNDS.items()},
    }


@functools.cache
def environments() -> dict[str, Any]:
    """Lamps, surround and ground of every environment by name."""
    found: dict[str, Any] = {}
    for name, environment in light.ENVIRONMENTS.items():
        surround = environment.surround
        found[name] = {
            "lamps": [
                {
                    "shape": lamp.shape,
                    "centre": lamp.centre.tolist(),
                    "a": lamp.half_axes[0].tolist(),
                    "b": lamp.half_axes[1].tolist(),
                    "area": lamp.area,
                    "radiance": list(lamp.radiance),
                }
                for lamp in environment.lamps.values()
            ],
            "surround": list(surround) if isinstance(surround, tuple) else [surround] * 3,
        }
        ground = environment.ground
        if isinstance(ground, tuple):
            found[name] |= {"ground": None, "groundColour": list(ground)}
        else:
            found[name]["ground"] = ground
        if environment.sky is not None:
            picture, sun = _sky(*environment.sky)
            found[name] |= {"picture": picture}
            found[name]["lamps"].append(sun)
    return found


def fade() -> dict[str, Any]:
    """Where ground fades into what is behind it, and how it gets its colour from a picture of light."""
    return {
        "radii": [light.FADE_FROM, light.FADE_TO],
        "band": list(light_picture.GROUND_BAND),
        "reach": light_picture.GROUND_WIDTH,
        "albedo": list(light_picture.GROUND_ALBEDO),
    }


def _sky(azimuth: float, elevation: float) -> tuple[dict[str, Any], dict[str, Any]]:
    """The sky's picture as `tools/make_view_sky.py` made it, and its sun as a distant disk."""
    with np.load(SKY) as file:
        picture, sun = file["picture"], file["sun"]
    distance, size = SUN_DISTANCE, 2 * SUN_DISTANCE * np.tan(np.radians(light.SUN_APERTURE / 2))
    lamp = light.Lamp(azimuth, elevation, distance, (size, size), 1.0, shape="disk")
    disk = {
        "shape": "disk",
        "centre": lamp.centre.tolist(),
        "a": lamp.half_axes[0].tolist(),
        "b": lamp.half_axes[1].tolist(),
        "area": lamp.area,
        "radiance": sun.tolist(),
    }
    height, width = picture.shape[:2]
    return {"width": width, "height": height, "half": packed(picture, "<f2")}, disk
