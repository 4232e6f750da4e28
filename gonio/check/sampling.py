"""Sampling: the density integrates to one, samples follow it, weights average to the albedo.

Many rows of parameters are looked at with a few samples each; the defaults and the most suspicious of the
others are tested with many. Cells are cut by a first set of samples so that each holds about as many.
The samples that are counted in them are evenly spread (Roberts' sequence), in `REPLICATES` sets that are
shifted by random numbers: their scatter says how exact the counts are, which is far more than with
independent samples. The means are compared with the adaptive integral of the density over each cell.
"""

from __future__ import annotations

import functools
import math
import time
from dataclasses import dataclass

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from gonio.check import hemisphere, sampled
from gonio.check.adversarial import special_parts
from gonio.check.energy import dimensions, spread_out, starts, viewer
from gonio.check.hemisphere import CELLS, COSINE_SECOND, PDF, SECOND, UNREACHED
from gonio.check.kernels import draw, evaluate, reflect, sample
from gonio.check.no_number import said
from gonio.check.report import FAIL, KNOWN, NOTE, PASS, UNSURE, Effort, Finding, Report, judge
from gonio.check.search import maximise
from gonio.check.statistics import chi2_limit, chi2_tail, noncentral_tail
from gonio.check.subject import (
    Array,
    Subject,
    directions,
    even,
    number_type,
    repeated,
    stored,
    vectors,
)
from gonio.check.suspects import INTEGRALS, SCREEN_SAMPLES, Screened, screen, screened, suspects

# Probability of a false alarm of one test. A test that fails is repeated with other random numbers, and
# only a second failure counts.
ALARM = 1e-4

# Sets of samples, each shifted by other random numbers.
REPLICATES = 16

# Relative errors of a cell's count that are not seen whatever the samples say: the integrals' own.
FLOOR = 1e-4

# Errors of the adaptive integrals, doubled; Mitsuba's plug-ins compute in float32.
TRUSTED, TRUSTED_FLOAT32 = 2e-4, 2e-3

# How often cells are cut.
CUTS = 10

# The same where something seems to be wrong: a lobe of width 1e-4 off the mirror direction needs it.
CAREFULLY = 1e-8

# The reported density is that of `pdf`, but for roundings of wi in between.
SAME, SAME_FLOAT32 = 1e-6, 2e-2

# Points at least of a search for unreached light.
LOOKED_AT = 48

# Samples that a search for waste draws at each point, where it looks around the best, and to confirm one:
# the first tell 0.1 from nothing, the second 0.01.
FEW, MORE, MANY = 64, 1 << 10, 1 << 16

# Standard errors that a mean may be off. They are estimated from REPLICATES numbers: Student's t with 15
# degrees of freedom exceeds 7 once in 200,000 times.
SIGMAS = 7.0

# A mean weight that may be off by so large a part of the albedo is not judged; good samplers keep to 0.01.
BLURRED = 0.1

# Samples, and directions anywhere, of a place that fails, among which is looked for what is no number.
PROBES = 1 << 12

# Samples in one kernel call, which bounds the memory.
BATCH = 1 << 21


def check(subject: Subject, effort: Effort) -> Report:
    """Density, samples, weights and waste; without tests only light that is never sampled."""
    start = time.perf_counter()
    looked = screened(subject, effort)
    if not effort.tests:  # the samples are those of another variant
        findings = [_unreached(subject, looked, effort)]
        return Report("sampling", subject.name, tuple(findings), time.perf_counter() - start)
    findings = [_wasted(subject, effort), _unreached(subject, looked, effort)]
    points = suspects(subject, looked, effort)
    first = [_test(subject, point[None], effort.samples, seed) for seed, point in enumerate(points)]
    trusted = TRUSTED_FLOAT32 if subject.float32 else TRUSTED
    tests = [
        _test(subject, points[row : row + 1], effort.samples, 500 + row, careful=True)
        if test.suspicious(trusted)
        else test
        for row, test in enumerate(first)
    ]
    findings += _judged(subject, points, tests, first, effort)
    findings += _reported(subject, points, tests, looked)
    if subject.claiming and not subject.float32:
        findings.append(sampled.check(subject, effort))
    return Report("sampling", subject.name, tuple(findings), time.perf_counter() - start)


