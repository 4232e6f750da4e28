"""The Blinn–Phong highlight of tri-Ace, of which its layers are made.

Source: Gotanda, "Beyond a simple physically based Blinn-Phong model in real-time", SIGGRAPH 2012 course
"Practical physically based shading in film and game production", Eq. 1.
"""

from gonio.lang import Float, Vec3, maximum
from gonio.parts.lobes import cos_power

# Eq. 1: the normalisation as a linear function of n.
NORM_SLOPE, NORM_OFFSET = 0.0397436, 0.0856832


def blinn_phong_highlight(wi: Vec3, wo: Vec3, shininess: Float) -> Float:
    """(0.0397436 n + 0.0856832) (N.H)^n / max(mu_i, mu_o): Eq. 1's highlight without Fresnel."""
    power = cos_power(wi + wo, shininess)
    return (NORM_SLOPE * shininess + NORM_OFFSET) * power / maximum(wi.z, wo.z)
