"""Distributions of microfacet normals: density D, and sampling of normals and of visible normals.

A facet's normal m is a unit vector in the local frame. Every D is per steradian and normalised such that
the integral of D(m) m.z over the hemisphere is 1. alpha is the width of the distribution of slopes, from
ALPHA_MIN to 1: Disney's and Unity's "roughness" r is perceptual, alpha = r^2. Anisotropic ones take a
width along x and one along y.

Everything is written with m.z and the tangential part x^2 + y^2, whose digits survive near the normal;
1 - m.z^2 loses them, and with them a sharp highlight.

Sources:
Walter et al., "Microfacet models for refraction through rough surfaces", EGSR 2007: Beckmann, GGX, Phong;
Burley, "Physically-based shading at Disney", SIGGRAPH 2012 course, appendix B: GTR1, anisotropic GGX;
Cook, Torrance, "A reflectance model for computer graphics", 1982: Gaussian (its c is left open);
Dupuy, Benyoub, "Sampling visible GGX normals with spherical caps", HPG 2023;
Jakob, "An improved visible normal sampling routine for the Beckmann distribution", 2014.
"""

from gonio.lang import (
    INV_PI,
    MU_MIN,
    PI,
    TWO_PI,
    Float,
    Vec2,
    Vec3,
    clamp,
    cos,
    dot,
    erf,
    erfinv,
    exp,
    length,
    log,
    maximum,
    minimum,
    normalize,
    safe_asin,
    safe_sqrt,
    select,
    sin,
    sqrt,
    vec2,
    vec3,
)
from gonio.parts.frame import azimuth
from gonio.parts.special import expm1, log1p, log1p_over

# Sharpest facets: a float32 direction is good to 6e-8, a thousandth of this width, so the shape of the
# highlight is still resolved. The peak of D, 3e7, and its derivatives fit into a float32.
ALPHA_MIN = 1e-4

# Square of the cosine below which exp(-tan^2 / alpha^2) is 0 in any precision, for alpha up to 3.2.
COS2_MIN = 1e-6

INV_SQRT_PI = 0.5641895835477563

# Distance of a random number from the ends, where erfinv has no bound: half a float32 epsilon.
RANDOM_MARGIN = 2.0**-24

# The Gaussian's normalisation as polynomials in q = alpha^2 on [0, 1], fitted to 40-digit values. Dawson's
# function over its argument, which is the integral over all angles up to infinity: error 4e-15.
# fmt: off
DAWSON_0, DAWSON_1, DAWSON_2 = 0.999999999999998, -0.66666666666618277, 0.26666666664727746
DAWSON_3, DAWSON_4, DAWSON_5 = -0.076190475887026499, 0.016931214491370693, -0.0030783916079760301
DAWSON_6, DAWSON_7, DAWSON_8 = 0.0004735667446096014, -6.3082706954634178e-5, 7.3502647670161513e-6
DAWSON_9, DAWSON_10 = -7.2077241302219111e-7, 4.6405300045444838e-8
# What lies beyond pi / 2, over q exp(-pi^2 / (4 q)): error 3e-12 of a part that is at most 3 %.
BEYOND_0, BEYOND_1, BEYOND_2 = 0.202642367284, -0.123191787006, 0.0426915174185
BEYOND_3, BEYOND_4, BEYOND_5 = -0.0106300084231, 0.00208454326375, -0.000338348612534
BEYOND_6, BEYOND_7, BEYOND_8 = 4.6655247915e-5, -5.33585946608e-6, 4.00455147614e-7
# fmt: on


# --- half vectors ---------------------------------------------------------------------------------


def anisotropic_alpha(alpha: Float, anisotropy: Float) -> Vec2:
    """Widths along x and y: aspect sqrt(1 - 0.9 anisotropy), their product remains alpha^2.

    Burley, appendix B, without its lower limit.
    """
    aspect = sqrt(1 - 0.9 * anisotropy)
    return vec2(alpha / aspect, alpha * aspect)


def _slope2(m: Vec3, alpha_x: Float, alpha_y: Float) -> Float:
    """Square of the slope in units of the widths, times m.z^2."""
    x, y = m.x / alpha_x, m.y / alpha_y
    return x * x + y * y


def _polar(tan_theta: Float, u: Float) -> Vec3:
    """A normal with a given slope and the azimuth 2 pi u."""
    phi = TWO_PI * u
    return normalize(vec3(tan_theta * cos(phi), tan_theta * sin(phi), 1))


# --- GGX -------------------------------------------------------------------------------------------


