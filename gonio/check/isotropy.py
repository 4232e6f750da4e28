"""Isotropy: turning both directions about the normal changes nothing, or the model says that it does."""

from __future__ import annotations

import time

import numpy as np

from gonio.check.adversarial import special_parts
from gonio.check.finite import closed_albedo
from gonio.check.reciprocity import FLOOR, ROUNDING_FLOAT32, dimensions, pairs
from gonio.check.report import FAIL, NOTE, PASS, Effort, Finding, Report
from gonio.check.search import maximise
from gonio.check.subject import Array, Subject, evaluate

# A turn rounds the directions to 1e-16, which the slopes of a lobe of width 1e-4 at grazing angles magnify
# by up to 1e12: so many times what one more rounding changes is allowed.
ROUNDING, ROUNDINGS, EPSILON = 1e-5, 64, 2.0**-52

# A sampler may take its axes from wo's azimuth: nearer to the normal than this there is none, and the edge
# of a clipped density may lie on either side of a rounding.
OFF_NORMAL, EDGE = 1e-6, 0.999

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
    if not subject.claiming:
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
    finding = Finding(
        "change by a turn", measured, verdict, text, subject.tag(), subject.replay(*case), case
    )
    return Report("isotropy", subject.name, (finding,), time.perf_counter() - start)


def change(subject: Subject, points: Array) -> Array:
    """Relative changes (n, 2 or 3) of value, density and closed-form albedo when both directions turn.

    The last coordinate of a point is the angle of the turn.
    """
    parameters, wi, wo = pairs(subject, points[:, :-1])
    angle = 2 * np.pi * points[:, -1]
    c, s = np.cos(angle), np.sin(angle)

    def turned(w: Array) -> Array:
        return np.stack([c * w[:, 0] - s * w[:, 1], s * w[:, 0] + c * w[:, 1], w[:, 2]], -1)

    n = len(points)
    index = np.tile(np.arange(n, dtype=np.uint32), 3)
    light, viewer = turned(wi), turned(wo)
    rng = np.random.default_rng(17)
    shaken = light * (1 + EPSILON * rng.choice([-1.0, 1.0], light.shape))
    wi, wo = np.concatenate([wi, light, shaken]), np.concatenate([wo, viewer, viewer])
    f, pdf = evaluate(subject, parameters, index, wi, wo)
    columns = [f.astype(np.float64), pdf.astype(np.float64)[:, None]]
    if subject.albedos == "closed form":
        columns.append(closed_albedo(subject, np.tile(parameters, (3, 1)), wo))
    found = []
    for value in columns:
        a, b, c = value[:n], value[n : 2 * n], value[2 * n :]
        scale = np.maximum(np.maximum(np.abs(a), np.abs(b)), FLOOR)
        beyond = np.abs(a - b) - ROUNDINGS * np.abs(b - c)
        found.append(
            (np.where(beyond > 0, beyond, np.where(np.isnan(beyond), beyond, 0)) / scale).max(
                axis=1
            )
        )
    near_normal = np.hypot(wo[:n, 0], wo[:n, 1]) < OFF_NORMAL
    found[1] = np.where(near_normal | (found[1] > EDGE), 0, found[1])
    return np.stack(found, -1)
