"""Sampling of rough diffuse reflection by linearly transformed cosines, clipped (CLTC) or not.

Source: Portsmouth, Kutz, Hill, "EON: A practical energy-preserving rough diffuse BRDF",
arXiv:2410.18026, section 3.1 and its listings 2 to 4. r is EON's roughness in [0, 1].
`cltc_matched` is not the paper's: its share of uniform samples falls to 0 with r as fast as the
BRDF turns into Lambert's, so that it never has more variance than cosine sampling, nor than the
paper's `cltc_uniform`.
Deviations: the coefficient d changes sign near normal incidence, and the clipping follows it; r = 0
with u = 0 is defined, and r^0.1 has a finite derivative there.
At the rim of the transformed lobe its density falls to 0; float32 keeps an absolute accuracy of 1e-6
per steradian there, not a relative one. The uniform lobe that is mixed in covers that.
"""

from gonio.lang import (
    INV_PI,
    TWO_PI,
    Float,
    Vec2,
    Vec3,
    cos,
    dot,
    lerp,
    maximum,
    normalize,
    power,
    safe_sqrt,
    select,
    sin,
    sqrt,
    vec2,
    vec3,
)
from gonio.parts.frame import azimuth, from_frame, to_frame
from gonio.parts.hemisphere import pdf_uniform, sample_uniform

# Smallest roughness in r^0.1, which keeps the derivative 0.1 r^-0.9 finite in float32. Below it are numbers
# that some machines take as 0, so it ends there for all.
R_MIN = 1e-37

# Smallest probability that is divided by: no 0 / 0, and no infinite derivative, in samples that are
# not taken.
P_MIN = 1e-6

# Up to this roughness `sample_cltc_matched` is cosine sampling. A lobe sheared by d leaves a wedge of
# height r above the horizon to the uniform lobe, which costs a variance of r^2 log(1 / r); that of cosine
# sampling is of order r^2, and the smaller of the two below r = 3e-4.
R_COSINE = 1e-4

# A sample that rounding pushed below the horizon is lifted to this cosine, 1/16 of a float32 epsilon.
Z_MIN = 2.0**-27


def coefficients(mu: Float, k: Float, r: Float) -> tuple[Float, Float, Float, Float]:
    """a, b, c, d of M = [[a, 0, b], [0, c, 0], [d, 0, 1]] (Eq. 25, Listing 2) at mu = wo.z, k = 1 - mu."""
    a = 1 + r * (0.303392 + (-0.518982 + 0.111709 * mu) * mu + (-0.276266 + 0.335918 * mu) * r)
    b = r * (-1.16407 + 1.15859 * mu + (0.150815 - 0.150105 * mu) * r) / (mu * mu * mu - 1.43545)
    c = 1 + (0.20013 + (-0.506373 + 0.261777 * mu) * mu) * r
    # Numerator and denominator of d nearly vanish at mu = 1: the paper's polynomials in mu,
    # 0.540852 - 1.01625 mu + 0.475392 mu^2 and -1.0743 + 0.0725628 mu + mu^2, are written in k = 1 - mu.
    d = r * (-6e-6 + (0.065466 + 0.475392 * k) * k) / (-0.0017372 - (2.0725628 - k) * k)
    return a, b, c, d


def _one_minus_cos(w: Vec3) -> Float:
    """1 - w.z, with the digits that w.z has lost beside the normal, where d needs them."""
    return (w.x * w.x + w.y * w.y) / (1 + w.z)


def _transform(x: Float, y: Float, wo: Vec3, r: Float, d: Float) -> Vec3:
    """M applied to the cosine lobe's direction above (x, y), turned to wo's azimuth, normalised."""
    a, b, c, _ = coefficients(wo.z, _one_minus_cos(wo), r)
    z = safe_sqrt(1 - x * x - y * y)
    return normalize(from_frame(vec3(a * x + b * z, c * y, d * x + z), azimuth(wo)))


def _pdf(wi: Vec3, wo: Vec3, r: Float, d: Float) -> Float:
    """Density of `_transform` for an unclipped cosine lobe (Eq. 23 and 24)."""
    a, b, c, _ = coefficients(wo.z, _one_minus_cos(wo), r)
    w = to_frame(wi, azimuth(wo))
    det = c * (a - b * d)
    # det(M) times the inverse of M, applied to w
    h = vec3(c * (w.x - b * w.z), (a - b * d) * w.y, c * (a * w.z - d * w.x))
    inv2 = 1 / dot(h, h)
    return INV_PI * det * det * inv2 * inv2 * maximum(h.z, 0)


def sample_ltc(wo: Vec3, r: Float, u: Vec2) -> Vec3:
    """Unclipped general fit: may return directions below the horizon, which are wasted."""
    R = safe_sqrt(u.x)
    phi = TWO_PI * u.y
    _, _, _, d = coefficients(wo.z, _one_minus_cos(wo), r)
    return _transform(R * cos(phi), R * sin(phi), wo, r, d)


