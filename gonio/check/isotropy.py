"""Isotropy: turning both directions about the normal changes nothing, or the model says that it does."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from gonio.check import kernels
from gonio.check.adversarial import special_parts
from gonio.check.kernels import evaluate
from gonio.check.no_number import said
from gonio.check.reciprocity import FLOOR, ROUNDING_FLOAT32, dimensions, pairs
from gonio.check.report import FAIL, NOTE, PASS, Effort, Finding, Report
from gonio.check.search import maximise
from gonio.check.subject import Array, Subject

# A turn rounds the directions to 1e-16, which the slopes of a lobe of width 1e-4 at grazing angles magnify
# by up to 1e12: so many times what one more rounding changes is allowed.
ROUNDING, ROUNDINGS, EPSILON = 1e-5, 64, 2.0**-52

# A sampler may take its axes from wo's azimuth: nearer to the normal than this there is none.
OFF_NORMAL = 1e-6

# The edge of a clipped density may lie on either side of a rounding: where nearly all of it is gone after a
# turn, it counts if it is gone at wi moved so far, to either side, as well.
EDGE, BESIDE = 0.999, 1e-3

# So many roundings are tried where the density seems to change. It may do so by its nature: where wi is
# within 1e-12 of opposite to a grazing wo, samples that left below the horizon and were turned up again
# come from facets of every tilt, seen edge-on, and the last bits of wi say from which.
SHAKES = 8

Turn = Callable[[Array], Array]

NAMES = ("eval", "pdf", "albedo")


def check(subject: Subject, effort: Effort) -> Report:
    """The largest relative change of value, density and albedo by a turn about the normal, by search."""
    start = time.perf_counter()
    points, values = maximise(
        lambda p: change(subject, p).max(axis=1),
        dimensions(subject) + 1,
        population=effort.population // 2,
        rounds=effort.rounds // 2,
        seed=13,
        special=special_parts(subject),
    )
    measured = float(values[0]) if not np.isinf(values[0]) else float("nan")
    what = NAMES[int(np.argmax(np.nan_to_num(change(subject, points[:1])[0], nan=np.inf)))]
    limit = ROUNDING_FLOAT32 if subject.float32 else ROUNDING
    parameters, wi, wo = pairs(subject, points[:1, :-1])
    isotropic = measured <= limit
    fault = (
        ""
        if np.isfinite(measured)
        else said(*zip(NAMES, _columns(subject, points[:1]), strict=False))
    )
    if fault:
        verdict, text = FAIL, fault
    elif not subject.claiming:
        verdict, text = (PASS, "isotropic") if isotropic else (NOTE, "anisotropic")
    elif subject.isotropic:
        verdict = PASS if isotropic else FAIL
        text = f"at most {limit:g} is allowed; {what}"
        if not isotropic:
            text += "; a model that is meant to be anisotropic declares isotropic = False"
    elif isotropic and subject.whole and not subject.tag():
        verdict, text = FAIL, "isotropic, but the model declares isotropic = False"
    else:
        verdict, text = PASS, "isotropic" if isotropic else "anisotropic, as declared"
    case = (parameters[0], wi[0], wo[0])
    replay = subject.replay(*case, compare=f"turned:{360 * float(points[0, -1])!r}")
    finding = Finding("change by a turn", measured, verdict, text, subject.tag(), replay, case)
    return Report("isotropy", subject.name, (finding,), time.perf_counter() - start)


def change(subject: Subject, points: Array) -> Array:
    """Relative changes (n, 2 or 3) of value, density and closed-form albedo when both directions turn.

    The last coordinate of a point is the angle of the turn.
    """
    parameters, wi, wo = pairs(subject, points[:, :-1])
    angle = 2 * np.pi * points[:, -1]
    n = len(points)
    light, viewer = _turned(wi, angle), _turned(wo, angle)
    found = []
    for value in _columns(subject, points):
        a, b, c = value[:n], value[n : 2 * n], value[2 * n :]
        scale = np.maximum(np.maximum(np.abs(a), np.abs(b)), FLOOR)
        beyond = np.abs(a - b) - ROUNDINGS * np.abs(b - c)
        found.append(
            (np.where(beyond > 0, beyond, np.where(np.isnan(beyond), beyond, 0)) / scale).max(
                axis=1
            )
        )
    moved = np.flatnonzero(found[1] > ROUNDING)
    if len(moved):  # one rounding may happen to change nothing
        found[1][moved] = np.maximum(
            found[1][moved] - ROUNDINGS * _shaken(subject, parameters, light, viewer, moved), 0
        )
    near_normal = np.hypot(wo[:, 0], wo[:, 1]) < OFF_NORMAL
    found[1] = np.where(near_normal, 0, found[1])
    rows = np.flatnonzero(found[1] > EDGE)
    if len(rows):

        def same_turn(w: Array) -> Array:
            return _turned(w, np.tile(angle[rows], len(w) // len(rows)))

        found[1][rows] = _all_around(subject, parameters[rows], wi[rows], wo[rows], same_turn)
    return np.stack(found, -1)


def _columns(subject: Subject, points: Array) -> list[Array]:
    """Values, densities and closed-form albedos: at all points, turned, and a rounding beside that."""
    parameters, wi, wo = pairs(subject, points[:, :-1])
    angle = 2 * np.pi * points[:, -1]
    index = np.tile(np.arange(len(points), dtype=np.uint32), 3)
    light, viewer = _turned(wi, angle), _turned(wo, angle)
    rng = np.random.default_rng(17)
    shaken = light * (1 + EPSILON * rng.choice([-1.0, 1.0], light.shape))
    wi, wo = np.concatenate([wi, light, shaken]), np.concatenate([wo, viewer, viewer])
    f, pdf = evaluate(subject, parameters, index, wi, wo)
    columns = [f.astype(np.float64), pdf.astype(np.float64)[:, None]]
    if subject.albedos == "closed form":
        columns.append(kernels.albedo(subject, np.tile(parameters, (3, 1)), wo))
    return columns


def _shaken(
    subject: Subject, parameters: Array, wi: Array, wo: Array, rows: NDArray[np.intp]
) -> Array:
    """The largest relative change of the density by one of several roundings of both directions."""
    rng = np.random.default_rng(18)
    each = np.tile(rows, SHAKES)
    light, viewer = wi[each], wo[each]
    both = [w * (1 + EPSILON * rng.choice([-1.0, 1.0], w.shape)) for w in (light, viewer)]
    both = [np.concatenate([w[: len(rows)], b]) for w, b in zip((light, viewer), both, strict=True)]
    index = np.append(rows, each).astype(np.uint32)
    _, pdf = evaluate(subject, parameters, index, *both)
    value = pdf.astype(np.float64).reshape(SHAKES + 1, len(rows))
    change = np.abs(value[1:] - value[0]) / np.maximum(np.abs(value[0]), FLOOR)
    return np.asarray(change.max(axis=0))


def _turned(w: Array, angle: Array) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * w[:, 0] - s * w[:, 1], s * w[:, 0] + c * w[:, 1], w[:, 2]], -1)


def _all_around(subject: Subject, parameters: Array, wi: Array, wo: Array, turn: Turn) -> Array:
    """The smallest relative change of the density by the turn, of places on four sides of each wi."""
    n = len(wi)
    along = np.stack([-wi[:, 1], wi[:, 0], 0 * wi[:, 2]], -1) + np.array([1e-9, 0, 0])
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    across = np.cross(wi, along)
    beside = [wi + BESIDE * side for side in (along, -along, across, -across)]
    light = np.concatenate(beside)
    light[:, 2] = np.abs(light[:, 2])
    light /= np.linalg.norm(light, axis=1, keepdims=True)
    viewer = np.tile(wo, (4, 1))
    index = np.tile(np.arange(n, dtype=np.uint32), 8)
    both = [np.concatenate([w, turn(w)]) for w in (light, viewer)]
    _, pdf = evaluate(subject, parameters, index, *both)
    a, b = np.split(pdf.astype(np.float64), 2)
    relative = np.abs(a - b) / np.maximum(np.maximum(a, b), FLOOR)
    return np.asarray(relative.reshape(4, n).min(axis=0))
