"""Energy: no direction may reflect more than it receives, and white models that say so reflect everything.

The worst albedo is searched for over all angles and parameters with a quick estimate of the integral (half
of its nodes spread over the hemisphere, half drawn by the model's own sampler); the best finds are
integrated adaptively in float64, and only those numbers count.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Any

import drjit as dr
import numpy as np

from gonio.check import hemisphere
from gonio.check.adversarial import hard_parameters, special_parts
from gonio.check.kernels import reflect, sample
from gonio.check.no_number import said
from gonio.check.product_rules import albedos
from gonio.check.report import (
    FAIL,
    NOTE,
    PASS,
    TOO_LARGE,
    UNSURE,
    Effort,
    Finding,
    Report,
    judge,
)
from gonio.check.search import maximise
from gonio.check.subject import (
    Array,
    Subject,
    cosine_at,
    directions,
    even,
    number_type,
    stored,
)
from gonio.check.variants import part_of
from gonio.claims import WhiteFurnace

# Nodes of the quick estimate: so many over the hemisphere, and so many from the sampler.
NODES = 96

# The lowest cosine of wo. In the horizon itself every value is 0.
MU_LOW = 1e-6

# With up to so many coordinates twice the points are affordable: such models are not expensive.
FEW = 6

# One in so many of the points that the search begins with is among the brightest of its first wide look.
BRIGHT = 16

# Tolerance of the adaptive integrals that the search compares, how often it cuts cells, and how often where
# many points are looked at once.
ROUGHLY, SHALLOW, SKETCHY = 2e-5, 5, 2

# From which tolerance on `precise` tries product rules first, and which of the best so far others have to
# reach in the search.
WITH_RULES, BEATEN = 1e-5, 3

# Tolerances below this ask for more digits than float32 has: cells would be cut for its roundings.
SINGLE = 1e-6

# The integrals that count, all adaptive, because product rules may agree and be off by 1e-3: tolerance, how
# often cells are cut, and for how many of the best finds. The second one is for what is within so many of
# the first one's errors of a limit.
INTEGRATED = ((1.5e-5, 9, 2), (SINGLE, hemisphere.LEVELS, 2))
CLEARLY = 10.0

# What the adaptive integral is trusted to, doubled: in the search, and when it is repeated for furnaces.
TRUSTED = 1e-5
FURNACE = 5e-6

# A furnace that is claimed to within this is white to every eye, and may be better than it says.
NEGLIGIBLE = 1e-4

# So many times larger than found a claimed error may be: what is left of a correction has many summits that
# are nearly as high, and searches from different beginnings found between 83 and 100 % of the highest.
MISSED = 1.25

# Points of the first look for it, and of each of so many rounds around the best.
LOOKED_AT, AROUND, CLOSER = 256, 48, 12

# Where an integral errs by more than this, gains of less than so many times the error are not judged.
BLURRED, SURE = 1e-4, 5.0

# What an albedo is, where it is no number.
INTEGRAL = "the integral of eval"

# Angles at which a furnace is shown, and nodes of the mean.
FURNACE_ANGLES = (0.0, 30.0, 60.0, 85.0)
FURNACE_NODES = 12

# Places of a texture at which a furnace is shown.
FURNACE_PLACES = 16

# A gain smaller than this may be hidden by the errors of the estimates that the search begins with, and is
# no more than a size may be too large by: what is documented is then an upper bound only.
HARDLY = 0.03

# Albedos within this of 1 everywhere mean that a model preserves energy.
PRESERVED = 1e-4


def check(subject: Subject, effort: Effort) -> Report:
    """The largest directional albedo, the white furnaces that the model claims, and one it does not."""
    start = time.perf_counter()
    findings = [largest(subject, effort)]
    if subject.claiming:
        findings += _furnaces(subject, effort)
    else:
        findings.append(_in_a_furnace(subject))
    return Report("energy", subject.name, tuple(findings), time.perf_counter() - start)


def _in_a_furnace(subject: Subject) -> Finding:
    """What foreign code reflects of a world that is bright all around, at four angles and on average.

    Textures are looked at in many places; of each angle their mean is told, and the least and most.
    """
    x, w = np.polynomial.legendre.leggauss(FURNACE_NODES)
    mu2 = (x + 1) / 2  # (1/π) ∫ E μ dω = ∫ E dμ²
    mu = np.append(np.cos(np.radians(FURNACE_ANGLES)), np.sqrt(mu2))
    azimuth = np.concatenate(
        [0 * np.array(FURNACE_ANGLES), 2 * np.pi * 0.618034 * np.arange(len(mu2))]
    )
    places = even(FURNACE_PLACES) if subject.textured else subject.default()[None]
    parameters = np.tile(places, (len(mu), 1))
    wo = np.repeat(directions(mu, azimuth), len(places), axis=0)
    tolerance = ROUGHLY if subject.float32 else SINGLE  # four digits are shown
    E = precise(subject, parameters, wo, tolerance).mean(axis=1).reshape(len(mu), len(places))
    shown = ", ".join(
        f"{each.mean():.4f}{_between(each)} at {angle:g}°"
        for each, angle in zip(E, FURNACE_ANGLES, strict=False)
    )
    if len(places) > 1:
        shown += f", over {len(places)} places of uv"
    mean = float((E[len(FURNACE_ANGLES) :].mean(axis=1) * w / 2).sum())
    return Finding("in a white furnace", mean, NOTE, f"mean albedo; {shown}", subject.tag())


def _between(albedos: Array) -> str:
    """The least and the most of several places, where four digits tell them apart."""
    least, most = (f"{x:.4f}" for x in (albedos.min(), albedos.max()))
    return "" if least == most else f" ({least} to {most})"


def viewer(subject: Subject, points: Array, low: float = MU_LOW) -> tuple[Array, Array]:
    """Parameters and wo of points of a search, whose last two coordinates are angles.

    The azimuth counts for models that are meant to be isotropic as well: they may not be. Cosines of wo
    are `low` at least.
    """
    count = len(subject.parameters)
    azimuth = 2 * np.pi * points[:, count + 1]
    mu = np.maximum(cosine_at(points[:, count]), low)
    return points[:, :count], directions(mu, azimuth)


def dimensions(subject: Subject) -> int:
    """Coordinates of such points."""
    return len(subject.parameters) + 2


def starts(subject: Subject) -> Array:
    """The default parameters at several angles, and each of them at both ends; colours white as well."""
    base = subject.default()
    rows = [base]
    for number in range(len(base)):
        for end in (0.0, 1.0):
            row = base.copy()
            row[number] = end
            rows.append(row)
    colours = np.array([f.declared.width == 3 for f in subject.parameters], bool)
    rows += [np.where(colours, 1.0, row) for row in rows]
    angles = np.array([0.01, 0.25, 0.5, 0.97])
    found = [np.append(row, (a, (7.3 * a + 0.1) % 1)) for row in rows for a in angles]
    return np.array(found)


def estimate(subject: Subject, parameters: Array, wo: Array) -> Array:
    """Albedos of points, (points, 3), to about a percent, in one kernel."""
    Float = number_type()
    UInt = dr.uint32_array_t(Float)
    points = len(parameters)
    lane = dr.arange(UInt, points * NODES)
    index = lane // NODES
    node = lane - index * NODES
    Vec = dr.replace_shape_t(Float, (3, -1))
    wo_ = Vec(*(dr.gather(Float, stored(Float, c), index) for c in wo.T))
    a, b = (dr.gather(Float, stored(Float, c), node) for c in even(NODES).T)

    # Three quarters of the nodes around the mirror direction, the others around wo
    side = dr.select((node & 3) == 3, Float(-1), Float(1))

    def density(wi: Any) -> Any:
        """Of the nodes of both kinds together, without the sampler's."""
        found = Float(0)
        for turned, share in ((1.0, 0.75), (-1.0, 0.25)):
            u, v = hemisphere.unchart(wo_, wi, Float(turned))
            _, solid = hemisphere.chart(wo_, u, v, Float(turned))
            found += dr.select(solid > 0, share / dr.select(solid > 0, solid, 1), 0)
        return found

    def part(wi: Any, drawn: Any) -> Any:
        f, pdf = reflect(model, wi, wo_)
        total = density(wi) + pdf
        usable = (total > 0) & (wi.z > 0) & (drawn > 0)
        return dr.select(usable, f * (dr.maximum(wi.z, 0) / dr.select(usable, total, 1)), 0)

    u = dr.replace_shape_t(Float, (2, -1))(a, b)
    wi, _ = hemisphere.chart(wo_, a, b, side)
    dr.eval(index, wo_, u, wi)
    model = subject.at(parameters, index, Float)
    total = part(wi, dr.ones(Float, len(index)))
    dr.eval(total)
    total += part(*sample(model, wo_, u))
    dr.eval(total)
    values = np.stack([c.numpy() for c in total], -1).reshape(points, NODES, 3)
    return np.asarray(values.sum(axis=1) / NODES)


