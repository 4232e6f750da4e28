"""Numeric albedos, for models that have no closed form. A model names one of three rules by `numeric`.

angles: Gauss–Legendre in angles. θi is split at θo, and the azimuth into quarters measured from wo's,
because that is where the published models have their kinks (max(θi, θo), and the sign of cos(φi − φo)).
Nodes crowd at θo from both sides, where a grazing wo makes the integrand steep.

half_vectors: for highlights of any sharpness. The nodes are half vectors m, at slopes t = tan θm that are
spaced like τ sinh y: evenly around m = N, and evenly in log t beyond, so that a lobe of any width α has its
share of them without the rule knowing α; an anisotropic model says by `slope_widths` how wide it is along x
over along y, and gives its round lobes, if it has some, as `eval_round`. For each azimuth of m the slope
ends where wi meets the horizon, t² − 2 t tan θo cos φ = 1, and is split where wi is as high as wo,
t = tan θo cos φ. Computed in double precision, because wi + wo in single precision would blur a sharp lobe.

mirror: for lobes that are round about the mirror direction, as Phong's. The nodes lie on circles around it,
spaced as above; each circle ends in the horizon, and one has its edge at a right angle.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, Protocol, Self

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from gonio.albedos.half_vectors import last_slope, level_of, mirrored, slope_at
from gonio.fields import ModelError
from gonio.lang import Color, Vec2, Vec3, cos, safe_acos, sin, sqrt, vec2, vec3
from gonio.messages import did_you_mean
from gonio.parts.frame import azimuth


@dataclass(frozen=True)
class NumericAlbedo:
    """How the albedo of a model without a closed form is found; a model declares one as `numeric`.

    Raises:
        ModelError: a rule that does not exist, or parts that it does not ask for.
    """

    rule: str = ""
    """"angles", "half_vectors" or "mirror". Without one, `gonio.albedos.numeric` finds the rule that fits;
    inside kernels it is then "angles"."""
    stretched: bool = False
    """Whether the highlight has two widths, which the model's method `slope_widths` gives."""
    round_part: bool = False
    """Whether some of a stretched model is round; its method `eval_round` gives that part."""
    symmetric: bool = False
    """Whether the plane of wo is a mirror for the values; `gonio.albedos.numeric` finds it out."""
    smooth: bool = False
    """Whether half the half vectors do, because values have no kink inside the lobe; as well."""

    def __post_init__(self) -> None:
        """Refuse what no rule can use."""
        if self.rule and self.rule not in RULES:
            raise ModelError(
                f"NumericAlbedo: there is no rule {self.rule!r}; {did_you_mean(self.rule, RULES)}"
                f"allowed are {', '.join(map(repr, RULES))}."
            )
        if self.stretched and self.rule != "half_vectors":
            raise ModelError('NumericAlbedo: only the rule "half_vectors" can be stretched.')
        if self.round_part and not self.stretched:
            raise ModelError(
                "NumericAlbedo: a round_part stands beside a stretched one; add stretched=True."
            )


def check_declared(cls: Any, own: Callable[[str], bool]) -> None:
    """Whether what a class says of its numeric albedo fits together.

    own: whether the class, or one above it, writes a method.

    Raises:
        ModelError: another type, a name that nothing asks for, a method that is missing or unannounced.
    """
    if not isinstance(cls.numeric, NumericAlbedo):
        raise ModelError(
            f'{cls.name}: numeric is a NumericAlbedo, such as NumericAlbedo("mirror"), got {cls.numeric!r}.'
        )
    for name, value in vars(cls).items():
        if isinstance(value, NumericAlbedo) and name != "numeric":
            raise ModelError(
                f"{cls.name}: nothing asks for {name}; the albedo's rule is called numeric."
            )
    for announced, method in (("stretched", "slope_widths"), ("round_part", "eval_round")):
        if getattr(cls.numeric, announced) != own(method):
            has = "has no method" if getattr(cls.numeric, announced) else "has a method"
            raise ModelError(
                f"{cls.name} {has} {method}, which numeric albedos ask for with "
                f'numeric = NumericAlbedo("half_vectors", {announced}=True).'
            )


