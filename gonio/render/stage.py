"""The scene that shows a material: the ball or a mesh, under a light, before a camera."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from gonio.render import passes
from gonio.render.ball import BALL_CENTRE, CORE_RADIUS, direction, pedestal, shell, sphere
from gonio.render.light import Nodes, environment_nodes, grey, rgb, surround
from gonio.render.meshes.uvs import projected
from gonio.render.triangles import Floats
from gonio.render.user_mesh import load_mesh, on_stage, with_normals

MAX_PIXELS = 16384  # per side; more is a slip of the keyboard and would take all memory

TESTED = ("shell", "core", "mesh")  # the shapes that wear the material under test


DEPTH = 12  # a twelfth reflection adds less than noise hides
FURNACE_DEPTH = 256  # at 64 a white cavity still keeps a tenth of its light
FIELD_OF_VIEW = 20.0  # degrees, of the shorter side: a long lens, so that the ball stays round


VIEW = (
    0.0,
    13.0,
)  # azimuth and elevation of the camera, in degrees: from the front, a little above
FROM_ABOVE = 38.0  # elevation of the camera for a plate
FLAT = (0.08, 0.35)  # height over width of a plate, and of what is looked at as the ball is
BALL_DISTANCE = 9.6
FILLED = 0.84  # of the frame's width or height, by a mesh seen in it


def _sensor(
    size: tuple[int, int],
    spp: int,
    place: Floats,
    view: tuple[float, float],
    zoom: float,
    rfilter: str,
) -> Nodes:
    """The camera at a place, looking against the direction of the view's azimuth and elevation."""
    import mitsuba as mi

    azimuth, elevation = view
    towards, up = direction(azimuth, elevation), direction(azimuth, elevation + 90)

    half = np.tan(np.radians(FIELD_OF_VIEW) / 2) / zoom
    return {
        "type": "perspective",
        "fov": float(np.degrees(2 * np.arctan(half))),
        "fov_axis": "smaller",
        "to_world": mi.ScalarTransform4f().look_at(
            origin=place.tolist(), target=(place - towards).tolist(), up=up.tolist()
        ),
        "film": {
            "type": "hdrfilm",
            "width": size[0],
            "height": size[1],
            "pixel_format": "luminance" if "mono" in str(mi.variant()) else "rgb",
            "component_format": "float32",
            "rfilter": {"type": rfilter},
            # Bands of a large picture share the samples at their edges, as its own pixels do.
            "sample_border": size[0] * size[1] > passes.PATHS_PER_PASS,
        },
        # Strata are rows and columns: a square number is not rounded up with a warning.
        "sampler": {"type": "multijitter", "sample_count": (math.isqrt(spp - 1) + 1) ** 2},
    }


def _fitted(points: Floats, view: tuple[float, float], size: tuple[int, int]) -> Floats:
    """From where all points are inside of the frame and reach FILLED of it, across or up; (3,).

    A plane through the camera and an edge of the frame leaves all points on one side: the farthest of
    them along its normal says how far back the camera must be, exactly.
    """
    towards = direction(*view)
    right, up = direction(view[0] + 90, 0), direction(view[0], view[1] + 90)
    depth = points @ -towards  # along the view
    shorter = min(size)
    half = FILLED * np.tan(np.radians(FIELD_OF_VIEW) / 2)
    back = np.inf
    centre = []
    for axis, extent in ((right, size[0]), (up, size[1])):
        slope = half * extent / shorter
        across = points @ axis
        high, low = np.max(across - slope * depth), np.max(-across - slope * depth)
        back = min(back, -(high + low) / (2 * slope))
        centre.append((high - low) / 2)
    # `back` is measured along the view, from the origin: a negative number stands before the object.
    return np.asarray(centre[0] * right + centre[1] * up - back * towards)


def usual_view(points: Floats) -> tuple[float, float]:
    """From where an object is looked at: from higher up, the flatter it is, since its top is what it shows.

    points: of the object on the stage, shape (n, 3), y up.
    """
    across, high, deep = np.ptp(points, axis=0)
    flatness = high / max(across, deep, 1e-30)
    azimuth, elevation = VIEW
    return azimuth, float(np.interp(flatness, FLAT, (FROM_ABOVE, elevation)))


def check_size(size: tuple[int, int]) -> tuple[int, int]:
    """Width and height, or a ValueError for what is no size of a picture."""
    try:
        width, height = (int(s) for s in size)
    except (TypeError, ValueError):
        raise ValueError(f"size must be (width, height) in pixels, not {size!r}") from None
    if not (1 <= width <= MAX_PIXELS and 1 <= height <= MAX_PIXELS):
        raise ValueError(f"size must be 1 to {MAX_PIXELS} pixels a side, not {width} x {height}")
    return width, height


