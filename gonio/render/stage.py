"""The scene that shows a material: the ball or a mesh, under a light, before a camera."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from gonio.render.ball import BALL_CENTRE, CORE_RADIUS, direction, pedestal, shell, sphere
from gonio.render.light import Nodes, environment_nodes, grey, rgb, surround
from gonio.render.user_mesh import load_mesh, on_stage, with_normals

MAX_PIXELS = 16384  # per side; more is a slip of the keyboard and would take all memory

TESTED = ("shell", "core", "mesh")  # the shapes that wear the material under test


FURNACE_DEPTH = 256  # at 64 a white cavity still keeps a tenth of its light
FIELD_OF_VIEW = 20.0  # degrees, of the shorter side: a long lens, so that the ball stays round


def _sensor(size: tuple[int, int], spp: int, target: float) -> Nodes:
    """Looks down a little at (0, target, 0)."""
    import mitsuba as mi

    middle = np.array([0.0, target, 0.0])
    place = middle + 9.6 * direction(0, 13)
    return {
        "type": "perspective",
        "fov": FIELD_OF_VIEW,
        "fov_axis": "smaller",
        "to_world": mi.ScalarTransform4f().look_at(
            origin=place.tolist(), target=middle.tolist(), up=[0, 1, 0]
        ),
        "film": {
            "type": "hdrfilm",
            "width": size[0],
            "height": size[1],
            "pixel_format": "luminance" if "mono" in str(mi.variant()) else "rgb",
            "component_format": "float32",
            "rfilter": {"type": "gaussian"},
        },
        "sampler": {"type": "multijitter", "sample_count": spp},
    }


def _check_size(size: tuple[int, int]) -> tuple[int, int]:
    try:
        width, height = (int(s) for s in size)
    except (TypeError, ValueError):
        raise ValueError(f"size must be (width, height) in pixels, not {size!r}") from None
    if not (1 <= width <= MAX_PIXELS and 1 <= height <= MAX_PIXELS):
        raise ValueError(f"size must be 1 to {MAX_PIXELS} pixels a side, not {width} x {height}")
    return width, height


def _for_both_sides(bsdf: Any) -> Any:
    """The BSDF, made two-sided unless it lets light through."""
    import mitsuba as mi

    transmits = mi.has_flag(bsdf.flags(), mi.BSDFFlags.Transmission)
    if transmits or mi.has_flag(bsdf.flags(), mi.BSDFFlags.Null):
        return bsdf
    back = any(
        mi.has_flag(bsdf.flags(k), mi.BSDFFlags.BackSide) for k in range(bsdf.component_count())
    )
    return bsdf if back else mi.load_dict({"type": "twosided", "material": bsdf})


def shader_ball(
    bsdf: dict[str, object],
    *,
    environment: str | Path = "studio",
    mesh: str | Path | None = None,
    size: tuple[int, int] = (512, 512),
    furnace: bool = False,
    spp: int = 64,
    max_depth: int = 12,
    up: str = "y",
    turn: float = 0.0,
    environment_turn: float = 0.0,
) -> Nodes:
    """A scene for `mitsuba.load_dict` that shows a material.

    bsdf: a Mitsuba material as a dict. It goes on the shader ball's shell and core, or on the mesh:
    an .obj, .ply or .glb file, scaled to the ball's size, `up` its vertical axis ("y" or "z"),
    turned by `turn` degrees; there it is made two-sided, since cloth and scans are open surfaces.
    environment: a name in ENVIRONMENTS or an .exr or .hdr file, turned by `environment_turn`
    degrees. size: (width, height) in pixels. spp: samples per pixel the scene asks for.
    furnace: only the object, in radiance 1 from everywhere; a material that loses no light cannot
    be seen against the background.

    Set a Mitsuba variant first; the dict holds loaded meshes and belongs to that variant.
    Raises ValueError or FileNotFoundError, one line, for anything that cannot be used.
    """
    import mitsuba as mi

    if mi.variant() is None:
        raise ValueError("no Mitsuba variant is set; call mitsuba.set_variant('llvm_ad_rgb') first")
    size = _check_size(size)
    if spp < 1 or max_depth < 1:
        raise ValueError(f"spp and max_depth must be at least 1, not {spp} and {max_depth}")
    material = mi.load_dict(bsdf)
    scene: Nodes = {"type": "scene"}
    if mesh is None:
        middle = (0.0, BALL_CENTRE, 0.0)
        scene["shell"] = shell().moved(middle).to_mitsuba("shell", material)
        scene["core"] = sphere(CORE_RADIUS).moved(middle).to_mitsuba("core", material)
        target = BALL_CENTRE if furnace else BALL_CENTRE - 0.06
        if not furnace:
            scene["pedestal"] = pedestal().to_mitsuba("pedestal", grey(0.12))
    else:
        shape = with_normals(on_stage(load_mesh(mesh), up, turn))
        scene["mesh"] = shape.to_mitsuba("mesh", _for_both_sides(material))
        target = float(shape.positions[np.unique(shape.faces), 1].max()) / 2
    if furnace:
        # Russian roulette would only add noise: nothing is lost, so no path is worth cutting.
        integrator = {"type": "path", "max_depth": FURNACE_DEPTH, "rr_depth": FURNACE_DEPTH}
        # Shadow rays would add noise too. All go to a lamp that is off, and every path finds the
        # surround by the material's own sampling: exact when that samples without loss.
        scene["surround"] = surround(1.0, share=0)
        scene["off"] = {"type": "point", "position": [0, 9, 0], "intensity": rgb(0.0)}
    else:
        integrator = {"type": "path", "max_depth": max_depth, "rr_depth": 3}
        scene.update(environment_nodes(environment, environment_turn))
    scene["integrator"] = integrator
    scene["sensor"] = _sensor(size, spp, target)
    return scene
