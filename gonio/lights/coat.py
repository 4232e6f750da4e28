"""coat: light from a picture on a clear coat, and on what lies below it.

Source: Elek, "Layered materials in real-time rendering", CESCG 2010, Algorithm 1, lines 28 and 29: the coat
mirrors F(mu_o) times the blurred picture. The algorithm ends there; the base is lit here as its own model
would be (`gonio.lights.image`), along the refracted view, through what the coat lets in and out (Eq. 2 to
4). Too bright for rough coats at grazing angles, where F(mu_o) goes to 1 and that of the facets does not.
"""

from gonio.lang import INV_PI, Color, Vec3, maximum, minimum, select, vec3
from gonio.lights.frames import AnyFrame
from gonio.lights.lookups import Lookups
from gonio.lights.sky import Harmonics, irradiance
from gonio.models.weidlich_wilkie import WeidlichWilkie
from gonio.parts.image import CoatedGloss, Surfaced


def coat(model: CoatedGloss, frame: AnyFrame, wo: Vec3, sky: Harmonics, host: Lookups) -> Color:
    """Radiance towards the viewer of a picture all around, for a coat over a base with a highlight.

    sky: nine spherical harmonics of the radiance around. The table is that of the base's highlight.
    """
    layer = model.image_coat(wo)
    mirrored = frame.to_world(vec3(-wo.x, -wo.y, wo.z))
    surface = layer.reflected * host.environment(mirrored, model.alpha)
    lobes = model.base.image_lobes(layer.below.z)
    alpha = maximum(lobes.alpha, layer.alpha_below)
    split = host.split_sum(layer.below.z, alpha)
    # Refraction widens the highlight by eta, and what leaves the base too flat is reflected totally: of
    # GGX's facets t / (t + alpha^2) are less steep than the root of t.
    seen = host.environment(mirrored, minimum(model.eta * alpha, 1))
    kept = layer.cone * (1 + alpha * alpha) / (layer.cone + alpha * alpha)
    glossy = model.base.highlight_albedo(split) * kept * seen
    matte = INV_PI * lobes.matte * irradiance(sky, frame.normal)
    return select(wo.z > 0, surface + layer.glossy * glossy + layer.matte * matte, 0)


def coat_matte(
    model: WeidlichWilkie, frame: AnyFrame, wo: Vec3, sky: Harmonics, host: Lookups
) -> Color:
    """Radiance towards the viewer of a picture all around, for a coat over a matte base.

    sky: nine spherical harmonics of the radiance around.
    """
    layer = model.image_coat(wo)
    mirrored = frame.to_world(vec3(-wo.x, -wo.y, wo.z))
    surface = layer.reflected * host.environment(mirrored, model.alpha)
    matte = INV_PI * model.base.albedo(layer.below) * irradiance(sky, frame.normal)
    return select(wo.z > 0, surface + layer.matte * matte, 0)


def coat_alone(model: Surfaced, frame: AnyFrame, wo: Vec3, host: Lookups) -> Color:
    """Radiance towards the viewer of a picture all around, which the coat alone mirrors (Elek, line 29)."""
    surface = model.image_surface(wo.z)
    mirrored = frame.to_world(vec3(-wo.x, -wo.y, wo.z))
    return select(wo.z > 0, surface.reflected * host.environment(mirrored, surface.alpha), 0)


FORMS = (
    (coat, ("image_coat", "base.image_lobes")),
    (coat_matte, ("image_coat", "base.albedo")),
    (coat_alone, ("image_surface",)),
)