def for_both_sides(bsdf: Any) -> Any:
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
    max_depth: int | None = None,
    up: str = "y",
    turn: float = 0.0,
    uv: str | None = None,
    textured: Sequence[str] = (),
    environment_turn: float = 0.0,
    camera: tuple[float, float] | None = None,
    zoom: float = 1.0,
    ground: bool = True,
    transparent: bool = False,
    rfilter: str = "gaussian",
) -> Nodes:
    """A scene for `mitsuba.load_dict` that shows a material.

    bsdf: a Mitsuba material as a dict. It goes on the shader ball's shell and core, or on the mesh:
    a file that `load_mesh` reads, scaled to the ball's size, `up` its vertical axis ("y" or "z"),
    turned by `turn` degrees; there it is made two-sided, since cloth and scans are open surfaces.
    uv: "box" or "sphere" to project texture coordinates on the mesh in place of its own.
    textured: what on the material needs texture coordinates, for the error where there are none.
    environment: a name in ENVIRONMENTS or an .exr or .hdr file, turned by `environment_turn`
    degrees. size: (width, height) in pixels. spp: samples per pixel the scene asks for.
    max_depth: length of the longest path in segments: 2 is one reflection, 12 the default; in the
    furnace 256.
    camera: azimuth (to the right of the front) and elevation in degrees; by default from the front, a
    little above, and from higher up for a flat mesh (see `usual_view`). zoom: a longer lens.
    ground: False to leave it out. transparent: leave out the ground and what is behind, and give
    the picture an alpha channel.
    rfilter: Mitsuba's filter that makes pixels of samples; "box" keeps their noise independent.
    furnace: only the object, in radiance 1 from everywhere; a material that loses no light cannot
    be seen against the background.

    Set a Mitsuba variant first; the dict holds loaded meshes and belongs to that variant.
    Raises ValueError or FileNotFoundError, one line, for anything that cannot be used.
    """
    import mitsuba as mi

    if mi.variant() is None:
        raise ValueError("no Mitsuba variant is set; call mitsuba.set_variant('llvm_ad_rgb') first")
    size = check_size(size)
    if max_depth is None:
        max_depth = FURNACE_DEPTH if furnace else DEPTH
    if spp < 1 or max_depth < 1:
        raise ValueError(f"spp and max_depth must be at least 1, not {spp} and {max_depth}")
    if furnace and (transparent or not ground or environment_turn):
        raise ValueError(
            "the furnace is radiance 1 from everywhere, without ground, and cannot be turned or left out"
        )
    for name, angle in (("turn", turn), ("environment_turn", environment_turn)):
        if not math.isfinite(angle):
            raise ValueError(f"{name}={angle} is not a finite number of degrees")
    ground = ground and not transparent
    _check_view(camera or VIEW, zoom, ground and not furnace)
    material = mi.load_dict(bsdf)
    scene: Nodes = {"type": "scene"}
    if mesh is None:
        if uv is not None:
            raise ValueError("uv is for a mesh; the shader ball has texture coordinates")
        middle = (0.0, BALL_CENTRE, 0.0)
        scene["shell"] = shell().moved(middle).to_mitsuba("shell", material)
        scene["core"] = sphere(CORE_RADIUS).moved(middle).to_mitsuba("core", material)
        camera = camera or VIEW
        target = np.array([0.0, BALL_CENTRE if furnace else BALL_CENTRE - 0.06, 0.0])
        place = target + BALL_DISTANCE * direction(*camera)
        if not furnace:
            scene["pedestal"] = pedestal().to_mitsuba("pedestal", grey(0.12))
    else:
        shape = with_normals(on_stage(load_mesh(mesh), up, turn))
        if uv is not None:
            shape = projected(shape, uv)
        elif textured and shape.uvs is None:
            raise ValueError(
                f"mesh {mesh} has no texture coordinates, and {' and '.join(textured)} of the material "
                "needs them; use --uv box or --uv sphere to have some"
            )
        scene["mesh"] = shape.to_mitsuba("mesh", for_both_sides(material))
        points = shape.positions[np.unique(shape.faces)]
        camera = camera or usual_view(points)
        place = _fitted(points, camera, size)
    if furnace:
        # Russian roulette would only add noise: nothing is lost, so no path is worth cutting.
        integrator = {"type": "path", "max_depth": max_depth, "rr_depth": max_depth}
        # Shadow rays would add noise too. All go to a lamp that is off, and every path finds the
        # surround by the material's own sampling: exact when that samples without loss.
        scene["surround"] = surround(1.0, share=0)
        scene["off"] = {"type": "point", "position": [0, 9, 0], "intensity": rgb(0.0)}
    else:
        integrator = {"type": "path", "max_depth": max_depth, "rr_depth": 3}
        scene.update(environment_nodes(environment, environment_turn, camera[0]))
    if not ground:
        scene.pop("ground", None)
    scene["integrator"] = integrator
    scene["sensor"] = _sensor(size, spp, place, camera, zoom, rfilter)
    if transparent:
        integrator["hide_emitters"] = True
        scene["sensor"]["film"]["pixel_format"] = "rgba"  # type: ignore[index]
    return scene


def _check_view(camera: tuple[float, float], zoom: float, ground: bool) -> None:
    if not (np.isfinite(camera).all() and -90 <= camera[1] <= 90):
        raise ValueError(
            f"camera is an azimuth and an elevation from -90 to 90 degrees, not {camera}"
        )
    if ground and camera[1] < 0:
        raise ValueError(
            f"a camera at {camera[1]:g} degrees is below the ground and sees nothing; leave the ground out"
        )
    if not 0.05 <= zoom <= 100:
        raise ValueError(f"zoom={zoom} is out of range; allowed is 0.05 to 100")
