"""Noise taken out of a finished picture by Intel's Open Image Denoise, where mitsuba-oidn is installed.

    gonio.render("gold", spp=32, denoise=True)         # pip install 'gonio[denoise]'

A network guesses what more samples would show, from the picture and from the colours and normals of what
each pixel sees first. It is not the truth: fine texture that neither of these holds, such as the flakes
of a car paint, is smoothed with the noise, and light is moved between neighbouring pixels. For numbers
take pictures without it.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from gonio.materials import Material
from gonio.model import Model, model
from gonio.reference import Stack
from gonio.render.passes import PATHS_PER_PASS, Pixels

# The network is trained on noise that differs from pixel to pixel; a wider filter would smear it to blots.
FILTER = "box"

# Samples of a pixel that say what it sees: their noise is that of edges alone.
SEEN = 8

MISSING = "denoise needs the package mitsuba-oidn; install it with: pip install 'gonio[denoise]'"


def library() -> Any:
    """The package mitsuba-oidn.

    Raises:
        ValueError: it is not installed, or does not fit the Dr.Jit that is.
    """
    try:
        import mitsuba_oidn
    except ImportError as error:
        unfit = "" if isinstance(error, ModuleNotFoundError) else f" ({error})"
        raise ValueError(f"{MISSING}{unfit}.") from None
    return mitsuba_oidn


def stand_in(shown: Model | Material | Stack) -> Model | Material:
    """The colours of a material, seen at once: its albedo may be an integral at every point.

    What grows or has flakes is one colour as well: albedos of patina and car paint at every point take
    minutes. The growth's soft edges are seen in the picture itself, and flakes go with the noise.
    """
    if isinstance(shown, Stack):
        return model("lambert", rho=0.5)
    if isinstance(shown, Material):
        if shown.textures:
            return shown
        shown = shown.model
    rho = np.clip(shown.mean_albedo(), 0, 1).tolist()
    return model("lambert", rho=tuple(rho))


def denoised(pixels: Pixels, colours: Pixels, normals: Pixels) -> Pixels:
    """A picture without its noise; a fourth channel, alpha, stays as it is.

    Args:
        pixels: linear radiance, shape (height, width, 3 or 4), of a film with the filter `FILTER`.
        colours, normals: of what each pixel sees, as `first_seen` has them.

    Raises:
        ValueError: mitsuba-oidn is not installed.
    """
    oidn = library()
    light = np.ascontiguousarray(pixels[..., :3], np.float32)
    calm = np.asarray(oidn.denoise(light, colours, normals, hdr=True))
    return np.concatenate([np.maximum(calm, 0), pixels[..., 3:]], axis=2, dtype=np.float32)


def first_seen(loaded: Any) -> tuple[Pixels, Pixels]:
    """Diffuse colour and shading normal of the first surface in each pixel, (height, width, 3) each.

    loaded: a scene; its first sensor is asked. `stand_in` makes materials whose colours are quickly there.
    """
    import mitsuba as mi

    width, height = (int(n) for n in loaded.sensors()[0].film().crop_size())
    count = max(1, min(SEEN, PATHS_PER_PASS // (width * height)))
    integrator = mi.load_dict({"type": "aov", "aovs": "colour:albedo,normal:sh_normal"})
    # Its channels come after those of the film.
    found = np.array(mi.render(loaded, integrator=integrator, spp=count))[..., -6:]
    found = np.nan_to_num(found, posinf=0, neginf=0)
    colours = np.clip(found[..., :3], 0, 1)
    return np.ascontiguousarray(colours), np.ascontiguousarray(found[..., 3:])