class Reflecting(Protocol):
    """What the rules ask of a model bound to Dr.Jit values; `gonio.model.Model` has it."""

    numeric: NumericAlbedo
    float_type: Any

    def follows_tangents(self) -> bool:
        """Whether turning both directions about the normal changes the value."""

    def eval(self, wi: Vec3, wo: Vec3) -> Color:
        """BRDF value in 1/sr."""

    def albedo(self, wo: Vec3) -> Color:
        """Directional albedo."""

    def slope_widths(self) -> Vec2:
        """Widths of the highlight's slopes along x and y, up to a factor; of a `stretched` one."""

    def eval_round(self, wi: Vec3, wo: Vec3) -> Color:
        """The part of `eval` that is not stretched; asked for where there is a `round_part`."""

    def parameters(self) -> Iterator[tuple[str, Any, Any]]:
        """Path, declaration and value of every parameter."""

    def bind(self, Float: Any, convert: Callable[[str, Any, Any], Any]) -> Self:
        """A copy whose parameters are converted."""


# Nodes on each smooth piece; tests/test_models.py holds the result against closed forms at 1e-5.
# Fewer leave more than float32 rounding.
THETA_NODES = 16
PHI_NODES = 8
CROWDING = 3

# The same for half vectors (gonio.albedos.half_vectors). The error is below 5e-6 where F and G are smooth
# but for a kink at μi = μo. Others inside the lobe cost digits: 3e-5 for Walter's fit, 3e-4 for Cook and
# Torrance's G, and 1e-2 for the edge of total reflection.
SLOPE_NODES = 112
AZIMUTH_NODES = 16

# What does without kinks: the error is below 1e-6 there, where wo is SMOOTH_FROM above the horizon. Below,
# slopes range so far that it would be 1e-4.
SMOOTH_SLOPE_NODES = 64
SMOOTH_AZIMUTH_NODES = 12
SMOOTH_FROM = 0.01

# The same around the mirror direction. The scale of angles is a third of the sharpest Phong lobe's,
# 1 / sqrt(1e5); the error is below 2e-6.
ANGLE_SCALE = 1e-3
MIRROR_NODES = 96
ARC_NODES = 16

# Means over wo: nodes in the elevation, which crowd in the horizon, where masking sets in at μ near α; and
# azimuths in a quarter turn for anisotropic models.
ELEVATION_NODES = 24
MEAN_AZIMUTHS = 12

# Cosine that stands for wo in the horizon, where f and the cosine have no product but a limit.
HORIZON = 1e-8


@functools.cache
def _table(Float: Any) -> tuple[Any, ...]:
    """Distance from θo, azimuth (cos, sin) and weight of every node, as Dr.Jit arrays."""
    x, w = np.polynomial.legendre.leggauss(THETA_NODES)
    x = (x + 1) / 2
    theta, theta_weight = x**CROWDING, CROWDING * x ** (CROWDING - 1) * w / 2
    x, w = np.polynomial.legendre.leggauss(PHI_NODES)
    phi = 0.5 * np.pi * (np.arange(4)[:, None] + (x + 1) / 2).ravel()
    phi_weight = np.tile(0.25 * np.pi * w, 4)
    return _columns(
        Float,
        np.repeat(theta, len(phi)),
        np.tile(np.cos(phi), len(theta)),
        np.tile(np.sin(phi), len(theta)),
        np.outer(theta_weight, phi_weight).ravel(),
    )


def _columns(Float: Any, *columns: Any) -> tuple[Any, ...]:
    """Columns of a table as Dr.Jit arrays, or as lists for plain Python."""
    return tuple(c.tolist() if Float is float else Float(c) for c in columns)


def _sum(
    table: tuple[Any, ...],
    term: Callable[..., Color],
    zero: Color,
    label: str,
    rows: tuple[Any, Any] | None = None,
) -> Color:
    """The sum of a term over the rows of a table: one loop in a kernel, instead of a copy for each row.

    rows: the first, and the one behind the last; all if none are given.
    """

    def take(column: Any, index: Any) -> Any:
        return column[index] if isinstance(column, list) else dr.gather(type(column), column, index)

    def step(index: Any, total: Any) -> tuple[Any, Any]:
        return index + 1, total + term(*(take(column, index) for column in table))

    start, end = rows or (0, len(table[0]))
    if not isinstance(table[0], list):
        start = dr.uint32_array_t(table[0])(start)
    # Only the sum is carried along, so max_iterations=-1 lets derivatives run the loop again instead of
    # storing every step.
    _, total = dr.while_loop(
        (start, zero), lambda i, _: i < end, step, max_iterations=-1, label=label
    )
    return total


