"""Albedo: what the model says its integral is, closed form or quadrature, against adaptive integration.

The adaptive integral's own error is estimated, stated, and never charged to the model. Numbers of
`gonio.albedos.quadrature` are not the model's fault: they are shown, and judged only against a size that is
documented.
"""

from __future__ import annotations

import time

import numpy as np

from gonio.check import hemisphere, kernels
from gonio.check.adversarial import hard_parameters
from gonio.check.energy import dimensions, starts, viewer
from gonio.check.product_rules import albedos
from gonio.check.report import FAIL, NOTE, PASS, UNSURE, Effort, Finding, Report, judge
from gonio.check.subject import Array, Subject, directions

# What closed forms may be off: the adaptive integral itself errs by 1.2e-5 where a kink meets a cell that
# has no samples. Then what gonio.albedos.quadrature promises.
CLOSED, NUMERIC = 2e-5, 3e-5

# Tolerance of integrals of which many are added up, or which are repeated where something seems wrong.
ROUGHLY = 2e-5

# An integral that is good to no more than this tells nothing.
BLURRED = 1e-3

# Means by closed forms are compared with Gauss's rule in the elevation, and even steps in the azimuth.
MEAN_NODES, MEAN_TURNS = 16, 6
MEAN = 2e-5


def check(subject: Subject, effort: Effort) -> Report:
    """Directional albedos at points over the whole range, and means of a few."""
    start = time.perf_counter()
    findings = []
    if subject.albedos:
        findings = [_directional(subject, effort)]
        if subject.mean_closed:
            findings.append(_mean(subject))
    return Report("albedo", subject.name, tuple(findings), time.perf_counter() - start)


def _directional(subject: Subject, effort: Effort) -> Finding:
    rng = np.random.default_rng(31)
    closed = subject.albedos != "quadrature"
    # A closed form may be wrong anywhere: with fewer places one that is off in a tenth of the cosines and
    # of a parameter is missed (tools/measure_power.py). Others are mostly the quadrature's.
    count = {"closed form": 24, "composed": 2}.get(subject.albedos, 1) * effort.confirmed
    points = np.concatenate(
        [
            hard_parameters(subject, count, 33),
            rng.random((count, dimensions(subject) - len(subject.parameters))),
        ],
        axis=1,
    )
    first = starts(subject)[:4]
    points[: len(first)] = first[:count]
    parameters, wo = viewer(subject, points)
    # Albedos are compared where they are not yet the horizon's limit
    own = kernels.albedo(subject, parameters, wo)
    true, error = _integrals(subject, parameters, wo, 2e-6 if closed else ROUGHLY)
    off = _off(own, true) - error
    limit = CLOSED if closed else NUMERIC
    careful = CAREFULLY[0 if closed else 1]
    sure = np.zeros(len(off), bool)
    while True:  # until the worst one has been integrated with care, or is none
        order = np.argsort(-np.where(np.isnan(off), np.inf, off), kind="stable")
        row = int(order[0])
        if sure[row] or off[row] < 0.5 * limit:
            break
        suspect = order[~sure[order] & ~(off[order] < 0.5 * limit)][:SUSPECTS]
        true[suspect], error[suspect] = _integrals(
            subject, parameters[suspect], wo[suspect], careful
        )
        off[suspect] = _off(own[suspect], true[suspect]) - error[suspect]
        sure[suspect] = True
    measured = float(np.maximum(off[row], 0)) if not np.isnan(off[row]) else float("nan")
    # Whether a kink falls between two nodes is luck
    verdict, text = judge(subject, "numeric_albedo", measured, limit=limit, searched=False)
    text += (
        f"; {subject.albedos}, compared with integrals good to {max(float(error.max()), 1e-9):.1g}"
    )
    if verdict == FAIL and not closed and subject.size("numeric_albedo") is None:
        if not np.isnan(own[row]).any():
            verdict = NOTE
            text = (
                f"gonio's quadrature errs by this, not the model: another rule may fit better, or "
                f"numeric_albedo=at_most({measured:.1g}) in its claims tells users"
            )
    elif verdict == PASS and float(error[row]) > BLURRED:
        verdict, text = UNSURE, f"the integral itself is good to {float(error[row]):.1g} only"
    case = (parameters[row], wo[row], wo[row])
    return Finding(
        "error of albedo", measured, verdict, text, subject.tag(), subject.replay(*case), case
    )


# So many albedos at once are integrated again with care: closed forms, and the others to a fortieth of what
# is allowed. From which tolerance on product rules do.
SUSPECTS, CAREFULLY, WITH_RULES = 6, (1e-8, 4e-7), 1e-6


def _integrals(
    subject: Subject, parameters: Array, wo: Array, tolerance: float
) -> tuple[Array, Array]:
    if tolerance >= WITH_RULES:
        rough = albedos(subject, parameters, wo, tolerance)
        return rough.total, rough.error
    cut = hemisphere.partition(subject, parameters, wo)
    found = hemisphere.integrate(subject, parameters, wo, cut, tolerance, albedo_only=True)
    return found.total, found.error


def _off(own: Array, true: Array) -> Array:
    return np.asarray((np.abs(own - true) / np.maximum(np.abs(true), 1)).max(axis=1))


def _mean(subject: Subject) -> Finding:
    """The closed form of the mean against the integral of the directional albedo."""
    x, w = np.polynomial.legendre.leggauss(MEAN_NODES)
    # Half of the nodes crowd in the horizon
    theta = np.concatenate([np.pi / 8 * (x + 1), np.pi / 2 - np.pi / 4 * ((x + 1) / 2) ** 3])
    w = np.concatenate([np.pi / 8 * w, np.pi / 4 * 3 / 2 * ((x + 1) / 2) ** 2 * w])
    weight = w * 2 * np.sin(theta) * np.cos(theta)
    turns = 1 if subject.isotropic else MEAN_TURNS
    rng = np.random.default_rng(32)
    azimuth = 2 * np.pi * (np.repeat(np.arange(turns), len(theta)) / turns + 0.137)
    wo = directions(np.tile(np.cos(theta), turns), azimuth)
    weight = np.tile(weight / turns, turns)
    rows = np.stack([subject.default(), rng.random(len(subject.parameters))])
    worst, worst_row = 0.0, rows[0]
    for row in rows:
        own = kernels.mean_albedo(subject, row[None])[0]
        for tolerance in (ROUGHLY, CAREFULLY[0]):
            E, _ = _integrals(subject, np.tile(row, (len(wo), 1)), wo, tolerance)
            off = float(np.abs(own - (E * weight[:, None]).sum(axis=0)).max())
            if off <= MEAN:
                break
        if not off <= worst:
            worst, worst_row = off, row
    verdict = PASS if worst <= MEAN else FAIL
    text = f"at most {MEAN:g} is allowed; closed form"
    up = np.array([0.0, 0.0, 1.0])
    case = (worst_row, up, up)
    return Finding(
        "error of mean albedo", worst, verdict, text, subject.tag(), subject.replay(*case), case
    )
