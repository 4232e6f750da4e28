"""What a check has found: with its size, what is allowed, and a command that shows the worst case again."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from decimal import Decimal
from typing import Any
from xml.etree import ElementTree

from gonio import notebook
from gonio.check.subject import Subject, finite, known_size

PASS, NOTE, KNOWN, FAIL = "pass", "note", "known", "FAIL"
ORDER = (PASS, NOTE, KNOWN, FAIL)


@dataclass(frozen=True)
class Effort:
    """How long the checks look."""

    name: str
    population: int
    """Points in a round of a search for directions and parameters."""
    rounds: int
    albedos: int
    """Points in a round of a search for albedos, each an integral."""
    confirmed: int
    """How many of the best are integrated adaptively."""
    pairs: int
    """Pairs of directions for which float32 is compared with float64."""
    tests: int
    """Points at which the sampler is tested by chi-square, default options; a third with others."""
    samples: int
    """Samples of each of these tests."""
    derivatives: bool
    """Whether derivatives are checked with every option, or with the default ones only."""


# At 2^22 samples in 64 cells a density wrong by 0.5 % everywhere is rejected with a probability of 99 %.
EFFORTS = {
    "quick": Effort("quick", 4096, 12, 1024, 16, 30_000, 2, 1 << 22, False),
    "normal": Effort("normal", 16384, 32, 4096, 48, 200_000, 12, 1 << 22, True),
    "thorough": Effort("thorough", 65536, 64, 16384, 128, 1_000_000, 48, 1 << 24, True),
}


@dataclass(frozen=True)
class Finding:
    """One number that was measured, and what it means."""

    what: str
    measured: float
    verdict: str
    text: str
    """In words: what is allowed or documented, and where the worst case is."""
    tag: str = ""
    """The options it was measured with."""
    replay: str | None = None
    """A command that shows the worst case."""
    case: tuple[Any, Any, Any] | None = field(default=None, repr=False, compare=False)
    """Places of the parameters, wi and wo of the worst case, for the picture."""

    def data(self) -> dict[str, Any]:
        """As plain data that JSON can hold."""
        return {
            "what": self.what,
            "options": self.tag,
            "measured": finite(self.measured) if not math.isnan(self.measured) else None,
            "verdict": self.verdict.lower(),
            "text": self.text,
            "replay": self.replay,
        }


@dataclass(frozen=True)
class Report:
    """What one check has found about one model."""

    check: str
    model: str
    findings: tuple[Finding, ...]
    seconds: float = 0.0

    @property
    def verdict(self) -> str:
        """The worst of the findings."""
        return max((f.verdict for f in self.findings), key=ORDER.index, default=PASS)

    @property
    def failed(self) -> bool:
        """Whether something is not as it is claimed."""
        return self.verdict == FAIL


def judge(
    subject: Subject,
    promise: str,
    measured: float,
    *,
    limit: float,
    ideal: float = 0.0,
    searched: bool = True,
) -> tuple[str, str]:
    """Compare a departure with what the model says of it, and say so.

    Args:
        subject: what was measured.
        promise: field of `gonio.claims.Claims`.
        measured: the largest departure that was found.
        limit: up to which the promise counts as kept; it allows for roundings.
        ideal: the value without any departure.
        searched: whether the worst case has been searched for. How near a few points come to it is luck,
            and says nothing against a documented size that is larger.
    """
    known = known_size(subject, promise)
    if not measured > limit and not math.isnan(measured):
        if known is not None and subject.whole and searched:
            return FAIL, f"kept, but the model does not promise it: it declares {known:g}"
        return PASS, f"at most {limit if known is None or searched else known:g} is allowed"
    if known is None:
        return FAIL, f"at most {limit:g} is allowed"
    if math.isinf(known):
        return KNOWN, "documented to have no bound"
    if measured > known + _rounding(known):
        return FAIL, f"more than the documented {known:g}"
    if subject.whole and searched and measured - ideal < 0.5 * (known - ideal):
        return FAIL, f"the documented {known:g} is far too large"
    return KNOWN, f"documented as {known:g}"


def _rounding(size: float) -> float:
    """Half of the last digit of a documented size, which is rounded."""
    exponent = Decimal(repr(size)).normalize().as_tuple().exponent
    return 0.505 * 10.0 ** int(exponent) if int(exponent) < 0 else 1e-3 * size


class Reports(list[Report]):
    """What all checks have found; prints as a table, in notebooks as well."""

    def __str__(self) -> str:
        """The table and its sum, as `gonio check` prints them."""
        return "\n".join([*table(self), summary(self)])

    def _repr_html_(self) -> str:
        """The same for notebooks."""
        heads = ("check", "measures", "measured", "verdict", "allowed, and where")
        names = ", ".join(dict.fromkeys(report.model for report in self))
        return notebook.table(f"gonio check {names}", summary(self), heads, _rows(self))


# --- as text -------------------------------------------------------------------------------------


def _rows(reports: Sequence[Report]) -> list[tuple[str, str, str, str, str]]:
    """Check, measure, size, verdict and words: one row for all that is as it should be."""
    rows: list[tuple[str, str, str, str, str]] = []
    for report in reports:
        by_what: dict[str, list[Finding]] = {}
        for finding in report.findings:
            by_what.setdefault(finding.what, []).append(finding)
        name = report.check
        several = len({f.tag for f in report.findings}) > 1
        for what, findings in by_what.items():
            fine = [f for f in findings if f.verdict == PASS]
            if fine:
                worst = max(fine, key=lambda f: f.measured)
                also = f" ({len(fine)} variants)" if len(fine) > 1 else ""
                rows.append((name, what, _size(worst.measured), PASS, worst.text + also))
                name = ""
            for finding in findings:
                if finding.verdict != PASS:
                    tag = f"{finding.tag}: " if finding.tag and several else ""
                    text = tag + finding.text
                    rows.append((name, what, _size(finding.measured), finding.verdict, text))
                    name = ""
    return rows


def table(reports: Sequence[Report]) -> Iterator[str]:
    """The lines of a table: what was as it should be in one line each, everything else in full."""
    rows = _rows(reports)
    widths = [max((len(row[i]) for row in rows), default=0) for i in range(4)]
    for row in rows:
        cells = (f"{cell:<{width}}" for cell, width in zip(row[:4], widths, strict=True))
        yield f"  {'  '.join(cells)}  {row[4]}".rstrip()
    for report in reports:
        for finding in report.findings:
            if finding.verdict == FAIL and finding.replay:
                yield f"  {report.check}, {finding.what}: {finding.replay}"


def _size(value: float) -> str:
    return "" if math.isnan(value) else f"{value:.4g}"


def summary(reports: Iterable[Report]) -> str:
    """One line: how many findings of each kind."""
    verdicts = [f.verdict for r in reports for f in r.findings]
    counts = [
        f"{n} {word}"
        for verdict, word in ((FAIL, "FAILED"), (KNOWN, "known"), (PASS, "passed"))
        if (n := verdicts.count(verdict)) or verdict == PASS
    ]
    return ", ".join(counts)


def data(reports: Sequence[Report]) -> list[dict[str, Any]]:
    """All findings as plain data that JSON can hold."""
    return [
        {
            "model": r.model,
            "check": r.check,
            "verdict": r.verdict.lower(),
            "seconds": round(r.seconds, 3),
            "findings": [f.data() for f in r.findings],
        }
        for r in reports
    ]


def junit(reports: Sequence[Report]) -> bytes:
    """JUnit's XML, as continuous integration shows it: a suite for each model, a case for each check."""
    root = ElementTree.Element("testsuites", name="gonio check")
    for model in dict.fromkeys(r.model for r in reports):
        own = [r for r in reports if r.model == model]
        suite = ElementTree.SubElement(
            root,
            "testsuite",
            name=model,
            tests=str(len(own)),
            failures=str(sum(r.failed for r in own)),
            errors="0",
            skipped="0",
            time=f"{sum(r.seconds for r in own):.3f}",
        )
        for report in own:
            case = ElementTree.SubElement(
                suite,
                "testcase",
                classname=f"gonio.check.{model}",
                name=report.check,
                time=f"{report.seconds:.3f}",
            )
            bad = [f for f in report.findings if f.verdict == FAIL]
            if bad:
                failure = ElementTree.SubElement(case, "failure", message=_sentence(bad[0]))
                failure.text = "\n".join(f"{_sentence(f)}\n{f.replay or ''}".rstrip() for f in bad)
            notes = [f for f in report.findings if f.verdict in (KNOWN, NOTE)]
            if notes:
                out = ElementTree.SubElement(case, "system-out")
                out.text = "\n".join(f"{f.verdict}: {_sentence(f)}" for f in notes)
    ElementTree.indent(root)
    return bytes(ElementTree.tostring(root, encoding="utf-8", xml_declaration=True))


def _sentence(finding: Finding) -> str:
    tag = f" [{finding.tag}]" if finding.tag else ""
    return f"{finding.what}{tag} = {finding.measured:.6g}: {finding.text}"
