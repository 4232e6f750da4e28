"""Distributions of microfacet normals. One is a value: its kind and its widths, with functions of it.

`GGX(alpha_x, alpha_y).D(m)` is the density of facets with the normal m, a unit vector in the local frame.
Every D is per steradian and normalised such that the integral of D(m) m.z over the hemisphere is 1.
`sample` gives normals with the density `density`, in most cases D m.z; `sample_visible` those that a
direction sees. What Smith's masking needs of a distribution is `area`: all of the facets, whichever way
they face, as large as w sees them, the integral of |w . m| D(m). It is mu (1 + 2 Lambda), and
gonio.parts.masking makes Lambda, G1 and G of it.

Some also have D_along, which exports call in the place of D at a half vector. It takes the vector's slopes
in the place of making it unit, and has no derivatives where light and viewer are opposite and at the
horizon. There h is as short as 2e-18: GPUs take the squares of its tangential part for 0, and slopes are
what is left of a sharp highlight's shape.

alpha is the width of the distribution of slopes, from ALPHA_MIN to 1: Disney's and Unity's "roughness" r is
perceptual, alpha = r^2. Anisotropic ones have a width along x and one along y; the round ones are the same
with one width, by fewer operations.

Everything is written with m.z and the tangential part x^2 + y^2, whose digits survive near the normal;
1 - m.z^2 loses them, and with them a sharp highlight.

Sources:
Walter et al., "Microfacet models for refraction through rough surfaces", EGSR 2007: Beckmann, GGX, Phong;
Burley, "Physically-based shading at Disney", SIGGRAPH 2012 course, appendix B: GTR1, anisotropic GGX;
Cook, Torrance, "A reflectance model for computer graphics", 1982: Gaussian (its c is left open);
Dupuy, Benyoub, "Sampling visible GGX normals with spherical caps", HPG 2023;
Eto, Tokuyoshi, "Bounded VNDF sampling for Smith-GGX reflections", SIGGRAPH Asia 2023 technical
communications: normals that mirror a direction below the horizon are left out, as far as a cap can;
Heitz, "Understanding the masking-shadowing function in microfacet-based BRDFs", JCGT 2014: Lambda;
Jakob, "An improved visible normal sampling routine for the Beckmann distribution", 2014.
"""

from typing import NamedTuple, Protocol

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
    polynomial,
    safe_asin,
    safe_sqrt,
    select,
    sin,
    sqrt,
    vec2,
    vec3,
)
from gonio.parts.frame import azimuth, slopes, tangent2
from gonio.parts.special import expm1, log1p_over, log_cos, log_cos_along

# Sharpest facets: a float32 direction is good to 6e-8, a thousandth of this width, so the shape of the
# highlight is still resolved. The peak of D, 3e7, and its derivatives fit into a float32.
ALPHA_MIN = 1e-4

# Square of the cosine below which exp(-tan^2 / alpha^2) is 0 in any precision, for alpha up to 3.2.
COS2_MIN = 1e-6

INV_SQRT_PI = 0.5641895835477563

# 1 / sqrt(pi) - a exp(a^2) erfc(a) for a in [0, 7] as a quotient of polynomials, fitted to 60-digit values:
# error 3e-13 of it, 4e-7 in float32.
HIDDEN = (
    0.69845668195865953,
    0.45091098194948209,
    0.18020567226429097,
    0.046307835742194616,
    0.0072355941096782704,
    0.00054520946640526365,
)
OVER = (
    3.0104360865050833,
    4.1350779419232581,
    3.400222721627325,
    1.8411862936812916,
    0.6773434834307543,
    0.1670522584842057,
    0.025649673226458815,
    0.0019327141136208884,
)

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


class Facets(Protocol):
    """What a masking asks of a distribution."""

    def D(self, m: Vec3) -> Float:
        """Density of facets with the normal m, in 1/sr."""

    def area(self, w: Vec3) -> Float:
        """mu (1 + 2 Lambda): the integral of |w . m| D(m), all facets as large as w sees them."""


