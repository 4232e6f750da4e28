"""directional: one light from a known direction, such as the sun or a lamp that is far away.

Source: the rendering equation for one direction, f mu_i E.
"""

from gonio.lang import Color, Vec3, maximum
from gonio.lights.frames import AnyFrame
from gonio.model import Model


def directional(model: Model, frame: AnyFrame, wo: Vec3, light: Vec3, irradiance: Color) -> Color:
    """Radiance towards the viewer of one directional light.

    light: towards it, unit, in the world. irradiance: what a surface that faces it receives, linear RGB
    (an engine whose lights have an intensity I and whose shaders return pi f mu_i means pi I).
    """
    wi = frame.to_local(light)
    return model.eval(wi, wo) * (irradiance * maximum(wi.z, 0))


FORMS = ((directional, ("eval",)),)