def pdf_ltc(wi: Vec3, wo: Vec3, r: Float) -> Float:
    """Density of `sample_ltc`; its integral over the upper hemisphere is below 1."""
    _, _, _, d = coefficients(wo.z, _one_minus_cos(wo), r)
    return _pdf(wi, wo, r, d)


def sample_ltc_nonnegative(wo: Vec3, r: Float, u: Vec2) -> Vec3:
    """With d = 0 nothing falls below the horizon, but grazing lobes fit badly."""
    R = safe_sqrt(u.x)
    phi = TWO_PI * u.y
    return _transform(R * cos(phi), R * sin(phi), wo, r, 0 * r)


def pdf_ltc_nonnegative(wi: Vec3, wo: Vec3, r: Float) -> Float:
    """Density of `sample_ltc_nonnegative`."""
    return _pdf(wi, wo, r, 0 * r)


def _kept_area(d: Float) -> Float:
    """Share of the unit disk that clipping keeps (Eq. 28): (1 + cos(theta_P)) / 2."""
    return 0.5 + 0.5 / sqrt(1 + d * d)


def sample_cltc(wo: Vec3, r: Float, u: Vec2) -> Vec3:
    """Clipped to the directions that M keeps above the horizon (Listing 3)."""
    _, _, _, d = coefficients(wo.z, _one_minus_cos(wo), r)
    R = safe_sqrt(u.x)
    phi = TWO_PI * u.y
    y = R * sin(phi)
    # A half-disk and a half-ellipse (Heitz 2018); the plane cuts the side on which d x is negative.
    x = lerp(safe_sqrt(1 - y * y), R * cos(phi), _kept_area(d))
    wi = _transform(select(d < 0, -x, x), y, wo, r, d)
    return vec3(wi.x, wi.y, maximum(wi.z, Z_MIN))


def pdf_cltc(wi: Vec3, wo: Vec3, r: Float) -> Float:
    """Density of `sample_cltc`."""
    _, _, _, d = coefficients(wo.z, _one_minus_cos(wo), r)
    return _pdf(wi, wo, r, d) / _kept_area(d)


def uniform_share(mu: Float, r: Float) -> Float:
    """P_u of Listing 4: how many samples the uniform lobe gets, which bounds the weights."""
    fit = 0.162925 + mu * (-0.372058 + (0.538233 - 0.290822 * mu) * mu)
    return select(r > R_MIN, power(maximum(r, R_MIN), 0.1) * fit, 0)


def sample_cltc_uniform(wo: Vec3, r: Float, u: Vec2) -> Vec3:
    """CLTC mixed with the uniform hemisphere (one-sample MIS, Listing 4): the paper's choice."""
    P_u = uniform_share(wo.z, r)
    uniform = u.x < P_u
    u1 = select(uniform, u.x / maximum(P_u, P_MIN), (u.x - P_u) / (1 - P_u))
    w_u = sample_uniform(vec2(u1, u.y))
    w_c = sample_cltc(wo, r, vec2(u1, u.y))
    return select(uniform, w_u, w_c)


def pdf_cltc_uniform(wi: Vec3, wo: Vec3, r: Float) -> Float:
    """Density of `sample_cltc_uniform`."""
    P_u = uniform_share(wo.z, r)
    return lerp(pdf_cltc(wi, wo, r), pdf_uniform(), P_u)


def matched_share(mu: Float, r: Float) -> Float:
    """How many samples `sample_cltc_matched` gives to the uniform lobe: 0 at r = 0, at most 0.13.

    Fitted to the shares of least variance over (mu, r), on condition that the variance stays 4 %
    below those of cosine sampling and of the paper's choice. On average it is 5 % above the least.
    """
    k = 1 - mu
    steep = 0.0169 + k * (0.2136 + k * (0.445 * k - 0.2345))
    return r * steep * (1 + r * (0.315 * r - 0.602 - 0.5736 * k))


def _matched_roughness(r: Float) -> Float:
    return maximum(r - R_COSINE, 0)


def sample_cltc_matched(wo: Vec3, r: Float, u: Vec2) -> Vec3:
    """CLTC mixed with as much of the uniform hemisphere as the roughness asks for."""
    q = _matched_roughness(r)
    P_u = matched_share(wo.z, q)
    uniform = u.x < P_u
    u1 = select(uniform, u.x / maximum(P_u, P_MIN), (u.x - P_u) / (1 - P_u))
    w_u = sample_uniform(vec2(u1, u.y))
    w_c = sample_cltc(wo, q, vec2(u1, u.y))
    return select(uniform, w_u, w_c)


def pdf_cltc_matched(wi: Vec3, wo: Vec3, r: Float) -> Float:
    """Density of `sample_cltc_matched`."""
    q = _matched_roughness(r)
    return lerp(pdf_cltc(wi, wo, q), pdf_uniform(), matched_share(wo.z, q))
