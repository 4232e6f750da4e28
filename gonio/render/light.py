"""Light and ground: the stage's own environments, or the user's picture of one."""

from __future__ import annotations

import difflib
from collections.abc import Callable
from pathlib import Path

import numpy as np

from gonio.render.ball import BALL_CENTRE, direction
from gonio.render.triangles import Floats, Triangles, grid_faces, lathe, rounded
from gonio.render.user_mesh import existing, reason

IMAGE_FORMATS = (".exr", ".hdr")
HALF_MAX = 65504.0  # largest half float: what an overflowed sun pixel (inf) stood for


Colour = tuple[float, float, float]
Nodes = dict[str, object]


def rgb(value: Colour | float) -> Nodes:
    """A colour or a grey as a scene node."""
    # Always {"type": "rgb"}: a bare number would be an equal-energy spectrum in spectral variants,
    # which is pink next to the white point of the picture.
    return {"type": "rgb", "value": list(value) if isinstance(value, tuple) else [value] * 3}


def _softbox(
    azimuth: float,
    elevation: float,
    distance: float,
    size: tuple[float, float],
    irradiance: float,
    colour: Colour = (1.0, 1.0, 1.0),
    shape: str = "rectangle",
    share: float = 1.0,
) -> Nodes:
    """A flat lamp (rectangle or disk) turned towards the ball.

    Angles in degrees as in `direction`; size: full width and height; irradiance: what arrives at
    the ball's centre on a surface that faces the lamp (a white Lambertian then shows 1/pi of it).
    share: how often the lamp is chosen for a shadow ray, relative to the others.
    """
    import mitsuba as mi

    centre = np.array([0.0, BALL_CENTRE, 0.0])
    place = centre + distance * direction(azimuth, elevation)
    area = size[0] * size[1] * (1.0 if shape == "rectangle" else np.pi / 4)
    radiance = irradiance * distance**2 / area
    to_world = mi.ScalarTransform4f().look_at(
        origin=place.tolist(), target=centre.tolist(), up=[0, 1, 0]
    ) @ mi.ScalarTransform4f().scale([size[0] / 2, size[1] / 2, 1])
    return {
        "type": shape,
        "to_world": to_world,
        "emitter": {
            "type": "area",
            "radiance": rgb((radiance * colour[0], radiance * colour[1], radiance * colour[2])),
            "sampling_weight": share,
        },
    }


def surround(radiance: float | Colour, share: float = 1.0) -> Nodes:
    """The same radiance from everywhere; share: of the shadow rays, relative to the lamps'."""
    # Beside lamps the share is 0: paths that leave the scene by the material's own sampling find
    # the surround with less noise, and the shadow rays are all left for the lamps.
    return {"type": "constant", "radiance": rgb(radiance), "sampling_weight": share}


GROUND_GREY = 0.32


def _sweep() -> Triangles:
    """The paper backdrop of a studio: floor, curve and wall in one piece, smooth."""
    front, back, length, height, half_width = 14.0, -3.0, 13.0, 16.0, 24.0
    # The slope eases in and out along the curve; a plain quarter circle shows a line at both ends.
    t = np.linspace(0, 1, 97)
    slope = np.pi / 2 * t**2 * (3 - 2 * t)

    def along(speed: Floats) -> Floats:
        steps = (speed[1:] + speed[:-1]) / 2 * length / (len(t) - 1)
        return np.concatenate([[0.0], np.cumsum(steps)])

    rise, run = along(np.sin(slope)), along(np.cos(slope))
    y = np.concatenate([[0.0], rise, [height]])
    z = np.concatenate([[front], back - run, [back - run[-1]]])
    n_y = np.concatenate([[1.0], np.cos(slope), [0.0]])
    n_z = np.concatenate([[0.0], np.sin(slope), [1.0]])
    x = np.array([half_width, -half_width])

    def spread(first: Floats, second: Floats, third: Floats) -> Floats:
        columns = np.broadcast_arrays(first[None, :], second[:, None], third[:, None])
        return np.stack(columns, axis=-1).reshape(-1, 3)

    u, v = np.meshgrid([1.0, 0.0], np.linspace(1, 0, len(y)))
    return Triangles(
        spread(x, y, z),
        grid_faces(len(y), 2, False, False),
        spread(np.zeros(2), n_y, n_z),
        np.stack([u, v], axis=-1).reshape(-1, 2),
    )


def _turntable(radius: float, segments: int = 256) -> Triangles:
    """A flat round slab with its top at y = 0."""
    corners = [(0.0, 0.0, 0.0), (radius, 0.0, 0.03), (radius, -0.1, 0.02), (0.0, -0.1, 0.0)]
    return lathe(*rounded(corners), segments)


def grey(value: float) -> Nodes:
    """A matte material."""
    return {"type": "diffuse", "reflectance": rgb(value)}


def _studio_ground() -> Nodes:
    return {"ground": _sweep().to_mitsuba("ground", grey(GROUND_GREY))}


def _table_ground() -> Nodes:
    return {"ground": _turntable(2.6).to_mitsuba("ground", grey(GROUND_GREY))}