def anisotropic_alpha(alpha: Float, anisotropy: Float) -> Vec2:
    """Widths along x and y: aspect sqrt(1 - 0.9 anisotropy), their product remains alpha^2.

    Burley, appendix B, without its lower limit.
    """
    aspect2 = 1 - 0.9 * anisotropy
    stretch = 1 / sqrt(aspect2)
    return vec2(alpha * stretch, alpha * (aspect2 * stretch))


def pdf_visible(facets: Facets, wo: Vec3, m: Vec3) -> Float:
    """Density of wo mirrored at a visible normal m, in 1/sr: G1(wo) D / (4 mu_o)."""
    return 0.5 * facets.D(m) / (wo.z + facets.area(wo))


def pdf_bounded(facets: Facets, wo: Vec3, m: Vec3, bound: Float) -> Float:
    """Density of wo mirrored at a visible normal m that a bound leaves, in 1/sr."""
    return 0.5 * facets.D(m) / (bound * wo.z + facets.area(wo))


def _polar(tan_theta: Float, u: Float) -> Vec3:
    """A normal with a given slope and the azimuth 2 pi u."""
    phi = TWO_PI * u
    return normalize(vec3(tan_theta * cos(phi), tan_theta * sin(phi), 1))


# --- GGX -------------------------------------------------------------------------------------------


class GGX(NamedTuple):
    """Facets of GGX, also called Trowbridge-Reitz."""

    alpha_x: Float
    """width of the slopes along x"""
    alpha_y: Float
    """width of the slopes along y"""

    def D(self, m: Vec3) -> Float:
        """Density of facets, in 1/sr. Walter et al., Eq. 33; Burley, Eq. 13 (anisotropic)."""
        # (N.H)^2 (alpha^2 - 1) + 1 = alpha^2 ((x^2 + y^2) / alpha^2 + z^2), without its cancellation
        v = vec3(m.x / self.alpha_x, m.y / self.alpha_y, m.z)
        s = dot(v, v)
        return INV_PI / (self.alpha_x * self.alpha_y * s * s)

    def D_along(self, h: Vec3) -> Float:
        """Density of facets at the normal along h, which need not be unit, in 1/sr."""
        t = slopes(h)
        # By slopes, s is (1 + (x / alpha_x)^2 + (y / alpha_y)^2) / (1 + x^2 + y^2). Times the squares of
        # both widths no width is a divisor, and the steepest slopes, 1e18, have squares.
        x, y = self.alpha_y * t.x, self.alpha_x * t.y
        a2 = self.alpha_x * self.alpha_y
        r = a2 * (1 + (t.x * t.x + t.y * t.y)) / (a2 * a2 + x * x + y * y)
        return INV_PI * a2 * (r * r)

    def area(self, w: Vec3) -> Float:
        """mu (1 + 2 Lambda) = sqrt(mu^2 + alpha^2 sin^2(theta)), of which Smith's masking is made."""
        return length(vec3(self.alpha_x * w.x, self.alpha_y * w.y, w.z))

    def sample(self, u: Vec2) -> Vec3:
        """A normal with density D m.z. Walter et al., Eq. 35 and 36."""
        r = safe_sqrt(u.x)
        phi = TWO_PI * u.y
        x, y = self.alpha_x * r * cos(phi), self.alpha_y * r * sin(phi)
        return normalize(vec3(x, y, safe_sqrt(1 - u.x) + MU_MIN))

    def density(self, m: Vec3) -> Float:
        """Density of `sample` in 1/sr."""
        return self.D(m) * m.z

    def sample_visible(self, wo: Vec3, u: Vec2) -> Vec3:
        """A normal that wo sees, in proportion to max(wo . m, 0) D(m). Dupuy and Benyoub, Listing 3."""
        w = self._unstretched(wo)
        # u = 1 would be the facet opposite to w, whose half vector has no direction
        u1 = minimum(u.x, 1 - RANDOM_MARGIN)
        # A cap down to z = -w.z: z = 1 - u (1 + w.z)
        height = 1 + w.z
        return self._half_way(w, u1 * height, (1 - u1) * height, u.y)

    def sample_bounded(self, wo: Vec3, u: Vec2, bound: Float) -> Vec3:
        """A normal that wo sees, without those that mirror wo below the horizon, or most of them.

        Eto and Tokuyoshi, "Bounded VNDF sampling for Smith-GGX reflections", 2023; bound: see `ggx_bound`.
        """
        w = self._unstretched(wo)
        u1 = minimum(u.x, 1 - RANDOM_MARGIN)
        # A cap down to z = -bound w.z: z = 1 - u (1 + bound w.z), and z + w.z as a sum of positive terms
        height = 1 + bound * w.z
        return self._half_way(w, u1 * height, (1 - u1) * height + (1 - bound) * w.z, u.y)

    def _unstretched(self, w: Vec3) -> Vec3:
        """w where all facets are those of a unit sphere."""
        return normalize(vec3(self.alpha_x * w.x, self.alpha_y * w.y, w.z))

    def _half_way(self, w: Vec3, drop: Float, z: Float, v: Float) -> Vec3:
        """The facet half way from w to the height 1 - drop of the unit sphere; z: both heights together."""
        r = safe_sqrt(drop * (2 - drop))
        phi = TWO_PI * v
        h = vec3(r * cos(phi) + w.x, r * sin(phi) + w.y, z)
        return normalize(vec3(self.alpha_x * h.x, self.alpha_y * h.y, h.z))


