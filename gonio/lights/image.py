"""image: light from a picture of the surroundings: two sums for the highlight, harmonics for the rest.

Source: Karis, "Real shading in Unreal Engine 4", SIGGRAPH 2013 course "Physically based shading in theory
and practice". The highlight sees the surroundings as if it were looked at from above, blurred by its width.
"""

from gonio.lang import INV_PI, Color, Vec3, select, vec3
from gonio.lights.frames import AnyFrame
from gonio.lights.lookups import Lookups
from gonio.lights.sky import Harmonics, irradiance
from gonio.model import Model
from gonio.parts.image import Glossy


def image(model: Glossy, frame: AnyFrame, wo: Vec3, sky: Harmonics, host: Lookups) -> Color:
    """Radiance towards the viewer of a picture all around, for a model with a highlight.

    sky: harmonics of the same picture.
    """
    lobes = model.image_lobes(wo.z)
    mirrored = frame.to_world(vec3(-wo.x, -wo.y, wo.z))
    split = host.split_sum(wo.z, lobes.alpha)
    highlight = model.highlight_albedo(split) * host.environment(mirrored, lobes.alpha)
    matte = INV_PI * lobes.matte * irradiance(sky, frame.normal)
    return select(wo.z > 0, highlight + matte, 0)


def image_matte(model: Model, frame: AnyFrame, wo: Vec3, sky: Harmonics) -> Color:
    """Radiance towards the viewer of a picture all around, for a model without a highlight."""
    return INV_PI * model.albedo(wo) * irradiance(sky, frame.normal)


FORMS = ((image, ("image_lobes",)), (image_matte, ("albedo",)))
