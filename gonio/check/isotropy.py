"""Isotropy: turning both directions about the normal changes nothing, or the model says that it does."""

from __future__ import annotations

import time

import numpy as np

from gonio.check.reciprocity import FLOOR, ROUNDING_FLOAT32, dimensions, pairs
from gonio.check.report import FAIL, NOTE, PASS, Effort, Finding, Report
from gonio.check.search import maximise
from gonio.check.subject import Array, ModelSubject, Subject, evaluate

# A turn rounds the directions to 1e-16, which the slopes of a lobe of width 1e-4 at grazing angles magnify
# by up to 1e10; anisotropy that matters is far above.
ROUNDING = 2e-6


def check(subject: Subject, effort: Effort) -> Report:
    """The largest relative change by a turn about the normal, by search."""
    start = time.perf_counter()
    points, values = maximise(
        lambda p: change(subject, p),
        dimensions(subject) + 1,
        population=effort.population // 2,
        rounds=effort.rounds // 2,
        seed=13,
    )
    measured = float(values[0])
    limit = ROUNDING_FLOAT32 if subject.float32 else ROUNDING
    where, wi, wo = pairs(subject, points[:1, :-1])
    isotropic = measured <= limit
    if not isinstance(subject, ModelSubject):  # nothing is claimed
        verdict, text = (PASS, "isotropic") if isotropic else (NOTE, "anisotropic")
    elif subject.isotropic:
        verdict = PASS if isotropic else FAIL
        text = f"at most {limit:g} is allowed"
        if not isotropic:
            text += "; a model that is meant to be anisotropic declares isotropic = False"
    elif isotropic and subject.whole and not subject.tag():
        verdict, text = FAIL, "isotropic, but the model declares isotropic = False"
    else:
        verdict, text = PASS, "isotropic" if isotropic else "anisotropic, as declared"
    case = (where[0], wi[0], wo[0])
    finding = Finding(
        "change by a turn", measured, verdict, text, subject.tag(), subject.replay(*case), case
    )
    return Report("isotropy", subject.name, (finding,), time.perf_counter() - start)


def change(subject: Subject, points: Array) -> Array:
    """Relative change of the value when both directions are turned by the last coordinate, (n,)."""
    where, wi, wo = pairs(subject, points[:, :-1])
    angle = 2 * np.pi * points[:, -1]
    c, s = np.cos(angle), np.sin(angle)

    def turned(w: Array) -> Array:
        return np.stack([c * w[:, 0] - s * w[:, 1], s * w[:, 0] + c * w[:, 1], w[:, 2]], -1)

    n = len(points)
    index = np.tile(np.arange(n, dtype=np.uint32), 2)
    f, _ = evaluate(
        subject,
        where,
        index,
        np.concatenate([wi, turned(wi)]),
        np.concatenate([wo, turned(wo)]),
    )
    a, b = f[:n].astype(np.float64), f[n:].astype(np.float64)
    scale = np.maximum(np.maximum(np.abs(a), np.abs(b)), FLOOR)
    return np.asarray((np.abs(a - b) / scale).max(axis=1))
