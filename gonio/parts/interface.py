"""A clear layer's surface: refraction, transmittance, absorption, and light that bounces inside.

eta is the index of the layer over that of the medium above it. Where its distance from 1 counts, functions
take that instead: the excess eta - 1, whose digits an index near 1 has lost. Directions leave the surface
on the side of the normal, inside the layer as well: a refracted direction keeps the azimuth of the one it
belongs to.

Sources: Walsh, "The reflection factor of a polished glass surface for diffused light", 1926, for the
diffuse reflectance; Weidlich, Wilkie, "Arbitrarily layered micro-facet surfaces", GRAPHITE 2007, for the
absorption.
"""

from __future__ import annotations

from gonio.lang import (
    MU_MIN,
    Color,
    Float,
    Vec3,
    dot,
    exp,
    fma,
    log,
    maximum,
    minimum,
    normalize,
    safe_sqrt,
    select,
    smooth_sqrt,
    sqrt,
    vec3,
)
from gonio.parts.frame import SIN2_MIN

# The analytic part of the diffuse reflectance over x = (eta - 1) / (eta + 1), times (1 + x^2)^3, as a
# polynomial fitted to 50-digit values for eta in [1, 3]: error 2e-11.
# fmt: off
W0, W1, W2, W3 = 0.666666666645, 3.83333334536, 0.466665563105, -1.23329376639
W4, W5, W6, W7 = 0.284984070108, 1.81266759233, 0.68589219084, 0.912356419076
W8, W9, W10, W11 = -0.372378845687, 1.38203234214, -1.28370394485, 0.75661449279
# fmt: on

# 2 E_3(x) exp(x) = (1 + a x) / (1 + b x + a x^2 / 2), error below 0.27 % for every x >= 0 (its limits are
# exact): the share of diffuse light that crosses an optical depth x.
E3_A, E3_B = 1.0483666697, 1.9225672060

# Cosine of the flattest internal path that is reckoned with, when the layer has the lower index and
# nothing is reflected totally.
SLANT_MIN = 0.3


def refract(w: Vec3, excess: Float) -> Vec3:
    """The direction inside a layer with eta >= 1 that belongs to w outside."""
    return vec3(w.x, w.y, smooth_sqrt(_eta2_cos2(w.z, excess))) * (1 / (1 + excess))


def refracted_sum(wi: Vec3, wo: Vec3, excess: Float) -> Vec3:
    """eta times the sum of both refracted directions, which has their half vector's direction.

    Where the two are nearly mirrored the tangential parts cancel: they are summed before they are rounded
    by refraction, so that a sharp highlight below keeps its place.
    """
    z_i, z_o = _eta2_cos2(wi.z, excess), _eta2_cos2(wo.z, excess)
    return vec3(wi.x + wo.x, wi.y + wo.y, smooth_sqrt(z_i) + smooth_sqrt(z_o))


def refracted_sin2_half(wi: Vec3, wo: Vec3, excess: Float) -> Float:
    """Squared sine at which refracted light meets a facet, from a difference before it is rounded."""
    z_i, z_o = _eta2_cos2(wi.z, excess), _eta2_cos2(wo.z, excess)
    # A difference of two roots is that of their squares over their sum
    z = (wi.z - wo.z) * (wi.z + wo.z) / (smooth_sqrt(z_i) + smooth_sqrt(z_o))
    apart = vec3(wi.x - wo.x, wi.y - wo.y, z) / (1 + excess)
    return 0.25 * dot(apart, apart)


def _contrast(excess: Float) -> Float:
    """eta^2 - 1."""
    return excess * (2 + excess)


def _eta2_cos2(mu: Float, excess: Float) -> Float:
    """eta^2 cos^2(theta_t) = mu^2 + eta^2 - 1."""
    # mu^2 with its rounding error: at grazing angles little else is left
    return fma(mu, mu, _contrast(excess))


def attenuation(sigma_a: Color, thickness: Float, wi: Vec3, wo: Vec3) -> Color:
    """exp(-sigma_a d (1 / mu_i + 1 / mu_o)): what is left of light after its way in and out (Bouguer).

    wi, wo: refracted directions. sigma_a: absorption per unit of the thickness d.
    """
    return exp(-sigma_a * (thickness * ((wi.z + wo.z) / (wi.z * wo.z))))


# --- diffuse light -------------------------------------------------------------------------------------


