"""Masking and shadowing of microfacets.

Two forms: G1 is the share of facets that one direction sees, in [0, 1]; V is the pair's G(wi, wo) over
4 mu_i mu_o, which is all that a microfacet BRDF needs (f = F D V) and stays finite in the horizon, where
G and the cosines vanish together. So G = 4 mu_i mu_o V.

Sources:
Walter et al., "Microfacet models for refraction through rough surfaces", EGSR 2007: Smith and its fit;
Heitz, "Understanding the masking-shadowing function in microfacet-based BRDFs", JCGT 2014: Lambda;
Cook, Torrance, "A reflectance model for computer graphics", 1982; Neumann et al., "Compact metallic
reflectance models", 1999; Kelemen, Szirmay-Kalos, "A microfacet based coupled specular-matte BRDF model",
2001; Schlick, "An inexpensive BRDF model for physically-based rendering", 1994; Karis, "Real shading in
Unreal Engine 4", SIGGRAPH 2013 course.
"""

from gonio.lang import (
    Float,
    Vec3,
    maximum,
    minimum,
    select,
    sqrt,
)
from gonio.parts.distribution import Beckmann, Facets, RoundBeckmann, RoundGGX
from gonio.parts.exact import two_product, two_sum
from gonio.parts.frame import LENGTHENED, length2

SQRT_2_OVER_PI = 0.7978845608028654

# Largest V of the maskings that grow like 1 / mu^2 where both directions graze: times the largest D, 3e7,
# it still is a float32. It is reached at cosines of 5e-16.
V_MAX = 1e30


# --- without a width -------------------------------------------------------------------------------


def V_implicit() -> float:
    """G = mu_i mu_o, which cancels the denominator."""
    return 0.25


def V_neumann(wi: Vec3, wo: Vec3) -> Float:
    """G = mu_i mu_o / max(mu_i, mu_o)."""
    return 0.25 / maximum(wi.z, wo.z)


def G_cook_torrance(wi: Vec3, wo: Vec3) -> Float:
    """Of V-grooves: min(1, 2 m.z mu_o / wo.m, 2 m.z mu_i / wo.m)."""
    # 2 m.z / wo.m = 4 h.z / |h|^2, without a root
    h = wi + wo
    return minimum(4 * h.z * minimum(wi.z, wo.z) / length2(h), 1)


def lost_cook_torrance(wi: Vec3, wo: Vec3) -> Float:
    """1 - G of V-grooves, 1 - 4 h.z min(mu_i, mu_o) / |h|^2 with h = wi + wo, exact where G is nearly 1.

    To within 1e-14 in float32: a coat's transmittance, which it is added to, is as small as |h|.
    """
    a, b = LENGTHENED * wi, LENGTHENED * wo
    low, high = minimum(a.z, b.z), maximum(a.z, b.z)
    # h.z^2 - 4 h.z low = h.z (high - 3 low); high - 2 low is exact where G is nearly 1
    x, y, z = two_sum(a.x, b.x), two_sum(a.y, b.y), two_sum(low, high)
    rest = two_sum(high - 2 * low, -low)
    xx, yy, zr = two_product(x.x, x.x), two_product(y.x, y.x), two_product(z.x, rest.x)
    flat = two_sum(xx.x, yy.x)
    whole = two_sum(flat.x, zr.x)
    # What the roundings of the sums and products left out, each counted once
    missed = 2 * (x.x * x.y + y.x * y.y) + (z.x * rest.y + z.y * rest.x)
    missed = missed + (xx.y + yy.y + zr.y) + (flat.y + whole.y)
    # By the root twice: derivatives divide by the square of a divisor, which leaves a float32's range
    length = sqrt(flat.x + z.x * z.x)
    return maximum((whole.x + missed) / length / length, 0)


def lost_cook_torrance_plain(wi: Vec3, wo: Vec3) -> Float:
    """1 - G of V-grooves, 1 - 4 h.z min(mu_i, mu_o) / |h|^2 with h = wi + wo, exact where G is nearly 1.

    To within 1e-7 in float32. Shaders' compilers rearrange sums, and what was carried along would be 0.
    """
    h = wi + wo
    low, high = minimum(wi.z, wo.z), maximum(wi.z, wo.z)
    # h.z^2 - 4 h.z low = h.z (high - 3 low); in two steps, both are exact where G is nearly 1
    rest = (high - 2 * low) - low
    return maximum((h.x * h.x + h.y * h.y + h.z * rest) / length2(h), 0)


def V_cook_torrance(wi: Vec3, wo: Vec3) -> Float:
    """G over 4 mu_i mu_o."""
    # Divided by the smaller cosine, G = 4 h.z min(mu_i, mu_o) / |h|^2 does not depend on it; the quotient
    # has the difference of two derivatives that are as large as the cosine is small
    h = wi + wo
    low, high = minimum(wi.z, wo.z), maximum(wi.z, wo.z)
    return minimum(minimum(h.z / length2(h), 0.25 / low) / high, V_MAX)