def directional_albedo(model: Reflecting, wo: Vec3) -> Color:
    """∫ f μi dωi over the upper hemisphere, for a model that is already bound to Dr.Jit values."""
    return RULES[model.numeric.rule or "angles"](model, wo)


def _by_angles(model: Reflecting, wo: Vec3) -> Color:
    Float: Any = type(wo.z)
    wo = vec3(wo.x, wo.y, dr.maximum(wo.z, HORIZON))
    theta_o = safe_acos(wo.z)
    axis = azimuth(wo)
    cos_o, sin_o = axis.x, axis.y

    def term(node: Any, c: Any, s: Any, weight: Any) -> Color:
        total: Any = 0
        for extent in (-theta_o, 0.5 * np.pi - theta_o):
            theta = theta_o + node * extent
            sin_theta, cos_theta = sin(theta), cos(theta)
            wi = vec3(
                sin_theta * (c * cos_o - s * sin_o),
                sin_theta * (s * cos_o + c * sin_o),
                cos_theta,
            )
            total = total + model.eval(wi, wo) * (sin_theta * cos_theta * weight * dr.abs(extent))
        return total

    return _sum(_table(Float), term, 0 * model.eval(wo, wo), "albedo")


@functools.cache
def _half_vector_table(Float: Any, symmetric: bool) -> tuple[tuple[Any, ...], int]:
    """Azimuth (cos, sin) of m, place in the range of slopes, and weight of every node; where all begin.

    The nodes that do for smooth values stand first. symmetric: one side of the plane of wo stands for both.
    """
    few = _half_vectors(SMOOTH_SLOPE_NODES, SMOOTH_AZIMUTH_NODES, symmetric)
    every = _half_vectors(SLOPE_NODES, AZIMUTH_NODES, symmetric)
    both = (np.concatenate(columns) for columns in zip(few, every, strict=True))
    return _columns(Float, *both), len(few[0])


def _half_vectors(slopes: int, azimuths: int, symmetric: bool) -> tuple[NDArray[np.float64], ...]:
    x, w = np.polynomial.legendre.leggauss(azimuths)
    x = (x + 1) / 2
    # Crowding at a quarter turn from wo, where m begins to turn away from it
    bend, bend_weight = 0.5 * np.pi * x**CROWDING, 0.25 * np.pi * CROWDING * x ** (CROWDING - 1) * w
    toward, across = np.sin(bend), np.cos(bend)
    sides = (1,) if symmetric else (1, -1)
    c = np.concatenate([sign * toward for sign in (1, -1) for _ in sides])
    s = np.concatenate([side * across for _ in (1, -1) for side in sides])
    x, w = np.polynomial.legendre.leggauss(slopes)
    return (
        np.repeat(c, slopes),
        np.repeat(s, slopes),
        np.tile((x + 1) / 2, len(c)),
        np.outer(np.tile(2 / len(sides) * bend_weight, 2 * len(sides)), w / 2).ravel(),
    )


@functools.cache
def _few_from(Float: Any, smooth: bool) -> Any:
    """The cosine of wo from which few nodes do; known to no kernel, so that one serves both cases."""
    cosine = SMOOTH_FROM if smooth else 2.0
    return dr.opaque(Float, cosine) if dr.is_jit_v(Float) else cosine


def _half_vector_rows(wo: Vec3, numeric: NumericAlbedo) -> tuple[tuple[Any, ...], tuple[Any, Any]]:
    """The table of nodes, and which of its rows are for wo."""
    Float: Any = type(wo.z)
    table, few = _half_vector_table(Float, numeric.symmetric)
    enough = wo.z >= _few_from(Float, numeric.smooth)
    if isinstance(table[0], list):
        return table, (0, few) if enough else (few, len(table[0]))
    Index = dr.uint32_array_t(table[0])
    first = dr.select(enough, Index(0), Index(few))
    return table, (first, dr.select(enough, Index(few), Index(len(table[0]))))


def _double(value: Any) -> Any:
    return dr.float64_array_t(value)(value) if dr.is_array_v(value) else float(value)


