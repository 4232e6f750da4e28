"""Surfaces between two clear media: how a walk is scattered by them, and how two directions connect.

Everything here is local to the side a walk comes from: a is a unit vector on that side (a.z > 0), eta the
index of the other side over that of this one. Transport is counted in f* = f / n^2 and in n^2 times the
solid angle, with which reflection and refraction are both symmetric and no factor depends on which end of
a path is the light (Veach, "Robust Monte Carlo methods for light transport simulation", 1997, chapter 5).

Rough surfaces: Walter et al., "Microfacet models for refraction through rough surfaces", EGSR 2007, with
Smith's masking as the product of both directions' and visible normals. Facets scatter once: what they
mirror below, or refract above, their mean surface is lost.
Smooth surfaces that lie on one another scatter to the same two directions however often light crosses
them, so a pile of them is one `Pile` with the exact sum of that series.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import drjit as dr

from gonio.lang import (
    MU_MIN,
    Color,
    Float,
    Mask,
    Vec2,
    Vec3,
    dot,
    exp,
    maximum,
    minimum,
    select,
    sqrt,
    vec3,
)
from gonio.parts.distribution import (
    GGX,
    Beckmann,
    RoundBeckmann,
    RoundGGX,
)
from gonio.parts.frame import mirror
from gonio.parts.fresnel import F_dielectric, refracted_cos2, transmittance

# Smallest probability and squared length that are divided by.
TINY = 1e-20

# Largest sum of densities of rivals: times a density of 1e8 or over a small one it stays in a float32, and
# a way that has such rivals has no share left.
RIVALS_MAX = 1e18


class Bend(NamedTuple):
    """What a smooth pile does to light that meets it at one angle."""

    reflected: Color | Float
    transmitted: Color | Float
    cos_out: Float
    """Cosine of the refracted direction on the other side; 0 if there is none."""


class Event(NamedTuple):
    """One scattering of a walk."""

    w: Vec3
    """New direction: w.z > 0 is this side, w.z < 0 the other one."""
    weight: Color | Float
    """f* n^2 cos / density; 0 where the walk ends."""
    density: Float
    """Of w in 1/sr; a smooth surface passes on that of the direction before."""
    transmitted: Mask
    rivals: Float
    """Sum of the densities of the other ways to come here, over that of the walk; see `walk.State`."""


class Connection(NamedTuple):
    """How a walk's direction a and a given direction connect across a surface."""

    value: Float
    """f*, apart from 1 / n^2 of this side."""
    density: Float
    """Density with which the walk's own sampling would take the given direction."""
    light_density: Float
    """Density with which a path of light, refracted without choice, would take a."""


@dataclass(frozen=True)
class Rough:
    """A rough surface, or one of several: parameters may differ between the lanes of a kernel."""

    alpha: Float
    ggx: Any
    """Which distribution: True and False decide in Python, a mask for each lane."""

    def _of(self, ggx: Any, beckmann: Any) -> Any:
        if self.ggx is True:
            return ggx()
        if self.ggx is False:
            return beckmann()
        return select(self.ggx, ggx(), beckmann())

    def D(self, m: Vec3) -> Float:
        """Density of facets' normals."""
        a = self.alpha
        return self._of(lambda: RoundGGX(a).D(m), lambda: RoundBeckmann(a).D(m))

    def per_area(self, w: Vec3) -> Float:
        """G1(w) / w.z, finite in the horizon."""
        a = self.alpha
        return self._of(
            lambda: 2 / maximum(w.z + RoundGGX(a).area(w), MU_MIN),
            lambda: 2 / maximum(w.z + RoundBeckmann(a).area(w), MU_MIN),
        )

    def normal(self, a: Vec3, u: Vec2) -> Vec3:
        """A facet's normal, in proportion to what a sees of it."""
        s = self.alpha
        return self._of(
            lambda: GGX(s, s).sample_visible(a, u), lambda: Beckmann(s, s).sample_visible(a, u)
        )

    def scatter(
        self, a: Vec3, before: tuple[Float, Float], eta: Float, u: Vec2, pick: Float, forced: Any
    ) -> Event:
        """Reflect or refract a walk at a visible facet.

        before: density and rivals of the walk's last direction.
        pick: a random number that chooses between both by Fresnel's F.
        forced: a pair of masks, lanes that must refract and lanes that must reflect; or None.
        """
        m = self.normal(a, u)
        c = minimum(maximum(dot(a, m), MU_MIN), 1)
        T, R = transmittance(c, eta), F_dielectric(c, eta)
        P = T
        if forced is not None:
            P = select(forced[0], 1, select(forced[1], 0, T))
        through = pick < P
        cos_t = sqrt(maximum(refracted_cos2(c, eta), TINY)) / eta
        w = select(through, (c / eta - cos_t) * m - a / eta, mirror(a, m))
        side = select(through, -w.z, w.z)
        seen = vec3(w.x, w.y, maximum(side, 0))
        out = self.per_area(seen)
        share = select(through, T / maximum(P, TINY), R / maximum(1 - P, TINY))
        weight = select(side > 0, share * (seen.z * out), 0)
        D, spread = self.D(m), c - eta * cos_t
        bent = c * cos_t / maximum(spread * spread, TINY)
        density = D * self.per_area(a) * select(through, P * bent * eta * eta, 0.25 * (1 - P))
        light = D * out * bent
        rivals = 1 + select(through, light / maximum(before[0], TINY) * before[1], 0)
        rivals = minimum(rivals, RIVALS_MAX)
        return Event(w, weight, density, through, rivals)

    def light(self, a: Vec3, eta: Float, u: Vec2) -> tuple[Vec3, Float, Float, Float]:
        """Refract a path of light, without a choice.

        Returns its direction back out of the other side (mirrored so that z > 0), the weight
        (1 - F) G1, the density, and the density with which a walk that comes along it from the other
        side would leave along a.
        """
        m = self.normal(a, u)
        c = minimum(maximum(dot(a, m), MU_MIN), 1)
        T = transmittance(c, eta)
        cos_t = sqrt(maximum(refracted_cos2(c, eta), TINY)) / eta
        w = (c / eta - cos_t) * m - a / eta
        d = vec3(w.x, w.y, maximum(-w.z, 0))
        # On the side of the walk that connects, directions leave upwards: the refracted one points down
        d = vec3(-d.x, -d.y, d.z)
        out = self.per_area(d)
        spread = c - eta * cos_t
        lobe = self.D(m) * c * cos_t / maximum(spread * spread, TINY)
        return (
            d,
            select(w.z < 0, T * d.z * out, 0),
            lobe * self.per_area(a) * eta * eta,
            lobe * T * out,
        )

    def connect(self, a: Vec3, b: Vec3, eta: Float, reflecting: Mask) -> Connection:
        """Connect a and b by one facet: b on this side if `reflecting`, else (mirrored) on the other.

        b has b.z > 0 in both cases; for refraction the direction meant is (b.x, b.y, -b.z).
        """
        scale = select(reflecting, 1, eta)
        z = select(reflecting, b.z, -b.z)
        v = vec3(a.x + scale * b.x, a.y + scale * b.y, a.z + scale * z)
        v2 = maximum(dot(v, v), TINY)
        m = v / sqrt(v2)
        m = select(m.z < 0, -m, m)
        am = dot(a, m)
        bm = b.x * m.x + b.y * m.y + z * m.z
        c = minimum(maximum(am, MU_MIN), 1)
        T, R = transmittance(c, eta), F_dielectric(c, eta)
        facing = (am > 0) & (select(reflecting, bm, -bm) > 0)
        D = select(facing, self.D(m), 0)
        per_a, per_b = self.per_area(a), self.per_area(b)
        spread = c * select(reflecting, 0, -bm) / v2
        value = D * per_a * per_b * select(reflecting, 0.25 * R, T * spread)
        density = D * per_a * select(reflecting, 0.25 * R, T * spread * eta * eta)
        return Connection(value, density, D * per_b * spread)