def D_ggx(m: Vec3, alpha_x: Float, alpha_y: Float) -> Float:
    """GGX, also called Trowbridge-Reitz. Walter et al., Eq. 33; Burley, Eq. 13 (anisotropic)."""
    # (N.H)^2 (alpha^2 - 1) + 1 = alpha^2 ((x^2 + y^2) / alpha^2 + z^2), without its cancellation
    v = vec3(m.x / alpha_x, m.y / alpha_y, m.z)
    s = dot(v, v)
    return INV_PI / (alpha_x * alpha_y * s * s)


def sample_ggx(alpha_x: Float, alpha_y: Float, u: Vec2) -> Vec3:
    """A normal with density D_ggx m.z. Walter et al., Eq. 35 and 36."""
    r = safe_sqrt(u.x)
    phi = TWO_PI * u.y
    return normalize(
        vec3(alpha_x * r * cos(phi), alpha_y * r * sin(phi), safe_sqrt(1 - u.x) + MU_MIN)
    )


def stretched_sine(w: Vec3, alpha_x: Float, alpha_y: Float) -> Float:
    """alpha sin(theta), with the width of the facets along w; at least MU_MIN."""
    x, y = alpha_x * w.x, alpha_y * w.y
    return sqrt(maximum(x * x + y * y, MU_MIN * MU_MIN))


def ggx_length(w: Vec3, alpha_x: Float, alpha_y: Float) -> Float:
    """mu (1 + 2 Lambda) = sqrt(mu^2 + alpha^2 sin^2(theta)), of which Smith's terms for GGX are made."""
    return length(vec3(alpha_x * w.x, alpha_y * w.y, w.z))


def sample_ggx_visible(wo: Vec3, alpha_x: Float, alpha_y: Float, u: Vec2) -> Vec3:
    """A normal with density G1(wo) max(wo . m, 0) D_ggx(m) / mu_o. Dupuy and Benyoub, Listing 3."""
    w = normalize(vec3(alpha_x * wo.x, alpha_y * wo.y, wo.z))
    # A spherical cap: z = 1 - u (1 + w.z), and 1 - z^2 from its factors
    # u = 1 would be the facet opposite to w, whose half vector has no direction
    u1 = minimum(u.x, 1 - RANDOM_MARGIN)
    drop = u1 * (1 + w.z)
    r = safe_sqrt(drop * (2 - drop))
    phi = TWO_PI * u.y
    h = vec3(r * cos(phi) + w.x, r * sin(phi) + w.y, (1 - u1) * (1 + w.z))
    return normalize(vec3(alpha_x * h.x, alpha_y * h.y, h.z))


def pdf_ggx_visible(wo: Vec3, m: Vec3, alpha_x: Float, alpha_y: Float) -> Float:
    """Density of wo mirrored at `sample_ggx_visible`, in 1/sr: G1(wo) D / (4 mu_o)."""
    return D_ggx(m, alpha_x, alpha_y) / (2 * (wo.z + ggx_length(wo, alpha_x, alpha_y)))


# --- Beckmann --------------------------------------------------------------------------------------


def D_beckmann(m: Vec3, alpha_x: Float, alpha_y: Float) -> Float:
    """Beckmann: slopes with a normal distribution of variance alpha^2 / 2. Walter et al., Eq. 25."""
    inv_cos2 = 1 / maximum(m.z * m.z, COS2_MIN)
    slope2 = _slope2(m, alpha_x, alpha_y) * inv_cos2
    # Separate quotients: the square of their common denominator would leave a float32's range
    return INV_PI / (alpha_x * alpha_y) * inv_cos2 * inv_cos2 * exp(-slope2)


def D_beckmann_round(m: Vec3, alpha: Float) -> Float:
    """`D_beckmann` for facets of the same width in all directions."""
    inv_cos2 = 1 / maximum(m.z * m.z, COS2_MIN)
    tan2 = (m.x * m.x + m.y * m.y) * inv_cos2
    a2 = alpha * alpha
    return INV_PI / a2 * inv_cos2 * inv_cos2 * exp(-tan2 / a2)


def sample_beckmann(alpha_x: Float, alpha_y: Float, u: Vec2) -> Vec3:
    """A normal with density D_beckmann m.z. Walter et al., Eq. 28 and 29."""
    r = safe_sqrt(-log(maximum(1 - u.x, RANDOM_MARGIN)))
    phi = TWO_PI * u.y
    return normalize(vec3(alpha_x * r * cos(phi), alpha_y * r * sin(phi), 1))


