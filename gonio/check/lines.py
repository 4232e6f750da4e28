"""Reports of several models as lines of text, and the verdict on each of them."""

from __future__ import annotations

from collections.abc import Sequence

from gonio.check import failed
from gonio.check.mitsuba_bsdf import SCOPE
from gonio.check.report import FAIL, NOTE, PASS, UNSURE, Report, summary, table


def state(own: Sequence[Report]) -> str:
    """The verdict on one model; UNSURE where nothing could be judged, NOTE where nothing was."""
    verdicts = {f.verdict for r in own for f in r.findings}
    if failed(own):
        return FAIL
    return PASS if verdicts - {NOTE, UNSURE} else UNSURE if UNSURE in verdicts else NOTE


def lines(reports: Sequence[Report]) -> list[str]:
    """The tables of all models, each with a line of counts below."""
    found: list[str] = []
    for name in dict.fromkeys(r.model for r in reports):
        own = [r for r in reports if r.model == name]
        seconds = sum(r.seconds for r in own)
        verdict = state(own)
        said = "not judged" if verdict in (UNSURE, NOTE) else verdict
        left_out = [f.text for r in own if r.check == SCOPE for f in r.findings]
        found += [
            f"{name}: {'; '.join([said, *left_out])}",
            *table(own),
            f"  {summary(own)} in {seconds:.1f} s",
            "",
        ]
    return found[:-1]


def unjudged(reports: Sequence[Report]) -> bool:
    """Whether of something nothing at all could be judged, as of code that is black."""
    names = {r.model for r in reports}
    return any(state([r for r in reports if r.model == name]) == UNSURE for name in names)