def _by_half_vectors(model: Reflecting, wo: Vec3) -> Color:
    single = type(model.eval(wo, wo))
    wo = _double(wo)
    wo = vec3(wo.x, wo.y, dr.maximum(wo.z, HORIZON))
    model = model.bind(type(wo.z), lambda path, declared, value: _double(value))
    widths = model.slope_widths() if model.numeric.stretched else vec2(1, 1)
    numeric = model.numeric
    if not model.numeric.round_part:
        # Azimuths are spread in the plane of slopes over the root of their widths: the lobe becomes
        # rounder, and what is round becomes elliptic by no more than that
        return single(_over_half_vectors(model.eval, wo, sqrt(widths), numeric))
    total = _over_half_vectors(
        lambda i, o: model.eval(i, o) - model.eval_round(i, o), wo, widths, numeric
    )
    return single(total + _over_half_vectors(model.eval_round, wo, vec2(1, 1), numeric))


def _over_half_vectors(
    evaluate: Callable[[Vec3, Vec3], Color], wo: Vec3, width: Vec2, numeric: NumericAlbedo
) -> Color:
    stretched = vec3(width.x * wo.x, width.y * wo.y, wo.z)
    axis = azimuth(stretched)
    sine = sqrt(stretched.x * stretched.x + stretched.y * stretched.y + 1e-30)

    def term(c: Any, s: Any, node: Any, weight: Any) -> Color:
        total: Any = 0
        x = width.x * (c * axis.x - s * axis.y)
        y = width.y * (c * axis.y + s * axis.x)
        inv = dr.rsqrt(x * x + y * y)
        dphi = width.x * width.y * inv * inv
        toward = sine * c * inv
        end = level_of(last_slope(toward, wo.z))
        # Where wi is as high as wo, and max(μi, μo) has a kink
        equal = level_of(dr.maximum(toward, 0) / wo.z)
        for begin, extent in ((0, equal), (equal, end - equal)):
            slope, steepness = slope_at(begin + node * extent)
            wi, area = mirrored(wo, x * inv, y * inv, toward, slope)
            dwi = area * steepness * extent * weight * dphi
            total = total + evaluate(wi, wo) * (wi.z * dwi)
        return total

    table, rows = _half_vector_rows(wo, numeric)
    return _sum(table, term, 0 * evaluate(wo, wo), "albedo", rows)


@functools.cache
def _mirror_table(Float: Any) -> tuple[Any, ...]:
    """Place in a range of angles and in an arc, both in [0, 1], and weight of every node."""
    x, w = np.polynomial.legendre.leggauss(MIRROR_NODES)
    y, v = np.polynomial.legendre.leggauss(ARC_NODES)
    return _columns(
        Float,
        np.repeat((x + 1) / 2, ARC_NODES),
        np.tile((y + 1) / 2, MIRROR_NODES),
        np.outer(w / 2, v / 2).ravel(),
    )


def _around_mirror(model: Reflecting, wo: Vec3) -> Color:
    single = type(model.eval(wo, wo))
    wo = _double(wo)
    wo = vec3(wo.x, wo.y, dr.maximum(wo.z, HORIZON))
    Float: Any = type(wo.z)
    model = model.bind(Float, lambda path, declared, value: _double(value))
    axis = azimuth(wo)
    sine = sqrt(wo.x * wo.x + wo.y * wo.y + 1e-30)
    # Angle between the mirror direction and the horizon, where circles begin to be cut
    low = dr.atan2(wo.z, sine)

    def term(node: Any, turn: Any, weight: Any) -> Color:
        total: Any = 0
        for begin, extent in (
            (0, low),
            (low, 0.5 * np.pi - low),
            (0.5 * np.pi, 0.5 * np.pi - low),
        ):
            # The square, because what a cut takes away grows like a root; and crowding at the other
            # end for a lobe that falls off steeply there, like cos^0.1
            end = dr.asinh(extent / ANGLE_SCALE)
            rest = 1 - node * node
            grown = dr.exp((1 - rest * rest * rest) * end)
            alpha = begin + 0.5 * ANGLE_SCALE * (grown - 1 / grown)
            dalpha = 3 * ANGLE_SCALE * (grown + 1 / grown) * node * rest * rest * end
            c, s = cos(alpha), sin(alpha)
            # Half the arc of the circle that is above the horizon, and the place on it, from its top
            arc = safe_acos(dr.clip(-c * wo.z / dr.maximum(s * sine, 1e-30), -1, 1))
            psi = arc * (2 * turn - 1)
            up, across = s * cos(psi), s * sin(psi)
            outward = c * sine - up * wo.z
            wi = vec3(
                -axis.x * outward + axis.y * across,
                -axis.y * outward - axis.x * across,
                c * wo.z + up * sine,
            )
            total = total + model.eval(wi, wo) * (wi.z * s * dalpha * 2 * arc * weight)
        return total

    return single(_sum(_mirror_table(Float), term, 0 * model.eval(wo, wo), "albedo"))


