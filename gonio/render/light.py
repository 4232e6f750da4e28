"""Light and ground: the stage's own environments, or the user's picture of one."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from gonio.images import Pixels
from gonio.messages import did_you_mean
from gonio.render.ball import BALL_CENTRE, direction
from gonio.render.light_picture import IMAGE_FORMATS, exposure, ground_colour, read_light
from gonio.render.triangles import Floats, Triangles, grid_faces, lathe
from gonio.render.user_mesh import existing

Colour = tuple[float, float, float]
Nodes = dict[str, object]


def rgb(value: Colour | float) -> Nodes:
    """A colour or a grey as a scene node."""
    # Always {"type": "rgb"}: a bare number would be an equal-energy spectrum in spectral variants,
    # which is pink next to the white point of the picture.
    return {"type": "rgb", "value": list(value) if isinstance(value, tuple) else [value] * 3}


@dataclass(frozen=True)
class Lamp:
    """A flat lamp (rectangle or disk) turned towards the ball.

    Angles in degrees as in `direction`; size: full width and height; irradiance: what arrives at
    the ball's centre on a surface that faces the lamp (a white Lambertian then shows 1/pi of it).
    share: how often the lamp is chosen for a shadow ray, relative to the others.
    """

    azimuth: float
    elevation: float
    distance: float
    size: tuple[float, float]
    irradiance: float
    colour: Colour = (1.0, 1.0, 1.0)
    shape: str = "rectangle"
    share: float = 1.0

    @property
    def centre(self) -> Floats:
        """Where it is."""
        middle = np.array([0.0, BALL_CENTRE, 0.0])
        return middle + self.distance * direction(self.azimuth, self.elevation)

    @property
    def half_axes(self) -> tuple[Floats, Floats]:
        """From the centre to two edges; their cross product points where the lamp shines."""
        forward = -direction(self.azimuth, self.elevation)
        left = np.cross([0.0, 1.0, 0.0], forward)
        left /= np.linalg.norm(left)
        return self.size[0] / 2 * left, self.size[1] / 2 * np.cross(forward, left)

    @property
    def area(self) -> float:
        """Of the lamp's face."""
        return self.size[0] * self.size[1] * (1.0 if self.shape == "rectangle" else np.pi / 4)

    @property
    def radiance(self) -> Colour:
        """In every direction in front of it."""
        r, g, b = self.colour
        grey = self.irradiance * self.distance**2 / self.area
        return grey * r, grey * g, grey * b

    def to_mitsuba(self) -> Nodes:
        """The lamp as a scene node."""
        import mitsuba as mi

        to_world = mi.ScalarTransform4f().look_at(
            origin=self.centre.tolist(), target=[0, BALL_CENTRE, 0], up=[0, 1, 0]
        ) @ mi.ScalarTransform4f().scale([self.size[0] / 2, self.size[1] / 2, 1])
        return {
            "type": self.shape,
            "to_world": to_world,
            "emitter": {
                "type": "area",
                "radiance": rgb(self.radiance),
                "sampling_weight": self.share,
            },
        }


def surround(radiance: float | Colour, share: float = 1.0) -> Nodes:
    """The same radiance from everywhere; share: of the shadow rays, relative to the lamps'."""
    # Beside lamps the share is 0: paths that leave the scene by the material's own sampling find
    # the surround with less noise, and the shadow rays are all left for the lamps.
    return {"type": "constant", "radiance": rgb(radiance), "sampling_weight": share}


GROUND_GREY = 0.32


def sweep(steps: int = 96) -> Triangles:
    """The paper backdrop of a studio: floor, curve (in so many steps) and wall in one piece, smooth."""
    front, back, length, height, half_width = 14.0, -3.0, 13.0, 16.0, 24.0
    # The slope eases in and out along the curve; a plain quarter circle shows a line at both ends.
    t = np.linspace(0, 1, steps + 1)
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


def disk(radius: float, segments: int = 256) -> Triangles:
    """A flat round plate at y = 0; v runs from its middle to its rim."""
    profile = np.array([(0.0, 0.0), (radius, 0.0)])
    return lathe(profile, np.array([(0.0, 1.0), (0.0, 1.0)]), segments)


# Radii between which ground fades into what is behind it: outside of what an object shades.
FADE_FROM, FADE_TO = 1.7, 6.5


