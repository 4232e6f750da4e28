"""harmonics: diffuse light on a rough surface, by scaled spherical harmonics.

Source: Gotanda, "Beyond a simple physically based Blinn-Phong model in real-time", SIGGRAPH 2012 course
"Practical physically based shading in film and game production", Eq. 27 to 29 and the caption of Figure 10.
The course stops at the linear harmonics; the quadratic ones are scaled like these.
"""

from gonio.lang import INV_PI, Color, Vec3, clamp, maximum, select
from gonio.lights.frames import AnyFrame
from gonio.lights.image_light import (
    harmonic_dc_scale,
    harmonic_dc_scale_cheap,
    harmonic_linear_scale,
    harmonic_linear_scale_halved,
)
from gonio.lights.sky import Harmonics, irradiance_bands
from gonio.models.triace_oren_nayar import TriAceOrenNayar

CHOICES = {"dc": ("eq27", "eq28"), "linear": ("eq29", "halved")}


def harmonics(
    model: TriAceOrenNayar,
    frame: AnyFrame,
    wo: Vec3,
    sky: Harmonics,
    dc: str = "eq27",
    linear: str = "eq29",
) -> Color:
    """Radiance towards the viewer of a picture all around, for tri-Ace's Oren-Nayar.

    sky: nine spherical harmonics of the radiance around.
    """
    mu = clamp(wo.z, 0, 1)
    if dc == "eq28":
        constant = harmonic_dc_scale_cheap(mu, model.shininess)
    else:
        constant = harmonic_dc_scale(mu, model.shininess)
    if linear == "halved":
        rest = harmonic_linear_scale_halved(mu, model.shininess)
    else:
        rest = harmonic_linear_scale(mu, model.shininess)
    bands = irradiance_bands(sky, frame.normal)
    light = maximum(constant * bands.constant + rest * (bands.linear + bands.quadratic), 0)
    return select(wo.z > 0, INV_PI * model.rho * light, 0)


FORMS = ((harmonics, ("rho", "shininess", "variant")),)