# With a quotient less, for exports that have no derivatives.
def V_cook_torrance_value(wi: Vec3, wo: Vec3) -> Float:
    """G over 4 mu_i mu_o."""
    h = wi + wo
    return minimum(minimum(h.z / length2(h) * minimum(wi.z, wo.z), 0.25) / (wi.z * wo.z), V_MAX)


def V_kelemen(cos_h: Float) -> Float:
    """G = mu_i mu_o / (wo . m)^2."""
    return minimum(0.25 / cos_h / cos_h, V_MAX)


# --- Smith -----------------------------------------------------------------------------------------
# Of any facets, by their `area`, mu (1 + 2 Lambda).


def G1(facets: Facets, w: Vec3) -> Float:
    """Smith's masking 1 / (1 + Lambda)."""
    return 2 * w.z / (w.z + facets.area(w))


def V_smith(facets: Facets, wi: Vec3, wo: Vec3) -> Float:
    """G = G1(wi) G1(wo): masking and shadowing taken as independent."""
    return 1 / ((wi.z + facets.area(wi)) * (wo.z + facets.area(wo)))


def V_smith_correlated(facets: Facets, wi: Vec3, wo: Vec3) -> Float:
    """G = 1 / (1 + Lambda_i + Lambda_o): correlated by the facet's height. Heitz 2014, Eq. 99."""
    return 0.5 / (wo.z * facets.area(wi) + wi.z * facets.area(wo))


def lost_smith(facets: RoundBeckmann | RoundGGX, wi: Vec3, wo: Vec3) -> Float:
    """1 - G of `V_smith`, exact where G is nearly 1."""
    # (s_i s_o - 4 mu_i mu_o) / (s_i s_o) with s = mu + area = 2 mu + hidden
    rest = (wi.z + facets.area(wi)) * facets.hidden(wo) + 2 * wo.z * facets.hidden(wi)
    return rest * V_smith(facets, wi, wo)


def lost_smith_correlated(facets: RoundBeckmann | RoundGGX, wi: Vec3, wo: Vec3) -> Float:
    """1 - G of `V_smith_correlated`, exact where G is nearly 1."""
    rest = wo.z * facets.hidden(wi) + wi.z * facets.hidden(wo)
    return 2 * rest * V_smith_correlated(facets, wi, wo)


# Blinn-Phong uses Beckmann's: c = sqrt(n / 2 + 1) / tan(theta) is 1 / (alpha tan(theta)) with its width.


def _walter_over_mu(facets: Beckmann | RoundBeckmann, w: Vec3) -> Float:
    """Walter's rational fit of Beckmann's G1, over mu."""
    sine = facets.sine(w)
    # Walter et al. take 1 from 1.6 on, where the fit has reached 1.00006
    a = minimum(w.z / sine, 1.6)
    fit = (3.535 + 2.181 * a) / (sine * (1 + 2.276 * a + 2.577 * a * a))
    return select(w.z < 1.6 * sine, fit, 1 / maximum(w.z, 1.6 * sine))


def G1_walter(facets: Beckmann | RoundBeckmann, w: Vec3) -> Float:
    """Walter et al., section 5.2: a rational fit of Beckmann's `G1`, error below 0.35 %."""
    return w.z * _walter_over_mu(facets, w)


def V_smith_walter(facets: Beckmann | RoundBeckmann, wi: Vec3, wo: Vec3) -> Float:
    """G = G1(wi) G1(wo) with Walter's fit."""
    return 0.25 * _walter_over_mu(facets, wi) * _walter_over_mu(facets, wo)


# --- Schlick ---------------------------------------------------------------------------------------


def schlick_k_beckmann(alpha: Float) -> Float:
    """k = alpha sqrt(2 / pi), made for Beckmann."""
    return SQRT_2_OVER_PI * alpha


def schlick_k_ggx(alpha: Float) -> Float:
    """k = alpha / 2, made for GGX; Unreal Engine 4 uses it for image-based light."""
    return 0.5 * alpha


def schlick_k_ue4(roughness: Float) -> Float:
    """k = (r + 1)^2 / 8 of Unreal Engine 4's punctual lights; r is the perceptual roughness."""
    r = roughness + 1
    return r * r / 8


def G1_schlick(mu: Float, k: Float) -> Float:
    """Schlick's masking mu / (mu (1 - k) + k)."""
    return mu / (mu * (1 - k) + k)


def V_schlick(wi: Vec3, wo: Vec3, k: Float) -> Float:
    """G = G1_schlick(mu_i) G1_schlick(mu_o)."""
    return 0.25 / ((wi.z * (1 - k) + k) * (wo.z * (1 - k) + k))
