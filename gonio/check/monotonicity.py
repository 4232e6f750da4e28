"""Monotonicity: parameters of which the model says that the mean albedo never grows with them."""

from __future__ import annotations

import time

import numpy as np

from gonio.check.adversarial import hard_parameters, special_parts
from gonio.check.energy import ROUGHLY, SHALLOW, SINGLE, precise
from gonio.check.hemisphere import LEVELS
from gonio.check.report import FAIL, PASS, Effort, Finding, Report
from gonio.check.subject import Array, Subject, directions

# Steps over the parameter's range, each at a random value, rows of the other parameters, nodes of the
# mean over wo, and azimuths of an anisotropic model.
STEPS, ROWS, NODES, TURNS = 11, 2, 3, 4

# The steps that grow most, or fall least, are cut into so many, so many times.
NEARER, LOOKS, WORST = 4, 2, 2

# Means may grow by the error of the integrals.
TRUSTED = 5e-5


def check(subject: Subject, effort: Effort) -> Report:
    """The largest growth of the mean albedo between two neighbouring values."""
    start = time.perf_counter()
    free = {f.path for f in subject.parameters}
    findings = [_growth(subject, path) for path in subject.claims.falls if path in free]
    return Report("monotonicity", subject.name, tuple(findings), time.perf_counter() - start)


def means(
    subject: Subject, parameters: Array, tolerance: float = ROUGHLY, levels: int = SHALLOW
) -> Array:
    """Mean albedos (rows, 3) over wo, of albedos that `precise` integrates."""
    x, w = np.polynomial.legendre.leggauss(NODES)
    mu = np.sqrt((x + 1) / 2)  # (1/π) ∫ E μ dω = ∫ E dμ²
    turns = 1 if subject.isotropic else TURNS
    azimuth = 2 * np.pi * np.repeat(np.arange(turns) + 0.137, NODES) / turns
    wo = np.tile(directions(np.tile(mu, turns), azimuth), (len(parameters), 1))
    each = NODES * turns
    E = precise(subject, np.repeat(parameters, each, axis=0), wo, tolerance, levels)
    weight = np.tile(w / 2, turns) / turns
    return np.asarray((E.reshape(len(parameters), each, 3) * weight[:, None]).sum(axis=1))


def _growth(subject: Subject, path: str) -> Finding:
    rng = np.random.default_rng(61)
    number = next(n for n, f in enumerate(subject.parameters) if f.path == path)
    rows = hard_parameters(subject, ROWS, 62)
    rows[0] = subject.default()
    special = special_parts(subject)[number]
    steps = np.unique(np.concatenate([(np.arange(STEPS) + rng.random(STEPS)) / STEPS, special[:6]]))
    for accuracy in ((ROUGHLY, SHALLOW), (SINGLE, LEVELS)):  # what fails is looked at with care
        worst, where, at = _largest(subject, number, rows, steps, *accuracy)
        if worst <= TRUSTED:
            break
    verdict = PASS if worst <= TRUSTED else FAIL
    up = np.array([0.0, 0.0, 1.0])
    where = where.copy()
    where[number] = at
    case = (where, up, up)
    return Finding(
        f"growth with {path}",
        worst,
        verdict,
        "the mean albedo may not grow",
        subject.tag(),
        subject.replay(*case),
        case,
    )


def _largest(
    subject: Subject, number: int, rows: Array, steps: Array, tolerance: float, levels: int
) -> tuple[float, Array, float]:
    """The largest growth with a parameter, the row of the others, and the parameter's part of its range."""

    def along(row: Array, t: Array) -> Array:
        parameters = np.tile(row, (len(t), 1))
        parameters[:, number] = t
        return means(subject, parameters, tolerance, levels)

    found = [(row, steps, along(row, steps)) for row in rows]
    worst, where, at = 0.0, rows[0], 0.0
    for look in range(LOOKS + 1):
        nearer = []
        for row, t, mean in found:
            growth = np.diff(mean, axis=0).max(axis=1)
            best = int(np.argmax(np.where(np.isnan(growth), np.inf, growth)))
            if not growth[best] <= worst:
                worst, where, at = float(growth[best]), row, float(t[best + 1])
            nearer += [(float(growth[k]), row, t[k], t[k + 1]) for k in np.argsort(-growth)[:WORST]]
        if look == LOOKS:
            break
        found = []
        for _, row, low, high in sorted(nearer, key=lambda n: -n[0])[:WORST]:
            t = np.linspace(low, high, NEARER + 1)
            found.append((row, t, along(row, t)))
    return worst, where, at
