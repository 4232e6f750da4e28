"""Directions and the frames that they are given in: azimuths, half vectors, mirrored directions.

Source of `pdf_mirror`: Walter, Marschner, Li, Torrance, "Microfacet models for refraction through rough
surfaces", EGSR 2007.
"""

from gonio.lang import Float, Vec2, Vec3, dot, fma, maximum, select, sqrt, vec2, vec3

# Below this squared sine the azimuth of wo is taken as 0: any azimuth is right there, and the square
# of its reciprocal still fits into a float32.
SIN2_MIN = 1e-18

# wi + wo is as short as 2e-18 where light and viewer are opposite and hardly above the horizon. The squares
# of its tangential part are numbers that threads of LLVM and GPUs take for 0, unless it is so much longer.
LENGTHENED = 2.0**40


def azimuth(wo: Vec3) -> Vec2:
    """Cosine and sine of wo's azimuth; (1, 0) at normal incidence."""
    sin2 = wo.x * wo.x + wo.y * wo.y
    tilted = sin2 > SIN2_MIN
    inv = 1 / sqrt(maximum(sin2, SIN2_MIN))
    return vec2(select(tilted, wo.x * inv, 1), select(tilted, wo.y * inv, 0))


def from_frame(w: Vec3, axis: Vec2) -> Vec3:
    """A direction given relative to an azimuth (cosine, sine), about the normal turned by it."""
    return vec3(axis.x * w.x - axis.y * w.y, axis.y * w.x + axis.x * w.y, w.z)


def to_frame(w: Vec3, axis: Vec2) -> Vec3:
    """A direction relative to an azimuth (cosine, sine): the inverse of `from_frame`."""
    return vec3(axis.x * w.x + axis.y * w.y, axis.x * w.y - axis.y * w.x, w.z)


def tangential_dot(wi: Vec3, wo: Vec3) -> Float:
    """s = cos(phi_i - phi_o) sin(theta_i) sin(theta_o), the inner product of the tangential parts.

    It is divided by cosines that may be tiny, so its last bits count: the rounding error of one
    product is carried along (Kahan), which plain wi.x wo.x + wi.y wo.y or dot(wi, wo) - mu_i mu_o loses.
    """
    q = wi.y * wo.y
    error = fma(wi.y, wo.y, -q)
    return fma(wi.x, wo.x, q) + error


def tangential_cross(wi: Vec3, wo: Vec3) -> Float:
    """sin(phi_o - phi_i) sin(theta_i) sin(theta_o), as exact as `tangential_dot`."""
    q = wi.y * wo.x
    error = fma(wi.y, wo.x, -q)
    return fma(wi.x, wo.y, -q) - error


def length2(h: Vec3) -> Float:
    """Squared length, added up from the tangential part, which is of use by itself: shaders share it."""
    return (h.x * h.x + h.y * h.y) + h.z * h.z


def half_vector(wi: Vec3, wo: Vec3) -> Vec3:
    """The normal m of the facets that mirror wi into wo: (wi + wo) / |wi + wo|."""
    h = LENGTHENED * (wi + wo)
    return h / sqrt(length2(h))  # the root is the cosine's as well


def slopes(h: Vec3) -> Vec2:
    """Of the facet whose normal is along h, which is above the horizon and need not be unit."""
    inv = 1 / h.z
    return vec2(h.x * inv, h.y * inv)


def tangent2(h: Vec3) -> Float:
    """Squared tangent of that facet's angle."""
    t = slopes(h)
    return t.x * t.x + t.y * t.y


def cos_half(wi: Vec3, wo: Vec3) -> Float:
    """wo . m = wi . m, the cosine at which light meets the facet: half the length of wi + wo."""
    # 2 (wo . m)^2 = 1 + wi . wo, but the sum of 1 and a scalar product near -1 has few digits left.
    return half_length(wi, wo)


def cos_half_value(wi: Vec3, wo: Vec3) -> Float:
    """wo . m = wi . m, the cosine at which light meets the facet: half the length of wi + wo."""
    # 2 (wo . m)^2 = 1 + wi . wo, but the sum of 1 and a scalar product near -1 has few digits left.
    return 0.5 * sqrt(length2(wi + wo))


def half_length(wi: Vec3, wo: Vec3) -> Float:
    """|wi + wo| / 2, the same with all digits however short it is: for what is divided by it."""
    return (0.5 / LENGTHENED) * sqrt(length2(LENGTHENED * (wi + wo)))


def sin2_half(wi: Vec3, wo: Vec3) -> Float:
    """1 - cos_half^2, the squared sine at which light meets the facet: of half the length of wi - wo."""
    apart = wi - wo
    return 0.25 * dot(apart, apart)


def mirror(wo: Vec3, m: Vec3) -> Vec3:
    """wo mirrored at a facet with normal m; it may leave below the horizon."""
    return 2 * dot(wo, m) * m - wo


def pdf_mirror(density: Float, cos_h: Float) -> Float:
    """Density of `mirror` in 1/sr, if m has the given density and cos_h = wo . m."""
    # Walter et al., Eq. 14
    return 0.25 * density / cos_h