@functools.cache
def mean_nodes(follows_tangents: bool) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Directions, shape (n, 3), and weights, shape (n,), for the mean (1/π) ∫ E(wo) μo dωo."""
    x, w = np.polynomial.legendre.leggauss(ELEVATION_NODES)
    x = (x + 1) / 2
    elevation = 0.5 * np.pi * x**CROWDING
    weight = 0.5 * np.pi * CROWDING * x ** (CROWDING - 1) * w / 2
    weight *= np.sin(2 * elevation)
    # Models that follow tangents are at least mirror-symmetric, and periodic functions need no more
    # than even steps.
    turns = MEAN_AZIMUTHS if follows_tangents else 1
    azimuth = 0.5 * np.pi * (np.arange(turns) + 0.5) / turns if turns > 1 else np.zeros(1)
    wo = np.stack(
        [
            np.outer(np.cos(elevation), np.cos(azimuth)).ravel(),
            np.outer(np.cos(elevation), np.sin(azimuth)).ravel(),
            np.repeat(np.sin(elevation), turns),
        ],
        axis=-1,
    )
    return wo, np.repeat(weight / turns, turns)


def mean_albedo(model: Reflecting) -> Color:
    """(1/π) ∫ albedo(wo) μo dωo of a model that is already bound to Dr.Jit values."""
    known = vars(model).get(KNOWN_MEAN)
    if known is not None:
        return known
    found = _mean_albedo(model)
    if _is_one(model):
        know_mean(model, found)
    return found


KNOWN_MEAN = "_known_mean"


def know_mean(model: Reflecting, mean: Color) -> None:
    """Let a bound model remember its mean albedo, also where it is asked inside a loop of a kernel."""
    object.__setattr__(model, KNOWN_MEAN, mean)


def _mean_albedo(model: Reflecting) -> Color:
    Float = model.float_type
    wo, weights = mean_nodes(model.follows_tangents())
    if dr.is_jit_v(Float) and _is_one(model):
        x, y, z, weight = _columns(Float, *wo.T, weights)
        # A kernel of its own with a direction in each lane: else every lane of the kernel that asks
        # would sum over all of them
        found = dr.replace_shape_t(Float, (3, -1))(model.albedo(vec3(x, y, z)) * weight)
        return vec3(*(dr.sum(channel) for channel in found))

    def term(x: Any, y: Any, z: Any, weight: Any) -> Color:
        return model.albedo(vec3(x, y, z)) * weight

    up = vec3(Float(0), Float(0), Float(1))
    return _sum(_columns(Float, *wo.T, weights), term, 0 * model.eval(up, up), "mean_albedo")


def _is_one(model: Reflecting) -> bool:
    """Whether a bound model is the same in all lanes, and what is asked of it can be computed at once."""
    if dr.is_jit_v(model.float_type) and dr.flag(dr.JitFlag.SymbolicScope):
        return False
    return all(dr.width(value) == 1 for _, _, value in model.parameters())


# How often each rule asks for a value at one of its nodes.
ASKED = {"angles": 2, "half_vectors": 2, "mirror": 3}


def evaluations(numeric: NumericAlbedo) -> int:
    """How often a rule evaluates the model for one direction, beside once or twice for the types.

    Where values are smooth, for one that is SMOOTH_FROM above the horizon.
    """
    rule = numeric.rule or "angles"
    if rule == "angles":
        nodes = len(_table(float)[0])
    elif rule == "mirror":
        nodes = len(_mirror_table(float)[0])
    else:
        _, (first, end) = _half_vector_rows(vec3(0.0, 0.0, 1.0), numeric)
        nodes = end - first
    # The round part is taken off, and integrated alone
    return nodes * ASKED[rule] * (3 if numeric.round_part else 1)


RULES: dict[str, Callable[[Any, Vec3], Color]] = {
    "angles": _by_angles,
    "half_vectors": _by_half_vectors,
    "mirror": _around_mirror,
}
"""How an albedo is found, by the name that `NumericAlbedo` has."""