def precise(
    subject: Subject,
    parameters: Array,
    wo: Array,
    tolerance: float = 1e-6,
    levels: int = hemisphere.LEVELS,
) -> Array:
    """Albedos of points, (points, 3): by adaptive integration, from WITH_RULES on as `albedos` has them."""
    if tolerance >= WITH_RULES:
        return albedos(subject, parameters, wo, tolerance, levels).total
    return _integrated(subject, parameters, wo, tolerance, levels).total


def _integrated(
    subject: Subject,
    parameters: Array,
    wo: Array,
    tolerance: float,
    levels: int = hemisphere.LEVELS,
) -> hemisphere.Integrals:
    """The same always by adaptive integration: what a verdict rests on."""
    if subject.float32:
        tolerance = max(tolerance, SINGLE)
    cut = hemisphere.partition(subject, parameters, wo)
    return hemisphere.integrate(subject, parameters, wo, cut, tolerance, levels, albedo_only=True)


def _at_least(total: Array, error: Array) -> Array:
    """The largest channel of each point, less the integral's error: so that no search looks for errors."""
    return np.asarray(total.max(axis=1) - 2 * error)


class _Contest:
    """The same for the points of a search; infinite where it is not a number."""

    def __init__(self, subject: Subject, low: float) -> None:
        """Nothing has been looked at."""
        self.subject, self.low = subject, low
        self.best = np.full(BEATEN, -np.inf)

    def __call__(self, points: Array, levels: int = SHALLOW) -> Array:
        """What is far below the best so far is not integrated with care."""
        at = viewer(self.subject, points, self.low)
        rough = albedos(self.subject, *at, ROUGHLY, levels, float(self.best[0]))
        found = _at_least(rough.total, rough.error)
        found = np.where(np.isnan(found), np.inf, found)
        self.best = np.sort(np.append(self.best, found))[-BEATEN:]
        return found


