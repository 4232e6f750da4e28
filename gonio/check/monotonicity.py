"""Monotonicity: parameters of which the model says that the mean albedo never grows with them."""

from __future__ import annotations

import time

import numpy as np

from gonio.check.energy import ROUGHLY, SHALLOW, precise
from gonio.check.report import FAIL, PASS, Effort, Finding, Report
from gonio.check.subject import Array, ModelSubject, Subject

# Steps over the parameter's range, sets of the other parameters, and nodes of the mean over wo.
STEPS, SETS, NODES = 9, 3, 4

# Means may grow by the error of the integrals.
TRUSTED = 5e-5


def check(subject: Subject, effort: Effort) -> Report:
    """The largest growth of the mean albedo between two neighbouring values."""
    start = time.perf_counter()
    findings = []
    if isinstance(subject, ModelSubject):
        findings = [_growth(subject, path) for path in subject.claims.falls if _free(subject, path)]
    return Report("monotonicity", subject.name, tuple(findings), time.perf_counter() - start)


def _free(subject: ModelSubject, path: str) -> bool:
    return any(c.path == path for c in subject.columns)


def means(subject: ModelSubject, places: Array) -> Array:
    """Mean albedos (points, 3) over wo, of an isotropic model or in one plane."""
    x, w = np.polynomial.legendre.leggauss(NODES)
    mu2 = (x + 1) / 2  # (1/π) ∫ E μ dω = ∫ E dμ²
    wo = np.stack([np.sqrt(1 - mu2), 0 * mu2, np.sqrt(mu2)], -1)
    wo = np.tile(wo, (len(places), 1))
    E = precise(subject, np.repeat(places, NODES, axis=0), wo, ROUGHLY, SHALLOW)
    return np.asarray((E.reshape(len(places), NODES, 3) * (w / 2)[:, None]).sum(axis=1))


def _growth(subject: ModelSubject, path: str) -> Finding:
    rng = np.random.default_rng(61)
    column = next(n for n, c in enumerate(subject.columns) if c.path == path)
    sets = rng.random((SETS, len(subject.columns)))
    sets[0] = subject.default()
    places = np.repeat(sets, STEPS, axis=0)
    places[:, column] = np.tile(np.linspace(0, 1, STEPS), SETS)
    mean = means(subject, places).reshape(SETS, STEPS, 3)
    growth = np.diff(mean, axis=1).max(axis=2)
    row, step = np.unravel_index(growth.argmax(), growth.shape)
    measured = max(float(growth.max()), 0.0)
    verdict = PASS if measured <= TRUSTED else FAIL
    up = np.array([0.0, 0.0, 1.0])
    case = (places[row * STEPS + step], up, up)
    return Finding(
        f"growth with {path}",
        measured,
        verdict,
        "the mean albedo may not grow",
        subject.tag(),
        subject.replay(*case),
        case,
    )
