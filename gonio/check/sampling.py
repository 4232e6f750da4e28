"""Sampling: the density integrates to one, samples follow it, weights average to the albedo.

Cells are cut by a first set of samples so that each holds about the same number; a second set is counted in
them and compared with the adaptive integral of the density over each, by Pearson's chi-square test.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from gonio.check import hemisphere
from gonio.check.energy import dimensions, starts, viewer
from gonio.check.hemisphere import CELLS, COSINE_SECOND, PDF, SECOND, UNREACHED
from gonio.check.report import FAIL, NOTE, PASS, Effort, Finding, Report, judge
from gonio.check.search import maximise
from gonio.check.statistics import chi2_tail, power
from gonio.check.subject import (
    Array,
    Subject,
    draw,
    even,
    number_type,
    repeated,
    stored,
    vectors,
)

# Probability of a false alarm of one test. A test that fails is repeated with other random numbers, and
# only a second failure counts.
ALARM = 1e-4

# The error of a density that the test has to find.
TO_FIND = 0.005

# Cells in which fewer samples are expected than this are counted together, as Pearson's test wants it.
EXPECTED = 25.0

# Errors of the adaptive integrals, doubled; Mitsuba's plug-ins compute in float32.
TRUSTED, TRUSTED_FLOAT32 = 2e-4, 2e-3

# How often cells are cut, and the tolerance of the integrals; an error of 1e-5 is a tenth of the standard
# error of the counts in a cell.
CUTS, INTEGRALS = 10, 2e-5

# The same where something seems to be wrong: a lobe of width 1e-4 off the mirror direction needs it.
CAREFULLY = 1e-8

# The reported density is that of `pdf`, but for roundings of wi in between.
SAME, SAME_FLOAT32 = 1e-6, 2e-2

# Samples wasted in the search, and those that confirm the worst.
FEW, MANY = 256, 1 << 17

# Standard errors that a mean may be off.
SIGMAS = 5.0

# Samples in one kernel call, which bounds the memory.
BATCH = 1 << 22


def check(subject: Subject, effort: Effort) -> Report:
    """Density, samples, weights and waste."""
    start = time.perf_counter()
    count = effort.tests if not subject.tag() else max(effort.tests // 3, 1)
    points = _points(subject, count)
    findings = [_wasted(subject, effort), _unreached(subject, effort)]
    first = [_test(subject, point[None], effort.samples, seed) for seed, point in enumerate(points)]
    trusted = TRUSTED_FLOAT32 if subject.float32 else TRUSTED
    tests = [
        _test(subject, points[row : row + 1], effort.samples, 500 + row, careful=True)
        if test.suspicious(trusted)
        else test
        for row, test in enumerate(first)
    ]
    findings += _judged(subject, points, tests, first, effort)
    return Report("sampling", subject.name, tuple(findings), time.perf_counter() - start)


def _points(subject: Subject, count: int) -> Array:
    """The default parameters at two angles, then random ones over the whole range."""
    rng = np.random.default_rng(41)
    points = rng.random((count, dimensions(subject)))
    at_end = rng.random(points.shape) < 0.15
    points = np.where(at_end, rng.integers(0, 2, points.shape), points)
    extra = dimensions(subject) - len(subject.columns)
    for row, angle in enumerate((0.4, 0.2)[:count]):
        points[row] = np.append(subject.default(), np.full(extra, angle))
    return points


@dataclass(frozen=True)
class Sampled:
    """What the samples of one point have shown."""

    chi2: float
    bins: int
    probability: float
    """Of a larger chi-square."""
    integral: float
    """Of the density."""
    kept: float
    """Part of the samples that have a direction."""
    kept_error: float
    mean: float
    """Of the weights, and its standard error."""
    mean_error: float
    albedo: float
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
        return abs(self.integral - self.kept) - SIGMAS * self.kept_error

    def mean_off(self) -> float:
        """Relative difference between the mean weight and the albedo, beyond its standard error."""
        off = abs(self.mean - (self.albedo - self.unreached)) - SIGMAS * self.mean_error
        return max(off, 0.0) / max(self.albedo, 1e-3)

    def suspicious(self, trusted: float) -> bool:
        """Whether it has to be repeated with other random numbers and finer integrals."""
        off = max(self.density_off(), self.mean_off())
        return not (self.probability >= ALARM and off <= trusted)


def _test(
    subject: Subject, point: Array, samples: int, seed: int, *, careful: bool = False
) -> Sampled:
    places, wo = viewer(subject, point)
    cut = hemisphere.partition(subject, places, wo)
    tolerance, cuts = (CAREFULLY, hemisphere.LEVELS) if careful else (INTEGRALS, CUTS)
    integrals = hemisphere.integrate(subject, places, wo, cut, tolerance, cuts)
    counts = np.zeros(CELLS + 1)
    total = squares = 0.0
    largest, different, below = 0.0, 0.0, 0
    rng = np.random.default_rng(1000 + seed)
    for first in range(0, samples, BATCH):
        batch = min(BATCH, samples - first)
        cells, weight, off, low = _drawn(subject, places, wo, cut.cuts, rng.random((batch, 2)))
        counts += np.bincount(cells, minlength=CELLS + 1)
        total += float(weight.sum())
        squares += float(np.square(weight).sum())
        largest = max(largest, float(weight.max()))
        different = max(different, float(off.max()))
        below += int(low.sum())
    whole = integrals.total[0]
    expected = samples * integrals.cells[0, :, PDF]
    chi2, bins = _pearson(counts, expected, samples)
    mean = total / samples
    variance = max(squares / samples - mean * mean, 0.0)
    albedo = float(whole[:3].mean())
    kept = 1 - counts[CELLS] / samples
    return Sampled(
        chi2,
        bins,
        chi2_tail(chi2, bins),
        float(whole[PDF]),
        kept,
        float(np.sqrt(max(kept * (1 - kept), 0) / samples)),
        mean,
        float(np.sqrt(variance / samples)),
        albedo,
        max(float(whole[SECOND]) - albedo * albedo, 0.0),
        max(float(whole[COSINE_SECOND]) - albedo * albedo, 0.0),
        largest,
        float(whole[UNREACHED]),
        different,
        below,
    )


def _drawn(
    subject: Subject, places: Array, wo: Array, cuts: Array, u: Array
) -> tuple[NDArray[np.intp], Array, Array, NDArray[np.bool_]]:
    """Cell of every sample (CELLS if it is wasted), weight, error of the reported density, below or not."""
    Float = number_type()
    UInt = dr.uint32_array_t(Float)
    n = len(u)
    Vec = dr.replace_shape_t(Float, (3, -1))
    wo_ = Vec(*(stored(Float, c) for c in wo.T))
    index = dr.zeros(UInt, n)
    model = subject.at(places, index, Float)
    wi, reported = model.sample(wo_, vectors(Float, u))
    wi, reported = Vec(wi), Float(reported)
    good = reported > 0
    pdf = Float(model.pdf(wi, wo_))
    f = Vec(model.eval(wi, wo_))
    a, b = hemisphere.unchart(wo_, wi)
    cell = hemisphere.cell_of(stored(Float, cuts[0]), index, a, b)
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


def _pearson(counts: Array, expected: Array, samples: int) -> tuple[float, int]:
    """Chi-square of counts in cells, and of wasted samples, and its number of bins."""
    missing = max(samples - float(expected.sum()), 0.0)
    expected = np.append(expected, missing)
    few = expected < EXPECTED
    observed = np.append(counts[~few], counts[few].sum())
    wanted = np.append(expected[~few], expected[few].sum())
    if wanted[-1] < EXPECTED and len(wanted) > 1:
        # The cells that hardly get any join the smallest of the others; a crowd in them still shows
        smallest = int(np.argmin(wanted[:-1]))
        observed[smallest] += observed[-1]
        wanted[smallest] += wanted[-1]
        observed, wanted = observed[:-1], wanted[:-1]
    return float(np.sum((observed - wanted) ** 2 / np.maximum(wanted, 1e-300))), len(wanted)


def _judged(
    subject: Subject, points: Array, tests: list[Sampled], first: list[Sampled], effort: Effort
) -> list[Finding]:
    trusted = TRUSTED_FLOAT32 if subject.float32 else TRUSTED
    findings = []

    def finding(what: str, row: int, measured: float, verdict: str, text: str) -> Finding:
        places, wo = viewer(subject, points[row : row + 1])
        case = (places[0], wo[0], wo[0])
        return Finding(what, measured, verdict, text, subject.tag(), subject.replay(*case), case)

    # The density and its samples
    bad = [row for row, t in enumerate(tests) if not t.probability >= ALARM]
    row = bad[0] if bad else int(np.argmin([t.probability for t in tests]))
    found = power(effort.samples, CELLS, TO_FIND, ALARM)
    text = (
        f"smallest of {len(tests)} probabilities, {effort.samples:.2g} samples each: a density wrong by "
        f"{100 * TO_FIND:g} % is rejected with {100 * found:.3g} %"
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
    row = int(np.argmax(off))
    verdict = FAIL if off[row] > trusted else PASS
    t = tests[row]
    text = f"integral {t.integral:.6g}, {t.kept:.6g} of the samples have a direction"
    findings.append(finding("density off 1 - wasted", row, abs(t.integral - t.kept), verdict, text))

    # What is reported
    row = int(np.argmax([t.different for t in tests]))
    same = SAME_FLOAT32 if subject.float32 else SAME
    verdict = FAIL if tests[row].different > same else PASS
    text = f"largest relative difference between sample's density and pdf, at most {same:g}"
    findings.append(finding("reported density", row, tests[row].different, verdict, text))
    row = int(np.argmax([t.below for t in tests]))
    if tests[row].below:
        text = "samples below the horizon have a density above 0"
        findings.append(finding("below the horizon", row, float(tests[row].below), FAIL, text))

    # The mean weight
    missed = [t.mean_off() for t in tests]
    row = int(np.argmax(missed))
    t = tests[row]
    verdict = FAIL if missed[row] > trusted else PASS
    text = f"mean {t.mean:.6g} ± {t.mean_error:.2g}, albedo {t.albedo:.6g}"
    findings.append(finding("mean weight off albedo", row, missed[row], verdict, text))

    # How good it is
    row = int(np.argmax([t.variance / max(t.albedo, 1e-9) ** 2 for t in tests]))
    t = tests[row]
    text = (
        f"variance of weights over albedo², {t.cosine_variance / max(t.albedo, 1e-9) ** 2:.3g} with "
        f"cosine sampling; largest weight {max(s.largest for s in tests):.3g}"
    )
    findings.append(finding("variance", row, t.variance / max(t.albedo, 1e-9) ** 2, NOTE, text))
    return findings


def waste(subject: Subject, points: Array, count: int) -> Array:
    """Part of the samples without a direction above the horizon, (points,)."""
    places, wo = viewer(subject, points)
    index = repeated(len(points), count)
    u = np.tile(even(count), (len(points), 1))
    wi, pdf = draw(subject, places, index, wo[index], u)
    lost = ~((pdf > 0) & (wi[:, 2] > 0))
    return np.asarray(lost.reshape(len(points), count).mean(axis=1))


def _wasted(subject: Subject, effort: Effort) -> Finding:
    points, _ = maximise(
        lambda p: waste(subject, p, FEW),
        dimensions(subject),
        population=effort.albedos,
        rounds=effort.rounds,
        seed=42,
        starts=starts(subject),
    )
    found = waste(subject, points[:4], MANY)
    row = int(np.argmax(found))
    measured = float(found[row])
    places, wo = viewer(subject, points[row : row + 1])
    if subject.float32:
        verdict, text = NOTE, "samples without a direction"
    else:
        # A few samples in the horizon itself are nothing
        verdict, text = judge(subject, "wasted", measured, limit=1e-4)
    case = (places[0], wo[0], wo[0])
    return Finding(
        "wasted samples", measured, verdict, text, subject.tag(), subject.replay(*case), case
    )


def unreached(subject: Subject, points: Array, tolerance: float, levels: int) -> Array:
    """Albedo in directions that the sampler never draws, (points,)."""
    places, wo = viewer(subject, points)
    cut = hemisphere.partition(subject, places, wo)
    result = hemisphere.integrate(subject, places, wo, cut, tolerance, levels)
    return np.asarray(result.total[:, UNREACHED])


def _unreached(subject: Subject, effort: Effort) -> Finding:
    trusted = TRUSTED_FLOAT32 if subject.float32 else TRUSTED
    rng = np.random.default_rng(43)
    count = 2 * effort.confirmed
    points = np.concatenate([_points(subject, 4), rng.random((count - 4, dimensions(subject)))])
    found = unreached(subject, points, 1e-2, 1)
    if found.max() > trusted:  # there is something to search for
        points, found = maximise(
            lambda p: unreached(subject, p, 1e-2, 1),
            dimensions(subject),
            population=count,
            rounds=8,
            seed=44,
            starts=points[np.argsort(-found)[: count // 2]],
        )
    best = points[int(np.argmax(found))][None]
    measured = float(unreached(subject, best, INTEGRALS, CUTS)[0])
    verdict, text = judge(subject, "unreached", measured, limit=trusted)
    places, wo = viewer(subject, best)
    case = (places[0], wo[0], wo[0])
    return Finding(
        "albedo never sampled", measured, verdict, text, subject.tag(), subject.replay(*case), case
    )