def _scattered(subject: Subject, effort: Effort) -> Array:
    """Points anywhere, every second one white."""
    count, rng = effort.integrals, np.random.default_rng(effort.beginning(6))
    angles = dimensions(subject) - len(subject.parameters)
    parameters = hard_parameters(subject, count, effort.beginning(7))
    colours = np.array([f.declared.width == 3 for f in subject.parameters], bool)
    parameters[::2] = np.where(colours, 1.0, parameters[::2])
    return np.concatenate([parameters, rng.random((count, angles))], axis=1)


def _even(subject: Subject, effort: Effort) -> Array:
    """Points that are merely random, every second one white: with the default options many of them."""
    count = effort.albedos if subject.tag() else effort.population
    points = np.random.default_rng(effort.beginning(8)).random((count, dimensions(subject)))
    colours = np.array([f.declared.width == 3 for f in subject.parameters], bool)
    white = points[::2, : len(subject.parameters)]
    points[::2, : len(subject.parameters)] = np.where(colours, 1.0, white)
    return points


def largest(subject: Subject, effort: Effort, low: float = MU_LOW) -> Finding:
    """The largest directional albedo of viewers whose cosine is `low` at least, by search."""
    special = special_parts(subject)

    def estimated(points: Array) -> Array:
        return np.asarray(estimate(subject, *viewer(subject, points, low)).max(axis=1))

    # A window that is narrow in an angle and in a parameter is met by many points, and by no search
    wide = _even(subject, effort)
    seen = estimated(wide)
    first = np.argsort(-np.where(np.isnan(seen), np.inf, seen), kind="stable")
    begin = [starts(subject)[: effort.albedos // 2], wide[first[: effort.albedos // BRIGHT]]]
    points, _ = maximise(
        estimated,
        dimensions(subject),
        population=effort.albedos,
        rounds=effort.rounds,
        seed=effort.beginning(1),
        starts=np.concatenate(begin),
        special=special,
        bands=len(subject.parameters),
    )
    # From here on with the integrals that count; the estimates hide what gains less than a percent
    surely = _Contest(subject, low)
    scattered = _scattered(subject, effort)
    order = np.argsort(-surely(scattered, SKETCHY), kind="stable")
    points, _ = maximise(
        surely,
        dimensions(subject),
        population=effort.confirmed * (2 if dimensions(subject) <= FEW else 1),
        rounds=max(effort.rounds - 2, 3),
        seed=effort.beginning(5),
        starts=np.concatenate(
            [spread_out(points, effort.confirmed // 2), scattered[order[: effort.confirmed // 4]]]
        ),
        steps=(0.1, 1e-3),
    )
    documented = subject.size("energy")
    limits = [1.0] if documented is None else [1.0, documented.size]
    for tolerance, levels, count in INTEGRATED:
        parameters, wo = viewer(subject, points[:count], low)
        found = _integrated(subject, parameters, wo, tolerance, levels)
        least = _at_least(found.total, found.error)
        order = np.argsort(-np.where(np.isnan(least), np.inf, least), kind="stable")
        best, points = int(order[0]), points[:count][order]
        measured, error = float(found.total[best].max()), 2 * float(found.error[best])
        # Finer integrals would change nothing where no limit is near
        if all(abs(measured - limit) > max(CLEARLY * error, PRESERVED) for limit in limits):
            break
    # A white surface of a sharp lobe is only as white as the integral is exact
    limit = 1 + max(TRUSTED, error)
    verdict, text = judge(subject, "energy", measured, limit=limit, ideal=1.0, error=limit - 1)
    if verdict == FAIL and documented is not None and measured < documented.size < 1 + HARDLY:
        verdict, text = (
            PASS,
            f"up to {documented.size:g} is documented, which is too little to search for",
        )
    elif verdict == FAIL and not (
        subject.float32 and tolerance == SINGLE
    ):  # once more, more carefully
        again = slice(best, best + 1)
        found = _integrated(subject, parameters[again], wo[again], 1e-9)
        measured, error = float(found.total.max()), 2 * float(found.error[0])
        limit = 1 + max(TRUSTED, error)
        verdict, text = judge(subject, "energy", measured, limit=limit, ideal=1.0, error=limit - 1)
    if verdict == FAIL and error > BLURRED and measured < 1 + SURE * error:
        verdict, text = UNSURE, "the integral did not converge"
    fault = said((INTEGRAL, measured))
    theta = np.degrees(np.arccos(wo[best, 2]))
    text = f"{fault or text}; at {theta:.4g} degrees"
    case = (parameters[best], wo[best], wo[best])
    # A closed form that `gonio eval` shows is no integral, and quadrature may miss what is no number
    checked = bool(fault) or subject.albedos in ("closed form", "composed")
    return Finding(
        "largest albedo",
        measured,
        verdict,
        text if fault else f"{text}, integrated to {max(error, 1e-9):.1g}",
        subject.tag(),
        subject.recheck("energy", case) if checked else subject.replay(*case),
        case,
    )


def spread_out(points: Array, count: int) -> Array:
    """The first points, leaving out those that hardly differ from one before."""
    kept: list[Array] = []
    for point in points:
        if all(np.abs(point - other).max() > 1e-3 for other in kept):
            kept.append(point)
        if len(kept) == count:
            break
    return np.array(kept)


def furnace_points(subject: Subject, values: Mapping[str, Any], count: int, seed: int) -> Array:
    """Random points of a search with some parameters at given values, angles from normal to grazing."""
    rng = np.random.default_rng(seed)
    points = rng.random((count, dimensions(subject)))
    at_end = rng.random(points.shape) < 0.15
    points = np.where(at_end, rng.integers(0, 2, points.shape), points)
    return fix(subject, points, values)


def fix(subject: Subject, points: Array, values: Mapping[str, Any]) -> Array:
    """Points with some parameters at given values."""
    points = points.copy()
    for number, free in enumerate(subject.parameters):
        if free.path in values:
            value = values[free.path]
            value = value[free.channel] if isinstance(value, tuple) else value
            points[:, number] = part_of(free.declared, value)
    return points


def _furnaces(subject: Subject, effort: Effort) -> list[Finding]:
    """Every white furnace that is claimed, or a finding that one is not."""
    findings = []
    if subject.tag() == "":  # each once, with the options it names
        free = {f.path for f in subject.parameters} | set(subject.chosen)
        for entry in subject.furnaces():
            if free >= set(entry.values):
                choice = {k: v for k, v in entry.values.items() if isinstance(v, str)}
                findings.append(_furnace(subject, subject.with_options(choice), entry, effort))
    claimed = subject.claims.furnaces(subject.chosen)
    if subject.whole and not claimed:
        colours = {f.path: f.declared.high for f in subject.parameters if f.declared.width == 3}
        if all(high == 1 for high in colours.values()):
            parameters, wo = viewer(subject, furnace_points(subject, colours, 24, seed=2))
            off = float(np.abs(precise(subject, parameters, wo, ROUGHLY) - 1).max())
            if off < PRESERVED:
                names = ", ".join(f"{name}=1" for name in colours)
                findings.append(
                    Finding(
                        "white furnace",
                        off,
                        FAIL,
                        f"reflects everything with {names}, but does not claim it: "
                        f"furnace=white_furnace(within=..., {names}) in its claims",
                        subject.tag(),
                        subject.recheck("energy"),
                    )
                )
    return findings


def _furnace(claiming: Subject, subject: Subject, entry: WhiteFurnace, effort: Effort) -> Finding:
    """The largest |albedo - 1| with the parameters and options of a furnace that a subject claims."""
    numbers = {k: v for k, v in entry.values.items() if not isinstance(v, str)}

    def off(points: Array) -> Array:
        at = viewer(subject, fix(subject, points, numbers))
        return np.asarray(np.abs(precise(subject, *at, ROUGHLY, SHALLOW) - 1).max(axis=1))

    # As many with any effort: fewer miss the highest of many summits, and cost as much in the end
    points = furnace_points(
        subject, numbers, max(effort.albedos // 4, LOOKED_AT), effort.beginning(3)
    )
    found = off(points)
    best, _ = maximise(
        off,
        dimensions(subject),
        population=max(2 * effort.confirmed, AROUND),
        rounds=max(effort.rounds // 2, CLOSER),
        seed=effort.beginning(4),
        starts=points[np.argsort(-np.where(np.isnan(found), np.inf, found))[: AROUND // 2]],
        special=special_parts(subject),
        steps=(0.1, 1e-3),
    )
    parameters, wo = viewer(subject, fix(subject, best[:1], numbers))
    integral = _integrated(subject, parameters, wo, 1e-8)
    measured = float(np.abs(integral.total[0] - 1).max())
    trusted = max(FURNACE, 2 * float(integral.error[0]))
    if fault := said((INTEGRAL, measured)):
        verdict, text = FAIL, fault
    elif not measured <= max(entry.error, trusted):
        verdict, text = FAIL, f"the model claims {entry.error:g}"
    elif subject.whole and entry.error > max(MISSED * measured + trusted, NEGLIGIBLE):
        verdict, text = FAIL, f"the claimed {entry.error:g} {TOO_LARGE}"
    else:
        verdict, text = PASS, f"|albedo - 1|, at most {entry.error:g} is claimed"
    setting = ", ".join(f"{name}={value}" for name, value in entry.values.items())
    case = (parameters[0], wo[0], wo[0])
    # A furnace is one where its parameters and options are free
    replay = claiming.recheck("energy", case, free=entry.values)
    text = f"{text}; {setting}" if setting else text
    return Finding("white furnace", measured, verdict, text, subject.tag(), replay, case)