def beckmann_lambda_mu(w: Vec3, alpha_x: Float, alpha_y: Float) -> Float:
    """mu Lambda(w) of Smith's masking, finite in the horizon. Heitz 2014, Eq. 66."""
    sigma = stretched_sine(w, alpha_x, alpha_y)
    a = w.z / sigma
    # Lambda is smaller than 1e-22 from there on, and the limit keeps a^2 in range
    a = minimum(a, 7)
    return maximum(0.5 * (INV_SQRT_PI * sigma * exp(-a * a) - w.z * (1 - erf(a))), 0)


def _newton(x: Float, target: Float, w: Vec3, sine: Float) -> Float:
    """One step towards the visible slope erfinv(x) with the given cumulated area, times w.z."""
    slope = erfinv(x)
    value = w.z * (1 + x) + INV_SQRT_PI * sine * exp(-slope * slope) - target
    slant = maximum(w.z - slope * sine, MU_MIN)
    return clamp(x - value / slant, RANDOM_MARGIN - 1, 1 - RANDOM_MARGIN)


def sample_beckmann_visible(wo: Vec3, alpha_x: Float, alpha_y: Float, u: Vec2) -> Vec3:
    """A normal with density G1(wo) max(wo . m, 0) D_beckmann(m) / mu_o, after Jakob (2014).

    The slope towards wo has no inverse in closed form: it is found by Newton's method in the domain of
    erf, from a guess that is exact at normal incidence.
    """
    w = normalize(vec3(alpha_x * wo.x, alpha_y * wo.y, wo.z))
    sine = safe_sqrt(w.x * w.x + w.y * w.y)
    cot = minimum(w.z / maximum(sine, MU_MIN), 7)
    top = erf(cot)
    u1 = clamp(u.x, RANDOM_MARGIN, 1 - RANDOM_MARGIN)
    u2 = clamp(u.y, RANDOM_MARGIN, 1 - RANDOM_MARGIN)
    guess = top - (top + 1) * erf(sqrt(-log(u1)))
    target = u1 * (w.z * (1 + top) + INV_SQRT_PI * sine * exp(-cot * cot))
    x = clamp(guess, RANDOM_MARGIN - 1, 1 - RANDOM_MARGIN)
    x = _newton(x, target, w, sine)
    x = _newton(x, target, w, sine)
    x = _newton(x, target, w, sine)
    along, across = erfinv(x), erfinv(2 * u2 - 1)
    axis = azimuth(w)
    slope_x = axis.x * along - axis.y * across
    slope_y = axis.y * along + axis.x * across
    return normalize(vec3(-alpha_x * slope_x, -alpha_y * slope_y, 1))


def pdf_beckmann_visible(wo: Vec3, m: Vec3, alpha_x: Float, alpha_y: Float) -> Float:
    """Density of wo mirrored at `sample_beckmann_visible`, in 1/sr: G1(wo) D / (4 mu_o)."""
    area = wo.z + beckmann_lambda_mu(wo, alpha_x, alpha_y)
    return D_beckmann(m, alpha_x, alpha_y) / (4 * area)


# --- Blinn-Phong -----------------------------------------------------------------------------------


def blinn_phong_exponent(alpha: Float) -> Float:
    """n of (N.H)^n that matches a width: 2 / alpha^2 - 2, from 0 at alpha = 1."""
    return 2 / (alpha * alpha) - 2


def blinn_phong_alpha(exponent: Float) -> Float:
    """The width that matches an exponent n: sqrt(2 / (n + 2))."""
    return sqrt(2 / (exponent + 2))


def D_blinn_phong(m: Vec3, alpha: Float) -> Float:
    """Blinn-Phong, (n + 2) / (2 pi) (N.H)^n with n = 2 / alpha^2 - 2. Walter et al., Eq. 30."""
    # (N.H)^n = (1 + tan^2)^(-n / 2): a sharp lobe needs the digits of the tangent, not of the cosine
    tan2 = (m.x * m.x + m.y * m.y) / maximum(m.z * m.z, 0.25)
    steep = log(clamp(m.z, MU_MIN, 0.5))
    minus_log_cos = select(m.z > 0.5, 0.5 * log1p(tan2), -steep)
    a2 = alpha * alpha
    return INV_PI / a2 * exp(-2 * minus_log_cos * ((1 - alpha) * (1 + alpha) / a2))


def sample_blinn_phong(alpha: Float, u: Vec2) -> Vec3:
    """A normal with density D_blinn_phong m.z. Walter et al., Eq. 32 and 33: cos = u^(1 / (n + 2))."""
    tan2 = expm1(-alpha * alpha * log(maximum(1 - u.x, RANDOM_MARGIN)))
    return _polar(safe_sqrt(tan2), u.y)


# --- Gaussian --------------------------------------------------------------------------------------


