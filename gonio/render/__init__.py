"""Pictures of models on the shader ball or on the user's mesh; `gonio.render(...)` makes one.

Beside it: `gonio.render.sheets` for several side by side, `gonio.render.user_scene` for the user's own
Mitsuba scene, `gonio.render.picture` for files.
"""

from __future__ import annotations

import dataclasses
import math
import sys
import types
from pathlib import Path
from typing import Any

import numpy as np

from gonio.materials import Material, load
from gonio.model import Model
from gonio.reference import Stack
from gonio.render import denoise as denoising
from gonio.render.diffusion import diffuse_on_screen, reach_in_pixels
from gonio.render.growth import add_to, textured
from gonio.render.passes import Pixels, Progress, integrate, ready_mitsuba
from gonio.render.picture import Picture
from gonio.render.stage import TESTED, shader_ball

Shown = Model | Material | Stack


def render(
    material: Shown | str | Path,
    *,
    environment: str | Path = "studio",
    mesh: str | Path | None = None,
    furnace: bool = False,
    diffusion: float = 0.0,
    sampler: str = "own",
    size: tuple[int, int] = (512, 512),
    spp: int = 64,
    noise: float | None = None,
    seconds: float | None = None,
    clamp: float | None = None,
    denoise: bool = False,
    seed: int = 0,
    progress: Progress | None = None,
    **stage: Any,
) -> Picture:
    """Render a model or material on the shader ball, or on a mesh of the user's.

    Args:
        material: what to show: a model, a material, a stack of layers (which is the truth), or text as
            `gonio.load` takes it.
        environment: "studio", "sun", "front", "side", "white", "sunsky", or a path to .exr or .hdr.
        mesh: a path to .obj, .ply, .stl, .glb or .gltf instead of the ball.
        furnace: put the object into radiance 1 from everywhere; what loses no energy disappears.
        diffusion: how long a millimetre is in the scene's units, to let diffuse light wander on the screen
            as it does in skin, red the farthest (see `gonio.render.diffusion`); 0 leaves it where it is.
        sampler: how paths are continued: by the model's "own" sampler, or "cosine" or "uniform" to see
            the difference in noise. Options of models, such as EON's sampler, choose among their own.
        size: width and height in pixels.
        spp: samples per pixel; with `noise` or `seconds` the most that are taken.
        noise: stop when the picture's noise is at most this, a part of each pixel's brightness: 0.02 looks
            clean (see `gonio.render.passes.Noise`).
        seconds: begin no further pass after that time.
        clamp: cut samples of indirect light above this radiance: fireflies go, and some light with them;
            a notice says how much (see `gonio.render.fireflies`).
        denoise: take the noise out of the finished picture, as `gonio.render.denoise` tells; needs the
            package mitsuba-oidn.
        seed: of the random numbers; the same seed gives the same picture.
        progress: called after each pass.
        stage: further arguments of `gonio.render.stage.shader_ball`, such as up="z".

    Returns:
        Linear RGB radiance, float32, shape (height, width, 3); with transparent=True (height, width, 4),
        colours multiplied by alpha.

    Raises:
        ValueError, FileNotFoundError: one line on what was wrong with an argument or a file.
    """
    if isinstance(material, (str, Path)):
        material = load(material)

    def built(shown: Shown) -> Any:
        return scene(
            shown,
            environment=environment,
            mesh=mesh,
            sampler=sampler,
            size=size,
            furnace=furnace,
            spp=spp,
            **stage,
        )

    if clamp is not None and not 0 < clamp < math.inf:
        raise ValueError(f"clamp={clamp} is out of range; allowed is a finite number above 0.")
    if clamp is not None and furnace:
        raise ValueError(
            "clamp changes nothing in the furnace, where all light is 1; leave it out."
        )
    if clamp is not None and stage.get("max_depth") in (1, 2):
        raise ValueError(
            "clamp changes nothing in paths of at most two segments, which hold no indirect light; leave "
            "it out, or give max_depth 3 and more."
        )
    if denoise:
        denoising.library()  # what is missing is said before the work
        if stage.setdefault("rfilter", denoising.FILTER) != denoising.FILTER:
            raise ValueError(
                f"denoise needs pixels of their own samples alone: rfilter={denoising.FILTER!r}; leave "
                f"rfilter={stage['rfilter']!r} out."
            )
    loaded = built(material)
    until: dict[str, Any] = {"noise": noise, "seconds": seconds, "clamp": clamp}
    alpha = bool(stage.get("transparent"))

    guides = denoising.first_seen(built(denoising.stand_in(material))) if denoise else None

    def finished(pixels: Pixels) -> Pixels:
        return pixels if guides is None else denoising.denoised(pixels, *guides)

    if not diffusion:
        whole = integrate(loaded, spp, seed, progress, alpha=alpha, **until)
        return finished(whole).view(Picture)
    without = built(without_diffuse(material))
    check_diffusion(loaded, diffusion)

    def third(first: int) -> Progress:
        def step(done: int, total: int) -> None:
            if progress is not None:
                progress(first * total + done, 3 * total)

        return step

    full = integrate(loaded, spp, seed, third(0), alpha=alpha, **until)
    glossy = integrate(without, spp, seed, third(1), **until)
    return diffused(finished(full), finished(glossy), loaded, diffusion, third(2))


