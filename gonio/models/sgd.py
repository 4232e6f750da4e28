"""SGD: the shifted gamma distribution of facets, which was fitted to a hundred measured materials.

Source: Bagher, Soler, Holzschuch, "Accurate fitting of measured reflectances using a shifted gamma
micro-facet distribution", Computer Graphics Forum 31(4), 2012. Every number has three channels; K, the
masking and F are free of each other, as in the published fits. Deviations: c (theta - theta_0)^k is
((theta - theta_0) / width)^k with width = c^(-1/k), as c of some fits is above 10^100; F and G are
never below 0.
"""

from typing import NamedTuple

from gonio.albedos.quadrature import NumericAlbedo
from gonio.claims import UNBOUNDED, Claims, Place, at_most, kink
from gonio.lang import (
    INV_PI,
    TWO_PI,
    Color,
    Float,
    Sample,
    Vec2,
    Vec3,
    clamp,
    cos,
    exp,
    fract,
    log,
    maximum,
    minimum,
    normalize,
    select,
    sin,
    smooth_sqrt,
    twice_atan_over,
    vec2,
    vec3,
)
from gonio.model import Model, param
from gonio.parts.frame import cos_half, half_length, half_vector, mirror, pdf_mirror
from gonio.parts.hemisphere import pdf_cosine, sample_cosine
from gonio.parts.lobes import average, choose, shares
from gonio.parts.special import expm1, log1p

# Smallest alpha: of the fits, 1.6e-5 is the least.
ALPHA_SGD = 1e-5

# Nearer to 1 than this, 1 - p is taken as this: what is divided by it differs by as little.
POWER_MIN = 1e-4

# Largest x of exp(x) in the masking, where G of all fits is 0 before; and the smallest, where
# 1.8e-35 of Lambda changes no G and still is a normal float32.
LOG_MAX, LOG_MIN = 3.0, -80.0

# Largest squared slope over alpha, where D is 0 in every precision.
SLOPE_MAX = 1e4

# Largest 1 / (mu_i mu_o), at cosines of 1e-4: times D and its derivatives it still is a float32.
V_SGD = 1e8

# Angles and squared cosines below which a logarithm or quotient leaves a float32.
ANGLE_MIN, COS2_MIN = 1e-12, 1e-30


class ShiftedGamma(NamedTuple):
    """Densities of one channel's facets for samples: s^-p up to s = 1, and exp(1 - s) beyond.

    s is alpha + tan^2 / alpha. The distribution itself, s^-p exp(-s), has no inverse; it is at most the one
    for samples, and at least a third of that before s = 1.
    """

    alpha: Float
    """Shift, and width of the squared slopes."""
    p: Float
    """Power of the tail."""

    def near(self) -> Float:
        """The integral of s^-p from alpha to 1; that of the rest is 1."""
        q = self._one_less()
        return -expm1(q * log(self.alpha)) / q

    def density(self, m: Vec3) -> Float:
        """Of normals in 1/sr."""
        z2 = maximum(m.z * m.z, COS2_MIN)
        x = minimum((m.x * m.x + m.y * m.y) / z2 / self.alpha, SLOPE_MAX)
        s = self.alpha + x
        tail = select(s < 1, exp(-self.p * log(minimum(s, 1))), exp(minimum(1 - s, 0)))
        return INV_PI * tail / ((self.near() + 1) * self.alpha) / z2 * (m.z / z2)

    def sample(self, u: Vec2) -> Vec3:
        """A normal."""
        near, q = self.near(), self._one_less()
        v = u.x * (near + 1)
        inside = v < near
        # s = alpha (1 + q v alpha^-q)^(1/q), less alpha
        grown = log1p(q * minimum(v, near) * exp(-q * log(self.alpha))) / q
        x = self.alpha * expm1(grown)
        far = 1 - self.alpha - log(maximum(1 + near - v, ANGLE_MIN))
        tangent = smooth_sqrt(self.alpha * maximum(select(inside, x, far), 0))
        phi = TWO_PI * u.y
        return normalize(vec3(tangent * cos(phi), tangent * sin(phi), 1))

    def _one_less(self) -> Float:
        """1 - p, not quite 0."""
        q = 1 - self.p
        return select(q < 0, minimum(q, -POWER_MIN), maximum(q, POWER_MIN))


