"""Runs the line that a finding gives, as it would be pasted, and says whether the fault is shown."""

from __future__ import annotations

import json
import math
import re
import shlex
from collections.abc import Iterable
from typing import Any

import numpy as np
from click.testing import CliRunner

from gonio.check.finite import LENGTH
from gonio.check.report import FAIL, Finding, Report
from gonio.cli import main

# Means of samples and searches come this near to what was found; three digits are shown of differences.
NEARLY = 0.01

# What is kept to this is kept.
NOTHING = 1e-7

NO_NUMBER = re.compile(r"\b(NaN|infinite|nan|inf)\b")


def replays(reports: Iterable[Report], again: bool) -> list[tuple[Report, Finding]]:
    """Failures whose line is `gonio eval`, each line once; with `again` also those that check again."""
    found: dict[tuple[str, str], tuple[Report, Finding]] = {}
    for report in reports:
        for finding in report.findings:
            line = finding.replay or ""
            if finding.verdict == FAIL and (again or line.startswith("gonio eval ")):
                found[line, finding.what] = (report, finding)
    return list(found.values())


def hidden(report: Report, finding: Finding) -> str:
    """Nothing where the line shows the fault; else the line, with what it gave."""
    words = shlex.split(finding.replay or "")
    result = CliRunner().invoke(main, [*words[1:], "--json"])
    try:
        data = json.loads(result.stdout)
        shown = _failed(data, report, finding) if words[1] == "check" else _shown(data, finding)
    except (json.JSONDecodeError, KeyError, TypeError) as error:
        shown, result.stderr_bytes = False, repr(error).encode()
    told = f"{report.check}, {finding.what} = {finding.measured:g} ({finding.text})"
    return "" if shown else f"{told}: {finding.replay}\n{result.output}"


def _failed(data: Any, report: Report, finding: Finding) -> bool:
    """Whether the same fails in the same way."""
    (again,) = (r for r in data if r["check"] == report.check)
    same = [f for f in again["findings"] if f["what"] == finding.what and f["verdict"] == "fail"]
    number = NO_NUMBER.search(finding.text) is None
    return any((NO_NUMBER.search(f["text"]) is None) == number for f in same)


def _shown(data: Any, finding: Finding) -> bool:
    """Whether the values that `gonio eval` gives have what the finding says."""
    if NO_NUMBER.search(finding.text):
        return bool(re.search(r'"(NaN|-?Infinity)"', json.dumps(_named(data, finding.text))))
    if "derivatives" in data:
        return any(_off(d) for d in data["derivatives"] if d["name"] in finding.text)
    if "u" in data and "compared" in data:  # how far samples may be apart depends on the lobe
        return _relative(data["wi"], data["compared"]["wi"]) > 0
    if "--compare double" in (finding.replay or ""):  # roundings are taken off what is found
        return _most(data, data["compared"], exact=True) >= (1 - NEARLY) * finding.measured
    if "compared" in data:
        swapped = "--compare swapped" in (finding.replay or "")
        return _near(_most(data, data["compared"], swapped=swapped), finding)
    if finding.what == "reported density":
        return _near(abs(data["pdf"] / data["sampled_pdf"] - 1), finding)
    if finding.what == "below zero, times pi":
        return _near(-math.pi * min(data["eval"]), finding)
    if finding.what == "largest albedo":
        return _near(max(data["albedo"]), finding)
    # Directions that are not of length one, and densities below zero
    return finding.what == "not finite" and (
        abs(np.linalg.norm(data["wi"]) - 1) > LENGTH or data["pdf"] < 0
    )


def _near(measured: float, finding: Finding) -> bool:
    return math.isclose(measured, finding.measured, rel_tol=NEARLY, abs_tol=NOTHING)


def _most(data: Any, other: Any, exact: bool = False, swapped: bool = False) -> float:
    """The largest relative difference, of the larger one or of the exact one."""
    names = ("eval",) if swapped else ("eval", "pdf", "albedo")  # the others are of wo
    return max(_relative(data[name], other[name], exact) for name in names)


def _named(data: Any, text: str) -> list[Any]:
    """What the text says is no number: a derivative where it names one, else all values."""
    named = [d for d in data.get("derivatives", []) if d["name"] in text]
    return named or [data, data.get("compared")]


def _off(derivative: Any) -> bool:
    """Whether a derivative is not what it is beside, in float32 or as a difference."""
    exact = derivative["float64"]
    beside = derivative["difference"] or exact
    return _relative(derivative["float32"], exact) > 0.02 or _relative(exact, beside) > 1e-4


def _relative(a: Any, b: Any, exact: bool = False) -> float:
    a, b = np.asarray(a, np.float64), np.asarray(b, np.float64)
    scale = np.abs(b) if exact else np.maximum(np.abs(a), np.abs(b))
    return float((np.abs(a - b) / np.maximum(scale, 1e-300)).max())
