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
from gonio.check.report import FAIL, NOTE, PASS, Effort, Finding, Report, judge
from gonio.check.search import maximise
from gonio.check.subject import (
    Array,
    ModelSubject,
    Subject,
    cosine_at,
    directions,
    even,
    known_size,
    number_type,
    stored,
    whites,
)
from gonio.check.variants import place_of
from gonio.claims import as_tuple

# Nodes of the quick estimate: so many over the hemisphere, and so many from the sampler.
NODES = 256

# The lowest cosine of wo. In the horizon itself every value is 0.
MU_LOW = 1e-6

# With up to so many coordinates twice the points are affordable: such models are not expensive.
FEW = 6

# Tolerance of the adaptive integrals that the search compares, and how often it cuts cells.
ROUGHLY, SHALLOW = 2e-5, 5

# What the adaptive integral is trusted to, doubled: in the search, and when it is repeated for furnaces.
TRUSTED = 1e-5
FURNACE = 5e-6

# Angles at which a furnace is shown, and nodes of the mean.
FURNACE_ANGLES = (0.0, 30.0, 60.0, 85.0)
FURNACE_NODES = 12

# A gain smaller than this may be hidden by the errors of the estimates that the search begins with; its
# documented size is then an upper bound only.
HARDLY = 0.03

# Albedos within this of 1 everywhere mean that a model preserves energy.
PRESERVED = 1e-4


def check(subject: Subject, effort: Effort) -> Report:
    """The largest directional albedo, the white furnaces that the model claims, and one it does not."""
    start = time.perf_counter()
    findings = [_largest(subject, effort)]
    findings += _furnaces(subject, effort)
    if not isinstance(subject, ModelSubject):
        findings.append(_in_a_furnace(subject))
    return Report("energy", subject.name, tuple(findings), time.perf_counter() - start)


def _in_a_furnace(subject: Subject) -> Finding:
    """What a plug-in reflects of a world that is bright all around, at four angles and on average."""
    x, w = np.polynomial.legendre.leggauss(FURNACE_NODES)
    mu2 = (x + 1) / 2  # (1/π) ∫ E μ dω = ∫ E dμ²
    mu = np.append(np.cos(np.radians(FURNACE_ANGLES)), np.sqrt(mu2))
    E = precise(subject, np.zeros((len(mu), 0)), directions(mu, 0 * mu)).mean(axis=1)
    shown = ", ".join(
        f"{albedo:.4f} at {angle:g}°" for albedo, angle in zip(E, FURNACE_ANGLES, strict=False)
    )
    mean = float((E[len(FURNACE_ANGLES) :] * w / 2).sum())
    return Finding("in a white furnace", mean, NOTE, f"mean albedo; {shown}", subject.tag())


def viewer(subject: Subject, points: Array) -> tuple[Array, Array]:
    """Parameters' places and wo of points of a search, whose last one or two coordinates are angles."""
    count = len(subject.columns)
    azimuth = 0.0 if subject.isotropic else 2 * np.pi * points[:, count + 1]
    mu = np.maximum(cosine_at(points[:, count]), MU_LOW)
    return points[:, :count], directions(mu, azimuth + 0 * mu)


def dimensions(subject: Subject) -> int:
    """Coordinates of such points."""
    return len(subject.columns) + (1 if subject.isotropic else 2)


def starts(subject: Subject) -> Array:
    """The default parameters at several angles, and each of them at both ends."""
    base = subject.default()
    rows = [base]
    for column in range(len(base)):
        for end in (0.0, 1.0):
            row = base.copy()
            row[column] = end
            rows.append(row)
    colours = np.array([c.declared.width == 3 for c in subject.columns], bool)
    rows += [np.where(colours, 1.0, row) for row in rows]
    extra = dimensions(subject) - len(base)
    angles = np.array([0.01, 0.25, 0.5, 0.97])
    found = [np.append(row, np.full(extra, a)) for row in rows for a in angles]
    return np.array(found)


def estimate(subject: Subject, places: Array, wo: Array) -> Array:
    """Albedos of points, (points, 3), to about a percent, in one kernel."""
    Float = number_type()
    UInt = dr.uint32_array_t(Float)
    points = len(places)
    lane = dr.arange(UInt, points * NODES)
    index = lane // NODES
    node = lane - index * NODES
    Vec = dr.replace_shape_t(Float, (3, -1))
    wo_ = Vec(*(dr.gather(Float, stored(Float, c), index) for c in wo.T))
    a, b = (dr.gather(Float, stored(Float, c), node) for c in even(NODES).T)
    model = subject.at(places, index, Float)

    def part(wi: Any, solid: Any) -> Any:
        f = Vec(model.eval(wi, wo_))
        density = 1 / solid + Float(model.pdf(wi, wo_))
        usable = (solid > 0) & (density > 0) & (wi.z > 0)
        return dr.select(usable, f * (dr.maximum(wi.z, 0) / dr.select(usable, density, 1)), 0)

    wi, solid = hemisphere.chart(wo_, a, b)
    total = part(wi, solid)
    wi, pdf = model.sample(wo_, dr.replace_shape_t(Float, (2, -1))(a, b))
    u, v = hemisphere.unchart(wo_, wi)
    _, solid = hemisphere.chart(wo_, u, v)
    total += dr.select(Float(pdf) > 0, part(wi, solid), 0)
    dr.eval(total)
    values = np.stack([c.numpy() for c in total], -1).reshape(points, NODES, 3)
    return np.asarray(values.sum(axis=1) / NODES)