KEY, WARM, COOL = (1.0, 0.975, 0.94), (1.0, 0.94, 0.86), (0.9, 0.95, 1.0)


def _studio() -> Nodes:
    """Big key from the upper left, weak fill from the right, a strip behind for the rim."""
    return {
        "key": _softbox(-54, 42, 6.0, (4.6, 4.6), 2.9, KEY, share=4),
        "fill": _softbox(72, 16, 7.0, (2.4, 6.0), 0.25, COOL),
        "rim": _softbox(128, 48, 7.0, (5.0, 2.0), 1.0, WARM, share=2),
        "surround": surround(0.09, share=0),
        **_studio_ground(),
    }


def _sun() -> Nodes:
    """A hard, warm sun from the side over the studio's dim cool surround."""
    return {
        # 2 degrees across: four times the real sun, so that its shadows' edges are still seen
        "sun": _softbox(-62, 38, 16.0, (0.56, 0.56), 2.8, (1.0, 0.94, 0.85), "disk"),
        "surround": surround((0.08, 0.1, 0.13), share=0),
        **_studio_ground(),
    }


def _front() -> Nodes:
    """One small lamp beside the camera: what flattens a rough diffuse ball into a disk."""
    return {
        "lamp": _softbox(6, 22, 9.0, (1.2, 1.2), 2.6, shape="disk"),
        "surround": surround(0.02, share=0),
        **_studio_ground(),
    }


def _side() -> Nodes:
    """One small lamp at a right angle to the view: what shows the terminator."""
    return {
        "lamp": _softbox(90, 14, 9.0, (1.2, 1.2), 2.6, shape="disk"),
        "surround": surround(0.02, share=0),
        **_studio_ground(),
    }


def _white() -> Nodes:
    """Radiance 1 from everywhere."""
    return {"surround": surround(1.0), **_table_ground()}


def _sunsky() -> Nodes:
    """Mitsuba's sun and clear sky over wide grey ground."""
    import mitsuba as mi

    if "mono" in str(mi.variant()):
        raise ValueError("environment 'sunsky' needs colour; use an rgb or spectral variant")
    sun = direction(-55, 38)
    return {
        "sky": {
            "type": "sunsky",
            "sun_direction": sun.tolist(),
            "turbidity": 3.5,
            "albedo": rgb(GROUND_GREY),
            "sun_aperture": 2.0,
            "to_world": mi.ScalarTransform4f().rotate([1, 0, 0], -90),  # its zenith is +z
            "sky_scale": SKY_SCALE,
            "sun_scale": SKY_SCALE,
        },
        "ground": _turntable(120.0).to_mitsuba("ground", grey(GROUND_GREY)),
    }


SKY_SCALE = 1.7  # brings white in the sun to about 0.9

ENVIRONMENTS: dict[str, Callable[[], Nodes]] = {
    "studio": _studio,
    "sun": _sun,
    "front": _front,
    "side": _side,
    "white": _white,
    "sunsky": _sunsky,
}


def environment_nodes(environment: str | Path, turn: float = 0.0) -> Nodes:
    """Lights and ground as scene nodes, by name (see ENVIRONMENTS) or from an .exr or .hdr file.

    turn: degrees about the vertical by which a picture is turned; its middle is behind the object.
    Infinite pixels count as the largest half float and negative ones as 0. ValueError for an
    unknown name or a file that is no picture, FileNotFoundError for one that does not exist.
    """
    name = str(environment)
    if isinstance(environment, str) and name in ENVIRONMENTS:
        return ENVIRONMENTS[name]()
    if Path(name).suffix == "" and not Path(name).is_file():
        near = difflib.get_close_matches(name, ENVIRONMENTS, n=1)
        guess = f"did you mean {near[0]!r}? Known" if near else "known"
        raise ValueError(
            f"no environment {name!r}; {guess}: {', '.join(ENVIRONMENTS)}, or a path to an "
            f"{' or '.join(IMAGE_FORMATS)} file"
        )
    return {"sky": _picture_light(Path(name), turn), **_table_ground()}


def _picture_light(path: Path, turn: float) -> Nodes:
    import mitsuba as mi

    file = existing(path, "environment", IMAGE_FORMATS)
    try:
        bitmap = mi.Bitmap(str(file)).convert(
            mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, srgb_gamma=False
        )
        pixels = np.array(bitmap, dtype=np.float32)
    except Exception as error:
        raise ValueError(
            f"cannot read environment {file}; is it damaged? The reader says: {reason(error)}"
        ) from error
    if np.isnan(pixels).any():
        raise ValueError(f"environment {file} has NaN pixels; repair it in an image editor")
    pixels = np.clip(pixels, 0, HALF_MAX)
    if min(pixels.shape[:2]) < 2 or not pixels.max() > 0:
        raise ValueError(f"environment {file} has no light in it")
    return {
        "type": "envmap",
        "bitmap": mi.Bitmap(pixels),
        # Mitsuba has the middle of the picture at +z, behind the camera.
        "to_world": mi.ScalarTransform4f().rotate([0, 1, 0], 180 + turn),
    }
