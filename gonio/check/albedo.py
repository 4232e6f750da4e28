"""Albedo: what the model says its integral is, closed form or quadrature, against adaptive integration."""

from __future__ import annotations

import time

import drjit as dr
import numpy as np

from gonio.check.energy import dimensions, precise, starts, viewer
from gonio.check.finite import closed_albedo
from gonio.check.report import FAIL, PASS, Effort, Finding, Report, judge
from gonio.check.subject import (
    ModelSubject,
    Subject,
    columns_of,
    number_type,
)
from gonio.model import Model

# What closed forms may be off: the adaptive integral itself errs by 1.2e-5 where a kink meets a cell that
# has no samples. Then what gonio.quadrature promises.
CLOSED, NUMERIC = 2e-5, 3e-5

# Means by closed forms are compared with Gauss's rule in the elevation.
MEAN_NODES = 16
MEAN = 2e-5


def check(subject: Subject, effort: Effort) -> Report:
    """Directional albedos at points over the whole range, and means of a few."""
    start = time.perf_counter()
    findings = []
    if isinstance(subject, ModelSubject):
        findings = [_directional(subject, effort)]
        if type(subject.model).mean_albedo is not Model.mean_albedo:
            findings.append(_mean(subject))
    return Report("albedo", subject.name, tuple(findings), time.perf_counter() - start)


def _directional(subject: ModelSubject, effort: Effort) -> Finding:
    rng = np.random.default_rng(31)
    count = 2 * effort.confirmed
    points = rng.random((count, dimensions(subject)))
    at_end = rng.random(points.shape) < 0.1
    points = np.where(at_end, rng.integers(0, 2, points.shape), points)
    first = starts(subject)[:4]
    points[: len(first)] = first
    places, wo = viewer(subject, points)
    # Albedos are compared where they are not yet the horizon's limit
    own = closed_albedo(subject, places, wo)
    true = precise(subject, places, wo, 2e-6)
    off = (np.abs(own - true) / np.maximum(np.abs(true), 1)).max(axis=1)
    suspect = np.flatnonzero(~(off < 0.5 * CLOSED))
    if len(suspect):
        again = precise(subject, places[suspect], wo[suspect], 1e-8)
        difference = np.abs(own[suspect] - again) / np.maximum(np.abs(again), 1)
        off[suspect] = difference.max(axis=1)
    row = int(np.argmax(np.where(np.isnan(off), np.inf, off)))
    measured = float(off[row])
    limit = CLOSED if subject.closed_form else NUMERIC
    # Whether a kink falls between two nodes is luck
    verdict, text = judge(subject, "numeric_albedo", measured, limit=limit, searched=False)
    case = (places[row], wo[row], wo[row])
    kind = "closed form" if subject.closed_form else "quadrature"
    return Finding(
        "error of albedo",
        measured,
        verdict,
        f"{text}; {kind}",
        subject.tag(),
        subject.replay(*case),
        case,
    )


def _mean(subject: ModelSubject) -> Finding:
    """The closed form of the mean against the integral of the directional albedo."""
    x, w = np.polynomial.legendre.leggauss(MEAN_NODES)
    # Half of the nodes crowd in the horizon
    theta = np.concatenate([np.pi / 8 * (x + 1), np.pi / 2 - np.pi / 4 * ((x + 1) / 2) ** 3])
    w = np.concatenate([np.pi / 8 * w, np.pi / 4 * 3 / 2 * ((x + 1) / 2) ** 2 * w])
    weight = w * 2 * np.sin(theta) * np.cos(theta)
    rng = np.random.default_rng(32)
    places = np.stack([subject.default(), rng.random(len(subject.columns))])
    worst = 0.0
    for row in places:
        wo = np.stack([np.sin(theta), 0 * theta, np.cos(theta)], -1)
        E = precise(subject, np.tile(row, (len(theta), 1)), wo, 1e-6)
        true = (E * weight[:, None]).sum(axis=0)
        Float = number_type()
        UInt = dr.uint32_array_t(Float)
        model = subject.at(row[None], dr.zeros(UInt, 1), Float)
        own = columns_of(
            dr.replace_shape_t(Float, (3, -1))(model.mean_albedo()) + dr.zeros(Float, 1), Float
        )[0]
        worst = max(worst, float(np.abs(own - true).max()))
    verdict, text = (PASS if worst <= MEAN else FAIL), f"at most {MEAN:g} is allowed; closed form"
    up = np.array([0.0, 0.0, 1.0])
    case = (places[-1], up, up)
    return Finding(
        "error of mean albedo", worst, verdict, text, subject.tag(), subject.replay(*case), case
    )