class RoundGGX(NamedTuple):
    """Facets of GGX with the same width in all directions."""

    alpha: Float
    """width of the slopes"""

    def D(self, m: Vec3) -> Float:
        """Density of facets, in 1/sr. Walter et al., Eq. 33."""
        a2 = self.alpha * self.alpha
        s = a2 + (1 - a2) * (m.x * m.x + m.y * m.y)
        return INV_PI * a2 / (s * s)

    def D_along(self, h: Vec3) -> Float:
        """Density of facets at the normal along h, which need not be unit, in 1/sr."""
        a2, tan2 = self.alpha * self.alpha, tangent2(h)
        r = (1 + tan2) / (a2 + tan2)
        return INV_PI * a2 * (r * r)

    def area(self, w: Vec3) -> Float:
        """mu (1 + 2 Lambda) = sqrt(mu^2 + alpha^2 sin^2(theta)), of which Smith's masking is made."""
        a2 = self.alpha * self.alpha
        return sqrt(a2 + (1 - a2) * (w.z * w.z))

    def hidden(self, w: Vec3) -> Float:
        """2 mu Lambda, `area` without mu, exact where it is little."""
        # The difference would have few digits, which count beside a coat that transmits as little
        rest = self.alpha * self.alpha * ((1 - w.z) * (1 + w.z))
        return rest / (self.area(w) + w.z)

    def sample(self, u: Vec2) -> Vec3:
        """A normal with density D m.z."""
        return GGX(self.alpha, self.alpha).sample(u)

    def density(self, m: Vec3) -> Float:
        """Density of `sample` in 1/sr."""
        return self.D(m) * m.z

    def sample_visible(self, wo: Vec3, u: Vec2) -> Vec3:
        """A normal that wo sees, in proportion to max(wo . m, 0) D(m); see `GGX.sample_visible`."""
        return GGX(self.alpha, self.alpha).sample_visible(wo, u)

    def sample_bounded(self, wo: Vec3, u: Vec2, bound: Float) -> Vec3:
        """A normal that wo sees, without most that mirror wo downwards; see `GGX.sample_bounded`."""
        return GGX(self.alpha, self.alpha).sample_bounded(wo, u, bound)


def ggx_bound(least: Float, wo: Vec3) -> Float:
    """How far down the cap of visible normals goes that mirror wo above the horizon; 1: all the way.

    Eto and Tokuyoshi, Eq. 5 and 6; least: the smaller width, at most 1. No normal is left out that would
    mirror wo above the horizon. Of facets of one width 5 % at most of the others are left.
    """
    s = 1 + safe_sqrt(wo.x * wo.x + wo.y * wo.y)
    a2, s2 = least * least, s * s
    return (1 - a2) * s2 / (s2 + a2 * wo.z * wo.z)


# --- Beckmann --------------------------------------------------------------------------------------