# --- one test ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Sampled:
    """What the samples of one point have shown."""

    chi2: float
    """Squared differences of cells' counts from their integrals, over their variance."""
    bins: int
    probability: float
    """Of a larger chi-square."""
    power: float
    """The error of a density, up in half of the cells and down in the others, found in 99 % of the runs."""
    integral: float
    """Of the density."""
    kept: float
    """Part of the samples that have a direction."""
    kept_error: float
    mean: float
    """Of the weights, and its standard error."""
    mean_error: float
    albedo: float
    integral_error: float
    variance: float
    cosine_variance: float
    largest: float
    """Weight."""
    unreached: float
    different: float
    """Largest relative difference between the reported density and that of `pdf`."""
    below: int
    """Samples below the horizon with a density."""

    def density_off(self) -> float:
        """Difference between the density's integral and the samples kept, beyond its standard error."""
        return abs(self.integral - self.kept) - SIGMAS * self.kept_error - self.integral_error

    def mean_off(self) -> float:
        """Relative difference between the mean weight and the albedo, beyond its standard error."""
        off = abs(self.mean - (self.albedo - self.unreached)) - SIGMAS * self.mean_error
        off -= self.integral_error
        return (off if off > 0 or np.isnan(off) else 0.0) / max(self.albedo, 1e-3)

    def blurred(self) -> float:
        """Up to which part of the albedo the mean weight tells nothing."""
        return SIGMAS * self.mean_error / max(self.albedo, 1e-3)

    def faults(self) -> str:
        """What is no number of the integrals: at places that no sample need to meet."""
        return said(("the integral of eval", self.albedo), ("the integral of pdf", self.integral))

    def suspicious(self, trusted: float) -> bool:
        """Whether it has to be repeated with other random numbers and finer integrals."""
        right = self.density_off() <= trusted and self.mean_off() <= trusted
        return not (self.probability >= ALARM and right)