def scene(
    shown: Shown,
    *,
    environment: str | Path,
    size: tuple[int, int],
    spp: int,
    mesh: str | Path | None = None,
    sampler: str = "own",
    furnace: bool = False,
    **stage: Any,
) -> Any:
    """The scene that `render` renders, loaded; arguments as there."""
    mi = ready_mitsuba()
    from gonio.mitsuba import node

    placed = shader_ball(
        node(shown, sampler),
        textured=textured(shown),
        environment=environment,
        mesh=mesh,
        size=size,
        furnace=furnace,
        spp=spp,
        **stage,
    )
    if isinstance(shown, Material) and shown.grows:
        for name in TESTED:
            if name in placed:
                add_to(placed[name])
    # Mitsuba's optimizations leave lamps in an order that changes from run to run, and so the noise.
    return mi.load_dict(placed, optimize=False)


def check_diffusion(loaded: Any, millimetre: float) -> None:
    """Refuse, before the work, light that would wander farther than is reckoned with.

    Args:
        loaded: the scene.
        millimetre: in the scene's units.

    Raises:
        ValueError: as `gonio.render.diffusion.reach_in_pixels`.
    """
    points, _, surface = _seen(loaded)
    reach_in_pixels(points, surface, millimetre)


def diffused(
    full: Any, glossy: Any, loaded: Any, millimetre: float, progress: Progress | None = None
) -> Picture:
    """A picture whose diffuse light has wandered on the screen.

    Args:
        full: the picture.
        glossy: the same with black diffuse reflection.
        loaded: the scene of either.
        millimetre: in the scene's units.
        progress: called while the light spreads.
    """
    spread = diffuse_on_screen(full[..., :3] - glossy, *_seen(loaded), millimetre, progress)
    return np.concatenate([glossy + spread, full[..., 3:]], axis=2, dtype=np.float32).view(Picture)


def without_diffuse(material: Shown) -> Model | Material:
    """The same with black diffuse reflection."""
    if isinstance(material, Stack):
        raise ValueError(
            "a stack of layers has no diffuse colour whose light diffusion could spread."
        )
    model = material.model if isinstance(material, Material) else material
    named = [path for path, _, _ in model.parameters() if path.rpartition(".")[2] == "rho"]
    black = [path for path in named if _matters(model, path)]
    if not black:
        raise ValueError(
            f"{material.name} has no diffuse colour rho, whose light diffusion could spread."
        )
    model = model.replace(**dict.fromkeys(black, 0.0))
    if not isinstance(material, Material):
        return model
    textures = {path: file for path, file in material.textures.items() if path not in black}
    channels = {path: name for path, name in material.channels.items() if path in textures}
    return dataclasses.replace(material, model=model, textures=textures, channels=channels)


def _matters(model: Model, path: str) -> bool:
    """Whether a colour changes what is reflected: options may leave a model without its matte part."""
    normal = np.array([0.0, 0.0, 1.0])
    values = [model.replace(**{path: colour}).eval(normal, normal) for colour in (0.0, 1.0)]
    return bool((np.asarray(values[0]) != np.asarray(values[1])).any())


def _seen(loaded: Any) -> tuple[Any, Any, Any]:
    """What each pixel's middle shows: the point, the area (up to a factor), the tested shape's number."""
    import mitsuba as mi

    sensor = loaded.sensors()[0]
    width, height = (int(n) for n in sensor.film().size())
    y, x = np.mgrid[0:height, 0:width]
    middle = mi.Point2f(
        ((x.ravel() + 0.5) / width).astype(np.float32),
        ((y.ravel() + 0.5) / height).astype(np.float32),
    )
    ray, _ = sensor.sample_ray(0.0, 0.5, middle, mi.Point2f(0.5))
    si = loaded.ray_intersect(ray)
    surface = np.zeros(width * height, int)
    for number, shape in enumerate(loaded.shapes(), 1):
        if shape.id() in TESTED:
            surface[np.array(si.is_valid() & (si.shape == mi.ShapePtr(shape)))] = number
    # Flat pixels at the rim show much surface, but one sample of it says little.
    cosine = np.maximum(np.abs(np.array(si.wi.z)), 0.2)
    areas = np.where(surface > 0, np.array(si.t), 0) ** 2 / cosine
    points = np.where(surface > 0, np.array(si.p), 0).T
    return (
        points.reshape(height, width, 3),
        areas.reshape(height, width),
        surface.reshape(height, width),
    )


class _Callable(types.ModuleType):
    """This package is the function as well: `gonio.render("gold")` however it was imported."""

    def __call__(self, *arguments: Any, **named: Any) -> Picture:
        return render(*arguments, **named)


sys.modules[__name__].__class__ = _Callable