class Beckmann(NamedTuple):
    """Beckmann's facets: slopes with a normal distribution of variance alpha^2 / 2."""

    alpha_x: Float
    """width of the slopes along x"""
    alpha_y: Float
    """width of the slopes along y"""

    def D(self, m: Vec3) -> Float:
        """Density of facets, in 1/sr. Walter et al., Eq. 25."""
        inv_cos2 = 1 / maximum(m.z * m.z, COS2_MIN)
        x, y = m.x / self.alpha_x, m.y / self.alpha_y
        slope2 = (x * x + y * y) * inv_cos2
        # Separate quotients: the square of their common denominator would leave a float32's range
        return INV_PI / (self.alpha_x * self.alpha_y) * inv_cos2 * inv_cos2 * exp(-slope2)

    def sine(self, w: Vec3) -> Float:
        """alpha sin(theta), with the width of the facets along w; at least MU_MIN."""
        x, y = self.alpha_x * w.x, self.alpha_y * w.y
        return sqrt(maximum(x * x + y * y, MU_MIN * MU_MIN))

    def area(self, w: Vec3) -> Float:
        """mu (1 + 2 Lambda) of Smith's masking. Heitz 2014, Eq. 66."""
        return w.z + _beckmann_hidden(w.z, self.sine(w))

    def sample(self, u: Vec2) -> Vec3:
        """A normal with density D m.z. Walter et al., Eq. 28 and 29."""
        r = safe_sqrt(-log(maximum(1 - u.x, RANDOM_MARGIN)))
        phi = TWO_PI * u.y
        return normalize(vec3(self.alpha_x * r * cos(phi), self.alpha_y * r * sin(phi), 1))

    def density(self, m: Vec3) -> Float:
        """Density of `sample` in 1/sr."""
        return self.D(m) * m.z

    def sample_visible(self, wo: Vec3, u: Vec2) -> Vec3:
        """A normal that wo sees, in proportion to max(wo . m, 0) D(m), after Jakob (2014).

        The slope towards wo has no inverse in closed form: it is found by Newton's method in the domain of
        erf, from a guess that is exact at normal incidence.
        """
        w = normalize(vec3(self.alpha_x * wo.x, self.alpha_y * wo.y, wo.z))
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
        return normalize(vec3(-self.alpha_x * slope_x, -self.alpha_y * slope_y, 1))


class RoundBeckmann(NamedTuple):
    """Beckmann's facets with the same width in all directions."""

    alpha: Float
    """width of the slopes"""

    def D(self, m: Vec3) -> Float:
        """Density of facets, in 1/sr. Walter et al., Eq. 25."""
        inv_cos2 = 1 / maximum(m.z * m.z, COS2_MIN)
        inv_a2 = 1 / (self.alpha * self.alpha)
        sin2 = m.x * m.x + m.y * m.y
        return INV_PI * inv_a2 * inv_cos2 * inv_cos2 * exp(-sin2 * inv_cos2 * inv_a2)

    def D_along(self, h: Vec3) -> Float:
        """Density of facets at the normal along h, which need not be unit, in 1/sr."""
        inv_a2, tan2 = 1 / (self.alpha * self.alpha), tangent2(h)
        # The root of D, as 1 / cos^4 leaves a float32 where the exponential is 0
        root = (1 + tan2) * exp(-0.5 * tan2 * inv_a2)
        return INV_PI * inv_a2 * (root * root)

    def sine(self, w: Vec3) -> Float:
        """alpha sin(theta); at least MU_MIN."""
        return maximum(self.alpha * safe_sqrt(w.x * w.x + w.y * w.y), MU_MIN)

    def area(self, w: Vec3) -> Float:
        """mu (1 + 2 Lambda) of Smith's masking. Heitz 2014, Eq. 66."""
        return w.z + _beckmann_hidden(w.z, self.sine(w))

    def hidden(self, w: Vec3) -> Float:
        """2 mu Lambda, `area` without mu, exact where it is little: D has no tail there."""
        return _beckmann_hidden(w.z, self.sine(w))

    def sample(self, u: Vec2) -> Vec3:
        """A normal with density D m.z."""
        return Beckmann(self.alpha, self.alpha).sample(u)

    def density(self, m: Vec3) -> Float:
        """Density of `sample` in 1/sr."""
        return self.D(m) * m.z


