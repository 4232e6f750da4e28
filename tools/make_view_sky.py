"""Writes gonio/view/web/assets/sky.npz: Mitsuba's clear sky and its sun, for `gonio view`.

The sky without its sun is smooth, so that a small picture holds it; the sun becomes a disk with the mean
radiance of Mitsuba's. `python tools/make_view_sky.py` makes the file again.
"""

from pathlib import Path
from typing import Any

import numpy as np

import gonio.mitsuba  # noqa: F401  (before Mitsuba: it chooses LLVM)
from gonio.render import light

OUTPUT = Path(__file__).parent.parent / "gonio/view/web/assets/sky.npz"
HEIGHT = 64


def radiance(node: dict[str, Any], directions: Any) -> Any:
    """What comes from some directions, shape (n, 3)."""
    import drjit as dr
    import mitsuba as mi

    emitter = mi.load_dict({"type": "scene", "sky": node}).emitters()[0]
    si = dr.zeros(mi.SurfaceInteraction3f, len(directions))
    si.wi = mi.Vector3f(*(-directions.T.astype(np.float32)))
    return np.array(emitter.eval(si)).T


def sky() -> dict[str, Any]:
    """The picture (its middle at -z), the sun's radiance and direction."""
    import mitsuba as mi

    mi.set_variant("llvm_ad_rgb")
    angles = light.ENVIRONMENTS["sunsky"].sky
    assert angles is not None
    node = light.sky_node(*angles)
    theta = (np.arange(HEIGHT) + 0.5) / HEIGHT * np.pi
    phi = (np.arange(2 * HEIGHT) + 0.5) / HEIGHT * np.pi
    t, p = np.meshgrid(theta, phi, indexing="ij")
    directions = np.stack([-np.sin(t) * np.sin(p), np.cos(t), np.sin(t) * np.cos(p)], -1)
    picture = radiance(node | {"sun_scale": 0.0}, directions.reshape(-1, 3))
    middle = light.direction(*angles)
    across = np.cross(middle, [0.0, 1.0, 0.0])
    across /= np.linalg.norm(across)
    # Mean over the disk: rings of equal area
    rings = np.radians(light.SUN_APERTURE / 2) * np.sqrt((np.arange(64) + 0.5) / 64)
    points = np.cos(rings)[:, None] * middle + np.sin(rings)[:, None] * across
    sun = radiance(node | {"sky_scale": 0.0}, points).mean(axis=0)
    return {
        "picture": picture.reshape(HEIGHT, 2 * HEIGHT, 3).astype(np.float16),
        "sun": sun.astype(np.float32),
    }


if __name__ == "__main__":
    np.savez_compressed(OUTPUT, **sky())
    print(OUTPUT)
