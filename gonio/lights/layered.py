"""layered: light from a picture on tri-Ace's two layers, one above the other.

Source: Gotanda, "Beyond a simple physically based Blinn-Phong model in real-time", SIGGRAPH 2012 course
"Practical physically based shading in film and game production", Eq. 5 to 9, and 27 and 29 for a rough
matte part. F of the upper layer is Schlick's at the viewer's cosine; the lower one's is Eq. 5's constant.
"""

from gonio.lang import INV_PI, Color, Vec3, clamp, maximum, select, vec3
from gonio.lights.frames import AnyFrame
from gonio.lights.image_light import (
    diffuse_image_absorption,
    harmonic_dc_scale,
    harmonic_linear_scale,
    specular_image_absorption,
)
from gonio.lights.lookups import Lookups
from gonio.lights.sky import Harmonics, irradiance_bands
from gonio.models.triace_layered import TriAceLayered
from gonio.parts.coat import optical_depth
from gonio.parts.distribution import blinn_phong_alpha
from gonio.parts.fresnel import F_schlick, f0_between, f0_from_eta


def layered(
    model: TriAceLayered, frame: AnyFrame, wo: Vec3, sky: Harmonics, host: Lookups
) -> Color:
    """Radiance towards the viewer of a picture all around, for tri-Ace's layers.

    sky: nine spherical harmonics of the radiance around.
    """
    mu = clamp(wo.z, 0, 1)
    mirrored = frame.to_world(vec3(-wo.x, -wo.y, wo.z))
    f0 = f0_from_eta(model.top_eta)
    F_top = F_schlick(mu, f0, 1)
    F_bottom = f0_between(model.top_eta, model.bottom_eta) * (1 - f0)
    T = 1 - F_top if model.top_transmission == "on" else 1
    depth = optical_depth(model.sigma_a, model.thickness)
    top = F_top * host.environment(mirrored, blinn_phong_alpha(model.top_shininess))

    seen = host.environment(mirrored, blinn_phong_alpha(model.bottom_shininess))
    glossy = T * F_bottom * specular_image_absorption(depth, mu) * seen
    bands = irradiance_bands(sky, frame.normal)
    if model.diffuse == "oren_nayar":
        constant = harmonic_dc_scale(mu, model.bottom_shininess) * bands.constant
        rest = harmonic_linear_scale(mu, model.bottom_shininess)
        light = constant + rest * (bands.linear + bands.quadratic)
    else:
        light = bands.constant + bands.linear + bands.quadratic
    matte = T * (1 - F_bottom) * INV_PI * model.rho * maximum(light, 0)
    below = glossy + matte * diffuse_image_absorption(depth, mu)
    return select(wo.z > 0, top + below, 0)


FORMS = ((layered, ("top_shininess", "bottom_shininess")),)