def _beckmann_hidden(mu: Float, sine: Float) -> Float:
    """2 mu Lambda: sine exp(-a^2) / sqrt(pi) - mu erfc(a) with a = mu / sine = 1 / (alpha tan(theta))."""
    # Lambda is smaller than 1e-22 from there on, and the limit keeps a^2 in range
    a = minimum(mu / sine, 7)
    hidden = polynomial(a, 7, INV_SQRT_PI, *HIDDEN) / polynomial(a, 7, 1, *OVER)
    return sine * exp(-a * a) * hidden


def _newton(x: Float, target: Float, w: Vec3, sine: Float) -> Float:
    """One step towards the visible slope erfinv(x) with the given cumulated area, times w.z."""
    slope = erfinv(x)
    value = w.z * (1 + x) + INV_SQRT_PI * sine * exp(-slope * slope) - target
    slant = maximum(w.z - slope * sine, MU_MIN)
    return clamp(x - value / slant, RANDOM_MARGIN - 1, 1 - RANDOM_MARGIN)


# --- Blinn-Phong -----------------------------------------------------------------------------------


def blinn_phong_exponent(alpha: Float) -> Float:
    """n of (N.H)^n that matches a width: 2 / alpha^2 - 2, from 0 at alpha = 1."""
    return 2 / (alpha * alpha) - 2


def blinn_phong_alpha(exponent: Float) -> Float:
    """The width that matches an exponent n: sqrt(2 / (n + 2))."""
    return sqrt(2 / (exponent + 2))


class BlinnPhong(NamedTuple):
    """Blinn-Phong's facets, (n + 2) / (2 pi) (N.H)^n with n = 2 / alpha^2 - 2."""

    alpha: Float
    """width of the slopes"""

    def D(self, m: Vec3) -> Float:
        """Density of facets, in 1/sr. Walter et al., Eq. 30."""
        return self._at(log_cos(m))

    def D_along(self, h: Vec3) -> Float:
        """Density of facets at the normal along h, which need not be unit, in 1/sr."""
        return self._at(log_cos_along(h))

    def _at(self, log_cosine: Float) -> Float:
        """Density of facets by the logarithm of their cosine."""
        alpha = self.alpha
        a2 = alpha * alpha
        return INV_PI / a2 * exp(2 * log_cosine * ((1 - alpha) * (1 + alpha) / a2))

    def sample(self, u: Vec2) -> Vec3:
        """A normal with density D m.z. Walter et al., Eq. 32 and 33: cos = u^(1 / (n + 2))."""
        tan2 = expm1(-self.alpha * self.alpha * log(maximum(1 - u.x, RANDOM_MARGIN)))
        return _polar(safe_sqrt(tan2), u.y)

    def density(self, m: Vec3) -> Float:
        """Density of `sample` in 1/sr."""
        return self.D(m) * m.z


# --- Gaussian --------------------------------------------------------------------------------------