def gaussian_norm(alpha: Float) -> Float:
    """Integral of exp(-(theta / alpha)^2) cos(theta) over the hemisphere, over pi alpha^2; error 1e-13."""
    q = alpha * alpha
    d = DAWSON_6 + q * (DAWSON_7 + q * (DAWSON_8 + q * (DAWSON_9 + q * DAWSON_10)))
    d = DAWSON_2 + q * (DAWSON_3 + q * (DAWSON_4 + q * (DAWSON_5 + q * d)))
    b = BEYOND_4 + q * (BEYOND_5 + q * (BEYOND_6 + q * (BEYOND_7 + q * BEYOND_8)))
    b = BEYOND_0 + q * (BEYOND_1 + q * (BEYOND_2 + q * (BEYOND_3 + q * b)))
    return DAWSON_0 + q * (DAWSON_1 + q * d) + exp(-PI * PI / (4 * q)) * q * b


def _angle(m: Vec3) -> Float:
    """Angle between m and the normal, exact at both ends of its range."""
    sine = safe_sqrt(m.x * m.x + m.y * m.y)
    return select(
        sine < m.z, safe_asin(minimum(sine, 0.75)), PI / 2 - safe_asin(minimum(m.z, 0.75))
    )


def D_gaussian(m: Vec3, alpha: Float) -> Float:
    """Gaussian of the angle, c exp(-(theta / alpha)^2). Cook and Torrance, with c normalised."""
    t = _angle(m) / alpha
    return INV_PI * exp(-t * t) / (alpha * alpha * gaussian_norm(alpha))


def _gaussian_covered(alpha: Float) -> Float:
    """Share of a plane Gaussian that lies within the angle pi / 2."""
    return 1 - exp(-PI * PI / (4 * alpha * alpha))


def sample_gaussian(alpha: Float, u: Vec2) -> Vec3:
    """A normal whose angle follows a plane Gaussian, nearly D_gaussian m.z; see `density_gaussian`."""
    theta = alpha * safe_sqrt(-log(maximum(1 - u.x * _gaussian_covered(alpha), RANDOM_MARGIN)))
    phi = TWO_PI * u.y
    s = sin(theta)
    return vec3(s * cos(phi), s * sin(phi), cos(theta))


def density_gaussian(m: Vec3, alpha: Float) -> Float:
    """Density of `sample_gaussian` in 1/sr; at least D_gaussian m.z / 1.68."""
    theta = _angle(m)
    t = theta / alpha
    sine = safe_sqrt(m.x * m.x + m.y * m.y)
    ratio = select(sine > MU_MIN, theta / maximum(sine, MU_MIN), 1)
    return INV_PI * exp(-t * t) * ratio / (alpha * alpha * _gaussian_covered(alpha))


# --- GTR1 ------------------------------------------------------------------------------------------


def D_gtr1(m: Vec3, alpha: Float) -> Float:
    """Generalised Trowbridge-Reitz with exponent 1: Disney's clearcoat. Burley, Eq. 4."""
    # log(alpha^2) / (alpha^2 - 1) goes to 1 at alpha = 1, and needs the plain logarithm far from it
    a2 = alpha * alpha
    below_one = (alpha - 1) * (alpha + 1)
    far = minimum(below_one, -0.2)
    ratio = select(below_one < -0.2, log(a2) / far, log1p_over(maximum(below_one, -0.2)))
    return INV_PI / (ratio * (m.x * m.x + m.y * m.y + a2 * m.z * m.z))


def D_gtr1_narrow(m: Vec3, alpha: Float) -> Float:
    """`D_gtr1` for alpha up to 0.5, where nothing cancels in its norm."""
    a2 = alpha * alpha
    v = vec3(m.x, m.y, alpha * m.z)
    return INV_PI * (a2 - 1) / (log(a2) * dot(v, v))


def sample_gtr1(alpha: Float, u: Vec2) -> Vec3:
    """A normal with density D_gtr1 m.z. Burley, Eq. 5."""
    # sin^2 = alpha^2 (alpha^(-2 u) - 1) / (1 - alpha^2); both differences vanish at alpha = 1
    a2 = alpha * alpha
    log_a2 = log(a2)
    below_one = (alpha - 1) * (alpha + 1)
    down, up = expm1(-u.x * log_a2), expm1((1 - u.x) * log_a2)
    # tan^2 = sin^2 / cos^2 with cos^2 = (1 - alpha^(2 - 2 u)) / (1 - alpha^2)
    round_ = below_one > -1e-6
    tan2 = select(
        round_, u.x / (1 - u.x + RANDOM_MARGIN), a2 * down / maximum(-up, RANDOM_MARGIN * a2)
    )
    return _polar(safe_sqrt(tan2), u.y)
