"""What reflects nothing cannot be judged: of a value of 0 every promise is kept."""

from __future__ import annotations

import dataclasses

import numpy as np

from gonio.check.adversarial import hard_numbers, hard_parameters
from gonio.check.kernels import draw, evaluate
from gonio.check.report import PASS, UNSURE, Report
from gonio.check.subject import Array, Subject, directions, even

# Pairs of directions that are tried, for each of four kinds.
TRIED = 256

# The checks that values of 0 pass, and those that need densities of 0 as well.
PASSED_BY_BLACK = {"energy", "reciprocity", "albedo", "isotropy", "continuity", "monotonicity"}
OF_SAMPLES = {"sampling"}

# What departures and probabilities are where every value is 0.
NOTHING = {0.0, 1.0}


def judged(subject: Subject, report: Report) -> Report:
    """A report whose passes are no verdicts where there is nothing to judge."""
    passed = [f for f in report.findings if f.verdict == PASS]
    if report.check not in PASSED_BY_BLACK | OF_SAMPLES or not passed:
        return report
    if not all(f.measured in NOTHING for f in passed) or not is_dark(subject, report.check):
        return report
    what = "is never sampled and has" if report.check in OF_SAMPLES else "reflects nothing, and has"
    text = f"{subject.name} {what} a value of 0 wherever it was looked at: nothing to judge"
    return dataclasses.replace(
        report,
        findings=tuple(
            dataclasses.replace(f, verdict=UNSURE, text=text) if f.verdict == PASS else f
            for f in report.findings
        ),
    )


def is_dark(subject: Subject, check: str) -> bool:
    """Whether all values are 0, at samples, mirror directions and anywhere; OF_SAMPLES: densities too."""
    parameters = hard_parameters(subject, TRIED, 95)
    parameters[: TRIED // 4] = subject.default()
    index = np.arange(TRIED, dtype=np.uint32)
    a, b = even(TRIED), even(2 * TRIED)[TRIED:]
    wo, other = (directions(1 - x[:, 0], 2 * np.pi * x[:, 1]) for x in (a, b))
    drawn, density = draw(
        subject, parameters, index, wo, hard_numbers(TRIED, 96).astype(np.float64)
    )
    up = np.array([0.0, 0.0, 1.0])
    sampled: Array = np.where(((density > 0) & (drawn[:, 2] > 0))[:, None], drawn, up)
    for wi in (other, wo, wo * (-1, -1, 1), sampled):
        f, pdf = evaluate(subject, parameters, index, np.asarray(wi, np.float64), wo)
        if (f != 0).any() or (check in OF_SAMPLES and ((pdf != 0).any() or (density != 0).any())):
            return False
    return True