class Gaussian(NamedTuple):
    """Facets with a Gaussian of the angle, c exp(-(theta / alpha)^2). Cook and Torrance."""

    alpha: Float
    """width of the angles"""

    def D(self, m: Vec3) -> Float:
        """Density of facets, in 1/sr; with c normalised."""
        t = _angle(m) / self.alpha
        return INV_PI / (self.alpha * self.alpha * self.norm()) * exp(-t * t)

    def norm(self) -> Float:
        """Integral of exp(-(theta / alpha)^2) cos(theta) over the hemisphere, over pi alpha^2.

        Error 1e-13.
        """
        q = self.alpha * self.alpha
        d = DAWSON_6 + q * (DAWSON_7 + q * (DAWSON_8 + q * (DAWSON_9 + q * DAWSON_10)))
        d = DAWSON_2 + q * (DAWSON_3 + q * (DAWSON_4 + q * (DAWSON_5 + q * d)))
        b = BEYOND_4 + q * (BEYOND_5 + q * (BEYOND_6 + q * (BEYOND_7 + q * BEYOND_8)))
        b = BEYOND_0 + q * (BEYOND_1 + q * (BEYOND_2 + q * (BEYOND_3 + q * b)))
        return DAWSON_0 + q * (DAWSON_1 + q * d) + exp(-PI * PI / (4 * q)) * q * b

    def covered(self) -> Float:
        """Share of a plane Gaussian that lies within the angle pi / 2."""
        return 1 - exp(-PI * PI / (4 * self.alpha * self.alpha))

    def sample(self, u: Vec2) -> Vec3:
        """A normal whose angle follows a plane Gaussian, nearly D m.z; see `density`."""
        theta = self.alpha * safe_sqrt(-log(maximum(1 - u.x * self.covered(), RANDOM_MARGIN)))
        phi = TWO_PI * u.y
        s = sin(theta)
        return vec3(s * cos(phi), s * sin(phi), cos(theta))

    def density(self, m: Vec3) -> Float:
        """Density of `sample` in 1/sr; at least D m.z / 1.68."""
        theta = _angle(m)
        t = theta / self.alpha
        sine = safe_sqrt(m.x * m.x + m.y * m.y)
        ratio = select(sine > MU_MIN, theta / maximum(sine, MU_MIN), 1)
        return INV_PI / (self.alpha * self.alpha * self.covered()) * ratio * exp(-t * t)


def _angle(m: Vec3) -> Float:
    """Angle between m and the normal, exact at both ends of its range."""
    sine = safe_sqrt(m.x * m.x + m.y * m.y)
    return select(
        sine < m.z, safe_asin(minimum(sine, 0.75)), PI / 2 - safe_asin(minimum(m.z, 0.75))
    )


# --- GTR1 ------------------------------------------------------------------------------------------


class GTR1(NamedTuple):
    """Generalised Trowbridge-Reitz with exponent 1: the facets of Disney's clearcoat."""

    alpha: Float
    """width of the slopes"""

    def D(self, m: Vec3) -> Float:
        """Density of facets, in 1/sr. Burley, Eq. 4."""
        # log(alpha^2) / (alpha^2 - 1) goes to 1 at alpha = 1, and needs the plain logarithm far from it
        a2 = self.alpha * self.alpha
        below_one = (self.alpha - 1) * (self.alpha + 1)
        far = minimum(below_one, -0.2)
        ratio = select(below_one < -0.2, log(a2) / far, log1p_over(maximum(below_one, -0.2)))
        return INV_PI / (ratio * (m.x * m.x + m.y * m.y + a2 * m.z * m.z))

    def D_narrow(self, m: Vec3) -> Float:
        """Density of facets in 1/sr for alpha up to 0.5, where nothing cancels in its norm."""
        a2 = self.alpha * self.alpha
        below_one = 1 - a2
        return INV_PI * below_one / (-log(a2) * (a2 + below_one * (m.x * m.x + m.y * m.y)))

    def D_narrow_along(self, h: Vec3) -> Float:
        """`D_narrow` at the normal along h, which need not be unit."""
        a2, tan2 = self.alpha * self.alpha, tangent2(h)
        return INV_PI * (1 - a2) * (1 + tan2) / (-log(a2) * (a2 + tan2))

    def sample(self, u: Vec2) -> Vec3:
        """A normal with density D m.z. Burley, Eq. 5."""
        # sin^2 = alpha^2 (alpha^(-2 u) - 1) / (1 - alpha^2); both differences vanish at alpha = 1
        a2 = self.alpha * self.alpha
        log_a2 = log(a2)
        below_one = (self.alpha - 1) * (self.alpha + 1)
        down, up = expm1(-u.x * log_a2), expm1((1 - u.x) * log_a2)
        # tan^2 = sin^2 / cos^2 with cos^2 = (1 - alpha^(2 - 2 u)) / (1 - alpha^2)
        round_ = below_one > -1e-6
        tan2 = select(
            round_, u.x / (1 - u.x + RANDOM_MARGIN), a2 * down / maximum(-up, RANDOM_MARGIN * a2)
        )
        return _polar(safe_sqrt(tan2), u.y)