def _test(
    subject: Subject, point: Array, samples: int, seed: int, *, careful: bool = False
) -> Sampled:
    parameters, wo = viewer(subject, point)
    cut = hemisphere.partition(subject, parameters, wo)
    tolerance, cuts = (CAREFULLY, hemisphere.LEVELS) if careful else (INTEGRALS, CUTS)
    integrals = hemisphere.integrate(subject, parameters, wo, cut, tolerance, cuts)
    rng = np.random.default_rng(1000 + seed)
    each = samples // REPLICATES
    counts = np.zeros((REPLICATES, CELLS + 1))
    totals, squares = np.zeros(REPLICATES), 0.0
    largest, different, below = 0.0, 0.0, 0
    shifts = rng.random((REPLICATES, 1, 2))
    together = max(BATCH // each, 1)
    for first in range(0, REPLICATES, together):
        u = (even(each) + shifts[first : first + together]) % 1.0
        rows = slice(first, first + len(u))
        cells, weight, off, low = _drawn(subject, parameters, wo, cut, u.reshape(-1, 2))
        place = cells + (CELLS + 1) * (np.arange(len(cells)) // each)
        counts[rows] = np.bincount(place, minlength=len(u) * (CELLS + 1)).reshape(len(u), -1)
        totals[rows] = weight.reshape(len(u), -1).sum(axis=1)
        squares += float(np.square(weight).sum())
        largest = float(np.maximum(largest, weight.max()))
        different = float(np.maximum(different, off.max()))
        below += int(low.sum())
    whole = integrals.total[0]
    chi2, bins, power = _compare(counts / each, integrals.cells[0, :, PDF], integrals.cell_error[0])
    means = totals / each
    mean = float(means.mean())
    albedo = float(whole[:3].mean())
    kept = 1 - counts[:, CELLS] / each
    root = np.sqrt(REPLICATES)
    return Sampled(
        chi2,
        bins,
        chi2_tail(chi2, bins) if np.isfinite(chi2) else 0.0,
        power,
        float(whole[PDF]),
        float(kept.mean()),
        float(kept.std(ddof=1) / root),
        mean,
        float(means.std(ddof=1) / root),
        albedo,
        float(integrals.error[0]),
        float(np.maximum(whole[SECOND] - albedo * albedo, 0.0)),
        float(np.maximum(whole[COSINE_SECOND] - albedo * albedo, 0.0)),
        largest,
        float(whole[UNREACHED]),
        different,
        below,
    )


def _drawn(
    subject: Subject, parameters: Array, wo: Array, cut: hemisphere.Partition, u: Array
) -> tuple[NDArray[np.intp], Array, Array, NDArray[np.bool_]]:
    """Cell of every sample (CELLS if it is wasted), weight, error of the reported density, below or not."""
    Float = number_type()
    UInt = dr.uint32_array_t(Float)
    n = len(u)
    wo_ = vectors(Float, np.repeat(wo, n, axis=0))
    index = stored(UInt, np.zeros(n, np.uint32))
    model = subject.at(parameters, index, Float)
    wi, reported = sample(model, wo_, vectors(Float, u))
    good = reported > 0
    f, pdf = reflect(model, wi, wo_)
    a, b = hemisphere.unchart(wo_, wi, dr.opaque(Float, float(cut.side[0])))
    cell = hemisphere.cell_of(stored(Float, cut.cuts[0]), index, a, b)
    cell = dr.select(good & (wi.z > 0), cell, CELLS)
    mean = (f.x + f.y + f.z) / 3
    weight = dr.select(good, mean * wi.z / dr.select(good, reported, 1), 0)
    off = dr.select(good & (wi.z > 0), dr.abs(pdf - reported) / dr.select(good, reported, 1), 0)
    low = good & (wi.z <= 0)
    zero = dr.zeros(Float, n)
    results = [cell + dr.zeros(UInt, n), weight + zero, off + zero, dr.select(low, 1, 0) + zero]
    dr.eval(results)
    cells, weights, offs, lows = (r.numpy() for r in results)
    return cells.astype(np.intp), weights, offs, lows > 0


def _compare(shares: Array, expected: Array, error: Array) -> tuple[float, int, float]:
    """Chi-square of the replicates' shares of the cells against integrals, its bins, and the power.

    error: of the integrals.

    The variance of a cell's mean is taken from the scatter of its shares, half of it from that of all
    cells: sixteen numbers alone would make some cells far too sure.
    """
    expected = np.append(expected, max(1 - float(expected.sum()), 0.0))
    mean = shares.mean(axis=0)
    variance = shares.var(axis=0, ddof=1) / len(shares)
    inner = variance[:-1]
    pooled = 0.5 * (variance + inner.mean())
    # What is never drawn and never expected says nothing
    used = (mean > 0) | (expected > 1e-7)
    pooled = pooled + (FLOOR * np.maximum(expected, 1 / CELLS)) ** 2
    pooled += np.append(error, error.sum()) ** 2
    chi2 = float(np.sum((mean - expected)[used] ** 2 / pooled[used]))
    bins = int(np.count_nonzero(used))
    offset = float(np.sum(expected[used] ** 2 / pooled[used]))
    return chi2, bins, float(np.sqrt(needed_offset(bins) / offset))


@functools.cache
def needed_offset(bins: int) -> float:
    """The noncentrality at which the test rejects in 99 % of the runs."""
    limit = chi2_limit(ALARM, bins)
    low, high = 0.0, 40.0 * bins
    for _ in range(30):
        middle = 0.5 * (low + high)
        found = noncentral_tail(limit, bins, middle) > 0.99
        low, high = (low, middle) if found else (middle, high)
    return high


def _judged(
    subject: Subject, points: Array, tests: list[Sampled], first: list[Sampled], effort: Effort
) -> list[Finding]:
    trusted = TRUSTED_FLOAT32 if subject.float32 else TRUSTED
    findings = []

    def finding(what: str, row: int, measured: float, verdict: str, text: str) -> Finding:
        if verdict == FAIL:
            text = _faults(subject, points[row : row + 1]) or tests[row].faults() or text
        parameters, wo = viewer(subject, points[row : row + 1])
        case = (parameters[0], wo[0], wo[0])
        replay = subject.recheck("sampling", case)
        return Finding(what, measured, verdict, text, subject.tag(), replay, case)

    # The density and its samples
    bad = [row for row, t in enumerate(tests) if not t.probability >= ALARM]
    row = bad[0] if bad else int(np.argmin([t.probability for t in tests]))
    weakest = max(t.power for t in tests)
    text = (
        f"smallest of {len(tests)} probabilities, after a look at {effort.screened} settings; a density "
        f"off by {100 * min(t.power for t in tests):.2g} to {100 * weakest:.2g} % is found in 99 % of runs"
    )
    if bad:
        text = (
            f"the samples do not follow the density: chi-square {first[row].chi2:.4g} in "
            f"{first[row].bins} bins, and {tests[row].chi2:.4g} with other random numbers"
        )
    verdict = FAIL if bad else PASS
    findings.append(finding("chi-square", row, tests[row].probability, verdict, text))

    # Its integral
    off = [t.density_off() for t in tests]
    row = _worst(off)
    verdict = PASS if off[row] <= trusted else FAIL
    t = tests[row]
    text = f"integral {t.integral:.6g}, {t.kept:.6g} of the samples have a direction"
    findings.append(finding("density off 1 - wasted", row, abs(t.integral - t.kept), verdict, text))

    # The mean weight
    missed = [t.mean_off() for t in tests]
    row = _worst(missed)
    blurred = [t.blurred() for t in tests]
    verdict = PASS if missed[row] <= trusted else FAIL
    hardly = ""
    if verdict == PASS and max(blurred) > BLURRED:
        row = _worst(blurred)
        weights = f"; weights of up to {tests[row].largest:.2g}"
        if _unbounded(subject):
            verdict, hardly = KNOWN, f"{weights}, as the albedo is documented to have no bound"
        else:
            verdict, hardly = UNSURE, f"{weights}: some of the light is hardly ever sampled"
    t = tests[row]
    text = f"mean {t.mean:.6g} ± {t.mean_error:.2g}, albedo {t.albedo:.6g}{hardly}"
    findings.append(finding("mean weight off albedo", row, missed[row], verdict, text))

    # How good it is
    row = _worst([t.variance / max(t.albedo, 1e-9) ** 2 for t in tests])
    t = tests[row]
    text = (
        f"variance of weights over albedo², {t.cosine_variance / max(t.albedo, 1e-9) ** 2:.3g} with "
        f"cosine sampling; largest weight {max(s.largest for s in tests):.3g}"
    )
    findings.append(finding("variance", row, t.variance / max(t.albedo, 1e-9) ** 2, NOTE, text))
    return findings


def _unbounded(subject: Subject) -> bool:
    """Whether the albedo is documented to have no bound: no weights with such a mean have one."""
    documented = subject.size("energy")
    return documented is not None and math.isinf(documented.size)


def _reported(
    subject: Subject, points: Array, tests: list[Sampled], looked: Screened
) -> list[Finding]:
    """The density that a sampler reports, at the settings that were tested and all that were looked at."""
    different = np.concatenate([looked.different, [t.different for t in tests]])
    below = np.concatenate([looked.below, [t.below for t in tests]])
    points = np.concatenate([looked.points, points])

    def finding(
        what: str, row: int, measured: float, verdict: str, text: str, u: Array | None = None
    ) -> Finding:
        if verdict == FAIL:
            text = _faults(subject, points[row : row + 1]) or text
        parameters, wo = viewer(subject, points[row : row + 1])
        case = (parameters[0], wo[0], wo[0])
        # A sample that is known is shown itself
        replay = subject.recheck("sampling", case) if u is None else subject.replay(*case, u=u)
        return Finding(what, measured, verdict, text, subject.tag(), replay, case)

    row = _worst(list(different))
    same = SAME_FLOAT32 if subject.float32 else SAME
    verdict = PASS if different[row] <= same else FAIL
    text = f"largest relative difference between sample's density and pdf, at most {same:g}"
    few = row < len(looked.points)  # those samples are known one by one
    u = even(SCREEN_SAMPLES)[int(looked.which[row])] if few else None
    findings = [finding("reported density", row, float(different[row]), verdict, text, u)]
    row = int(np.argmax(below))
    if below[row]:
        text = "samples below the horizon have a density above 0"
        findings.append(finding("below the horizon", row, float(below[row]), FAIL, text))
    return findings


def _faults(subject: Subject, point: Array) -> str:
    """What is no number at a place: of samples, their densities, and values there and anywhere."""
    parameters, wo = viewer(subject, point)
    u = even(PROBES)
    index = np.zeros(PROBES, np.uint32)
    wi, reported = draw(subject, parameters, index, wo[index], u)
    sound = np.isfinite(wi).all(axis=1)
    around = directions(u[:, 0], 2 * np.pi * u[:, 1])
    both = np.concatenate([around, np.where(sound[:, None], wi, wo)])
    index = np.tile(index, 2)
    f, pdf = evaluate(subject, parameters, index, both, wo[index])
    named = ("sampled wi", wi), ("the density that sample reports", reported), ("pdf", pdf)
    return said(*named, ("eval", f))


def _worst(values: list[float]) -> int:
    """The row of the largest value; what is not a number is larger."""
    return int(np.argmax(np.where(np.isnan(values), np.inf, values)))


def waste(subject: Subject, points: Array, count: int) -> Array:
    """Part of the samples without a direction above the horizon, (points,)."""
    parameters, wo = viewer(subject, points)
    index = repeated(len(points), count)
    u = np.tile(even(count), (len(points), 1))
    wi, pdf = draw(subject, parameters, index, wo[index], u)
    lost = ~((pdf > 0) & (wi[:, 2] > 0))
    return np.asarray(lost.reshape(len(points), count).mean(axis=1))


def _wasted(subject: Subject, effort: Effort) -> Finding:
    points, _ = maximise(
        lambda p: waste(subject, p, FEW),
        dimensions(subject),
        population=2 * effort.albedos,
        rounds=effort.rounds,
        seed=effort.beginning(42),
        starts=starts(subject)[: effort.albedos // 2],
        special=special_parts(subject),
        bands=len(subject.parameters),
    )
    points, _ = maximise(
        lambda p: waste(subject, p, MORE),
        dimensions(subject),
        population=4 * effort.confirmed,
        rounds=effort.rounds,
        seed=effort.beginning(45),
        starts=spread_out(points, 2 * effort.confirmed),
        special=special_parts(subject),
        bands=len(subject.parameters),
        steps=(0.1, 1e-3),
    )
    worst = points[:1]
    measured = float(waste(subject, worst, MANY)[0])
    parameters, wo = viewer(subject, worst)
    if not subject.claiming:
        verdict, text = NOTE, "samples without a direction"
    else:
        # A few samples in the horizon itself are nothing, and evenly spread ones err by 1e-4
        verdict, text = judge(subject, "wasted", measured, limit=1e-4, error=2e-4)
        if verdict == FAIL:
            text = _faults(subject, worst) or text
    case = (parameters[0], wo[0], wo[0])
    replay = subject.recheck("sampling", case)
    return Finding("wasted samples", measured, verdict, text, subject.tag(), replay, case)


def unreached(subject: Subject, points: Array) -> Array:
    """Albedo in directions that the sampler never draws, (points,)."""
    parameters, wo = viewer(subject, points)
    cut = hemisphere.partition(subject, parameters, wo)
    result = hemisphere.integrate(subject, parameters, wo, cut, INTEGRALS, CUTS)
    return np.asarray(result.total[:, UNREACHED])


def _unreached(subject: Subject, looked: Screened, effort: Effort) -> Finding:
    trusted = TRUSTED_FLOAT32 if subject.float32 else TRUSTED
    points, found = looked.points, looked.unreached
    if not found.max() <= trusted:  # there is something to search for
        count = max(4 * effort.confirmed, LOOKED_AT)
        points, found = maximise(
            lambda p: screen(subject, p).unreached,
            dimensions(subject),
            population=count,
            rounds=8,
            seed=effort.beginning(44),
            starts=points[np.argsort(-found)[: count // 2]],
        )
    best = points[_worst(list(found))][None]
    # The rule has seen values with a density alone, wherever it looked
    measured = float(unreached(subject, best)[0]) if found.max() != 0 else 0.0
    verdict, text = judge(subject, "unreached", measured, limit=trusted, error=trusted)
    if verdict == FAIL:
        text = _faults(subject, best) or text
    parameters, wo = viewer(subject, best)
    case = (parameters[0], wo[0], wo[0])
    replay = subject.recheck("sampling", case)
    return Finding("albedo never sampled", measured, verdict, text, subject.tag(), replay, case)
