"""ambient: the same light from everywhere, with a table of what the highlight reflects of it.

Source: Gotanda, "Practical implementation of physically-based shading models at tri-Ace", SIGGRAPH 2010
course "Physically-based shading models in film and game production": AmbientBRDF, the directional albedo as
a table over N.E and shininess.
"""

from gonio.lang import Color, Vec3, select
from gonio.lights.frames import AnyFrame
from gonio.lights.lookups import Lookups
from gonio.model import Model
from gonio.parts.image import Glossy


def ambient(model: Glossy, frame: AnyFrame, wo: Vec3, radiance: Color, host: Lookups) -> Color:
    """Radiance towards the viewer of a uniform surrounding, for a model with a highlight.

    radiance: of the surrounding, linear RGB.
    """
    lobes = model.image_lobes(wo.z)
    highlight = model.highlight_albedo(host.split_sum(wo.z, lobes.alpha))
    return select(wo.z > 0, (highlight + lobes.matte) * radiance, 0)


def ambient_matte(model: Model, frame: AnyFrame, wo: Vec3, radiance: Color) -> Color:
    """Radiance towards the viewer of a uniform surrounding, for a model without a highlight."""
    return model.albedo(wo) * radiance


FORMS = ((ambient, ("image_lobes",)), (ambient_matte, ("albedo",)))