def _diffuse_reflectance_above_one(eta: Float) -> Float:
    """Walsh's integral of 2 F(mu) mu for eta in [1, 3], error 1e-11."""
    x = (eta - 1) / (eta + 1)
    x2 = x * x
    # The logarithm has this factor exactly; the rest is analytic.
    logarithmic = 2 * x * (1 + x) * (1 + x) * log(maximum(x, MU_MIN))
    p = W6 + x * (W7 + x * (W8 + x * (W9 + x * (W10 + x * W11))))
    p = W0 + x * (W1 + x * (W2 + x * (W3 + x * (W4 + x * (W5 + x * p)))))
    q = 1 + x2
    return x * (logarithmic + p) / (q * q * q)


def diffuse_reflectance(eta: Float) -> Float:
    """Share of diffuse light from above that the smooth surface reflects: 0.0918 at eta = 1.5."""
    flipped = 1 / eta
    above = _diffuse_reflectance_above_one(maximum(eta, flipped))
    return select(eta >= 1, above, 1 - eta * eta * (1 - above))


def diffuse_reflectance_inside(eta: Float) -> Float:
    """Share of diffuse light from inside that the smooth surface reflects: 0.5963 at eta = 1.5."""
    # What passes is the same in both directions, counted in eta^2 times the solid angle inside.
    flipped = 1 / eta
    above = _diffuse_reflectance_above_one(maximum(eta, flipped))
    return select(eta >= 1, 1 - (1 - above) * flipped * flipped, above)


def diffuse_return(optical_depth: Color, eta: Float) -> Color:
    """Share of diffuse light leaving the base that comes back to it from the surface.

    Exact without absorption. With it, the light is taken as diffuse within the angles of total reflection,
    which holds most of it.
    """
    slant = sqrt(maximum(1 - 1 / (eta * eta), SLANT_MIN * SLANT_MIN))
    x = 2 * optical_depth / slant
    kept = exp(-x) * (1 + E3_A * x) / (1 + x * (E3_B + 0.5 * E3_A * x))
    return diffuse_reflectance_inside(eta) * kept


# Added to the weight of a lobe, so that the reciprocal of two black lobes' sum has a finite derivative.
LOBE_MIN = 1e-12


# --- sampling ------------------------------------------------------------------------------------------
# A base is sampled inside the layer. Directions within the critical angle leave by refraction. The others
# cannot leave, and would be wasted: their ring is spread over the whole outer hemisphere instead, so that
# cosine-weighted samples inside are cosine-weighted samples outside, exactly.

# Flattest direction that a sample leaves in: derivatives by the index fit in a float32 there.
LEAVE_MIN = 1e-12


def critical_cosine(excess: Float) -> Float:
    """Cosine inside the layer of the flattest direction that leaves it; 0 for eta <= 1."""
    return safe_sqrt(_contrast(excess)) / (1 + excess)


def leave(w: Vec3, excess: Float) -> Vec3:
    """The outer direction for a direction inside: refracted, or spread out if it cannot leave."""
    k, eta = critical_cosine(excess), 1 + excess
    refracted = w.z > k
    spread = minimum(w.z / maximum(k, MU_MIN), 1)
    # The sine from x and y: under many layers 1 - z^2 has few digits
    sin2 = w.x * w.x + w.y * w.y
    z = select(refracted, safe_sqrt(1 - eta * eta * sin2), spread)
    # Refracted sines are eta times as large, of which 1 - z^2 would leave no digits near the normal
    spread_out = safe_sqrt(1 - spread * spread) / sqrt(maximum(sin2, SIN2_MIN))
    scale = select(refracted, eta, spread_out)
    # A sample above the horizon stays there, however flat.
    z = select(w.z > 0, maximum(z, LEAVE_MIN), -1)
    return normalize(vec3(w.x * scale, w.y * scale, z))


def gather(w: Vec3, excess: Float) -> Vec3:
    """The inner direction that `leave` spreads to w; z = 0 for eta <= 1, which has none."""
    k = critical_cosine(excess)
    z = k * w.z
    sin2 = w.x * w.x + w.y * w.y
    scale = safe_sqrt(1 - z * z) / sqrt(maximum(sin2, SIN2_MIN))
    near = sin2 < SIN2_MIN  # no azimuth: any is right
    x = select(near, safe_sqrt(1 - z * z), w.x * scale)
    return vec3(x, select(near, 0, w.y * scale), z)


def pdf_leave(
    pdf_refracted: Float, pdf_gathered: Float, w: Vec3, w_t: Vec3, excess: Float
) -> Float:
    """Density of `leave` at w, from the inner density at w_t = refract(w) and at gather(w)."""
    # Solid angle over cosine-weighted one: 1 / mu. Refraction shrinks the latter by eta^2, gathering by
    # k^2, and the cosines are k mu and mu.
    eta = 1 + excess
    return pdf_refracted * w.z / (eta * eta * w_t.z) + pdf_gathered * critical_cosine(excess)
