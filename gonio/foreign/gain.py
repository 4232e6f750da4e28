"""Energy of foreign code: the largest albedo, told from what float32 adds, and from ends without values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from gonio.check import energy
from gonio.check.reciprocity import dimensions
from gonio.check.report import FAIL, NOTE, PASS, UNSURE, Effort, Finding
from gonio.check.subject import Array
from gonio.fields import Parameter
from gonio.foreign.places import LIMIT, places
from gonio.foreign.returned import around_the_mirror
from gonio.foreign.rounding import ROUNDINGS, rounded
from gonio.foreign.subject import ForeignSubject

# So many places tell whether an end of a parameter's range has values; if not, checks begin this part of
# the range inside of it.
PROBED, INSIDE = 256, 0.05

# The lowest cosine of the viewer at which a gain counts where roundings hide it.
MU_CLEAR = 1e-2

# An albedo of which roundings may be so much has no digits. That is looked for at such parts of a range
# from its ends, and for a viewer at a middling angle: seen at grazing angles much more is lost.
NO_DIGITS = 0.1
OUTER = (0.0, 1e-4, 1e-3, INSIDE / 8, INSIDE / 4, INSIDE / 2)
MIDDLING = np.array([0.6, 0.0, 0.8])


def without_poles(subject: ForeignSubject) -> tuple[ForeignSubject, list[Finding]]:
    """The subject without ends of parameters at which hardly any value is finite, and notes on them."""
    foreign = subject.foreign
    rng = np.random.default_rng(43)
    points = rng.uniform(0.05, 0.95, (PROBED, dimensions(subject)))
    # The mirror direction, where narrow lobes have their values
    points[:, -2:] = np.where(rng.random((PROBED, 1)) < 0.5, points[:, -4:-2], points[:, -2:])
    parameters, notes = dict(foreign.parameters), []
    for name, p in foreign.parameters.items():
        columns = [k for k, free in enumerate(subject.parameters) if free.path == name]
        for end, value, word in ((0.0, p.low, "begin"), (1.0, p.high, "end")):
            there = points.copy()
            there[:, columns] = end
            bad = ~np.isfinite(foreign.brdf(*places(subject, there))).all(axis=1)
            if bad.mean() < 0.5:
                continue
            p = parameters[name] = _inside(p, end)
            kept = p.high if end else p.low
            text = (
                f"no number at {name} = {value:g}; all checks but 'finite' {word} at {kept:g}; "
                f"--range {name}={p.low:g}..{p.high:g} if it is never given that"
            )
            notes.append(Finding("left out", float(bad.mean()), NOTE, text))
    return (narrowed(subject, parameters), notes) if notes else (subject, [])


def narrowed(subject: ForeignSubject, parameters: Mapping[str, Parameter]) -> ForeignSubject:
    """The subject with other ranges."""
    matched = replace(subject.foreign.matched, parameters=dict(parameters))
    return ForeignSubject(replace(subject.foreign, matched=matched))


def _inside(p: Parameter, end: float, part: float = INSIDE) -> Parameter:
    """A parameter without the part of its range at one end, 0 or 1."""
    width = part * (p.high - p.low)
    p = replace(p, high=p.high - width) if end else replace(p, low=p.low + width)
    return replace(p, default=_within(p))


def _within(p: Parameter) -> Any:
    """The default, not beyond the ends."""
    if isinstance(p.default, tuple):
        return tuple(float(np.clip(x, p.low, p.high)) for x in p.default)
    return float(np.clip(p.default, p.low, p.high))


def check(subject: ForeignSubject, effort: Effort) -> list[Finding]:
    """The largest albedo by search; a gain of less than LIMIT may be roundings of a white surface.

    Where values lose many digits, what is left of each without its roundings has to gain as well.
    """
    first, *others = energy.check(subject, effort.less()).findings
    return [_beyond_rounding(subject, effort, first), *others]


def _beyond_rounding(subject: ForeignSubject, effort: Effort, first: Finding) -> Finding:
    """A gain that was found, or what roundings leave of it.

    In the horizon 2 + 2 L.V, or 1 - N.H^2, can be nothing but roundings, which no shaking tells from an
    error: what is gained there alone is a note.
    """
    if first.verdict not in (FAIL, UNSURE) or first.case is None:
        return first
    if first.measured <= 1 + LIMIT:
        text = f"no more than roundings of float32; {first.text}"
        return replace(first, verdict=PASS, text=text)
    parameters, _, wo = first.case
    lost = albedo_lost(subject, parameters, wo)
    if first.verdict == FAIL and not lost * ROUNDINGS > first.measured - 1:
        return first
    least = ForeignSubject(subject.foreign, least=True)
    beyond = energy.largest(least, effort.less(), MU_CLEAR)
    if beyond.verdict == FAIL and beyond.measured > 1 + LIMIT:
        return replace(beyond, text=f"{beyond.text}; without what float32 may have rounded")
    if first.verdict == UNSURE:
        angle = np.degrees(np.arccos(MU_CLEAR))
        return replace(first, text=f"{first.text}; up to {angle:.4g} degrees {beyond.measured:.4g}")
    text = (
        f"no gain beyond rounding, which is {lost:.1g} there: digits are lost, and with them energy; "
        f"{first.text}"
    )
    return replace(first, verdict=NOTE, text=text)


def with_digits(subject: ForeignSubject) -> tuple[ForeignSubject, list[Finding]]:
    """The subject without ends of ranges at which values have no digits, and a note on them."""
    base = subject.default()
    base[[k for k, free in enumerate(subject.parameters) if free.declared.width == 3]] = 1
    found: dict[str, Parameter] = {}
    said = []
    for number, free in enumerate(subject.parameters):
        if free.declared.width != 1:
            continue

        def blurred(part: float, end: float, number: int = number) -> bool:
            row = base.copy()
            row[number] = abs(end - part)
            return not albedo_lost(subject, row, MIDDLING) < NO_DIGITS

        for end, words in ((0.0, "from {} = {:g} on"), (1.0, "up to {} = {:g}")):
            if not any(blurred(part, end) for part in OUTER):
                continue
            part = next((k * INSIDE for k in (1, 2, 4) if not blurred(k * INSIDE, end)), None)
            if part is not None:
                p = found[free.path] = _inside(found.get(free.path, free.declared), end, part)
                where = words.format(free.path, p.high if end else p.low)
                said.append(where)
    if not found:
        return subject, []
    text = f"values have digits {' and '.join(said)}; equalities and energy are judged there"
    note = Finding("left out", float(len(said)), NOTE, text)
    return narrowed(subject, {**subject.foreign.parameters, **found}), [note]


def albedo_lost(subject: ForeignSubject, parameters: Array, wo: Array) -> float:
    """How much of an albedo roundings of the directions may be, at one place."""
    values = {name: v[0] for name, v in subject.values(parameters[None]).items()}
    wi, weight = around_the_mirror(np.asarray(wo, np.float64))
    both = rounded(subject.foreign, wi, np.broadcast_to(wo, wi.shape), values)
    return float(np.nansum(both.rounding.max(axis=1) * weight * wi[:, 2]))