class SGD(Model):
    """Paints, metals and plastics as they were measured; the default is a gold paint. Reciprocal."""

    numeric = NumericAlbedo("half_vectors")

    rho: Color = param((0.147708, 0.0806975, 0.033172), 0, 1, "diffuse albedo, linear RGB")
    specular: Color = param(
        (0.160592, 0.217282, 0.236425), 0, 10, "weight of the highlight, linear RGB"
    )
    alpha: Color = param(
        (0.122506, 0.108069, 0.12187),
        ALPHA_SGD,
        1,
        "shift, and width of the squared slopes",
        kind="slope",
    )
    p: Color = param((0.795078, 0.637578, 0.936117), 0, 2, "power of the distribution's tail")
    f0: Color = param((0, 0, 0.0024589), 0, 10, "F's constant")
    f1: Color = param(
        (-0.596835, -0.331147, -0.140729), -2, 10, "F's slope: f0 - f1 at normal incidence"
    )
    normalization: Color = param(
        (5.98176, 7.35539, 5.29722),
        0,
        1e5,
        "K: 1 / (alpha Gamma(1 - p, alpha)) where D is normalized",
    )
    masking_strength: Color = param((2.64832, 3.04253, 2.3013), 0, 1e8, "Lambda")
    masking_angle: Color = param(
        (-0.284195, -0.277297, -0.245352), -1, 1.5, "theta_0 in radians: G is 1 up to there"
    )
    masking_width: Color = param(
        (1.943735, 1.94587, 1.890624), 0.01, 100, "c^(-1/k): radians from there on"
    )
    masking_exponent: Color = param(
        (24.3593, 24.4037, 25.3623), 1, 1000, "k: how suddenly masking begins"
    )
    caveats = (
        "K, F and G are numbers of fits: nothing keeps the albedo below 1, and nothing bounds it at "
        "grazing angles, where they are divided by the cosines.",
        "Where F passes through 0, as it does with a positive f1, float32 keeps an accuracy of its terms, "
        "f0 and f1 cos, not of their difference: 1e-4 elsewhere.",
        "Wastes the samples that a facet mirrors below the horizon.",
    )
    claims = Claims(
        energy=at_most(UNBOUNDED),
        wasted=at_most(0.51),
        float32=at_most(UNBOUNDED),
        # Where masking is a step; 0.014 in 999 of 1,000 settings
        numeric_albedo=at_most(0.15),
        kinks=kink(Place.ELSEWHERE),
    )

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """rho / pi + specular / pi F D G / (mu_i mu_o): BRDF value in 1/sr, without the cosine."""
        m = half_vector(wi, wo)
        G = self._G(wi) * self._G(wo)
        D = self._D(m) * minimum(1 / wi.z / wo.z, V_SGD)
        return INV_PI * (self.rho + self.specular * self._F(cos_half(wi, wo)) * (G * D))

    def sample(self, wo: Vec3, u: Vec2) -> Sample:
        """Cosine-weighted, or wo mirrored at a normal of one of the channels."""
        matte, v = choose(self._shares(wo).x, u)
        thirds = 3 * v.x
        w = vec2(fract(thirds), v.y)
        m = self._red().sample(w)
        m = select(thirds < 1, m, self._green().sample(w))
        m = select(thirds < 2, m, self._blue().sample(w))
        wi = select(matte, sample_cosine(v), mirror(wo, m))
        return Sample(wi, self.pdf(wi, wo))

    def pdf(self, wi: Vec3, wo: Vec3) -> Float:
        """Density of `sample` in 1/sr."""
        P, m = self._shares(wo), half_vector(wi, wo)
        facets = self._red().density(m) + self._green().density(m)
        facets = (facets + self._blue().density(m)) / 3
        return P.x * pdf_cosine(wi) + P.y * pdf_mirror(facets, half_length(wi, wo))

    def _red(self) -> ShiftedGamma:
        """The facets of a channel."""
        return ShiftedGamma(self.alpha.x, self.p.x)

    def _green(self) -> ShiftedGamma:
        """The facets of a channel."""
        return ShiftedGamma(self.alpha.y, self.p.y)

    def _blue(self) -> ShiftedGamma:
        """The facets of a channel."""
        return ShiftedGamma(self.alpha.z, self.p.z)

    def _D(self, m: Vec3) -> Color:
        """K s^-p exp(-s) / cos^4 with s = alpha + tan^2 / alpha."""
        z2 = maximum(m.z * m.z, COS2_MIN)
        s = self.alpha + minimum((m.x * m.x + m.y * m.y) / z2 / self.alpha, SLOPE_MAX)
        return self.normalization * exp(-self.p * log(s) - s - 2 * log(z2))

    def _F(self, cos_h: Float) -> Color:
        """Schlick's with a slope."""
        c = 1 - minimum(cos_h, 1)
        c5 = c * c * (c * c) * c
        return maximum(self.f0 - self.f1 * cos_h + (1 - self.f0) * c5, 0)

    def _G(self, w: Vec3) -> Color:
        """1 + Lambda (1 - exp(((theta - theta_0) / width)^k))."""
        v = smooth_sqrt(w.x * w.x + w.y * w.y) / (1 + w.z)
        beyond = v * twice_atan_over(v) - self.masking_angle
        x = log(maximum(beyond, ANGLE_MIN)) - log(self.masking_width)
        t = maximum(minimum(self.masking_exponent * x, LOG_MAX), LOG_MIN)
        # expm1 of each channel
        lost = exp(t)
        masked = self.masking_strength * vec3(expm1(lost.x), expm1(lost.y), expm1(lost.z))
        return select(beyond > 0, clamp(1 - masked, 0, 1), 1)

    def _shares(self, wo: Vec3) -> Vec2:
        """Probabilities of the diffuse part and of the highlight, as if it was a mirror."""
        near = vec3(self._red().near(), self._green().near(), self._blue().near())
        mass = self.normalization * self.alpha * (near + 1)
        return shares(average(self.rho), 4 * average(self.specular * self._F(wo.z) * mass))
