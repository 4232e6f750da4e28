"""Measured files judged as models are: negative values, holes, energy, reciprocity, isotropy, noise.

What a file's authors have extrapolated, and what interpolation fills in, has findings of its own, which
do not count against the measurement.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

from gonio.check.report import FAIL, NOTE, PASS, Finding, Report
from gonio.measured import Measurement, load_parts
from gonio.measured.quality import Albedo, Quality, Spread, quality

# A surface reflects no more than it receives; what integration over steps of a degree adds to that.
ENERGY = 1.01

# Departures of real measurements are as large as their noise, but for this many times.
TIMES_NOISE = 3.0

# Below this departures are neither seen nor do they matter to a fit.
SMALL = 0.05

# Noise of a median value, above which a table says little between its places.
NOISY = 0.2

# Part of the places above the horizon that may be missing.
MISSING = 0.5

Judge = Callable[[Measurement, Quality], list[Finding]]


def check_file(path: str | Path, only: tuple[str, ...] = ()) -> list[Report]:
    """Judge the reflection that a file holds.

    Args:
        path: a file of a format that `gonio.measured` reads.
        only: names of checks; all if empty.

    Raises:
        DataError: the file cannot be read.
    """
    begin = time.perf_counter()
    found = [part for part in load_parts(path) if not part.transmission] or load_parts(path)
    reports = []
    for measured in found:
        name = measured.title if len(found) == 1 else f"{measured.title} ({measured.part})"
        q = quality(measured)
        for check, judge in DATA_CHECKS.items():
            if not only or check in only:
                seconds = time.perf_counter() - begin
                reports.append(Report(check, name, tuple(judge(measured, q)), seconds))
                begin = time.perf_counter()
    return reports


def _negative(measured: Measurement, q: Quality) -> list[Finding]:
    verdict = FAIL if q.negative else PASS
    findings = [
        Finding(
            "values below 0",
            q.negative / q.used,
            verdict,
            f"of {q.used} places, down to {min(q.lowest, 0):.4g} at a largest value of {q.largest:.4g}; "
            "light is not negative",
        )
    ]
    if q.extrapolated:
        part = q.negative_extrapolated / q.extrapolated
        verdict = NOTE if q.negative_extrapolated else PASS
        findings.append(
            Finding("below 0, extrapolated", part, verdict, f"of {q.extrapolated} places")
        )
    return findings


def _holes(measured: Measurement, q: Quality) -> list[Finding]:
    above = q.used + q.holes
    part = q.holes / above
    verdict = FAIL if part > MISSING else NOTE if q.holes else PASS
    findings = [
        Finding(
            "holes",
            part,
            verdict,
            f"of {above} places above the horizon; at most {MISSING:g} is allowed",
        )
    ]
    if q.extrapolated:
        findings.append(
            Finding(
                "extrapolated", q.extrapolated / q.used, NOTE, "continued by the file's authors"
            )
        )
    if q.covered == q.covered:  # transmission has none
        findings.append(
            Finding(
                "covered", q.covered, NOTE, "of all pairs of directions up to 85° are near a value"
            )
        )
    return findings


def _energy(measured: Measurement, q: Quality) -> list[Finding]:
    if not q.albedos:
        return [Finding("largest albedo", float("nan"), NOTE, "not integrated for transmission")]
    findings = []
    for what, value in (("largest albedo", _measured), ("with what is filled in", _all)):
        worst = max(q.albedos, key=value)
        over = value(worst) > ENERGY
        verdict = (FAIL if what == "largest albedo" else NOTE) if over else PASS
        text = f"at theta_o {worst.theta:.0f}°"
        if not measured.isotropic:
            text += f", phi_o {worst.phi:.0f}°"
        findings.append(
            Finding(what, value(worst), verdict, f"{text}; at most {ENERGY:g} is allowed")
        )
    return findings


def _measured(albedo: Albedo) -> float:
    return albedo.measured


def _all(albedo: Albedo) -> float:
    return albedo.all


def _departure(what: str, spread: Spread, q: Quality) -> list[Finding]:
    if spread.count == 0:
        return [Finding(what, float("nan"), NOTE, "cannot be told from this file")]
    noise = 0.0 if q.noise.count == 0 else q.noise.median
    limit = max(SMALL, TIMES_NOISE * noise)
    text = f"in the middle, {spread.high:.3g} at 19 of 20 places; noise allows {limit:.2g}"
    return [Finding(what, spread.median, FAIL if spread.median > limit else PASS, text)]


def _reciprocity(measured: Measurement, q: Quality) -> list[Finding]:
    return _departure("directions swapped", q.reciprocity, q)


def _isotropy(measured: Measurement, q: Quality) -> list[Finding]:
    if measured.isotropic:
        return _departure("mirrored at the plane of incidence", q.symmetry, q)
    if q.symmetry.count == 0:
        return [Finding("sample turned", float("nan"), NOTE, "cannot be told from this file")]
    text = f"in the middle, {q.symmetry.high:.3g} at 19 of 20 places; the format promises nothing"
    return [Finding("sample turned", q.symmetry.median, NOTE, text)]


def _noise(measured: Measurement, q: Quality) -> list[Finding]:
    if q.noise.count == 0:
        return [Finding("noise", float("nan"), NOTE, "too few values to tell")]
    text = f"in the middle, {q.noise.high:.3g} at 19 of 20 places; at most {NOISY:g} is allowed"
    return [Finding("noise", q.noise.median, FAIL if q.noise.median > NOISY else PASS, text)]


DATA_CHECKS: dict[str, Judge] = {
    "negative": _negative,
    "holes": _holes,
    "energy": _energy,
    "reciprocity": _reciprocity,
    "isotropy": _isotropy,
    "noise": _noise,
}