def fading_ground(colour: Colour) -> Any:
    """Matte ground around the object that dissolves into the light behind it, without an edge."""
    import mitsuba as mi

    r = np.linspace(0, FADE_TO, 512)
    t = np.clip((r - FADE_FROM) / (FADE_TO - FADE_FROM), 0, 1)
    opacity = (
        1 - t * t * (3 - 2 * t)
    ) ** 2  # most of the way is thin, where it is seen at grazing angles
    texture = {
        "type": "bitmap",
        "bitmap": mi.Bitmap(opacity.astype(np.float32)[:, None, None]),
        "raw": True,
        "wrap_mode": "clamp",
    }
    matte = {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": rgb(colour)}}
    mask = {"type": "mask", "opacity": texture, "bsdf": matte}
    return disk(FADE_TO).to_mitsuba("ground", mask)


def grey(value: float) -> Nodes:
    """A matte material."""
    return {"type": "diffuse", "reflectance": rgb(value)}


# Grounds that are meshes; the argument is how finely their curves are divided.
GROUNDS: dict[str, Callable[..., Triangles]] = {
    "sweep": sweep,
    "plain": functools.partial(disk, 120.0),
}

KEY, WARM, COOL = (1.0, 0.975, 0.94), (1.0, 0.94, 0.86), (0.9, 0.95, 1.0)


@dataclass(frozen=True)
class Environment:
    """Lamps by name, what surrounds all, the ground; or a clear sky with its sun."""

    lamps: Mapping[str, Lamp] = field(default_factory=dict)
    surround: Colour | float = 0.0
    ground: str | Colour = "sweep"
    """One of GROUNDS, or the colour of one that fades into what is behind it."""
    sky: tuple[float, float] | None = None
    """Azimuth and elevation of the sun of Mitsuba's sky."""


ENVIRONMENTS: dict[str, Environment] = {
    # Big key from the upper left, weak fill from the right, a strip behind for the rim
    "studio": Environment(
        {
            "key": Lamp(-54, 42, 6.0, (4.6, 4.6), 2.9, KEY, share=4),
            "fill": Lamp(72, 16, 7.0, (2.4, 6.0), 0.25, COOL),
            "rim": Lamp(128, 48, 7.0, (5.0, 2.0), 1.0, WARM, share=2),
        },
        surround=0.09,
    ),
    # A hard, warm sun from the side over the studio's dim cool surround. 2 degrees across: four times the
    # real sun, so that its shadows' edges are still seen
    "sun": Environment(
        {"sun": Lamp(-62, 38, 16.0, (0.56, 0.56), 2.8, (1.0, 0.94, 0.85), "disk")},
        surround=(0.08, 0.1, 0.13),
    ),
    # One small lamp beside the camera: what flattens a rough diffuse ball into a disk
    "front": Environment({"lamp": Lamp(6, 22, 9.0, (1.2, 1.2), 2.6, shape="disk")}, surround=0.02),
    # One small lamp at a right angle to the view: what shows the terminator
    "side": Environment({"lamp": Lamp(90, 14, 9.0, (1.2, 1.2), 2.6, shape="disk")}, surround=0.02),
    # Radiance 1 from everywhere
    "white": Environment(surround=1.0, ground=(0.85, 0.85, 0.85)),
    # Mitsuba's sun and clear sky over wide grey ground
    "sunsky": Environment(sky=(-55, 38), ground="plain"),
}

SKY_SCALE = 1.7  # brings white in the sun to about 0.9
SUN_APERTURE = 2.0  # degrees


def sky_node(azimuth: float, elevation: float) -> Nodes:
    """Mitsuba's clear sky with the sun at these angles."""
    import mitsuba as mi

    if "mono" in str(mi.variant()):
        raise ValueError("environment 'sunsky' needs colour; use an rgb or spectral variant")
    return {
        "type": "sunsky",
        "sun_direction": direction(azimuth, elevation).tolist(),
        "turbidity": 3.5,
        "albedo": rgb(GROUND_GREY),
        "sun_aperture": SUN_APERTURE,
        "to_world": mi.ScalarTransform4f().rotate([1, 0, 0], -90),  # its zenith is +z
        "sky_scale": SKY_SCALE,
        "sun_scale": SKY_SCALE,
    }


def _nodes(environment: Environment) -> Nodes:
    nodes: Nodes = {name: lamp.to_mitsuba() for name, lamp in environment.lamps.items()}
    if environment.sky is not None:
        nodes["sky"] = sky_node(*environment.sky)
    else:
        nodes["surround"] = surround(environment.surround, share=0 if nodes else 1)
    ground = environment.ground
    if isinstance(ground, tuple):
        return nodes | {"ground": fading_ground(ground)}
    return nodes | {"ground": GROUNDS[ground]().to_mitsuba("ground", grey(GROUND_GREY))}


def environment_nodes(environment: str | Path, turn: float = 0.0, view: float = 0.0) -> Nodes:
    """Lights and ground as scene nodes, by name (see ENVIRONMENTS) or from an .exr or .hdr file.

    turn: degrees about the vertical by which a picture is turned; its middle is behind the object.
    view: azimuth of the camera in degrees; the ground gets the colour of what is seen behind it.
    ValueError for an unknown name or a file that is no picture (see `read_light`), FileNotFoundError
    for one that does not exist.
    """
    name = str(environment)
    if is_own(environment):
        if turn:
            raise ValueError(f"environment {name!r} is not a picture that could be turned")
        return _nodes(ENVIRONMENTS[name])
    pixels = picture_of(environment)
    return {
        "sky": _picture_light(pixels, turn),
        "ground": fading_ground(ground_colour(pixels, turn - view)),
    }


def auto_exposure(environment: str | Path) -> float:
    """Stops that bring white in this light to 0.9: 0 for gonio's own, which are made so."""
    return 0.0 if is_own(environment) else exposure(picture_of(environment))


def is_own(environment: str | Path) -> bool:
    """Whether this is the name of one of gonio's own environments, not a file."""
    return isinstance(environment, str) and environment in ENVIRONMENTS


def picture_of(environment: str | Path) -> Pixels:
    """The radiance of an environment file; errors as `environment_nodes` has them."""
    name = str(environment)
    if Path(name).suffix == "" and not Path(name).is_file():
        raise ValueError(
            f"no environment {name!r}; {did_you_mean(name, ENVIRONMENTS)}known are "
            f"{', '.join(ENVIRONMENTS)}, or a path to an "
            f"{' or '.join(IMAGE_FORMATS)} file"
        )
    return read_light(existing(name, "environment", IMAGE_FORMATS))


def _picture_light(pixels: Pixels, turn: float) -> Nodes:
    import mitsuba as mi

    return {
        "type": "envmap",
        "bitmap": mi.Bitmap(pixels.copy()),  # it takes no arrays that are read-only
        # Mitsuba has the middle of the picture at +z, behind the camera.
        "to_world": mi.ScalarTransform4f().rotate([0, 1, 0], 180 + turn),
    }