def precise(
    subject: Subject,
    places: Array,
    wo: Array,
    tolerance: float = 1e-6,
    levels: int = hemisphere.LEVELS,
) -> Array:
    """Albedos of points, (points, 3), by adaptive integration."""
    cut = hemisphere.partition(subject, places, wo)
    return hemisphere.integrate(subject, places, wo, cut, tolerance, levels, albedo_only=True).total


def _largest(subject: Subject, effort: Effort) -> Finding:
    points, _ = maximise(
        lambda p: estimate(subject, *viewer(subject, p)).max(axis=1),
        dimensions(subject),
        population=effort.albedos,
        rounds=effort.rounds,
        seed=1,
        starts=starts(subject),
    )
    # From here on with the integrals that count
    points, albedos = maximise(
        lambda p: precise(subject, *viewer(subject, p), ROUGHLY, SHALLOW).max(axis=1),
        dimensions(subject),
        population=effort.confirmed * (2 if dimensions(subject) <= FEW else 1),
        rounds=8,
        seed=5,
        starts=_spread_out(points, effort.confirmed // 2),
        steps=(0.1, 1e-3),
    )
    places, wo = viewer(subject, points[:6])
    albedos = precise(subject, places, wo).max(axis=1)
    best = int(np.argmax(np.where(np.isnan(albedos), np.inf, albedos)))
    measured = float(albedos[best])
    limit = 1 + TRUSTED
    verdict, text = judge(subject, "energy", measured, limit=limit, ideal=1.0)
    known = known_size(subject, "energy")
    if verdict == FAIL and known is not None and measured < known < 1 + HARDLY:
        verdict, text = PASS, f"up to {known:g} is documented, which is too little to search for"
    elif verdict == FAIL:  # once more, more carefully
        again = slice(best, best + 1)
        measured = float(precise(subject, places[again], wo[again], 1e-9).max())
        verdict, text = judge(subject, "energy", measured, limit=limit, ideal=1.0)
    theta = np.degrees(np.arccos(wo[best, 2]))
    return Finding(
        "largest albedo",
        measured,
        verdict,
        f"{text}; at {theta:.4g} degrees",
        subject.tag(),
        subject.replay(places[best], wo[best], wo[best]),
        (places[best], wo[best], wo[best]),
    )


def _spread_out(points: Array, count: int) -> Array:
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
    for number, column in enumerate(subject.columns):
        if column.path in values:
            value = values[column.path]
            value = value[column.channel] if isinstance(value, tuple) else value
            points[:, number] = place_of(column.declared, value)
    return points


def _furnaces(subject: Subject, effort: Effort) -> list[Finding]:
    """Every white furnace that is claimed, or a finding that one is not."""
    if not isinstance(subject, ModelSubject):
        return []
    findings = []
    if subject.tag() == "":  # each once, with the options it names
        for entry in as_tuple(subject.claims.furnace):
            choice = {k: v for k, v in entry.values.items() if isinstance(v, str)}
            white = ModelSubject(subject.model.replace(**choice), subject.fixed, subject.label)
            if all(path not in subject.fixed for path in entry.values):
                findings.append(_furnace(white, entry, effort))
    if subject.whole and not whites(subject):
        colours = {c.path: c.declared.high for c in subject.columns if c.declared.width == 3}
        if all(high == 1 for high in colours.values()):
            places, wo = viewer(subject, furnace_points(subject, colours, 24, seed=2))
            off = float(np.abs(precise(subject, places, wo) - 1).max())
            if off < PRESERVED:
                names = ", ".join(f"{name}=1" for name in colours)
                findings.append(
                    Finding(
                        "white furnace",
                        off,
                        FAIL,
                        f"reflects everything with {names}, but does not claim it: "
                        "furnace=white(...) in its claims",
                        subject.tag(),
                    )
                )
    return findings


def _furnace(subject: ModelSubject, entry: Any, effort: Effort) -> Finding:
    """The largest |albedo - 1| with the parameters of a claimed white furnace."""
    numbers = {k: v for k, v in entry.values.items() if not isinstance(v, str)}
    points = furnace_points(subject, numbers, max(effort.albedos // 8, 64), seed=3)
    off = np.abs(precise(subject, *viewer(subject, points), ROUGHLY, SHALLOW) - 1).max(axis=1)
    best, _ = maximise(
        lambda p: np.abs(
            precise(subject, *viewer(subject, fix(subject, p, numbers)), ROUGHLY, SHALLOW) - 1
        ).max(axis=1),
        dimensions(subject),
        population=effort.confirmed,
        rounds=4,
        seed=4,
        starts=points[np.argsort(-off)[: effort.confirmed // 2]],
    )
    places, wo = viewer(subject, fix(subject, best[:1], numbers))
    albedo = precise(subject, places, wo, 1e-8)[0]
    measured = float(np.abs(albedo - 1).max())
    allowed = max(entry.error, FURNACE)
    if measured > allowed * 1.02:
        verdict, text = FAIL, f"the model claims {entry.error:g}"
    elif measured < 0.4 * entry.error and entry.error > FURNACE:
        verdict, text = FAIL, f"the claimed {entry.error:g} is far too large"
    else:
        verdict, text = PASS, f"|albedo - 1|, at most {entry.error:g} is claimed"
    setting = ", ".join(f"{name}={value}" for name, value in entry.values.items())
    return Finding(
        "white furnace",
        measured,
        verdict,
        f"{text}; {setting}",
        subject.tag(),
        subject.replay(places[0], wo[0], wo[0]),
        (places[0], wo[0], wo[0]),
    )