@dataclass(frozen=True)
class Pile:
    """Smooth surfaces one upon another, with absorbing slabs between them."""

    etas: Sequence[Float]
    """Index below over index above, from the top down."""
    depths: Sequence[Color]
    """Optical depths of the slabs between them: one less."""

    def bend(self, c: Float, from_above: bool) -> Bend:
        """Reflectance, transmittance and refraction of light that arrives with the cosine c.

        Light between two surfaces is a geometric series; a surface below is added to those above it
        (Stokes, "On the intensity of the light reflected from or transmitted through a pile of plates",
        1862).
        """
        etas, depths = list(self.etas), list(self.depths)
        if not from_above:
            etas, depths = [1 / eta for eta in reversed(etas)], depths[::-1]
        R = back = F_dielectric(c, etas[0])
        T = transmittance(c, etas[0])
        c = _refracted(c, etas[0])
        for eta, depth in zip(etas[1:], depths, strict=True):
            crossed = exp(-depth / maximum(c, MU_MIN))
            F = F_dielectric(c, eta)
            series = crossed / maximum(1 - back * crossed * crossed * F, TINY)
            passed = transmittance(c, eta)
            R = R + T * T * crossed * F * series
            back = F + passed * passed * back * crossed * series
            T = T * passed * series
            c = _refracted(c, eta)
        return Bend(R, T, c)

    def scatter(
        self,
        a: Vec3,
        before: tuple[Float, Float],
        bend: Bend,
        eta: Float,
        pick: Float,
        forced: Any,
    ) -> Event:
        """Mirror or refract a walk; eta and bend as seen from its side, the rest as for rough surfaces."""
        P = chance(bend)
        if forced is not None:
            P = select(forced[0], 1, select(forced[1], 0, P))
        through = pick < P
        w = select(through, vec3(-a.x / eta, -a.y / eta, -bend.cos_out), vec3(-a.x, -a.y, a.z))
        weight = select(
            through, bend.transmitted / maximum(P, TINY), bend.reflected / maximum(1 - P, TINY)
        )
        density = before[0] * P * compression(a.z, bend.cos_out, eta)
        # Nothing but this walk could have been mirrored here; what was refracted keeps its rivals.
        return Event(w, weight, density, through, select(through, before[1], 0))


def chance(bend: Bend) -> Float:
    """Probability with which a walk is refracted by a pile, not mirrored."""
    T, R = _mean(bend.transmitted), _mean(bend.reflected)
    return T / maximum(T + R, TINY)


def compression(c: Float, cos_out: Float, eta: Float) -> Float:
    """Solid angle before refraction over that after it, which is also how a density changes."""
    return eta * eta * cos_out / maximum(c, MU_MIN)


def channels(colour: Color | Float) -> list[Float]:
    """The channels of a colour, of which there may be more than three; of a number, itself."""
    count = dr.size_v(colour) if dr.is_array_v(colour) else 0
    return [colour[c] for c in range(count)] if count > 0 else [colour]


def _mean(colour: Color | Float) -> Float:
    parts = channels(colour)
    return sum(parts[1:], parts[0]) / len(parts)


def _refracted(c: Float, eta: Float) -> Float:
    """Cosine on the other side; 0 if there is none."""
    return sqrt(maximum(refracted_cos2(c, eta), 0)) / eta
