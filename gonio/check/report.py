"""What a check has found: with its size, what is allowed, and a command that shows the worst case again."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any
from xml.etree import ElementTree

from gonio import notebook
from gonio.check.subject import Case, Subject, finite

PASS, NOTE, KNOWN, UNSURE, FAIL = "pass", "note", "known", "unsure", "FAIL"
ORDER = (PASS, NOTE, KNOWN, UNSURE, FAIL)

# A documented size may be larger than the departure that is found by a share of it, and by what rounding up
# to two decimals adds; of values above 1 by a few percent of the value. Searches with the default effort,
# from two beginnings each, agreed to within 3 % of the departure in 58 of 62 choices of models and options.
GENEROUS, DECIMALS, FEW_PERCENT = 0.05, 0.01, 0.03

# A size is called too large when none of so many whole searches, each from another beginning, comes near.
BEGINNINGS = 3

# A size is as good as none if it is only so many times the limit.
NEARLY = 5.0

# What is said of a documented size that is not reached, and of one that is no departure at all; and of both
# where nothing more is searched.
TOO_LARGE, KEPT = "is far too large", "kept, but the model does not promise it"
BOUND = "is an upper bound here"


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
    integrals: int
    """How many points are integrated adaptively whatever the estimates say."""
    pairs: int
    """Points in a round of the search for errors of float32."""
    cases: int
    """Hard cases beside the fixed list, and points in a round of the search for overflows."""
    screened: int
    """Rows of parameters at which the sampler is looked at with a few samples."""
    tests: int
    """Rows at which it is tested with many: the default ones, and the most suspicious of the others.

    0 if another variant has the same sampler, and has been tested."""
    samples: int
    """Samples of each of these tests."""
    derivatives: bool
    """Whether derivatives are checked with every option, or with the default ones only."""
    variants: int
    """Combinations of two options are checked while there are at most so many variants of the model."""
    small: bool = False
    """Whether batches are so small that one thread is enough."""
    briefly: bool = False
    """Whether derivatives are looked at at hard cases only, and in no search."""
    full: Effort | None = None
    """What this is less of: a documented size is called too large after a search with that."""
    bounds: bool = False
    """Whether documented sizes are taken as upper bounds: what these searches miss says nothing."""
    seed: int = 0
    """Where its searches begin: with another number, elsewhere."""

    def beginning(self, number: int) -> int:
        """The seed of one of its searches."""
        return number + 1000 * self.seed

    def whole(self) -> Iterator[Effort]:
        """What to search with, one after the other, before a documented size is called too large.

        What a search has missed says nothing against a size: more of it, and then from other beginnings.
        """
        full = replace(self.full or self, seed=self.seed)
        efforts = [replace(full, seed=self.seed + more) for more in range(1, BEGINNINGS)]
        if self.full is not None:
            efforts.insert(0, full)
            if self.population < full.less().population:
                efforts.insert(0, full.less())
        for effort in efforts:  # samples are not what is searched for
            yield replace(effort, tests=self.tests, samples=self.samples)

    def less(self) -> Effort:
        """For options other than the default ones: the same checks, with smaller searches."""
        return replace(
            self,
            full=self.full or self,
            population=max(self.population // 4, 512),
            rounds=max(self.rounds // 3, 4),
            albedos=max(self.albedos // 4, 128),
            confirmed=max(self.confirmed // 2, 4),
            integrals=max(self.integrals // 8, 32),
            pairs=max(self.pairs // 4, 256),
            cases=max(self.cases // 4, 256),
            screened=max(self.screened // 4, 16),
            tests=max(self.tests // 3, 1),
            samples=max(self.samples // 4, 1 << 16),
            bounds=self.name == "quick",
        )


_NORMAL = Effort(
    "normal", 16384, 24, 1024, 24, 2048, 8192, 8192, 512, 8, 1 << 20, True, 64, small=True
)

EFFORTS = {
    # That nothing comes near a documented size is said after a normal search
    "quick": Effort(
        *("quick", 4096, 12, 768, 8, 256, 512, 1024, 96, 3, 1 << 18, False, 12),
        small=True,
        full=_NORMAL,
    ),
    "normal": _NORMAL,
    "thorough": Effort(
        "thorough", 65536, 64, 8192, 96, 16384, 65536, 65536, 4096, 32, 1 << 22, True, 1000
    ),
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
    case: Case | None = field(default=None, repr=False, compare=False)
    """The worst case, for the picture."""

    @property
    def overstated(self) -> bool:
        """Whether something is better than it is claimed: a search that missed the worst says so too."""
        return self.verdict == FAIL and (TOO_LARGE in self.text or KEPT in self.text)

    def data(self) -> dict[str, Any]:
        """As plain data that JSON can hold."""
        return {
            "what": self.what,
            "options": self.tag,
            "measured": "NaN" if math.isnan(self.measured) else finite(self.measured),
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

    @property
    def overstated(self) -> bool:
        """Whether one of the findings is."""
        return any(f.overstated for f in self.findings)

    def within_bounds(self) -> Report:
        """The same where sizes are upper bounds: what is better than it is claimed is no fault."""

        def taken(f: Finding) -> Finding:
            text = f.text.replace(TOO_LARGE, BOUND).replace(
                KEPT, f"kept; what is documented {BOUND}"
            )
            return (
                f if text == f.text or f.verdict != FAIL else replace(f, verdict=KNOWN, text=text)
            )

        return replace(self, findings=tuple(taken(f) for f in self.findings))


def judge(
    subject: Subject,
    promise: str,
    measured: float,
    *,
    limit: float,
    ideal: float = 0.0,
    searched: bool = True,
    error: float = 0.0,
    fault: str = "",
) -> tuple[str, str]:
    """Compare a departure with what the model says of it, and say so.

    A documented size is never short, whatever its digits, and at most `largest_documented`.

    Args:
        subject: what was measured.
        promise: field of `gonio.claims.Claims`.
        measured: the largest departure that was found.
        limit: up to which the promise counts as kept; it allows for roundings.
        ideal: the value without any departure.
        searched: whether the worst case has been searched for. How near a few points come to it is luck,
            and says nothing against a documented size that is larger.
        error: of the measurement.
        fault: what is no number of the values compared, as `gonio.check.no_number.said` has it.
    """
    if fault or not math.isfinite(measured):
        return FAIL, fault or "not a number"
    documented = subject.size(promise)
    known = None if documented is None else documented.size
    # Inherited sizes, and those of a model with something fixed, are upper bounds
    exact = documented is not None and documented.own and subject.whole and searched
    if measured <= limit:
        if known is not None and exact and known > ideal + NEARLY * (limit - ideal):
            return FAIL, f"{KEPT}: it declares {known:g}"
        return (
            PASS,
            f"at most {limit if known is None or searched else max(known, limit):g} is allowed",
        )
    if known is None:
        return FAIL, f"at most {limit:g} is allowed"
    if math.isinf(known):
        return KNOWN, "documented to have no bound"
    if not measured <= known + error:
        return FAIL, f"more than the documented {known:g}"
    if exact and not known <= largest_documented(measured, ideal):
        return FAIL, f"the documented {known:g} {TOO_LARGE}"
    return KNOWN, f"documented as at most {known:g}"


def largest_documented(measured: float, ideal: float = 0.0) -> float:
    """The largest size that may be documented where a departure has been measured."""
    rounding = FEW_PERCENT * measured if ideal else DECIMALS
    return measured + GENEROUS * (measured - ideal) + rounding


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
            if finding.verdict in (FAIL, UNSURE) and finding.replay:
                yield f"  {report.check}, {finding.what}: {finding.replay}"


def _size(value: float) -> str:
    return f"{value:.4g}"


SUMMED = ((FAIL, "FAILED"), (UNSURE, "not judged"), (KNOWN, "known"), (PASS, "passed"))


def summary(reports: Iterable[Report]) -> str:
    """One line: how many findings of each kind."""
    verdicts = [f.verdict for r in reports for f in r.findings]
    counts = [
        f"{n} {word}"
        for verdict, word in SUMMED
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
    """JUnit's XML, as continuous integration shows it: a suite for each model, a case for each check.

    What could not be judged is skipped.
    """
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
            skipped=str(sum(r.verdict == UNSURE for r in own)),
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
            if report.verdict == UNSURE:
                unsure = next(f for f in report.findings if f.verdict == UNSURE)
                ElementTree.SubElement(case, "skipped", message=_sentence(unsure))
            notes = [f for f in report.findings if f.verdict in (KNOWN, NOTE, UNSURE)]
            if notes:
                out = ElementTree.SubElement(case, "system-out")
                out.text = "\n".join(f"{f.verdict}: {_sentence(f)}" for f in notes)
    ElementTree.indent(root)
    return bytes(ElementTree.tostring(root, encoding="utf-8", xml_declaration=True))


def _sentence(finding: Finding) -> str:
    tag = f" [{finding.tag}]" if finding.tag else ""
    return f"{finding.what}{tag} = {finding.measured:.6g}: {finding.text}"
