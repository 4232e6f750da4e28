"""Commands that show a finding again: where one pair of directions does not show it, the check itself."""

from __future__ import annotations

import re
from dataclasses import replace

from gonio.check.report import Finding, Report
from gonio.check.subject import Subject

# What these find is an integral, a count of samples, a derivative, or a change from one place to the next.
MEASURED = {"sampling", "albedo", "monotonicity", "continuity", "gradient"}

# Where the worst case is told with random numbers, the one sample of them shows it.
SAMPLE = " --u "


def shown(subject: Subject, report: Report) -> Report:
    """A report whose replays show what was found."""
    findings = tuple(_shown(subject, report.check, finding) for finding in report.findings)
    return replace(report, findings=findings)


def _shown(subject: Subject, check: str, finding: Finding) -> Finding:
    # `gonio eval` shows the closed form beside such an albedo, and not the integral
    closed = finding.what == "largest albedo" and subject.albedos != "quadrature"
    if check not in MEASURED and not closed:
        return finding
    if finding.replay is None or finding.case is None:
        return finding
    if check == "sampling" and SAMPLE in finding.replay:
        return finding
    said = f"{finding.what} {finding.text}"
    # What changes along a parameter is seen where that one is free
    free = {
        f.path
        for f in subject.parameters
        if re.search(rf"(with|at|/ d) {re.escape(f.path)}\b", said)
    }
    again = subject.recheck(check, finding.case[0], free)
    return replace(finding, replay=again or finding.replay)
