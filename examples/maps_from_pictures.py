"""Maps of roughness and colour from pictures, by the gradients of Mitsuba's renderings.

    python examples/maps_from_pictures.py        # makes its own pictures, and finds their maps again

A flat sample is photographed from above in a few known lights. Each texel is seen in all of them, the
highlight passes over it in some, and so its roughness and its colour can be told apart.

docs/maps_from_pictures.md says what to change for pictures of your own.
"""

from __future__ import annotations

import sys
from typing import Any

import gonio.mitsuba  # noqa: F401

# isort: split
# Behind gonio.mitsuba, which finds the LLVM that both need
import drjit as dr
import mitsuba as mi
import numpy as np

TEXELS, PIXELS, STEPS = 8, 32, 120

# Towards the lights: around the mirror direction, where highlights tell the roughness, and low ones.
LIGHTS = (
    (0.0, 0.05, 1.0),
    (0.25, 0.0, 1.0),
    (-0.2, 0.2, 1.0),
    (0.0, -0.4, 1.0),
    (0.7, 0.3, 1.0),
    (-0.6, -0.5, 1.0),
)


def scene(light: tuple[float, float, float], maps: dict[str, Any]) -> Any:
    """A square that fills the picture, in one distant light."""
    textures = {
        name: {
            "type": "bitmap",
            "data": mi.TensorXf(values),
            "raw": True,
            "filter_type": "bilinear",
        }
        for name, values in maps.items()
    }
    film = {"type": "hdrfilm", "width": PIXELS, "height": PIXELS, "rfilter": {"type": "box"}}
    to_world = mi.ScalarTransform4f().look_at([0, 0, 8], [0, 0, 0], [0, 1, 0])
    return mi.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "direct"},
            "sensor": {"type": "perspective", "fov": 14.2, "to_world": to_world, "film": film},
            "light": {"type": "directional", "direction": [-x for x in light], "irradiance": 3.0},
            "sample": {
                "type": "rectangle",
                "bsdf": {"type": "gonio_metallic_roughness", **textures},
            },
        }
    )


def render(scenes: list[Any], maps: dict[str, Any], spp: int = 4) -> list[Any]:
    """A picture in each light, with derivatives by the maps."""
    pictures = []
    for one in scenes:
        params = mi.traverse(one)
        for name, values in maps.items():
            params[f"sample.bsdf.{name}.data"] = values
        params.update()
        pictures.append(mi.render(one, params, spp=spp))
    return pictures


def find_maps(pictures: list[Any], scenes: list[Any], steps: int = STEPS) -> dict[str, Any]:
    """The maps whose renderings are nearest to pictures, by Adam from grey ones."""
    shape = (TEXELS, TEXELS)
    optimiser = mi.ad.Adam(lr=0.05)
    optimiser["roughness"] = mi.TensorXf(np.full((*shape, 1), 0.5))
    optimiser["base_color"] = mi.TensorXf(np.full((*shape, 3), 0.5))
    for step in range(steps):
        maps = {
            "roughness": dr.clip(optimiser["roughness"], 0.1, 1.0),
            "base_color": dr.clip(optimiser["base_color"], 0.0, 1.0),
        }
        # The logarithm lets highlights and the rest count alike, as in gonio fit
        loss = sum(
            dr.mean(dr.square(dr.log(1 + made) - dr.log(1 + seen)), axis=None)
            for made, seen in zip(render(scenes, maps), pictures, strict=True)
        )
        dr.backward(loss)
        optimiser.step()
        for name, low in (("roughness", 0.1), ("base_color", 0.0)):
            optimiser[name] = dr.clip(dr.detach(optimiser[name]), low, 1.0)
        if step in (steps // 2, 3 * steps // 4):
            optimiser.set_learning_rate(0.05 / (2 if step == steps // 2 else 8))
    return {name: np.array(optimiser[name]) for name in ("roughness", "base_color")}


def made_up() -> dict[str, Any]:
    """Maps to be found: a rough stripe on something smoother, and colours that change across it."""
    y, x = np.meshgrid(np.linspace(0, 1, TEXELS), np.linspace(0, 1, TEXELS), indexing="ij")
    roughness = np.where(np.abs(x - y) < 0.3, 0.55, 0.3) + 0.1 * y
    colour = np.stack([0.2 + 0.6 * x, 0.3 + 0.3 * y, 0.7 - 0.5 * x], -1)
    return {
        "roughness": roughness[..., None].astype(np.float32),
        "base_color": colour.astype(np.float32),
    }


def main(steps: int = STEPS) -> dict[str, float]:
    """Make pictures, find their maps, and return the mean errors."""
    mi.set_variant("llvm_ad_rgb")  # which registers the models
    true = made_up()
    flat = {name: np.full_like(values, 0.5) for name, values in true.items()}
    pictures = [dr.detach(mi.render(scene(light, true), spp=16, seed=7)) for light in LIGHTS]
    found = find_maps(pictures, [scene(light, flat) for light in LIGHTS], steps)
    errors = {name: float(np.abs(found[name] - true[name]).mean()) for name in true}
    for name, error in errors.items():
        print(
            f"{name}: off by {error:.3f} on average, {np.abs(true[name] - 0.5).mean():.3f} at the start"
        )
    return errors


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else STEPS)
